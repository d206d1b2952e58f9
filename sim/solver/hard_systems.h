// The choice of a more expensive method for systems that need many iterations.
#pragma once

#include <limits>

#include "sim/base/state_archive.h"

namespace weft::sim {

// The choice between two methods of solution: iterations of a cheap one, and one that is worthwhile
// only for systems of many iterations. A system is hard if its iterations cost more than the second
// method. After a hard system, the next eight systems of the same or a larger gamma take the second
// method. Then the first one is tried again. Every further hard system doubles this number, up to
// 4096, until a system of the same or a larger gamma is not hard. Hard systems often come in short
// series, for example while surfaces meet (docs/decisions/0016).
class HardSystems {
 public:
  // A system of more than `worthwhile_iterations` is hard. If `is_allowed` is false, none is.
  HardSystems(double worthwhile_iterations, bool is_allowed)
      : worthwhile_iterations_(worthwhile_iterations), is_allowed_(is_allowed) {}

  // Takes the next system, with this gamma (s), out of those that the second method solves. Returns
  // false if the first method solves it.
  bool take_hard_system(double gamma);
  // Records the iterations of a system with this gamma (s). Returns true if the system is hard.
  bool record(double gamma, int iterations);
  // True if a system of so many iterations is hard.
  bool would_be_hard(int iterations) const {
    return is_allowed_ && iterations > worthwhile_iterations_;
  }

  void transfer(StateArchive& archive) {
    archive(hard_from_, patience_, systems_left_, hard_gamma_);
  }

 private:
  double worthwhile_iterations_;
  bool is_allowed_;
  // Smallest gamma (s) of systems that take the second method.
  double hard_from_ = std::numeric_limits<double>::infinity();
  int patience_ = 0;       // number of systems that take the second method after a hard one
  int systems_left_ = 0;   // number of these systems that are still to come
  double hard_gamma_ = 0;  // gamma of the last hard system (s)
};

// Returns the number of iterations that cost as much as a sparse factorisation. On a surface, a
// factorisation costs O(particles^1.5) and an iteration O(particles). Above some 150 000 particles
// the result exceeds the iteration limit of conjugate gradients.
double iterations_per_factorisation(int particles);

}  // namespace weft::sim
