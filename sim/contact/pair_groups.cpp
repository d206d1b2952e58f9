// Groups of candidates: those of each list that may be in reach, by their kind.
#include "sim/base/parallel.h"
#include "sim/contact/surface_contact.h"
#include "sim/contact/surface_features.h"

namespace weft::sim {

namespace {

// Part of ContactSearch::candidate_slack() by which distances may shrink until those candidates
// that can be in reach are selected anew. With less, this happens more often; with more, more of
// them are measured.
constexpr double part_for_groups = 0.25;

}  // namespace

// Sets the properties of a group, but for its candidates and its friction: those of a list's
// vertex-triangle (kind 0), triangle-vertex (1) or edge-edge (2) pairs.
void SurfaceContact::describe(const CandidateList& list, int kind, PairGroup& group) const {
  const SceneBody& first = scene_.bodies[kind == 0 ? list.body_a : list.body_b];
  const SceneBody& second = scene_.bodies[kind == 0 ? list.body_b : list.body_a];
  group.edges = kind == 2;
  group.samples = !group.edges && first.dynamic;
  group.thickness = list.thickness;
  group.of_spheres = first.spheres != nullptr;
  group.on_spheres = second.spheres != nullptr;
  group.body_a = list.body_a;
  group.body_b = list.body_b;
  group.surface = kind == 0 ? list.body_b : list.body_a;
  group.across = kind == 0 ? list.first_across : kind == 1 ? list.second_across : nullptr;
}

// Adds the `pairs` whose distance in the list is at most `limit` to a group.
void SurfaceContact::select(const CandidateList& list, std::span<const FeaturePair> pairs,
                            float limit, PairGroup& group) {
  const SurfaceFeatures a(scene_.bodies[list.body_a]), b(scene_.bodies[list.body_b]);
  const bool swapped = !group.edges && group.surface != list.body_b;
  const SurfaceFeatures &first = swapped ? b : a, &second = swapped ? a : b;
  // The first loop has no branch, which would be hard to predict.
  const auto select_part = [&](int begin, int end, Selected& part) {
    part.clear();
    part.numbers.resize(end - begin);
    int selected = 0;
    for (int i = begin; i < end; ++i) {
      part.numbers[selected] = i;
      selected += pairs[i].distance <= limit ? 1 : 0;
    }
    for (const int i : std::span(part.numbers).first(selected)) {
      part.nodes.push_back(points_of(group.edges, first, second, pairs[i]));
      if (group.samples) part.triangles.push_back(pairs[i].b);
    }
  };
  const int count = static_cast<int>(pairs.size());
  for (const Selected& part : parallel_parts(selected_, count, scene_.threads, select_part))
    group.append(part);
}

// Returns the candidates that may be closer than thickness + reach. The reach is `sample_reach` for
// samples and for all pairs with a sleeping body, and `reach` for other pairs. Candidates in `kept`
// that are still complete are not selected again. Precondition: `kept` is empty, or was last used
// with the same reaches.
std::vector<const SurfaceContact::PairGroup*> SurfaceContact::groups_within(double sample_reach,
                                                                            double reach,
                                                                            KeptGroups& kept) {
  const std::span<const CandidateList> lists = search_.lists();
  kept.resize(lists.size());
  std::vector<const PairGroup*> groups;
  for (std::size_t l = 0; l < lists.size(); ++l) {
    const CandidateList& list = lists[l];
    GroupsOfList& of = kept[l];
    if (of.version != list.version || list.drift > of.drift) {
      of.version = -1;
      of.drift = list.drift + part_for_groups * search_.candidate_slack();
      select_groups(list, sample_reach, reach, of);
      of.version = list.version;
    }
    for (PairGroup& group : of.groups) {
      if (group.nodes.empty()) continue;
      // The coefficient may vary in time.
      group.friction = group.has_spheres() ? spheres_.friction(list.body_a, list.body_b)
                                           : friction_.of(list.body_a, list.body_b);
      groups.push_back(&group);
    }
  }
  return groups;
}

// Selects the groups of a list that drifts no farther than `of.drift`.
void SurfaceContact::select_groups(const CandidateList& list, double sample_reach, double reach,
                                   GroupsOfList& of) {
  const std::vector<FeaturePair>* kinds[3] = {&list.vertex_triangle, &list.triangle_vertex,
                                              &list.edge_edge};
  for (int kind = 0; kind < 3; ++kind) {
    PairGroup& group = of.groups[kind];
    group.clear();
    if (kinds[kind]->empty()) continue;
    describe(list, kind, group);
    const bool whole_range = group.samples || scene_.bodies[list.body_b].sleeps;
    const double within = list.thickness + (whole_range ? sample_reach : reach) + of.drift;
    select(list, *kinds[kind], static_cast<float>(within) * (1 + 1e-6F), group);
  }
}

// Returns the neighbours at rest that may touch. They have no thickness.
std::vector<SurfaceContact::PairGroup> SurfaceContact::neighbours() const {
  std::vector<PairGroup> groups;
  for (const CandidateList& list : search_.lists()) {
    const auto limit = static_cast<float>(list.drift) * (1 + 1e-6F);
    for (const auto* pairs :
         {&list.near_vertex_triangle, &list.near_triangle_vertex, &list.near_edge_edge}) {
      if (pairs->empty()) continue;
      const bool swapped = pairs == &list.near_triangle_vertex;
      PairGroup group;
      group.edges = pairs == &list.near_edge_edge;
      group.body_a = list.body_a;
      group.body_b = list.body_b;
      group.surface = swapped ? list.body_a : list.body_b;
      const SurfaceFeatures first(scene_.bodies[swapped ? list.body_b : list.body_a]);
      const SurfaceFeatures second(scene_.bodies[group.surface]);
      for (const FeaturePair& pair : *pairs) {
        if (pair.distance <= limit)
          group.nodes.push_back(points_of(group.edges, first, second, pair));
      }
      if (!group.nodes.empty()) groups.push_back(std::move(group));
    }
  }
  return groups;
}

}  // namespace weft::sim
