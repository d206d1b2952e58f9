// A separate process for untrusted files. HDF5 1.10 crashes on some damaged files and reads others
// without end; both must become a message.
#pragma once

#include <functional>
#include <optional>
#include <string>

namespace weft::sim {

struct ProcessEnd {
  int code = 0;    // result of `work`
  int signal = 0;  // signal that ended the process; 0: none
};

// Calls `work` in a copy of this process and waits for it. The copy has only the calling thread;
// its memory is its own, but it shares this process's streams. It dies with this process, leaves no
// core file, and ends without destructors or exit handlers: `work` must flush what it writes. An
// exception that leaves `work` ends it by SIGABRT. Meanwhile this process calls `meanwhile`, to
// read what `work` sends. Throws std::runtime_error if the system gives no process. Cost: about a
// millisecond.
//
// After `cpu_limit` seconds of CPU time, rounded up, SIGXCPU ends the process.
ProcessEnd run_in_process(const std::function<int()>& work,
                          const std::function<void()>& meanwhile = {},
                          std::optional<double> cpu_limit = {});

// Limit of CPU time for reading, s; a sound file takes far less.
inline constexpr double reading_cpu_limit = 30;

// Message for a crash: "PATH: is damaged: HDF5 crashed on reading it (Segmentation fault)" or, for
// SIGXCPU, "PATH: is damaged: HDF5 comes to no end of reading it".
std::string describe_crash(const std::string& path, int signal);

}  // namespace weft::sim
