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
    prescribed_motion,  // prescribed motion is too fast, or leaves no room for a body
    energy,             // the motion has gained energy
    cpu_limit,          // compute.cpu_limit is reached
    interrupted,        // a user or another program has stopped the run
    solver              // SUNDIALS stopped for another reason
  };
  Kind kind = Kind::solver;
  double time = 0;    // s
  int particle = -1;  // where the failure arose (Scene::describe_particle); -1: no single place
  std::string text;   // message for the user: kind and, if known, place and time
};

// Returns the kind as --json writes it in `reason_kind`: "error_tolerance", "newton" ...
const char* kind_name(Failure::Kind kind);

}  // namespace weft::sim
