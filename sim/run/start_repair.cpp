#include "sim/run/start_repair.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <random>
#include <set>

#include "bsi/proximity.h"
#include "sim/case/case_error.h"
#include "sim/case/case_text.h"
#include "sim/run/initial_state.h"
#include "sim/run/wrong_sides.h"

namespace weft::sim {

namespace {

// Most rounds that take parts through surfaces, and most rounds that push surfaces apart.
constexpr int most_rounds = 60, most_spacing_rounds = 300;
// Gaps to which surfaces are separated, and gaps below which they are separated, as fractions of
// contact.range. Surfaces of one body are separated until they are out of reach of each other.
constexpr double aimed_range = 0.5, least_range = 0.4;
constexpr double aimed_range_within = 1.25, least_range_within = 1.02;
// Length by which points are displaced to find what is cut off, as a fraction of an edge. It keeps
// edges of regular images from meeting in points.
constexpr double displaced_part = 1e-6;
// Lengths by which borders are wider where they cut others, as fractions of an edge: the first that
// cuts something off counts. A line of intersection ends where the border of one surface meets the
// other, which may be some edges away from the border of the other.
constexpr double wider_parts[] = {1e-4, 0.5, 1, 2};
// Fraction of an edge by which triangles that cross without a point on the wrong side are parted.
constexpr double lifted_part = 0.1;
// The longest way of a point: twice the deepest part that is taken through, and the separation.
constexpr double longest_way = 2;

double mean_edge(const SceneBody& body, std::span<const Vec3> points) {
  double sum = 0;
  for (const bsi::Edge& edge : body.mesh.edges) {
    sum += (points[body.first_point + edge.vertex[0]] - points[body.first_point + edge.vertex[1]])
               .norm();
  }
  return sum / static_cast<double>(std::max<std::size_t>(1, body.mesh.edges.size()));
}

// The weighted sums of the moves that constraints ask of points, and their weights. A point goes by
// the mean. The weight of a point in a constraint is its share of the place that has to move: a
// point far from that place would be moved by little, and keep its other constraints from what they
// need.
struct Moves {
  std::vector<Vec3> sum;
  std::vector<double> weight;

  explicit Moves(std::size_t points) : sum(points, Vec3::Zero()), weight(points, 0) {}
  void add(int point, const Vec3& move, double share) {
    sum[point] += share * move;
    weight[point] += share;
  }
  std::vector<Vec3> applied_to(const std::vector<Vec3>& points, double factor = 1) const {
    std::vector<Vec3> result(points);
    for (std::size_t i = 0; i < points.size(); ++i)
      if (weight[i] > 0) result[i] += factor / weight[i] * sum[i];
    return result;
  }
};

// Two features that are too close.
struct Separation {
  std::array<int, 4> nodes{};
  std::array<double, 4> weight{};
  Vec3 move{0, 0, 0};   // m, of the first feature's closest point from that of the second
  double distance = 0;  // m
  int vertex = -1;      // the first feature, or -1 for two edges
  int other = 0;        // body of the second feature
};

// A point of a surface: corners and weights.
struct ClosestOnSurface {
  std::array<int, 4> nodes{};
  bsi::Closest closest;
};

class Repair {
 public:
  explicit Repair(const Scene& scene)
      : scene_(scene), x_(scene.initial_position), is_free_(x_.size(), 0) {
    for (int p = 0; p < scene.dynamic_particles; ++p) is_free_[p] = scene.pinned[p] == 0;
    for (const TimedPin& pin : scene.timed_pins)
      for (const int p : pin.particles) is_free_[p] = 0;
    scene.sewn.visit_pairs([&](int a, int b) { is_free_[a] = is_free_[b] = 0; });
    for (const SceneBody& body : scene.bodies) edge_.push_back(mean_edge(body, x_));
  }

