// Trajectories as pictures and as a movie.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

namespace weft::sim {

struct RenderOptions {
  int width = 960, height = 720;  // pixels, 1..8192
  int every = 1;                  // draws frames 0, every, 2 every, ... and the last; >= 1
  // Draws bodies with as few triangles as keep every point within so many pixels, and without grid
  // lines; > 0.
  std::optional<double> detail_pixels;
  // At most one of these two and detail_pixels. Draws the surface of this level of each body's
  // pyramid (bsi/level_of_detail.h), or, beyond its last level, the body; >= 0.
  std::optional<int> surface_of_level;
  // Draws the spheres of this level of each body's pyramid, or of its last level, those that touch
  // one of another body in red; >= 0.
  std::optional<int> spheres_of_level;
  bool force = false;                       // overwrites pictures that are not its own
  bool movie = true;                        // also directory/movie.mp4, if ffmpeg is there
  std::optional<double> frames_per_second;  // of the movie, > 0; default below
  // Called with the number of pictures done and of all, before the first one and after each.
  std::function<void(int, int)> progress;
};

struct RenderReport {
  int pictures = 0;
  std::int64_t triangles = 0;      // drawn, in all pictures together
  std::int64_t all_triangles = 0;  // the same at full detail
  double frames_per_second = 0;
  std::string movie;         // its path; empty when there is none
  std::string why_no_movie;  // "ffmpeg not found: no movie", or what ffmpeg said
};

// Draws the trajectory at `trajectory` into `directory` (made if need be) as frame_00000.png,
// frame_00010.png, ..., by the numbers of the frames, and as an MP4 (H.264) through the ffmpeg
// program. Pictures of an earlier rendering that are not replaced, and its movie, are removed;
// files that no rendering made are left, and without `force` refused, before anything is drawn,
// where they are in the way. One fixed camera sees every body over all drawn frames; of obstacles
// more than twice as large as what is simulated it sees what is near. Bodies take gpu::palette in
// order, obstacles are grey. The movie runs in real time, from the times of the frames, but with 1
// to 120 frames a second. Throws FileError for an unreadable trajectory; std::runtime_error
// when it has no frames or positions that are not finite, when a file is in the way, when a picture
// cannot be written, or when Weft was built without gpu/. Without a movie it only says so in the
// report: the pictures are kept. Tens of milliseconds per picture.
RenderReport render_trajectory(const std::string& trajectory, const std::string& directory,
                               const RenderOptions& options);

}  // namespace weft::sim
