#include "sim/trajectory/leftover_files.h"

#include <cerrno>
#include <charconv>
#include <csignal>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <vector>

#include "sim/trajectory/file_lock.h"

namespace weft::sim {

namespace {

// True if `name` is `file`, the number of a process that does not live on this machine, and .tmp,
// with dots between them.
bool is_leftover_of(std::string_view name, std::string_view file) {
  constexpr std::string_view end = ".tmp";
  if (!name.starts_with(file) || !name.ends_with(end)) return false;
  name.remove_prefix(file.size());
  if (name.size() < end.size() + 2 || name[0] != '.') return false;
  name = name.substr(1, name.size() - 1 - end.size());
  const char* const name_end = name.data() + name.size();
  int process = 0;
  const auto [rest, error] = std::from_chars(name.data(), name_end, process);
  if (error != std::errc() || rest != name_end || process <= 0) return false;
  return kill(process, 0) != 0 && errno == ESRCH;
}

}  // namespace

void remove_leftovers(const std::string& path) {
  namespace fs = std::filesystem;
  const fs::path trajectory(path);
  const std::string file = trajectory.filename().string();
  const std::string sidecar = fs::path(file).replace_extension(".xdmf").string();
  const fs::path folder = trajectory.has_parent_path() ? trajectory.parent_path() : ".";
  std::error_code error;
  std::vector<fs::path> leftovers;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    const std::string name = at->path().filename().string();
    if (is_leftover_of(name, file) || is_leftover_of(name, sidecar))
      leftovers.push_back(at->path());
  }
  for (const fs::path& leftover : leftovers) {
    if (!is_locked(leftover.string())) fs::remove(leftover, error);
  }
}

}  // namespace weft::sim
