#include "sim/solver/factorisation_choice.h"

#include <algorithm>
#include <cmath>

namespace weft::sim {

namespace {

// Least and largest number of systems that are factorised before iterations are tried again.
constexpr int least_patience = 8, most_patience = 4096;

// Returns the number of iterations that cost as much as a factorisation. On a surface, a
// factorisation costs O(particles^1.5) and an iteration O(particles). Above some 150 000 particles
// the result exceeds the iteration limit of conjugate gradients.
double iterations_per_factorisation(int particles) { return 40 + 5 * std::sqrt(particles); }

}  // namespace

FactorisationChoice::FactorisationChoice(int particle_count, bool is_allowed)
    : worthwhile_iterations_(iterations_per_factorisation(particle_count)),
      is_allowed_(is_allowed) {}

bool FactorisationChoice::next_is_factorised(double gamma) {
  if (gamma < factorised_from_) return false;
  if (systems_left_ == 0) {
    factorised_from_ = std::numeric_limits<double>::infinity();
    return false;
  }
  --systems_left_;
  return true;
}

bool FactorisationChoice::takes_too_long(double gamma, int iterations) {
  if (iterations <= worthwhile_iterations_) {
    if (gamma >= hard_gamma_) patience_ = 0;
    return false;
  }
  if (!is_allowed_) return false;
  factorised_from_ = hard_gamma_ = gamma;
  patience_ = std::clamp(2 * patience_, least_patience, most_patience);
  systems_left_ = patience_;
  return true;
}

}  // namespace weft::sim