  StartRepair run() {
    StartRepair result;
    result.crossings = static_cast<int>(forbidden_crossings(scene_, x_).size());
    if (result.crossings > 0) take_through();
    push_apart();
    result.position = x_;
    for (int b = 0; b < scene_.dynamic_bodies; ++b) add_report(b, result);
    return result;
  }

 private:
  const SceneBody& body(int index) const { return scene_.bodies[index]; }

  [[noreturn]] void refuse(const std::string& reason, const std::string& hint) const {
    throw CaseError({scene_.source.path, 0, 0}, "the initial state is not repaired: " + reason,
                    hint);
  }

  double thickness_of(int a, int b) const { return 0.5 * (body(a).thickness + body(b).thickness); }
  double aim_of(int a, int b) const {
    return thickness_of(a, b) +
           (a == b ? aimed_range_within : aimed_range) * scene_.source.contact.range;
  }
  double least_of(int a, int b) const {
    return thickness_of(a, b) +
           (a == b ? least_range_within : least_range) * scene_.source.contact.range;
  }

  // The mean edge of the bodies that can move; the smaller one of two.
  double edge_of(int a, int b) const {
    double edge = std::numeric_limits<double>::infinity();
    for (const int each : {a, b})
      if (each < scene_.dynamic_bodies) edge = std::min(edge, edge_[each]);
    return edge;
  }

  // The positions with every point displaced by a tiny length in a direction of its own.
  std::vector<Vec3> displaced() const {
    std::vector<Vec3> points(x_);
    std::mt19937_64 random(1);
    const auto unit = [&] { return 2 * std::ldexp(static_cast<double>(random() >> 11), -53) - 1; };
    for (int b = 0; b < static_cast<int>(scene_.bodies.size()); ++b) {
      for (int i = 0; i < body(b).point_count(); ++i) {
        const double length = displaced_part * edge_[b];
        Vec3& point = points[body(b).first_point + i];
        for (int k = 0; k < 3; ++k) point[k] += length * unit();
      }
    }
    return points;
  }

  // The points with those of borders farther out, in the planes of their triangles.
  std::vector<Vec3> wider(const std::vector<Vec3>& points, double part) const {
    std::vector<Vec3> result(points);
    for (int b = 0; b < static_cast<int>(scene_.bodies.size()); ++b) {
      const bsi::Mesh& mesh = body(b).surface_mesh();
      for (const bsi::Edge& edge : mesh.edges) {
        if (edge.triangle[1] >= 0) continue;
        const auto [from, to] = edge.vertex;
        const auto at = [&](int local) { return points[body(b).first_point + local]; };
        Vec3 inward = Vec3::Zero();
        for (const int corner : mesh.triangles[edge.triangle[0]])
          if (corner != from && corner != to) inward = at(corner) - at(from);
        const Vec3 along = (at(to) - at(from)).normalized();
        const Vec3 out = (inward.dot(along) * along - inward).normalized();
        for (const int local : {from, to})
          result[body(b).first_point + local] += part * edge_[b] * out;
      }
    }
    return result;
  }

  // Pairs of triangles that may cross at `points`, of the pairs of bodies that cross.
  std::vector<Crossing> near_crossings(const std::vector<Crossing>& crossings,
                                       const std::vector<Vec3>& points) const {
    std::set<std::pair<int, int>> crossed;
    for (const Crossing& c : crossings) crossed.insert({c.surface_a, c.surface_b});
    const double distance = 10 * displaced_part * *std::ranges::max_element(edge_);
    std::vector<Crossing> near = find_near_triangles(contact_surfaces(scene_, points), distance);
    std::erase_if(near, [&](const Crossing& c) {
      return !crossed.contains({c.surface_a, c.surface_b}) || !may_touch(c);
    });
    return near;
  }

