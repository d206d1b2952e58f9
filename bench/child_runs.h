// Work in processes of their own, each of which may crash or hang.
#pragma once

#include <cstddef>
#include <functional>
#include <string>

namespace weft::bench {

// How a child has ended.
struct ChildEnd {
  bool is_well = false;  // it has returned from its work
  int signal = 0;        // that ended it, if any
  std::string result;    // what its work has returned, any bytes
};

// Calls work(i) for every i below `count` in a child process, `jobs` at a time, each with at most
// cpu_limit(i) seconds of CPU time (rounded up), at which it is ended by SIGXCPU; done(i, end) here
// as each ends. Throws std::runtime_error where the system has no process or pipe left.
void run_children(std::size_t count, int jobs, const std::function<double(std::size_t)>& cpu_limit,
                  const std::function<std::string(std::size_t)>& work,
                  const std::function<void(std::size_t, const ChildEnd&)>& done);

}  // namespace weft::bench
