// Pairs of triangles: CPU time of the batches, for every instruction set, beside that of the scalar
// functions, in one run.
#include "bsi/narrow_phase.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "bench/medians.h"
#include "bsi/instruction_set.h"
#include "bsi/shapes.h"

namespace {

using namespace weft::bsi;

struct Scene {
  const char* name;
  std::vector<Vec3> positions;
  std::vector<std::array<int, 3>> triangles;
  std::vector<LeafPair> candidates;
  double margin = 0;
};

bool share_particle(const std::array<int, 3>& a, const std::array<int, 3>& b) {
  for (int i : a)
    for (int j : b)
      if (i == j) return true;
  return false;
}

// The pairs of triangles whose boxes come within the margin, by sorting along x.
void find_candidates(Scene& scene) {
  struct Item {
    Vec3 low, high;
    int triangle;
  };
  std::vector<Item> items;
  for (int t = 0; t < static_cast<int>(scene.triangles.size()); ++t) {
    const auto& [i, j, k] = scene.triangles[t];
    const Vec3 &a = scene.positions[i], &b = scene.positions[j], &c = scene.positions[k];
    items.push_back({a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c), t});
  }
  std::sort(items.begin(), items.end(),
            [](const Item& p, const Item& q) { return p.low.x() < q.low.x(); });
  for (std::size_t p = 0; p < items.size(); ++p) {
    for (std::size_t q = p + 1; q < items.size(); ++q) {
      if (items[q].low.x() - items[p].high.x() > scene.margin) break;
      const int a = std::min(items[p].triangle, items[q].triangle);
      const int b = std::max(items[p].triangle, items[q].triangle);
      const bool near = ((items[q].low - items[p].high).array() <= scene.margin).all() &&
                        ((items[p].low - items[q].high).array() <= scene.margin).all();
      if (near && !share_particle(scene.triangles[a], scene.triangles[b]))
        scene.candidates.push_back({a, b});
    }
  }
  std::sort(scene.candidates.begin(), scene.candidates.end());
}

// A sheet of 2 m x 2 m, bent by `bend`.
template <class Bend>
Scene sheet_scene(const char* name, int n, double margin, const Bend& bend) {
  Surface sheet = make_rectangle(2, 2, n, n);
  Scene scene{name, sheet.positions, build_mesh(sheet.atlas).triangles, {}, margin};
  for (Vec3& p : scene.positions) p = bend(p);
  find_candidates(scene);
  return scene;
}

std::vector<Scene> all_scenes(int n) {
  std::vector<Scene> scenes;
  // A roll whose layers are 1.5 mm apart.
  scenes.push_back(sheet_scene("rolled", n, 2e-3, [](const Vec3& p) {
    const double pitch = 1.5e-3 / (2 * M_PI), along = p.x() + 1.2;
    const double angle = std::sqrt(2 * along / pitch);
    return Vec3(pitch * angle * std::cos(angle), p.y(), pitch * angle * std::sin(angle));
  }));
  scenes.push_back(sheet_scene("pleated", n, 2e-3, [](const Vec3& p) {
    return Vec3(0.02 * p.x(), p.y() + 1e-3 * std::sin(40 * p.x()), 0.1 * std::sin(60 * p.x()));
  }));
  // Crumpled at random, far through itself.
  scenes.push_back(sheet_scene("crumpled", n, 0, [](const Vec3& p) {
    const Vec3 q(p.x() * 3, p.y() * 3, 0);
    return Vec3(0.3 * std::sin(4 * q.x() + 1) + 0.2 * std::sin(3 * q.y()),
                0.3 * std::sin(4 * q.y() + 2) + 0.2 * std::cos(5 * q.x()),
                0.3 * std::sin(3 * q.x() + 2 * q.y()));
  }));
  return scenes;
}

std::size_t scalar_hits(const Scene& scene) {
  std::size_t hits = 0;
  for (const LeafPair& pair : scene.candidates) {
    std::array<Vec3, 3> a, b;
    for (int i = 0; i < 3; ++i) {
      a[i] = scene.positions[scene.triangles[pair.a][i]];
      b[i] = scene.positions[scene.triangles[pair.b][i]];
    }
    hits += squared_triangle_distance(a, b) <= scene.margin * scene.margin;
  }
  return hits;
}

struct Cost {
  std::size_t hits = 0;
  NarrowPhaseCounters counters;
  std::vector<double> hits_alone, distances, over_scalar;  // ns a candidate; the last a ratio
};

double measure(const Scene& scene, bool distances, Cost& cost) {
  TriangleHits hits;
  const TriangleSet set{scene.positions, scene.triangles};
  cost.counters = {};
  const double time = weft::bench::cpu_time_of([&] {
    find_triangle_hits(set, set, scene.candidates, {scene.margin, distances, 1}, hits,
                       cost.counters);
  });
  cost.hits = hits.pairs.size();
  return 1e9 * time / static_cast<double>(scene.candidates.size());
}

void report(const Scene& scene, int repeats) {
  const auto sets = available_instruction_sets();
  std::vector<Cost> cost(sets.size());
  std::vector<double> scalar;
  std::size_t expected = 0;
  for (int i = 0; i < repeats; ++i) {
    scalar.push_back(1e9 / static_cast<double>(scene.candidates.size()) *
                     weft::bench::cpu_time_of([&] { expected = scalar_hits(scene); }));
    for (std::size_t s = 0; s < sets.size(); ++s) {
      use_instruction_set(sets[s]);
      cost[s].distances.push_back(measure(scene, true, cost[s]));
      cost[s].hits_alone.push_back(measure(scene, false, cost[s]));
      cost[s].over_scalar.push_back(scalar.back() / cost[s].hits_alone.back());
    }
  }
  const double total = static_cast<double>(scene.candidates.size());
  std::printf("%s: %zu candidates, %.1f %% hits; scalar %.1f ns\n", scene.name,
              scene.candidates.size(), 100 * static_cast<double>(expected) / total,
              weft::bench::median(scalar));
  for (std::size_t s = 0; s < sets.size(); ++s) {
    std::printf(
        "  %-9s %7.1f ns, with distances %7.1f ns, %6.1f x faster than scalar; "
        "%.3f %% in double, %.4f %% scalar%s\n",
        name(sets[s]).data(), weft::bench::median(cost[s].hits_alone),
        weft::bench::median(cost[s].distances), weft::bench::median(cost[s].over_scalar),
        100 * static_cast<double>(cost[s].counters.measured) / total,
        100 * static_cast<double>(cost[s].counters.scalar) / total,
        cost[s].hits == expected ? "" : "  HITS DIFFER");
    if (cost[s].hits != expected) std::exit(1);
  }
}

}  // namespace

int main() {
  std::printf("ns a candidate (CPU), medians of 7 interleaved repeats, one thread\n");
  for (const Scene& scene : all_scenes(129)) report(scene, 7);
  return 0;
}
