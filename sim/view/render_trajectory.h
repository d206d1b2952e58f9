// Renders trajectories as pictures and as a movie.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace weft::sim {

struct RenderOptions {
  int width = 960, height = 720;  // pixels, 1..8192
  int every = 1;                  // draws frames 0, every, 2 every, ... and the last; >= 1
  // Draws bodies with fewer triangles and without grid lines. Every point stays within this many
  // pixels of its place. > 0.
  std::optional<double> detail_pixels;
  // Draws the surface of this level of each body's pyramid (bsi/level_of_detail.h), or the body
  // itself beyond the last level. >= 0. At most one of detail_pixels, surface_of_level and
  // spheres_of_level may be given.
  std::optional<int> surface_of_level;
  // Draws the spheres of this level of each body's pyramid, or of its last level if there are
  // fewer. >= 0. Spheres that touch a sphere of another body are red.
  std::optional<int> spheres_of_level;
  // Colours the bodies by this recorded field instead of their own colours, and adds a legend.
  // Vectors count by their magnitude. Not allowed with spheres_of_level.
  std::optional<std::string> colour_field;
  // Values at the ends of the colours, the smaller one first. By default the extremes of all drawn
  // frames.
  std::optional<std::array<double, 2>> colour_range;
  bool force = false;  // overwrites files that no rendering made
  bool movie = true;   // also makes directory/movie.mp4, if ffmpeg is installed
  std::optional<double> frames_per_second;  // of the movie, > 0; default: see render_trajectory()
  // Called with the number of finished pictures and the number of all, before the first picture and
  // after each.
  std::function<void(int, int)> progress;
};

// Thrown for a request that this file cannot meet, such as a field that it lacks.
class RenderUsageError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct RenderReport {
  int pictures = 0;
  std::int64_t triangles = 0;      // drawn in all pictures together
  std::int64_t all_triangles = 0;  // in all pictures together, at full detail
  double frames_per_second = 0;
  // With colour_field: the field's extremes in the drawn frames, its unit, and the bodies without
  // it.
  double least = 0, most = 0;
  std::string units;
  std::vector<std::string> plain_bodies;
  std::string movie;         // path of the movie; empty without one
  std::string why_no_movie;  // "ffmpeg not found: no movie", or what ffmpeg said
};

// Draws the trajectory at `trajectory` into `directory`, which is created if needed. Pictures are
// frame_00000.png, frame_00010.png, ..., named by their frames. The ffmpeg program makes an MP4
// (H.264) from them.
//
// Pictures and a movie of an earlier rendering are removed or replaced. Files that no rendering
// made stay. Without `force`, such a file in the way is an error before anything is drawn.
//
// One fixed camera shows every body over all drawn frames. Of obstacles more than twice as large as
// the simulated bodies it shows the part near them. Bodies take the colours of gpu::palette in
// order; obstacles are grey. With a colour field, one scale holds for all pictures, and the legend
// takes a strip at their right. By default the movie runs in real time, with 1 to 120 frames per
// second.
//
// Throws FileError for an unreadable trajectory. Throws RenderUsageError, before anything is
// written, if no body has the colour field or the picture is too small for its legend. Throws
// std::runtime_error for a trajectory without frames or with positions that are not finite. Also
// throws it if a file is in the way or cannot be written, or if Weft was built without gpu/. A
// missing movie is not an error: the report says why, and the pictures stay. Cost: tens of
// milliseconds per picture.
RenderReport render_trajectory(const std::string& trajectory, const std::string& directory,
                               const RenderOptions& options);

}  // namespace weft::sim
