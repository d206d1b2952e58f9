// Records a run: computes the values of its frames and steps, and writes them to a trajectory.
#pragma once

#include <string>
#include <vector>

#include "sim/base/bill.h"
#include "sim/base/state_archive.h"
#include "sim/channels/recorded_channels.h"
#include "sim/motion/dynamics.h"
#include "sim/simulation/simulation.h"
#include "sim/trajectory/frame_copy.h"
#include "sim/trajectory/recorded_images.h"
#include "sim/trajectory/trajectory.h"

namespace weft::sim {

// Returns what a FrameRecorder of the simulation would write, without writing it.
TrajectoryContents recorded_contents(const Simulation& simulation,
                                     const std::vector<TrajectoryWriter::Series>& more = {});

// Writes the frames of a run and one row of values per step. A frame has positions, channels,
// energies, counters and phase times.
class FrameRecorder {
 public:
  // Creates the trajectory, which gets the name `path` by publish(). `more` lists series in
  // addition to those of every run. The cost of frames and commits is added to `cost`, which must
  // outlive the recorder. The costs of this constructor, of add_step() and of the energies of
  // frames are not added. Throws FileError.
  FrameRecorder(const Simulation& simulation, const std::string& path, bool force, Cost& cost,
                const std::vector<TrajectoryWriter::Series>& more = {});

  // Copies the first `frames` frames of the file that has the name so far. Must be called before
  // publish(). Throws FileError.
  void copy_earlier(int frames);
  // Gives the file its name. Throws FileError.
  void publish();
  // Writes or reads all data of this object that later frames depend on: a recorder that has read
  // them, and copied the frames so far, goes on as the one that wrote them.
  void transfer(StateArchive& archive);

  // Adds a row about the last step of the simulation. The row is written with the next frame.
  void add_step(const Simulation& simulation);
  // Adds a frame: the state `y` at `time` (s). `more` has one value for each series in the
  // constructor's `more`. Returns the frame's largest stretch (Dynamics::largest_stretch()). Throws
  // FileError.
  double add_frame(double time, std::span<const double> y, const IntegratorCounts& counts,
                   std::span<const double> more = {});
  // Commits the waiting frames if the last commit will be at least a quarter of a second old after
  // a pause of `pause` seconds, or if they occupy 64 MiB. Throws FileError.
  void commit_before_pause(double pause);
  // Writes the waiting frames. Throws FileError.
  void commit();
  // Commits, and writes the end of the run. No frame may follow. Throws FileError.
  void finish(const RunEnd& end);
  int frames() const { return writer_.frames(); }
  // Returns the energies (J) of the last frame, each with the name of its series.
  const std::vector<std::pair<std::string, double>>& energies() const { return energies_; }
  // Throws FileError unless the path still names the recorder's file.
  void check_in_place() const { writer_.check_in_place(); }

 private:
  TrajectoryLayout make_layout(const std::vector<TrajectoryWriter::Series>& more) const;
  std::vector<double> frame_values(const StateSummary& summary, double largest_stretch,
                                   const IntegratorCounts& counts) const;

  std::string path_;
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
  TrajectoryLayout layout_;
  TrajectoryWriter writer_;
};

}  // namespace weft::sim
