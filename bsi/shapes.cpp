#include "bsi/shapes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <string>

#include "bsi/detail/sewn_patches.h"

namespace weft::bsi {

namespace {

// Makes a surface of one patch from position(row, col), m.
template <typename Position>
Surface make_patch(const Patch& patch, Position position) {
  Surface surface;
  surface.atlas = Atlas({patch});  // first, because it checks the size
  surface.positions.reserve(surface.atlas.particle_count());
  for (int row = 0; row < patch.rows; ++row) {
    for (int col = 0; col < patch.cols; ++col) surface.positions.push_back(position(row, col));
  }
  return surface;
}

double turn(int index, int count) { return 2 * std::numbers::pi * index / count; }

// The angles (radians) of the columns of a surface of revolution. They begin at the x axis and run
// counter-clockwise seen from +z. A sector of 360 degrees is closed.
struct Sector {
  explicit Sector(double degrees, int cols) : angle_deg(degrees), count(cols) {
    if (degrees > 0 && degrees <= 360) return;
    throw std::invalid_argument("the angle must be more than 0 and at most 360 degrees, not " +
                                std::to_string(degrees));
  }
  bool closed() const { return angle_deg == 360; }
  double angle(int col) const {
    if (closed()) return turn(col, count);
    return std::numbers::pi / 180 * angle_deg * col / (count - 1);
  }

  double angle_deg;
  int count;
};

// A point of the profile of a surface of revolution.
struct ProfilePoint {
  double distance;  // distance from the z axis, m
  double z;         // m
};

// Revolves a profile around the z axis. profile(v) returns the profile's point for v from 0 (first
// row) to 1 (last row).
template <typename Profile>
Surface revolve(int rows, int cols, double angle_deg, Profile profile) {
  const Sector sector(angle_deg, cols);
  return make_patch({rows, cols, sector.closed(), false}, [&](int row, int col) {
    const double angle = sector.angle(col);
    const ProfilePoint point = profile(static_cast<double>(row) / (rows - 1));
    return Vec3(point.distance * std::cos(angle), point.distance * std::sin(angle), point.z);
  });
}

}  // namespace

Surface make_rectangle(double size_x, double size_y, int rows, int cols) {
  check_size("the rectangle's size along x", size_x);
  check_size("the rectangle's size along y", size_y);
  return make_patch({rows, cols}, [&](int row, int col) {
    return Vec3(size_x * (static_cast<double>(col) / (cols - 1) - 0.5),
                size_y * (static_cast<double>(row) / (rows - 1) - 0.5), 0.0);
  });
}

Surface make_cylinder(double radius, double length, int rows, int cols, double angle_deg) {
  check_size("the cylinder's radius", radius);
  check_size("the cylinder's length", length);
  return revolve(rows, cols, angle_deg, [=](double v) -> ProfilePoint {
    return {radius, length * (v - 0.5)};
  });
}

Surface make_frustum(double radius, double top_radius, double length, int rows, int cols) {
  check_size("the cone's radius", radius);
  check_size("the cone's top radius", top_radius);
  check_size("the cone's length", length);
  return revolve(rows, cols, 360, [=](double v) -> ProfilePoint {
    return {(1 - v) * radius + v * top_radius, length * (v - 0.5)};
  });
}

Surface make_annulus(double inner_radius, double outer_radius, int rows, int cols,
                     double angle_deg) {
  check_size("the annulus' inner radius", inner_radius);
  check_size("the annulus' outer radius", outer_radius);
  if (inner_radius >= outer_radius) {
    throw std::invalid_argument("the annulus' inner radius must be smaller than its outer radius");
  }
  // Rows run inwards, so that u x v points along +z.
  return revolve(rows, cols, angle_deg, [=](double v) -> ProfilePoint {
    return {(1 - v) * outer_radius + v * inner_radius, 0};
  });
}

Surface make_sphere_sector(double radius, double south_deg, double north_deg, int rows, int cols,
                           double angle_deg) {
  check_size("the sphere's radius", radius);
  if (!(south_deg > -90 && south_deg < north_deg && north_deg < 90)) {
    throw std::invalid_argument("the latitudes must rise between -90 and 90 degrees");
  }
  return revolve(rows, cols, angle_deg, [=](double v) -> ProfilePoint {
    const double latitude = std::numbers::pi / 180 * ((1 - v) * south_deg + v * north_deg);
    return {radius * std::cos(latitude), radius * std::sin(latitude)};
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
    // u runs downwards on the outside, so that u x v points out of the tube.
    return Vec3(distance * std::cos(axis), distance * std::sin(axis),
                -minor_radius * std::sin(tube));
  });
}

Surface cut_into_patches(const Surface& surface, int patch_rows, int patch_cols) {
  if (surface.atlas.patches().size() != 1)
    throw std::invalid_argument("only a surface of one patch can be cut into patches");
  const Patch& whole = surface.atlas.patches()[0];
  if (patch_rows < 1 || patch_cols < 1 || whole.quad_rows() % patch_rows != 0 ||
      whole.quad_cols() % patch_cols != 0) {
    throw std::invalid_argument("the image does not divide into patches of equal size");
  }
  const int quad_rows = whole.quad_rows() / patch_rows, quad_cols = whole.quad_cols() / patch_cols;
  Patch patch = whole;  // an axis that is not cut keeps its wrap
  if (patch_rows > 1) {
    patch.rows = quad_rows + 1;
    patch.wrap_v = false;
  }
  if (patch_cols > 1) {
    patch.cols = quad_cols + 1;
    patch.wrap_u = false;
  }
  std::vector<Label> labels;
  for (int tile = 0; tile < patch_rows * patch_cols; ++tile) {
    for (int texel = 0; texel < patch.texel_count(); ++texel) {
      const int row = tile / patch_cols * quad_rows + texel / patch.cols;
      const int col = tile % patch_cols * quad_cols + texel % patch.cols;
      labels.push_back({surface.atlas.particle(0, row, col), 0, 0});
    }
  }
  return make_sewn(std::vector<Patch>(patch_rows * patch_cols, patch), labels,
                   [&](const Label& label) { return surface.positions[label[0]]; });
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

// Returns, for each texel, the first texel to which it is sewn, or itself. Border texels at the
// same position are sewn only if they belong to more than one patch.
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
