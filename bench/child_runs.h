// Work in separate processes, each of which may crash or hang.
#pragma once

#include <cstddef>
#include <functional>
#include <string>

namespace weft::bench {

// How a child has ended.
struct ChildEnd {
  bool is_well = false;  // its work returned
  int signal = 0;        // signal that ended it, or 0
  std::string result;    // result of its work, any bytes
};

// Calls work(i) for every i below `count` in a child process, `jobs` at a time. Each may take
// cpu_limit(i) seconds of CPU time (rounded up), after which SIGXCPU ends it. Calls done(i, end) in
// this process as each ends. Throws std::runtime_error if the system has no process or pipe left.
void run_children(std::size_t count, int jobs, const std::function<double(std::size_t)>& cpu_limit,
                  const std::function<std::string(std::size_t)>& work,
                  const std::function<void(std::size_t, const ChildEnd&)>& done);

}  // namespace weft::bench
