#include "bsi/level_of_detail.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <map>
#include <random>
#include <set>
#include <string>

#include "bsi/proximity.h"
#include "bsi/shapes.h"

namespace weft::bsi::level_of_detail_test {
namespace {

// Bends a body, so that no block of it is flat.
void bend(Surface& surface) {
  for (Vec3& p : surface.positions) {
    p += Vec3(0.05 * std::sin(4 * p.y()), 0.04 * std::sin(5 * p.z() + 1),
              0.06 * std::cos(3 * p.x() + 2 * p.y()));
  }
}

Surface bent(Surface surface) {
  bend(surface);
  return surface;
}

// Two sheets of different widths and heights sewn along a side of 9 vertices.
Surface two_sheets() {
  const std::vector<Patch> patches{{9, 21}, {6, 9}};
  std::vector<Vec3> positions;
  std::vector<int> particles;
  for (int row = 0; row < 9; ++row) {
    for (int col = 0; col < 21; ++col) {
      particles.push_back(static_cast<int>(positions.size()));
      positions.emplace_back(0.1 * col, 0.1 * row, 0);
    }
  }
  // The second patch runs along the first one's last column, on its far side.
  for (int row = 0; row < 6; ++row) {
    for (int col = 0; col < 9; ++col) {
      if (row == 5) {
        particles.push_back(col * 21 + 20);
        continue;
      }
      particles.push_back(static_cast<int>(positions.size()));
      positions.emplace_back(2.0 + 0.1 * (5 - row), 0.1 * col, 0);
    }
  }
  return {Atlas(patches, particles), positions};
}

// One patch whose first and last column are the same particles: a cylinder sewn to itself.
Surface sewn_to_itself() {
  Surface cylinder = make_cylinder(0.5, 1, 9, 16);
  std::vector<int> particles;
  for (int row = 0; row < 9; ++row) {
    for (int col = 0; col < 17; ++col) particles.push_back(row * 16 + col % 16);
  }
  return {Atlas({{9, 17}}, particles), cylinder.positions};
}

// A patch whose last row is sewn to the middle of a longer one's first column.
Surface sheet_beside_a_wide_one() {
  const std::vector<Patch> patches{{25, 14}, {8, 10}};
  std::vector<Vec3> positions;
  std::vector<int> particles;
  for (int texel = 0; texel < 25 * 14; ++texel) {
    particles.push_back(texel);
    positions.emplace_back(0.1 * (texel % 14), 0.1 * (texel / 14), 0);
  }
  for (int row = 0; row < 8; ++row) {
    for (int col = 0; col < 10; ++col) {
      const int beside = 6 + 9 - col;
      const bool is_seam = row == 7;
      particles.push_back(is_seam ? beside * 14 : static_cast<int>(positions.size()));
      if (!is_seam) positions.emplace_back(-0.1 * (7 - row), 0.1 * beside, 0);
    }
  }
  return {Atlas(patches, particles), positions};
}

// Rings of vertices round an axis, every `patch` of which runs over some of them.
Surface sewn_rings(int rings, int around, std::vector<Patch> patches,
                   const std::function<std::array<int, 2>(int patch, int row, int col)>& place) {
  std::vector<int> particles;
  for (int patch = 0; patch < static_cast<int>(patches.size()); ++patch) {
    for (int row = 0; row < patches[patch].rows; ++row) {
      for (int col = 0; col < patches[patch].cols; ++col) {
        const auto [ring, step] = place(patch, row, col);
        particles.push_back(ring * around + step % around);
      }
    }
  }
  return {Atlas(std::move(patches), particles), make_cylinder(0.4, 1, rings, around).positions};
}

// A tube of two halves: four stretches of border, two of them between the same corners.
Surface tube_of_halves() {
  return sewn_rings(9, 20, {{9, 11}, {9, 11}}, [](int patch, int row, int col) {
    return std::array{row, 10 * patch + col};
  });
}

// Two tubes end to end, one turned against the other.
Surface turned_tubes() {
  return sewn_rings(15, 22, {{7, 22, true, false}, {9, 22, true, false}},
                    [](int patch, int row, int col) {
                      return std::array{6 * patch + row, col + 9 * patch};
                    });
}

struct NamedSurface {
  std::string name;
  Surface surface;
};

const std::vector<NamedSurface>& bodies() {
  static const std::vector<NamedSurface> all{
      {"flat rectangle", make_rectangle(1, 1, 17, 17)},
      {"rectangle", bent(make_rectangle(1, 1, 33, 33))},
      {"odd rectangle", bent(make_rectangle(1, 2, 14, 37))},
      {"ribbon", bent(make_rectangle(2, 0.1, 2, 40))},
      {"narrow ribbon", bent(make_rectangle(2, 0.1, 3, 40))},
      {"smallest", make_rectangle(1, 1, 2, 2)},
      {"cylinder", bent(make_cylinder(0.5, 1, 17, 24))},
      {"ring of three", make_cylinder(0.5, 1, 5, 3)},
      {"belt", make_cylinder(0.5, 0.1, 2, 33)},
      {"torus", bent(make_torus(1, 0.3, 40, 23))},
      {"smallest torus", make_torus(1, 0.3, 3, 3)},
      {"thin torus", make_torus(1, 0.3, 50, 5)},
      {"sphere", bent(make_sphere(0.7, 13))},
      {"blob", make_blob(0.7, 7)},
      {"two sheets", bent(two_sheets())},
      {"sewn to itself", bent(sewn_to_itself())},
      {"sheet beside a wide one", bent(sheet_beside_a_wide_one())},
      {"tube of halves", bent(tube_of_halves())},
      {"turned tubes", bent(turned_tubes())},
  };
  return all;
}

Pyramid pyramid_of(const Surface& surface) {
  Pyramid pyramid(surface.atlas, {.tangents = false, .spheres = true});
  EXPECT_FALSE(pyramid.rebuild(surface.positions));
  return pyramid;
}

// Numbers of triangles that run along an edge in either direction.
struct EdgeCount {
  int forward = 0, backward = 0;  // from the smaller number to the larger, and back
};
using EdgeCounts = std::map<std::array<int, 2>, EdgeCount>;

EdgeCounts count_edges(const std::vector<std::array<int, 3>>& triangles) {
  EdgeCounts counts;
  for (const auto& triangle : triangles) {
    for (int i = 0; i < 3; ++i) {
      const int from = triangle[i], to = triangle[(i + 1) % 3];
      EdgeCount& count = counts[{std::min(from, to), std::max(from, to)}];
      ++(from < to ? count.forward : count.backward);
    }
  }
  return counts;
}

// The border lines, each as the points that its directed edges pass, from the least one.
using Point = std::array<double, 3>;
using BorderLine = std::vector<Point>;
std::set<BorderLine> border(const std::vector<Vec3>& positions, const EdgeCounts& counts) {
  std::map<Point, Point> next;
  const auto add = [&](int from, int to) {
    const auto point = [&](int vertex) {
      const Vec3& p = positions[vertex];
      return Point{p.x(), p.y(), p.z()};
    };
    EXPECT_TRUE(next.emplace(point(from), point(to)).second);
  };
  for (const auto& [edge, count] : counts) {
    if (count.forward > count.backward) add(edge[0], edge[1]);
    if (count.forward < count.backward) add(edge[1], edge[0]);
  }
  std::set<BorderLine> lines;
  while (!next.empty()) {
    BorderLine line;
    for (auto it = next.begin(); it != next.end();) {
      line.push_back(it->first);
      const Point to = it->second;
      next.erase(it);
      it = next.find(to);
    }
    std::rotate(line.begin(), std::ranges::min_element(line), line.end());
    lines.insert(line);
  }
  return lines;
}

// True if every line of the one border passes some points of one line of the other, in their order.
bool is_sampled(const std::set<BorderLine>& samples, const std::set<BorderLine>& originals) {
  std::map<Point, std::array<std::size_t, 2>> place;  // line, index
  for (const BorderLine& line : originals) {
    const std::size_t number = std::distance(originals.begin(), originals.find(line));
    for (std::size_t i = 0; i < line.size(); ++i) place[line[i]] = {number, i};
  }
  std::set<std::size_t> met;
  for (const BorderLine& line : samples) {
    int returns = 0;
    for (std::size_t i = 0; i < line.size(); ++i) {
      const auto from = place.find(line[i]), to = place.find(line[(i + 1) % line.size()]);
      if (from == place.end() || to == place.end()) return false;
      if (from->second[0] != to->second[0]) return false;
      returns += from->second[1] >= to->second[1] ? 1 : 0;
    }
    if (returns != 1 || !met.insert(place.at(line.front())[0]).second) return false;
  }
  return met.size() == originals.size();
}

// True if the triangles around every vertex form one fan, closed or open.
bool has_one_fan_at_each_vertex(const DetailSurface& surface) {
  std::vector<std::map<int, int>> next(surface.positions.size());
  for (const auto& triangle : surface.triangles) {
    for (int i = 0; i < 3; ++i) {
      next[triangle[i]][triangle[(i + 1) % 3]] = triangle[(i + 2) % 3];
    }
  }
  return std::ranges::all_of(next, [](const std::map<int, int>& around) {
    if (around.empty()) return false;
    int start = around.begin()->first;
    // On the border, the fan starts at the neighbour without a predecessor.
    for (const auto& [from, to] : around) {
      const bool follows = std::ranges::any_of(
          around, [from = from](const auto& pair) { return pair.second == from; });
      if (!follows) start = from;
    }
    std::size_t steps = 0;
    int at = start;
    for (auto it = around.find(at); it != around.end() && steps < around.size(); ++steps) {
      at = it->second;
      it = around.find(at);
    }
    return steps == around.size();
  });
}

enum class Border { whole, sampled };

// Checks that there is no crack and no edge folded onto another, and that borders, orientation and
// topology are the original's.
void expect_sound(const Surface& original, const DetailSurface& detail, Border expected) {
  const Mesh mesh = build_mesh(original.atlas);
  const EdgeCounts counts = count_edges(detail.triangles);
  for (const auto& [edge, count] : counts) {
    ASSERT_LE(count.forward, 1);
    ASSERT_LE(count.backward, 1);
    ASSERT_NE(edge[0], edge[1]);
  }
  const auto found = border(detail.positions, counts);
  const auto whole = border(original.positions, count_edges(mesh.triangles));
  if (expected == Border::whole) {
    ASSERT_EQ(found, whole);
  } else {
    ASSERT_TRUE(is_sampled(found, whole));
  }
  const auto euler = [](std::size_t vertices, std::size_t edges, std::size_t triangles) {
    return static_cast<int>(vertices) - static_cast<int>(edges) + static_cast<int>(triangles);
  };
  ASSERT_EQ(euler(detail.positions.size(), counts.size(), detail.triangles.size()),
            euler(original.positions.size(), mesh.edges.size(), mesh.triangles.size()));
  ASSERT_TRUE(has_one_fan_at_each_vertex(detail));
}

double distance_to(const Vec3& point, const std::vector<Vec3>& positions,
                   const std::vector<std::array<int, 3>>& triangles) {
  double squared = std::numeric_limits<double>::infinity();
  for (const auto& [a, b, c] : triangles) {
    squared = std::min(
        squared,
        closest_vertex_triangle(point, positions[a], positions[b], positions[c]).squared_distance);
  }
  return std::sqrt(squared);
}

// Checks the deviation both ways, at random points of random triangles.
void expect_within_deviation(const Surface& original, const DetailSurface& detail, double bound,
                             std::mt19937& random) {
  const Mesh mesh = build_mesh(original.atlas);
  std::uniform_real_distribution<double> unit(0, 1);
  const auto sample = [&](const auto& positions, const auto& triangles) -> Vec3 {
    const auto& [a, b, c] = triangles[random() % triangles.size()];
    const double u = unit(random);
    const double v = unit(random) * (1 - u);
    return positions[a] + u * (positions[b] - positions[a]) + v * (positions[c] - positions[a]);
  };
  for (int i = 0; i < 20; ++i) {
    const Vec3 there = sample(original.positions, mesh.triangles);
    ASSERT_LE(distance_to(there, detail.positions, detail.triangles), bound + 1e-12);
    const Vec3 here = sample(detail.positions, detail.triangles);
    ASSERT_LE(distance_to(here, original.positions, mesh.triangles), bound + 1e-12);
  }
}

int deepest(const Pyramid& pyramid) {
  int levels = 0;
  for (int patch = 0; patch < pyramid.patch_count(); ++patch) {
    levels = std::max(levels, pyramid.levels(patch));
  }
  return levels;
}

TEST(LevelOfDetail, HasNoCrackAtAnyLevel) {
  std::mt19937 random(1);
  for (const auto& [name, surface] : bodies()) {
    const Pyramid pyramid = pyramid_of(surface);
    std::size_t fewer = 0;
    for (int level = 0; level <= deepest(pyramid); ++level) {
      SCOPED_TRACE(name + ", level " + std::to_string(level));
      const std::vector<int> levels(pyramid.patch_count(), level);
      const DetailSurface detail = detail_at_levels(pyramid, surface.positions, levels);
      const bool is_whole = level == deepest(pyramid);
      expect_sound(surface, detail, is_whole ? Border::whole : Border::sampled);
      EXPECT_LE(fewer, detail.triangles.size());
      fewer = detail.triangles.size();
      const double measured = deviation_at_levels(pyramid, surface.positions, levels);
      expect_within_deviation(surface, detail, detail.deviation, random);
      expect_within_deviation(surface, detail, measured, random);
    }
    EXPECT_EQ(fewer, 2U * surface.atlas.quad_count()) << name;
  }
}

// A patch keeps its corners and the centre of its block; other patches may add to its border.
TEST(LevelOfDetail, HasFourTrianglesAPatchAtTheTop) {
  const auto triangles = [](const Surface& surface, int level) {
    const Pyramid pyramid = pyramid_of(surface);
    const std::vector<int> levels(pyramid.patch_count(), level);
    return detail_at_levels(pyramid, surface.positions, levels).triangles.size();
  };
  EXPECT_EQ(triangles(make_rectangle(1, 1, 33, 33), 0), 4U);
  EXPECT_EQ(triangles(make_sphere(1, 17), 0), 6 * 4U);
  // Round each edge of the cube, two patches of one face meet four of the other.
  EXPECT_EQ(triangles(make_blob(1, 9), 0), 48 * 4 + 12 * 2U);
  EXPECT_EQ(triangles(sheet_beside_a_wide_one(), 0), 6 + 4U);
  // Both ends of the tube are kept open by a vertex between their corners.
  EXPECT_EQ(triangles(tube_of_halves(), 0), 2 * 6U);
  // Every level has fewer than half the triangles of the next, down to blocks of one patch.
  for (int level = 0; level < 4; ++level)
    EXPECT_LT(2 * triangles(make_blob(1, 33), level), triangles(make_blob(1, 33), level + 1));
}

TEST(LevelOfDetail, HasNoCrackBetweenPatchesOfDifferentLevels) {
  std::mt19937 random(2);
  for (const auto& [name, surface] : bodies()) {
    const Pyramid pyramid = pyramid_of(surface);
    for (int trial = 0; trial < 8; ++trial) {
      SCOPED_TRACE(name + ", trial " + std::to_string(trial));
      std::vector<int> levels;
      levels.reserve(pyramid.patch_count());
      for (int patch = 0; patch < pyramid.patch_count(); ++patch) {
        levels.push_back(static_cast<int>(random() % (pyramid.levels(patch) + 1)));
      }
      const DetailSurface detail = detail_at_levels(pyramid, surface.positions, levels);
      expect_sound(surface, detail, Border::sampled);
      expect_within_deviation(surface, detail, detail.deviation, random);
    }
  }
}

TEST(LevelOfDetail, StaysWithinToleranceWithoutCracks) {
  std::mt19937 random(3);
  for (const auto& [name, surface] : bodies()) {
    const Pyramid pyramid = pyramid_of(surface);
    std::size_t more = 2U * surface.atlas.quad_count() + 1;
    for (const double tolerance : {0.0, 1e-4, 1e-3, 1e-2, 1e-1, 10.0}) {
      SCOPED_TRACE(name + ", tolerance " + std::to_string(tolerance));
      const DetailSurface detail = detail_within(pyramid, surface.positions, {tolerance});
      expect_sound(surface, detail, Border::whole);
      EXPECT_LE(detail.deviation, tolerance);
      EXPECT_LE(detail.triangles.size(), more);
      more = detail.triangles.size();
      expect_within_deviation(surface, detail, detail.deviation, random);
    }
  }
}

// Returns heights over a regular grid in the x-y plane, with 0.1 m between columns and between
// rows. The centres of blocks then lie over their middles: x and y are places in the image.
Surface hills(int rows, int cols) {
  Surface surface = make_rectangle(0.1 * (cols - 1), 0.1 * (rows - 1), rows, cols);
  const Eigen::Vector2d peak(0.45 * 0.1 * cols, 0.18 * 0.1 * rows);
  for (Vec3& p : surface.positions) {
    p.z() = 0.3 * std::sin(8.9 * p.x()) * std::cos(5.3 * p.y()) +
            0.85 * std::exp(-50 * (p.head<2>() - peak).squaredNorm());
  }
  return surface;
}

// Returns the largest difference between a vertex of the hills and the triangle above or below it.
double height_error(const Surface& surface, const DetailSurface& detail) {
  const Patch& size = surface.atlas.patches()[0];
  const Eigen::Array2d first = surface.positions[0].head<2>();
  double largest = 0;
  for (const auto& triangle : detail.triangles) {
    Eigen::Matrix3d corners;  // columns (x, y, 1) in steps of the grid
    Eigen::RowVector3d heights;
    for (int i = 0; i < 3; ++i) {
      const Vec3& p = detail.positions[triangle[i]];
      corners.col(i) << ((p.head<2>().array() - first) / 0.1).matrix(), 1;
      heights[i] = p.z();
    }
    const Eigen::Matrix3d weights = corners.inverse();
    const Vec3 low = corners.rowwise().minCoeff();
    const Vec3 high = corners.rowwise().maxCoeff();
    for (int row = static_cast<int>(low.y()); row <= high.y(); ++row) {
      for (int col = static_cast<int>(low.x()); col <= high.x(); ++col) {
        const Vec3 weight = weights * Vec3(col, row, 1);
        if (weight.minCoeff() < 1e-6) continue;
        const double height = surface.positions[row * size.cols + col].z();
        largest = std::max(largest, std::abs(heights.dot(weight) - height));
      }
    }
  }
  return largest;
}

TEST(LevelOfDetail, FoldsNoTriangleOverAndKeepsTheTolerance) {
  for (const auto& [rows, cols] : {std::array{25, 13}, {14, 37}, {35, 182}, {33, 33}, {59, 7}}) {
    const Surface surface = hills(rows, cols);
    const Pyramid pyramid = pyramid_of(surface);
    const auto expect_upright = [](const DetailSurface& detail) {
      for (const auto& [a, b, c] : detail.triangles) {
        const Vec3& origin = detail.positions[a];
        const Vec3 area = (detail.positions[b] - origin).cross(detail.positions[c] - origin);
        ASSERT_GT(area.z(), 0);
      }
    };
    for (int level = 0; level <= pyramid.levels(0); ++level) {
      const DetailSurface detail = detail_at_levels(pyramid, surface.positions, std::array{level});
      expect_upright(detail);
      const double measured = deviation_at_levels(pyramid, surface.positions, std::array{level});
      EXPECT_LE(height_error(surface, detail), measured + 1e-6);  // centres are float32
    }
    for (int step = 0; step < 24; ++step) {
      const double tolerance = 1e-3 * std::pow(1.33, step);
      const DetailSurface detail = detail_within(pyramid, surface.positions, {tolerance});
      expect_upright(detail);
      EXPECT_LE(height_error(surface, detail), tolerance + 1e-6);
    }
  }
}

TEST(LevelOfDetail, IsFinerNearTheEye) {
  const Surface body = make_blob(1, 33);
  const Pyramid pyramid = pyramid_of(body);
  DetailTolerance tolerance;
  tolerance.eye = {4, 0, 0};
  tolerance.per_distance = 2e-3;
  const DetailSurface detail = detail_within(pyramid, body.positions, tolerance);
  expect_sound(body, detail, Border::whole);
  const Mesh mesh = build_mesh(body.atlas);
  std::mt19937 random(4);
  std::array<int, 2> vertices{};  // far, near
  for (const Vec3& p : detail.positions) {
    ++vertices[p.x() > 0];
    if (random() % 50 != 0) continue;
    ASSERT_LE(distance_to(p, body.positions, mesh.triangles), tolerance.at(p) * 1.01);
  }
  EXPECT_GT(vertices[1], vertices[0]);
  EXPECT_LT(2 * detail.triangles.size(), mesh.triangles.size());
}

TEST(LevelOfDetail, IsTheOriginalSurfaceWithoutTolerance) {
  for (const auto& [name, surface] : bodies()) {
    const Pyramid pyramid = pyramid_of(surface);
    const Mesh mesh = build_mesh(surface.atlas);
    const DetailSurface detail = detail_within(pyramid, surface.positions, {0});
    EXPECT_EQ(detail.deviation, 0);
    ASSERT_EQ(detail.triangles.size(), mesh.triangles.size()) << name;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      for (int i = 0; i < 3; ++i) {
        ASSERT_EQ(detail.positions[detail.triangles[t][i]],
                  surface.positions[mesh.triangles[t][i]]);
      }
    }
  }
}

}  // namespace
}  // namespace weft::bsi::level_of_detail_test
