#include "sim/view/start_picture.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <set>
#include <span>

#include "bsi/proximity.h"
#include "gpu/renderer.h"
#include "gpu/triangle_batch.h"
#include "sim/base/file_error.h"
#include "sim/base/file_status.h"
#include "sim/base/output_folder.h"
#include "sim/view/rendered_spheres.h"

namespace weft::sim {

namespace {

constexpr int width = 800, height = 720;  // pixels of each of the two views
// The smallest part of the simulated bodies' size that is seen.
constexpr double least_part = 1.0 / 3;

// Rounding of gaps that are zero in exact numbers, as a fraction of the radius: spheres whose
// collisions the method finds may touch.
constexpr double overlap_rounding = 1e-9;

// A body as it is drawn: its triangles, and those that are marked. Particles are spheres.
struct StartBody {
  std::vector<std::array<int, 3>> plain, marked;
  std::vector<Vec3> normals;
  std::vector<std::array<int, 2>> lines;
  SphereSurface spheres, marked_spheres;
};

struct Bounds {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = -low;

  void add(const Vec3& point) {
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
};

std::span<const Vec3> points_of(const SceneBody& body, std::span<const Vec3> points) {
  return points.subspan(body.first_point, body.point_count());
}

// Finds the spheres that overlap another sphere or a surface at the start.
class SphereOverlaps {
 public:
  SphereOverlaps(const Scene& scene, std::span<const Vec3> points)
      : scene_(scene), points_(points), marks_(scene.bodies.size()) {
    for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
      const SceneBody& body = scene.bodies[b];
      centres_.emplace_back();
      if (!is_group(body)) continue;
      for (int i = 0; i < body.point_count(); ++i) centres_.back().push_back({i, i, i});
      marks_[b].resize(static_cast<std::size_t>(body.point_count()));
    }
  }

  // Sets the mark of each sphere that overlaps something to 1.
  void find() {
    for (std::size_t a = 0; a < scene_.bodies.size(); ++a) {
      if (!is_group(scene_.bodies[a])) continue;
      for (std::size_t b = 0; b < scene_.bodies.size(); ++b) {
        if (scene_.bodies[b].are_spins || (is_group(scene_.bodies[b]) && b < a)) continue;
        compare(static_cast<int>(a), static_cast<int>(b));
      }
    }
  }

  // Returns the marks by body and sphere.
  const std::vector<std::vector<char>>& marks() const { return marks_; }
  // Returns the number of marked spheres.
  int count() const {
    std::ptrdiff_t sum = 0;
    for (const std::vector<char>& marks : marks_) sum += std::ranges::count(marks, 1);
    return static_cast<int>(sum);
  }

 private:
  static bool is_group(const SceneBody& body) { return body.spheres != nullptr && !body.are_spins; }
  // Returns the distance (m) from a body's points or triangles at which it is touched.
  static double reach(const SceneBody& body) {
    return is_group(body) ? body.spheres->radius : 0.5 * body.thickness;
  }
  // Marks the spheres of group `a` that overlap body `b`, which may be a group, too.
  void compare(int a, int b) {
    const SceneBody &group = scene_.bodies[a], &other = scene_.bodies[b];
    const double sum = reach(group) + reach(other);
    const double rounding = scene_.spheres_collide ? overlap_rounding * group.spheres->radius : 0;
    std::vector<CrossingSurface> surfaces{{points_of(group, points_), centres_[a], a == b}};
    if (a != b) {
      surfaces.push_back({points_of(other, points_),
                          is_group(other) ? centres_[b] : other.surface_mesh().triangles, false});
    }
    for (const Crossing& near : find_near_triangles(surfaces, sum)) {
      if (distance(a, near.triangle_a, b, near.triangle_b) - sum > -rounding) continue;
      marks_[a][near.triangle_a] = 1;
      if (is_group(other)) marks_[b][near.triangle_b] = 1;
    }
  }
  // Returns the distance (m) from the centre of a sphere to a sphere's centre or a triangle.
  double distance(int a, int sphere, int b, int other) const {
    const Vec3& centre = points_of(scene_.bodies[a], points_)[sphere];
    const auto own = points_of(scene_.bodies[b], points_);
    if (is_group(scene_.bodies[b])) return (centre - own[other]).norm();
    const auto& [i, j, k] = scene_.bodies[b].surface_mesh().triangles[other];
    return std::sqrt(bsi::closest_vertex_triangle(centre, own[i], own[j], own[k]).squared_distance);
  }

