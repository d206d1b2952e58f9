// Supports that hold particles in some directions and leave them free in the other directions.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "sim/base/vectors.h"
#include "sim/scene/motion.h"

namespace weft::sim {

struct PinCase;
struct SceneBody;

// Holds one component of a particle's position x, or of its difference from another particle, the
// base: direction . (x - x_base) = direction . (start - start_base). Without a base, both base
// terms are zero. The motion of the pin moves `start` and `start_base`. Particles are local
// indices.
struct SlidingSupport {
  int particle = 0;
  int base = -1;  // -1: no base
  Vec3 direction{0, 0, 0};
  Vec3 start{0, 0, 0}, start_base{0, 0, 0};  // m, at t = 0
  int pin = 0;                               // index of the pin in the body's list
};

// The supports of a body, with the motions of its pins.
struct SlidingSupports {
  std::vector<SlidingSupport> all;
  std::vector<RigidMotion> motions;  // by pin
  std::vector<char> moves;           // by pin: nonzero if the pin moves
  std::vector<double> radii;         // by pin: RigidMotion::radius_of() its particles, m

  bool any_moves() const { return std::ranges::find(moves, 1) != moves.end(); }
  // Calls visit(motion, radius) for each pin that moves.
  template <class Visit>
  void visit_motions(const Visit& visit) const {
    for (std::size_t pin = 0; pin < moves.size(); ++pin) {
      if (moves[pin] != 0) visit(motions[pin], radii[pin]);
    }
  }
};

// Appends the supports of a pin with `axes` or with a plane of symmetry. `number` is the index of
// the pin in the body's list. `held` has the particles that the pin selects (local indices,
// sorted). `position` has the body's particles at t = 0, m.
//
// A plane of symmetry supports all particles of `held` along its normal. It also holds the control
// points next to each border that lies wholly in `held`: their offsets from the border keep their
// components along the plane. Throws CaseError at the pin if the particles of `held` do not lie in
// one plane of symmetry.
void add_sliding_supports(const SceneBody& body, const PinCase& pin, int number,
                          std::span<const int> held, std::span<const Vec3> position,
                          SlidingSupports& supports);

// Returns the starts, stops and keyframes of the motions of supports.
std::vector<MotionEvent> events_of(const SlidingSupports& supports);

// Sets the supported components of a body's positions (m, by particle) to those of the supports at
// `time` (s). O(supports), as match_velocities().
void match_positions(const SlidingSupports& supports, double time, std::span<Vec3> position);
// Sets the supported components of a body's velocities (m/s, by particle) to those of the supports
// at `time` (s), after any jump then. The springs of supports would do so within a time that no
// step resolves. O(supports) if the directions at each particle are perpendicular.
void match_velocities(const SlidingSupports& supports, double time, std::span<Vec3> velocity);

}  // namespace weft::sim
