// Makes the folder of an output file.
#pragma once

#include <filesystem>
#include <string>
#include <system_error>

#include "sim/base/file_error.h"

namespace weft::sim {

// Creates the folder of the file `path` if it is missing, and returns `path`. Throws FileError if
// the folder cannot be created. Call it only after the case has been checked, so that a faulty case
// creates no folders.
inline std::string in_output_folder(const std::string& path) {
  const auto folder = std::filesystem::path(path).parent_path();
  std::error_code error;
  if (!folder.empty()) std::filesystem::create_directories(folder, error);
  if (error) throw FileError(folder.string() + ": cannot create: " + error.message());
  return path;
}

}  // namespace weft::sim
