// `weft bench`: experiments on speed, run by a separate program.
#pragma once

#include <string>
#include <vector>

namespace weft::sim {

// Replaces this process by `weft-bench` with these arguments. The program is looked for beside this
// one, as installed, and in the folder bench/ of the build folder. If it cannot be run, prints the
// reason and returns the exit code.
int run_bench(const std::vector<std::string>& arguments);

}  // namespace weft::sim
