// Access to the vectors and counters of SUNDIALS.
#pragma once

#include <nvector/nvector_serial.h>

#include <limits>
#include <span>

#include "sim/motion/dynamics.h"
#include "sim/motion/tolerances.h"

namespace weft::sim {

// Returns a view of the entries of a serial vector.
inline std::span<double> values(N_Vector v) {
  return {NV_DATA_S(v), static_cast<std::size_t>(NV_LENGTH_S(v))};
}

// Returns a counter of a solver, read by a function such as CVodeGetNumSteps.
inline long counter_of(void* solver, int (*get)(void*, long*)) {
  long value = 0;
  get(solver, &value);
  return value;
}

// Tells contact about the first iterate of each attempt to solve a step or stage. Those of the same
// attempt are at the same time, and different attempts at different times. (The iteration counter
// of SUNNonlinearSolver is that of the attempt before until the first evaluation has been made.)
class NewtonAttempts {
 public:
  // To be called before each evaluation of the forces at time t (s) in a Newton iteration.
  void note_iterate(double t, Dynamics& dynamics) {
    if (t != time_ && dynamics.contact() != nullptr) dynamics.contact()->begin_newton();
    time_ = t;
  }

 private:
  double time_ = std::numeric_limits<double>::quiet_NaN();  // s, of the last evaluation
};

// Returns the particle with the largest weighted local error in the last trial of a solver whose
// state is `y`. `get_errors` and `get_weights` are functions of that solver, such as
// CVodeGetErrWeights.
inline int worst_particle(void* solver, N_Vector y, int (*get_errors)(void*, N_Vector),
                          int (*get_weights)(void*, N_Vector)) {
  N_Vector error = N_VClone(y), weight = N_VClone(y);
  get_errors(solver, error);
  get_weights(solver, weight);
  const int worst = worst_particle(values(error), values(weight));
  N_VDestroy(error);
  N_VDestroy(weight);
  return worst;
}

}  // namespace weft::sim
