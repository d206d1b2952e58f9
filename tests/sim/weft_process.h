// Runs the built weft command in a separate folder.
#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "tests/temporary_folder.h"

namespace weft::sim {

inline std::string read_bytes(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  EXPECT_TRUE(file) << path;
  return {std::istreambuf_iterator<char>(file), {}};
}

// Returns the file of that name in the folder of a process in /proc, or an empty text if the
// process has ended. Reading fails where it ends after the file was opened: streams take that for
// the end of the file, but their buffers, which an istreambuf_iterator reads, throw.
inline std::string read_process_file(pid_t process, const std::string& name) {
  const std::ifstream file("/proc/" + std::to_string(process) + "/" + name, std::ios::binary);
  std::ostringstream bytes;
  bytes << file.rdbuf();
  return bytes.str();
}

// Returns the numbers of the processes whose arguments contain `text`. The text must have the
// folder of the test: other tests run the command at the same time.
inline std::vector<pid_t> processes_with(const std::string& text) {
  std::vector<pid_t> found;
  for (const std::filesystem::directory_entry& entry :
       std::filesystem::directory_iterator("/proc")) {
    const std::string name = entry.path().filename().string();
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    const pid_t process = std::stoi(name);
    if (read_process_file(process, "cmdline").find(text) != std::string::npos)
      found.push_back(process);
  }
  return found;
}

// A process whose streams go to files. If it still runs at the end, it is killed.
class WeftProcess {
 public:
  using Arguments = std::vector<std::string>;

  // `prepare` runs in the new process, in `folder`, before the command.
  WeftProcess(const std::filesystem::path& folder, const Arguments& arguments,
              const std::function<void()>& prepare = {})
      : out_(folder / "stdout.txt"), err_(folder / "stderr.txt"), process_(fork()) {
    if (process_ != 0) return;
    const bool ready = redirect(out_, STDOUT_FILENO) && redirect(err_, STDERR_FILENO) &&
                       chdir(folder.c_str()) == 0;
    if (!ready) _exit(126);
    if (prepare) prepare();
    std::vector<char*> words{const_cast<char*>(WEFT_COMMAND)};
    for (const std::string& argument : arguments) {
      words.push_back(const_cast<char*>(argument.c_str()));
    }
    words.push_back(nullptr);
    execv(WEFT_COMMAND, words.data());
    _exit(127);
  }
  ~WeftProcess() {
    if (process_ > 0) {
      kill(process_, SIGKILL);
      waitpid(process_, nullptr, 0);
    }
  }
  WeftProcess(const WeftProcess&) = delete;
  WeftProcess& operator=(const WeftProcess&) = delete;

  void send(int signal) const { kill(process_, signal); }

  // The exit code, or minus the signal that ended it.
  int wait() {
    int status = 0;
    waitpid(process_, &status, 0);
    process_ = 0;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }

  // The environment that the running program was started with.
  std::string environment() const { return read_process_file(process_, "environ"); }
  std::string out() const { return read_bytes(out_); }
  std::string err() const { return read_bytes(err_); }

 private:
  static bool redirect(const std::filesystem::path& path, int stream) {
    const int file = open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    return file >= 0 && dup2(file, stream) == stream && close(file) == 0;
  }

  std::filesystem::path out_, err_;
  pid_t process_;
};

class WeftCommand : public testing::Test {
 protected:
  struct Result {
    int code = 0;
    std::string out, err;
  };

  const std::filesystem::path& folder() const { return folder_.path(); }
  std::filesystem::path path(const std::string& name) const { return folder_.path(name); }
  bool exists(const std::string& name) const { return std::filesystem::exists(path(name)); }
  void write(const std::string& name, const std::string& text) const { folder_.write(name, text); }

  Result weft(const WeftProcess::Arguments& arguments,
              const std::function<void()>& prepare = {}) const {
    WeftProcess process(folder(), arguments, prepare);
    const int code = process.wait();
    return {code, process.out(), process.err()};
  }

  // Waits for a run's file. A run gives it its final name once the file can be read and signals are
  // caught.
  void wait_for_file(const std::string& name) const {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(30);
    while (!exists(name)) {
      ASSERT_LT(std::chrono::steady_clock::now(), end) << name << " is not made";
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }

 private:
  TemporaryFolder folder_;
};

}  // namespace weft::sim
