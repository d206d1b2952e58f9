// Looks at files of which the system may refuse to say anything.
#pragma once

#include <filesystem>
#include <string>
#include <system_error>

#include "sim/base/file_error.h"

namespace weft::sim {

// Returns the message for the user: the path and the reason of the system.
inline std::string fault_text(const std::filesystem::filesystem_error& error) {
  const std::string path = error.path1().string();
  return (path.empty() ? "weft" : path) + ": cannot be accessed: " + error.code().message();
}

// Returns the status of the file at `path`, across links; its type is not_found if there is none.
// Throws FileError if the system does not tell, for example because a folder may not be entered,
// links lead in a circle or a name is too long.
inline std::filesystem::file_status status_of(const std::string& path) {
  try {
    return std::filesystem::status(path);
  } catch (const std::filesystem::filesystem_error& error) {
    throw FileError(fault_text(error));
  }
}

// Returns the status of the file or the link at `path`, like status_of().
inline std::filesystem::file_status link_status_of(const std::string& path) {
  try {
    return std::filesystem::symlink_status(path);
  } catch (const std::filesystem::filesystem_error& error) {
    throw FileError(fault_text(error));
  }
}

// Throws FileError if a new file at `path` would take the place of a folder, a device, a pipe or a
// socket. `status` is link_status_of(path): a link gives way, and what it names stays.
inline void refuse_special_file(const std::string& path,
                                const std::filesystem::file_status& status) {
  if (std::filesystem::is_directory(status)) throw FileError(path + ": is a directory");
  if (std::filesystem::is_other(status) && !std::filesystem::is_symlink(status))
    throw FileError(path + ": is no file, but a device, a pipe or a socket");
}

// Throws FileError if the name of the file `path` is longer than the system allows, also where its
// folder is still to be made.
inline void refuse_long_name(const std::string& path) {
  namespace fs = std::filesystem;
  std::error_code error;
  fs::path folder = fs::absolute(path, error).parent_path();
  while (!fs::exists(folder, error) && folder.has_relative_path()) folder = folder.parent_path();
  static_cast<void>(fs::symlink_status(folder / fs::path(path).filename(), error));
  if (error == std::errc::filename_too_long)
    throw FileError(path + ": cannot create: " + error.message());
}

}  // namespace weft::sim
