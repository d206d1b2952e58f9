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
#include "sim/case/case.h"

namespace weft::sim {

// A field of a body: one number or vector per texel and frame, besides the positions.
struct TrajectoryField {
  std::string name;  // of the dataset
  std::string units;
  std::string channel;  // name of the channel (sim/case/channels.h)
  int components = 3;   // 1: scalar
  bool operator==(const TrajectoryField&) const = default;
};

// Values that belong to no texel: one number or vector per frame.
struct TrajectoryRecord {
  std::string path;  // of the dataset, for example "reactions/cloth/pin_1/force"
  std::string units;
  std::string channel;
  int components = 1;
  bool operator==(const TrajectoryRecord&) const = default;
};

// A body as the trajectory stores it. All patches of a body have the same size. Names are unique
// and not empty, and contain no '/'.
struct TrajectoryBody {
  std::string name;
  bsi::Atlas atlas;
  bool moves = true;  // false: positions are written once, not per frame
  bool is_obstacle = false;
  double thickness = 0;   // m
  int spline_degree = 0;  // of a shell, whose images hold points of its surface. 0: no shell
  std::vector<TrajectoryField> fields = {};  // only for bodies that move
  // Rows and columns of the body's images that the atlas shows, in increasing order. Empty: all.
  std::vector<int> part_rows = {}, part_cols = {};
  bool is_part() const { return !part_rows.empty(); }
};

// The values of one frame besides positions and series.
struct FrameChannels {
  // By body and field: `components` numbers per particle.
  std::vector<std::vector<std::span<const double>>> fields;
  // Values of all records, one record after the other.
  std::span<const double> records;
};

// The end of a run: its status and its cost.
struct RunEnd {
  std::string status;  // "done", "failed" or "interrupted"
  std::string reason;  // why the run failed or was stopped
  Bill bill;           // up to the time of writing
};

// Writes a trajectory. The file has the following layout (format version 1; full reference:
// docs/trajectory.md). Only the first N = len(/time) entries of a per-frame dataset are complete
// frames: a killed run may leave more entries elsewhere.
//   /                        attributes: format = "weft-trajectory", version, weft_version, title,
//                            compute, time_units
//   /case                    string: the resolved case (TOML); a dataset, since HDF5 limits small
//                            attributes to 64 KiB
//   /time[N]                 float64, s; extended last: the commit mark
//   /body/NAME               attributes: moves, obstacle, thickness_m, wrap_u, wrap_v (one integer,
//                            or one per patch); part_rows, part_cols if recorded in part;
//                            spline_degree of a shell
//   /body/NAME/position      float32 or float64, m: [N, rows, cols, 3], or [N, patches, rows, cols,
//                            3] for more than one patch; without N if the body does not move
//   /body/NAME/FIELD         float32, on request: the shape of the positions, without the last
//                            axis for scalars; attributes units and channel
//   /CHANNEL/.../NAME        float64, on request: [N] or [N, 3]; attributes units and channel
//   /body/NAME/particle      int32 [patches, rows, cols]: particle of each texel (sewn bodies only)
//   /body/NAME/triangles     int32 [triangles, 3]: texels, by the rule of bsi::quad_triangles
//   /series/NAME[N]          float64, attribute units: energies, counters, solver statistics
//   /steps/NAME[S]           float64, attribute units: one entry per accepted step, written
//                            with the frame that follows it; the first /series/steps[n] precede
//                            frame n
//   /run                     attributes, once the run has ended: how it ended and what it cost
//   /frame/A/B/F/position/NAME   virtual dataset [texels, 3] for the sidecar: frame F, with
//                            A = F / 16384 and B = F / 128; likewise FIELD/NAME for each field
class TrajectoryWriter {
 public:
  struct Series {
    std::string name;
    std::string units;
  };
  struct Options {
    std::string title = {};
    std::string case_text = {};
    std::string compute = {};  // device of the contact search, and why
    bool force = false;        // overwrites an existing file
    std::vector<Series> step_series = {};
    std::vector<TrajectoryRecord> records = {};
    Precision precision = Precision::float32;     // of positions
    Compression compression = Compression::none;  // of frames: positions and fields
    // Largest change of a coordinate by Compression::bounded (m, > 0). Rounding to `precision`
    // comes on top.
    double compression_error = 1e-6;
    // Frames wait in memory until this wall time (s) has passed since the last commit, or until
    // they occupy 64 MiB.
    double commit_interval = 0;
  };
  // Creates `path` and its sidecar. The file has a temporary name until its header is complete and
  // flushed. It is locked while the writer lives (file_lock.h). `initial_positions` holds one list
  // per body, by particle (m); lists of bodies that move are not read and may be empty. Throws
  // FileError if a file cannot be written, or exists without `force`. Throws it even with `force`
  // if another writer holds the old file.
  TrajectoryWriter(const std::string& path, std::vector<TrajectoryBody> bodies,
                   std::vector<Series> series, Options options,
                   const std::vector<std::span<const Vec3>>& initial_positions);
  ~TrajectoryWriter();
  // Throws FileError if an existing file would make the constructor throw. Call it before long
  // work.
  static void refuse_existing(const std::string& path, bool force);
  TrajectoryWriter(const TrajectoryWriter&) = delete;
  TrajectoryWriter& operator=(const TrajectoryWriter&) = delete;

