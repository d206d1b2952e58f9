#include "sim/probes/shadow.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <compare>
#include <vector>

namespace weft::sim {

namespace {

// A point of the plane of the shadow. The line of the sweep has a constant u.
struct ShadowPoint {
  double u = 0, v = 0;
};

// An edge of the surface with its step: the number of triangles under the line of the sweep above
// the edge, less that below it. Points `from` and `to` are indices of vertices, from < to.
struct SteppedEdge {
  int from = 0, to = 0, step = 0;
};

// Returns the edges across which the number of triangles changes: the border, and folds. The two
// triangles at any other edge lie on both sides of it, and their steps cancel.
std::vector<SteppedEdge> contour_of(std::span<const ShadowPoint> points,
                                    std::span<const std::array<int, 3>> triangles) {
  std::vector<SteppedEdge> edges;
  edges.reserve(3 * triangles.size());
  for (const std::array<int, 3>& triangle : triangles) {
    const ShadowPoint &a = points[triangle[0]], &b = points[triangle[1]], &c = points[triangle[2]];
    const double area = (b.u - a.u) * (c.v - a.v) - (c.u - a.u) * (b.v - a.v);
    const int turn = (area > 0 ? 1 : 0) - (area < 0 ? 1 : 0);
    for (int k = 0; k < 3; ++k) {
      const int from = triangle[k], to = triangle[(k + 1) % 3];
      // The triangle lies to the left of its edges if it turns to the left.
      const double way = points[to].u - points[from].u;
      const int step = turn * ((way > 0 ? 1 : 0) - (way < 0 ? 1 : 0));
      edges.push_back({std::min(from, to), std::max(from, to), step});
    }
  }
  std::ranges::sort(edges, {},
                    [](const SteppedEdge& edge) { return std::pair(edge.from, edge.to); });
  std::vector<SteppedEdge> contour;
  for (const SteppedEdge& edge : edges) {
    const bool is_next =
        contour.empty() || contour.back().from != edge.from || contour.back().to != edge.to;
    if (is_next) {
      if (!contour.empty() && contour.back().step == 0) contour.pop_back();
      contour.push_back(edge);
    } else {
      contour.back().step += edge.step;
    }
  }
  if (!contour.empty() && contour.back().step == 0) contour.pop_back();
  return contour;
}

// An edge of the contour, from left to right.
struct ContourEdge {
  ShadowPoint left, right;
  int step = 0;

  double at(double u) const {
    if (u >= right.u) return right.v;
    return left.v + (right.v - left.v) * ((u - left.u) / (right.u - left.u));
  }
};

// The edges of the contour under the line of the sweep, within a slab between two neighbouring ends
// of edges.
class Slab {
 public:
  void add(const ContourEdge& edge) { active_.push_back(&edge); }

  // Returns the area of the shadow between `start` and `end`, after edges that end before have been
  // dropped. The length of the line within the shadow is linear between the crossings of edges.
  double area(double start, double end) {
    std::erase_if(active_, [&](const ContourEdge* edge) { return edge->right.u <= start; });
    pieces_.clear();
    for (const ContourEdge* edge : active_)
      pieces_.push_back({edge->at(start), edge->at(end), edge->step});
    std::ranges::sort(pieces_);
    find_crossings();
    double integral = 0, last_t = 0, last_length = length(0);
    for (const double t : crossings_) {
      const double here = length(t);
      integral += 0.5 * (t - last_t) * (last_length + here);
      last_t = t;
      last_length = here;
    }
    return (end - start) * integral;
  }

 private:
  // A piece of an edge: v at both ends of the slab.
  struct Piece {
    double start, end;
    int step;
    double at(double t) const { return start + t * (end - start); }
    auto operator<=>(const Piece&) const = default;
  };

  // Lists the places t, from 0 to 1 within the slab, at which pieces cross, and 1. Sorting the
  // pieces from their order at the start to that at the end swaps each pair that crosses.
  void find_crossings() {
    crossings_.clear();
    by_end_.clear();
    for (const Piece& inserted : pieces_) {
      by_end_.push_back(inserted);
      std::size_t place = by_end_.size() - 1;
      for (; place > 0 && by_end_[place - 1].end > inserted.end; --place) {
        const double apart = inserted.start - by_end_[place - 1].start;
        crossings_.push_back(apart / (apart + by_end_[place - 1].end - inserted.end));
        by_end_[place] = by_end_[place - 1];
      }
      by_end_[place] = inserted;
    }
    std::ranges::sort(crossings_);
    crossings_.push_back(1);
  }

  // Returns the length of the line within the shadow at t.
  double length(double t) {
    // The order has changed little since the last call, for which insertion is the fastest sort.
    for (std::size_t i = 1; i < pieces_.size(); ++i) {
      const Piece inserted = pieces_[i];
      std::size_t place = i;
      for (; place > 0 && pieces_[place - 1].at(t) > inserted.at(t); --place)
        pieces_[place] = pieces_[place - 1];
      pieces_[place] = inserted;
    }
    double sum = 0;
    int triangles = 0;
    for (std::size_t i = 0; i + 1 < pieces_.size(); ++i) {
      triangles += pieces_[i].step;
      if (triangles > 0) sum += pieces_[i + 1].at(t) - pieces_[i].at(t);
    }
    return sum;
  }

  std::vector<const ContourEdge*> active_;
  std::vector<Piece> pieces_, by_end_;
  std::vector<double> crossings_;
};

}  // namespace

double shadow_area(std::span<const Vec3> points, std::span<const std::array<int, 3>> triangles,
                   int axis) {
  std::vector<ShadowPoint> projected;
  for (const Vec3& point : points)
    projected.push_back({point[(axis + 1) % 3], point[(axis + 2) % 3]});
  std::vector<ContourEdge> edges;
  std::vector<double> stops;
  for (const auto& [from, to, step] : contour_of(projected, triangles)) {
    ContourEdge edge{projected[from], projected[to], step};
    if (edge.left.u > edge.right.u) std::swap(edge.left, edge.right);
    edges.push_back(edge);
    stops.insert(stops.end(), {edge.left.u, edge.right.u});
  }
  std::ranges::sort(edges, {}, [](const ContourEdge& edge) { return edge.left.u; });
  std::ranges::sort(stops);
  stops.erase(std::unique(stops.begin(), stops.end()), stops.end());
  Slab slab;
  double area = 0;
  auto next = edges.begin();
  for (std::size_t i = 0; i + 1 < stops.size(); ++i) {
    for (; next != edges.end() && next->left.u <= stops[i]; ++next) slab.add(*next);
    area += slab.area(stops[i], stops[i + 1]);
  }
  return area;
}

double surface_area(std::span<const Vec3> points, std::span<const std::array<int, 3>> triangles) {
  double area = 0;
  for (const auto& [a, b, c] : triangles)
    area += 0.5 * (points[b] - points[a]).cross(points[c] - points[a]).norm();
  return area;
}

}  // namespace weft::sim
