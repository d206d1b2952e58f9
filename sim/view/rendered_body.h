// The bodies of a trajectory as they are drawn: whole, at reduced detail, or as spheres of their
// pyramid. For render_trajectory.cpp.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "bsi/level_of_detail.h"
#include "bsi/pyramid.h"
#include "gpu/renderer.h"
#include "sim/trajectory/trajectory.h"

namespace weft::sim {

// Many spheres as one surface.
struct SphereSurface {
  std::vector<Vec3> positions;  // m
  std::vector<Vec3> normals;
  std::vector<std::array<int, 3>> triangles;
};

// A body as it is drawn: the parts that stay the same over the frames, and its shape in one frame.
struct RenderedBody {
  int index = 0;
  bool moves = true;
  bool is_obstacle = false;
  bsi::Mesh mesh;
  std::vector<std::array<int, 2>> lines;
  gpu::SurfaceColours colours;
  std::vector<Vec3> positions;
  std::optional<bsi::Pyramid> pyramid;  // made when first needed
  // Reduced detail; without triangles the body is drawn whole.
  double most_deviation = 0;  // m
  bsi::DetailSurface detail;
  std::vector<Vec3> detail_normals;
  // The spheres of a level that touch none of another body, and those that do.
  SphereSurface spheres, touching_spheres;
};

// Throws FileError for a body whose triangles make no surface.
std::vector<RenderedBody> rendered_bodies(const std::string& path, const TrajectoryReader& reader);

// Positions that stay are read once. Throws std::runtime_error for those that are not finite.
void read_positions(const TrajectoryReader& reader, int frame, RenderedBody& body);

// The functions below use the positions read last; for bodies that stay, they do so once. They
// throw std::runtime_error, naming the frame, for bodies too far away.

// Detail within the tolerance, and little enough that bodies do not show through each other.
void reduce_detail(const TrajectoryReader& reader, int frame, bsi::DetailTolerance tolerance,
                   RenderedBody& body);
// The surface of one level of the pyramid; beyond its last level the body as it is.
void reduce_to_level(const TrajectoryReader& reader, int frame, int level, RenderedBody& body);
// The spheres of one level of the pyramids of all bodies, of its last one where there are fewer.
void make_spheres(const TrajectoryReader& reader, int frame, int level,
                  std::vector<RenderedBody>& bodies);

// Appends what is to be drawn of a body. The surfaces refer to it.
void add_surfaces(const TrajectoryReader& reader, RenderedBody& body,
                  std::vector<gpu::DrawnSurface>& surfaces);

}  // namespace weft::sim
