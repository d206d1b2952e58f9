#include "sim/run/wrong_sides.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <tuple>

#include "bsi/triangle_intersection.h"

namespace weft::sim {

namespace {

// A cut of an edge by a triangle of another body, or of the same one.
struct EdgeCut {
  int edge = 0;  // index into the mesh of the body
  int other = 0, triangle = 0;
};

// The cuts of the edges of each body: sorted, each once.
using Cuts = std::vector<std::vector<EdgeCut>>;

bsi::Point3 coordinates(const Vec3& x) { return {x.x(), x.y(), x.z()}; }

void add_cuts(const Scene& scene, std::span<const Vec3> points, std::span<const Vec3> wider,
              int body, int triangle, int other, int other_triangle, Cuts& cuts) {
  const SceneBody &owner = scene.bodies[body], &cutter = scene.bodies[other];
  const auto& corners = cutter.surface_mesh().triangles[other_triangle];
  const auto end = [&](int local) { return coordinates(points[owner.first_point + local]); };
  const auto corner = [&](int i) { return coordinates(wider[cutter.first_point + corners[i]]); };
  const bsi::Triangle3 face{corner(0), corner(1), corner(2)};
  for (const int edge : owner.surface_mesh().triangle_edges[triangle]) {
    const auto [from, to] = owner.surface_mesh().edges[edge].vertex;
    const bsi::Triangle3 segment{end(from), end(to), end(to)};
    if (bsi::triangles_meet(segment, face)) cuts[body].push_back({edge, other, other_triangle});
  }
}

Cuts find_cuts(const Scene& scene, std::span<const Vec3> points, std::span<const Vec3> wider,
               std::span<const Crossing> near) {
  Cuts cuts(scene.bodies.size());
  for (const Crossing& c : near) {
    add_cuts(scene, points, wider, c.surface_a, c.triangle_a, c.surface_b, c.triangle_b, cuts);
    add_cuts(scene, points, wider, c.surface_b, c.triangle_b, c.surface_a, c.triangle_a, cuts);
  }
  const auto key = [](const EdgeCut& cut) { return std::tie(cut.edge, cut.other, cut.triangle); };
  for (std::vector<EdgeCut>& of_body : cuts) {
    std::ranges::sort(of_body, {}, key);
    const auto same = [&](const EdgeCut& a, const EdgeCut& b) { return key(a) == key(b); };
    of_body.erase(std::unique(of_body.begin(), of_body.end(), same), of_body.end());
  }
  return cuts;
}

// Sets of points that edges join.
class JoinedPoints {
 public:
  explicit JoinedPoints(int count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  int root(int point) {
    while (parent_[point] != point) point = parent_[point] = parent_[parent_[point]];
    return point;
  }
  void join(int a, int b) { parent_[root(a)] = root(b); }

 private:
  std::vector<int> parent_;
};

// Appends the parts that the cuts of one body cut off.
void add_parts(const SceneBody& body, int index, const std::vector<EdgeCut>& cuts,
               std::vector<CutOffPart>& parts) {
  const bsi::Mesh& mesh = body.surface_mesh();
  std::vector<int> times_cut(mesh.edges.size(), 0);
  for (const EdgeCut& cut : cuts) ++times_cut[cut.edge];
  JoinedPoints whole(body.point_count()), joined(body.point_count());
  for (std::size_t e = 0; e < mesh.edges.size(); ++e) {
    const auto [from, to] = mesh.edges[e].vertex;
    whole.join(from, to);
    if (times_cut[e] % 2 == 0) joined.join(from, to);
  }
  std::vector<std::vector<int>> members(body.point_count());
  for (int p = 0; p < body.point_count(); ++p) members[joined.root(p)].push_back(p);
  std::vector<int> largest(body.point_count(), -1);  // by the root in `whole`
  for (int root = 0; root < body.point_count(); ++root) {
    if (members[root].empty()) continue;
    int& best = largest[whole.root(root)];
    if (best < 0 || members[root].size() > members[best].size()) best = root;
  }
  std::map<std::pair<int, int>, CutOffPart> found;  // by part and the body that cuts it off
  for (const EdgeCut& cut : cuts) {
    if (times_cut[cut.edge] % 2 == 0) continue;
    const auto ends = mesh.edges[cut.edge].vertex;
    for (const int side : {0, 1}) {
      const int root = joined.root(ends[side]);
      if (root == largest[whole.root(root)] || root == joined.root(ends[1 - side])) continue;
      CutOffPart& part = found[{root, cut.other}];
      part.body = index;
      part.other = cut.other;
      part.points_beyond.push_back(ends[1 - side]);
      part.cutting_triangles.push_back(cut.triangle);
    }
  }
  for (auto& [key, part] : found) {
    part.points = members[key.first];
    parts.push_back(std::move(part));
  }
}

}  // namespace

std::vector<CutOffPart> find_cut_off_parts(const Scene& scene, std::span<const Vec3> points,
                                           std::span<const Vec3> wider,
                                           std::span<const Crossing> near) {
  const Cuts cuts = find_cuts(scene, points, wider, near);
  std::vector<CutOffPart> parts;
  for (int body = 0; body < static_cast<int>(scene.bodies.size()); ++body)
    if (!cuts[body].empty()) add_parts(scene.bodies[body], body, cuts[body], parts);
  std::ranges::stable_sort(parts, {}, [](const CutOffPart& p) { return p.points.size(); });
  return parts;
}

}  // namespace weft::sim
