#include "bsi/detail/neighbourhoods.h"

#include <algorithm>

#include "bsi/proximity.h"

namespace weft::bsi {

namespace {

// Widens the radius by more than rounding, so that equal distances at rest are treated alike.
constexpr double widening = 1 + 1e-9;

constexpr int vertices_per_chunk = 256;

}  // namespace

// The neighbourhood of one vertex while it grows, with lists that the next vertex reuses.
struct Neighbourhoods::Flood {
  explicit Flood(std::size_t triangle_count) : seen(triangle_count, -1) {}

  std::vector<int> seen;       // by triangle: the last vertex that has met it
  std::vector<int> triangles;  // of the neighbourhood
  // Runs of a chunk of vertices, and their number by vertex.
  std::vector<Run> runs;
  std::vector<int> counts;
  bool beyond_ring = false;

  void append_runs() {
    std::sort(triangles.begin(), triangles.end());
    const std::size_t before = runs.size();
    for (const int t : triangles) {
      if (runs.size() > before && runs.back().last + 1 == t) {
        ++runs.back().last;
      } else {
        runs.push_back({t, t});
      }
    }
    counts.push_back(static_cast<int>(runs.size() - before));
  }
};

Neighbourhoods::Neighbourhoods(const Mesh& mesh, std::span<const Vec3> rest, double radius,
                               int threads)
    : mesh_(mesh), squared_radius_(radius * radius * widening * widening) {
  const int count = static_cast<int>(rest.size());
  list_triangles(count);
  const int chunks = (count + vertices_per_chunk - 1) / vertices_per_chunk;
  std::vector<std::vector<Run>> runs(chunks);
  std::vector<std::vector<int>> counts(chunks);
  bool beyond_rings = false;
#pragma omp parallel num_threads(threads) if (threads > 1 && chunks > 1)
  {
    Flood flood(mesh.triangles.size());
#pragma omp for schedule(dynamic) reduction(|| : beyond_rings)
    for (int c = 0; c < chunks; ++c) {
      flood.runs.clear();
      flood.counts.clear();
      const int last = std::min(count, (c + 1) * vertices_per_chunk);
      for (int v = c * vertices_per_chunk; v < last; ++v) {
        beyond_rings = collect(v, rest, flood) || beyond_rings;
        flood.append_runs();
      }
      runs[c] = flood.runs;
      counts[c] = flood.counts;
    }
  }
  if (!beyond_rings) return;
  run_start_.push_back(0);
  for (int c = 0; c < chunks; ++c) {
    runs_.insert(runs_.end(), runs[c].begin(), runs[c].end());
    for (const int n : counts[c]) run_start_.push_back(run_start_.back() + n);
  }
}

Neighbourhoods::Neighbourhoods(const Mesh& mesh, int vertex_count,
                               std::span<const std::vector<int>> triangles)
    : mesh_(mesh), squared_radius_(0) {
  list_triangles(vertex_count);
  Flood flood(0);
  run_start_.push_back(0);
  for (const std::vector<int>& of_vertex : triangles) {
    flood.triangles = of_vertex;
    flood.append_runs();
    run_start_.push_back(static_cast<int>(flood.runs.size()));
  }
  runs_ = flood.runs;
}

std::vector<int> Neighbourhoods::triangles(int vertex) const {
  const std::span<const int> ring = triangles_of(vertex);
  if (are_rings()) return {ring.begin(), ring.end()};
  std::vector<int> all;
  for (int r = run_start_[vertex]; r < run_start_[vertex + 1]; ++r) {
    for (int t = runs_[r].first; t <= runs_[r].last; ++t) all.push_back(t);
  }
  return all;
}

void Neighbourhoods::list_triangles(int vertex_count) {
  triangle_start_.assign(vertex_count + 1, 0);
  for (const auto& corners : mesh_.triangles)
    for (const int v : corners) ++triangle_start_[v + 1];
  for (int v = 0; v < vertex_count; ++v) triangle_start_[v + 1] += triangle_start_[v];
  triangles_.resize(triangle_start_.back());
  std::vector<int> next(triangle_start_.begin(), triangle_start_.end() - 1);
  for (int t = 0; t < static_cast<int>(mesh_.triangles.size()); ++t)
    for (const int v : mesh_.triangles[t]) triangles_[next[v]++] = t;
}

// Sets flood.triangles to the neighbourhood of a vertex. Returns true if it contains a triangle
// without that vertex.
bool Neighbourhoods::collect(int vertex, std::span<const Vec3> rest, Flood& flood) const {
  flood.triangles.clear();
  for (const int t : triangles_of(vertex)) {
    flood.seen[t] = vertex;
    flood.triangles.push_back(t);
  }
  const std::size_t ring = flood.triangles.size();
  for (std::size_t next = 0; next < flood.triangles.size(); ++next) {
    for (const int corner : mesh_.triangles[flood.triangles[next]]) {
      if (corner == vertex) continue;
      for (const int t : triangles_of(corner)) {
        if (flood.seen[t] == vertex) continue;
        flood.seen[t] = vertex;
        const auto& [a, b, c] = mesh_.triangles[t];
        if (closest_vertex_triangle(rest[vertex], rest[a], rest[b], rest[c]).squared_distance <
            squared_radius_)
          flood.triangles.push_back(t);
      }
    }
  }
  return flood.triangles.size() > ring;
}

bool Neighbourhoods::holds_run(int vertex, int first, int last) const {
  if (are_rings()) return false;
  const auto begin = runs_.begin() + run_start_[vertex],
             end = runs_.begin() + run_start_[vertex + 1];
  const auto run = std::partition_point(begin, end, [&](const Run& r) { return r.last < last; });
  return run != end && run->first <= first;
}

bool Neighbourhoods::contains(int vertex, int triangle) const {
  return holds_run(vertex, triangle, triangle);
}

bool Neighbourhoods::contains_quad(int vertex, int quad) const {
  return holds_run(vertex, 2 * quad, 2 * quad + 1);
}

bool Neighbourhoods::touches(int vertex, int other) const {
  return std::ranges::any_of(triangles_of(other), [&](int t) { return contains(vertex, t); });
}

bool Neighbourhoods::contains_edge(int vertex, const Edge& edge) const {
  return contains(vertex, edge.triangle[0]) &&
         (edge.triangle[1] < 0 || contains(vertex, edge.triangle[1]));
}

bool Neighbourhoods::are_neighbours(const Edge& one, const Edge& other) const {
  return contains_edge(one.vertex[0], other) || contains_edge(one.vertex[1], other) ||
         contains_edge(other.vertex[0], one) || contains_edge(other.vertex[1], one);
}

}  // namespace weft::bsi
