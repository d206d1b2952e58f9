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
  int every = 1;                  // >= 1; draws frames 0, every, 2 every, ... and the last frame
  // If set, bodies are drawn with fewer triangles and without grid lines. It is the largest
  // distance (pixels, > 0) by which a point of the picture may be displaced.
  std::optional<double> detail_pixels;
  // If set, bodies are drawn as the surfaces of this level (>= 0) of their pyramids
  // (bsi/level_of_detail.h). A patch with fewer levels is drawn as it is. At most one of
  // detail_pixels, surface_of_level and spheres_of_level may be set.
  std::optional<int> surface_of_level;
  // If set, bodies are drawn as the spheres of this level (>= 0) of their pyramids. A patch with
  // fewer levels shows those of its last level. Spheres that touch a sphere of another body are
  // red.
  std::optional<int> spheres_of_level;
  // If set, this recorded field colours the bodies, and pictures have a legend. Vectors count by
  // their magnitude. Not allowed with spheres_of_level.
  std::optional<std::string> colour_field;
  // Values at the ends of the colour scale, the smaller one first. Default: the extremes of the
  // field in all drawn frames.
  std::optional<std::array<double, 2>> colour_range;
  bool force = false;  // if true, overwrites files that no rendering made
  bool movie = true;   // if true, also makes directory/movie.mp4, given that ffmpeg is installed
  // Frames per second of the movie, > 0. Default: real time multiplied by time.scale of the case,
  // but at least 1 and at most 120; 25 if the frames span no time.
  std::optional<double> frames_per_second;
  // Is called with the number of finished pictures and the number of all pictures, before the first
  // picture and after each one.
  std::function<void(int, int)> progress;
};

// The exception for options that a trajectory does not allow, such as a field that it lacks.
class RenderUsageError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct RenderReport {
  int pictures = 0;
  std::int64_t triangles = 0;             // number of drawn triangles, summed over all pictures
  std::int64_t all_triangles = 0;         // number of triangles at full detail, over all pictures
  double frames_per_second = 0;           // rate of the movie
  double least = 0, most = 0;             // extremes of the colour_field in the drawn frames
  std::string units;                      // unit of the colour_field
  std::vector<std::string> plain_bodies;  // names of the bodies without the colour_field
  std::string movie;                      // path of the movie; empty if no movie was made
  std::string why_no_movie;  // reason why no movie was made, such as "ffmpeg not found: no movie"
};

// Draws the frames of the file `trajectory` as pictures in the folder `directory`, which is created
// if needed. Pictures are named by their frames: frame_00000.png, frame_00010.png, .... With
// RenderOptions::movie, the program ffmpeg makes an MP4 movie (H.264) from them.
//
// Pictures and a movie of an earlier rendering are removed or replaced. Another file is replaced
// only with `force`, and only by a complete picture or movie of its name; it is never removed.
// Without `force`, a file with such a name that no rendering made is an error before anything is
// drawn.
//
// One fixed camera shows every body in all drawn frames. If an obstacle is more than twice as large
// as all simulated bodies together, the camera shows only the part of it near these bodies. Bodies
// have the colours of gpu::palette, in order; obstacles are grey. With a colour field, all pictures
// have the same colour scale and a legend in a strip at their right.
//
// Throws FileError for an unreadable trajectory. Throws RenderUsageError, before anything is
// written, if no body has the colour field, if the pictures are too small for a legend, or if a
// picture or the movie would replace the trajectory, also with `force`. Throws
// std::runtime_error for a trajectory without frames or with positions that are not finite. Also
// throws it if a file must not be replaced or cannot be written, or if Weft was built without gpu/.
// A missing movie is not an error: the report has the reason, and the pictures stay. Cost: tens of
// milliseconds per picture.
RenderReport render_trajectory(const std::string& trajectory, const std::string& directory,
                               const RenderOptions& options);

}  // namespace weft::sim
