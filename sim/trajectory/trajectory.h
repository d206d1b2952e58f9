// Trajectories on disk: HDF5 files, each with an XDMF sidecar for ParaView.
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

// Two particles that a seam holds together, by body in the order of the trajectory.
struct SewnParticles {
  int body = 0, particle = 0;
  int other_body = 0, other_particle = 0;
};

// A field of a body: one number or vector per texel and frame, besides the positions.
struct TrajectoryField {
  std::string name;  // name of the dataset
  std::string units;
  std::string channel;  // name of the channel (sim/case/channels.h)
  int components = 3;   // 1: a number, 3: a vector
  bool operator==(const TrajectoryField&) const = default;
};

// A record: one number or vector per frame, independent of texels.
struct TrajectoryRecord {
  std::string path;  // path of the dataset, for example "reactions/cloth/pin_1/force"
  std::string units;
  std::string channel;  // name of the channel (sim/case/channels.h)
  int components = 1;   // 1: a number, 3: a vector
  bool operator==(const TrajectoryRecord&) const = default;
};

// A body as the trajectory stores it. All patches of a body have the same size. The names of bodies
// are unique, not empty, and contain no '/'.
struct TrajectoryBody {
  std::string name;
  bsi::Atlas atlas;
  bool moves = true;  // if false, positions are written once instead of per frame
  bool is_obstacle = false;
  double thickness = 0;                      // m
  int spline_degree = 0;                     // degree of a shell's splines; 0 for other bodies
  std::vector<TrajectoryField> fields = {};  // empty if the body does not move
  // Rows and columns that the atlas shows of the whole image, in increasing order. Empty: all rows
  // and columns.
  std::vector<int> part_rows = {}, part_cols = {};
  bool is_part() const { return !part_rows.empty(); }
  // Radius (m) of each sphere of a group of particles, whose atlas has no quads (Atlas::of_points).
  // Empty for surfaces.
  std::vector<double> radii = {};
  bool is_of_spheres() const { return !radii.empty(); }
};

// The values of the channels in one frame.
struct FrameChannels {
  // Values by body and field, with TrajectoryField::components numbers per particle.
  std::vector<std::vector<std::span<const double>>> fields;
  // Values of all records, one record after the other.
  std::span<const double> records;
};

// The end of a run: its status and its cost.
struct RunEnd {
  std::string status;  // "done", "failed" or "interrupted"
  std::string reason;  // reason of a failure or a stop, in words; else empty
  Bill bill;           // costs until the end is written
};

// Writes a trajectory. The file has the following layout (format version 1; full reference:
// docs/trajectory.md). Only the first N = len(/time) entries of a per-frame dataset are complete
// frames: a killed run may leave more entries elsewhere.
//   /                        attributes: format = "weft-trajectory", version, weft_version, title,
//                            compute, case_folder, time_units
//   /case                    string: the resolved case (TOML); a dataset, since HDF5 limits small
//                            attributes to 64 KiB
//   /time[N]                 float64, in time_units; extended last: the commit mark
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
//   /particles/NAME          a group of spheres; attribute moves
//   /particles/NAME/position float32 or float64, m: [N, spheres, 3], centres
//   /particles/NAME/radius   float64 [spheres], m
//   /particles/NAME/velocity float32 [N, spheres, 3], on request
//   /sewn                    int32 [pairs, 4]: body, particle, body, particle that seams hold
//                            together (only with seams)
//   /series/NAME[N]          float64, attribute units: energies, counters, solver statistics
//   /steps/NAME[S]           float64, attribute units: one entry per accepted step, written
//                            with the frame that follows it; the first /series/steps[n] entries
//                            precede frame n
//   /run                     attributes, once the run has ended: status, reason and costs
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
    std::string compute = {};  // device of the contact search and its reason
    // Folder of the case, relative to the folder of the trajectory. Empty: not recorded.
    std::string case_folder = {};
    std::string time_units = "s";  // of /time; "1" if frames are numbers of modes
    bool force = false;            // if true, overwrites an existing file
    std::vector<Series> step_series = {};
    std::vector<TrajectoryRecord> records = {};
    std::vector<SewnParticles> sewn = {};
    Precision precision = Precision::float32;     // precision of positions
    Compression compression = Compression::none;  // compression of positions and fields
    // Largest change of a coordinate by Compression::bounded (m, > 0), in addition to the rounding
    // to `precision`.
    double compression_error = 1e-6;
    // If true, the file keeps its temporary name until publish().
    bool publish_later = false;
    // Wall time between commits (s). write_frame() commits the waiting frames if this time has
    // passed since the last commit, or if they occupy 64 MiB.
    double commit_interval = 0;
  };
  // Creates the file `path` and its sidecar. The file has a temporary name until its header is
  // complete and flushed (or until publish(), see Options::publish_later). It is locked while the
  // writer lives (file_lock.h). `initial_positions` (m) holds one list per body, by particle; lists
  // of bodies that move are not read and may be empty. Throws FileError if a file cannot be
  // written, or if it exists and `force` is false. Even with `force`, throws it if another writer
  // holds the lock of the old file.
  TrajectoryWriter(const std::string& path, std::vector<TrajectoryBody> bodies,
                   std::vector<Series> series, Options options,
                   const std::vector<std::span<const Vec3>>& initial_positions);
  ~TrajectoryWriter();
  // Throws FileError if an existing file or the name of the file would make the constructor throw.
  // Call it before long work.
  static void refuse_existing(const std::string& path, bool force);
  // Throws FileError if the path of the sidecar is that of a file which no version of Weft wrote.
  // A run that goes on calls it, because it replaces the sidecar without `force`.
  static void refuse_foreign_sidecar(const std::string& path);
  TrajectoryWriter(const TrajectoryWriter&) = delete;
  TrajectoryWriter& operator=(const TrajectoryWriter&) = delete;

  // Appends a frame at `time` (s), and commits if a commit is due (Options::commit_interval).
  // Positions (m) and fields are by body; entries of bodies that do not move are not read. `series`
  // holds one value per series. `step_rows` has one row per step since the last frame, with one
  // value per step series. Throws FileError; committed frames then remain, and no other frame can
  // be written. O(texels); does not call fsync().
  void write_frame(double time, const std::vector<std::span<const Vec3>>& positions,
                   const FrameChannels& channels, std::span<const double> series,
                   std::span<const double> step_rows = {});
  // Writes the waiting frames, and lists them in the sidecar, whose path is `path` with the
  // extension .xdmf. Afterwards they can be read even if this process dies. If the process is
  // killed within this call, either all or none of these frames can be read. Throws FileError like
  // write_frame(). The destructor commits too, but ignores errors.
  void commit();
  // Commits, and gives the file its name: an old file of that name is replaced at once, by a file
  // with all frames so far. Precondition: Options::publish_later; called once. Throws FileError
  // like the constructor.
  void publish();
  // Commits, and writes the end of the run. No frame may follow. Throws FileError like
  // write_frame().
  void finish(const RunEnd& end);
  // True if waiting frames should be committed before work that takes `pause` seconds: the commit
  // interval will have passed after this work, or the frames occupy 64 MiB.
  bool is_due(double pause) const;
  // Returns the number of frames, both committed and waiting.
  int frames() const;
  // Throws FileError if the path no longer names this writer's file, because the file was moved,
  // removed or replaced.
  void check_in_place() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

