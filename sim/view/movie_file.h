// Makes movies from pictures with the program ffmpeg.
#pragma once

#include <string>
#include <vector>

namespace weft::sim {

inline constexpr const char* movie_name = "movie.mp4";

struct MovieResult {
  bool written = false;
  std::string reason;  // empty if written
};

// Makes directory/movie.mp4 (H.264, yuv420p) from `pictures`: names of PNG files in the directory,
// in the order of the movie. An odd width or height grows by a black line, because yuv420p needs
// even sizes. The comment in the movie's metadata says that Weft made it. Runs ffmpeg from PATH,
// without a shell, and waits for it. The movie has a temporary name until it is complete, and then
// replaces any file of its name. Without a movie, that file stays, and the reason is returned.
MovieResult write_movie(const std::string& directory, const std::vector<std::string>& pictures,
                        double frames_per_second);

// True if the first or the last mebibyte of the file at `path` has the comment of write_movie().
bool is_own_movie(const std::string& path);

}  // namespace weft::sim
