// Makes movies from numbered pictures with the ffmpeg program.
#pragma once

#include <string>
#include <vector>

namespace weft::sim {

struct MovieResult {
  bool written = false;
  std::string reason;  // empty if written
};

// Makes directory/movie.mp4 (H.264, yuv420p) from the pictures, in this order. `pictures` are names
// of files in the directory. An odd width or height gets a black line, because yuv420p needs even
// sizes. The movie's metadata (comment) says that Weft made it. Runs ffmpeg from PATH, without a
// shell, and waits for it. Returns the reason if that fails, and removes an unfinished movie.
MovieResult write_movie(const std::string& directory, const std::vector<std::string>& pictures,
                        double frames_per_second);

// True if write_movie() made the movie at `path`. Reads at most a mebibyte at each end of the file.
bool is_own_movie(const std::string& path);

}  // namespace weft::sim
