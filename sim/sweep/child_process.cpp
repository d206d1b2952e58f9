#include "sim/sweep/child_process.h"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <fstream>
#include <utility>

#include "sim/base/file_error.h"

namespace weft::sim {

namespace {

constexpr double mebibyte = 1024.0 * 1024.0;

double seconds_of(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

bool redirect(const char* path, int stream, int flags = O_WRONLY | O_CREAT | O_TRUNC) {
  const int file = open(path, flags, 0644);
  return file >= 0 && dup2(file, stream) == stream && close(file) == 0;
}

// Turns a copy of this process into the program. Calls only functions that are safe after fork().
[[noreturn]] void become(const ChildProcess::Command& command, char* const* words,
                         char* const* environment, pid_t parent) {
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) _exit(127);  // the parent ended before prctl()
  for (const int signal : {SIGINT, SIGTERM, SIGUSR1, SIGCHLD, SIGPIPE})
    std::signal(signal, SIG_DFL);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  if (command.inherited >= 0) fcntl(command.inherited, F_SETFD, 0);
  const bool ready = redirect("/dev/null", STDIN_FILENO, O_RDONLY) &&
                     redirect(command.output.c_str(), STDOUT_FILENO) &&
                     redirect(command.errors.c_str(), STDERR_FILENO);
  if (ready) execve(words[0], words, environment);
  _exit(127);
}

// Returns the environment of this process with another number of threads.
std::vector<std::string> environment_with(int threads) {
  std::vector<std::string> all;
  for (char** each = environ; *each != nullptr; ++each) {
    if (!std::string(*each).starts_with("OMP_THREAD_LIMIT=")) all.emplace_back(*each);
  }
  all.push_back("OMP_THREAD_LIMIT=" + std::to_string(threads));
  return all;
}

std::vector<char*> pointers_to(std::vector<std::string>& texts) {
  std::vector<char*> pointers;
  for (std::string& text : texts) pointers.push_back(text.data());
  pointers.push_back(nullptr);
  return pointers;
}

}  // namespace

ChildProcess::ChildProcess(const Command& command)
    : process_(-1), start_(std::chrono::steady_clock::now()) {
  std::vector<std::string> words = command.words;
  std::vector<std::string> environment = environment_with(command.threads);
  const std::vector<char*> word_pointers = pointers_to(words);
  const std::vector<char*> environment_pointers = pointers_to(environment);
  const pid_t parent = getpid();
  process_ = fork();
  if (process_ == 0) become(command, word_pointers.data(), environment_pointers.data(), parent);
  if (process_ < 0) throw FileError(words[0] + ": cannot start a process: " + std::strerror(errno));
}

ChildProcess::ChildProcess(ChildProcess&& other) noexcept
    : process_(std::exchange(other.process_, -1)), start_(other.start_) {}

ChildProcess::~ChildProcess() {
  if (process_ <= 0) return;
  kill(process_, SIGKILL);
  while (waitpid(process_, nullptr, 0) < 0 && errno == EINTR) continue;
}

std::optional<ChildEnd> ChildProcess::poll() {
  int status = 0;
  rusage usage{};
  if (wait4(process_, &status, WNOHANG, &usage) != process_) return std::nullopt;
  process_ = -1;
  ChildEnd end;
  if (WIFSIGNALED(status)) {
    end.signal = WTERMSIG(status);
  } else {
    end.exit_code = WEXITSTATUS(status);
  }
  end.wall_seconds = seconds();
  end.cpu_seconds = seconds_of(usage.ru_utime) + seconds_of(usage.ru_stime);
  end.peak_memory = static_cast<double>(usage.ru_maxrss) / 1024;
  return end;
}

void ChildProcess::send(int signal) const {
  if (process_ > 0) kill(process_, signal);
}

double ChildProcess::seconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

double ChildProcess::memory() const {
  std::ifstream file("/proc/" + std::to_string(process_) + "/statm");
  double total = 0, resident = 0;
  if (!(file >> total >> resident)) return 0;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / mebibyte;
}

}  // namespace weft::sim
