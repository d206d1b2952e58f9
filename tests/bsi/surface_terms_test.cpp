// The signed sum over a surface, against the same sum written out feature by feature, and against
// known values on planes, ridges, valleys and spheres.
#include "bsi/detail/surface_terms.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>
#include <random>

#include "bsi/shapes.h"

namespace weft::bsi::surface_terms_test {
namespace {

constexpr double reach = 0.03;
// A function that falls with the distance like the push of a contact: (r - d) (2 ln(r / d) + r / d
// - 1).
double falling(double distance) {
  const double ratio = reach / distance;
  return ratio > 1 ? (reach - distance) * (2 * std::log(ratio) + ratio - 1) : 0;
}

struct MeshedSurface {
  Atlas atlas;
  std::vector<Vec3> x;
  Mesh mesh;
  std::unique_ptr<const Neighbourhoods> neighbourhoods;
  SurfaceTerms terms;
  // With a radius (m), triangles within it of a vertex on `rest` are its neighbours.
  MeshedSurface(Atlas atlas_, std::vector<Vec3> positions, const std::vector<Vec3>& rest = {},
                double radius = 0)
      : atlas(std::move(atlas_)),
        x(std::move(positions)),
        mesh(build_mesh(atlas)),
        neighbourhoods(radius > 0 ? std::make_unique<const Neighbourhoods>(mesh, rest, radius)
                                  : nullptr),
        terms(mesh, static_cast<int>(x.size()), neighbourhoods.get()) {}
  bool leaves_out(int triangle, int own) const {
    const auto& [a, b, c] = mesh.triangles[triangle];
    if (a == own || b == own || c == own) return true;
    return own >= 0 && neighbourhoods != nullptr && neighbourhoods->contains(own, triangle);
  }
  MeshedSurface(const MeshedSurface&) = delete;
  MeshedSurface& operator=(const MeshedSurface&) = delete;
};

// Returns a sheet of 1 m in the plane z = 0, with inner vertices moved at random within the plane,
// bent by `height` as a function of x and y.
MeshedSurface sheet(int size, unsigned seed, const std::function<double(double, double)>& height) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> shift(-0.3, 0.3);
  std::vector<Vec3> x;
  for (int r = 0; r < size; ++r) {
    for (int c = 0; c < size; ++c) {
      const bool inner = r > 0 && c > 0 && r < size - 1 && c < size - 1;
      const double u = (c + (inner ? shift(random) : 0)) / (size - 1.0);
      const double v = (r + (inner ? shift(random) : 0)) / (size - 1.0);
      x.emplace_back(u, v, height(u, v));
    }
  }
  return {Atlas({Patch{.rows = size, .cols = size}}), x};
}

std::vector<int> triangles_within(const MeshedSurface& surface, const Vec3& point, int own) {
  std::vector<int> found;
  for (int t = 0; t < static_cast<int>(surface.mesh.triangles.size()); ++t) {
    const auto& [a, b, c] = surface.mesh.triangles[t];
    if (surface.leaves_out(t, own)) continue;
    const double d2 =
        closest_vertex_triangle(point, surface.x[a], surface.x[b], surface.x[c]).squared_distance;
    if (d2 <= reach * reach) found.push_back(t);
  }
  return found;
}

double sum_of_terms(const MeshedSurface& surface, const Vec3& point, int own = -1,
                    std::size_t* count = nullptr) {
  std::vector<SurfaceTerm> terms;
  surface.terms.find(point, own, triangles_within(surface, point, own), surface.x, reach, terms);
  if (count != nullptr) *count = terms.size();
  double sum = 0;
  for (const SurfaceTerm& term : terms) {
    EXPECT_NE(term.coefficient, 0);
    sum += term.coefficient * falling(std::sqrt(term.closest.squared_distance));
  }
  return sum;
}

// Returns the sum over faces, minus inner edges, plus inner vertices, each by its own distance. It
// leaves out the triangles around `own`, with the edges and vertices that only they make inner.
double sum_by_feature(const MeshedSurface& surface, const Vec3& point, int own = -1) {
  const Mesh& mesh = surface.mesh;
  const auto distance = [&](int a, int b, int c) {
    return std::sqrt(
        closest_vertex_triangle(point, surface.x[a], surface.x[b], surface.x[c]).squared_distance);
  };
  double sum = 0;
  std::vector<char> border(surface.x.size(), 0);
  const auto holds = [&](int t) { return surface.leaves_out(t, own); };
  for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    if (!holds(t)) sum += falling(distance(a, b, c));
    if (!holds(t)) continue;
    for (int v : mesh.triangles[t]) border[v] = 1;
  }
  for (const Edge& edge : mesh.edges) {
    const auto [a, b] = edge.vertex;
    const bool inner =
        edge.triangle[1] >= 0 && !holds(edge.triangle[0]) && !holds(edge.triangle[1]);
    if (inner) sum -= falling(distance(a, b, b));
    if (edge.triangle[1] < 0) border[a] = border[b] = 1;
  }
  for (std::size_t v = 0; v < surface.x.size(); ++v) {
    if (border[v] == 0) sum += falling((point - surface.x[v]).norm());
  }
  return sum;
}

