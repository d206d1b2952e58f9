// What tests of the sphere pyramid ask of one, by brute force.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "bsi/pyramid.h"
#include "bsi/shapes.h"

namespace weft::bsi {

using Positions = std::vector<Vec3>;

inline constexpr std::array all_policies{RadiusPolicy::fast, RadiusPolicy::exact,
                                         RadiusPolicy::tight};

// Every block of the hierarchy, from the root down.
inline std::vector<Block> all_blocks(const Pyramid& pyramid) {
  std::vector<Block> blocks{pyramid.root()};
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (pyramid.is_leaf(blocks[i])) continue;
    std::array<Block, 4> child;
    const int count = pyramid.children(blocks[i], child);
    blocks.insert(blocks.end(), child.begin(), child.begin() + count);
  }
  return blocks;
}

// The quads below a block, found by walking down to the leaves.
inline std::vector<int> quads_below(const Pyramid& pyramid, const Block& block) {
  std::vector<int> quads;
  std::vector<Block> stack{block};
  while (!stack.empty()) {
    const Block next = stack.back();
    stack.pop_back();
    if (pyramid.is_leaf(next)) {
      quads.push_back(pyramid.quad_of_leaf(next));
      continue;
    }
    std::array<Block, 4> child;
    const int count = pyramid.children(next, child);
    stack.insert(stack.end(), child.begin(), child.begin() + count);
  }
  std::ranges::sort(quads);
  return quads;
}

// Largest distance from the centre of a block's sphere to the vertices of its quads, in float64
// (long double where float64 would round).
inline long double reach(const Pyramid& pyramid, const Block& block, const Positions& positions) {
  const Sphere& sphere = pyramid.sphere(block);
  long double squared = 0;
  for (const int quad : quads_below(pyramid, block)) {
    for (const int particle : pyramid.atlas().quad_particles(quad)) {
      const auto x = static_cast<long double>(positions[particle].x()) - sphere.x;
      const auto y = static_cast<long double>(positions[particle].y()) - sphere.y;
      const auto z = static_cast<long double>(positions[particle].z()) - sphere.z;
      squared = std::max(squared, x * x + y * y + z * z);
    }
  }
  return std::sqrt(squared);
}

inline double largest_coordinate(const Positions& positions) {
  double largest = 0;
  for (const Vec3& position : positions) {
    largest = std::max(largest, position.cwiseAbs().maxCoeff());
  }
  return largest;
}

inline void expect_conservative(const Pyramid& pyramid, const Positions& positions) {
  for (const Block& block : all_blocks(pyramid)) {
    EXPECT_LE(reach(pyramid, block, positions), pyramid.sphere(block).radius)
        << "patch " << block.patch << " level " << block.level << " u " << block.u << " v "
        << block.v;
  }
}

// Radii beyond the reach of the vertices, allowing for what rounding to float32 costs.
inline void expect_tight(const Pyramid& pyramid, const Positions& positions, double factor) {
  const double rounding = largest_coordinate(positions) * 0x1p-22 + 2e-18;
  for (const Block& block : all_blocks(pyramid)) {
    EXPECT_LE(pyramid.sphere(block).radius, factor * reach(pyramid, block, positions) + rounding)
        << "patch " << block.patch << " level " << block.level;
  }
}

inline Surface crumple(Surface surface, double amplitude, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, amplitude);
  for (Vec3& position : surface.positions) {
    position += Vec3(noise(random), noise(random), noise(random));
  }
  return surface;
}

// Surfaces of every kind: odd and even sizes, long and thin, wrapped, of several patches.
inline std::vector<Surface> surfaces() {
  std::vector<Surface> list;
  for (const auto& [rows, cols] :
       {std::pair{2, 2}, {3, 2}, {2, 7}, {17, 17}, {18, 16}, {6, 41}, {53, 4}, {33, 20}}) {
    list.push_back(crumple(make_rectangle(1.0, 1.5, rows, cols), 0.05, 1));
  }
  list.push_back(crumple(make_cylinder(0.5, 1.0, 9, 15), 0.02, 2));
  list.push_back(crumple(make_torus(1.0, 0.3, 3, 3), 0.02, 3));
  list.push_back(make_torus(1.0, 0.3, 37, 22));
  for (const int n : {2, 3, 6}) list.push_back(crumple(make_sphere(1.0, n), 0.02, 4));
  list.push_back(make_from_texels(1, 5, 3, make_rectangle(1, 1, 5, 3).positions, false, true));
  // Patches of different sizes, in a number that is no power of two.
  Surface mixed;
  mixed.atlas = Atlas({{2, 9}, {5, 5, true, false}, {3, 3}, {12, 2}, {4, 6, true, true}});
  mixed.positions.resize(mixed.atlas.particle_count(), Vec3::Zero());
  list.push_back(crumple(std::move(mixed), 1.0, 5));
  return list;
}

}  // namespace weft::bsi
