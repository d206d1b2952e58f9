// Anchors of sticking contacts: points of surfaces to which springs hold the samples in contact.
#pragma once

#include <array>
#include <compare>
#include <vector>

#include "sim/base/step_history.h"
#include "sim/base/vectors.h"

namespace weft::sim {

struct Scene;
class StateArchive;

// A sample, and the surface to which it is anchored. Bodies are numbered as in the case, points as
// in their bodies, so that anchors serve all scenes that are made from a case during a run.
struct AnchorKey {
  int body = 0, point = 0;
  int surface = 0;  // the body of the surface
  // clang-tidy 14 mistakes the generated comparison with 0 for one with a null pointer.
  auto operator<=>(const AnchorKey&) const = default;  // NOLINT(modernize-use-nullptr)
};

// A point of a surface, or of the plane of one of its triangles: the sum of the weights times the
// positions of three of the surface's points. The weights sum to 1.
struct Anchor {
  AnchorKey key;
  std::array<int, 3> corners{};
  std::array<double, 3> weights{};
};

// The anchors of all contacts that stick or slide, sorted by key.
using Anchors = std::vector<Anchor>;
using AnchorHistory = StepHistory<Anchors>;

// Returns the anchor with this key, or null. O(log anchors).
const Anchor* find_anchor(const Anchors& anchors, const AnchorKey& key);

// The closest point of a surface to a sample, in one of the surface's triangles, whose corners have
// the positions x (m). `weights` sum to 1. `normal` is the unit vector from there to the sample.
struct Footing {
  std::array<int, 3> corners{};
  std::array<double, 3> weights{};
  std::array<Vec3, 3> x{};
  Vec3 normal{0, 0, 0};
};

// Returns the anchor of a sample at the end of a step. `before` is its anchor so far, or null, and
// `offset` (m) the vector from there to the sample. While the part of `offset` across the normal is
// no longer than `distance` (m), the anchor stays. A longer one drags it along, until it has that
// length. Without an anchor so far, the foot becomes the anchor.
Anchor advanced_anchor(const AnchorKey& key, const Anchor* before, const Vec3& offset,
                       const Footing& foot, double distance);

// Writes or reads anchors. Throws std::invalid_argument if the scene cannot have those that are
// read.
void transfer(StateArchive& archive, Anchors& anchors, const Scene& scene);

}  // namespace weft::sim
