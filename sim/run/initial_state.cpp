#include "sim/run/initial_state.h"

#include <algorithm>
#include <string>
#include <vector>

#include "sim/case/case_error.h"
#include "sim/case/case_text.h"
#include "sim/contact/contact.h"
#include "sim/view/crossings.h"

namespace weft::sim {

namespace {

constexpr std::size_t listed_places = 10;

std::string describe_triangle(const Scene& scene, int body, int triangle) {
  const SceneBody& owner = scene.bodies[body];
  return scene.describe_point(owner.surface_mesh().triangles[triangle][0] + owner.first_point);
}

void refuse_crossings(const Scene& scene) {
  std::vector<CrossingSurface> surfaces;
  std::vector<Vec3> room;
  const std::span<const Vec3> position =
      scene.surface_map.points_of(scene.initial_position, scene.point_count, room);
  for (const SceneBody& body : scene.bodies) {
    surfaces.push_back({position.subspan(body.first_point, body.point_count()),
                        body.surface_mesh().triangles, body.self_contact});
  }
  std::vector<Crossing> crossings = find_crossings(surfaces);
  // Obstacles may intersect each other, because no contact acts between them.
  std::erase_if(crossings, [&](const Crossing& c) {
    return scene.bodies[c.surface_a].is_obstacle && scene.bodies[c.surface_b].is_obstacle;
  });
  if (crossings.empty()) return;
  // Triangles are described by their first vertices. Pairs of triangles with the same description
  // are listed once.
  std::vector<std::string> places;
  for (const Crossing& c : crossings) {
    std::string place = describe_triangle(scene, c.surface_a, c.triangle_a) + "  with  " +
                        describe_triangle(scene, c.surface_b, c.triangle_b);
    if (std::ranges::find(places, place) == places.end()) places.push_back(std::move(place));
    if (places.size() > listed_places) break;
  }
  std::string message = "the initial state has " + counted(std::ssize(crossings),
                                                           "intersecting pair of triangles, at",
                                                           "intersecting pairs of triangles, at");
  for (std::size_t i = 0; i < std::min(places.size(), listed_places); ++i)
    message += "\n  " + places[i];
  if (places.size() > listed_places) message += "\n  and elsewhere";
  const bool are_of_one_body =
      std::ranges::all_of(crossings, [](const Crossing& c) { return c.surface_a == c.surface_b; });
  throw CaseError({scene.source.path, 0, 0}, message,
                  are_of_one_body ? "expected a shape that does not pass through itself, or "
                                    "self_contact = false"
                                  : "move the bodies apart");
}

// True if both features of the fault belong to one body.
bool is_of_one_body(const ContactFault& fault, const Scene& scene) {
  return fault.kind != ContactFault::Kind::not_finite &&
         scene.body_index_of_point(fault.nodes[0]) == scene.body_index_of_point(fault.nodes[3]);
}

void refuse_missing_gaps(const Scene& scene) {
  Statistics unused;
  Contact contact(scene, unused);
  double smallest_gap = 0;
  const auto fault = contact.check_state(scene.initial_position, &smallest_gap);
  if (fault) {
    throw CaseError({scene.source.path, 0, 0},
                    "the initial state cannot be simulated: " + fault->describe(scene),
                    is_of_one_body(*fault, scene)
                        ? "make thickness smaller, or the edges of the mesh longer"
                        : "move the bodies apart, or make thickness smaller");
  }
  if (const auto pair = contact.self_pair_in_reach(scene.initial_position)) {
    throw CaseError(
        {scene.source.path, 0, 0},
        "contact.range is too large for this mesh: in the undeformed shape " +
            pair->describe(scene),
        "expected thickness + contact.range below the distance of features that share no vertex "
        "(about 0.7 of the shortest edge)");
  }
}

}  // namespace

void check_initial_state(const Scene& scene) {
  if (!scene.source.contact.enabled) return;
  refuse_crossings(scene);
  refuse_missing_gaps(scene);
}

}  // namespace weft::sim
