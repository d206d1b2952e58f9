#include "sim/view/start_picture.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <set>
#include <span>

#include "gpu/renderer.h"
#include "gpu/triangle_batch.h"
#include "sim/base/file_error.h"
#include "sim/base/output_folder.h"
#include "sim/view/rendered_spheres.h"

namespace weft::sim {

namespace {

constexpr int width = 800, height = 720;  // pixels of each of the two views
// The smallest part of the simulated bodies' size that is seen.
constexpr double least_part = 1.0 / 3;

// A body as it is drawn: its triangles, and those that are marked. Particles are spheres.
struct StartBody {
  std::vector<std::array<int, 3>> plain, marked;
  std::vector<Vec3> normals;
  std::vector<std::array<int, 2>> lines;
  SphereSurface spheres;
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

// Returns the bounds of what is seen: of the marked triangles, or of the simulated bodies.
Bounds seen_bounds(const Scene& scene, std::span<const Vec3> points,
                   const std::vector<StartBody>& drawn) {
  Bounds marked, simulated;
  for (std::size_t b = 0; b < drawn.size(); ++b) {
    const auto own = points_of(scene.bodies[b], points);
    for (const auto& triangle : drawn[b].marked)
      for (const int corner : triangle) marked.add(own[corner]);
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

std::vector<StartBody> start_bodies(const Scene& scene, std::span<const Vec3> points,
                                    std::span<const Crossing> crossings) {
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
      drawn[b].spheres =
          surface_of_spheres(own, std::vector<double>(own.size(), body.spheres->radius));
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

std::vector<gpu::DrawnSurface> surfaces_of(const Scene& scene, std::span<const Vec3> points,
                                           const std::vector<StartBody>& drawn) {
  std::vector<gpu::DrawnSurface> surfaces;
  for (std::size_t b = 0; b < drawn.size(); ++b) {
    const SceneBody& body = scene.bodies[b];
    if (body.are_spins) continue;
    const auto own = points_of(body, points);
    const gpu::SurfaceColours colours = colours_of(scene, static_cast<int>(b));
    if (body.spheres != nullptr) {
      surfaces.push_back({.positions = drawn[b].spheres.positions,
                          .triangles = drawn[b].spheres.triangles,
                          .front_colour = colours.back,
                          .back_colour = colours.back,
                          .normals = drawn[b].spheres.normals});
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

void draw_start(const Scene& scene, std::span<const Crossing> crossings, const std::string& path,
                bool force) {
  const bool exists = std::filesystem::exists(std::filesystem::symlink_status(path));
  if (exists && !force && !gpu::is_own_png(path)) {
    throw FileError(path + ": was not made by weft, and is only overwritten by force (--force)");
  }
  std::vector<Vec3> room;
  const std::span<const Vec3> points =
      scene.surface_map.points_of(scene.initial_position, scene.point_count, room);
  const std::vector<StartBody> drawn = start_bodies(scene, points, crossings);
  const std::vector<gpu::DrawnSurface> surfaces = surfaces_of(scene, points, drawn);
  const Bounds seen = seen_bounds(scene, points, drawn);
  gpu::Camera camera =
      gpu::camera_for_box(seen.low, seen.high, static_cast<double>(width) / height);
  try {
    gpu::Renderer renderer(width, height);
    const gpu::Picture above = renderer.draw(surfaces, camera);
    camera.eye.z() = 2 * camera.target.z() - camera.eye.z();
    camera.lit_from_below = true;
    gpu::write_png(in_output_folder(path), beside(above, renderer.draw(surfaces, camera)));
  } catch (const std::runtime_error& error) {
    throw FileError(error.what());
  }
}

}  // namespace weft::sim
