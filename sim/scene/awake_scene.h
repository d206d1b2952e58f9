// The part of a scene that is simulated while some of its bodies sleep.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "sim/scene/scene.h"

namespace weft::sim {

// A copy of a scene, `whole`, in which sleeping bodies are obstacles at rest. It has all bodies and
// particles of `whole`, in this order: first the awake bodies, then the sleeping bodies, then the
// bodies that are not dynamic in `whole`.
class AwakeScene {
 public:
  // `asleep` has a mark for each dynamic body of `whole`; a nonzero mark means that the body
  // sleeps. `position` has the present positions of the dynamic particles of `whole`, m.
  // Preconditions: at least one body sleeps, at least one is awake, and no sleeping body has a pin
  // that moves. `whole` must outlive this object.
  AwakeScene(const Scene& whole, std::span<const char> asleep, std::span<const Vec3> position);

  const Scene& scene() const { return scene_; }
  // whole_body() and whole_particle() return the index in `whole` of a body or a particle of
  // scene().
  int whole_body(int body) const { return whole_body_[body]; }
  int whole_particle(int particle) const;
  // gather() copies the positions and velocities of awake bodies from a state of `whole` to a state
  // of scene(), and scatter() copies them back. States are those of StateView
  // (sim/motion/dynamics.h).
  void gather(std::span<const double> whole, std::span<double> awake) const;
  void scatter(std::span<const double> awake, std::span<double> whole) const;

 private:
  template <class Copy>
  void visit_vectors(const Copy& copy) const;

  const Scene& whole_;
  Scene scene_;
  std::vector<int> whole_body_;  // by body of scene_: index in whole_
};

}  // namespace weft::sim
