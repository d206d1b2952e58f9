#include "sim/contact/device_candidates.h"

#include "sim/base/parallel.h"
#include "sim/contact/contact_stiffness.h"
#include "sim/contact/surface_features.h"

namespace weft::sim {

namespace {

// The pairs of one kind in a list: the vertices of one body with the triangles of another, or the
// edges of both.
struct PairKind {
  const CandidateList& list;
  std::span<const FeaturePair> pairs;
  bool edges;
  int first, second;  // bodies of the features
  bool samples;
  const bsi::Neighbourhoods* across = nullptr;  // of the first features, across seams
};

// Calls use(PairKind) for all kinds that have pairs.
template <class Use>
void for_each_kind(const Scene& scene, std::span<const CandidateList> lists, const Use& use) {
  for (const CandidateList& list : lists) {
    const int a = list.body_a, b = list.body_b;
    for (const PairKind& kind : {PairKind{list, list.vertex_triangle, false, a, b,
                                          scene.bodies[a].dynamic, list.first_across},
                                 PairKind{list, list.triangle_vertex, false, b, a,
                                          scene.bodies[b].dynamic, list.second_across},
                                 PairKind{list, list.edge_edge, true, a, b, false}}) {
      if (!kind.pairs.empty()) use(kind);
    }
  }
}

std::array<std::uint32_t, 4> unsigned_of(const std::array<int, 4>& points) {
  return {static_cast<std::uint32_t>(points[0]), static_cast<std::uint32_t>(points[1]),
          static_cast<std::uint32_t>(points[2]), static_cast<std::uint32_t>(points[3])};
}
std::array<int, 4> signed_of(const std::array<std::uint32_t, 4>& points) {
  return {static_cast<int>(points[0]), static_cast<int>(points[1]), static_cast<int>(points[2]),
          static_cast<int>(points[3])};
}

}  // namespace

DeviceCandidates device_candidates(const Scene& scene, std::span<const CandidateList> lists,
                                   std::span<const bsi::SurfaceTerms> surfaces,
                                   std::span<const Vec3> rest) {
  DeviceCandidates result;
  std::uint32_t group = 0;
  for_each_kind(scene, lists, [&](const PairKind& kind) {
    const std::size_t before = result.candidates.size();
    result.candidates.resize(before + kind.pairs.size());
    const std::span<gpu::ContactCandidate> candidates(result.candidates.data() + before,
                                                      kind.pairs.size());
    const SurfaceFeatures first(scene.bodies[kind.first]), second(scene.bodies[kind.second]);
    parallel_chunks(static_cast<int>(kind.pairs.size()), scene.threads, [&](int begin, int end) {
      for (int i = begin; i < end; ++i) {
        const FeaturePair& pair = kind.pairs[i];
        candidates[i] = {unsigned_of(points_of(kind.edges, first, second, pair)), 0, pair.distance};
        if (!kind.samples) continue;
        const int own = kind.list.is_self() || kind.across != nullptr ? pair.a : -1;
        candidates[i].own_features = surfaces[kind.second].own_features(pair.b, own, kind.across);
      }
    });
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      if (kind.samples && i > 0 && kind.pairs[i].a == kind.pairs[i - 1].a) continue;
      const std::array<int, 4> points = signed_of(candidates[i].points);
      gpu::ContactRow row{static_cast<std::uint32_t>(before + i), group};
      row.stiffness = kind.samples ? sample_stiffness(scene, scene.bodies[kind.second], points[0])
                                   : pair_stiffness(scene, points, kind.edges);
      if (kind.edges) row.parallel_threshold = parallel_threshold(rest, points);
      result.rows.push_back(row);
    }
    ++group;
  });
  return result;
}

std::vector<gpu::ContactGroup> device_groups(const Scene& scene,
                                             std::span<const CandidateList> lists,
                                             const PairFriction& friction,
                                             std::span<const Vec3> spins) {
  const ContactCase& contact = scene.source.contact;
  std::vector<gpu::ContactGroup> groups;
  for_each_kind(scene, lists, [&](const PairKind& kind) {
    const CandidateList& list = kind.list;
    gpu::ContactGroup& group = groups.emplace_back();
    group.edges = kind.edges;
    group.samples = kind.samples;
    group.obstacle = !scene.bodies[list.body_b].dynamic;
    group.thickness = list.thickness;
    group.range = kind.samples ? contact.range : short_range * contact.range;
    group.damping_time = contact.damping_time;
    group.friction = friction.of(list.body_a, list.body_b);
    group.friction_speed = contact.friction_speed;
    if (group.obstacle) group.spin = spins[list.body_b];
    group.limit = static_cast<float>(list.thickness + group.range + list.drift) * (1 + 1e-6F);
  });
  return groups;
}

}  // namespace weft::sim
