#include "bench/child_runs.h"

#include <poll.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <vector>

namespace weft::bench {

namespace {

struct Child {
  pid_t process = 0;
  int pipe_end = 0;
  std::size_t index = 0;
  std::string result;
};

[[noreturn]] void fail(const char* call) {
  throw std::runtime_error(std::string(call) + ": " + std::strerror(errno));
}

[[noreturn]] void be_the_child(int pipe_end, double cpu_limit,
                               const std::function<std::string()>& work) {
  const auto seconds = static_cast<rlim_t>(std::ceil(cpu_limit));
  const rlimit cpu{seconds, seconds + 1}, no_core{0, 0};
  setrlimit(RLIMIT_CPU, &cpu);
  setrlimit(RLIMIT_CORE, &no_core);
  const std::string text = work();
  for (std::size_t sent = 0; sent < text.size();) {
    const ssize_t written = write(pipe_end, text.data() + sent, text.size() - sent);
    if (written <= 0) _exit(1);
    sent += static_cast<std::size_t>(written);
  }
  _exit(0);
}

Child start(std::size_t index, double cpu_limit, const std::function<std::string()>& work) {
  int ends[2];
  if (pipe(ends) != 0) fail("pipe");
  std::fflush(nullptr);
  const pid_t process = fork();
  if (process < 0) fail("fork");
  if (process == 0) {
    close(ends[0]);
    be_the_child(ends[1], cpu_limit, work);
  }
  close(ends[1]);
  return {process, ends[0], index, {}};
}

// Collects the end of a child whose pipe is closed.
ChildEnd collect(Child& child) {
  close(child.pipe_end);
  int status = 0;
  if (waitpid(child.process, &status, 0) < 0) fail("waitpid");
  ChildEnd end;
  end.is_well = WIFEXITED(status) && WEXITSTATUS(status) == 0;
  if (WIFSIGNALED(status)) end.signal = WTERMSIG(status);
  end.result = std::move(child.result);
  return end;
}

// Waits until a child writes or ends; returns the index of one that has ended, or
// `children.size()`.
std::size_t listen(std::vector<Child>& children) {
  std::vector<pollfd> pipes;
  for (const Child& child : children) pipes.push_back({child.pipe_end, POLLIN, 0});
  if (poll(pipes.data(), pipes.size(), -1) < 0 && errno != EINTR) fail("poll");
  char buffer[65536];
  for (std::size_t i = 0; i < children.size(); ++i) {
    if (pipes[i].revents == 0) continue;
    const ssize_t count = read(children[i].pipe_end, buffer, sizeof buffer);
    if (count <= 0) return i;
    children[i].result.append(buffer, static_cast<std::size_t>(count));
  }
  return children.size();
}

}  // namespace

void run_children(std::size_t count, int jobs, const std::function<double(std::size_t)>& cpu_limit,
                  const std::function<std::string(std::size_t)>& work,
                  const std::function<void(std::size_t, const ChildEnd&)>& done) {
  std::vector<Child> running;
  for (std::size_t next = 0; next < count || !running.empty();) {
    if (next < count && running.size() < static_cast<std::size_t>(jobs)) {
      running.push_back(start(next, cpu_limit(next), [&] { return work(next); }));
      ++next;
      continue;
    }
    const std::size_t ended = listen(running);
    if (ended == running.size()) continue;
    Child child = std::move(running[ended]);
    running.erase(running.begin() + static_cast<std::ptrdiff_t>(ended));
    const ChildEnd end = collect(child);
    done(child.index, end);
  }
}

}  // namespace weft::bench
