#include "sim/contact/curved_paths.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <utility>

#include "bsi/detail/feature_batches.h"
#include "sim/scene/spline_sampling.h"

namespace weft::sim {

namespace {

// Number of parts into which the sides of a shell's triangles are divided.
constexpr int shell_division = 4;

// The corners of a divided triangle have the barycentric weights (n - i - j, i, j) / n. They are
// listed by j, then i.
int corner(int division, int i, int j) { return j * (2 * division + 3 - j) / 2 + i; }

struct Division {
  explicit Division(int n) {
    for (int j = 0; j <= n; ++j) {
      for (int i = 0; i + j <= n; ++i) weights.push_back({n - i - j, i, j});
    }
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i + j < n; ++i) {
        const int a = corner(n, i, j), b = corner(n, i + 1, j), c = corner(n, i, j + 1);
        triangles.push_back({a, b, c});
        for (const auto& [from, to] : {std::pair(a, b), {b, c}, {c, a}})
          edges.push_back({from, to});
        if (i + j < n - 1) triangles.push_back({b, corner(n, i + 1, j + 1), c});
      }
    }
  }
  std::vector<std::array<int, 3>> weights;  // times n
  std::vector<std::array<int, 3>> triangles;
  std::vector<std::array<int, 2>> edges;
};

const Division& division_of(int n) {
  static const Division point(0), whole(1), fine(shell_division);
  return n == 0 ? point : n == 1 ? whole : fine;
}

// Lists the pairs of features of two divided triangles, whose corners are numbered through.
struct DividedPairs {
  DividedPairs(const Division& one, const Division& other) {
    const int offset = static_cast<int>(one.weights.size());
    for (int vertex = 0; vertex < offset; ++vertex) {
      for (const auto& [a, b, c] : other.triangles)
        vertex_triangle.push_back({vertex, offset + a, offset + b, offset + c});
    }
    for (int vertex = 0; vertex < std::ssize(other.weights); ++vertex) {
      for (const auto& [a, b, c] : one.triangles)
        vertex_triangle.push_back({offset + vertex, a, b, c});
    }
    for (const auto& [a, b] : one.edges) {
      for (const auto& [c, d] : other.edges) edge_edge.push_back({a, b, offset + c, offset + d});
    }
  }
  std::vector<bsi::FourParticles> vertex_triangle, edge_edge;
};

const DividedPairs& pairs_of(int division, int other_division) {
  static const auto all = [] {
    std::vector<DividedPairs> pairs;
    for (const int one : {0, 1, shell_division})
      for (const int other : {0, 1, shell_division})
        pairs.emplace_back(division_of(one), division_of(other));
    return pairs;
  }();
  return all[3 * std::min(division, 2) + std::min(other_division, 2)];
}

Eigen::AlignedBox3d box_of_path(std::span<const Vec3> start, std::span<const Vec3> end) {
  Eigen::AlignedBox3d box;
  for (const auto& points : {start, end}) {
    for (const Vec3& each : points) box.extend(each);
  }
  return box;
}

bool are_safe(bsi::FeatureKind kind, std::span<const Vec3> start, std::span<const Vec3> end,
              std::span<const bsi::FourParticles> pairs, double separation) {
  std::vector<double> fractions(pairs.size());
  bsi::safe_fractions(kind, start, end, pairs, separation, fractions);
  return std::ranges::all_of(fractions, [](double fraction) { return fraction >= 1; });
}

// True if two pieces of surface provably stay apart on their paths, and on all paths that deviate
// from them by at most `stray` together.
template <class Piece>
bool stay_apart(const Piece& one, const Piece& other, double stray) {
  const double separation = one.deviation + other.deviation + stray;
  const double between =
      box_of_path(one.start, one.end).exteriorDistance(box_of_path(other.start, other.end));
  if (between > (1 + 1e-9) * separation + 1e-12) return true;
  const DividedPairs& pairs = pairs_of(one.division, other.division);
  std::vector<Vec3> start(one.start), end(one.end);
  start.insert(start.end(), other.start.begin(), other.start.end());
  end.insert(end.end(), other.end.begin(), other.end.end());
  return are_safe(bsi::FeatureKind::vertex_triangle, start, end, pairs.vertex_triangle,
                  separation) &&
         are_safe(bsi::FeatureKind::edge_edge, start, end, pairs.edge_edge, separation);
}

}  // namespace

CurvedPaths::CurvedPaths(const Scene& scene) : scene_(scene) {
  std::vector<int> counts(scene.point_count, 0);
  const auto visit = [&](const auto& add) {
    for (const SceneBody& body : scene.bodies) {
      const auto& triangles = body.surface_mesh().triangles;
      for (int t = 0; t < std::ssize(triangles); ++t) {
        for (const int local : triangles[t]) add(body.first_point + local, t);
      }
    }
  };
  visit([&](int point, int) { ++counts[point]; });
  first_.push_back(0);
  for (const int count : counts) first_.push_back(first_.back() + count);
  triangles_.resize(first_.back());
  std::vector<int> next(first_.begin(), first_.end() - 1);
  visit([&](int point, int triangle) { triangles_[next[point]++] = triangle; });
}

