// Reads untrusted files in a separate process. HDF5 1.10 crashes on some damaged files and reads
// others without end; the caller must get a message in both cases.
#pragma once

#include <functional>
#include <optional>
#include <string>

namespace weft::sim {

struct ProcessEnd {
  int code = 0;    // return value of `work`
  int signal = 0;  // signal that ended the process; 0: it exited by itself
};

// Calls `work` in a forked copy of this process and waits for its end. The copy runs only the
// calling thread. Its memory is its own, but it shares this process's streams.
//
// The copy dies with this process and leaves no core file. It ends without destructors or exit
// handlers, so `work` must flush its output. An exception that leaves `work` ends the copy by
// SIGABRT. After `cpu_limit` seconds of CPU time, rounded up, SIGXCPU ends it.
//
// This process calls `meanwhile` before it waits, for example to read the output of `work`. Throws
// std::runtime_error if the system cannot start a process. Costs about a millisecond.
ProcessEnd run_in_process(const std::function<int()>& work,
                          const std::function<void()>& meanwhile = {},
                          std::optional<double> cpu_limit = {});

// CPU time limit for reading a file (s). An undamaged file needs far less.
inline constexpr double reading_cpu_limit = 30;

// Returns the message for a crash: "PATH: is damaged: HDF5 crashed on reading it (Segmentation
// fault)" or, for SIGXCPU, "PATH: is damaged: HDF5 comes to no end of reading it".
std::string describe_crash(const std::string& path, int signal);

}  // namespace weft::sim
