// Trajectories on disk: HDF5 with an XDMF sidecar.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "bsi/geometry_image.h"

namespace weft::sim {

using bsi::Vec3;

// A body as the trajectory knows it. All patches of a body have the same size.
struct TrajectoryBody {
  std::string name;
  bsi::Atlas atlas;
  bool moves = true;  // false: positions are written once, not per frame
  bool is_obstacle = false;
  double thickness = 0;  // m
};

// Thrown for what the file system or HDF5 refuses (exit code 4).
class TrajectoryError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Layout (format version 1):
//   /                   attributes: format = "weft-trajectory", version, weft_version, title, case
//   (resolved TOML) /time[T]            s; written last: the number of complete frames
//   /body/NAME/position[T, rows, cols, 3] float32 (m), or [T, patches, rows, cols, 3]; [rows, cols,
//   3] when it
//                       does not move; attributes: units, thickness_m, wrap_u, wrap_v, obstacle
//   /body/NAME/velocity (m/s) on request
//   /body/NAME/particle [patches, rows, cols] int32: particle of each texel (sewn bodies only)
//   /series/NAME[T]     float64, attribute units: energies, counters and solver statistics at each
//   frame
class TrajectoryWriter {
 public:
  struct Series {
    std::string name;
    std::string units;
  };
  struct Options {
    std::string title;
    std::string case_text;
    bool velocity = false;
    bool force = false;  // overwrite
  };
  // Creates `path` (under a temporary name, renamed once complete and flushed); throws
  // TrajectoryError when it exists without `force`, or cannot be written. `initial_positions` are
  // by particle, one list a body.
  TrajectoryWriter(const std::string& path, std::vector<TrajectoryBody> bodies,
                   std::vector<Series> series, Options options,
                   const std::vector<std::span<const Vec3>>& initial_positions);
  ~TrajectoryWriter();
  TrajectoryWriter(const TrajectoryWriter&) = delete;
  TrajectoryWriter& operator=(const TrajectoryWriter&) = delete;

  // Appends a frame and flushes it: afterwards the file can be opened whatever becomes of this
  // process, and the sidecar PATH with .xdmf lists the frame. Lists are by body (velocities empty
  // unless asked for) and by series.
  void write_frame(double time, const std::vector<std::span<const Vec3>>& positions,
                   const std::vector<std::span<const Vec3>>& velocities,
                   std::span<const double> series);
  int frames() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

// Opens a trajectory, also one whose run was killed: frames() counts the committed ones.
class TrajectoryReader {
 public:
  explicit TrajectoryReader(const std::string& path);
  ~TrajectoryReader();
  int frames() const;
  double time(int frame) const;
  std::string title() const;
  std::string case_text() const;
  const std::vector<TrajectoryBody>& bodies() const;
  // By particle, m.
  std::vector<Vec3> positions(int body, int frame) const;
  std::vector<TrajectoryWriter::Series> series() const;
  std::vector<double> series_values(const std::string& name) const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

// A file shape: [rows, cols, 3] or [patches, rows, cols, 3] from an HDF5 file. Throws
// TrajectoryError.
struct TexelFile {
  int patches = 0, rows = 0, cols = 0;
  std::vector<Vec3> texels;
};
TexelFile read_texels(const std::string& path, const std::string& dataset);

}  // namespace weft::sim
