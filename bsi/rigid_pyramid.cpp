#include "bsi/rigid_pyramid.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <stdexcept>

#include "bsi/detail/rounded_up.h"

namespace weft::bsi {

namespace {

// Returns an upper bound (m) of the rounding error of a placed box along an axis (docs/theory.md,
// "A rigid body in its own frame"). The proof needs 28 x 2^-24 of the largest coordinate in the
// frame and 7 x 2^-24 of the translation. The last term covers underflow.
double rounding_of_boxes(double magnitude, double translation) {
  return 0x1p-19 * magnitude + 0x1p-21 * translation + 0x1p-120;
}

double largest_quad(const Atlas& atlas, std::span<const Vec3> positions) {
  double squared = 0;
  for (int quad = 0; quad < atlas.quad_count(); ++quad) {
    const std::array<int, 4> corner = atlas.quad_particles(quad);
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < i; ++j)
        squared = std::max(squared, (positions[corner[i]] - positions[corner[j]]).squaredNorm());
    }
  }
  return std::sqrt(squared);
}

}  // namespace

RigidPyramid::RigidPyramid(const Atlas& atlas, std::vector<Vec3> positions, bool spheres,
                           int threads)
    : pyramid_(atlas, {.tangents = false, .spheres = spheres}), positions_(std::move(positions)) {
  if (pyramid_.rebuild(positions_, threads))
    throw std::invalid_argument("a rigid body has a position that is not finite");
  for (const Vec3& p : positions_) radius_ = std::max(radius_, p.norm());
  if (spheres) largest_quad_ = largest_quad(atlas, positions_);
}

void RigidPyramid::place(std::span<const RigidFrame> ends, PlacedTree& placed) const {
  assert(ends.size() == 1 || ends.size() == 2);
  BoxPlacement& placement = placed.placement;
  placement.positions = positions_.data()->data();
  double translation = 0;
  for (std::size_t end = 0; end < 2; ++end) {
    const RigidFrame& frame = ends[std::min(end, ends.size() - 1)];
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        placement.rotation[end][i][j] = frame.rotation(i, j);
        placement.rotation_float[end][i][j] = static_cast<float>(frame.rotation(i, j));
      }
      placement.translation[end][i] = frame.translation[i];
      placement.translation_float[end][i] = static_cast<float>(frame.translation[i]);
      translation = std::max(translation, std::abs(frame.translation[i]));
    }
  }
  placement.rounding =
      rounded_up(rounding_of_boxes(static_cast<double>(pyramid_.magnitude()), translation));
  placed.tree = pyramid_.tree();
  placed.tree.placement = &placement;
  placed.tree.swept = ends.size() > 1 ? 1 : 0;
  const Box whole = placed_box(placed.tree, pyramid_.top());
  placed.tree.magnitude = 0;
  for (int axis = 0; axis < 3; ++axis) {
    placed.tree.magnitude = std::max({placed.tree.magnitude, -whole.low[axis], whole.high[axis]});
  }
  assert(placed.tree.magnitude < Pyramid::coordinate_limit);
  // Spheres are placed by the last frame alone. The positions of a vertex in the first and the last
  // frame are at most `way` (m) apart.
  const RigidFrame &first = ends.front(), &last = ends.back();
  const double way = (last.rotation - first.rotation).norm() * radius_ +
                     (last.translation - first.translation).norm();
  // Along each axis, a point of a leaf's box is at most `side` (m) from every vertex of the leaf at
  // the last frame.
  const double side = largest_quad_ + way;
  placed.beyond_spheres = static_cast<double>(root_of_three) * side * (1 + 0x1p-40) +
                          2 * static_cast<double>(placement.rounding);
}

Box placed_box(const BoxTree& tree, const Box& own) {
  const BoxPlacement& placement = *tree.placement;
  Box placed;
  for (int end = 0; end <= tree.swept; ++end) {
    for (int i = 0; i < 3; ++i) {
      double centre = placement.translation[end][i],
             half = 2 * static_cast<double>(placement.rounding);
      for (int j = 0; j < 3; ++j) {
        const auto low = static_cast<double>(own.low[j]), high = static_cast<double>(own.high[j]);
        centre += placement.rotation[end][i][j] * 0.5 * (low + high);
        half += std::abs(placement.rotation[end][i][j]) * 0.5 * (high - low);
      }
      const float low = -rounded_up(half - centre), high = rounded_up(half + centre);
      placed.low[i] = end == 0 ? low : std::min(placed.low[i], low);
      placed.high[i] = end == 0 ? high : std::max(placed.high[i], high);
    }
  }
  return placed;
}

}  // namespace weft::bsi
