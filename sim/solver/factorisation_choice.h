// Which systems are factorised because conjugate gradients take too long.
#pragma once

#include <limits>

#include "sim/base/state_archive.h"

namespace weft::sim {

// Once a system takes more iterations than a factorisation is worth, systems of as long a gamma are
// factorised. Iterations are tried again after eight of these, then after twice as many each time
// that they take too long again: a few hard systems, as where surfaces meet, say nothing about
// those that follow (docs/decisions/0016).
class FactorisationChoice {
 public:
  // `is_allowed`: false if the case names a preconditioner, which is then always used.
  FactorisationChoice(int particle_count, bool is_allowed);

  // True if the next system, of this gamma (s), is to be factorised, which it then must be.
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
  int patience_ = 0;       // systems factorised before iterations are tried again
  int systems_left_ = 0;   // of these
  double hard_gamma_ = 0;  // s, of the last system that took too many iterations
};

}  // namespace weft::sim
