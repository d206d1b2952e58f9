#include "gpu/screen_geometry.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace weft::gpu {
namespace {

using Eigen::Vector2d;

// Length (pixels) beyond which an edge of a triangle is cut, if neither end is nearer to the eye
// than Perspective::nearest.
constexpr double longest_edge = 16;
// Lines are moved towards the eye by this length, measured in pixels at their depth. Otherwise
// their own surface would hide them. (To push the surface back in proportion to its slope would
// reveal lines 2 mm behind a fold that is seen edge-on.)
constexpr double line_pull_in_pixels = 1.5;

// A vertex as the camera sees it.
struct ScreenVertex {
  Vec3 seen;       // coordinates relative to the eye (Perspective::seen()), m
  Vector2d pixel;  // position in the picture, pixels; meaningful only in front of the eye
};

// Returns the plane that has these values at three points (pixels). `twice_area` is twice the
// signed area of the triangle of the points.
ScreenPlane plane_through(const std::array<Vector2d, 3>& points,
                          const std::array<double, 3>& values, double twice_area) {
  const Vector2d u = points[1] - points[0], v = points[2] - points[0];
  const double du = (values[1] - values[0]) / twice_area, dv = (values[2] - values[0]) / twice_area;
  const double across = du * v.y() - dv * u.y();
  const double down = dv * u.x() - du * v.x();
  return {static_cast<float>(values[0] - across * points[0].x() - down * points[0].y()),
          static_cast<float>(across), static_cast<float>(down)};
}

class Projection {
 public:
  Projection(const Perspective& perspective, TriangleBatch& batch, ScreenGeometry& geometry)
      : perspective_(&perspective), batch_(&batch), geometry_(&geometry) {
    vertices_.reserve(batch.vertices.size());
    for (const BatchVertex& vertex : batch.vertices) add_screen_vertex(vertex);
  }

  void add_triangle(const BatchTriangle& triangle);
  void add_line(const std::array<std::uint32_t, 2>& ends);

 private:
  void add_screen_vertex(const BatchVertex& vertex);
  bool is_out_of_sight(const std::array<std::uint32_t, 3>& corners) const;
  // Returns the length (m) of an edge if the edge must be cut, else 0.
  double length_to_cut(std::uint32_t from, std::uint32_t to) const;
  std::uint32_t middle(std::uint32_t from, std::uint32_t to);
  // Returns the pixels of the picture between the corners `low` and `high`; an empty box if it
  // shows no such pixel.
  ScreenBox box_around(const Vector2d& low, const Vector2d& high) const;
  void set_up(const BatchTriangle& triangle);
  float line_darkness(std::uint32_t vertex) const;

