#include "sim/view/rendered_body.h"

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "gpu/triangle_batch.h"
#include "sim/case/case_text.h"
#include "sim/view/rendered_spheres.h"

namespace weft::sim {
namespace {

// Largest coordinate that is drawn (m). The renderer computes in float32, whose range the products
// of much larger coordinates would exceed.
constexpr double farthest_drawn = 1e9;

// Returns RenderedBody::most_deviation (m) of each body. Contact keeps two bodies apart by at least
// the mean of their thicknesses. So that bodies do not show through each other, the deviations of
// two bodies add up to no more than that mean, unless both thicknesses are zero.
std::vector<double> most_deviation(const std::vector<TrajectoryBody>& bodies) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  double least = infinity;
  double least_positive = infinity;
  for (const TrajectoryBody& body : bodies) {
    least = std::min(least, body.thickness);
    if (body.thickness > 0) least_positive = std::min(least_positive, body.thickness);
  }
  std::vector<double> most;
  most.reserve(bodies.size());
  for (const TrajectoryBody& body : bodies) {
    most.push_back(0.25 * (std::max(body.thickness, least_positive) + least));
  }
  return most;
}

// Rebuilds the pyramid from the present positions. Does nothing and returns false if the body does
// not move and its pyramid is already built, or if the body consists of particles.
bool rebuild_pyramid(const TrajectoryReader& reader, int frame, RenderedBody& body) {
  if (!body.radii.empty()) return false;
  if (!body.moves && body.pyramid) return false;
  const TrajectoryBody& recorded = reader.bodies()[body.index];
  if (!body.pyramid) {
    body.pyramid.emplace(body.surface.atlas(),
                         bsi::PyramidParts{.tangents = false, .spheres = true});
  }
  if (body.pyramid->rebuild(body.positions)) {
    throw std::runtime_error("cannot draw frame " + std::to_string(frame) + " so: body '" +
                             recorded.name + "' is too far away");
  }
  return true;
}

void find_detail_normals(RenderedBody& body) {
  gpu::DrawnSurface original;
  original.positions = body.positions;
  original.triangles = body.mesh.triangles;
  body.detail_normals = gpu::detail_normals(body.detail, original);
}

}  // namespace

std::vector<RenderedBody> rendered_bodies(const std::string& path, const TrajectoryReader& reader) {
  std::vector<RenderedBody> bodies;
  const std::vector<double> most = most_deviation(reader.bodies());
  int coloured = 0;
  for (int index = 0; index < static_cast<int>(reader.bodies().size()); ++index) {
    const TrajectoryBody& body = reader.bodies()[index];
    RenderedBody& rendered = bodies.emplace_back(body);
    rendered.index = index;
    rendered.moves = body.moves;
    rendered.is_obstacle = body.is_obstacle;
    rendered.most_deviation = most[index];
    rendered.radii = body.radii;
    try {
      rendered.mesh = rendered.surface.mesh();
    } catch (const std::invalid_argument& error) {
      throw FileError(path + ": body '" + body.name + "': " + error.what());
    }
    if (body.is_obstacle) {
      rendered.colours = gpu::obstacle_colours();
    } else {
      rendered.colours = gpu::palette(coloured++);
    }
  }
  return bodies;
}

void read_positions(const TrajectoryReader& reader, int frame, RenderedBody& body) {
  if (!body.moves && !body.positions.empty()) return;
  body.positions = body.surface.points(reader.positions(body.index, frame));
  for (const Vec3& position : body.positions) {
    if (position.allFinite() && position.cwiseAbs().maxCoeff() <= farthest_drawn) continue;
    const std::string fault =
        position.allFinite() ? "beyond " + rounded_text(farthest_drawn) + " m" : "not finite";
    throw std::runtime_error("cannot draw frame " + std::to_string(frame) + ": body '" +
                             reader.bodies()[body.index].name + "' has a position that is " +
                             fault);
  }
}

void reduce_detail(const TrajectoryReader& reader, int frame, bsi::DetailTolerance tolerance,
                   RenderedBody& body) {
  // The camera is fixed, so a body that does not move is reduced only once.
  if (!rebuild_pyramid(reader, frame, body)) return;
  tolerance.most = body.most_deviation;
  body.detail = bsi::detail_within(*body.pyramid, body.positions, tolerance);
  find_detail_normals(body);
}

void reduce_to_level(const TrajectoryReader& reader, int frame, int level, RenderedBody& body) {
  if (!rebuild_pyramid(reader, frame, body)) return;
  const std::vector<int> levels(body.pyramid->patch_count(), level);
  body.detail = bsi::detail_at_levels(*body.pyramid, body.positions, levels);
  find_detail_normals(body);
}

void make_spheres(const TrajectoryReader& reader, int frame, int level,
                  std::vector<RenderedBody>& bodies) {
  for (RenderedBody& body : bodies) rebuild_pyramid(reader, frame, body);
  surround_bodies(level, bodies);
}

std::vector<bsi::Sphere> drawn_spheres(const TrajectoryReader& reader, int frame, int level,
                                       RenderedBody& body) {
  rebuild_pyramid(reader, frame, body);
  if (!body.pyramid) return {};
  return spheres_of_level(*body.pyramid, level);
}

void add_surfaces(RenderedBody& body, std::vector<gpu::DrawnSurface>& surfaces) {
  if (!body.radii.empty()) draw_particles(body);
  const auto add_spheres = [&](const SphereSurface& spheres, const gpu::Colour& colour) {
    if (spheres.triangles.empty()) return;
    surfaces.push_back({.positions = spheres.positions,
                        .triangles = spheres.triangles,
                        .front_colour = colour,
                        .back_colour = colour,
                        .normals = spheres.normals});
  };
  if (!body.spheres.triangles.empty() || !body.touching_spheres.triangles.empty()) {
    add_spheres(body.spheres, body.colours.back);
    if (!body.sphere_places.empty()) {
      surfaces.back().colour_map = body.colour_map;
      surfaces.back().places = body.sphere_places;
    }
    add_spheres(body.touching_spheres, gpu::touching_colour());
    return;
  }
  gpu::DrawnSurface& surface = surfaces.emplace_back();
  surface.front_colour = body.colours.front;
  surface.back_colour = body.colours.back;
  if (!body.places.empty()) surface.colour_map = body.colour_map;
  if (!body.detail.triangles.empty()) {
    surface.positions = body.detail.positions;
    surface.triangles = body.detail.triangles;
    surface.normals = body.detail_normals;
    body.detail_places.clear();
    if (surface.colour_map == nullptr) return;
    for (const int particle : body.detail.particles)
      body.detail_places.push_back(body.places[particle]);
    surface.places = body.detail_places;
    return;
  }
  // The first drawn frame determines the grid lines, whose cells are square in that frame.
  if (!body.is_obstacle && body.lines.empty()) {
    body.lines = gpu::grid_lines(body.surface.atlas(), body.positions);
  }
  surface.positions = body.positions;
  surface.triangles = body.mesh.triangles;
  surface.lines = body.lines;
  surface.places = body.places;
}

}  // namespace weft::sim
