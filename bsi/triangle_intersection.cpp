#include "bsi/triangle_intersection.h"

#include <algorithm>

namespace weft::bsi {

namespace {

Point2 projected(const Point3& point, int dropped_axis) {
  return {point[(dropped_axis + 1) % 3], point[(dropped_axis + 2) % 3]};
}

int projected_orientation(const Point3& a, const Point3& b, const Point3& c, int dropped_axis) {
  return orientation(projected(a, dropped_axis), projected(b, dropped_axis),
                     projected(c, dropped_axis));
}

// Does the box of the segment p-q overlap that of the other points?
template <class Points>
bool boxes_overlap(const Point3& p, const Point3& q, const Points& points) {
  for (int axis = 0; axis < 3; ++axis) {
    double low = points[0][axis], high = low;
    for (const Point3& point : points) {
      low = std::min(low, point[axis]);
      high = std::max(high, point[axis]);
    }
    if (std::max(p[axis], q[axis]) < low || high < std::min(p[axis], q[axis])) return false;
  }
  return true;
}

bool segments_meet(const Point3& p, const Point3& q, const Point3& a, const Point3& b) {
  if (!boxes_overlap(p, q, std::array{a, b}) || orientation(p, q, a, b) != 0) return false;
  for (int axis = 0; axis < 3; ++axis) {
    const int side_a = projected_orientation(p, q, a, axis);
    const int side_b = projected_orientation(p, q, b, axis);
    const int side_p = projected_orientation(a, b, p, axis);
    const int side_q = projected_orientation(a, b, q, axis);
    // A projection that shows an area is one-to-one on the plane of the four points.
    if (side_a != 0 || side_b != 0 || side_p != 0 || side_q != 0)
      return side_a * side_b <= 0 && side_p * side_q <= 0;
  }
  return true;  // all on one line, where boxes that overlap are segments that overlap
}

// Whether a point on the plane of a triangle is in it; false for triangles without area.
bool is_inside(const Point3& point, const Triangle3& triangle) {
  for (int axis = 0; axis < 3; ++axis) {
    const int whole = projected_orientation(triangle[0], triangle[1], triangle[2], axis);
    if (whole == 0) continue;
    for (int corner = 0; corner < 3; ++corner) {
      const Point3& next = triangle[(corner + 1) % 3];
      if (projected_orientation(triangle[corner], next, point, axis) == -whole) return false;
    }
    return true;
  }
  return false;
}

// On which sides of the plane of `triangle` the corners of the other lie; 0 is on it.
std::array<int, 3> sides_of(const Triangle3& triangle, const Triangle3& other) {
  std::array<int, 3> side;
  for (int corner = 0; corner < 3; ++corner)
    side[corner] = orientation(triangle[0], triangle[1], triangle[2], other[corner]);
  return side;
}

// The segment p-q, whose ends are on these sides of the plane of the triangle.
bool segment_meets_triangle(const Point3& p, const Point3& q, int side_p, int side_q,
                            const Triangle3& triangle) {
  if (side_p * side_q > 0) return false;
  const auto& [a, b, c] = triangle;
  if (side_p == 0 && side_q == 0) {
    if (!boxes_overlap(p, q, triangle)) return false;
    return is_inside(p, triangle) || segments_meet(p, q, a, b) || segments_meet(p, q, b, c) ||
           segments_meet(p, q, c, a);
  }
  // It meets the plane in one point, which is in the triangle unless the line passes two edges on
  // different sides.
  const int side_ab = orientation(p, q, a, b);
  const int side_bc = orientation(p, q, b, c);
  if (side_ab * side_bc < 0) return false;
  const int side_ca = orientation(p, q, c, a);
  return side_bc * side_ca >= 0 && side_ca * side_ab >= 0;
}

bool edge_meets_triangle(const Triangle3& edges, int edge, const std::array<int, 3>& sides,
                         const Triangle3& triangle) {
  const int next = (edge + 1) % 3;
  return segment_meets_triangle(edges[edge], edges[next], sides[edge], sides[next], triangle);
}

}  // namespace

bool triangles_meet(const Triangle3& a, const Triangle3& b) {
  const auto apart = [](const std::array<int, 3>& side) {
    return side[0] != 0 && side[0] == side[1] && side[0] == side[2];
  };
  const std::array<int, 3> sides_b = sides_of(a, b);
  if (apart(sides_b)) return false;
  const std::array<int, 3> sides_a = sides_of(b, a);
  if (apart(sides_a)) return false;
  // What two triangles have in common ends at an edge of one of them.
  for (int edge = 0; edge < 3; ++edge) {
    if (edge_meets_triangle(b, edge, sides_b, a)) return true;
    if (edge_meets_triangle(a, edge, sides_a, b)) return true;
  }
  return false;
}

bool triangles_meet_beyond_corner(const Triangle3& a, const Triangle3& b) {
  const std::array<int, 3> sides_b = sides_of(a, b);
  if (sides_b[1] * sides_b[2] > 0) return false;
  const std::array<int, 3> sides_a = sides_of(b, a);
  if (sides_a[1] * sides_a[2] > 0) return false;
  return edge_meets_triangle(b, 1, sides_b, a) || edge_meets_triangle(a, 1, sides_a, b);
}

}  // namespace weft::bsi
