#include "bench/timed_command.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>
#include <system_error>

namespace weft::bench {

namespace {

double seconds_of(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

[[noreturn]] void be_the_command(const std::vector<std::string>& words, const std::string& folder) {
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  if (chdir(folder.c_str()) != 0) _exit(126);
  const int file = open("output.txt", O_WRONLY | O_CREAT | O_TRUNC, 0600);
  if (file < 0 || dup2(file, STDOUT_FILENO) < 0 || dup2(file, STDERR_FILENO) < 0) _exit(126);
  setenv("OMP_NUM_THREADS", "1", 1);
  execvp(arguments[0], arguments.data());
  _exit(127);
}

}  // namespace

TimedCommand run_command(const std::vector<std::string>& words, const std::string& folder) {
  const pid_t process = fork();
  if (process < 0) throw std::system_error(errno, std::generic_category(), "fork");
  if (process == 0) be_the_command(words, folder);
  int status = 0;
  rusage usage{};
  while (wait4(process, &status, 0, &usage) < 0) {
    if (errno != EINTR) throw std::system_error(errno, std::generic_category(), "wait4");
  }
  std::ifstream file(folder + "/output.txt");
  return {.is_well = WIFEXITED(status) && WEXITSTATUS(status) == 0,
          .cpu_s = seconds_of(usage.ru_utime) + seconds_of(usage.ru_stime),
          .output = {std::istreambuf_iterator<char>(file), {}}};
}

std::string weft_command() {
  const auto folder = std::filesystem::read_symlink("/proc/self/exe").parent_path();
  const std::filesystem::path places[] = {folder / "weft", folder.parent_path() / "sim" / "weft"};
  for (const std::filesystem::path& place : places) {
    if (access(place.c_str(), X_OK) == 0) return place.string();
  }
  throw std::runtime_error("weft is neither beside weft-bench nor in the build folder");
}

bool is_installed(const std::string& program) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path == nullptr ? "" : path);
  for (std::string folder; std::getline(folders, folder, ':');) {
    if (access((folder + '/' + program).c_str(), X_OK) == 0) return true;
  }
  return false;
}

}  // namespace weft::bench
