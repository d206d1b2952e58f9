#include "bsi/proximity.h"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

namespace weft::bsi {

namespace {

// If the squared sine of a triangle's corner, or of the angle between two edges, is below this
// limit, rounding may misjudge which feature is closest. All features are then tried.
constexpr double thin_squared_sine = 1e-12;
// If the squared sine is below this limit, two edges count as parallel and a triangle as
// degenerate: the equations for both parameters are nearly singular.
constexpr double parallel_squared_sine = 1e-20;

struct OnEdge {
  double parameter = 0;
  Vec3 separation = Vec3::Zero();
};

// Returns the point of `edge` closest to a given point. `from_start` (m) is the vector from the
// start of the edge to the given point.
inline OnEdge closest_on_edge(const Vec3& from_start, const Vec3& edge) {
  const double along = from_start.dot(edge);
  const double squared_length = edge.squaredNorm();
  if (along <= 0) return {0, from_start};
  if (along >= squared_length) return {1, from_start - edge};
  const double parameter = along / squared_length;
  const Vec3 separation = from_start - parameter * edge;
  // Rounding leaves a part along the edge that does not shrink with the gap. Without it, the
  // separation is perpendicular to the edge even if its length is nearly zero.
  return {parameter, separation - (separation.dot(edge) / squared_length) * edge};
}

inline bool inside(double parameter) { return parameter > 0 && parameter < 1; }

// The closest point found so far on the border of a triangle. It lies on the edge from point
// `start` to point `end`, both numbered as in Closest.
struct BorderPoint {
  double squared_distance = std::numeric_limits<double>::infinity();
  OnEdge on_edge;
  int start = 1, end = 2;

  void offer(const Vec3& from_start, const Vec3& edge, int edge_start, int edge_end) {
    const OnEdge candidate = closest_on_edge(from_start, edge);
    const double candidate_distance = candidate.separation.squaredNorm();
    if (candidate_distance >= squared_distance) return;
    squared_distance = candidate_distance;
    on_edge = candidate;
    start = edge_start;
    end = edge_end;
  }
};

Closest at_border(const BorderPoint& best) {
  Closest result;
  result.squared_distance = best.squared_distance;
  result.separation = best.on_edge.separation;
  result.weight[0] = 1;
  result.weight[best.start] = best.on_edge.parameter - 1;
  result.weight[best.end] = -best.on_edge.parameter;
  result.free_directions = inside(best.on_edge.parameter) ? 1 : 0;
  return result;
}

inline Closest at_interior(const Vec3& separation, double weight2, double weight3) {
  Closest result;
  result.squared_distance = separation.squaredNorm();
  result.separation = separation;
  result.weight = {1, weight2 + weight3 - 1, -weight2, -weight3};
  result.free_directions = 2;
  return result;
}

// The closest pair of points found so far on two edges, at the parameters s (first edge) and t
// (second edge).
struct EdgePair {
  double squared_distance = std::numeric_limits<double>::infinity();
  Vec3 separation = Vec3::Zero();
  double s = 0, t = 0;

