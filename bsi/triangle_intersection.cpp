#include "bsi/triangle_intersection.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "bsi/geometry_image.h"

namespace weft::bsi {

namespace {

Point2 projected(const Point3& point, int dropped_axis) {
  return {point[(dropped_axis + 1) % 3], point[(dropped_axis + 2) % 3]};
}

int projected_orientation(const Point3& a, const Point3& b, const Point3& c, int dropped_axis) {
  return orientation(projected(a, dropped_axis), projected(b, dropped_axis),
                     projected(c, dropped_axis));
}

// Returns true if the box of the segment p-q overlaps the box of `points`.
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
    // If three of these points form a triangle with area in a projection, the projection is
    // one-to-one on the common plane.
    if (side_a != 0 || side_b != 0 || side_p != 0 || side_q != 0)
      return side_a * side_b <= 0 && side_p * side_q <= 0;
  }
  return true;  // all points are on one line, and the boxes overlap
}

// Returns true if a point on the plane of a triangle is inside the triangle or on its border.
// Returns false if the triangle has no area.
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

// Returns the side (-1, 0, 1) of the plane of `triangle` on which each corner of `other` lies. On
// the plane itself the side is 0.
std::array<int, 3> sides_of(const Triangle3& triangle, const Triangle3& other) {
  std::array<int, 3> side;
  for (int corner = 0; corner < 3; ++corner)
    side[corner] = orientation(triangle[0], triangle[1], triangle[2], other[corner]);
  return side;
}

