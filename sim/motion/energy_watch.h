// Detects motion that has more energy than was put in. Such a gain reveals steps that are too long
// and tolerances that are too loose, if the method's own error estimate misses them.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "sim/base/failure.h"
#include "sim/motion/dynamics.h"
#include "sim/motion/external_work.h"

namespace weft::sim {

// Checks that the kinetic and elastic energy E of the free particles does not exceed the energy put
// in. E leaves out forces with Force::is_constraint(). `put_in` is the energy at the start plus the
// work of gravity, of external forces and of prescribed motion (external_work.h), less the energy
// that creases have dissipated. The test compares square roots, which are norms. Their errors add:
//   sqrt(E) <= sqrt(put_in + doubt + 0.05 most) + e,
//   e = sqrt(3/2 M) velocity_tolerance + relative_tolerance sqrt(most).
// M is the total mass, and `doubt` that of ExternalWork. `most` is the larger of two energies: the
// largest `put_in` so far, and the kinetic energy at the start plus the energy of a free fall. The
// fall begins at the start and covers at most the diagonal of the box around the dynamic bodies at
// that time. If gravity varies, the fall assumes that its direction never changes. e is the error
// of sqrt(E) if every component errs by its tolerance.
//
// The energy of contact and of forces with is_constraint() counts only once it has become motion: a
// long step that ends deep within a barrier overestimates it, but most methods damp the excess.
// Equilibria are checked only under proportional loading, without prescribed motion, applied loads
// and wind that acts on a body.
class EnergyWatch {
 public:
  // `start` is the state at `start_time` (s). The dynamics must outlive the watch. Evaluates
  // contact.
  EnergyWatch(Dynamics& dynamics, std::span<const double> start, double start_time = 0);

  // Checks the state at the end of a step, whose energies are `now`. Returns the failure, if any.
  // If external().is_possible(), it must be called after every step, in order, and costs as much as
  // ExternalWork::add_step().
  [[nodiscard]] std::optional<Failure> check(double time, std::span<const double> y,
                                             const Energies& now);
  // False for scenes that are never checked. check() then costs nothing and does not read `now`.
  bool applies() const { return applies_; }
  void transfer(StateArchive& archive);
  // True if the last check found more energy than was put in, beyond a tenth of what the test
  // allows for errors.
  bool has_gain() const { return has_gain_; }
  // Returns the largest ratio so far of the energy to its limit.
  double largest_share() const { return largest_share_; }
  const ExternalWork& external() const { return external_; }

 private:
  double fall_energy(double time) const;
  double gravitational(double time, std::span<const double> y, const Energies& now) const;
  Failure failure(double time, std::span<const double> y, double within, double put_in) const;

  const Scene& scene_;
  const Dynamics& dynamics_;
  ExternalWork external_;
  bool applies_ = true;
  double start_time_ = 0;                // s
  double mass_ = 0;                      // mass of the dynamic particles (kg)
  double longest_fall_ = 0;              // longest free fall (m)
  double start_ = 0;                     // energy at the start, gravitational energy included (J)
  double start_dissipated_ = 0;          // energy that creases had dissipated at the start (J)
  double start_kinetic_ = 0, most_ = 0;  // kinetic energy at the start, and `most` (J)
  double largest_share_ = 0;
  bool has_gain_ = false;
};

}  // namespace weft::sim
