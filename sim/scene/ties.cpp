#include "sim/scene/ties.h"

#include <algorithm>
#include <limits>

#include "bsi/proximity.h"
#include "sim/scene/pins.h"
#include "sim/scene/scene.h"
#include "sim/scene/surface_points.h"

namespace weft::sim {

namespace {

// Returns the index of a body or obstacle in the order of the case: bodies first, then obstacles.
int case_index(const Case& source, const std::string& name) {
  int index = 0;
  for (const BodyCase& body : source.body) {
    if (body.name == name) return index;
    ++index;
  }
  for (const ObstacleCase& obstacle : source.obstacle) {
    if (obstacle.name == name) return index;
    ++index;
  }
  return index;
}

// Sets nodes, weights, place and length of a spring to those of the point on `body` that is nearest
// to `vertex` at t = 0.
void attach_to_surface(const Scene& scene, const SceneBody& body, const Vec3& vertex,
                       TieSpring& spring) {
  const Vec3* const position = scene.initial_position.data() + body.first_particle;
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto& triangle : body.mesh.triangles) {
    const bsi::Closest closest = bsi::closest_vertex_triangle(
        vertex, position[triangle[0]], position[triangle[1]], position[triangle[2]]);
    if (!(closest.squared_distance < nearest)) continue;
    nearest = closest.squared_distance;
    spring.place.setZero();
    for (int i = 0; i < 3; ++i) {
      spring.nodes[i] = triangle[i];
      spring.weights[i] = -closest.weight[i + 1];
      spring.place += spring.weights[i] * position[triangle[i]];
    }
  }
  spring.length = (vertex - spring.place).norm();
}

}  // namespace

void add_ties(Scene& scene) {
  for (const TieCase& from : scene.source.tie) {
    Tie tie;
    tie.source = &from;
    tie.number = static_cast<int>(scene.ties.size());
    tie.body = case_index(scene.source, from.body);
    tie.to = case_index(scene.source, from.to);
    const SceneBody& body = scene.bodies[scene.case_order[tie.body]];
    const SceneBody& other = scene.bodies[scene.case_order[tie.to]];
    const auto positions = std::span<const Vec3>(scene.initial_position)
                               .subspan(body.first_particle, body.particle_count());
    const std::vector<double> areas = areas_around(body.mesh, body.rest);
    double area = 0;
    for (const int vertex : select_vertices(from.vertices, from.location, "tie", body, positions)) {
      TieSpring spring;
      spring.vertex = vertex;
      spring.place = positions[vertex];
      if (!other.is_obstacle) attach_to_surface(scene, other, positions[vertex], spring);
      spring.share = areas[vertex];
      area += areas[vertex];
      tie.springs.push_back(spring);
    }
    for (TieSpring& spring : tie.springs) spring.share /= area;
    scene.ties.push_back(std::move(tie));
  }
}

bool has_breakable_ties(const Scene& scene) {
  return std::ranges::any_of(scene.ties,
                             [](const Tie& tie) { return tie.source->break_force.has_value(); });
}

}  // namespace weft::sim
