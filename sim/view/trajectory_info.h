// The facts about a trajectory that `weft info` prints: a summary, or the number of crossings.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bsi/geometry_image.h"
#include "sim/base/bill.h"
#include "sim/view/field_extremes.h"

namespace weft::sim {

// The distance between the curved surface of a shell and the triangles on which contact acts.
// `largest` is an upper bound over all frames with finite positions (m), and `time` the first time
// at which it is reached (s). Contact keeps the curved surfaces of two bodies apart if neither
// bound exceeds half the thickness of its body.
struct SurfaceDeviation {
  double largest = 0, time = 0;
};

struct BodySummary {
  std::string name;
  int patches = 0, rows = 0, cols = 0;  // number of patches; numbers of rows and columns in a patch
  int particles = 0, triangles = 0;
  bool moves = true;
  bool is_obstacle = false;
  double thickness = 0;  // m
  // Smallest and largest radius (m) of a group of particles; zero for surfaces.
  double least_radius = 0, largest_radius = 0;
  // Recorded rows and columns of the body's image. Empty: all rows and columns.
  std::vector<int> part_rows, part_cols;
  std::optional<SurfaceDeviation> deviation;  // set for shells recorded as a whole, with positions
  // is_finite: true if all positions in the last frame are finite. has_bounds: true if, in
  // addition, the body has positions; a body that moves has none before the first frame.
  bool has_bounds = false, is_finite = true;
  // Corners of the bounding box in the last frame (m), if has_bounds.
  bsi::Vec3 lower = bsi::Vec3::Zero(), upper = bsi::Vec3::Zero();
};

struct SeriesSummary {
  std::string name, units;
  // Value in the last frame, and extremes of the finite values of all frames.
  double last = 0, minimum = 0, maximum = 0;
  bool has_extremes = false;  // false if no value is finite
};

struct TrajectorySummary {
  std::string path, title, weft_version;
  std::string time_units;  // of all times: "s", or "1" if frames are numbers of modes
  // Status of the run: "done", or "failed" or "interrupted" with the reason. While a process writes
  // the file, the status is "running". If that process died before the end of the run, the status
  // is "killed". It is "unknown" if the file is of a version that does not record the ends of runs.
  std::string status, reason;
  Bill bill;  // cost of the run; zero unless the run has ended
  int format_version = 1;
  int frames = 0;
  double first_time = 0, last_time = 0;  // zero without frames
  bool has_velocity = false;
  std::vector<BodySummary> bodies;
  std::vector<FieldSummary> fields;
  std::vector<RecordSummary> records;
  std::vector<SeriesSummary> series;
};

// Returns the summary of the trajectory at `path`. Reads the whole file, except that only shells
// need positions of other frames than the last. Reads one frame of one field at a time. Throws
// FileError.
TrajectorySummary summarise_trajectory(const std::string& path);
// Returns the summary as text for people.
std::string to_text(const TrajectorySummary& summary);
// Returns the summary as one JSON object. Most keys are the names of the members above, extended by
// units, such as "last_time_s".
std::string to_json(const TrajectorySummary& summary);

// The position of a triangle in a trajectory.
struct CrossingPlace {
  std::string body;
  bsi::TexelAddress texel;  // first corner of the triangle's quad
};
struct FrameCrossings {
  int frame = 0;
  double time = 0;     // s
  int count = 0;       // number of pairs of triangles that intersect
  CrossingPlace a, b;  // triangles of the first pair, if count > 0
};

// Counts the intersecting pairs of triangles in the recorded positions, exactly
// (sim/view/crossings.h). Returns one entry per frame. Obstacles are checked neither against each
// other nor against themselves, because they may be built from overlapping parts. The triangles are
// those of RecordedSurface, and texels belong to RecordedSurface::atlas().
//
// Throws FileError for a file that cannot be read or judged. A file cannot be judged if it has no
// frame, no body besides obstacles, a body recorded in part, or a position that is not finite or
// beyond the range of float32.
std::vector<FrameCrossings> count_crossings(const std::string& path);
// Returns the crossings as text for people.
std::string to_text(const std::vector<FrameCrossings>& frames);
// Returns the crossings as a JSON object {"crossings": total, "frames": [{"frame", "time_s",
// "count", "first": [place, place]}...]}. A place is {"body", "patch", "row", "col"}. A frame
// without crossings has no "first".
std::string to_json(const std::vector<FrameCrossings>& frames);

}  // namespace weft::sim
