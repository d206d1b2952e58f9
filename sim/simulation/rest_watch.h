// Detects bodies that have come to rest.
#pragma once

#include <span>
#include <vector>

#include "sim/base/state_archive.h"
#include "sim/scene/scene.h"

namespace weft::sim {

// Watches each body over a window of at least half a second. The body is at rest if, since the
// window's start, all its vertices have been slower than the velocity tolerance. In addition, none
// may have been farther from its place at that start than
//
//   position_tolerance * window / (time left until time.duration, at least the window).
//
// A body that continued at that pace until the end would move by less than position_tolerance.
//
// States are checked at most sixteen times per window. A check costs O(vertices of the bodies that
// are checked).
class RestWatch {
 public:
  static constexpr double window = 0.5;  // s

  // Begins the window of each body at `time` (s) in the state `y` (StateView,
  // sim/motion/dynamics.h). The scene must outlive this object.
  RestWatch(const Scene& scene, double time, std::span<const double> y);

  bool is_due(double time) const { return time >= last_look_ + window / 16; }
  // Checks the state of all bodies that are not `asleep` (one mark per dynamic body).
  void look(double time, std::span<const double> y, std::span<const char> asleep);
  // True if the body was at rest at the last check.
  bool is_at_rest(int body) const { return last_look_ - since_[body] >= window; }
  // Begins the windows of all bodies at `time` (s) in the state `y`.
  void begin(double time, std::span<const double> y);
  // Begins the body's window anew at `time` (s) in the state `y`.
  void begin_window(int body, double time, std::span<const double> y);
  void transfer(StateArchive& archive) { archive(place_, since_, last_look_); }

 private:
  bool stays(const SceneBody& body, std::span<const double> y, double distance) const;

  const Scene& scene_;
  std::vector<Vec3> place_;    // m, by dynamic particle: at the start of the window
  std::vector<double> since_;  // s, by dynamic body: start of its window
  double last_look_ = 0;       // s, time of the last check
};

}  // namespace weft::sim
