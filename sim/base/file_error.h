// The error of files that cannot be read or written.
#pragma once

#include <stdexcept>

namespace weft::sim {

// Thrown for what the file system or HDF5 refuses (exit code 4); the text starts with the path.
class FileError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace weft::sim
