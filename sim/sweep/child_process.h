// The process of one run.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace weft::sim {

// The end of a process, with the resources it took.
struct ChildEnd {
  int exit_code = 0;  // meaningless after a signal
  int signal = 0;     // signal that ended the process, or 0
  double wall_seconds = 0, cpu_seconds = 0;
  double peak_memory = 0;  // MiB, resident
};

// A program that runs beside this process, in a process group of its own, so that Ctrl-C on the
// terminal does not reach it. It gets SIGTERM when the thread that made the object ends, and thus
// when this process ends, however that comes about. The destructor kills it.
class ChildProcess {
 public:
  struct Command {
    std::vector<std::string> words;        // program and arguments
    std::filesystem::path output, errors;  // files for standard output and standard error
    int threads = 1;                       // most threads of the program (OMP_THREAD_LIMIT)
    int inherited = -1;                    // descriptor that stays open in the program, or -1
  };
  // Starts the program. Throws FileError if the system cannot. A program that cannot be executed
  // ends with exit code 127.
  explicit ChildProcess(const Command& command);
  ~ChildProcess();
  ChildProcess(ChildProcess&& other) noexcept;
  ChildProcess& operator=(ChildProcess&&) = delete;

  // Returns the end of the process if it has ended, without waiting. Call it no more afterwards.
  std::optional<ChildEnd> poll();
  void send(int signal) const;
  double seconds() const;  // wall time since the start
  double memory() const;   // MiB, resident at present; 0 if it cannot be read

 private:
  pid_t process_;
  std::chrono::steady_clock::time_point start_;
};

}  // namespace weft::sim
