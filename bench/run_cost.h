// Time and memory of the first steps of a run, measured in a process of its own.
#pragma once

#include "sim/case/case.h"

namespace weft::bench {

struct RunCost {
  int vertices = 0;              // dynamic particles
  int steps = 0;                 // taken; fewer than requested if one failed
  double cpu = 0;                // s, median step
  double linear_iterations = 0;  // per step
  double linear_solves = 0;      // Newton iterations per step, each with a linear solve
  double peak_bytes = 0;         // largest resident memory of the process

  // Returns 0 if nothing was solved, as with explicit methods.
  double iterations_per_solve() const {
    return linear_solves > 0 ? linear_iterations / linear_solves : 0;
  }
};

// Runs `steps` steps of the case in a child process, whose peak memory is then that of this run.
// The message of a step that fails goes to stderr. Throws std::runtime_error if the child ends
// early.
RunCost cost_of_run(const sim::Case& source, int steps);

// Returns the case with an image of n x n vertices for its first body.
sim::Case with_image(sim::Case source, int n);

// Image of n x n vertices whose memory is that of the program alone.
inline constexpr int tiny_image = 5;

}  // namespace weft::bench
