// Counts the work of an integration instead of timing it, so that choices based on work are the
// same on every machine.
#pragma once

#include "sim/motion/dynamics.h"

namespace weft::sim {

// Work of one assembly of the matrices, in the unit of work_of().
inline constexpr double assembly_work = 5;
// Returns the work of a run so far. The unit is an iteration of conjugate gradients with
// block-Jacobi, without contact, at 33^2 vertices. Iterations with multigrid count as one too,
// although they take up to four times as long.
inline double work_of(const Dynamics& dynamics, std::int64_t linear_iterations) {
  const Counters& counters = dynamics.statistics().counters;
  return static_cast<double>(linear_iterations) +
         assembly_work * static_cast<double>(counters.matrix_assemblies) +
         dynamics.evaluation_work() * static_cast<double>(counters.force_evaluations);
}

}  // namespace weft::sim
