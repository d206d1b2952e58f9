// The numbers that a run records, computed from its state.
#pragma once

#include <string>
#include <vector>

#include "sim/base/bill.h"
#include "sim/channels/recorded_channels.h"
#include "sim/motion/dynamics.h"
#include "sim/simulation/simulation.h"
#include "sim/trajectory/recorded_images.h"
#include "sim/trajectory/trajectory.h"

namespace weft::sim {

// Writes frames (positions, channels, energies, counters, times) and one row per step between them.
class FrameRecorder {
 public:
  // The series `more` follow those that every run has. The cost of frames, without that of their
  // energies, is added to `cost`, which must outlive the recorder. The constructor and add_step()
  // are not counted.
  FrameRecorder(const Simulation& simulation, const std::string& path, bool force, Cost& cost,
                const std::vector<TrajectoryWriter::Series>& more = {});

  // Adds a row about the last step to /steps. It is written with the next frame.
  void add_step(const Simulation& simulation);
  // Adds a frame of the state `y` at `time`, with a value for each series of `more`. Returns the
  // largest stretch in it.
  double add_frame(double time, std::span<const double> y, const IntegratorCounts& counts,
                   std::span<const double> more = {});
  // Commits the frames if a `pause` (s) would make them wait longer than a quarter of a second, the
  // usual time between commits.
  void commit_before_pause(double pause);
  void commit();
  // Commits, and writes how the run ended.
  void finish(const RunEnd& end);
  int frames() const { return writer_.frames(); }
  // Energies of the last frame (J) with the names of their series.
  const std::vector<std::pair<std::string, double>>& energies() const { return energies_; }
  // Throws FileError unless the path still names the recorder's file.
  void check_in_place() const { writer_.check_in_place(); }

 private:
  std::vector<TrajectoryWriter::Series> frame_series(
      const std::vector<TrajectoryWriter::Series>& more) const;
  std::vector<double> frame_values(const StateSummary& summary, double largest_stretch,
                                   const IntegratorCounts& counts) const;

  const Scene& scene_;
  const Simulation& simulation_;
  Dynamics& dynamics_;
  Cost& cost_;
  IntegratorCounts last_counts_;
  std::vector<Vec3> position_, velocity_;
  std::vector<double> step_rows_;
  std::vector<std::pair<std::string, double>> energies_;
  RecordedChannels channels_;
  RecordedImages images_;
  TrajectoryWriter writer_;
};

}  // namespace weft::sim
