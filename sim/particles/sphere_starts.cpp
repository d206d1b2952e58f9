#include "sim/particles/sphere_starts.h"

#include <algorithm>

#include "sim/case/case_error.h"
#include "sim/case/case_text.h"
#include "sim/particles/sphere_search.h"

namespace weft::sim {

namespace {

// Rounding of gaps that are zero in exact numbers, as a fraction of the radius: a lattice of
// touching spheres, or spheres that lie on a floor.
constexpr double rounding_of_gaps = 1e-9;

std::string partner_of(const SphereContact& contact, const SphereSurfaces& surfaces,
                       const Scene& scene) {
  if (contact.other >= 0) return scene.describe_particle(contact.other);
  const ObstacleSurface& surface = surfaces.all()[contact.surface];
  return "obstacle \"" + scene.bodies[surface.body].name + "\"";
}

}  // namespace

void refuse_overlapping_spheres(const Scene& scene) {
  Statistics unused;
  const SphereSurfaces surfaces(scene);
  SphereLaws laws(scene);
  laws.set_friction(0);
  SphereSearch search(scene, surfaces, laws, unused);
  const std::vector<RigidPose> poses = surfaces.poses(0);
  const auto position = std::span<const Vec3>(scene.initial_position)
                            .first(static_cast<std::size_t>(scene.dynamic_particles));
  const std::vector<Vec3> rest(position.size(), Vec3::Zero());
  const SphereStart start{position, rest, rest, poses, poses, 1};
  const std::vector<double> reach(position.size(), 0.0);
  std::vector<SphereContact> overlaps;
  search.find_contacts(start, reach, 0, overlaps);
  std::erase_if(overlaps, [&](const SphereContact& contact) {
    return contact.gap >= -rounding_of_gaps * search.radii()[contact.sphere];
  });
  if (overlaps.empty()) return;
  const SphereContact& first = overlaps.front();
  // The group that the case names later is at fault.
  const int later = std::max(first.sphere, first.other);
  throw CaseError(
      scene.body_of_particle(later).spheres->positions.location,
      scene.describe_particle(first.sphere) + " overlaps " + partner_of(first, surfaces, scene) +
          " by " + rounded_text(-first.gap) + " m at the start" +
          (overlaps.size() > 1
               ? ", the first of " + std::to_string(overlaps.size()) + " overlapping pairs"
               : ""),
      "expected particles that do not overlap anything");
}

}  // namespace weft::sim