TEST(SurfaceTerms, AddUpToFacesLessInnerEdgesPlusInnerVertices) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(-0.02, 1.02), above(-0.025, 0.025);
  const auto bumps = [](double u, double v) { return 0.02 * std::sin(40 * u) * std::cos(30 * v); };
  for (int size : {5, 33, 97}) {
    const MeshedSurface surface = sheet(size, 2, bumps);
    for (int trial = 0; trial < 100; ++trial) {
      const double u = place(random), v = place(random);
      const Vec3 point(u, v, bumps(u, v) + above(random));
      const double expected = sum_by_feature(surface, point);
      ASSERT_NEAR(sum_of_terms(surface, point), expected, 1e-9 * std::abs(expected) + 1e-15)
          << size << " " << trial;
    }
  }
}

TEST(SurfaceTerms, LeaveOutWhatIsAroundTheirOwnVertex) {
  const auto crumpled = [](double u, double v) { return 0.05 * std::sin(70 * u + 50 * v); };
  const MeshedSurface surface = sheet(65, 3, crumpled);
  int in_reach = 0;
  for (int own = 0; own < 65 * 65; own += 17) {
    const double expected = sum_by_feature(surface, surface.x[own], own);
    ASSERT_NEAR(sum_of_terms(surface, surface.x[own], own), expected,
                1e-9 * std::abs(expected) + 1e-15);
    in_reach += expected != 0;
  }
  EXPECT_GT(in_reach, 20);
}

TEST(SurfaceTerms, LeaveOutTheNeighbourhoodOfTheirOwnVertex) {
  std::vector<Vec3> rest, crumpled;
  for (int r = 0; r < 65; ++r) {
    for (int c = 0; c < 65; ++c) {
      const double u = c / 64.0, v = r / 64.0;
      rest.emplace_back(u, v, 0);
      crumpled.emplace_back(0.4 * u, v, 0.05 * std::sin(70 * u + 20 * v));
    }
  }
  const MeshedSurface surface(Atlas({Patch{.rows = 65, .cols = 65}}), crumpled, rest, 0.045);
  int in_reach = 0;
  for (int own = 0; own < 65 * 65; own += 13) {
    const double expected = sum_by_feature(surface, surface.x[own], own);
    ASSERT_NEAR(sum_of_terms(surface, surface.x[own], own), expected,
                1e-9 * std::abs(expected) + 1e-15);
    in_reach += expected != 0;
  }
  EXPECT_GT(in_reach, 20);
}

// Layers of one folded sheet count once, however fine the mesh between the neighbourhoods is.
TEST(SurfaceTerms, ALayerOfTheOwnSurfaceCountsOnce) {
  for (const int size : {17, 65, 129}) {
    std::vector<Vec3> rest, folded;
    for (int r = 0; r < size; ++r) {
      for (int c = 0; c < size; ++c) {
        const double u = c / (size - 1.0), v = r / (size - 1.0);
        rest.emplace_back(u, v, 0);
        folded.emplace_back(u < 0.5 ? u : 1 - u, v + (u < 0.5 ? 0 : 0.003), u < 0.5 ? 0 : 0.02);
      }
    }
    const MeshedSurface surface(Atlas({Patch{.rows = size, .cols = size}}), folded, rest, 0.05);
    for (int r = size / 4; r < 3 * size / 4; r += 3) {
      const int own = r * size + size / 4;  // at u = 1/4, below the layer of u = 3/4
      EXPECT_NEAR(sum_of_terms(surface, surface.x[own], own), falling(0.02), 1e-9) << size;
    }
  }
}

