// External work on a scene: by wind, loads, moving pins and obstacles, and gravity that varies.
#pragma once

#include <span>
#include <vector>

#include "sim/base/state_archive.h"
#include "sim/motion/dynamics.h"

namespace weft::sim {

// Sums the work on the free particles, without that of constant gravity. F are the forces (without
// gravity, mass damping and drag) on particles with prescribed motion, x their positions, and P the
// power of external forces (drag and loads) on the free particles. For a step of length h from 0 to
// 1,
//   work  += -sum (F0 + F1) / 2 . (x1 - x0) + h (P0 + P1) / 2,
//   doubt += (|sum (F1 - F0) . (x1 - x0)| + h |P1 - P0|) / 2.
// If forces and power are monotonic in each step, the error of the work is at most the doubt.
// Internal damping, contact damping and friction turn some of this work into heat, which is not
// subtracted: on all particles together they only take energy, so the work is an upper bound of the
// energy that becomes motion and strain. Drag is counted on the free particles themselves, losses
// included. If wind or drag jumps between two steps, each step uses the P on its own side of the
// jump.
//
// Gravity g that varies has no potential. The energy -g . S of the present g, with S = sum m x of
// the free particles, is corrected so that gravity does the work (g0 + g1) / 2 . (S1 - S0) in a
// step:
//   work  -= S0 . (g0 - g of the last step's end) + (S0 + S1) / 2 . (g1 - g0),
//   doubt += sum over components |(g1 - g0) (S1 - S0)| / 2.
class ExternalWork {
 public:
  // `y` is the state at `time` (s). The dynamics must outlive this object.
  ExternalWork(Dynamics& dynamics, std::span<const double> y, double time = 0);
  void transfer(StateArchive& archive);

  // True if wind, loads, prescribed motion or varying gravity can do work at all. Otherwise the
  // functions below cost nothing.
  bool is_possible() const { return is_moved() || counts_external_ || gravity_varies_; }
  // Takes the step that ends at (time, y). With prescribed motion it costs an evaluation of the
  // forces, with wind one of drag. Contact is then that of y.
  void add_step(double time, std::span<const double> y);

  double work() const { return work_; }    // J
  double doubt() const { return doubt_; }  // J
  // If gravity varies: speed (m/s) that it alone gives from rest if it never turns, and its largest
  // amount (m/s^2), so far.
  double fall_speed() const { return fall_speed_; }
  double largest_gravity() const { return largest_gravity_; }
  // Energies (J) of the dynamic particles with prescribed motion, at the end of the last step.
  // Their pins supply and take these directly.
  double held_kinetic_energy() const { return held_kinetic_energy_; }
  double held_gravitational_energy() const { return held_gravitational_energy_; }

 private:
  // A particle of an obstacle and the force on it, N.
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
  // Power of external forces (W): at the end of the last step, and at the start of the next.
  double power_ = 0, next_power_ = 0;
  std::vector<double> jumps_;  // s, of curves
  bool gravity_varies_ = false;
  Vec3 gravity_{0, 0, 0}, moment_{0, 0, 0};  // m/s^2 and kg m, at the end of the last step
  double fall_speed_ = 0, largest_gravity_ = 0;
  std::vector<Vec3> force_, last_force_, place_, last_place_;  // of `moved_`
  std::vector<Vec3> all_forces_, position_, velocity_;         // of all particles
  std::vector<int> loaded_particles_;
  // Forces on the particles of obstacles that move, in order, and the poses of these.
  std::vector<Load> loads_, last_loads_;
  std::vector<RigidPose> poses_, last_poses_;
  double work_ = 0, doubt_ = 0;
  double held_kinetic_energy_ = 0, held_gravitational_energy_ = 0;
};

}  // namespace weft::sim
