// Finds motion that has more energy than anything put in: what a step that is too long, or a
// tolerance that is too loose, looks like when the method itself does not notice.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "sim/integrator/dynamics.h"

namespace weft::sim {

// Kinetic and elastic energy are together not above what was put in, the energy of the start and
// the work of gravity; in a norm, so that errors add up:
//   sqrt(E) <= sqrt(put in + 5 % of the most that was in, or a fall would put in) + e,
//   e = sqrt(3/2 M) velocity_tolerance + relative_tolerance sqrt(most),
// with the total mass M. The fall is by gravity for the duration of the case or by the diagonal of
// the box around the start of the dynamic bodies, whichever is less. e is the error of the
// tolerance in every component. The energy of contact counts when it has become motion: a long step
// that ends deep within the range of contact has too much of it, and most methods damp that.
// Wind, and pins or obstacles that move, do work that this does not know: scenes with them are not
// checked.
class EnergyWatch {
 public:
  // `start`: the energies of the initial state. The scene must outlive it.
  EnergyWatch(const Scene& scene, const Energies& start);

  // Of a state with the energies `now`: nothing, or what is wrong.
  [[nodiscard]] std::optional<std::string> check(double time, std::span<const double> y,
                                                 const Energies& now);
  // Largest energy so far, as a share of the limit.
  double largest_share() const { return largest_share_; }

 private:
  std::string describe(double time, std::span<const double> y, double within, double put_in) const;

  const Scene& scene_;
  bool applies_ = true;
  double mass_ = 0;   // kg, of the dynamic particles
  double start_ = 0;  // J, with that of gravity
  double most_ = 0;   // J
  double largest_share_ = 0;
};

}  // namespace weft::sim