TEST(SurfaceTerms, APlaneCountsOnceWhateverItsTriangles) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> place(0.1, 0.9), above(0.001, 0.029);
  const auto flat = [](double, double) { return 0.0; };
  for (int size : {3, 5, 33, 97}) {
    const MeshedSurface surface = sheet(size, 5, flat);
    for (int trial = 0; trial < 200; ++trial) {
      const double height = above(random);
      std::size_t terms = 0;
      const double sum = sum_of_terms(surface, {place(random), place(random), height}, -1, &terms);
      ASSERT_NEAR(sum, falling(height), 1e-12 * falling(height) + 1e-18);
      ASSERT_EQ(terms, 1U);
    }
  }
}

// Above a convex ridge one term remains. In a valley the two faces minus their edge remain; their
// sum is more than the nearer face alone and less than both.
TEST(SurfaceTerms, RidgesAndValleys) {
  const auto ridge = [](double u, double) { return -std::abs(u - 0.5); };
  const auto valley = [](double u, double) { return std::abs(u - 0.5); };
  MeshedSurface convex = sheet(3, 6, ridge), concave = sheet(3, 6, valley);
  for (MeshedSurface* surface : {&convex, &concave}) {
    for (int r = 0; r < 3; ++r) surface->x[3 * r + 1] = Vec3(0.5, 0.5 * r, 0);
  }
  std::size_t terms = 0;
  EXPECT_NEAR(sum_of_terms(convex, {0.5, 0.3, 0.02}, -1, &terms), falling(0.02), 1e-12);
  EXPECT_EQ(terms, 1U);
  const double face = falling(0.02 * std::sqrt(0.5)), edge = falling(0.02);
  EXPECT_NEAR(sum_of_terms(concave, {0.5, 0.3, 0.02}, -1, &terms), 2 * face - edge, 1e-12);
  EXPECT_EQ(terms, 3U);
}

// A point near a sphere, at 1/15 of its radius: the sum is that of one term at the distance of the
// mesh. Inside a coarse mesh, this distance is much less than that of the sphere.
TEST(SurfaceTerms, ASphereCountsOnce) {
  struct Sphere {
    int resolution;
    double side, least, most;
  };
  for (const Sphere& sphere : {Sphere{9, 1, 0.8, 1.3}, Sphere{9, -1, 0.8, 1.3},
                               Sphere{49, 1, 0.98, 1.02}, Sphere{49, -1, 0.98, 1.02}}) {
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    const double height = reach / 4, radius = 15 * height;
    Surface shape = make_sphere(radius, sphere.resolution);
    const MeshedSurface surface(std::move(shape.atlas), std::move(shape.positions));
    for (int trial = 0; trial < 300; ++trial) {
      const Vec3 direction = Vec3(normal(random), normal(random), normal(random)).normalized();
      const Vec3 point = (radius + sphere.side * height) * direction;
      const double ratio = sum_of_terms(surface, point) / falling(height);
      ASSERT_GT(ratio, sphere.least) << sphere.resolution << " " << sphere.side;
      ASSERT_LT(ratio, sphere.most) << sphere.resolution << " " << sphere.side;
    }
  }
}

// Along the point's whole path, changes of the slope shrink with the step; at a kink they would
// not.
TEST(SurfaceTerms, TheSumIsSmooth) {
  const auto bumps = [](double u, double v) { return 0.02 * std::sin(40 * u) * std::cos(30 * v); };
  const MeshedSurface surface = sheet(65, 8, bumps);
  const auto largest_change_of_slope = [&](double step) {
    double last = 0, last_slope = 0, largest = 0;
    for (int i = 0; i * step < 0.02; ++i) {
      const double u = 0.3 + step * i, v = 0.4 + 0.7 * step * i;
      const double sum = sum_of_terms(surface, {u, v, bumps(u, v) + 0.015});
      const double slope = (sum - last) / step;
      if (i > 1) largest = std::max(largest, std::abs(slope - last_slope));
      last = sum;
      last_slope = slope;
    }
    return largest;
  };
  EXPECT_LT(largest_change_of_slope(1e-5), 0.3 * largest_change_of_slope(4e-5));
}

}  // namespace
}  // namespace weft::bsi::surface_terms_test
