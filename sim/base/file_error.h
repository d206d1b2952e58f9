// The error of a file that cannot be read or written.
#pragma once

#include <stdexcept>

namespace weft::sim {

// Thrown when a file cannot be read or written, or its content is not valid (exit code 4). The text
// starts with the path.
class FileError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace weft::sim
