#include "sim/view/movie_file.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <vector>

#include "sim/base/file_status.h"

extern char** environ;  // NOLINT(readability-redundant-declaration): POSIX declares no environ

namespace weft::sim {
namespace {

constexpr const char* signature = "made by weft render";

// A folder with symbolic links to the pictures. The links are numbered without gaps, as ffmpeg
// requires. The destructor removes all symbolic links in the folder, and the folder if it is then
// empty. Other files in the folder are never removed.
class NumberedLinks {
 public:
  NumberedLinks(const std::string& directory, const std::vector<std::string>& pictures)
      : folder_(std::filesystem::path(directory) / name) {
    remove_links();  // a killed rendering may have left links
    std::filesystem::create_directory(folder_);
    for (std::size_t i = 0; i < pictures.size(); ++i) {
      std::filesystem::create_symlink(std::filesystem::path("..") / pictures[i],
                                      folder_ / (std::to_string(i) + ".png"));
    }
  }
  ~NumberedLinks() { remove_links(); }
  NumberedLinks(const NumberedLinks&) = delete;
  NumberedLinks& operator=(const NumberedLinks&) = delete;

  static constexpr const char* name = ".movie_frames";

 private:
  // Removes the links, and also the folder if it is then empty.
  void remove_links() const {
    std::error_code ignored;
    if (!std::filesystem::is_directory(std::filesystem::symlink_status(folder_, ignored))) return;
    std::vector<std::filesystem::path> links;
    for (const auto& entry : std::filesystem::directory_iterator(folder_, ignored)) {
      if (entry.is_symlink(ignored)) links.push_back(entry.path());
    }
    for (const std::filesystem::path& link : links) std::filesystem::remove(link, ignored);
    std::filesystem::remove(folder_, ignored);
  }

  std::filesystem::path folder_;
};

std::vector<std::string> ffmpeg_arguments(double frames_per_second, const std::string& name) {
  return {"ffmpeg",
          "-nostdin",
          "-y",
          "-loglevel",
          "error",
          "-framerate",
          std::to_string(frames_per_second),
          "-start_number",
          "0",
          "-i",
          std::string(NumberedLinks::name) + "/%d.png",
          "-vf",
          "pad=ceil(iw/2)*2:ceil(ih/2)*2",
          "-c:v",
          "libx264",
          "-crf",
          "18",
          "-pix_fmt",
          "yuv420p",
          "-movflags",
          "+faststart",
          "-metadata",
          std::string("comment=") + signature,
          "-f",
          "mp4",
          name};
}

// Starts ffmpeg in `directory` and sets `process` to its id. Its messages go to `message_pipe`.
// Returns 0 or the error number of posix_spawnp().
int start_ffmpeg(const std::string& directory, const std::vector<std::string>& arguments,
                 int message_pipe, pid_t& process) {
  std::vector<char*> pointers;
  pointers.reserve(arguments.size() + 1);
  for (const std::string& argument : arguments) {
    pointers.push_back(const_cast<char*>(argument.c_str()));  // posix_spawn does not write to them
  }
  pointers.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addchdir_np(&actions, directory.c_str());
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, message_pipe, STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, message_pipe, STDERR_FILENO);
  const int error =
      posix_spawnp(&process, pointers[0], &actions, nullptr, pointers.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  return error;
}

// Reads from a pipe until its other end is closed. Returns the text without line ends at its end.
std::string read_all(int file) {
  std::string text;
  std::array<char, 4096> part{};
  for (;;) {
    const ssize_t count = read(file, part.data(), part.size());
    if (count > 0) {
      text.append(part.data(), static_cast<std::size_t>(count));
    } else if (count == 0 || errno != EINTR) {
      break;
    }
  }
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text;
}

// Runs ffmpeg in `directory` and waits for it. Returns why there is no movie, or an empty text.
std::string run_ffmpeg(const std::string& directory, const std::vector<std::string>& arguments) {
  std::array<int, 2> message_pipe{};
  if (pipe2(message_pipe.data(), O_CLOEXEC) != 0)
    return std::string("cannot run ffmpeg: ") + std::strerror(errno);
  pid_t process = 0;
  const int error = start_ffmpeg(directory, arguments, message_pipe[1], process);
  close(message_pipe[1]);
  const std::string messages = error == 0 ? read_all(message_pipe[0]) : "";
  close(message_pipe[0]);
  if (error == ENOENT) return "ffmpeg not found: no movie";
  if (error != 0) return std::string("cannot run ffmpeg: ") + std::strerror(error);
  int status = 0;
  while (waitpid(process, &status, 0) < 0) {
    if (errno != EINTR) return std::string("lost ffmpeg: ") + std::strerror(errno);
  }
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return "";
  const std::string end = WIFEXITED(status) ? "exit code " + std::to_string(WEXITSTATUS(status))
                                            : "signal " + std::to_string(WTERMSIG(status));
  return "ffmpeg failed (" + end + ")" + (messages.empty() ? "" : ": " + messages);
}

}  // namespace

MovieResult write_movie(const std::string& directory, const std::vector<std::string>& pictures,
                        double frames_per_second) {
  const std::filesystem::path folder(directory);
  const std::string unfinished = std::string(movie_name) + "." + std::to_string(getpid()) + ".tmp";
  std::string reason;
  try {
    const NumberedLinks links(directory, pictures);
    reason = run_ffmpeg(directory, ffmpeg_arguments(frames_per_second, unfinished));
    if (reason.empty()) std::filesystem::rename(folder / unfinished, folder / movie_name);
  } catch (const std::filesystem::filesystem_error& error) {
    reason = "no movie: " + fault_text(error);
  }
  if (reason.empty()) return {true, ""};
  std::error_code ignored;
  std::filesystem::remove(folder / unfinished, ignored);
  return {false, reason};
}

bool is_own_movie(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return false;
  std::ifstream file(path, std::ios::binary);
  constexpr std::streamoff reach = 1 << 20;
  const auto size = static_cast<std::streamoff>(std::filesystem::file_size(path, error));
  for (const std::streamoff start :
       {std::streamoff{0}, std::max<std::streamoff>(0, size - reach)}) {
    std::string part(static_cast<std::size_t>(std::min(size, reach)), '\0');
    file.seekg(start);
    if (file.read(part.data(), std::ssize(part)) && part.find(signature) != std::string::npos) {
      return true;
    }
  }
  return false;
}

}  // namespace weft::sim
