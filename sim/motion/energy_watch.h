// Detects motion with more energy than was put in. Too long a step, or too loose a tolerance, shows
// in this way if the method itself does not notice it.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "sim/base/failure.h"
#include "sim/motion/dynamics.h"
#include "sim/motion/external_work.h"

namespace weft::sim {

// Checks that the kinetic and elastic energy E of the free particles does not exceed the energy put
// in: that of the start, the work of gravity, and that of wind and prescribed motion
// (external_work.h), less what creases have dissipated. The test uses square roots, which are
// norms, so that errors add up:
//   sqrt(E) <= sqrt(put_in + doubt + 0.05 most) + e,
//   e = sqrt(3/2 M) velocity_tolerance + relative_tolerance sqrt(most),
// with the total mass M and the doubt about that work. `most` is the largest energy put in so far,
// or the kinetic energy of the start plus that of a fall, if this is more. The fall is by gravity
// for the time so far (if gravity varies, as if it never turned), or by the diagonal of the box
// around the dynamic bodies' start, whichever is less. e is the error of the tolerance in every
// component.
//
// The energy of contact counts once it has become motion. A long step that ends deep within the
// range of contact has too much of it, and most methods damp that. Equilibria (`static`) with wind
// or prescribed motion are not checked.
class EnergyWatch {
 public:
  // `start` is the state at `start_time` (s). The dynamics must outlive the watch. Evaluates
  // contact.
  EnergyWatch(Dynamics& dynamics, std::span<const double> start, double start_time = 0);

  // Judges the state at the end of a step, with the energies `now`; returns the failure, if any. If
  // external().is_possible(), every step must be passed, in order, and the check evaluates forces.
  [[nodiscard]] std::optional<Failure> check(double time, std::span<const double> y,
                                             const Energies& now);
  // False for scenes that are never judged; check() then costs nothing and needs no energies.
  bool applies() const { return applies_; }
  void transfer(StateArchive& archive);
  // Largest energy so far, as a share of the limit.
  double largest_share() const { return largest_share_; }
  const ExternalWork& external() const { return external_; }

 private:
  double fall_energy(double time) const;
  Failure failure(double time, std::span<const double> y, double within, double put_in) const;

  const Scene& scene_;
  ExternalWork external_;
  bool applies_ = true;
  double start_time_ = 0;                // s
  double mass_ = 0;                      // kg, of the dynamic particles
  double longest_fall_ = 0;              // m
  double start_ = 0;                     // J, including that of gravity
  double start_dissipated_ = 0;          // J
  double start_kinetic_ = 0, most_ = 0;  // J
  double largest_share_ = 0;
};

}  // namespace weft::sim
