// Checks of arguments that several commands share.
#pragma once

#include <string>

namespace weft::sim {

// Validates an option that names a file or a folder: returns an error message, or an empty text if
// the name is not empty. An empty name would stand for the default, or for no file, in silence.
inline std::string is_name(const std::string& text) {
  return text.empty() ? "expected a name, not an empty text" : "";
}

}  // namespace weft::sim
