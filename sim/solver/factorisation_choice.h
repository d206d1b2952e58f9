// The choice of the systems that are factorised because conjugate gradients take too long.
#pragma once

#include <limits>

#include "sim/base/state_archive.h"

namespace weft::sim {

// Once a system takes more iterations than a factorisation costs, systems of the same or a longer
// gamma are factorised. After eight of them iterations are tried again. Each failed trial doubles
// that number. A few hard systems, for example while surfaces meet, do not make later ones hard
// (docs/decisions/0016).
class FactorisationChoice {
 public:
  // `is_allowed` is false if the case names a preconditioner, which is then always used.
  FactorisationChoice(int particle_count, bool is_allowed);

  // True if the next system, of this gamma (s), is to be factorised. The caller must then do so.
  bool next_is_factorised(double gamma);
  // Notes the iterations that a system of this gamma took. True if it should have been factorised.
  bool takes_too_long(double gamma, int iterations);

  void transfer(StateArchive& archive) {
    archive(factorised_from_, patience_, systems_left_, hard_gamma_);
  }

 private:
  double worthwhile_iterations_;
  bool is_allowed_;
  double factorised_from_ = std::numeric_limits<double>::infinity();  // gamma, s
  int patience_ = 0;       // systems factorised before the next trial of iterations
  int systems_left_ = 0;   // until the next trial of iterations
  double hard_gamma_ = 0;  // s, of the last system that took too many iterations
};

}  // namespace weft::sim