// Lists the triangles that have all these points for corners. A sphere stands for its triangle.
void CurvedPaths::list_triangles(std::span<const int> points, std::vector<Triangle>& found) const {
  found.clear();
  const int number = scene_.body_index_of_point(points[0]);
  const SceneBody& body = scene_.bodies[number];
  if (body.spheres != nullptr) {
    found.push_back({number, points[0] - body.first_point});
    return;
  }
  for (int i = first_[points[0]]; i < first_[points[0] + 1]; ++i) {
    const auto& corners = body.surface_mesh().triangles[triangles_[i]];
    const bool has_all = std::ranges::all_of(points, [&](int point) {
      return std::ranges::find(corners, point - body.first_point) != corners.end();
    });
    if (has_all) found.push_back({number, triangles_[i]});
  }
}

// Returns the parameters of a shell's surface at the corners of its divided triangle.
std::vector<SplineSurface::Place> CurvedPaths::places_of(const Triangle& triangle) const {
  const bsi::TexelAddress at =
      scene_.bodies[triangle.body].surface_atlas().quad_address(triangle.number / 2);
  // Rows and columns of the corners, relative to the quad's (bsi::quad_triangles).
  constexpr int rows[2][3] = {{0, 0, 1}, {0, 1, 1}}, cols[2][3] = {{0, 1, 0}, {1, 1, 0}};
  std::vector<SplineSurface::Place> places;
  for (const std::array<int, 3>& weights : division_of(shell_division).weights) {
    double row = at.row, col = at.col;
    for (int k = 0; k < 3; ++k) {
      row += weights[k] * rows[triangle.number % 2][k] / double{shell_division};
      col += weights[k] * cols[triangle.number % 2][k] / double{shell_division};
    }
    places.push_back(
        {at.patch, col / SplineSampling::per_element, row / SplineSampling::per_element});
  }
  return places;
}

CurvedPaths::Piece CurvedPaths::piece_of(const Triangle& triangle, const Path& path,
                                         const CurveStray& curve,
                                         const RigidObstacles& obstacles) const {
  const SceneBody& body = scene_.bodies[triangle.body];
  if (body.spheres != nullptr) {
    const int point = body.first_point + triangle.number;
    return {.start = {path.start.position()[point]},
            .end = {path.end.position()[point]},
            .division = 0,
            .deviation = body.spheres->radius};
  }
  const auto& corners = body.surface_mesh().triangles[triangle.number];
  const double covered = body.spline ? curve.covered * body.thickness : 0;
  Piece piece;
  if (body.spline && body.dynamic) {
    piece.division = shell_division;
    for (const SplineSurface::Place& place : places_of(triangle)) {
      const SplineSurface::Point point = body.spline->at(body.atlas, place);
      const auto own = [&](std::span<const Vec3> all) {
        return all.subspan(body.first_particle, body.particle_count());
      };
      piece.start.push_back(point.position(own(path.start_particles)));
      piece.end.push_back(point.position(own(path.end_particles)));
    }
    for (const int local : corners)
      piece.deviation = std::max(piece.deviation, curve.point[body.first_point + local] + covered);
    piece.deviation /= shell_division * shell_division;
    return piece;
  }
  const int number = obstacles.of_body(triangle.body);
  for (const int local : corners) {
    const int point = body.first_point + local;
    if (path.end.pose(number) != nullptr) {
      path.end.place(obstacles.all()[number], point);
      path.start.place(obstacles.all()[number], point);
    }
    piece.start.push_back(path.start.position()[point]);
    piece.end.push_back(path.end.position()[point]);
  }
  piece.deviation = curve.body[triangle.body] + covered;
  return piece;
}

// True if the triangles share a point or have points that are sewn together.
bool CurvedPaths::touch(const Triangle& one, const Triangle& other) const {
  const SceneBody &body = scene_.bodies[one.body], &beyond = scene_.bodies[other.body];
  if (body.spheres != nullptr || beyond.spheres != nullptr) return false;
  for (const int a : body.surface_mesh().triangles[one.number]) {
    for (const int b : beyond.surface_mesh().triangles[other.number]) {
      const int point = body.first_point + a, second = beyond.first_point + b;
      if (point == second) return true;
      if (!scene_.sewn.is_empty() && scene_.sewn.are_joined(point, second)) return true;
    }
  }
  return false;
}

std::optional<ContactFault> CurvedPaths::find_fault(std::span<const OpenPair> pairs,
                                                    const Path& path, const PointStray& stray,
                                                    const CurveStray& curve,
                                                    const RigidObstacles& obstacles) {
  std::map<Triangle, Piece> pieces;
  const auto piece = [&](const Triangle& triangle) -> const Piece& {
    const auto found = pieces.find(triangle);
    if (found != pieces.end()) return found->second;
    return pieces.emplace(triangle, piece_of(triangle, path, curve, obstacles)).first->second;
  };
  const auto stray_of = [&](const Triangle& triangle) {
    return stray.body.empty() ? 0 : stray.body[triangle.body];
  };
  std::set<std::pair<Triangle, Triangle>> checked;
  std::vector<Triangle> ones, others;
  for (const OpenPair& pair : pairs) {
    const std::span<const int> nodes(pair.nodes);
    list_triangles(nodes.first(pair.split), ones);
    list_triangles(nodes.subspan(pair.split), others);
    for (const Triangle& one : ones) {
      for (const Triangle& other : others) {
        if (!checked.emplace(std::minmax(one, other)).second || touch(one, other)) continue;
        if (!stay_apart(piece(one), piece(other), stray_of(one) + stray_of(other)))
          return ContactFault{ContactFault::Kind::curved, pair.nodes, pair.left_by};
      }
    }
  }
  return std::nullopt;
}

}  // namespace weft::sim
