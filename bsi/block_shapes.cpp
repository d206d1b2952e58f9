// Closed shapes whose patches tile the six faces of a block: box, capsule, sphere and blob.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <stdexcept>

#include "bsi/detail/sewn_patches.h"
#include "bsi/shapes.h"

namespace weft::bsi {

namespace {

// Numbers of quads along the block's x, y and z axes.
using Quads = std::array<int, 3>;

// Size of a patch: numbers of quads along v (rows) and u (columns).
struct Tile {
  int v = 0;
  int u = 0;
};

// Returns the label of a vertex of a face: twice its coordinates relative to the block's centre, in
// quads. Faces are numbered +x, -x, +y, -y, +z, -z.
Label block_point(int face, int row, int col, const Quads& quads) {
  const int normal = face / 2;
  const int u = (normal + 1) % 3;
  const int v = (normal + 2) % 3;
  const int sign = face % 2 == 0 ? 1 : -1;
  Label point{};
  point[normal] = sign * quads[normal];
  // u is reversed on the negative faces, so that (u, v, normal) is right-handed on every face.
  point[u] = sign * (2 * col - quads[u]);
  point[v] = 2 * row - quads[v];
  return point;
}

// Makes the six faces of a block, each split into patches of the size of `tile`. position(label) is
// in m. Precondition: `tile` divides every face evenly.
Surface make_block(const Quads& quads, const Tile& tile,
                   const std::function<Vec3(const Label&)>& position) {
  std::vector<Patch> patches;
  std::vector<Label> labels;
  for (int face = 0; face < 6; ++face) {
    const int across = quads[(face / 2 + 1) % 3] / tile.u;
    const int tiles = across * (quads[(face / 2 + 2) % 3] / tile.v);
    for (int i = 0; i < tiles; ++i) {
      patches.push_back({tile.v + 1, tile.u + 1});
      for (int row = 0; row <= tile.v; ++row) {
        for (int col = 0; col <= tile.u; ++col) {
          labels.push_back(
              block_point(face, i / across * tile.v + row, i % across * tile.u + col, quads));
        }
      }
    }
  }
  return make_sewn(patches, labels, position);
}

// Returns the largest square patch that divides every face evenly.
Tile square_tile(const Quads& quads) {
  const int side = std::gcd(std::gcd(quads[0], quads[1]), quads[2]);
  return {side, side};
}

// Projects a vertex of a cube, with `quads` quads per edge, onto the unit sphere. The images of
// rows and columns lie in planes through the centre, at equal angles.
Vec3 on_unit_sphere(const Label& point, int quads) {
  Vec3 direction;
  for (int axis = 0; axis < 3; ++axis) {
    direction[axis] = std::tan(std::numbers::pi / 4 * point[axis] / quads);
  }
  return direction.normalized();
}

// Makes a sphere-like surface from a cube with `quads` quads per edge. The vertices are projected
// onto the unit sphere. position(p) returns the position (m) of the vertex at point p of that
// sphere.
template <typename Position>
Surface make_cube_sphere(int quads, const Tile& tile, Position position) {
  return make_block({quads, quads, quads}, tile,
                    [&](const Label& p) -> Vec3 { return position(on_unit_sphere(p, quads)); });
}

void check_vertices(int n) {
  if (n < 2) throw std::invalid_argument("an open axis needs at least 2 vertices");
}

}  // namespace

Surface make_sphere(double radius, int n) {
  check_size("the sphere's radius", radius);
  check_vertices(n);
  return make_cube_sphere(n - 1, {n - 1, n - 1},
                          [radius](const Vec3& p) -> Vec3 { return radius * p; });
}

Surface make_blob(double radius, int n) {
  check_size("the blob's radius", radius);
  check_vertices(n);
  return make_cube_sphere(4 * (n - 1), {2 * (n - 1), n - 1}, [radius](const Vec3& p) -> Vec3 {
    // The blob is star-shaped, so it cannot intersect itself. It is asymmetric, so no two patches
    // are alike.
    const double height = 0.14 * std::sin(3 * p.x() + 1) * std::cos(2 * p.y()) +
                          0.10 * std::sin(5 * p.z() + 2 * p.x()) +
                          0.06 * std::cos(7 * p.y() - 3 * p.z());
    return radius * (1 + height) * p;
  });
}

Surface make_box(const Vec3& size, const std::array<int, 3>& vertices) {
  for (const double side : size) check_size("the box's size", side);
  Quads quads{};
  for (int axis = 0; axis < 3; ++axis) {
    check_vertices(vertices[axis]);
    quads[axis] = vertices[axis] - 1;
  }
  return make_block(quads, square_tile(quads), [&](const Label& point) {
    Vec3 position;
    // Multiplication by 0.5 is exact, so corners lie at exactly half the size.
    for (int axis = 0; axis < 3; ++axis)
      position[axis] = size[axis] * (0.5 * point[axis] / quads[axis]);
    return position;
  });
}

Surface make_capsule(double radius, double length, int rows, int n) {
  check_size("the capsule's radius", radius);
  check_size("the capsule's length", length);
  check_vertices(n);
  check_vertices(rows);
  const int straight = rows - 1;
  // Each end of the block is half of a cube with 2 (n - 1) quads per edge. The straight part lies
  // between the ends.
  const int cube = 2 * (n - 1);
  const Quads quads{cube, cube, cube + straight};
  return make_block(quads, square_tile(quads), [=](const Label& point) -> Vec3 {
    const int along = std::clamp(point[2], -straight, straight);
    const Vec3 end = on_unit_sphere({point[0], point[1], point[2] - along}, cube);
    return radius * end + Vec3(0, 0, 0.5 * length * along / straight);
  });
}

}  // namespace weft::bsi
