#include "sim/base/reading_process.h"

#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstring>
#include <stdexcept>

namespace weft::sim {
namespace {

// Restores the default signal handlers, which sanitizers replace: a crash must end this process by
// its signal. Also suppresses the core file, and makes this process end when its parent ends.
void prepare_to_crash(pid_t parent) {
  for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT}) std::signal(signal, SIG_DFL);
  const rlimit none{0, 0};
  setrlimit(RLIMIT_CORE, &none);
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(1);  // the parent ended before prctl()
}

void limit_cpu_time(double seconds) {
  std::signal(SIGXCPU, SIG_DFL);
  const rlim_t limit = static_cast<rlim_t>(std::ceil(seconds));
  const rlimit both{limit, limit + 1};
  setrlimit(RLIMIT_CPU, &both);
}

}  // namespace

ProcessEnd run_in_process(const std::function<int()>& work, const std::function<void()>& meanwhile,
                          std::optional<double> cpu_limit) {
#ifdef FUZZING_BUILD_MODE_UNSAFE_FOR_PRODUCTION
  // A fuzzer must see what the work reaches and where it fails.
  if (!meanwhile) return {work(), 0};
#endif
  const pid_t parent = getpid();
  const pid_t child = fork();
  if (child < 0) {
    throw std::runtime_error(std::string("cannot start a process: ") + std::strerror(errno));
  }
  if (child == 0) {
    prepare_to_crash(parent);
    if (cpu_limit) limit_cpu_time(*cpu_limit);
    int code = 0;
    try {
      code = work();
    } catch (...) {
      std::abort();
    }
    _exit(code);
  }
  if (meanwhile) meanwhile();
  int status = 0;
  while (waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) {
      throw std::runtime_error(std::string("lost a process: ") + std::strerror(errno));
    }
  }
  if (WIFSIGNALED(status)) return {0, WTERMSIG(status)};
  return {WEXITSTATUS(status), 0};
}

std::string describe_crash(const std::string& path, int signal) {
  if (signal == SIGXCPU) return path + ": is damaged: HDF5 comes to no end of reading it";
  return path + ": is damaged: HDF5 crashed on reading it (" + strsignal(signal) + ")";
}

}  // namespace weft::sim
