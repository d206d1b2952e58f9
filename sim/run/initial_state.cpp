#include "sim/run/initial_state.h"

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "sim/base/memory_shortage.h"
#include "sim/case/case_error.h"
#include "sim/case/case_text.h"
#include "sim/contact/contact.h"
#include "sim/contact/contact_search.h"
#include "sim/forces/force_arrays.h"
#include "sim/particles/sphere_starts.h"

namespace weft::sim {

namespace {

constexpr std::size_t listed_places = 10;

std::string describe_triangle(const Scene& scene, int body, int triangle) {
  const SceneBody& owner = scene.bodies[body];
  return scene.describe_point(owner.surface_mesh().triangles[triangle][0] + owner.first_point);
}

// Returns where the case has a body, an obstacle or a group of particles.
SourceLocation location_in_case(const Scene& scene, std::size_t index) {
  const Case& source = scene.source;
  if (index < source.body.size()) return source.body[index].location;
  index -= source.body.size();
  if (index < source.obstacle.size()) return source.obstacle[index].location;
  return source.particles[index - source.obstacle.size()].location;
}

// Returns where the case has that of two bodies which it names later.
SourceLocation later_location(const Scene& scene, int one, int other) {
  const int later = std::max(scene.case_index(one), scene.case_index(other));
  return location_in_case(scene, static_cast<std::size_t>(later));
}

// True if the triangles have points that seams hold together: these touch.
bool are_sewn(const Scene& scene, const Crossing& crossing) {
  const SceneBody &one = scene.bodies[crossing.surface_a],
                  &other = scene.bodies[crossing.surface_b];
  for (const int a : one.surface_mesh().triangles[crossing.triangle_a]) {
    for (const int b : other.surface_mesh().triangles[crossing.triangle_b]) {
      if (scene.sewn.are_joined(one.first_point + a, other.first_point + b)) return true;
    }
  }
  return false;
}

void refuse_crossings(const Scene& scene) {
  std::vector<Vec3> room;
  const std::vector<Crossing> crossings = forbidden_crossings(
      scene, scene.surface_map.points_of(scene.initial_position, scene.point_count, room));
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
  const Crossing& first = crossings.front();
  throw CaseError(later_location(scene, first.surface_a, first.surface_b), message,
                  are_of_one_body ? "expected a shape that does not pass through itself, or "
                                    "self_contact = false"
                                  : "move the bodies apart");
}

// True if both features of the fault belong to one body.
bool is_of_one_body(const ContactFault& fault, const Scene& scene) {
  return fault.kind != ContactFault::Kind::not_finite &&
         scene.body_index_of_point(fault.nodes[0]) == scene.body_index_of_point(fault.nodes[3]);
}

// Returns where the case has the later body of a fault.
SourceLocation location_of(const ContactFault& fault, const Scene& scene) {
  if (fault.kind == ContactFault::Kind::not_finite) {
    const int body = scene.body_index_of_particle(fault.nodes[0]);
    return later_location(scene, body, body);
  }
  return later_location(scene, scene.body_index_of_point(fault.nodes[0]),
                        scene.body_index_of_point(fault.nodes[3]));
}

const char* hint_for(const ContactFault& fault, const Scene& scene) {
  if (fault.kind == ContactFault::Kind::not_finite)
    return "expected a place within 1e15 m of the origin";
  return is_of_one_body(fault, scene)
             ? "make thickness smaller, or the layers of the shape farther apart"
             : "move the bodies apart, or make thickness smaller";
}

// Throws CaseError at the places of the particles, if the fault is that of a particle. Of two
// groups, the one that the case names later is at fault.
void refuse_overlap_of_particle(const ContactFault& fault, const Scene& scene) {
  if (fault.kind != ContactFault::Kind::touching) return;
  const int one = scene.body_index_of_point(fault.nodes[0]),
            other = scene.body_index_of_point(fault.nodes[3]);
  const bool first = scene.bodies[one].spheres != nullptr,
             second = scene.bodies[other].spheres != nullptr;
  if (!first && !second) return;
  const int later = first && second ? std::max(one, other) : first ? one : other;
  const int sphere = first ? fault.nodes[0] : fault.nodes[3],
            partner = first ? fault.nodes[3] : fault.nodes[0];
  const std::string place = scene.describe_point(partner);
  throw CaseError(
      scene.bodies[later].spheres->positions.location,
      scene.describe_point(sphere) +
          (fault.gap < 0 ? " overlaps " + place + " by " + rounded_text(-fault.gap) + " m"
                         : " touches " + place) +
          " at the start",
      "expected particles with a gap around them");
}

[[noreturn]] void refuse(const ContactFault& fault, const Scene& scene) {
  refuse_overlap_of_particle(fault, scene);
  throw CaseError(location_of(fault, scene),
                  "the initial state cannot be simulated: " + fault.describe(scene),
                  hint_for(fault, scene));
}

// Throws CaseError if a vertex is found within the thickness of another body. Stops looking after
// some comparisons. A thickness in the wrong unit is answered at once: with it, the search for
// contacts would list all pairs of triangles first, which can take minutes and most of the memory.
void refuse_close_vertices(const Scene& scene) {
  if (!scene.sewn.is_empty()) return;
  int comparisons_left = 1'000'000;
  std::vector<Vec3> room;
  const auto points = scene.surface_map.points_of(scene.initial_position, scene.point_count, room);
  for (const CandidateList& list : neighbours_at_start(scene)) {
    const SceneBody &a = scene.bodies[list.body_a], &b = scene.bodies[list.body_b];
    if (list.is_self() || a.spheres != nullptr || b.spheres != nullptr) continue;
    for (int i = a.first_point; i < a.first_point + a.point_count(); ++i) {
      if (!scene.is_free_point(i)) continue;
      for (const std::array<int, 3>& corners : b.surface_mesh().triangles) {
        if (--comparisons_left < 0) return;
        const int other = corners[0] + b.first_point;
        const double gap = (points[i] - points[other]).norm() - list.thickness;
        if (!(gap <= 0)) continue;
        refuse({ContactFault::Kind::touching,
                {i, other, corners[1] + b.first_point, corners[2] + b.first_point},
                gap},
               scene);
      }
    }
  }
}

void refuse_missing_gaps(const Scene& scene) try {
  refuse_close_vertices(scene);
  Statistics unused;
  Contact contact(scene, unused);
  double smallest_gap = 0;
  if (const auto fault = contact.check_state(scene.initial_position, &smallest_gap))
    refuse(*fault, scene);
  const auto curved = contact.check_path(scene.initial_position, scene.initial_position);
  if (curved && curved->kind == ContactFault::Kind::curved) {
    throw CaseError(location_of(*curved, scene),
                    "the initial state cannot be simulated: " + curved->describe(scene),
                    "expected bodies farther apart, or a shell that its image resolves better");
  }
} catch (const MemoryShortage& shortage) {
  throw CaseError(later_location(scene, shortage.body_a, shortage.body_b), shortage.what(),
                  "expected fewer vertices, shorter distances, or a larger compute.memory_limit");
}

void refuse_strain(const Scene& scene) {
  const auto start =
      std::span(scene.initial_position).first(static_cast<std::size_t>(scene.dynamic_particles));
  const std::unique_ptr<Force> limit = make_strain_limit_force(scene);
  const int particle = limit ? limit->find_beyond_limit(start) : -1;
  if (particle < 0) return;
  const int body = scene.case_index(scene.body_index_of_particle(particle));
  throw CaseError(
      scene.source.body[body].location,
      "at the start the membrane exceeds its strain_limit at " + scene.describe_particle(particle),
      "expected a larger strain_limit, or a start that is stretched less");
}

}  // namespace

std::vector<CrossingSurface> contact_surfaces(const Scene& scene, std::span<const Vec3> points) {
  std::vector<CrossingSurface> surfaces;
  for (const SceneBody& body : scene.bodies) {
    surfaces.push_back({points.subspan(body.first_point, body.point_count()),
                        body.surface_mesh().triangles, body.self_contact});
  }
  return surfaces;
}

std::vector<Crossing> forbidden_crossings(const Scene& scene, std::span<const Vec3> points) {
  std::vector<Crossing> crossings = find_crossings(contact_surfaces(scene, points));
  // Obstacles may intersect each other, because no contact acts between them.
  std::erase_if(crossings, [&](const Crossing& c) {
    return scene.bodies[c.surface_a].is_obstacle && scene.bodies[c.surface_b].is_obstacle;
  });
  if (!scene.sewn.is_empty())
    std::erase_if(crossings, [&](const Crossing& c) { return are_sewn(scene, c); });
  return crossings;
}

void check_initial_state(const Scene& scene) {
  refuse_strain(scene);
  if (scene.spheres_collide) refuse_overlapping_spheres(scene);
  if (!scene.source.contact.enabled) return;
  refuse_crossings(scene);
  refuse_missing_gaps(scene);
}

}  // namespace weft::sim