  const Scene& scene_;
  std::span<const Vec3> points_;
  std::vector<std::vector<std::array<int, 3>>> centres_;  // triangles without area, by body
  std::vector<std::vector<char>> marks_;                  // by body and sphere
};

// Returns the bounds of what is seen: of what is marked, or of the simulated bodies.
Bounds seen_bounds(const Scene& scene, std::span<const Vec3> points,
                   const std::vector<StartBody>& drawn) {
  Bounds marked, simulated;
  for (std::size_t b = 0; b < drawn.size(); ++b) {
    const auto own = points_of(scene.bodies[b], points);
    for (const auto& triangle : drawn[b].marked)
      for (const int corner : triangle) marked.add(own[corner]);
    for (const Vec3& point : drawn[b].marked_spheres.positions) {
      marked.add(point);
      simulated.add(point);
    }
    if (scene.bodies[b].is_obstacle || scene.bodies[b].are_spins) continue;
    for (const Vec3& point : scene.bodies[b].spheres == nullptr
                                 ? own
                                 : std::span<const Vec3>(drawn[b].spheres.positions))
      simulated.add(point);
  }
  if (!(marked.low.x() <= marked.high.x())) return simulated;
  const double size = (simulated.high - simulated.low).norm();
  const double lacking = least_part * size - (marked.high - marked.low).norm();
  if (lacking > 0) {
    // The box grows by as much along each axis; sqrt(3) axes of a cube make its diagonal.
    const Vec3 margin = Vec3::Constant(0.5 * lacking / std::sqrt(3.0));
    marked.low -= margin;
    marked.high += margin;
  }
  return marked;
}

// Returns the surface of those spheres of a group whose mark is `mark`.
SphereSurface marked_surface(const SceneBody& group, std::span<const Vec3> centres,
                             std::span<const char> marks, char mark) {
  std::vector<Vec3> chosen;
  for (std::size_t i = 0; i < centres.size(); ++i) {
    if (marks[i] == mark) chosen.push_back(centres[i]);
  }
  return surface_of_spheres(chosen, std::vector<double>(chosen.size(), group.spheres->radius));
}

std::vector<StartBody> start_bodies(const Scene& scene, std::span<const Vec3> points,
                                    std::span<const Crossing> crossings,
                                    const std::vector<std::vector<char>>& overlaps) {
  std::vector<std::set<int>> crossing(scene.bodies.size());
  for (const Crossing& c : crossings) {
    crossing[c.surface_a].insert(c.triangle_a);
    crossing[c.surface_b].insert(c.triangle_b);
  }
  std::vector<StartBody> drawn(scene.bodies.size());
  for (std::size_t b = 0; b < drawn.size(); ++b) {
    const SceneBody& body = scene.bodies[b];
    const auto& triangles = body.surface_mesh().triangles;
    for (int t = 0; t < static_cast<int>(triangles.size()); ++t)
      (crossing[b].contains(t) ? drawn[b].marked : drawn[b].plain).push_back(triangles[t]);
    const auto own = points_of(body, points);
    if (body.spheres != nullptr && !body.are_spins) {
      drawn[b].spheres = marked_surface(body, own, overlaps[b], 0);
      drawn[b].marked_spheres = marked_surface(body, own, overlaps[b], 1);
    }
    drawn[b].normals = gpu::vertex_normals({.positions = own, .triangles = triangles});
    if (!body.is_obstacle) drawn[b].lines = gpu::grid_lines(body.surface_atlas(), own);
  }
  return drawn;
}

// The colours by which `weft render` draws the body.
gpu::SurfaceColours colours_of(const Scene& scene, int body) {
  if (scene.bodies[body].is_obstacle) return gpu::obstacle_colours();
  const auto before = scene.case_order.begin() + scene.case_index(body);
  return gpu::palette(static_cast<int>(std::count_if(
      scene.case_order.begin(), before, [&](int b) { return !scene.bodies[b].is_obstacle; })));
}

void add_sphere_surface(const SphereSurface& spheres, const gpu::Colour& colour,
                        std::vector<gpu::DrawnSurface>& surfaces) {
  if (spheres.positions.empty()) return;
  surfaces.push_back({.positions = spheres.positions,
                      .triangles = spheres.triangles,
                      .front_colour = colour,
                      .back_colour = colour,
                      .normals = spheres.normals});
}

std::vector<gpu::DrawnSurface> surfaces_of(const Scene& scene, std::span<const Vec3> points,
                                           const std::vector<StartBody>& drawn) {
  std::vector<gpu::DrawnSurface> surfaces;
  for (std::size_t b = 0; b < drawn.size(); ++b) {
    const SceneBody& body = scene.bodies[b];
    if (body.are_spins) continue;
    const auto own = points_of(body, points);
    const gpu::SurfaceColours colours = colours_of(scene, static_cast<int>(b));
    if (body.spheres != nullptr) {
      add_sphere_surface(drawn[b].spheres, colours.back, surfaces);
      add_sphere_surface(drawn[b].marked_spheres, gpu::touching_colour(), surfaces);
      continue;
    }
    surfaces.push_back({.positions = own,
                        .triangles = drawn[b].plain,
                        .front_colour = colours.front,
                        .back_colour = colours.back,
                        .lines = drawn[b].lines,
                        .normals = drawn[b].normals});
    if (drawn[b].marked.empty()) continue;
    surfaces.push_back({.positions = own,
                        .triangles = drawn[b].marked,
                        .front_colour = gpu::touching_colour(),
                        .back_colour = gpu::touching_colour(),
                        .normals = drawn[b].normals});
  }
  return surfaces;
}

gpu::Picture beside(const gpu::Picture& left, const gpu::Picture& right) {
  gpu::Picture both{left.width + right.width, left.height, {}};
  for (int row = 0; row < left.height; ++row) {
    for (const gpu::Picture* each : {&left, &right}) {
      const auto first = each->rgb.begin() + 3L * row * each->width;
      both.rgb.insert(both.rgb.end(), first, first + 3L * each->width);
    }
  }
  return both;
}

}  // namespace

int draw_start(const Scene& scene, std::span<const Crossing> crossings, const std::string& path,
               bool force) {
  const bool exists = std::filesystem::exists(link_status_of(path));
  if (exists && !force && !gpu::is_own_png(path)) {
    throw FileError(path + ": was not made by weft, and is only overwritten by force (--force)");
  }
  std::vector<Vec3> room;
  const std::span<const Vec3> points =
      scene.surface_map.points_of(scene.initial_position, scene.point_count, room);
  SphereOverlaps spheres(scene, points);
  if (scene.source.contact.enabled || scene.spheres_collide) spheres.find();
  const std::vector<std::vector<char>>& overlaps = spheres.marks();
  const std::vector<StartBody> drawn = start_bodies(scene, points, crossings, overlaps);
  const std::vector<gpu::DrawnSurface> surfaces = surfaces_of(scene, points, drawn);
  const Bounds seen = seen_bounds(scene, points, drawn);
  try {
    gpu::Camera camera =
        gpu::camera_for_box(seen.low, seen.high, static_cast<double>(width) / height);
    gpu::Renderer renderer(width, height);
    const gpu::Picture above = renderer.draw(surfaces, camera);
    camera.eye.z() = 2 * camera.target.z() - camera.eye.z();
    camera.lit_from_below = true;
    gpu::write_png(in_output_folder(path), beside(above, renderer.draw(surfaces, camera)));
  } catch (const std::exception& error) {
    throw FileError(error.what());
  }
  return spheres.count();
}

}  // namespace weft::sim
