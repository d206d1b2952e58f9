// Folders of files that are to be written.
#pragma once

#include <filesystem>
#include <string>
#include <system_error>

#include "sim/base/file_error.h"

namespace weft::sim {

// Returns the path after creating its folder if that is missing. Throws FileError if it cannot be
// created. Called once all else is ready, since a faulty case must leave nothing behind.
inline std::string in_output_folder(const std::string& path) {
  const auto folder = std::filesystem::path(path).parent_path();
  std::error_code error;
  if (!folder.empty()) std::filesystem::create_directories(folder, error);
  if (error) throw FileError(folder.string() + ": cannot create: " + error.message());
  return path;
}

}  // namespace weft::sim