  const Perspective* perspective_;
  TriangleBatch* batch_;
  std::vector<ScreenVertex> vertices_;
  ScreenGeometry* geometry_;
};

void Projection::add_screen_vertex(const BatchVertex& vertex) {
  const Vec3 seen = perspective_->seen(vertex.position().matrix().cast<double>());
  vertices_.push_back({seen, perspective_->pixel(seen)});
}

// Returns true if all corners are beyond the same side of the picture, or all are nearer to the eye
// than perspective_->nearest.
bool Projection::is_out_of_sight(const std::array<std::uint32_t, 3>& corners) const {
  unsigned beyond = 31;
  for (const std::uint32_t corner : corners) {
    const Vec3& seen = vertices_[corner].seen;
    const double x = seen.x() * perspective_->focal_length;
    const double y = seen.y() * perspective_->focal_length;
    const double half_width = 0.5 * perspective_->width * seen.z();
    const double half_height = 0.5 * perspective_->height * seen.z();
    beyond &= (x < -half_width ? 1U : 0U) | (x > half_width ? 2U : 0U) |
              (y < -half_height ? 4U : 0U) | (y > half_height ? 8U : 0U) |
              (seen.z() < perspective_->nearest ? 16U : 0U);
  }
  return beyond != 0;
}

// The result depends only on the edge, so the triangles on both sides of an edge are cut at the
// same vertex positions.
double Projection::length_to_cut(std::uint32_t from, std::uint32_t to) const {
  const ScreenVertex& a = vertices_[from];
  const ScreenVertex& b = vertices_[to];
  const double length = (a.seen - b.seen).norm();
  const bool is_cut_off = std::min(a.seen.z(), b.seen.z()) < perspective_->nearest;
  const bool is_too_long = is_cut_off
                               ? length > perspective_->nearest / 8
                               : (a.pixel - b.pixel).squaredNorm() > longest_edge * longest_edge;
  return is_too_long ? length : 0;
}

std::uint32_t Projection::middle(std::uint32_t from, std::uint32_t to) {
  BatchVertex vertex;
  vertex.values = 0.5F * (batch_->vertices[from].values + batch_->vertices[to].values);
  batch_->vertices.push_back(vertex);
  std::vector<float>& places = batch_->places;
  if (!places.empty()) places.push_back(0.5F * (places[from] + places[to]));
  add_screen_vertex(vertex);
  return static_cast<std::uint32_t>(batch_->vertices.size() - 1);
}

void Projection::add_triangle(const BatchTriangle& triangle) {
  if (is_out_of_sight(triangle.corners)) return;
  const auto [a, b, c] = triangle.corners;
  const std::array<double, 3> lengths{length_to_cut(a, b), length_to_cut(b, c),
                                      length_to_cut(c, a)};
  const auto longest = std::ranges::max_element(lengths) - lengths.begin();
  if (lengths[longest] == 0) {
    set_up(triangle);
    return;
  }
  const std::uint32_t from = triangle.corners[longest];
  const std::uint32_t to = triangle.corners[(longest + 1) % 3];
  const std::uint32_t opposite = triangle.corners[(longest + 2) % 3];
  const std::uint32_t cut = middle(from, to);
  add_triangle({{from, cut, opposite}, triangle.surface});
  add_triangle({{cut, to, opposite}, triangle.surface});
}

ScreenBox Projection::box_around(const Vector2d& low, const Vector2d& high) const {
  const Vector2d last(perspective_->width - 1, perspective_->height - 1);
  const Vector2d begin = low.cwiseMax(0).array().floor();
  const Vector2d end = high.cwiseMin(last).array().floor();
  if ((end.array() < begin.array()).any()) return {};
  return {static_cast<int>(begin.x()), static_cast<int>(begin.y()), static_cast<int>(end.x()),
          static_cast<int>(end.y())};
}

void Projection::set_up(const BatchTriangle& triangle) {
  std::array<Vector2d, 3> points;
  std::array<double, 3> nearness;
  for (int i = 0; i < 3; ++i) {
    const ScreenVertex& vertex = vertices_[triangle.corners[i]];
    if (vertex.seen.z() < perspective_->nearest) return;
    points[i] = vertex.pixel;
    nearness[i] = 1 / vertex.seen.z();
  }
  const Vector2d low = points[0].cwiseMin(points[1]).cwiseMin(points[2]);
  const Vector2d high = points[0].cwiseMax(points[1]).cwiseMax(points[2]);
  const ScreenBox box = box_around(low, high);
  for (Vector2d& point : points) point -= Vector2d(box.left, box.top);
  const Vector2d u = points[1] - points[0], v = points[2] - points[0];
  const double twice_area = u.x() * v.y() - u.y() * v.x();
  if (box.right < box.left || std::abs(twice_area) < 1e-9) return;

  ScreenTriangle& drawn = geometry_->triangles.emplace_back();
  drawn.box = box;
  drawn.corners = triangle.corners;
  drawn.surface = triangle.surface;
  drawn.is_front = twice_area < 0;  // negative for front sides, because y points downwards
  drawn.nearness = plane_through(points, nearness, twice_area);
  // The slack allows for a few rounding errors of floats as large as the triangle in pixels.
  const double slack_in_pixels = 1e-6 * (high - low).sum();
  for (int i = 0; i < 3; ++i) {
    std::array<double, 3> values{};
    values[i] = 1;
    drawn.shares[i] = plane_through(points, values, twice_area);
    drawn.slack[i] = static_cast<float>(slack_in_pixels) *
                     std::sqrt(drawn.shares[i].across * drawn.shares[i].across +
                               drawn.shares[i].down * drawn.shares[i].down);
    drawn.corner_nearness[i] = static_cast<float>(nearness[i]);
  }
}

// Returns the darkness of a line at a vertex. Lines fade out where the surface is seen edge-on.
// Otherwise they would crowd there, and lines of the far side would show through.
float Projection::line_darkness(std::uint32_t vertex) const {
  const Vec3 view = perspective_->eye - batch_->vertices[vertex].position().matrix().cast<double>();
  const Vec3 normal = batch_->vertices[vertex].normal().matrix().cast<double>();
  const double facing = std::abs(view.normalized().dot(normal));
  const double share = std::clamp((facing - 0.05) / 0.3, 0.0, 1.0);
  return static_cast<float>(0.22 * share * share * (3 - 2 * share));
}

void Projection::add_line(const std::array<std::uint32_t, 2>& ends) {
  const ScreenVertex& tail = vertices_[ends[0]];
  const ScreenVertex& head = vertices_[ends[1]];
  if (std::min(tail.seen.z(), head.seen.z()) < perspective_->nearest) return;
  const Vector2d margin(0.5, 0.5);
  const ScreenBox box = box_around(tail.pixel.cwiseMin(head.pixel) - margin,
                                   tail.pixel.cwiseMax(head.pixel) + margin);
  const Vector2d way = head.pixel - tail.pixel;
  const double length = way.norm();
  if (box.right < box.left || length < 1e-9) return;

  const Vector2d from = tail.pixel - Vector2d(box.left, box.top);
  const auto plane = [&from](const Vector2d& slope) {
    return ScreenPlane{static_cast<float>(-slope.dot(from)), static_cast<float>(slope.x()),
                       static_cast<float>(slope.y())};
  };
  ScreenLine& drawn = geometry_->lines.emplace_back();
  drawn.box = box;
  drawn.along = plane(way / (length * length));
  drawn.aside = plane(Vector2d(-way.y(), way.x()) / length);
  const double pulled = 1 / (1 - line_pull_in_pixels / perspective_->focal_length);
  drawn.nearness = static_cast<float>(pulled / tail.seen.z());
  drawn.nearness_slope = static_cast<float>(pulled / head.seen.z()) - drawn.nearness;
  drawn.darkness = line_darkness(ends[0]);
  drawn.darkness_slope = line_darkness(ends[1]) - drawn.darkness;
}

}  // namespace

void ScreenGeometry::project(const Perspective& perspective, TriangleBatch& batch) {
  triangles.clear();
  lines.clear();
  Projection projection(perspective, batch, *this);
  for (const BatchTriangle& triangle : batch.triangles) projection.add_triangle(triangle);
  for (const auto& line : batch.lines) projection.add_line(line);
}

}  // namespace weft::gpu
