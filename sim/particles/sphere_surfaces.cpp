#include "sim/particles/sphere_surfaces.h"

#include <algorithm>
#include <cassert>

namespace weft::sim {

SphereSurfaces::SphereSurfaces(const Scene& scene) {
  for (int b = scene.dynamic_bodies; b < static_cast<int>(scene.bodies.size()); ++b) {
    const SceneBody& body = scene.bodies[b];
    const auto held = std::ranges::find_if(scene.prescribed, [&](const PrescribedMotion& each) {
      return !each.particles.empty() && each.particles.front() == body.first_particle;
    });
    const bool moves = held != scene.prescribed.end() && held->moves;
    const auto first = scene.initial_position.begin() + body.first_particle;
    ObstacleSurface surface{.body = b,
                            .motion = moves ? &held->motion : nullptr,
                            .vertices = {first, first + body.particle_count()},
                            .mesh = &body.mesh,
                            .half_thickness = 0.5 * body.thickness,
                            .radius = 0,
                            .pyramid = bsi::Pyramid(body.atlas, {.tangents = false})};
    if (moves) {
      surface.vertices = held->start;
      surface.radius = held->radius;
    }
    [[maybe_unused]] const auto fault = surface.pyramid.rebuild(surface.vertices, scene.threads);
    assert(!fault);
    all_.push_back(std::move(surface));
  }
}

std::vector<RigidPose> SphereSurfaces::poses(double time, bool before_jump) const {
  std::vector<RigidPose> poses;
  for (const ObstacleSurface& surface : all_)
    poses.push_back(surface.motion != nullptr ? surface.motion->pose(time, before_jump)
                                              : RigidPose());
  return poses;
}

}  // namespace weft::sim
