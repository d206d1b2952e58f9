// Finds motion that has more energy than anything put in: what a step that is too long, or a
// tolerance that is too loose, looks like when the method itself does not notice.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "sim/base/failure.h"
#include "sim/motion/dynamics.h"
#include "sim/motion/external_work.h"

namespace weft::sim {

// Kinetic and elastic energy of the free particles are together not above what was put in: the
// energy of the start, the work of gravity and that of wind and of prescribed motion
// (external_work.h). In a norm, so that errors add up:
//   sqrt(E) <= sqrt(put in + doubt + 5 % of the most that was in, or a fall would put in) + e,
//   e = sqrt(3/2 M) velocity_tolerance + relative_tolerance sqrt(most),
// with the total mass M and the doubt about that work. The fall is by gravity for the time so far
// or by the diagonal of the box around the start of the dynamic bodies, whichever is less. e is the
// error of the tolerance in every component. The energy of contact counts when it has become
// motion: a long step that ends deep within the range of contact has too much of it, and most
// methods damp that. Equilibria (`static`) beside wind or prescribed motion are not checked.
class EnergyWatch {
 public:
  // `start`: the state at `start_time` (s). The dynamics must outlive it. Evaluates contact.
  EnergyWatch(Dynamics& dynamics, std::span<const double> start, double start_time = 0);

  // Judges the state at the end of a step, with the energies `now`: nothing, or what is wrong.
  // Every step must be shown, in order. Beside wind or prescribed motion it evaluates forces.
  [[nodiscard]] std::optional<Failure> check(double time, std::span<const double> y,
                                             const Energies& now);
  // False for what is never judged; check() then costs nothing and needs no energies.
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
  double start_ = 0;                     // J, with that of gravity
  double start_kinetic_ = 0, most_ = 0;  // J
  double largest_share_ = 0;
};

}  // namespace weft::sim
