#include "sim/solver/hard_systems.h"

#include <algorithm>
#include <cmath>

namespace weft::sim {

namespace {

// Least and largest number of systems before the first method is tried again.
constexpr int least_patience = 8, most_patience = 4096;

}  // namespace

double iterations_per_factorisation(int particles) { return 40 + 5 * std::sqrt(particles); }

bool HardSystems::take_hard_system(double gamma) {
  if (gamma < hard_from_) return false;
  if (systems_left_ == 0) {
    hard_from_ = std::numeric_limits<double>::infinity();
    return false;
  }
  --systems_left_;
  return true;
}

bool HardSystems::record(double gamma, int iterations) {
  if (iterations <= worthwhile_iterations_) {
    if (gamma >= hard_gamma_) patience_ = 0;
    return false;
  }
  if (!is_allowed_) return false;
  hard_from_ = hard_gamma_ = gamma;
  patience_ = std::clamp(2 * patience_, least_patience, most_patience);
  systems_left_ = patience_;
  return true;
}

}  // namespace weft::sim
