// The error of a file that cannot be read or written.
#pragma once

#include <stdexcept>

namespace weft::sim {

// The exception for a file that cannot be read or written, or whose content is not valid (exit code
// 4). The text starts with the path of the file, or of its folder if the folder cannot be created.
class FileError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace weft::sim
