// Coulomb coefficients of contact between bodies.
#pragma once

#include <cstddef>
#include <vector>

#include "sim/scene/scene.h"

namespace weft::sim {

// The friction of all pairs of bodies that may touch: two dynamic bodies, a dynamic body and an
// obstacle, or a dynamic body and itself. A [[contact.pair]] of their names precedes one of their
// materials. contact.friction, which may vary in time, holds for pairs without either.
class PairFriction {
 public:
  // Costs one number per pair of bodies, and nothing if the case has no [[contact.pair]]. The scene
  // must outlive the object.
  explicit PairFriction(const Scene& scene);

  // Sets contact.friction.
  void set_default(double friction) { default_ = friction; }
  // Returns the friction of two bodies, by their indices in Scene::bodies. Precondition: body_a is
  // dynamic.
  double of(int body_a, int body_b) const {
    if (rule_.empty()) return default_;
    const int rule = rule_[entry(body_a, body_b)];
    return rule < 0 ? default_ : friction_[rule];
  }
  // Returns false if no two bodies have friction.
  bool any() const { return default_ > 0 || largest_ > 0; }
  // Returns for each [[contact.pair]] the number of pairs of bodies for which it holds.
  std::vector<int> uses() const;

 private:
  std::size_t entry(int body_a, int body_b) const {
    return static_cast<std::size_t>(body_a) * bodies_ + static_cast<std::size_t>(body_b);
  }
  void apply(int rule, const std::vector<int>& first, const std::vector<int>& second);

  const Scene& scene_;
  std::size_t bodies_;
  double default_;
  double largest_ = 0;            // of all rules that hold for some pair of bodies
  std::vector<double> friction_;  // by rule: index of the [[contact.pair]]
  std::vector<int> rule_;         // by entry(); -1: contact.friction holds
};

}  // namespace weft::sim
