// Work in a process of its own, with its peak memory.
#pragma once

#include <functional>
#include <string>

namespace weft::bench {

struct ApartResult {
  std::string result;     // result of the work, any bytes
  double peak_bytes = 0;  // largest resident memory of the process
};

// Calls work() in a child process, whose peak memory is then that of this work alone, apart from
// the program itself. Precondition: this process has not used several threads yet. Throws
// std::runtime_error if the work throws (its message goes to stderr) or the child ends early.
ApartResult run_apart(const std::function<std::string()>& work);

}  // namespace weft::bench
