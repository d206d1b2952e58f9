// The search for quads of bodies that come near each other, on which the contact search is based.
// It runs on the CPU or on a device of OpenGL, with the same results.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "bsi/traversal.h"
#include "sim/contact/rigid_obstacles.h"
#include "sim/scene/scene.h"

namespace weft::sim {

// A body's particles, m: at rest at `end`, or on straight paths from `start` to `end`.
struct BodyPath {
  int body = 0;
  std::span<const Vec3> start;  // the same span as `end`: at rest
  std::span<const Vec3> end;
  // A rigid obstacle and its place at both ends; `start` and `end` then tell only whether it is
  // swept.
  const RigidObstacle* obstacle = nullptr;
  std::array<bsi::RigidFrame, 2> frames{};
  bool is_swept() const { return start.data() != end.data(); }
};

// Two bodies of the scene, or one with itself.
struct PairQuery {
  int body_a = 0;
  int body_b = 0;
  double margin = 0;  // m
};

class PairSearch {
 public:
  virtual ~PairSearch() = default;

  // Can paths name rigid obstacles? Otherwise all of their positions must be given.
  virtual bool takes_frames() const { return false; }
  // Remembers where these bodies are; the others stay where they were. All positions finite.
  // Returns how many pyramids were built for it: a rigid obstacle that has one is placed.
  virtual int rebuild(std::span<const BodyPath> paths) = 0;
  // Sets found[i] to the quad pairs of query i (bsi/traversal.h, with the tangent certificate), in
  // any order; pairs may be missing that end farther apart than the margin and twice the longest
  // path of their corners. All bodies asked for have been rebuilt. Counters are added to.
  virtual void find(std::span<const PairQuery> queries,
                    std::vector<std::vector<bsi::LeafPair>>& found,
                    bsi::TraversalCounters& counters) = 0;
};

std::unique_ptr<PairSearch> make_cpu_search(const Scene& scene);

}  // namespace weft::sim
