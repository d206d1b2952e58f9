// The bodies of a trajectory in the form that is drawn: whole, at reduced detail, or as spheres of
// their pyramid. For render_trajectory.cpp.
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

// A body in the form that is drawn: the parts that stay the same over the frames, and its shape in
// one frame.
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
  // Places in `colour_map` by particle; if they are empty, the body has its `colours`.
  std::vector<float> places;
  const gpu::ColourMap* colour_map = nullptr;
  std::optional<bsi::Pyramid> pyramid;  // made when first needed
  // The members below are for reduced detail; if `detail` has no triangles, the body is drawn
  // whole.
  double most_deviation = 0;  // m
  bsi::DetailSurface detail;
  std::vector<Vec3> detail_normals;
  std::vector<float> detail_places;
  // The spheres of a level: those that touch no sphere of another body, and those that touch one.
  SphereSurface spheres, touching_spheres;
};

// Makes the bodies of a trajectory, without positions. Throws FileError for a body whose triangles
// form no surface.
std::vector<RenderedBody> rendered_bodies(const std::string& path, const TrajectoryReader& reader);

// Reads the positions of a frame; those of a body that does not move are read once. Throws
// std::runtime_error if they are not finite.
void read_positions(const TrajectoryReader& reader, int frame, RenderedBody& body);

// The functions below use the positions read last. For bodies that do not move, they do their work
// only once. They throw std::runtime_error, naming the frame, for bodies that are too far away.

// Reduces detail within the tolerance, and by so little that bodies do not show through each other.
void reduce_detail(const TrajectoryReader& reader, int frame, bsi::DetailTolerance tolerance,
                   RenderedBody& body);
// Replaces the body by the surface of one level of its pyramid; beyond the last level it stays.
void reduce_to_level(const TrajectoryReader& reader, int frame, int level, RenderedBody& body);
// Makes the spheres of one level of each body's pyramid, or of its last level if it has fewer.
void make_spheres(const TrajectoryReader& reader, int frame, int level,
                  std::vector<RenderedBody>& bodies);

// Returns the spheres that make_spheres() draws of a body.
std::vector<bsi::Sphere> drawn_spheres(const TrajectoryReader& reader, int frame, int level,
                                       RenderedBody& body);

// Appends the surfaces of a body that are drawn. They refer to the body's data.
void add_surfaces(RenderedBody& body,
                  std::vector<gpu::DrawnSurface>& surfaces);

}  // namespace weft::sim
