// The shapes that a case file can name, as geometry images.
#pragma once

#include <vector>

#include "bsi/geometry_image.h"

namespace weft::bsi {

// An atlas with the position of every particle, in metres.
struct Surface {
  Atlas atlas;
  std::vector<Vec3> positions;  // atlas.particle_count()
};

// All functions throw std::invalid_argument on a size that is not positive or too few vertices.
// Particles are numbered in the order of their first texels.

// A rectangle in the x-y plane, centred on the origin: u along x, v along y; normal +z.
Surface make_rectangle(double size_x, double size_y, int rows, int cols);
// A cylinder around the z axis, centred on the origin, open at both ends: u around (wrapped), v
// along z; normal outwards.
Surface make_cylinder(double radius, double length, int rows, int cols);
// A torus around the z axis: u around the tube (wrapped), v around the axis (wrapped); normal
// outwards. Also throws unless the minor radius is below the major one: the tube would intersect
// itself.
Surface make_torus(double major_radius, double minor_radius, int rows, int cols);
// A sphere of six sewn patches of n x n vertices: the faces of a cube with equal angles between the
// vertices. Normal outwards.
Surface make_sphere(double radius, int n);
// A sphere with dents and bulges of up to 30 % of its radius, as 48 sewn patches of 2 n - 1 rows
// and n columns: each face of the cube is split into 2 x 4. Normal outwards.
Surface make_blob(double radius, int n);
// A surface of patches of `rows` x `cols` positions given texel by texel, as read from a file.
// Border texels of different patches at exactly the same position are sewn. Throws on a position
// that is not finite, naming the texel.
Surface make_from_texels(int patches, int rows, int cols, const std::vector<Vec3>& texels,
                         bool wrap_u, bool wrap_v);

}  // namespace weft::bsi