// Returns true if the segment p-q meets the triangle. `side_p` and `side_q` are the sides of the
// triangle's plane on which p and q lie.
bool segment_meets_triangle(const Point3& p, const Point3& q, int side_p, int side_q,
                            const Triangle3& triangle) {
  if (side_p * side_q > 0) return false;
  const auto& [a, b, c] = triangle;
  if (side_p == 0 && side_q == 0) {
    if (!boxes_overlap(p, q, triangle)) return false;
    return is_inside(p, triangle) || segments_meet(p, q, a, b) || segments_meet(p, q, b, c) ||
           segments_meet(p, q, c, a);
  }
  // The segment meets the plane in one point. That point is in the triangle unless the line through
  // p and q passes two edges on opposite sides.
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
  // If two triangles meet, an edge of one of them meets the other.
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

namespace {

bool has_area(const Triangle3& triangle) {
  for (int axis = 0; axis < 3; ++axis)
    if (projected_orientation(triangle[0], triangle[1], triangle[2], axis) != 0) return true;
  return false;
}

// Returns true if the interiors of two coplanar triangles overlap. Precondition: both have area.
// The interiors are disjoint if and only if the line of some edge has the other triangle entirely
// on its outer side.
bool insides_overlap(const Triangle3& a, const Triangle3& b) {
  int axis = 0;
  while (projected_orientation(a[0], a[1], a[2], axis) == 0) ++axis;
  const auto separates = [axis](const Triangle3& edges, const Triangle3& other) {
    const int whole = projected_orientation(edges[0], edges[1], edges[2], axis);
    for (int edge = 0; edge < 3; ++edge) {
      bool across = true;
      for (const Point3& corner : other) {
        across =
            across &&
            projected_orientation(edges[edge], edges[(edge + 1) % 3], corner, axis) * whole <= 0;
      }
      if (across) return true;
    }
    return false;
  };
  return !separates(a, b) && !separates(b, a);
}

// Returns true if a point is in the triangle. Precondition: the triangle has no area, or the point
// is on its plane.
bool contains(const Triangle3& triangle, const Point3& point) {
  if (is_inside(point, triangle)) return true;
  for (int edge = 0; edge < 3; ++edge)
    if (segments_meet(point, point, triangle[edge], triangle[(edge + 1) % 3])) return true;
  return false;
}

Vec3 to_vector(const Point3& point) { return {point[0], point[1], point[2]}; }

// Returns the point between p and q whose distances from p and q are in the ratio from_p : from_q.
Point3 point_between(const Point3& p, const Point3& q, double from_p, double from_q) {
  const double sum = from_p + from_q;
  const double t = sum > 0 ? from_p / sum : 0.5;
  const Vec3 point = to_vector(p) + t * (to_vector(q) - to_vector(p));
  return {point.x(), point.y(), point.z()};
}

// Returns the point where the segment p-q crosses the plane of the triangle. Precondition: p and q
// are strictly on opposite sides of the plane.
Point3 plane_point(const Point3& p, const Point3& q, const Triangle3& triangle) {
  const Vec3 corner = to_vector(triangle[0]);
  const Vec3 normal = (to_vector(triangle[1]) - corner).cross(to_vector(triangle[2]) - corner);
  return point_between(p, q, std::abs(normal.dot(to_vector(p) - corner)),
                       std::abs(normal.dot(to_vector(q) - corner)));
}

// Returns the point where the segment p-q crosses the line of a-b. Precondition: both lie in one
// plane.
Point3 crossing_point(const Point3& p, const Point3& q, const Point3& a, const Point3& b) {
  const Vec3 along = to_vector(b) - to_vector(a);
  return point_between(p, q, along.cross(to_vector(p) - to_vector(a)).norm(),
                       along.cross(to_vector(q) - to_vector(a)).norm());
}

// Returns true if two segments in one plane cross at an inner point of both.
bool segments_cross(const Point3& p, const Point3& q, const Point3& a, const Point3& b) {
  for (int axis = 0; axis < 3; ++axis) {
    const int pq = projected_orientation(p, q, a, axis) * projected_orientation(p, q, b, axis);
    const int ab = projected_orientation(a, b, p, axis) * projected_orientation(a, b, q, axis);
    if (pq < 0 && ab < 0) return true;
  }
  return false;
}

// The border of a triangle as pairs of corners: three edges, or one segment if the triangle has no
// area.
struct Border {
  std::array<std::array<int, 2>, 3> edge{{{0, 1}, {1, 2}, {2, 0}}};
  int count = 3;

  explicit Border(const Triangle3& triangle) {
    if (has_area(triangle)) return;
    const auto [first, last] = std::minmax_element(triangle.begin(), triangle.end());
    edge[0] = {static_cast<int>(first - triangle.begin()),
               static_cast<int>(last - triangle.begin())};
    count = 1;
  }
};

// The points that determine the intersection of two triangles if it has no area. There are three
// kinds: corners of one triangle in the other, crossings of two edges at inner points, and points
// where an edge pierces the interior of the other triangle. Before rounding, points of different
// kinds, or from different edges, never coincide.
class CommonPoints {
 public:
  CommonPoints(const Triangle3& a, const Triangle3& b) {
    const std::array<int, 3> sides_a = sides_of(b, a), sides_b = sides_of(a, b);
    const Border border_a(a), border_b(b);
    add_corners(a, border_a, sides_a, b);
    add_corners(b, border_b, sides_b, a);
    int volume[3][3] = {}, transposed[3][3] = {};
    for (int i = 0; i < border_a.count; ++i) {
      for (int j = 0; j < border_b.count; ++j) {
        const Point3 &p = a[border_a.edge[i][0]], &q = a[border_a.edge[i][1]];
        const Point3 &r = b[border_b.edge[j][0]], &s = b[border_b.edge[j][1]];
        volume[i][j] = transposed[j][i] = orientation(p, q, r, s);
        if (volume[i][j] == 0 && segments_cross(p, q, r, s)) add(crossing_point(p, q, r, s));
      }
    }
    add_piercings(a, border_a, sides_a, b, volume);
    add_piercings(b, border_b, sides_b, a, transposed);
  }

  TriangleIntersection result() const {
    if (count_ == 0) return {};
    if (count_ == 1) return {IntersectionKind::point, {point_[0], point_[0]}};
    TriangleIntersection found{IntersectionKind::edge, {point_[0], point_[1]}};
    double longest = 0;  // all points lie on one line; the ends are farthest apart
    for (int i = 0; i < count_; ++i) {
      for (int j = i + 1; j < count_; ++j) {
        const double length = (to_vector(point_[i]) - to_vector(point_[j])).squaredNorm();
        if (length <= longest) continue;
        longest = length;
        found.ends = {point_[i], point_[j]};
      }
    }
    return found;
  }

 private:
  void add(const Point3& point) { point_[count_++] = point; }

  void add_corners(const Triangle3& corners, const Border& border, const std::array<int, 3>& sides,
                   const Triangle3& triangle) {
    for (int edge = 0; edge < border.count; ++edge) {
      for (int i : border.edge[edge]) {
        const auto end = point_.begin() + count_;
        if (sides[i] == 0 && std::find(point_.begin(), end, corners[i]) == end &&
            contains(triangle, corners[i]))
          add(corners[i]);
      }
    }
  }

  // Adds the points where an edge pierces the interior of the triangle. The ends of such an edge
  // are on two sides of the plane, and its line passes all three edges of the triangle on the same
  // side.
  void add_piercings(const Triangle3& edges, const Border& border, const std::array<int, 3>& sides,
                     const Triangle3& triangle, const int (&volume)[3][3]) {
    for (int i = 0; i < border.count; ++i) {
      const auto [from, to] = border.edge[i];
      const int* v = volume[i];
      if (sides[from] * sides[to] < 0 && v[0] != 0 && v[0] == v[1] && v[0] == v[2])
        add(plane_point(edges[from], edges[to], triangle));
    }
  }

  std::array<Point3, 6 + 6 + 9> point_{};
  int count_ = 0;
};

}  // namespace

TriangleIntersection intersect_triangles(const Triangle3& a, const Triangle3& b) {
  const auto apart = [](const std::array<int, 3>& side) {
    return side[0] != 0 && side[0] == side[1] && side[0] == side[2];
  };
  const std::array<int, 3> sides_b = sides_of(a, b);
  if (apart(sides_b) || apart(sides_of(b, a))) return {};
  const bool one_plane = sides_b == std::array<int, 3>{0, 0, 0};
  if (one_plane && has_area(a) && has_area(b) && insides_overlap(a, b))
    return {IntersectionKind::surface, {}};
  return CommonPoints(a, b).result();
}

}  // namespace weft::bsi
