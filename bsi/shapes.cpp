#include "bsi/shapes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <string>

namespace weft::bsi {

namespace {

void check_size(const char* name, double value) {
  if (value > 0 && std::isfinite(value)) return;
  throw std::invalid_argument(std::string(name) + " must be a positive length, not " +
                              std::to_string(value));
}

// Makes a patch row by row; position(row, col) is in m.
template <typename Position>
Surface make_patch(const Patch& patch, Position position) {
  Surface surface;
  surface.atlas = Atlas({patch});  // first: it checks the size
  surface.positions.reserve(surface.atlas.particle_count());
  for (int row = 0; row < patch.rows; ++row) {
    for (int col = 0; col < patch.cols; ++col) surface.positions.push_back(position(row, col));
  }
  return surface;
}

double turn(int index, int count) { return 2 * std::numbers::pi * index / count; }

}  // namespace

Surface make_rectangle(double size_x, double size_y, int rows, int cols) {
  check_size("the rectangle's size along x", size_x);
  check_size("the rectangle's size along y", size_y);
  return make_patch({rows, cols}, [&](int row, int col) {
    return Vec3(size_x * (static_cast<double>(col) / (cols - 1) - 0.5),
                size_y * (static_cast<double>(row) / (rows - 1) - 0.5), 0.0);
  });
}

Surface make_cylinder(double radius, double length, int rows, int cols) {
  check_size("the cylinder's radius", radius);
  check_size("the cylinder's length", length);
  return make_patch({rows, cols, true, false}, [&](int row, int col) {
    const double angle = turn(col, cols);
    return Vec3(radius * std::cos(angle), radius * std::sin(angle),
                length * (static_cast<double>(row) / (rows - 1) - 0.5));
  });
}

Surface make_torus(double major_radius, double minor_radius, int rows, int cols) {
  check_size("the torus' major radius", major_radius);
  check_size("the torus' minor radius", minor_radius);
  if (minor_radius >= major_radius) {
    throw std::invalid_argument("the torus' minor radius must be smaller than its major radius");
  }
  return make_patch({rows, cols, true, true}, [&](int row, int col) {
    const double tube = turn(col, cols);
    const double axis = turn(row, rows);
    const double distance = major_radius + minor_radius * std::cos(tube);
    // v runs downwards on the outside, so that u x v points out of the tube.
    return Vec3(distance * std::cos(axis), distance * std::sin(axis),
                -minor_radius * std::sin(tube));
  });
}

namespace {

using Lattice = std::array<int, 3>;

// Returns a point of the cube's surface in integers, -(n - 1) .. n - 1 along each axis. Texels of
// different faces are then matched without comparing floating-point numbers.
Lattice cube_point(int face, int row, int col, int n) {
  const int normal_axis = face / 2;
  const int sign = face % 2 == 0 ? 1 : -1;
  Lattice point{};
  point[normal_axis] = sign * (n - 1);
  // (u, v, normal) is right-handed on every face: u is reversed on the negative ones.
  point[(normal_axis + 1) % 3] = sign * (2 * col - (n - 1));
  point[(normal_axis + 2) % 3] = 2 * row - (n - 1);
  return point;
}

Vec3 on_unit_sphere(const Lattice& point, int n) {
  Vec3 direction;
  for (int axis = 0; axis < 3; ++axis) {
    direction[axis] = std::tan(std::numbers::pi / 4 * point[axis] / (n - 1));
  }
  return direction.normalized();
}

// Sorts texel indices by (key, texel): texels with the same key form a group in ascending order.
template <typename Less>
void sort_texels(std::vector<int>& texels, Less less) {
  std::ranges::sort(texels, [&](int a, int b) {
    if (less(a, b)) return true;
    if (less(b, a)) return false;
    return a < b;
  });
}

// Numbers particles in the order of their first texels. `first_of` names for each texel the first
// texel that coincides with it.
std::vector<int> number_particles(std::vector<int> first_of) {
  int count = 0;
  for (std::size_t texel = 0; texel < first_of.size(); ++texel) {
    const auto first = static_cast<std::size_t>(first_of[texel]);
    // first <= texel: earlier entries already hold particle indices.
    first_of[texel] = first == texel ? count++ : first_of[first];
  }
  return first_of;
}

}  // namespace

namespace {

// Makes the cube's six faces of n x n points, each split into split_v x split_u patches of equal
// size and sewn where points coincide. position(direction) maps a unit vector to m.
template <typename Position>
Surface make_cube_sphere(int n, int split_v, int split_u, Position position) {
  const Patch size{(n - 1) / split_v + 1, (n - 1) / split_u + 1};
  const int patches_a_face = split_v * split_u;
  const std::vector<Patch> patches(std::size_t{6} * patches_a_face, size);
  const Atlas unsewn(patches);
  std::vector<Lattice> points;
  points.reserve(unsewn.texel_count());
  for (int patch = 0; patch < 6 * patches_a_face; ++patch) {
    const int first_row = patch % patches_a_face / split_u * (size.rows - 1);
    const int first_col = patch % split_u * (size.cols - 1);
    for (int row = 0; row < size.rows; ++row) {
      for (int col = 0; col < size.cols; ++col) {
        points.push_back(cube_point(patch / patches_a_face, first_row + row, first_col + col, n));
      }
    }
  }
  std::vector<int> order(points.size());
  std::iota(order.begin(), order.end(), 0);
  sort_texels(order, [&](int a, int b) { return points[a] < points[b]; });
  std::vector<int> first_of(points.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && points[order[i]] == points[order[i - 1]];
    first_of[order[i]] = same ? first_of[order[i - 1]] : order[i];
  }
  std::vector<int> particles = number_particles(std::move(first_of));
  Surface surface;
  surface.positions.resize(*std::ranges::max_element(particles) + 1);
  for (std::size_t texel = 0; texel < points.size(); ++texel) {
    surface.positions[particles[texel]] = position(on_unit_sphere(points[texel], n));
  }
  surface.atlas = Atlas(patches, std::move(particles));
  return surface;
}

}  // namespace

Surface make_sphere(double radius, int n) {
  check_size("the sphere's radius", radius);
  return make_cube_sphere(n, 1, 1, [radius](const Vec3& p) -> Vec3 { return radius * p; });
}

Surface make_blob(double radius, int n) {
  check_size("the blob's radius", radius);
  return make_cube_sphere(4 * (n - 1) + 1, 2, 4, [radius](const Vec3& p) -> Vec3 {
    // The shape is star-shaped, so it cannot intersect itself, and asymmetric, so that every patch
    // differs.
    const double height = 0.14 * std::sin(3 * p.x() + 1) * std::cos(2 * p.y()) +
                          0.10 * std::sin(5 * p.z() + 2 * p.x()) +
                          0.06 * std::cos(7 * p.y() - 3 * p.z());
    return radius * (1 + height) * p;
  });
}

namespace {

bool on_border(const Patch& patch, const TexelAddress& place) {
  const bool end_u = place.col == 0 || place.col == patch.cols - 1;
  const bool end_v = place.row == 0 || place.row == patch.rows - 1;
  return (end_u && !patch.wrap_u) || (end_v && !patch.wrap_v);
}

void check_finite(const Atlas& atlas, const std::vector<Vec3>& texels) {
  for (std::size_t texel = 0; texel < texels.size(); ++texel) {
    if (texels[texel].allFinite()) continue;
    const TexelAddress place = atlas.texel_address(static_cast<int>(texel));
    throw std::invalid_argument("the position at patch " + std::to_string(place.patch) + ", row " +
                                std::to_string(place.row) + ", column " +
                                std::to_string(place.col) + " is not finite");
  }
}

// Returns for each texel the first one it is sewn to, or itself. Texels at one place that all
// belong to one patch are not sewn.
std::vector<int> sew(const Atlas& atlas, const std::vector<Vec3>& texels) {
  std::vector<int> first_of(texels.size());
  std::iota(first_of.begin(), first_of.end(), 0);
  std::vector<int> border;
  std::vector<int> patch_of(texels.size());
  for (std::size_t i = 0; i < texels.size(); ++i) {
    const auto texel = static_cast<int>(i);
    const TexelAddress place = atlas.texel_address(texel);
    patch_of[i] = place.patch;
    if (on_border(atlas.patches()[place.patch], place)) border.push_back(texel);
  }
  sort_texels(border, [&](int a, int b) {
    return std::ranges::lexicographical_compare(texels[a], texels[b]);
  });
  for (std::size_t begin = 0, end = 0; begin < border.size(); begin = end) {
    while (end < border.size() && texels[border[end]] == texels[border[begin]]) ++end;
    if (patch_of[border[begin]] == patch_of[border[end - 1]]) continue;
    for (std::size_t i = begin; i < end; ++i) first_of[border[i]] = border[begin];
  }
  return first_of;
}

}  // namespace

Surface make_from_texels(int patches, int rows, int cols, const std::vector<Vec3>& texels,
                         bool wrap_u, bool wrap_v) {
  if (patches < 1) throw std::invalid_argument("at least one patch is needed");
  const std::vector<Patch> sizes(patches, Patch{rows, cols, wrap_u, wrap_v});
  const Atlas unsewn(sizes);
  if (static_cast<std::int64_t>(texels.size()) != unsewn.texel_count()) {
    throw std::invalid_argument(std::to_string(texels.size()) + " positions were given for " +
                                std::to_string(unsewn.texel_count()) + " texels");
  }
  check_finite(unsewn, texels);
  std::vector<int> particles = number_particles(sew(unsewn, texels));
  const int count = *std::ranges::max_element(particles) + 1;
  if (count == unsewn.texel_count()) return {unsewn, texels};
  Surface surface;
  surface.positions.resize(count);
  for (std::size_t texel = 0; texel < texels.size(); ++texel) {
    surface.positions[particles[texel]] = texels[texel];
  }
  surface.atlas = Atlas(sizes, std::move(particles));
  return surface;
}

}  // namespace weft::bsi
