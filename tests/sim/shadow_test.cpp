// Areas of shadows, against closed forms and a brute-force sum over lines.
#include "sim/probes/shadow.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "bsi/geometry_image.h"

namespace weft::sim::shadow_test {

namespace {

struct Surface {
  std::vector<Vec3> points;
  std::vector<std::array<int, 3>> triangles;

  double shadow(int axis) const { return shadow_area(points, triangles, axis); }
  double area() const { return surface_area(points, triangles); }

  void append(const Surface& other) {
    const int first = static_cast<int>(points.size());
    points.insert(points.end(), other.points.begin(), other.points.end());
    for (const auto& [a, b, c] : other.triangles)
      triangles.push_back({first + a, first + b, first + c});
  }
};

// A surface of n x n vertices whose points are place(s, t), with s and t from 0 to 1.
Surface surface_of(int n, const auto& place) {
  Surface surface;
  surface.triangles = bsi::build_mesh(bsi::Atlas({{.rows = n, .cols = n}})).triangles;
  for (int i = 0; i < n * n; ++i)
    surface.points.push_back(place(double(i % n) / (n - 1), double(i / n) / (n - 1)));
  return surface;
}

// A sheet of 2 m x 1 m, with irregular vertices inside, in the plane through `centre` that `along`
// and `across` span.
Surface sheet(int n, const Vec3& along, const Vec3& across, const Vec3& centre = Vec3::Zero()) {
  return surface_of(n, [&](double s, double t) {
    const double inside = s * (1 - s) * t * (1 - t);
    const double a = s + 0.3 * inside * std::sin(40 * t), b = t + 0.3 * inside * std::cos(30 * s);
    return Vec3(centre + 2 * (a - 0.5) * along + (b - 0.5) * across);
  });
}

TEST(Shadow, OfAFlatSheetIsItsArea) {
  const double c = std::cos(0.3), s = std::sin(0.3);
  for (const int n : {2, 9, 33}) {
    const Surface straight = sheet(n, {1, 0, 0}, {0, 1, 0});
    EXPECT_NEAR(straight.shadow(2), 2, 1e-12);
    EXPECT_EQ(straight.shadow(0), 0);
    EXPECT_EQ(straight.shadow(1), 0);
    const Surface turned = sheet(n, {c, s, 0}, {-s, c, 0}, {5, -3, 1});
    EXPECT_NEAR(turned.shadow(2), 2, 1e-12);
    EXPECT_NEAR(turned.area(), 2, 1e-12);
  }
}

TEST(Shadow, OfATiltedSheetIsItsAreaTimesTheCosine) {
  const double angle = 0.7;
  const Surface tilted = sheet(17, {1, 0, 0}, {0, std::cos(angle), std::sin(angle)});
  EXPECT_NEAR(tilted.shadow(2), 2 * std::cos(angle), 1e-12);
  EXPECT_NEAR(tilted.shadow(1), 2 * std::sin(angle), 1e-12);
  EXPECT_NEAR(tilted.shadow(0), 0, 1e-12);
  EXPECT_NEAR(tilted.area(), 2, 1e-12);
}

TEST(Shadow, CountsLayersOnce) {
  // Folded along the middle of its length, with the upper half turned by 0.4 about the end of the
  // fold: the halves are squares of 1 m with one corner in common.
  const double turn = 0.4;
  Surface folded = surface_of(21, [&](double s, double t) {
    const double x = 2 * s - 1;
    if (x <= 0) return Vec3(-x, t, 0);
    return Vec3(x * std::cos(turn) - t * std::sin(turn), x * std::sin(turn) + t * std::cos(turn),
                0.1);
  });
  // The triangles between the two halves would cover more.
  std::erase_if(folded.triangles, [&](const auto& triangle) {
    return std::ranges::any_of(triangle, [&](int a) { return a % 21 == 10; }) &&
           std::ranges::any_of(triangle, [&](int a) { return a % 21 == 11; });
  });
  // The upper half now starts at x = 0.1 in its own frame; both are kites cut from squares.
  const double tangent = std::tan(turn);
  // Upper half: 0.1 <= x' <= 1, 0 <= y' <= 1. Its part outside of the lower square is what the
  // sum over lines says.
  double outside = 0;
  const int lines = 400000;
  for (int i = 0; i < lines; ++i) {
    // Line of constant x' in the frame of the upper half.
    const double x = 0.1 + 0.9 * (i + 0.5) / lines;
    // Inside the lower square: x cos - y sin in [0, 1] and x sin + y cos in [0, 1].
    const double low = std::max({0.0, (x * std::cos(turn) - 1) / std::sin(turn), -x * tangent});
    const double high = std::min({1.0, x / tangent, (1 - x * std::sin(turn)) / std::cos(turn)});
    outside += (1 - std::max(0.0, high - low)) * 0.9 / lines;
  }
  EXPECT_NEAR(folded.shadow(2), 1 + outside, 1e-7);
}

TEST(Shadow, OfAFoldedSheetIsThatOfItsLargerPart) {
  const double angle = 0.5;
  // 2 m folded across at 1.2 m; the rest comes back over it at an angle.
  const Surface folded = surface_of(21, [&](double s, double t) {
    const double x = 2 * s, back = x - 1.2;
    return back <= 0 ? Vec3(x, t, 0)
                     : Vec3(1.2 - back * std::cos(angle), t, back * std::sin(angle));
  });
  EXPECT_NEAR(folded.shadow(2), 1.2, 1e-12);
  EXPECT_NEAR(folded.shadow(0), 0.8 * std::sin(angle), 1e-12);
  EXPECT_NEAR(folded.area(), 2, 1e-12);
}

TEST(Shadow, OfSheetsThatCrossIsTheirUnion) {
  Surface cross = sheet(9, {1, 0, 0}, {0, 0.1, 0});
  cross.append(sheet(9, {0, 1, 0}, {0.1, 0, 0}, {0, 0, 1}));
  EXPECT_NEAR(cross.shadow(2), 2 * 0.2 - 0.01, 1e-12);
  const double c = std::sqrt(0.5);
  Surface oblique = sheet(9, {1, 0, 0}, {0, 0.1, 0});
  oblique.append(sheet(9, {c, c, 0}, {-0.1 * c, 0.1 * c, 0}));
  // Strips of width w that cross at an angle share a parallelogram of area w^2 / sin(angle).
  EXPECT_NEAR(oblique.shadow(2), 2 * 0.2 - 0.01 / c, 1e-12);
}

TEST(Shadow, OfASphereIsThatOfItsEquator) {
  const int cols = 48, rows = 25;
  Surface sphere;
  sphere.triangles =
      bsi::build_mesh(bsi::Atlas({{.rows = rows, .cols = cols, .wrap_u = true}})).triangles;
  for (int i = 0; i < rows * cols; ++i) {
    const double latitude = std::numbers::pi * ((i / cols + 0.0) / (rows - 1) - 0.5);
    const double longitude = 2 * std::numbers::pi * (i % cols) / cols;
    sphere.points.emplace_back(std::cos(latitude) * std::cos(longitude),
                               std::cos(latitude) * std::sin(longitude), std::sin(latitude));
  }
  const double polygon = 0.5 * cols * std::sin(2 * std::numbers::pi / cols);
  EXPECT_NEAR(sphere.shadow(2), polygon, 1e-12);
  EXPECT_NEAR(sphere.shadow(0), std::numbers::pi, 0.02);
}

// Sums the lengths of many lines within the triangles.
double sum_over_lines(const Surface& surface, int lines) {
  double sum = 0;
  for (int i = 0; i < lines; ++i) {
    const double x = (i + 0.5) / lines;
    std::vector<std::array<double, 2>> chords;
    for (const std::array<int, 3>& triangle : surface.triangles) {
      std::vector<double> cuts;
      for (int k = 0; k < 3; ++k) {
        const Vec3 &a = surface.points[triangle[k]], &b = surface.points[triangle[(k + 1) % 3]];
        if ((a[0] < x) != (b[0] < x))
          cuts.push_back(a[1] + (b[1] - a[1]) * (x - a[0]) / (b[0] - a[0]));
      }
      if (cuts.size() == 2)
        chords.push_back({std::min(cuts[0], cuts[1]), std::max(cuts[0], cuts[1])});
    }
    std::ranges::sort(chords);
    double reached = -1;
    for (const auto& [low, high] : chords) {
      if (high > reached) sum += (high - std::max(low, reached)) / lines;
      reached = std::max(reached, high);
    }
  }
  return sum;
}

TEST(Shadow, OfRandomTrianglesAgreesWithASumOverLines) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> number(0, 1);
  for (int trial = 0; trial < 20; ++trial) {
    Surface heap;
    for (int i = 0; i < 12; ++i) {
      const Vec3 centre(number(random), number(random), 0);
      for (int k = 0; k < 3; ++k) {
        const Vec3 corner(number(random), number(random), number(random));
        heap.points.emplace_back(0.6 * centre + 0.4 * corner);
      }
      heap.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    EXPECT_NEAR(heap.shadow(2), sum_over_lines(heap, 40000), 2e-7);
  }
}

}  // namespace

}  // namespace weft::sim::shadow_test
