// The checkpoint of a recorded run: a file beside its trajectory, from which the run can go on.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "sim/base/bill.h"
#include "sim/base/state_archive.h"
#include "sim/case/case.h"

namespace weft::sim {

// The state of a run at the end of a step, with all that later frames, steps and the report depend
// on.
struct RunCheckpoint {
  std::string case_text;         // motion_text() of the case before time.accuracy has chosen
  TimeCase time;                 // settled options of time integration
  std::string accuracy_choice;   // Case::accuracy_choice
  bool estimates_error = false;  // true if the run measures its error
  bool is_complete = false;      // true if the run has ended as the case says
  double reached = 0;            // simulated time (s)
  std::int64_t steps = 0;        // steps so far
  int frames = 0;                // frames so far
  double last_frame_time = 0;    // time of the last frame (s); 0 without frames
  std::int64_t next_frame = 0;   // FrameTimes index of the next frame
  std::optional<double> smallest_gap;
  double largest_stretch = 0;
  std::vector<std::pair<std::string, double>> energies;  // RunReport::energies
  Bill bill;                                             // costs so far
  std::string simulation;                                // Simulation::checkpoint()
  std::string recorder;                                  // FrameRecorder::transfer()
  std::string monitor;  // ErrorMonitor::checkpoint(); empty without estimates_error

  void transfer(StateArchive& archive);
};

// Returns the path of the checkpoint of a trajectory: its path with the extension .checkpoint.
std::string checkpoint_path(const std::string& trajectory);
// Returns the path of the file that becomes the checkpoint once it is complete.
std::string unfinished_checkpoint_path(const std::string& trajectory);

// Replaces the checkpoint of a trajectory at once: a process that is killed leaves the old or the
// new one. Throws FileError.
void write_checkpoint(const std::string& trajectory, RunCheckpoint checkpoint);
// Returns the checkpoint of a trajectory, or nothing if there is none. Throws FileError if it is
// damaged, was written by another version of Weft, or cannot be accessed.
std::optional<RunCheckpoint> read_checkpoint(const std::string& trajectory);
// Throws FileError if the path of the checkpoint is that of a file which no version of Weft wrote,
// unless `force` is true, or of something else than a file, or if it cannot be accessed or
// its name is too long.
void refuse_foreign_checkpoint(const std::string& trajectory, bool force);
// Removes the checkpoint of a trajectory, if there is one.
void remove_checkpoint(const std::string& trajectory);

// The last checkpoint of a run that goes on. Writing each of them could cost more than the steps
// between them, so it waits until a quarter of a second has passed since the last one was written.
class WaitingCheckpoint {
 public:
  explicit WaitingCheckpoint(std::string trajectory) : trajectory_(std::move(trajectory)) {}

  // Replaces the checkpoint that waits, if there is one.
  void keep(RunCheckpoint checkpoint) { waiting_ = std::move(checkpoint); }
  // True if a checkpoint waits and should be written before work that takes `pause` seconds.
  bool is_due(double pause) const;
  // Writes the checkpoint that waits, if there is one. Its frames must have been committed. Throws
  // FileError.
  void write();
  bool has_written() const { return has_written_; }

 private:
  std::string trajectory_;
  std::optional<RunCheckpoint> waiting_;
  bool has_written_ = false;
  std::chrono::steady_clock::time_point last_write_ = std::chrono::steady_clock::now();
};

}  // namespace weft::sim
