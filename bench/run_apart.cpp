#include "bench/run_apart.h"

#include <malloc.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <stdexcept>

namespace weft::bench {

namespace {

// Writes the result of the work to a pipe. Does not return.
[[noreturn]] void run_child(const std::function<std::string()>& work, int pipe_end) {
  int code = 1;
  try {
    const std::string result = work();
    const auto size = static_cast<ssize_t>(result.size());
    if (write(pipe_end, result.data(), result.size()) == size) code = 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "weft bench: %s\n", error.what());
  }
  _exit(code);
}

std::string read_all(int pipe_end) {
  std::string all;
  char part[4096];
  for (ssize_t size = 0; (size = read(pipe_end, part, sizeof part)) > 0;)
    all.append(part, static_cast<std::size_t>(size));
  return all;
}

}  // namespace

ApartResult run_apart(const std::function<std::string()>& work) {
  int pipe_ends[2];
  if (pipe(pipe_ends) != 0) throw std::runtime_error("no pipe to a child process");
  std::fflush(stdout);  // the child must not print what this process has buffered
  malloc_trim(0);       // the child would count memory that this process has freed and kept
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("no child process");
  if (child == 0) run_child(work, pipe_ends[1]);
  close(pipe_ends[1]);
  ApartResult end{.result = read_all(pipe_ends[0])};
  close(pipe_ends[0]);
  int status = 0;
  rusage usage{};
  wait4(child, &status, 0, &usage);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
    throw std::runtime_error("a process that was measured ended early");
  end.peak_bytes = 1024.0 * static_cast<double>(usage.ru_maxrss);
  return end;
}

}  // namespace weft::bench
