#include "sim/command/bench_command.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <iostream>

#include "sim/command/run_command.h"

namespace weft::sim {

namespace {

std::vector<std::filesystem::path> places() {
  std::error_code failure;
  const auto folder = std::filesystem::read_symlink("/proc/self/exe", failure).parent_path();
  return {folder / "weft-bench", folder.parent_path() / "bench" / "weft-bench"};
}

}  // namespace

int run_bench(const std::vector<std::string>& arguments) {
  for (const std::filesystem::path& place : places()) {
    if (access(place.c_str(), X_OK) != 0) continue;
    std::vector<char*> words{const_cast<char*>(place.c_str())};
    for (const std::string& argument : arguments)
      words.push_back(const_cast<char*>(argument.c_str()));
    words.push_back(nullptr);
    execv(place.c_str(), words.data());
    std::cerr << place.string() << ": cannot be run: " << std::strerror(errno) << '\n';
    return exit_code::input_output;
  }
  std::cerr << "weft bench: weft-bench is neither beside weft nor in the build folder; it is built "
               "with WEFT_BUILD_BENCH=ON: ninja -C build/release weft_bench\n";
  return exit_code::input_output;
}

}  // namespace weft::sim
