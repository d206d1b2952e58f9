// Compares the narrow phase in batches with scalar functions, for every instruction set, in one
// run.
#include "bsi/narrow_phase.h"

#include <algorithm>
#include <cstdio>
#include <functional>
#include <iterator>

#include "bench/experiments.h"
#include "bench/medians.h"
#include "bench/scenes.h"
#include "bench/triangle_test.h"
#include "bench/weft_method.h"
#include "bsi/continuous_collision.h"
#include "bsi/detail/feature_batches.h"
#include "bsi/detail/instruction_set.h"
#include "bsi/proximity.h"

namespace weft::bench {

namespace {

using bsi::FeatureKind;
using bsi::FourParticles;

constexpr int repeats = 7;

// Work on `count` pairs, scalar and in batches.
struct Work {
  const char* name;
  std::size_t count;
  std::function<long()> scalar, batch;  // both return a number that must agree
};

// Prints ns per pair and ratios, medians of interleaved repeats. Returns false if the results
// differ.
bool compare(const Work& work) {
  const auto sets = bsi::available_instruction_sets();
  std::vector<double> scalar;
  std::vector<std::vector<double>> batch(sets.size()), ratio(sets.size());
  const auto nanoseconds = [&](const std::function<long()>& run, long& result) {
    return 1e9 * thread_time_of([&] { result = run(); }) / static_cast<double>(work.count);
  };
  bool same = true;
  long expected = 0;
  for (int i = 0; i < repeats; ++i) {
    scalar.push_back(nanoseconds(work.scalar, expected));
    for (std::size_t s = 0; s < sets.size(); ++s) {
      bsi::use_instruction_set(sets[s]);
      long found = 0;
      batch[s].push_back(nanoseconds(work.batch, found));
      ratio[s].push_back(scalar.back() / batch[s].back());
      same = same && found == expected;
    }
  }
  const double part = 100 * static_cast<double>(expected) / static_cast<double>(work.count);
  std::printf("%-26s %9zu %7.1f %9.1f", work.name, work.count, part, median(scalar));
  for (std::size_t s = 0; s < sets.size(); ++s)
    std::printf(" %9.1f (%4.1f x)", median(batch[s]), median(ratio[s]));
  std::printf("%s\n", same ? "" : "  RESULTS DIFFER");
  return same;
}

std::vector<bsi::LeafPair> candidates_of(WeftMethod& method) {
  std::vector<bsi::LeafPair> candidates;
  method.rebuild();
  method.query(candidates);
  if (candidates.empty()) method.list(candidates);
  return candidates;
}

bool compare_triangles(const CollisionScene& scene) {
  const Body& body = scene.bodies.front();
  WeftMethod by_blocks(scene, {});
  const std::vector<bsi::LeafPair> candidates = candidates_of(by_blocks);
  const bsi::TriangleSet set{body.start, body.triangles};
  const auto scalar = [&] {
    return count_hits({body.start, body.triangles}, {body.start, body.triangles}, candidates,
                      scene.margin);
  };
  const auto batch = [&](bool distances) {
    bsi::TriangleHits hits;
    bsi::NarrowPhaseCounters counters;
    bsi::find_triangle_hits(set, set, candidates, {scene.margin, distances, 1}, hits, counters);
    return static_cast<long>(hits.pairs.size());
  };
  const std::string name = scene.name + ", triangles";
  const std::string blocks = scene.name + ", by leaf blocks";
  const std::string measured = scene.name + ", with distances";
  return compare({name.c_str(), candidates.size(), scalar, [&] { return batch(false); }}) &&
         compare({blocks.c_str(), candidates.size(), scalar,
                  [&] { return by_blocks.hits({}, scene.margin); }}) &&
         compare({measured.c_str(), candidates.size(), scalar, [&] { return batch(true); }});
}

// Returns, for every candidate, a corner of one triangle and the other triangle, or an edge of
// each.
std::vector<FourParticles> features_of(FeatureKind kind, const Body& body,
                                       std::span<const bsi::LeafPair> candidates) {
  std::vector<FourParticles> pairs;
  for (const auto& [a, b] : candidates) {
    const auto &t = body.triangles[a], &u = body.triangles[b];
    pairs.push_back(kind == FeatureKind::edge_edge ? FourParticles{t[0], t[1], u[0], u[1]}
                                                   : FourParticles{t[0], u[0], u[1], u[2]});
  }
  return pairs;
}

bsi::FourPoints points_of(std::span<const bsi::Vec3> x, const FourParticles& pair) {
  return {x[pair[0]], x[pair[1]], x[pair[2]], x[pair[3]]};
}

bool compare_features(FeatureKind kind, const CollisionScene& swept,
                      std::span<const bsi::LeafPair> candidates) {
  const Body& body = swept.bodies.front();
  const std::vector<FourParticles> pairs = features_of(kind, body, candidates);
  const bool edges = kind == FeatureKind::edge_edge;
  const auto scalar_reach = [&] {
    long count = 0;
    for (const FourParticles& pair : pairs) {
      const auto [x0, x1, x2, x3] = points_of(body.start, pair);
      const bsi::Closest closest = edges ? bsi::closest_edge_edge(x0, x1, x2, x3)
                                         : bsi::closest_vertex_triangle(x0, x1, x2, x3);
      count += closest.squared_distance <= swept.margin * swept.margin;
    }
    return count;
  };
  const auto batch_reach = [&] {
    std::vector<bsi::PairInReach> found;
    bsi::find_in_reach(kind, body.start, pairs, swept.margin, found);
    return static_cast<long>(found.size());
  };
  const auto is_safe = [&](const FourParticles& pair) {
    const bsi::FourPoints from = points_of(body.start, pair), to = points_of(body.end, pair);
    return (edges ? bsi::safe_fraction_edge_edge(from, to, 0)
                  : bsi::safe_fraction_vertex_triangle(from, to, 0)) == 1;
  };
  const auto paths = [&](const char* name, const std::vector<FourParticles>& of) {
    const auto scalar = [&] { return static_cast<long>(std::ranges::count_if(of, is_safe)); };
    const auto batch = [&] {
      std::vector<double> fraction(of.size());
      bsi::safe_fractions(kind, body.start, body.end, of, 0, fraction);
      return static_cast<long>(std::count(fraction.begin(), fraction.end(), 1.0));
    };
    return compare({name, of.size(), scalar, batch});
  };
  std::vector<FourParticles> unsafe;
  std::ranges::remove_copy_if(pairs, std::back_inserter(unsafe), is_safe);
  return compare({edges ? "edge-edge in reach" : "vertex-triangle in reach", pairs.size(),
                  scalar_reach, batch_reach}) &&
         paths(edges ? "edge-edge paths" : "vertex-triangle paths", pairs) &&
         (unsafe.empty() ||
          paths(edges ? "edge-edge paths, unsafe" : "vertex-triangle, unsafe", unsafe));
}

}  // namespace

int run_narrow_phase(int size) {
  const bsi::InstructionSet before = bsi::instruction_set();
  std::printf(
      "sheets of %d x %d vertices, ns a pair (CPU) and times faster than scalar,\n"
      "medians of %d interleaved repeats, one thread\n\n%-26s %9s %7s %9s",
      size, size, repeats, "", "pairs", "found %", "scalar");
  for (const bsi::InstructionSet set : bsi::available_instruction_sets())
    std::printf(" %18s", bsi::name(set).data());
  std::printf("\n");
  bool same = true;
  for (const char* name : {"rolled", "pleated", "crumpled"}) {
    const CollisionScene scene = make_scene(name, size);
    same = compare_triangles(scene) && same;
  }
  const CollisionScene swept = make_scene("crumpled-swept", size);
  WeftMethod method(swept, {});
  const std::vector<bsi::LeafPair> candidates = candidates_of(method);
  same = compare_features(FeatureKind::vertex_triangle, swept, candidates) && same;
  same = compare_features(FeatureKind::edge_edge, swept, candidates) && same;
  bsi::use_instruction_set(before);
  return same ? 0 : 1;
}

}  // namespace weft::bench
