#include "sim/command/thread_waiting.h"

#include <unistd.h>

#include <cstdlib>
#include <filesystem>

namespace weft::sim {

void shorten_waiting(char** arguments) {
  constexpr const char* spin_count = "GOMP_SPINCOUNT";
  if (std::getenv(spin_count) != nullptr || std::getenv("OMP_WAIT_POLICY") != nullptr) return;
  // By its path, so that the process keeps its name.
  std::error_code error;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", error);
  if (!error && setenv(spin_count, "1000", 1) == 0) execv(program.c_str(), arguments);
}

}  // namespace weft::sim
