// `weft bench`: the experiments on speed, which are a separate program.
#pragma once

#include <string>
#include <vector>

namespace weft::sim {

// Replaces this process by `weft-bench` with these arguments. The program lies beside this one, as
// installed, or in the folder bench/ of the build folder. Returns only if it cannot be run: reports
// the reason and returns the exit code.
int run_bench(const std::vector<std::string>& arguments);

}  // namespace weft::sim
