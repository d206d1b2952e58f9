// A step, a frame or a run that failed, as data.
#pragma once

#include <string>

namespace weft::sim {

struct Failure {
  enum class Kind {
    error_tolerance,    // no step is short enough for the error test
    newton,             // the Newton iteration, or the search for an equilibrium, does not converge
    surfaces,           // no step, or no frame, keeps surfaces apart
    not_finite,         // forces or positions are not finite numbers
    unstable,           // explicit steps are too long
    too_many_cuts,      // steps are cut again and again to keep surfaces apart
    prescribed_motion,  // it is too fast, or leaves no room
    energy,             // the motion has gained energy
    cpu_limit,          // compute.cpu_limit is reached
    interrupted,        // stopped from outside
    solver              // SUNDIALS, or a search for eigenvalues, stopped for another reason
  };
  Kind kind = Kind::solver;
  double time = 0;    // s
  int particle = -1;  // where it happened (Scene::describe_particle); -1: no single place
  std::string text;   // kind, place and time in words
};

// The kind as `reason_kind` of --json: "error_tolerance", "newton" ...
const char* kind_name(Failure::Kind kind);

}  // namespace weft::sim
