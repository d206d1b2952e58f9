// Movies from numbered pictures, through the ffmpeg program.
#pragma once

#include <string>
#include <vector>

namespace weft::sim {

struct MovieResult {
  bool written = false;
  std::string reason;  // why not
};

// Makes directory/movie.mp4 (H.264, yuv420p) of these pictures, which are names of files in the
// directory, in their order. An odd width or height gets a black line, since yuv420p needs even
// ones. Signs it in its metadata (comment). What a failed ffmpeg leaves is removed. Waits for
// ffmpeg, which is looked for in PATH and run without a shell.
MovieResult write_movie(const std::string& directory, const std::vector<std::string>& pictures,
                        double frames_per_second);

// True if there is a movie at `path` that write_movie made. Reads at most a mebibyte at each end of
// the file.
bool is_own_movie(const std::string& path);

}  // namespace weft::sim
