// Trajectories on disk: HDF5 with an XDMF sidecar.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bsi/geometry_image.h"
#include "sim/base/bill.h"
#include "sim/base/file_error.h"
#include "sim/base/vectors.h"

namespace weft::sim {

// A body as the trajectory knows it. All patches of a body have the same size. Names are unique,
// not empty, and contain no '/'.
struct TrajectoryBody {
  std::string name;
  bsi::Atlas atlas;
  bool moves = true;  // false: positions are written once, not per frame
  bool is_obstacle = false;
  double thickness = 0;  // m
};

// The end of a run: how it came and what the run cost.
struct RunEnd {
  std::string status;  // "done", "failed" or "interrupted"
  std::string reason;  // why it failed or was stopped
  Bill bill;           // up to the moment it is written
};

// Layout (format version 1; docs/trajectory.md has the whole reference). Only the first
// N = len(/time) entries of every per-frame dataset are complete frames: a killed run may leave
// more entries elsewhere.
//   /                        attributes: format = "weft-trajectory", version, weft_version, title,
//                            compute
//   /case                    string: the resolved case (TOML); a dataset, since HDF5 limits small
//                            attributes to 64 KiB
//   /time[N]                 float64, s; extended last: the commit mark
//   /body/NAME               attributes: moves, obstacle, thickness_m, wrap_u, wrap_v (one integer,
//                            or one a patch)
//   /body/NAME/position      float32, m: [N, rows, cols, 3], or [N, patches, rows, cols, 3] for
//                            more than one patch; without N where the body does not move
//   /body/NAME/velocity      float32, m/s, the same shape: on request, moving bodies only
//   /body/NAME/particle      int32 [patches, rows, cols]: particle of each texel (sewn bodies only)
//   /body/NAME/triangles     int32 [triangles, 3]: texels, by the rule of bsi::quad_triangles
//   /series/NAME[N]          float64, attribute units: energies, counters, solver statistics
//   /steps/NAME[S]           float64, attribute units: one entry an accepted step, written with the
//                            frame that follows it; the first /series/steps[n] belong to frame n
//   /run                     attributes: how the run ended and what it cost, once it has
//   /frame/F÷16384/F÷128/F/position/NAME   virtual dataset [texels, 3]: frame F for the sidecar
//                            (and velocity/NAME)
class TrajectoryWriter {
 public:
  struct Series {
    std::string name;
    std::string units;
  };
  struct Options {
    std::string title = {};
    std::string case_text = {};
    std::string compute = {};  // what the contact search runs on, and why
    bool velocity = false;
    bool force = false;  // overwrite
    std::vector<Series> step_series = {};
    // Frames wait in memory until this wall time has passed since the last commit, s, or until they
    // take 64 MiB.
    double commit_interval = 0;
  };
  // Creates `path` (under a temporary name, renamed once complete and flushed) and its sidecar;
  // throws FileError when one of them exists without `force`, when the writer of what is
  // there lives, with `force` too, or when one cannot be written. The file is locked while the
  // writer lives (file_lock.h). `initial_positions` are by particle, one list a body; only bodies
  // that do not move need one.
  TrajectoryWriter(const std::string& path, std::vector<TrajectoryBody> bodies,
                   std::vector<Series> series, Options options,
                   const std::vector<std::span<const Vec3>>& initial_positions);
  ~TrajectoryWriter();
  // Throws FileError for a path that the constructor would refuse because something is there:
  // for whoever has much to do before a writer is made.
  static void refuse_existing(const std::string& path, bool force);
  TrajectoryWriter(const TrajectoryWriter&) = delete;
  TrajectoryWriter& operator=(const TrajectoryWriter&) = delete;

  // Appends a frame, and commits if `commit_interval` has passed. Lists are by body (velocities
  // empty unless asked for; entries of bodies that do not move are not read) and by series;
  // `step_rows` holds the steps since the last frame, each as one value a step series. Throws
  // FileError, after which the frames committed before stand and no other can be written.
  // O(texels), no fsync.
  void write_frame(double time, const std::vector<std::span<const Vec3>>& positions,
                   const std::vector<std::span<const Vec3>>& velocities,
                   std::span<const double> series, std::span<const double> step_rows = {});
  // Writes the frames that wait: afterwards they can be read whatever becomes of this process, and
  // the sidecar PATH with .xdmf lists them. A process killed within this call leaves all of them
  // out or all of them in. Throws as write_frame. The destructor commits too, in silence.
  void commit();
  // Commits, and writes how the run ended: no frame follows. Throws as write_frame.
  void finish(const RunEnd& end);
  // True where frames wait and the interval will have passed in `pause` seconds: they should be
  // committed before anything that takes so long.
  bool is_due(double pause) const;
  // Counts frames that are committed and frames that wait.
  int frames() const;
  // Throws FileError unless the path still names the file of this writer, which someone may
  // have moved, removed or replaced.
  void check_in_place() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

// Opens a trajectory, also one whose run was killed or goes on: frames() counts the frames that
// were complete when it was opened. Frames and bodies out of range are programmer's errors; what
// the file lacks or has wrong is a FileError. One thread at a time (so is HDF5).
class TrajectoryReader {
 public:
  explicit TrajectoryReader(const std::string& path);
  ~TrajectoryReader();
  TrajectoryReader(const TrajectoryReader&) = delete;
  TrajectoryReader& operator=(const TrajectoryReader&) = delete;
  int frames() const;
  double time(int frame) const;
  std::string title() const;
  std::string weft_version() const;  // that wrote it
  std::string case_text() const;
  // Returns nothing where the run goes on or was killed, and for files of earlier versions.
  std::optional<RunEnd> end() const;
  // True for files of versions that say how their runs ended.
  bool says_its_end() const;
  const std::vector<TrajectoryBody>& bodies() const;
  // Positions by particle, m.
  std::vector<Vec3> positions(int body, int frame) const;
  // Velocities by particle, m/s; empty where velocities were not recorded.
  std::vector<Vec3> velocities(int body, int frame) const;
  std::vector<TrajectoryWriter::Series> series() const;
  // Returns one value per frame.
  std::vector<double> series_values(const std::string& name) const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace weft::sim
