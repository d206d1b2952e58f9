// The choice between conjugate gradients and factorisation for systems that need many iterations.
#pragma once

#include <limits>

#include "sim/base/state_archive.h"

namespace weft::sim {

// A system is hard if it takes more iterations than a factorisation costs. After a hard system, the
// next eight systems of the same or a larger gamma are factorised. Then iterations are tried again,
// and each failed trial doubles that number. Trials are worthwhile, because a few hard systems, for
// example while surfaces meet, do not make later ones hard (docs/decisions/0016).
class FactorisationChoice {
 public:
  // If `is_allowed` is false, no system is factorised: the case then names a preconditioner.
  FactorisationChoice(int particle_count, bool is_allowed);

  // True if the next system, with this gamma (s), is to be factorised. The caller must then do so,
  // because the call counts it.
  bool next_is_factorised(double gamma);
  // Notes the iterations of a system with this gamma (s). True if the system should have been
  // factorised.
  bool takes_too_long(double gamma, int iterations);

  void transfer(StateArchive& archive) {
    archive(factorised_from_, patience_, systems_left_, hard_gamma_);
  }

 private:
  double worthwhile_iterations_;
  bool is_allowed_;
  // Systems of this gamma (s) or a larger one are factorised.
  double factorised_from_ = std::numeric_limits<double>::infinity();
  int patience_ = 0;       // systems to factorise before the next trial of iterations
  int systems_left_ = 0;   // still to be factorised before that trial
  double hard_gamma_ = 0;  // gamma of the last hard system, s
};

}  // namespace weft::sim
