// The bodies of a trajectory as they are drawn: at full or reduced detail, or as spheres of their
// pyramids.
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

// A surface that consists of many triangulated spheres.
struct SphereSurface {
  std::vector<Vec3> positions;  // m
  std::vector<Vec3> normals;
  std::vector<std::array<int, 3>> triangles;
};

// A body as it is drawn: data that are the same in all frames, and the body's shape in one frame.
struct RenderedBody {
  explicit RenderedBody(const TrajectoryBody& body) : surface(body) {}

  RecordedSurface surface;
  int index = 0;  // index of the body in the trajectory
  bool moves = true;
  bool is_obstacle = false;
  bsi::Mesh mesh;                         // triangles of `surface`
  std::vector<std::array<int, 2>> lines;  // grid lines, as pairs of particles of the surface
  gpu::SurfaceColours colours;
  std::vector<Vec3> positions;  // m, by particle of the surface
  // Positions in `colour_map` (0 to 1, or NaN), by particle of the surface. If empty, `colours` are
  // used.
  std::vector<float> places;
  const gpu::ColourMap* colour_map = nullptr;
  std::optional<bsi::Pyramid> pyramid;  // built when first needed
  double most_deviation = 0;  // largest distance (m) by which reduce_detail() may move the surface
  bsi::DetailSurface detail;  // surface with fewer triangles; if it is empty, `mesh` is drawn
  std::vector<Vec3> detail_normals;  // normals of `detail`
  std::vector<float> detail_places;  // positions of the points of `detail` in `colour_map`
  std::vector<double> radii;         // m, of the spheres of a group of particles; else empty
  std::vector<float> sphere_places;  // positions of the points of `spheres` in `colour_map`
  // Spheres of one level: those that touch no sphere of another body, and those that do.
  SphereSurface spheres, touching_spheres;
};

// Returns the bodies of a trajectory, without positions. `path` is the path of the file for error
// messages. Throws FileError for a body whose triangles form no surface.
std::vector<RenderedBody> rendered_bodies(const std::string& path, const TrajectoryReader& reader);

// Sets the positions of a body to those of a frame. If the body does not move, they are read only
// once. Throws std::runtime_error, naming the frame, for a position that is not finite or has a
// coordinate beyond 1e9 m.
void read_positions(const TrajectoryReader& reader, int frame, RenderedBody& body);

// Sets RenderedBody::detail to a surface with fewer triangles for the present positions. The
// surface deviates by no more than the tolerance and RenderedBody::most_deviation. A body that does
// not move is reduced only once. Throws std::runtime_error, naming the frame, for a body that is
// too far away.
void reduce_detail(const TrajectoryReader& reader, int frame, bsi::DetailTolerance tolerance,
                   RenderedBody& body);
// Sets RenderedBody::detail to the surface of one level of the body's pyramid. A patch with fewer
// levels keeps its own triangles. A body that does not move is reduced only once. Throws
// std::runtime_error like reduce_detail().
void reduce_to_level(const TrajectoryReader& reader, int frame, int level, RenderedBody& body);
// Makes the spheres of one level of each body's pyramid, for the present positions. A patch with
// fewer levels uses its last level. Throws std::runtime_error like reduce_detail().
void make_spheres(const TrajectoryReader& reader, int frame, int level,
                  std::vector<RenderedBody>& bodies);

// Returns the spheres that make_spheres() would give to a body; none for particles. Throws
// std::runtime_error like reduce_detail().
std::vector<bsi::Sphere> drawn_spheres(const TrajectoryReader& reader, int frame, int level,
                                       RenderedBody& body);

// Appends the surfaces that represent the body in a picture: its spheres, else its surface with
// fewer triangles, else all its triangles. They refer to the body's data, which must outlive them.
void add_surfaces(RenderedBody& body, std::vector<gpu::DrawnSurface>& surfaces);

}  // namespace weft::sim
