// The error of files that cannot be read or written.
#pragma once

#include <stdexcept>

namespace weft::sim {

// Thrown when the file system or HDF5 refuses something (exit code 4). The text starts with the
// path.
class FileError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace weft::sim
