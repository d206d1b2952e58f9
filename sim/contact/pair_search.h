// The search for pairs of quads that come near each other, which is the first stage of the contact
// search. It runs on the CPU or on an OpenGL device. The device may leave out quads whose features
// stay out of reach.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "bsi/traversal.h"
#include "sim/contact/rigid_obstacles.h"
#include "sim/scene/scene.h"

namespace weft::sim {

// The positions of a body's surface points, m. The points are at rest at `end`, or follow straight
// paths from `start` to `end`.
struct BodyPath {
  int body = 0;
  std::span<const Vec3> start;  // the same span as `end` if at rest
  std::span<const Vec3> end;
  // True for the positions that serve queries of the body with itself. Those that serve queries
  // with other bodies are kept apart.
  bool own = false;
  // If not null, the body is this rigid obstacle, with `frames` at both ends. `start` and `end`
  // then serve is_swept() only.
  const RigidObstacle* obstacle = nullptr;
  std::array<bsi::RigidFrame, 2> frames{};
  bool is_swept() const { return start.data() != end.data(); }
};

// A query for the near quads of two bodies of the scene, or of one body with itself.
struct PairQuery {
  int body_a = 0;
  int body_b = 0;
  double margin = 0;  // m
};

class DeviceContact;

class PairSearch {
 public:
  virtual ~PairSearch() = default;

  // Returns true if BodyPath::obstacle may be set. Otherwise positions must be given for all
  // points.
  virtual bool takes_frames() const { return false; }
  // Stores the positions of these bodies. Precondition: the positions are finite. Bodies without a
  // path keep their positions. Returns the number of pyramids built. A rigid obstacle that already
  // has a pyramid gets new frames only.
  virtual int rebuild(std::span<const BodyPath> paths) = 0;
  // Sets found[i] to the quad pairs of query i (bsi/traversal.h, with the tangent certificate), in
  // any order. A pair may be missing if at the ends of its paths it is farther apart than the
  // margin plus twice the longest path of its corners. Increases the counters by the tests on the
  // CPU. Precondition: all bodies of the queries have been rebuilt.
  virtual void find(std::span<const PairQuery> queries,
                    std::vector<std::vector<bsi::LeafPair>>& found,
                    bsi::TraversalCounters& counters) = 0;
  // Returns the narrow phase on the graphics processor of this search, or null if the search runs
  // on the CPU or on a processor that OpenGL emulates.
  virtual std::unique_ptr<DeviceContact> make_device_contact() const;
};

std::unique_ptr<PairSearch> make_cpu_search(const Scene& scene);

}  // namespace weft::sim
