// A process of its own for files that others wrote. HDF5 1.10 crashes on some damaged ones and
// reads others without end; both must become a message.
#pragma once

#include <functional>
#include <optional>
#include <string>

namespace weft::sim {

struct ProcessEnd {
  int code = 0;    // what `work` returned
  int signal = 0;  // that ended it; 0: none
};

// Calls `work` in a copy of this process and waits for it. Only the calling thread exists there;
// its memory is its own, its streams are not. It dies with this process, leaves no core file, and
// ends without destructors or handlers of exit: `work` flushes what it writes. `meanwhile` runs
// here until it ends, to read what it sends. An exception that leaves `work` ends it by SIGABRT.
// Throws std::runtime_error when the system gives no process. About a millisecond.
//
// Beyond `cpu_limit` seconds of CPU time, rounded up, SIGXCPU ends the process.
ProcessEnd run_in_process(const std::function<int()>& work,
                          const std::function<void()>& meanwhile = {},
                          std::optional<double> cpu_limit = {});

// Reading a sound file takes far less CPU time than this, s.
inline constexpr double reading_cpu_limit = 30;

// "PATH: is damaged: HDF5 crashed on reading it (Segmentation fault)", or, for SIGXCPU, "PATH: is
// damaged: HDF5 comes to no end of reading it".
std::string describe_crash(const std::string& path, int signal);

}  // namespace weft::sim