  // Adds the moves of one round. `points` are displaced, and `crossings` are those of them.
  void add_round(const std::vector<Vec3>& points, const std::vector<Crossing>& crossings,
                 Moves& moves) const {
    std::vector<Crossing> left = crossings;
    for (const double part : wider_parts) {
      const std::vector<Vec3> borders = wider(points, part);
      const std::vector<CutOffPart> chosen =
          chosen_parts(find_cut_off_parts(scene_, points, borders, near_crossings(left, borders)));
      for (const CutOffPart& each : chosen) add_moves(each, borders, moves);
      std::erase_if(left, [&](const Crossing& c) { return has_part(chosen, c); });
      if (left.empty()) return;
    }
    for (const Crossing& c : left) lift(c, moves);
  }

  void take_through() {
    for (int round = 0; round < most_rounds; ++round) {
      const std::vector<Vec3> points = displaced();
      const std::vector<Crossing> crossings = forbidden_crossings(scene_, points);
      if (crossings.empty()) {
        if (forbidden_crossings(scene_, x_).empty()) return;
        adopt_free(points);  // surfaces that touch without crossing
        return;
      }
      Moves moves(x_.size());
      add_round(points, crossings, moves);
      x_ = moves.applied_to(x_);
    }
    const std::vector<Crossing> left = forbidden_crossings(scene_, x_);
    if (left.empty()) return;
    refuse("the surfaces at " + place(left[0].surface_a, left[0].triangle_a) + " and " +
               place(left[0].surface_b, left[0].triangle_b) +
               " are interlocked, or held where they cross",
           "move the bodies apart");
  }

  std::string place(int index, int triangle) const {
    return scene_.describe_point(body(index).first_point +
                                 body(index).surface_mesh().triangles[triangle][0]);
  }

  void adopt_free(const std::vector<Vec3>& points) {
    std::vector<char> touching(x_.size(), 0);
    for (const Crossing& c : forbidden_crossings(scene_, x_)) {
      for (const auto& [b, t] : {std::pair(c.surface_a, c.triangle_a), {c.surface_b, c.triangle_b}})
        for (const int corner : body(b).surface_mesh().triangles[t])
          touching[body(b).first_point + corner] = 1;
    }
    for (std::size_t i = 0; i < x_.size(); ++i)
      if (touching[i] != 0 && is_free_[i] != 0) x_[i] = points[i];
  }

  static bool has_part(const std::vector<CutOffPart>& parts, const Crossing& c) {
    return std::ranges::any_of(parts, [&](const CutOffPart& part) {
      return std::minmax(part.body, part.other) == std::minmax(c.surface_a, c.surface_b);
    });
  }

  // Returns the parts of one body of each pair of bodies: of the one with fewer points in its
  // parts. Of parts that a body cuts off from itself, the smallest is returned.
  static std::vector<CutOffPart> chosen_parts(std::vector<CutOffPart> parts) {
    const auto cut_off = [&](int a, int b) {
      std::size_t count = 0;
      for (const CutOffPart& part : parts)
        if (part.body == a && part.other == b) count += part.points.size();
      return count;
    };
    std::vector<CutOffPart> chosen;
    std::set<int> bent;
    for (const CutOffPart& part : parts) {
      const int a = part.body, b = part.other;
      if (a == b) {
        if (!bent.insert(a).second) continue;
      } else if (const std::size_t own = cut_off(a, b), others = cut_off(b, a);
                 others > 0 && (others < own || (others == own && b < a))) {
        continue;
      }
      chosen.push_back(part);
    }
    return chosen;
  }

