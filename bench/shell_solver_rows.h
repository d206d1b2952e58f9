// Rows of `weft bench shells` about the linear solver: iterations and memory of a shell against the
// size of its image.
#pragma once

#include <functional>
#include <vector>

#include "bench/check_row.h"

namespace weft::bench {

// Name of these rows among those that --cases lists.
inline constexpr const char* shell_solver = "solver";

// Takes steps of Euler's method with a swinging steel plate of 17^2 to 129^2 control points. The
// rows "multigrid iterations" hold the linear iterations per solve, which may differ by half from
// those at 17^2. The rows "memory per vertex" hold the peak memory (kB) and have no limit. Calls
// `done` with each row; their CPU time is that of a step. CPU time: about ten seconds.
void shell_solver_rows(const std::function<void(const CheckRow&)>& done);

}  // namespace weft::bench
