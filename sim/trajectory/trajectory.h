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

// Values beside the positions: one number or vector per texel and frame.
struct TrajectoryField {
  std::string name;  // of the dataset
  std::string units;
  std::string channel;  // sim/case/channels.h
  int components = 3;   // 1: a number
  bool operator==(const TrajectoryField&) const = default;
};

// Values by frame that belong to no texel: one number or vector per frame.
struct TrajectoryRecord {
  std::string path;  // of the dataset, such as "reactions/cloth/pin_1/force"
  std::string units;
  std::string channel;
  int components = 1;
  bool operator==(const TrajectoryRecord&) const = default;
};

// A body as the trajectory knows it. All patches of a body have the same size. Names are unique,
// not empty, and contain no '/'.
struct TrajectoryBody {
  std::string name;
  bsi::Atlas atlas;
  bool moves = true;  // false: positions are written once, not per frame
  bool is_obstacle = false;
  double thickness = 0;                      // m
  int spline_degree = 0;  // of a shell, whose image has points of its surface; 0: no shell
  std::vector<TrajectoryField> fields = {};  // only of bodies that move
  // The rows and columns of the body's own images that the atlas shows, in increasing order; empty:
  // all.
  std::vector<int> part_rows = {}, part_cols = {};
  bool is_part() const { return !part_rows.empty(); }
};

// The values of one frame beside the positions and series.
struct FrameChannels {
  // By body and field: `components` numbers per particle.
  std::vector<std::vector<std::span<const double>>> fields;
  // Values of all records, one after the other.
  std::span<const double> records;
};

// The end of a run: its status and its cost.
struct RunEnd {
  std::string status;  // "done", "failed" or "interrupted"
  std::string reason;  // why it failed or was stopped
  Bill bill;           // up to the moment of writing
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
//                            or one per patch); of a shell also spline_degree
//   /body/NAME/position      float32, m: [N, rows, cols, 3], or [N, patches, rows, cols, 3] for
//                            more than one patch; without N if the body does not move
//   /body/NAME/FIELD         float32, on request: the shape of the positions, without the last
//                            axis for numbers; attributes units and channel
//   /CHANNEL/.../NAME        float64, on request: [N] or [N, 3]; attributes units and channel
//   /body/NAME/particle      int32 [patches, rows, cols]: particle of each texel (sewn bodies only)
//   /body/NAME/triangles     int32 [triangles, 3]: texels, by the rule of bsi::quad_triangles
//   /series/NAME[N]          float64, attribute units: energies, counters, solver statistics
//   /steps/NAME[S]           float64, attribute units: one entry per accepted step, written
//                            with the frame that follows it; the first /series/steps[n] precede
//                            frame n
//   /run                     attributes, once the run has ended: how it ended and what it cost
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
    std::string compute = {};  // device of the contact search, and the reason for it
    bool force = false;        // overwrite
    std::vector<Series> step_series = {};
    std::vector<TrajectoryRecord> records = {};
    Precision precision = Precision::float32;     // of positions
    Compression compression = Compression::none;  // of frames: positions and fields
    double compression_error = 1e-6;  // m, > 0: of coordinates with Compression::bounded, beyond
                                      // the rounding to their precision
    // Frames wait in memory until this wall time (s) has passed since the last commit, or until
    // they take 64 MiB.
    double commit_interval = 0;
  };
  // Creates `path`, under a temporary name that is changed once the file is complete and flushed,
  // and its sidecar. The file is locked while the writer lives (file_lock.h). `initial_positions`
  // holds one list per body, by particle; only bodies that do not move need one. Throws FileError
  // if one of the files cannot be written, or exists without `force`; even with `force` if the
  // writer of the old file lives.
  TrajectoryWriter(const std::string& path, std::vector<TrajectoryBody> bodies,
                   std::vector<Series> series, Options options,
                   const std::vector<std::span<const Vec3>>& initial_positions);
  ~TrajectoryWriter();
  // Throws FileError if the constructor would refuse the path because of an existing file. Callers
  // can ask before they start long work.
  static void refuse_existing(const std::string& path, bool force);
  TrajectoryWriter(const TrajectoryWriter&) = delete;
  TrajectoryWriter& operator=(const TrajectoryWriter&) = delete;

  // Appends a frame, and commits if `commit_interval` has passed. Positions and fields are by body;
  // entries of bodies that do not move are not read. `series` holds one value per series.
  // `step_rows` holds the steps since the last frame, each as one value per step series. Throws
  // FileError; frames committed before it remain, and no other can be written. O(texels), no fsync.
  void write_frame(double time, const std::vector<std::span<const Vec3>>& positions,
                   const FrameChannels& channels, std::span<const double> series,
                   std::span<const double> step_rows = {});
  // Writes the frames that wait, and lists them in the sidecar PATH with .xdmf. Afterwards they can
  // be read even if this process dies. A process that is killed within this call leaves either none
  // of them or all. Throws as write_frame. The destructor commits too, and swallows errors.
  void commit();
  // Commits, and writes how the run ended. No frame may follow. Throws as write_frame.
  void finish(const RunEnd& end);
  // True if frames wait and the commit interval will have passed in `pause` seconds. They should be
  // committed before anything that takes so long.
  bool is_due(double pause) const;
  // Number of frames, both committed and waiting.
  int frames() const;
  // Throws FileError unless the path still names the file of this writer: someone may have moved,
  // removed or replaced it.
  void check_in_place() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

// Reads a trajectory, also one whose run was killed or still goes on: frames() counts the frames
// that were complete when it was opened. Frames and bodies out of range are programming errors; a
// fault of the file throws FileError. Like HDF5, for one thread at a time.
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
  // Empty while the run goes on, if it was killed, and for files of earlier versions.
  std::optional<RunEnd> end() const;
  // True if the file's version records how runs end.
  bool says_its_end() const;
  const std::vector<TrajectoryBody>& bodies() const;
  // Positions by particle, m.
  std::vector<Vec3> positions(int body, int frame) const;
  // Velocities by particle, m/s; empty if they were not recorded.
  std::vector<Vec3> velocities(int body, int frame) const;
  // Values of a field of the body by particle, `components` numbers each. Throws FileError for a
  // field that the body does not have.
  std::vector<double> field_values(int body, const std::string& field, int frame) const;
  // Records, by channel in the order of the file.
  const std::vector<TrajectoryRecord>& records() const;
  // Values of a record, `components` numbers per frame. Throws FileError for an unknown path.
  std::vector<double> record_values(const std::string& path) const;
  std::vector<TrajectoryWriter::Series> series() const;
  // Returns one value per frame.
  std::vector<double> series_values(const std::string& name) const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace weft::sim