  // Returns the closest point of a body, with its points at `x`, to a point. `excluded` marks local
  // points; triangles with one of them are left out.
  std::optional<ClosestOnSurface> closest_on(int index, int point, const std::vector<Vec3>& x,
                                             const std::vector<char>& excluded) const {
    const SceneBody& surface = body(index);
    std::optional<ClosestOnSurface> best;
    double least = std::numeric_limits<double>::infinity();
    for (const auto& corners : surface.surface_mesh().triangles) {
      std::array<int, 4> nodes{point};
      bool counts = true;
      for (int i = 0; i < 3; ++i) {
        nodes[i + 1] = surface.first_point + corners[i];
        counts = counts && (excluded.empty() || excluded[corners[i]] == 0);
      }
      if (!counts) continue;
      const Vec3 &a = x[nodes[1]], &b = x[nodes[2]], &c = x[nodes[3]];
      const Vec3 low = a.cwiseMin(b).cwiseMin(c), high = a.cwiseMax(b).cwiseMax(c);
      if ((x_[point] - x_[point].cwiseMax(low).cwiseMin(high)).squaredNorm() >= least) continue;
      const bsi::Closest closest = bsi::closest_vertex_triangle(x_[point], a, b, c);
      if (closest.squared_distance >= least) continue;
      least = closest.squared_distance;
      best = {nodes, closest};
    }
    return best;
  }

  // Marks local points of the body, and those within `rings` edges of them.
  std::vector<char> surroundings(int index, const std::vector<int>& points, int rings) const {
    std::vector<char> marked(body(index).point_count(), 0);
    for (const int p : points) marked[p] = 1;
    for (int ring = 0; ring < rings; ++ring) {
      std::vector<char> wider(marked);
      for (const bsi::Edge& edge : body(index).surface_mesh().edges) {
        if (marked[edge.vertex[0]] != 0 || marked[edge.vertex[1]] != 0)
          wider[edge.vertex[0]] = wider[edge.vertex[1]] = 1;
      }
      marked = std::move(wider);
    }
    return marked;
  }

  // Shares a move of the first feature of a pair relative to the second among the points that are
  // free, such that it is the whole move. `weight` is that of bsi::Closest.
  void share(const std::array<int, 4>& nodes, const std::array<double, 4>& weight, const Vec3& move,
             Moves& moves) const {
    double sum = 0;
    for (int i = 0; i < 4; ++i)
      if (is_free_[nodes[i]] != 0) sum += weight[i] * weight[i];
    if (sum < 1e-6) return;
    for (int i = 0; i < 4; ++i)
      if (is_free_[nodes[i]] != 0 && weight[i] != 0)
        moves.add(nodes[i], weight[i] / sum * move, std::abs(weight[i]));
  }

  // Returns the unit vector from the surface to the side on which the rest of a part lies, at a
  // point of the part on the surface.
  Vec3 side_of_rest(const CutOffPart& part, const ClosestOnSurface& at) const {
    const Vec3 &a = x_[at.nodes[1]], &b = x_[at.nodes[2]], &c = x_[at.nodes[3]];
    const Vec3 normal = (b - a).cross(c - a).normalized();
    double height = 0;
    for (const int beyond : part.points_beyond)
      height += normal.dot(x_[body(part.body).first_point + beyond] - a);
    return height < 0 ? Vec3(-normal) : normal;
  }

  // Adds the moves that take a part through a surface. Points beyond the border of the surface go
  // through the surface as it would go on there: `borders` are the points with wider borders.
  void add_moves(const CutOffPart& part, const std::vector<Vec3>& borders, Moves& moves) const {
    std::vector<char> excluded;
    if (part.body == part.other) excluded = surroundings(part.body, part.points, 2);
    const double limit = edge_of(part.body, part.other);
    for (const int local : part.points) {
      const int point = body(part.body).first_point + local;
      const auto found = closest_on(part.other, point, borders, excluded);
      if (!found) continue;
      const double depth = std::sqrt(found->closest.squared_distance);
      if (depth > limit) refuse_depth(point, part, depth, limit);
      const Vec3 way = depth > displaced_part * limit ? Vec3(-found->closest.separation / depth)
                                                      : side_of_rest(part, *found);
      share(found->nodes, found->closest.weight, (depth + aim_of(part.body, part.other)) * way,
            moves);
    }
  }

  [[noreturn]] void refuse_depth(int point, const CutOffPart& part, double depth,
                                 double limit) const {
    refuse(scene_.describe_point(point) + " is " + rounded_text(depth) +
               " m on the wrong side of \"" + body(part.other).name +
               "\", and only parts within the mean edge of the mesh, " + rounded_text(limit) +
               " m, are taken through",
           "move the bodies apart");
  }

