// The memory of this process.
#pragma once

#include <fstream>
#include <string>

namespace weft::sim {

// Returns the largest resident memory of this program so far (MiB), or 0 if the system does not
// tell it. Unlike ru_maxrss of getrusage(), it leaves out the memory of the process that started
// the program.
inline double peak_resident_memory() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    constexpr const char* name = "VmHWM:";  // kB
    if (line.starts_with(name)) return std::stod(line.substr(std::string(name).size())) / 1024;
  }
  return 0;
}

}  // namespace weft::sim
