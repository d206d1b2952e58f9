// The bodies of a trajectory as drawn: whole, at reduced detail, or as spheres of their pyramids.
// For render_trajectory.cpp.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "bsi/level_of_detail.h"
#include "bsi/pyramid.h"
#include "bsi/sphere.h"
#include "gpu/renderer.h"
#include "sim/trajectory/trajectory.h"
#include "sim/view/recorded_surface.h"

namespace weft::sim {

// Many spheres as one surface.
struct SphereSurface {
  std::vector<Vec3> positions;  // m
  std::vector<Vec3> normals;
  std::vector<std::array<int, 3>> triangles;
};

// A body as drawn: parts that are the same in all frames, and its shape in one frame.
struct RenderedBody {
  explicit RenderedBody(const TrajectoryBody& body) : surface(body) {}

  RecordedSurface surface;
  int index = 0;
  bool moves = true;
  bool is_obstacle = false;
  bsi::Mesh mesh;
  std::vector<std::array<int, 2>> lines;
  gpu::SurfaceColours colours;
  std::vector<Vec3> positions;  // m, by particle of the surface
  // Places in `colour_map` (0 .. 1), by particle of the surface. A body without places has its own
  // `colours`.
  std::vector<float> places;
  const gpu::ColourMap* colour_map = nullptr;
  std::optional<bsi::Pyramid> pyramid;  // built when first needed
  // For reduced detail. If `detail` has no triangles, the body is drawn whole.
  double most_deviation = 0;  // m
  bsi::DetailSurface detail;
  std::vector<Vec3> detail_normals;
  std::vector<float> detail_places;
  // The spheres of one level: those that touch no sphere of another body, and those that do.
  SphereSurface spheres, touching_spheres;
};

// Returns the bodies of a trajectory, without positions. `path` names the file in errors. Throws
// FileError for a body whose triangles form no surface.
std::vector<RenderedBody> rendered_bodies(const std::string& path, const TrajectoryReader& reader);

// Reads the positions of a frame. Positions of a body that does not move are read once. Throws
// std::runtime_error if a position is not finite.
void read_positions(const TrajectoryReader& reader, int frame, RenderedBody& body);

// The functions below use the positions read last. Pyramids and surfaces of bodies that do not move
// are made only once. The functions throw std::runtime_error, naming the frame, for a body that is
// too far away.

// Reduces detail within the tolerance, and within RenderedBody::most_deviation, so that bodies do
// not show through each other.
void reduce_detail(const TrajectoryReader& reader, int frame, bsi::DetailTolerance tolerance,
                   RenderedBody& body);
// Replaces the body by the surface of one level of its pyramid. Beyond the last level the body
// stays as it is.
void reduce_to_level(const TrajectoryReader& reader, int frame, int level, RenderedBody& body);
// Makes the spheres of one level of each body's pyramid. A patch with fewer levels uses its last
// one.
void make_spheres(const TrajectoryReader& reader, int frame, int level,
                  std::vector<RenderedBody>& bodies);

// Returns the spheres of a body that make_spheres() would draw.
std::vector<bsi::Sphere> drawn_spheres(const TrajectoryReader& reader, int frame, int level,
                                       RenderedBody& body);

// Appends the surfaces by which the body is drawn. They refer to the body's data, which must
// outlive them.
void add_surfaces(RenderedBody& body, std::vector<gpu::DrawnSurface>& surfaces);

}  // namespace weft::sim