  // Appends a frame at `time` (s), and commits if `commit_interval` has passed. Positions (m) and
  // fields are by body; entries of bodies that do not move are not read. `series` holds one value
  // per series. `step_rows` holds the steps since the last frame, each as one value per step
  // series. Throws FileError; committed frames then remain, and no other frame can be written.
  // O(texels), no fsync.
  void write_frame(double time, const std::vector<std::span<const Vec3>>& positions,
                   const FrameChannels& channels, std::span<const double> series,
                   std::span<const double> step_rows = {});
  // Writes the waiting frames, and lists them in the sidecar (PATH with .xdmf). Afterwards they can
  // be read even if this process dies. If the process is killed within this call, either all of
  // these frames can be read or none. Throws FileError like write_frame(). The destructor commits
  // too, but ignores errors.
  void commit();
  // Commits, and writes how the run ended. No frame may follow. Throws FileError like
  // write_frame().
  void finish(const RunEnd& end);
  // True if frames should be committed before work that takes `pause` seconds: the commit interval
  // will have passed by then, or the waiting frames occupy 64 MiB.
  bool is_due(double pause) const;
  // Number of frames, both committed and waiting.
  int frames() const;
  // Throws FileError unless the path still names this writer's file, which may have been moved,
  // removed or replaced.
  void check_in_place() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

// Reads a trajectory, even one whose run was killed or is still going on. frames() counts the
// frames that were complete when the file was opened. Precondition: frames and bodies are in range.
// A fault of the file throws FileError. Like HDF5, only one thread may use readers at a time.
class TrajectoryReader {
 public:
  explicit TrajectoryReader(const std::string& path);
  ~TrajectoryReader();
  TrajectoryReader(const TrajectoryReader&) = delete;
  TrajectoryReader& operator=(const TrajectoryReader&) = delete;
  int frames() const;
  double time(int frame) const;
  std::string title() const;
  std::string weft_version() const;  // of the writer
  std::string case_text() const;
  // Empty while the run is going on, if it was killed, and for files of earlier versions.
  std::optional<RunEnd> end() const;
  // True if the file's version records the ends of runs.
  bool says_its_end() const;
  const std::vector<TrajectoryBody>& bodies() const;
  // Returns the positions by particle (m).
  std::vector<Vec3> positions(int body, int frame) const;
  // Returns the velocities by particle (m/s); empty if they were not recorded.
  std::vector<Vec3> velocities(int body, int frame) const;
  // Values of a field of the body by particle, `components` numbers each. Throws FileError if the
  // body does not have the field.
  std::vector<double> field_values(int body, const std::string& field, int frame) const;
  // Records, ordered by channel and then as in the file.
  const std::vector<TrajectoryRecord>& records() const;
  // Values of a record, `components` numbers per frame. Throws FileError for an unknown path.
  std::vector<double> record_values(const std::string& path) const;
  std::vector<TrajectoryWriter::Series> series() const;
  // Returns one value per frame. Throws FileError for an unknown name.
  std::vector<double> series_values(const std::string& name) const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace weft::sim