  // Parts two triangles that cross without a point on the wrong side: their corners go away from
  // the other surface.
  void lift(const Crossing& c, Moves& moves) const {
    for (const auto& [own, triangle, other] :
         {std::tuple(c.surface_a, c.triangle_a, c.surface_b),
          std::tuple(c.surface_b, c.triangle_b, c.surface_a)}) {
      for (const int corner : body(own).surface_mesh().triangles[triangle]) {
        std::vector<char> excluded;
        if (own == other) excluded = surroundings(own, {corner}, 2);
        const auto found = closest_on(other, body(own).first_point + corner, x_, excluded);
        if (!found) continue;
        const double distance = std::sqrt(found->closest.squared_distance);
        const double limit = edge_of(own, other);
        if (!(distance > displaced_part * limit)) continue;
        share(found->nodes, found->closest.weight,
              lifted_part * limit / distance * found->closest.separation, moves);
      }
    }
  }

  // True if the features were as close in the rest shape of their body: neighbours.
  bool are_neighbours(const std::array<int, 4>& nodes, int a, int b, bool edges,
                      double distance) const {
    if (a != b) return false;
    std::array<Vec3, 4> rest;
    for (int i = 0; i < 4; ++i) rest[i] = body(a).surface_rest()[nodes[i] - body(a).first_point];
    const bsi::Closest closest =
        edges ? bsi::closest_edge_edge(rest[0], rest[1], rest[2], rest[3])
              : bsi::closest_vertex_triangle(rest[0], rest[1], rest[2], rest[3]);
    return closest.squared_distance <= distance * distance;
  }

  // Adds what separates a pair of features to `found` if it is closer than the least distance.
  // Edges that are closest at an end of one of them are left out: that end and a triangle are as
  // close.
  void separate(const std::array<int, 4>& nodes, bool edges, int a, int b,
                std::vector<Separation>& found) const {
    const Vec3 &x0 = x_[nodes[0]], &x1 = x_[nodes[1]], &x2 = x_[nodes[2]], &x3 = x_[nodes[3]];
    const bsi::Closest closest = edges ? bsi::closest_edge_edge(x0, x1, x2, x3)
                                       : bsi::closest_vertex_triangle(x0, x1, x2, x3);
    const double least = least_of(a, b);
    if (closest.squared_distance >= least * least) return;
    if (edges && std::ranges::find(closest.weight, 0.0) != closest.weight.end()) return;
    const double aim = aim_of(a, b), distance = std::sqrt(closest.squared_distance);
    if (are_neighbours(nodes, a, b, edges, aim)) return;
    const bool is_free = std::ranges::any_of(nodes, [&](int node) { return is_free_[node] != 0; });
    if (!is_free || !(distance > 0)) return;
    found.push_back({nodes, closest.weight, (aim - distance) / distance * closest.separation,
                     distance, edges ? -1 : nodes[0], b});
  }

  void separate_triangles(const Crossing& near, std::vector<Separation>& found) const {
    const auto corners = [&](int b, int t) {
      std::array<int, 3> nodes = body(b).surface_mesh().triangles[t];
      for (int& node : nodes) node += body(b).first_point;
      return nodes;
    };
    const int a = near.surface_a, b = near.surface_b;
    const auto p = corners(a, near.triangle_a), q = corners(b, near.triangle_b);
    for (int i = 0; i < 3; ++i) {
      separate({p[i], q[0], q[1], q[2]}, false, a, b, found);
      separate({q[i], p[0], p[1], p[2]}, false, b, a, found);
      for (int j = 0; j < 3; ++j)
        separate({p[i], p[(i + 1) % 3], q[j], q[(j + 1) % 3]}, true, a, b, found);
    }
  }

