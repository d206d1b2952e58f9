// External work on a scene: the work of wind, loads, moving pins, moving obstacles and varying
// gravity.
#pragma once

#include <span>
#include <vector>

#include "sim/base/state_archive.h"
#include "sim/motion/dynamics.h"

namespace weft::sim {

// Sums the work (J) on the free particles, except for the work of constant gravity. F are the
// forces on particles with prescribed motion, without gravity, mass damping and external forces. x
// are the positions of these particles. P is the power of the external forces (drag and loads) on
// the free particles, plus the power that moving clamps, supports and ties supply. A step of length
// h from state 0 to state 1 adds
//   work  += -sum (F0 + F1) / 2 . (x1 - x0) + h (P0 + P1) / 2,
//   doubt += (|sum (F1 - F0) . (x1 - x0)| + h |P1 - P0|) / 2.
// The error of `work` is at most `doubt` if, within each step, P and the sum of F . (x1 - x0) are
// monotonic and x moves on straight lines. Heat from internal damping, contact damping and friction
// is not subtracted. Apart from its error, `work` is therefore an upper bound of the energy that
// becomes motion and strain. P already includes the losses by drag. If wind, drag or a load jumps
// between two steps, each step uses the value of P on its own side of the jump.
//
// A given number of corrections leaves errors in the forces at the end of a step: seams that close
// may push there, after they have pulled all the way. With time.newton, h times the power that they
// then seem to take is added to `doubt`.
//
// If the velocity of sliding supports jumps, `work` also has the kinetic energy that the particles
// gain by Dynamics::match_supports(). Losses are left out, so that `work` stays an upper bound.
//
// A varying gravity g has no potential. EnergyWatch uses the energy -g . S with the present g,
// where S = sum m x over the free particles. Corrections make the work of gravity in a step (g0 +
// g1) / 2 . (S1 - S0):
//   work  -= S0 . (g0 - g of the last step's end) + (S0 + S1) / 2 . (g1 - g0),
//   doubt += sum over components |(g1 - g0) (S1 - S0)| / 2.
class ExternalWork {
 public:
  // `y` is the state at `time` (s). The dynamics must outlive this object.
  ExternalWork(Dynamics& dynamics, std::span<const double> y, double time = 0);
  void transfer(StateArchive& archive);

  // True if wind, loads, prescribed motion or varying gravity can do work. Otherwise add_step()
  // costs nothing.
  bool is_possible() const { return is_moved() || counts_external_ || gravity_varies_; }
  // Adds the work of the step that ends at (time, y). Steps must be added in order. With prescribed
  // motion it costs one evaluation of the forces and leaves contact evaluated at y. With wind or
  // loads it costs one evaluation of the external forces, or two at a jump.
  void add_step(double time, std::span<const double> y);

  double work() const { return work_; }    // J
  double doubt() const { return doubt_; }  // J
  // Returns the speed (m/s) of a fall from rest until now, if the direction of a varying gravity
  // never changed.
  double fall_speed() const { return fall_speed_; }
  // Returns the largest magnitude (m/s^2) of a varying gravity until now.
  double largest_gravity() const { return largest_gravity_; }
  // held_kinetic_energy() and held_gravitational_energy() are energies (J) of the dynamic particles
  // with prescribed motion, at the end of the last step. Pins supply and absorb these energies
  // directly.
  double held_kinetic_energy() const { return held_kinetic_energy_; }
  double held_gravitational_energy() const { return held_gravitational_energy_; }

 private:
  // A particle of an obstacle, and the force (N) on it.
  struct Load {
    int particle = 0;
    Vec3 force{0, 0, 0};
  };
  bool is_moved() const { return !moved_.empty() || obstacles_move_; }
  void measure(double time, std::span<const double> y);
  double power_after_jump(double time, std::span<const double> y);
  void add_gravity(double start, double time, std::span<const double> y);
  Vec3 free_moment(std::span<const double> y) const;
  template <class Visit>
  void visit_loads(const Visit& visit) const;

  Dynamics& dynamics_;
  std::vector<int> moved_;  // dynamic particles with prescribed motion
  bool obstacles_move_ = false;
  bool counts_external_ = false;
  double time_ = 0;
  // Power of external forces (W): at the end of the last step, and at the start of the next step.
  double power_ = 0, next_power_ = 0;
  std::vector<double> jumps_;  // times at which curves jump (s)
  bool gravity_varies_ = false;
  Vec3 gravity_{0, 0, 0}, moment_{0, 0, 0};  // g (m/s^2) and S (kg m) at the end of the last step
  double fall_speed_ = 0, largest_gravity_ = 0;
  std::vector<Vec3> force_, last_force_, place_, last_place_;  // forces and positions of `moved_`
  std::vector<Vec3> all_forces_, position_, velocity_;         // scratch for all particles
  std::vector<int> loaded_particles_;
  // Forces on particles of obstacles, in the order of particles: at the end and at the start of the
  // step.
  std::vector<Load> loads_, last_loads_;
  // Poses of moving obstacles, at the end and at the start of the step.
  std::vector<RigidPose> poses_, last_poses_;
  double work_ = 0, doubt_ = 0;
  double held_kinetic_energy_ = 0, held_gravitational_energy_ = 0;
};

}  // namespace weft::sim
