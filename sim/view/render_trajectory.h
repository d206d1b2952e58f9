// Trajectories as pictures and as a movie.
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
  // Draws bodies with fewer triangles and without grid lines, with every point within this many
  // pixels of its place; > 0.
  std::optional<double> detail_pixels;
  // Draws the surface of this level of each body's pyramid (bsi/level_of_detail.h), or the body
  // itself beyond the last level; >= 0. At most one of detail_pixels, surface_of_level and
  // spheres_of_level is given.
  std::optional<int> surface_of_level;
  // Draws the spheres of this level of each body's pyramid, or of its last level; >= 0. Spheres
  // that touch one of another body are red.
  std::optional<int> spheres_of_level;
  // Paints the bodies by this recorded field, with a legend, and not in their own colours. Vectors
  // count by their magnitude. Not with spheres_of_level.
  std::optional<std::string> colour_field;
  // Numbers at the ends of the colours, the first one smaller; by default those of all frames
  // drawn.
  std::optional<std::array<double, 2>> colour_range;
  bool force = false;                       // overwrites pictures that no rendering made
  bool movie = true;                        // also directory/movie.mp4, if ffmpeg is there
  std::optional<double> frames_per_second;  // of the movie, > 0; default below
  // Called with the numbers of pictures done and in all, before the first one and after each.
  std::function<void(int, int)> progress;
};

// A request that this file cannot meet, such as a field that it lacks.
class RenderUsageError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct RenderReport {
  int pictures = 0;
  std::int64_t triangles = 0;      // drawn, sum over all pictures
  std::int64_t all_triangles = 0;  // the same at full detail
  double frames_per_second = 0;
  // With colour_field: its numbers in the frames drawn, and the bodies that lack it.
  double least = 0, most = 0;
  std::string units;
  std::vector<std::string> plain_bodies;
  std::string movie;         // its path; empty without a movie
  std::string why_no_movie;  // "ffmpeg not found: no movie", or what ffmpeg said
};

// Draws the trajectory at `trajectory` into `directory`, which is created if needed, as
// frame_00000.png, frame_00010.png, ..., by the numbers of frames, and as an MP4 (H.264) through
// the ffmpeg program.
//
// Pictures and a movie of an earlier rendering are removed or replaced. Files that no rendering
// made stay; if they are in the way, they are refused before anything is drawn, unless `force` is
// set. One fixed camera sees every body over all drawn frames; of obstacles more than twice as
// large as the simulated bodies it sees the part near them. Bodies take the colours of gpu::palette
// in order; obstacles are grey. With a colour field, bodies that have it are painted by it in the
// colours of one scale for all pictures, and the legend takes a strip at their right. The movie
// runs in real time, by the times of the frames, with 1 to 120 frames per second.
//
// Throws FileError for an unreadable trajectory. Throws RenderUsageError, before anything is
// written, if no body has the colour field, or if the picture is too small for its legend. Throws
// std::runtime_error if it has no frames or
// positions that are not finite, if a file is in the way, if a picture cannot be written, or if
// Weft was built without gpu/. A missing movie is no error: the report says why, and the pictures
// stay. Cost: tens of milliseconds per picture.
RenderReport render_trajectory(const std::string& trajectory, const std::string& directory,
                               const RenderOptions& options);

}  // namespace weft::sim
