#include "sim/contact/rest_neighbours.h"

#include <algorithm>
#include <iterator>
#include <numbers>

#include "sim/contact/seam_neighbours.h"

namespace weft::sim {

double neighbour_radius(const SceneBody& body, double range) {
  const bsi::Neighbourhoods near(body.surface_mesh(), body.surface_rest(), body.thickness + range);
  return near.are_rings() ? 0 : std::numbers::pi / 2 * body.thickness + range;
}

std::unique_ptr<const bsi::Neighbourhoods> united(const SceneBody& body,
                                                  const bsi::Neighbourhoods& one,
                                                  const bsi::Neighbourhoods& other) {
  std::vector<std::vector<int>> triangles(body.point_count());
  for (int v = 0; v < body.point_count(); ++v) {
    const std::vector<int> first = one.triangles(v), second = other.triangles(v);
    std::ranges::set_union(first, second, std::back_inserter(triangles[v]));
  }
  return std::make_unique<const bsi::Neighbourhoods>(body.surface_mesh(), body.point_count(),
                                                     triangles);
}

void ContactSearch::find_neighbours_across_seams() {
  for (const auto& [pair, triangles] : neighbours_across_seams(scene_, range_)) {
    const SceneBody& body = scene_.bodies[pair.b];
    across_seams_[pair] = std::make_unique<const bsi::Neighbourhoods>(
        body.surface_mesh(), body.point_count(), triangles);
  }
}

void ContactSearch::set_across(CandidateList& list) const {
  if (across_seams_.empty() || list.is_self()) return;
  const auto across = [&](int vertices, int triangles) {
    const auto found = across_seams_.find({vertices, triangles});
    return found == across_seams_.end() ? nullptr : found->second.get();
  };
  list.first_across = across(list.body_a, list.body_b);
  list.second_across = across(list.body_b, list.body_a);
}

}  // namespace weft::sim
