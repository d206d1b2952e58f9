// Runs work in a separate process, so that untrusted files can be read safely. HDF5 1.10 crashes on
// some damaged files and never finishes reading others. The user must get a message in both cases.
#pragma once

#include <functional>
#include <optional>
#include <string>

namespace weft::sim {

struct ProcessEnd {
  int code = 0;    // return value of `work`
  int signal = 0;  // signal that ended the process; 0 if no signal did
};

// Calls `work` in a forked copy of this process and waits until the copy ends. The copy has only
// the calling thread. It shares open files with this process, but not memory.
//
// The copy is killed when this process ends, and writes no core file. It ends without destructors
// or exit handlers, so `work` must flush its output. An uncaught exception of `work` ends the copy
// by SIGABRT. After `cpu_limit` seconds of CPU time, rounded up, SIGXCPU ends it.
//
// This process calls `meanwhile` before it waits, for example to read the output of `work`. Throws
// std::runtime_error if the system cannot start the copy or cannot wait for it. Costs about a
// millisecond. Builds for fuzzing call `work` in this process, unless there is a `meanwhile`.
ProcessEnd run_in_process(const std::function<int()>& work,
                          const std::function<void()>& meanwhile = {},
                          std::optional<double> cpu_limit = {});

// Limit of the CPU time for reading a file (s). An undamaged file needs far less.
inline constexpr double reading_cpu_limit = 30;

// Returns the message for a reading process that a signal ended. It names the path and says that
// HDF5 crashed or, for SIGXCPU, that it came to no end.
std::string describe_crash(const std::string& path, int signal);

}  // namespace weft::sim