  // Returns the moves that separate the features. A vertex and a triangle count only if no other
  // triangle of that body is nearer to the vertex: beside its projection, the triangle would push
  // the vertex aside.
  Moves moves_of(const std::vector<Separation>& separations) const {
    std::map<std::pair<int, int>, double> nearest;
    for (const Separation& each : separations) {
      const auto [place, is_new] = nearest.try_emplace({each.vertex, each.other}, each.distance);
      if (!is_new) place->second = std::min(place->second, each.distance);
    }
    Moves moves(x_.size());
    for (const Separation& each : separations) {
      if (each.vertex >= 0 && each.distance > nearest.at({each.vertex, each.other})) continue;
      share(each.nodes, each.weight, each.move, moves);
    }
    return moves;
  }

  bool may_touch(const Crossing& near) const {
    if (near.surface_a >= scene_.dynamic_bodies) return false;
    if (scene_.sewn.is_empty()) return true;
    for (const int i : body(near.surface_a).surface_mesh().triangles[near.triangle_a]) {
      for (const int j : body(near.surface_b).surface_mesh().triangles[near.triangle_b]) {
        if (scene_.sewn.are_joined(body(near.surface_a).first_point + i,
                                   body(near.surface_b).first_point + j))
          return false;
      }
    }
    return true;
  }

  // Pushes features apart that are too close. No move makes surfaces cross.
  void push_apart() {
    double reach = 0;
    for (const SceneBody& each : scene_.bodies) reach = std::max(reach, each.thickness);
    reach += least_range_within * scene_.source.contact.range;
    for (int round = 0; round < most_spacing_rounds; ++round) {
      std::vector<Separation> found;
      for (const Crossing& near : find_near_triangles(contact_surfaces(scene_, x_), reach))
        if (may_touch(near)) separate_triangles(near, found);
      if (found.empty()) return;
      const Moves moves = moves_of(found);
      double factor = 1;
      std::vector<Vec3> next = moves.applied_to(x_);
      while (factor > 1e-3 && !forbidden_crossings(scene_, next).empty()) {
        factor *= 0.5;
        next = moves.applied_to(x_, factor);
      }
      if (factor > 1e-3) x_ = std::move(next);
    }
    refuse("surfaces that are too close find no room to part",
           "move the bodies apart, or make thickness smaller");
  }

  void add_report(int index, StartRepair& result) const {
    RepairedBody report{index};
    for (int i = 0; i < body(index).point_count(); ++i) {
      const int p = body(index).first_point + i;
      if (x_[p] == scene_.initial_position[p]) continue;
      ++report.moved;
      report.farthest = std::max(report.farthest, (x_[p] - scene_.initial_position[p]).norm());
    }
    if (report.moved == 0) return;
    double gap = 0;
    for (const SceneBody& each : scene_.bodies) gap = std::max(gap, each.thickness);
    gap += scene_.source.contact.range;
    if (report.farthest > longest_way * (edge_[index] + gap)) {
      refuse("a point of \"" + body(index).name + "\" would move by " +
                 rounded_text(report.farthest) + " m, farther than two edges of its mesh",
             "move the bodies apart");
    }
    result.bodies.push_back(report);
  }

  const Scene& scene_;
  std::vector<Vec3> x_;        // m, by point, which is by particle
  std::vector<char> is_free_;  // by particle
  std::vector<double> edge_;   // m, mean edge by body
};

void refuse_scenes(const Scene& scene) {
  const SourceLocation where{scene.source.path, 0, 0};
  if (scene.source.restart) {
    throw CaseError(where, "the initial state is not repaired: the bodies start in that of a run",
                    "expected a case without [restart]");
  }
  for (const SceneBody& body : scene.bodies) {
    if (!body.sampled) continue;
    throw CaseError(
        where,
        "the initial state is not repaired: \"" + body.name + "\" is a shell, and only cloth is",
        "move the bodies apart");
  }
}

}  // namespace

StartRepair repair_start(const Scene& scene) {
  refuse_scenes(scene);
  return Repair(scene).run();
}

}  // namespace weft::sim
