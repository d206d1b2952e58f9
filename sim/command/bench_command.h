// `weft bench`: the experiments on speed, which are a program of their own.
#pragma once

#include <string>
#include <vector>

namespace weft::sim {

// Becomes `weft-bench` with these arguments: that beside this program, as installed, or in the
// folder bench/ of the build folder. Does not return if that can be run; otherwise says why not and
// returns the exit code.
int run_bench(const std::vector<std::string>& arguments);

}  // namespace weft::sim
