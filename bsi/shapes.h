// Shapes as geometry images: functions that make an atlas and the positions of its particles.
#pragma once

#include <array>
#include <vector>

#include "bsi/geometry_image.h"

namespace weft::bsi {

// An atlas and the positions of its particles.
struct Surface {
  Atlas atlas;
  std::vector<Vec3> positions;  // one per particle, m
};

// Lengths are in m. All functions throw std::invalid_argument on too few vertices, on a size that
// is not positive and finite, and on an invalid angle. Particles are numbered in the order of their
// first texels. All patches of a shape have the same size. Areas and volumes differ from those of
// the smooth shape by terms of second order in the spacing of the vertices, except for the cone.
// With `angle_deg` below 360, a shape is the sector that begins at the x axis and runs
// counter-clockwise. Its u axis is then open.

// A rectangle in the x-y plane, centred on the origin: u along x, v along y; normal +z.
Surface make_rectangle(double size_x, double size_y, int rows, int cols);
// A disc in the x-y plane, centred on the origin, of 12 sewn patches of n x n vertices; normal +z.
// Patches 0 to 3 form a square around the centre. Patches 4 to 11 form the ring around the square,
// counter-clockwise. In the ring, u runs along the rim, and the first row of a patch lies on the
// rim. The angles of triangles are at least 30 degrees (26 for n = 2).
Surface make_disc(double radius, int n);
// An annulus in the x-y plane: u around (wrapped), v from the outer to the inner radius; normal +z.
Surface make_annulus(double inner_radius, double outer_radius, int rows, int cols,
                     double angle_deg = 360);

// A box centred on the origin, with sharp edges. `vertices` is the number of vertices along x, y
// and z. Each face is split into square patches of the largest size that fits all faces: the
// greatest common divisor of the numbers of quads along x, y and z. The normal points outwards.
Surface make_box(const Vec3& size, const std::array<int, 3>& vertices);
// A cylinder around the z axis, centred on the origin, open at both ends: u around (wrapped), v
// along z. The normal points outwards.
Surface make_cylinder(double radius, double length, int rows, int cols, double angle_deg = 360);
// A cylinder of `length` around the z axis with a hemisphere on each end, centred on the origin. An
// eighth of the circumference has n vertices, and the straight part has `rows` rows. The patches
// are arranged as on a box with 2 n - 1 vertices along x and y and rows + 2 n - 2 along z. The
// normal points outwards.
Surface make_capsule(double radius, double length, int rows, int n);
// The side of a cone around the z axis, with its apex at z = length / 2 and its open base at z =
// -length / 2. The patches are arranged as on the disc, with a vertex at the apex. Triangles of
// slender cones have smaller angles than those of the disc. The normal points outwards. The error
// of the area is of order h^2 log(n) in the spacing h, because the curvature is unbounded at the
// apex.
Surface make_cone(double radius, double length, int n);
// The side of a frustum of a cone: `radius` at z = -length / 2, `top_radius` at z = length / 2.
// Open at both ends: u around (wrapped), v along z. The normal points outwards.
Surface make_frustum(double radius, double top_radius, double length, int rows, int cols);
// A torus around the z axis: u around the tube (wrapped), v around the axis (wrapped). The normal
// points outwards. Also throws if the minor radius is not smaller than the major radius, because
// the tube would intersect itself.
Surface make_torus(double major_radius, double minor_radius, int rows, int cols);

// A sphere of six sewn patches of n x n vertices, one per face of a cube. The rows and columns of a
// patch lie in planes through the centre, at equal angles. The normal points outwards.
Surface make_sphere(double radius, int n);
// The part of a sphere between two latitudes, -90 < south < north < 90 degrees: u around (wrapped),
// v northwards. The normal points outwards.
Surface make_sphere_sector(double radius, double south_deg, double north_deg, int rows, int cols,
                           double angle_deg = 360);
// A sphere with dents and bulges of up to 30 % of its radius. It has 48 sewn patches of 2 n - 1
// rows and n columns: 2 x 4 patches per face of a cube. The normal points outwards.
Surface make_blob(double radius, int n);

// Cuts a surface of one patch into patch_rows x patch_cols patches of equal size. They are numbered
// row by row and sewn along the cuts. A closed axis that is cut becomes an open axis of each patch.
// Throws std::invalid_argument if the surface has more than one patch, if a number of patches is
// not positive, or if the quads do not divide evenly.
Surface cut_into_patches(const Surface& surface, int patch_rows, int patch_cols);

// A surface from the positions (m) of its texels, patch by patch and row by row. Border texels of
// different patches at exactly the same position are sewn. Throws std::invalid_argument on a wrong
// number of positions, or on a position that is not finite; the message names its texel.
Surface make_from_texels(int patches, int rows, int cols, const std::vector<Vec3>& texels,
                         bool wrap_u, bool wrap_v);

}  // namespace weft::bsi
