// The numbers that a run records, and how they follow from its state.
#pragma once

#include <string>
#include <vector>

#include "sim/base/bill.h"
#include "sim/motion/dynamics.h"
#include "sim/simulation/simulation.h"
#include "sim/trajectory/trajectory.h"

namespace weft::sim {

// Writes frames (positions, energies, counters, times) and, between them, one row a step.
class FrameRecorder {
 public:
  // `more` series follow those of every run. What frames cost, but for their energies, is added to
  // `cost`, which must outlive the recorder; making it and adding steps is not.
  FrameRecorder(const Scene& scene, Dynamics& dynamics, const std::string& path, bool force,
                Cost& cost, const std::vector<TrajectoryWriter::Series>& more = {});

  // Adds a row of /steps about the last step. It is written with the next frame.
  void add_step(const Simulation& simulation);
  // A frame of the state `y` at `time`, and a value for each of the series `more`. Returns the
  // largest stretch in it.
  double add_frame(double time, std::span<const double> y, const IntegratorCounts& counts,
                   std::span<const double> more = {});
  // Frames are committed about four times a second, and before a `pause` (s) that would be longer.
  void commit_before_pause(double pause);
  void commit();
  // Commits, and writes how the run ended.
  void finish(const RunEnd& end);
  int frames() const { return writer_.frames(); }
  // The energies of the last frame, J, have the names of their series.
  const std::vector<std::pair<std::string, double>>& energies() const { return energies_; }
  // Throws FileError unless the file is still where it was made.
  void check_in_place() const { writer_.check_in_place(); }

 private:
  std::vector<TrajectoryWriter::Series> frame_series(
      const std::vector<TrajectoryWriter::Series>& more) const;
  std::vector<double> frame_values(const Energies& energies, double largest_stretch,
                                   const IntegratorCounts& counts) const;

  const Scene& scene_;
  Dynamics& dynamics_;
  Cost& cost_;
  IntegratorCounts last_counts_;
  std::vector<Vec3> position_, velocity_;
  std::vector<double> step_rows_;
  std::vector<std::pair<std::string, double>> energies_;
  TrajectoryWriter writer_;
};

}  // namespace weft::sim
