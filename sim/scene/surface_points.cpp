#include "sim/scene/surface_points.h"

#include <algorithm>

namespace weft::sim {

namespace {

// Returns the map of the scene. In a body without a map of its own, each point is a particle.
SurfaceMap joined_map(const std::vector<SceneBody>& bodies) {
  if (std::ranges::none_of(bodies, [](const SceneBody& body) { return body.sampled.has_value(); }))
    return {};
  std::vector<int> first_share{0};
  std::vector<SurfaceMap::Share> shares;
  for (const SceneBody& body : bodies) {
    const SurfaceMap own = body.sampled ? body.sampled->map : SurfaceMap();
    for (int point = 0; point < body.point_count(); ++point) {
      if (own.is_identity()) shares.push_back({body.first_particle + point, 1.0});
      if (!own.is_identity()) {
        for (const auto& [particle, weight] : own.shares(point))
          shares.push_back({body.first_particle + particle, weight});
      }
      first_share.push_back(static_cast<int>(shares.size()));
    }
  }
  return {std::move(first_share), std::move(shares)};
}

}  // namespace

std::vector<double> areas_around(const bsi::Mesh& mesh, std::span<const Vec3> vertices) {
  std::vector<double> area(vertices.size(), 0.0);
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vec3 u = vertices[b] - vertices[a], v = vertices[c] - vertices[a];
    const double doubled = u.cross(v).norm();
    for (const int vertex : {a, b, c}) area[vertex] += doubled / 6;
  }
  return area;
}

void number_surface_points(Scene& scene) {
  scene.point_count = 0;
  scene.contact_area.clear();
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    SceneBody& body = scene.bodies[b];
    body.first_point = scene.point_count;
    scene.point_count += body.point_count();
    if (static_cast<int>(b) < scene.dynamic_bodies) scene.dynamic_points = scene.point_count;
    if (!scene.source.contact.enabled) continue;
    const std::vector<double> area = areas_around(body.surface_mesh(), body.surface_rest());
    scene.contact_area.insert(scene.contact_area.end(), area.begin(), area.end());
  }
  scene.surface_map = joined_map(scene.bodies);
  scene.sewn = scene.seams.empty() ? SewnPoints() : SewnPoints(scene);
}

}  // namespace weft::sim
