// The failure of a step, a frame or a run, as data.
#pragma once

#include <string>

namespace weft::sim {

struct Failure {
  enum class Kind {
    error_tolerance,    // no step is short enough for the error test
    newton,             // Newton iteration or equilibrium search does not converge
    surfaces,           // no step or frame keeps surfaces apart
    not_finite,         // forces or positions are not finite numbers
    unstable,           // explicit steps are too long
    too_many_cuts,      // steps are cut again and again to keep surfaces apart
    strain_limit,       // no step keeps membranes within their strain_limit
    prescribed_motion,  // prescribed motion is too fast, or makes surfaces cross
    energy,             // the motion has more energy than was put in
    cpu_limit,          // compute.cpu_limit is reached
    interrupted,        // a user or another program has stopped the run
    solver              // a solver, such as SUNDIALS, has failed for another reason
  };
  Kind kind = Kind::solver;
  double time = 0;    // simulated time of the failure, s
  int particle = -1;  // particle at which the failure arose; -1 if there is none
  std::string text;   // message for the user
};

// Returns the name of the enumerator, for example "newton".
const char* kind_name(Failure::Kind kind);

}  // namespace weft::sim
