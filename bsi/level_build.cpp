// Compiled without contraction of a * b + c into one rounding (see CMakeLists.txt): exact spheres
// have the bits of those of the kernels.
#include "bsi/level_build.h"

#include <omp.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "bsi/pyramid.h"
#include "bsi/smallest_ball.h"
#include "bsi/sphere_bounds.h"

namespace weft::bsi {

namespace {

using Ends = std::span<const std::span<const Vec3>>;
using Vec3f = Eigen::Vector3f;

constexpr int quads_worth_threads = 1 << 12;

float square(const Vec3f& a) { return a.x() * a.x() + a.y() * a.y() + a.z() * a.z(); }

// See sphere_kernels.cpp for the formulas.
Sphere exact_sphere(std::span<const Vec3> points) {
  Vec3f low = points[0].cast<float>(), high = low;
  for (const Vec3& point : points) {
    low = low.cwiseMin(point.cast<float>());
    high = high.cwiseMax(point.cast<float>());
  }
  const Vec3f centre = 0.5F * (low + high);
  float squared = 0;
  for (const Vec3& point : points) {
    squared = std::max(squared, square(point.cast<float>() - centre));
  }
  const float magnitude = std::fabs(centre.x()) + std::fabs(centre.y()) + std::fabs(centre.z());
  return {centre.x(), centre.y(), centre.z(),
          std::sqrt(squared) * round_up + (magnitude * centre_rounding + radius_floor)};
}

// The smaller of a sphere and the smallest ball around its points.
Sphere tight_sphere(std::span<const Vec3> points, const Sphere& sphere) {
  const Vec3f centre = smallest_ball(points).centre.cast<float>();
  double squared = 0;
  for (const Vec3& point : points) {
    squared = std::max(squared, (point - centre.cast<double>()).squaredNorm());
  }
  // float64 rounds by far less than 2^-40 here; the cast may round down, the next number up cannot.
  const auto reach = static_cast<float>(std::sqrt(squared) * (1 + 0x1p-40));
  const float radius =
      std::max(std::nextafter(reach, std::numeric_limits<float>::infinity()), radius_floor);
  return radius < sphere.radius ? Sphere{centre.x(), centre.y(), centre.z(), radius} : sphere;
}

void add_vertices(const Atlas& atlas, Ends ends, int patch, const QuadRange& range,
                  std::vector<Vec3>& points) {
  for (int row = range.row_begin; row <= range.row_end; ++row) {
    for (int col = range.col_begin; col <= range.col_end; ++col) {
      for (const auto& positions : ends)
        points.push_back(positions[atlas.particle(patch, row, col)]);
    }
  }
}

// Triangle 0 or 1 of the quad at (row, col).
void add_vertices_of_triangle(const Atlas& atlas, Ends ends, int patch, int row, int col,
                              int triangle, std::vector<Vec3>& points) {
  const int quad = atlas.first_quad(patch) + row * atlas.patches()[patch].quad_cols() + col;
  const auto both = quad_triangles(atlas.quad_particles(quad));
  for (const int particle : both[triangle]) {
    for (const auto& positions : ends) points.push_back(positions[particle]);
  }
}

// Calls set(block, points) for every block of a level that is not empty, counted row by row.
template <typename Set>
void for_each_block(const Atlas& atlas, const BlockLevels& numbers, Ends ends, int patch, int level,
                    int threads, const Set& set) {
  const bool triangles = level == numbers.levels(patch);
  const int quad_level = triangles ? level - 1 : level;
  const BlockLevel& place = numbers.at(patch, quad_level);
  const int columns = 1 << (place.log_u + (triangles ? 1 : 0));
  const int count = columns << place.log_v;
#pragma omp parallel num_threads(threads) if (count > 1 && atlas.patches()[patch].quad_count() >= \
                                                               quads_worth_threads)
  {
    std::vector<Vec3> points;
#pragma omp for schedule(dynamic, 16)
    for (int i = 0; i < count; ++i) {
      const int u = i % columns, v = i / columns;
      const QuadRange range = numbers.quads(patch, quad_level, triangles ? u / 2 : u, v);
      if (range.empty()) continue;
      points.clear();
      if (triangles) {
        add_vertices_of_triangle(atlas, ends, patch, range.row_begin, range.col_begin, u % 2,
                                 points);
      } else {
        add_vertices(atlas, ends, patch, range, points);
      }
      set(i, std::span<const Vec3>(points));
    }
  }
}

bool is_bounded(const Vec3& position) {
  // Not a maximum, which swallows what is not a number.
  return (position.cast<float>().array().abs() < Pyramid::coordinate_limit).all();
}

}  // namespace

std::optional<TexelAddress> build_level(const Atlas& atlas, std::span<const Vec3> positions,
                                        int patch, int level, RadiusPolicy policy,
                                        std::vector<Sphere>& spheres) {
  assert(static_cast<int>(positions.size()) == atlas.particle_count());
  spheres.clear();
  const Patch& image = atlas.patches()[patch];
  for (int texel = 0; texel < image.texel_count(); ++texel) {
    const int row = texel / image.cols, col = texel % image.cols;
    if (!is_bounded(positions[atlas.particle(patch, row, col)])) {
      return TexelAddress{patch, row, col};
    }
  }
  const BlockLevels numbers(atlas);
  assert(level <= numbers.levels(patch));
  const bool triangles = level == numbers.levels(patch);
  spheres.resize(triangles ? 2 * numbers.at(patch, level - 1).count()
                           : numbers.at(patch, level).count());
  for_each_block(atlas, numbers, std::array{positions}, patch, level, omp_get_max_threads(),
                 [&](int block, std::span<const Vec3> points) {
                   const Sphere sphere = exact_sphere(points);
                   spheres[block] =
                       policy == RadiusPolicy::tight ? tight_sphere(points, sphere) : sphere;
                 });
  return std::nullopt;
}

void tighten(const SphereTree& tree, Ends ends, int threads) {
  const Atlas& atlas = *tree.atlas;
  const BlockLevels& numbers = *tree.numbers;
  Sphere* triangles = tree.triangles;
  for (int patch = 0; patch < numbers.patch_count(); ++patch) {
    for (int level = 0; level < numbers.levels(patch); ++level) {
      Sphere* spheres = tree.spheres + numbers.at(patch, level).first;
      for_each_block(atlas, numbers, ends, patch, level, threads,
                     [&](int block, std::span<const Vec3> points) {
                       spheres[block] = tight_sphere(points, spheres[block]);
                     });
    }
    if (triangles == nullptr) continue;
    for_each_block(atlas, numbers, ends, patch, numbers.levels(patch), threads,
                   [&](int block, std::span<const Vec3> points) {
                     triangles[block] = tight_sphere(points, triangles[block]);
                   });
    triangles += 2 * numbers.at(patch, numbers.levels(patch) - 1).count();
  }
  std::vector<Vec3> points;
  for (int level = 0; level < numbers.group_levels(); ++level) {
    for (int group = 0; group < 1 << level; ++group) {
      const auto [begin, end] = numbers.patches_of_group(level, group);
      points.clear();
      for (int patch = begin; patch < end; ++patch) {
        add_vertices(atlas, ends, patch, numbers.quads(patch, 0, 0, 0), points);
      }
      Sphere& sphere = tree.groups[(std::size_t{1} << level) - 1 + group];
      sphere = tight_sphere(points, sphere);
    }
  }
}

}  // namespace weft::bsi
