// A contact of a rigid sphere.
#pragma once

#include <compare>
#include <cstddef>
#include <vector>

#include "sim/base/vectors.h"

namespace weft::sim {

// Contacts with equal keys are one contact in two steps. Lists of contacts are sorted by key.
struct ContactKey {
  int surface = -1, sphere = 0, other = -1, triangle = -1;
  // clang-tidy 14 mistakes the generated comparison with 0 for one with a null pointer.
  auto operator<=>(const ContactKey&) const = default;  // NOLINT(modernize-use-nullptr)
};

// A sphere that is near another sphere, or near a triangle of an obstacle.
struct SphereContact {
  int sphere = 0;        // index of the sphere
  int other = -1;        // index of the other sphere, or -1
  int surface = -1;      // index in SphereSurfaces, or -1
  int triangle = -1;     // triangle of the surface, or -1
  Vec3 normal{0, 0, 0};  // unit vector from the closest point of the other side to the sphere
  double gap = 0;        // m, distance of the surfaces, less half the thickness of an obstacle
  Vec3 drive{0, 0, 0};   // m/s, mean velocity of the obstacle's closest point during the step
  // Velocity (m/s) at the end of the step of the point of the obstacle that the sphere will be at.
  Vec3 end_drive{0, 0, 0};
  // If a sphere rolls or slides on an obstacle that rises before it, `normal` plus `bend` is
  // half way between the normals at both ends of the step. `rise` (m/s) is the speed along it with
  // which the sphere leaves the plane that it moves on at the start. Both are zero elsewhere.
  Vec3 bend{0, 0, 0};
  double rise = 0;
  // True if a closer contact with the same curved surface bears the sphere in this one's place.
  bool is_borne = false;
  double restitution = 0, friction = 0;

  Vec3 rolling_normal() const { return normal + bend; }
  ContactKey key() const { return {surface, sphere, other, triangle}; }
};

// Calls use(i, kept) for every i in 0 .. count - 1 whose key_of(i) is that of an entry of `kept`.
// Both are sorted by key.
template <class Kept, class KeyOf, class Use>
void match_kept(const std::vector<Kept>& kept, std::size_t count, const KeyOf& key_of,
                const Use& use) {
  auto next = kept.begin();
  for (std::size_t i = 0; i < count; ++i) {
    const ContactKey key = key_of(i);
    while (next != kept.end() && next->key < key) ++next;
    if (next == kept.end()) return;
    if (next->key == key) use(i, *next);
  }
}

}  // namespace weft::sim
