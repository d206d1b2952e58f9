// `weft bench`: experiments on speed, run by a separate program.
#pragma once

#include <string>
#include <vector>

namespace weft::sim {

// Replaces this process by the program weft-bench with these arguments. weft-bench is looked for in
// the folder of this program and in the folder ../bench relative to it. If weft-bench cannot be
// run, prints the reason and returns an exit code.
int run_bench(const std::vector<std::string>& arguments);

}  // namespace weft::sim
