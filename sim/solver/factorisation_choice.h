// The choice between conjugate gradients and factorisation for systems that need many iterations.
#pragma once

#include <limits>

#include "sim/base/state_archive.h"

namespace weft::sim {

// A system is hard if its iterations cost more than a factorisation. After a hard system, the next
// eight systems of the same or a larger gamma are factorised. Then iterations are tried again.
// Every further hard system doubles the number of systems to factorise, up to 4096, until a system
// of the same or a larger gamma is not hard. Hard systems often come in short series, for example
// while surfaces meet (docs/decisions/0016).
class FactorisationChoice {
 public:
  // If `is_allowed` is false, no system is factorised.
  FactorisationChoice(int particle_count, bool is_allowed);

  // True if the next system, with this gamma (s), is to be factorised. The caller must then
  // factorise it, because the call counts it as factorised.
  bool next_is_factorised(double gamma);
  // Records the iterations of a system with this gamma (s). Returns true if the system is hard and
  // factorisation is allowed.
  bool takes_too_long(double gamma, int iterations);

  void transfer(StateArchive& archive) {
    archive(factorised_from_, patience_, systems_left_, hard_gamma_);
  }

 private:
  double worthwhile_iterations_;
  bool is_allowed_;
  // Smallest gamma (s) of systems to factorise.
  double factorised_from_ = std::numeric_limits<double>::infinity();
  int patience_ = 0;       // number of systems to factorise after the last hard one
  int systems_left_ = 0;   // number of these systems that are still to be factorised
  double hard_gamma_ = 0;  // gamma of the last hard system (s)
};

}  // namespace weft::sim