// The names, shapes and units of all that a trajectory holds.
struct TrajectoryContents {
  std::vector<TrajectoryBody> bodies;
  std::vector<TrajectoryRecord> records;
  std::vector<TrajectoryWriter::Series> series;       // one value per frame
  std::vector<TrajectoryWriter::Series> step_series;  // one value per step
};

// Reads a trajectory, even if its run was killed or is still going on. Preconditions: indices of
// frames and bodies are in range, and only one thread uses readers at a time, because HDF5 requires
// this. All functions that read the file throw FileError if it is damaged or cannot be read.
class TrajectoryReader {
 public:
  explicit TrajectoryReader(const std::string& path);
  ~TrajectoryReader();
  TrajectoryReader(const TrajectoryReader&) = delete;
  TrajectoryReader& operator=(const TrajectoryReader&) = delete;
  // Returns the number of frames that were complete when the file was opened.
  int frames() const;
  // Returns the time of a frame (time_units()).
  double time(int frame) const;
  std::string title() const;
  std::string time_units() const;    // of time(): "s", or "1" if frames are numbers of modes
  std::string weft_version() const;  // version of Weft that wrote the file
  std::string case_text() const;     // resolved case (TOML)
  // Returns the folder of the case, relative to the folder of the trajectory. Returns an empty text
  // if the file does not name it: files of earlier versions do not.
  std::string case_folder() const;
  // Returns the end of the run, or nothing if the run is going on or was killed. Files of earlier
  // versions have no end either.
  std::optional<RunEnd> end() const;
  // True if the version of Weft that wrote the file records the ends of runs.
  bool says_its_end() const;
  const std::vector<TrajectoryBody>& bodies() const;
  // Returns the positions (m) by particle.
  std::vector<Vec3> positions(int body, int frame) const;
  // Returns the velocities (m/s) by particle; empty if they were not recorded.
  std::vector<Vec3> velocities(int body, int frame) const;
  // Returns the values of a field of the body, TrajectoryField::components numbers per particle.
  // Throws FileError if the body does not have the field.
  std::vector<double> field_values(int body, const std::string& field, int frame) const;
  // Returns the particles that seams hold together. Triangles touch there.
  const std::vector<SewnParticles>& sewn() const;
  // Returns the records, ordered by channel and then as in the file.
  const std::vector<TrajectoryRecord>& records() const;
  // Returns the values of a record, TrajectoryRecord::components numbers per frame. Throws
  // FileError for an unknown path.
  std::vector<double> record_values(const std::string& path) const;
  std::vector<TrajectoryWriter::Series> series() const;
  // Returns the values of a series, one per frame. Throws FileError for an unknown name.
  std::vector<double> series_values(const std::string& name) const;
  // Returns the series of steps; empty if the file has none.
  std::vector<TrajectoryWriter::Series> step_series() const;
  // Returns the values of a series of steps, one per step. All of these series have the same number
  // of values: steps that not all of them had when the file was opened are left out. Throws
  // FileError for an unknown name.
  std::vector<double> step_values(const std::string& name) const;
  TrajectoryContents contents() const;
  // Returns the first `count` values of a series by step (/steps). Throws FileError for an unknown
  // name, or if there are fewer.
  std::vector<double> step_values(const std::string& name, std::int64_t count) const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace weft::sim
