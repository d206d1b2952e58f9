// The search for pairs of quads that come near each other, on which the contact search is based. It
// runs on the CPU or on an OpenGL device, with the same results.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "bsi/traversal.h"
#include "sim/contact/rigid_obstacles.h"
#include "sim/scene/scene.h"

namespace weft::sim {

// The positions of a body's surface points, m: at rest at `end`, or on straight paths from `start`
// to `end`.
struct BodyPath {
  int body = 0;
  std::span<const Vec3> start;  // at rest: the same span as `end`
  std::span<const Vec3> end;
  // A rigid obstacle, and its frames at both ends. `start` and `end` then tell only whether the
  // obstacle is at rest.
  const RigidObstacle* obstacle = nullptr;
  std::array<bsi::RigidFrame, 2> frames{};
  bool is_swept() const { return start.data() != end.data(); }
};

// A query of two bodies of the scene, or of one body with itself.
struct PairQuery {
  int body_a = 0;
  int body_b = 0;
  double margin = 0;  // m
};

class PairSearch {
 public:
  virtual ~PairSearch() = default;

  // Returns true if paths may name rigid obstacles. Otherwise all of their positions must be given.
  virtual bool takes_frames() const { return false; }
  // Stores the positions of these bodies, all finite; other bodies keep theirs. Returns the number
  // of pyramids built. A rigid obstacle that already has one is only placed.
  virtual int rebuild(std::span<const BodyPath> paths) = 0;
  // Sets found[i] to the quad pairs of query i (bsi/traversal.h, with the tangent certificate), in
  // any order. Pairs may be missing if they end farther apart than the margin plus twice the
  // longest path of their corners. Counters are increased. Precondition: all bodies of the queries
  // have been rebuilt.
  virtual void find(std::span<const PairQuery> queries,
                    std::vector<std::vector<bsi::LeafPair>>& found,
                    bsi::TraversalCounters& counters) = 0;
};

std::unique_ptr<PairSearch> make_cpu_search(const Scene& scene);

}  // namespace weft::sim
