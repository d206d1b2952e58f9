// The summary of a trajectory that `weft info` prints.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bsi/geometry_image.h"
#include "sim/base/bill.h"
#include "sim/view/field_extremes.h"

namespace weft::sim {

// How far the curved surface of a shell leaves the triangles that contact keeps apart, over all
// frames: an upper bound (m), and the first time (s) at which it is reached. Curved surfaces keep
// apart while it is no more than half the thickness of contact.
struct SurfaceDeviation {
  double largest = 0, time = 0;
};

struct BodySummary {
  std::string name;
  int patches = 0, rows = 0, cols = 0;  // rows and columns of each patch
  int particles = 0, triangles = 0;
  bool moves = true;
  bool is_obstacle = false;
  double thickness = 0;  // m
  // Rows and columns of the body's images that are recorded. Empty: all.
  std::vector<int> part_rows, part_cols;
  std::optional<SurfaceDeviation> deviation;  // of shells recorded as a whole
  // Bounds at the last frame (m). has_bounds is false if a moving body has no frame yet, or if a
  // position is not finite.
  bool has_bounds = false, is_finite = true;
  bsi::Vec3 lower = bsi::Vec3::Zero(), upper = bsi::Vec3::Zero();
};

struct SeriesSummary {
  std::string name, units;
  // Last value and extremes over all frames. The extremes leave out values that are not finite.
  // Without finite values, has_extremes is false and both are zero.
  double last = 0, minimum = 0, maximum = 0;
  bool has_extremes = false;
};

struct TrajectorySummary {
  std::string path, title, weft_version;
  // Status of the run: "done", "failed" or "interrupted", with the reason; "running" while a
  // process writes the file; "killed" if its writer died; "unknown" in files of earlier versions.
  std::string status, reason;
  Bill bill;  // zero unless the run has ended
  int format_version = 1;
  int frames = 0;
  double first_time = 0, last_time = 0;  // s; zero without frames
  bool has_velocity = false;
  std::vector<BodySummary> bodies;
  std::vector<FieldSummary> fields;
  std::vector<RecordSummary> records;
  std::vector<SeriesSummary> series;
};

// Reads everything except the positions before the last frame; of shells it reads them all. Reads
// one frame of one field at a time. Throws FileError.
TrajectorySummary summarise_trajectory(const std::string& path);
// Returns the summary as text for people.
std::string to_text(const TrajectorySummary& summary);
// Returns one JSON object. Its keys are the names above with units: "last_time_s", "thickness_m",
// ...
std::string to_json(const TrajectorySummary& summary);

// The place of a triangle.
struct CrossingPlace {
  std::string body;
  bsi::TexelAddress texel;  // first corner of the triangle's quad
};
struct FrameCrossings {
  int frame = 0;
  double time = 0;     // s
  int count = 0;       // pairs of triangles that intersect
  CrossingPlace a, b;  // places of the first pair, if count > 0
};

// Counts the intersecting pairs of triangles in the positions on disk, exactly
// (sim/view/crossings.h). Returns one entry per frame. Obstacles are checked neither against each
// other nor against themselves, because they may be built from overlapping parts. Shells have the
// triangles of RecordedSurface, and their texels are those of its image.
//
// Throws FileError, also for a file that cannot be judged: it has no frame, only obstacles, a body
// recorded only in part, or a position that is not finite or beyond the range of float32. The
// message names the position.
std::vector<FrameCrossings> count_crossings(const std::string& path);
std::string to_text(const std::vector<FrameCrossings>& frames);
// Returns {"crossings": total, "frames": [{"frame", "time_s", "count", "first": [place,
// place]}...]}. A place is {"body", "patch", "row", "col"}.
std::string to_json(const std::vector<FrameCrossings>& frames);

}  // namespace weft::sim
