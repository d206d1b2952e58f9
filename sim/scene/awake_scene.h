// The part of a scene that is simulated while some of its bodies sleep.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "sim/scene/scene.h"

namespace weft::sim {

// A scene in which the sleeping bodies of another scene, the whole, are obstacles that stay where
// they rest. It has all bodies and particles of the whole in another order: first the awake bodies,
// then the sleeping ones, then those that are not dynamic in the whole either.
class AwakeScene {
 public:
  // `asleep` has a mark for each dynamic body of the whole. At least one body sleeps, at least one
  // is awake, and no sleeping body has a pin that moves. `position` (m, of the dynamic particles of
  // the whole) is where bodies are now. The whole must outlive the result.
  AwakeScene(const Scene& whole, std::span<const char> asleep, std::span<const Vec3> position);

  const Scene& scene() const { return scene_; }
  // Indices in the whole of a body and of a particle.
  int whole_body(int body) const { return whole_body_[body]; }
  int whole_particle(int particle) const;
  // Copies the part of awake bodies between states (StateView, sim/motion/dynamics.h) of the whole
  // and of this scene.
  void gather(std::span<const double> whole, std::span<double> awake) const;
  void scatter(std::span<const double> awake, std::span<double> whole) const;

 private:
  template <class Copy>
  void visit_vectors(const Copy& copy) const;

  const Scene& whole_;
  Scene scene_;
  std::vector<int> whole_body_;  // by body
};

}  // namespace weft::sim
