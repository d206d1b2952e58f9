// Supports that hold particles in some directions and leave them free in the others.
#pragma once

#include <span>
#include <vector>

#include "sim/base/vectors.h"
#include "sim/scene/motion.h"

namespace weft::sim {

struct PinCase;
struct SceneBody;

// Holds one component of a particle's place, or of the vector from another particle to it:
// direction . (x - x_base) = direction . (start - start_base), where the pin's motion moves the
// starts.
struct SlidingSupport {
  int particle = 0;
  int base = -1;  // -1: none
  Vec3 direction{0, 0, 0};
  Vec3 start{0, 0, 0}, start_base{0, 0, 0};  // m, at t = 0
  int pin = 0;                               // in the list of the body
};

// The supports of a body with the motions of its pins. Particles are local indices.
struct SlidingSupports {
  std::vector<SlidingSupport> all;
  std::vector<RigidMotion> motions;  // by pin
  std::vector<char> moves;           // by pin
};

// Appends the supports of a pin with `axes` or a plane of symmetry. Along a plane of symmetry, the
// rows of control points next to the whole borders that the pin names keep their places beside
// them. `held`: the particles that the pin names (local indices, sorted); `position`: of the body's
// particles at t = 0, m. Throws CaseError at the pin if its plane does not hold its particles.
void add_sliding_supports(const SceneBody& body, const PinCase& pin, int number,
                          std::span<const int> held, std::span<const Vec3> position,
                          SlidingSupports& supports);

}  // namespace weft::sim
