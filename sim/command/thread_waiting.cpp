#include "sim/command/thread_waiting.h"

#include <omp.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>

namespace weft::sim {

void shorten_waiting(char** arguments) {
  constexpr const char* spin_count = "GOMP_SPINCOUNT";
  if (std::getenv(spin_count) != nullptr || std::getenv("OMP_WAIT_POLICY") != nullptr) return;
  if (omp_get_max_threads() == 1) return;
  // By its path, so that the process keeps its name.
  std::error_code error;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", error);
  if (!error && setenv(spin_count, "1000", 1) == 0) execv(program.c_str(), arguments);
}

}  // namespace weft::sim
