#include "sim/probes/shadow.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <compare>
#include <limits>
#include <vector>

namespace weft::sim {

namespace {

// A point of the plane of the shadow. The line of the sweep has a constant u.
struct Point {
  double u = 0, v = 0;
  auto operator<=>(const Point&) const = default;
};

// Corners of a projected triangle, in increasing order.
using Corners = std::array<Point, 3>;

// Returns v at u of the edge from a to b, where a < b. Triangles that share an edge get the same
// bits, so no gap opens between them.
double at(const Point& a, const Point& b, double u) {
  if (u <= a.u) return a.v;
  if (u >= b.u) return b.v;
  return a.v + (b.v - a.v) * ((u - a.u) / (b.u - a.u));
}

// The part of the sweep's line inside a triangle, at both ends of a slab. Between them it is
// linear, as no vertex lies within a slab.
struct Chord {
  double low_start, high_start, low_end, high_end;
  double low(double t) const { return low_start + t * (low_end - low_start); }
  double high(double t) const { return high_start + t * (high_end - high_start); }
};

Chord chord_of(const Corners& triangle, double start, double end) {
  const auto& [a, b, c] = triangle;
  const bool is_left = end <= b.u;
  const Point& from = is_left ? a : b;
  const Point& to = is_left ? b : c;
  const double long_start = at(a, c, start), long_end = at(a, c, end);
  const double short_start = at(from, to, start), short_end = at(from, to, end);
  if (long_start + long_end <= short_start + short_end)
    return {long_start, short_start, long_end, short_end};
  return {short_start, long_start, short_end, long_end};
}

// The triangles under the line of the sweep, within a slab between two neighbouring vertices.
class Slab {
 public:
  void add(const Corners& triangle) { active_.push_back({&triangle, {}, 0, 0}); }

  // Returns the area of the shadow between `start` and `end`, after triangles that end before have
  // been dropped. The length of the line within the shadow is linear between the crossings of
  // projected edges.
  double area(double start, double end) {
    std::erase_if(active_, [&](const Active& each) { return (*each.triangle)[2].u <= start; });
    if (active_.empty()) return 0;
    for (Active& each : active_) each.chord = chord_of(*each.triangle, start, end);
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
  struct Active {
    const Corners* triangle;
    Chord chord;
    double low, high;  // ends of the chord at the last call of length()
  };
  // An end of a chord, which is a piece of a projected edge: v at both ends of the slab.
  struct Piece {
    double start, end;
    auto operator<=>(const Piece&) const = default;
  };

  // Lists the places t, from 0 to 1 within the slab, at which pieces of edges cross, and 1. Sorting
  // the pieces from their order at the start to that at the end swaps each pair that crosses.
  void find_crossings() {
    pieces_.clear();
    for (const Active& each : active_) {
      pieces_.push_back({each.chord.low_start, each.chord.low_end});
      pieces_.push_back({each.chord.high_start, each.chord.high_end});
    }
    std::ranges::sort(pieces_);
    crossings_.clear();
    for (std::size_t i = 1; i < pieces_.size(); ++i) {
      const Piece inserted = pieces_[i];
      std::size_t place = i;
      for (; place > 0 && pieces_[place - 1].end > inserted.end; --place) {
        const double apart = inserted.start - pieces_[place - 1].start;
        crossings_.push_back(apart / (apart + pieces_[place - 1].end - inserted.end));
        pieces_[place] = pieces_[place - 1];
      }
      pieces_[place] = inserted;
    }
    std::ranges::sort(crossings_);
    crossings_.push_back(1);
  }

  // Returns the length of the line within the shadow at t.
  double length(double t) {
    for (Active& each : active_) {
      each.low = each.chord.low(t);
      each.high = each.chord.high(t);
    }
    // The order has changed little since the last call, for which insertion is the fastest sort.
    for (std::size_t i = 1; i < active_.size(); ++i) {
      const Active inserted = active_[i];
      std::size_t place = i;
      for (; place > 0 && active_[place - 1].low > inserted.low; --place)
        active_[place] = active_[place - 1];
      active_[place] = inserted;
    }
    double sum = 0, reached = -std::numeric_limits<double>::infinity();
    for (const Active& each : active_) {
      if (each.high <= reached) continue;
      sum += each.high - std::max(each.low, reached);
      reached = each.high;
    }
    return sum;
  }

  std::vector<Active> active_;
  std::vector<Piece> pieces_;
  std::vector<double> crossings_;
};

Vec3 area_vector(std::span<const Vec3> points, const std::array<int, 3>& triangle) {
  const Vec3& a = points[triangle[0]];
  return 0.5 * (points[triangle[1]] - a).cross(points[triangle[2]] - a);
}

std::vector<Corners> project(std::span<const Vec3> points,
                             std::span<const std::array<int, 3>> triangles, int axis) {
  std::vector<Corners> result;
  result.reserve(triangles.size());
  for (const std::array<int, 3>& triangle : triangles) {
    Corners& corners = result.emplace_back();
    for (int k = 0; k < 3; ++k) {
      const Vec3& point = points[triangle[k]];
      corners[k] = {point[(axis + 1) % 3], point[(axis + 2) % 3]};
    }
    std::ranges::sort(corners);
    if (!(corners[0].u < corners[2].u)) result.pop_back();  // seen edge-on along the line
  }
  return result;
}

}  // namespace

double shadow_area(std::span<const Vec3> points, std::span<const std::array<int, 3>> triangles,
                   int axis) {
  std::vector<Corners> projected = project(points, triangles, axis);
  if (projected.empty()) return 0;
  std::ranges::sort(projected, [](const Corners& a, const Corners& b) { return a[0] < b[0]; });
  std::vector<double> stops;
  for (const Corners& triangle : projected) {
    for (const Point& corner : triangle) stops.push_back(corner.u);
  }
  std::ranges::sort(stops);
  stops.erase(std::unique(stops.begin(), stops.end()), stops.end());
  Slab slab;
  double area = 0;
  auto next = projected.begin();
  for (std::size_t i = 0; i + 1 < stops.size(); ++i) {
    for (; next != projected.end() && (*next)[0].u <= stops[i]; ++next) slab.add(*next);
    area += slab.area(stops[i], stops[i + 1]);
  }
  return area;
}

double surface_area(std::span<const Vec3> points, std::span<const std::array<int, 3>> triangles) {
  double area = 0;
  for (const std::array<int, 3>& triangle : triangles) area += area_vector(points, triangle).norm();
  return area;
}

}  // namespace weft::sim
