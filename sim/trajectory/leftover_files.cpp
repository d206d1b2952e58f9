#include "sim/trajectory/leftover_files.h"

#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <csignal>
#include <filesystem>
#include <system_error>
#include <vector>

#include "sim/trajectory/file_lock.h"

namespace weft::sim {

std::string temporary_path(const std::string& path) {
  return path + "." + std::to_string(getpid()) + ".tmp";
}

std::string file_of_leftover(std::string_view name) {
  constexpr std::string_view end = ".tmp";
  if (!name.ends_with(end)) return "";
  name.remove_suffix(end.size());
  const std::size_t dot = name.rfind('.');
  if (dot == std::string_view::npos) return "";
  const std::string_view number = name.substr(dot + 1);
  const char* const number_end = number.data() + number.size();
  int process = 0;
  const auto [rest, error] = std::from_chars(number.data(), number_end, process);
  if (error != std::errc() || rest != number_end || process <= 0) return "";
  if (kill(process, 0) == 0 || errno != ESRCH) return "";
  return std::string(name.substr(0, dot));
}

void remove_leftovers(const std::string& path) {
  namespace fs = std::filesystem;
  const fs::path trajectory(path);
  const std::string file = trajectory.filename().string();
  const std::string sidecar = fs::path(file).replace_extension(".xdmf").string();
  const fs::path folder = trajectory.has_parent_path() ? trajectory.parent_path() : ".";
  std::error_code error;
  std::vector<fs::path> leftovers;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    const std::string finished = file_of_leftover(at->path().filename().string());
    if (finished == file || finished == sidecar) leftovers.push_back(at->path());
  }
  for (const fs::path& leftover : leftovers) {
    if (!is_locked(leftover.string())) fs::remove(leftover, error);
  }
}

}  // namespace weft::sim
