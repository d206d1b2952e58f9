// Detects bodies that have come to rest.
#pragma once

#include <span>
#include <vector>

#include "sim/base/state_archive.h"
#include "sim/scene/scene.h"

namespace weft::sim {

// Watches each body over a window of at least half a second. A body is at rest if it passes all
// checks since the start of its window. In a check, no vertex may be faster than the velocity
// tolerance. No vertex may be farther from its position at the start of the window than
//
//   position_tolerance * window / (time left until time.duration, at least the window).
//
// A body that continued with the mean velocity of such a window would move by at most
// position_tolerance until the end.
//
// States are checked at most sixteen times per window. A check costs O(vertices of the bodies that
// are checked).
class RestWatch {
 public:
  static constexpr double window = 0.5;  // s

  // Begins the window of every body at `time` (s) in the state `y` (StateView,
  // sim/motion/dynamics.h). The scene must outlive this object.
  RestWatch(const Scene& scene, double time, std::span<const double> y);

  // True if the last check is at least a sixteenth of a window before `time` (s).
  bool is_due(double time) const { return time >= last_look_ + window / 16; }
  // Checks all bodies that are not asleep in the state `y` at `time` (s). `asleep` is not zero for
  // each dynamic body that sleeps. A body that fails begins a new window.
  void look(double time, std::span<const double> y, std::span<const char> asleep);
  // True if the body was at rest at the last check, at the end of a full window.
  bool is_at_rest(int body) const { return last_look_ - since_[body] >= window; }
  // Begins the windows of all bodies at `time` (s) in the state `y`.
  void begin(double time, std::span<const double> y);
  // Begins a new window of one body at `time` (s) in the state `y`.
  void begin_window(int body, double time, std::span<const double> y);
  void transfer(StateArchive& archive) { archive(place_, since_, last_look_); }

 private:
  bool stays(const SceneBody& body, std::span<const double> y, double distance) const;

  const Scene& scene_;
  std::vector<Vec3> place_;    // position (m) of each dynamic particle at the start of the window
  std::vector<double> since_;  // start of the window of each dynamic body (s)
  double last_look_ = 0;       // time of the last check (s)
};

}  // namespace weft::sim