  void offer(const Vec3& candidate, double candidate_s, double candidate_t) {
    const double candidate_distance = candidate.squaredNorm();
    if (candidate_distance >= squared_distance) return;
    squared_distance = candidate_distance;
    separation = candidate;
    s = candidate_s;
    t = candidate_t;
  }
};

inline Closest at_edge_pair(const EdgePair& best) {
  Closest result;
  result.squared_distance = best.squared_distance;
  result.separation = best.separation;
  result.weight = {1 - best.s, best.s, best.t - 1, -best.t};
  result.free_directions = (inside(best.s) ? 1 : 0) + (inside(best.t) ? 1 : 0);
  return result;
}

}  // namespace

Closest closest_vertex_triangle(const Vec3& x0, const Vec3& x1, const Vec3& x2, const Vec3& x3) {
  const Vec3 edge2 = x2 - x1, edge3 = x3 - x1, from1 = x0 - x1;
  const Vec3 normal = edge2.cross(edge3);
  const double scale = normal.squaredNorm();
  const double squared_lengths = edge2.squaredNorm() * edge3.squaredNorm();
  // Barycentric coordinates of the foot of the perpendicular from x0, times `scale`.
  const double area2 = from1.cross(edge3).dot(normal);
  const double area3 = edge2.cross(from1).dot(normal);
  const double area1 = scale - area2 - area3;
  const bool interior = area1 > 0 && area2 > 0 && area3 > 0;
  const bool thin = !(scale > thin_squared_sine * squared_lengths);
  // Computed along the normal, the separation keeps its direction even if its length is nearly
  // zero.
  if (interior && !thin)
    return at_interior((from1.dot(normal) / scale) * normal, area2 / scale, area3 / scale);

  // If the foot is outside the triangle, the closest point lies on an edge whose line separates the
  // foot from the triangle. (The closest point of a convex polygon is on an edge that faces the
  // given point.)
  BorderPoint best;
  if (thin || area3 <= 0) best.offer(from1, edge2, 1, 2);
  if (thin || area2 <= 0) best.offer(from1, edge3, 1, 3);
  if (thin || area1 <= 0) best.offer(x0 - x2, x3 - x2, 2, 3);
  if (thin && interior && scale > parallel_squared_sine * squared_lengths) {
    const Vec3 separation = from1 - (area2 / scale) * edge2 - (area3 / scale) * edge3;
    if (separation.squaredNorm() < best.squared_distance)
      return at_interior(separation, area2 / scale, area3 / scale);
  }
  return at_border(best);
}

Closest closest_edge_edge(const Vec3& x0, const Vec3& x1, const Vec3& x2, const Vec3& x3) {
  // The function to minimise is |from2 + s first - t second|.
  const Vec3 first = x1 - x0, second = x3 - x2, from2 = x0 - x2;
  const Vec3 normal = first.cross(second);
  const double scale = normal.squaredNorm();
  const double squared_lengths = first.squaredNorm() * second.squaredNorm();
  // The parameters at which the lines are closest, times `scale`.
  const double scaled_s = second.cross(from2).dot(normal);
  const double scaled_t = first.cross(from2).dot(normal);
  const bool interior = scaled_s > 0 && scaled_s < scale && scaled_t > 0 && scaled_t < scale;
  const bool thin = !(scale > thin_squared_sine * squared_lengths);
  EdgePair best;
  if (interior && !thin) {
    best.offer((from2.dot(normal) / scale) * normal, scaled_s / scale, scaled_t / scale);
    return at_edge_pair(best);
  }

  // If the minimum is not in the interior, one of the closest points is an end of its edge. The
  // squared distance is a convex quadratic function of both parameters. Its minimum over the unit
  // square lies on a side that faces the unconstrained minimum, where the lines are closest.
  const auto offer_end = [&](const Vec3& from_start, const Vec3& edge, bool end_of_first,
                             double end_parameter) {
    const OnEdge found = closest_on_edge(from_start, edge);
    if (end_of_first)
      best.offer(found.separation, end_parameter, found.parameter);
    else
      best.offer(-found.separation, found.parameter, end_parameter);
  };
  if (thin || scaled_s <= 0) offer_end(from2, second, true, 0);
  if (thin || scaled_s >= scale) offer_end(x1 - x2, second, true, 1);
  if (thin || scaled_t <= 0) offer_end(-from2, first, false, 0);
  if (thin || scaled_t >= scale) offer_end(x3 - x0, first, false, 1);
  if (thin && interior && scale > parallel_squared_sine * squared_lengths) {
    // Rounding makes s inaccurate here. The distance is accurate nevertheless, because t is the
    // best parameter for this s.
    const double s = scaled_s / scale;
    const OnEdge found = closest_on_edge(from2 + s * first, second);
    if (inside(found.parameter)) best.offer(found.separation, s, found.parameter);
  }
  return at_edge_pair(best);
}

}  // namespace weft::bsi
