// Reference values from other sources, stored with these in tests/reference/.
#pragma once

#include <fstream>
#include <stdexcept>
#include <string>

namespace weft {

// Returns the second field of the line of tests/reference/closed_forms.csv that begins with this
// name.
inline double reference_value(const std::string& name) {
  std::ifstream file(std::string(WEFT_REFERENCE_DIR) + "/closed_forms.csv");
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with(name + ",")) return std::stod(line.substr(name.size() + 1));
  }
  throw std::runtime_error("tests/reference/closed_forms.csv has no " + name);
}

}  // namespace weft
