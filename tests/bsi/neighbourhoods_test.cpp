// Neighbourhoods at rest: against distances in the plane, the unrolled cylinder, and folds whose
// layers come close to each other.
#include "bsi/detail/neighbourhoods.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "bsi/proximity.h"
#include "bsi/shapes.h"

namespace weft::bsi::neighbourhoods_test {
namespace {

struct Rest {
  Atlas atlas;
  std::vector<Vec3> x;
  Mesh mesh;
};

// Returns a sheet of rows x cols vertices. place(u, v) takes u, v from 0 to 1 to positions.
Rest sheet(int rows, int cols, const std::function<Vec3(double, double)>& place) {
  Rest rest{Atlas({Patch{.rows = rows, .cols = cols}}), {}, {}};
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < cols; ++c) rest.x.push_back(place(c / (cols - 1.0), r / (rows - 1.0)));
  rest.mesh = build_mesh(rest.atlas);
  return rest;
}

// Returns a flat sheet of 1 m whose inner vertices are moved at random.
Rest uneven_sheet(int size, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> shift(-0.3 / (size - 1), 0.3 / (size - 1));
  return sheet(size, size, [&](double u, double v) {
    const bool inner = u > 0 && v > 0 && u < 1 && v < 1;
    const double x = shift(random), y = shift(random);
    return inner ? Vec3(u + x, v + y, 0) : Vec3(u, v, 0);
  });
}

double distance(const Rest& rest, const std::vector<Vec3>& x, int vertex, int triangle) {
  const auto& [a, b, c] = rest.mesh.triangles[triangle];
  return std::sqrt(closest_vertex_triangle(x[vertex], x[a], x[b], x[c]).squared_distance);
}

bool holds(const Rest& rest, int triangle, int vertex) {
  return std::ranges::find(rest.mesh.triangles[triangle], vertex) !=
         rest.mesh.triangles[triangle].end();
}

TEST(Neighbourhoods, OfAFlatSheetAreDiscs) {
  const Rest rest = uneven_sheet(17, 3);
  for (const double radius : {0.08, 0.2, 0.35}) {
    const Neighbourhoods near(rest.mesh, rest.x, radius, 2);
    ASSERT_FALSE(near.are_rings());
    for (int v = 0; v < static_cast<int>(rest.x.size()); v += 3) {
      for (int t = 0; t < static_cast<int>(rest.mesh.triangles.size()); ++t)
        EXPECT_EQ(near.contains(v, t), distance(rest, rest.x, v, t) < radius) << v << " " << t;
    }
  }
}

TEST(Neighbourhoods, OfASmallRadiusAreRings) {
  const Rest rest = sheet(9, 9, [](double u, double v) { return Vec3(u, v, 0); });
  // The diagonal of a square of 1/8 is the nearest edge without the vertex.
  EXPECT_TRUE(Neighbourhoods(rest.mesh, rest.x, 0.7 / 8).are_rings());
  EXPECT_FALSE(Neighbourhoods(rest.mesh, rest.x, 0.71 / 8).are_rings());
}

// Half a cylinder: every triangle with a vertex nearer than the radius along the surface belongs to
// the neighbourhood, and none whose points are all farther away than the ball allows.
TEST(Neighbourhoods, HoldAllWithinTheGeodesicDistance) {
  constexpr double curvature_radius = 0.2, radius = 0.31;  // no multiple of an edge
  const auto flat = [](double u, double v) {
    return Vec3(std::numbers::pi * curvature_radius * u, 0.6 * v, 0);
  };
  const Rest rolled = sheet(25, 25, [&](double u, double v) {
    const double angle = flat(u, v).x() / curvature_radius;
    return Vec3(curvature_radius * std::cos(angle), flat(u, v).y(),
                curvature_radius * std::sin(angle));
  });
  const Rest unrolled = sheet(25, 25, flat);
  const Neighbourhoods near(rolled.mesh, rolled.x, radius);
  for (int v = 0; v < static_cast<int>(rolled.x.size()); v += 5) {
    for (int t = 0; t < static_cast<int>(rolled.mesh.triangles.size()); ++t) {
      if (distance(unrolled, unrolled.x, v, t) < radius) {
        EXPECT_TRUE(near.contains(v, t));
      }
      if (distance(rolled, rolled.x, v, t) > radius && !holds(rolled, t, v)) {
        EXPECT_FALSE(near.contains(v, t));
      }
    }
  }
}

// A strip of two layers 0.1 m apart, joined at x = 1: the radius exceeds the distance of the
// layers, but only near the fold are they connected within it.
TEST(Neighbourhoods, LayersAreNeighboursOnlyNearTheirFold) {
  const Rest rest = sheet(4, 82, [](double u, double v) {
    const double s = 2.1 * u;
    if (s <= 1) return Vec3(s, 0.3 * v, 0);
    return s <= 1.1 ? Vec3(1, 0.3 * v, s - 1) : Vec3(2.1 - s, 0.3 * v, 0.1);
  });
  const Neighbourhoods near(rest.mesh, rest.x, 0.15);
  int joined = 0, apart = 0;
  for (int v = 0; v < static_cast<int>(rest.x.size()); ++v) {
    for (int t = 0; t < static_cast<int>(rest.mesh.triangles.size()); ++t) {
      const double d = distance(rest, rest.x, v, t);
      const bool other_layer =
          std::abs(rest.x[v].z() - rest.x[rest.mesh.triangles[t][0]].z()) > 0.09;
      if (!other_layer || d >= 0.15) continue;
      // The ball of 0.15 m around a point at z = 0 reaches sqrt(0.15^2 - 0.1^2) = 0.112 m along the
      // other layer, and touches the fold if the point is within 0.15 m of it.
      if (rest.x[v].x() < 0.8) {
        EXPECT_FALSE(near.contains(v, t));
        ++apart;
      } else {
        joined += near.contains(v, t) ? 1 : 0;
      }
    }
  }
  EXPECT_GT(apart, 100);
  EXPECT_GT(joined, 10);
}

TEST(Neighbourhoods, AnswerForQuadsVerticesAndEdges) {
  const Rest rest = uneven_sheet(13, 5);
  const Neighbourhoods near(rest.mesh, rest.x, 0.19);
  const int triangles = static_cast<int>(rest.mesh.triangles.size());
  for (int v = 0; v < static_cast<int>(rest.x.size()); v += 4) {
    for (int q = 0; 2 * q < triangles; ++q)
      EXPECT_EQ(near.contains_quad(v, q), near.contains(v, 2 * q) && near.contains(v, 2 * q + 1));
    for (int other = 0; other < static_cast<int>(rest.x.size()); ++other) {
      bool touches = false;
      for (int t = 0; t < triangles; ++t) touches |= holds(rest, t, other) && near.contains(v, t);
      EXPECT_EQ(near.touches(v, other), touches);
    }
  }
}

// Neighbourhoods made from the triangles of others are the same, and rings are listed, too.
TEST(Neighbourhoods, AreKeptByTheirTriangles) {
  const Rest rest = uneven_sheet(13, 5);
  const int vertices = static_cast<int>(rest.x.size());
  for (const double radius : {0.01, 0.19}) {
    const Neighbourhoods near(rest.mesh, rest.x, radius);
    std::vector<std::vector<int>> triangles;
    for (int v = 0; v < vertices; ++v) triangles.push_back(near.triangles(v));
    const Neighbourhoods listed(rest.mesh, vertices, triangles);
    for (int v = 0; v < vertices; ++v) {
      EXPECT_EQ(listed.triangles(v), triangles[v]) << v;
      for (int t = 0; t < static_cast<int>(rest.mesh.triangles.size()); ++t)
        EXPECT_EQ(listed.contains(v, t),
                  near.are_rings() ? holds(rest, t, v) : near.contains(v, t));
    }
  }
}

// Edges that are no neighbours are farther apart than the radius; neighbours are not much farther.
TEST(Neighbourhoods, EdgesBeyondTheRadiusAreNoNeighbours) {
  const Rest rest = uneven_sheet(9, 7);
  constexpr double radius = 0.2;
  const Neighbourhoods near(rest.mesh, rest.x, radius);
  int neighbours = 0, others = 0;
  for (const Edge& e : rest.mesh.edges) {
    for (const Edge& f : rest.mesh.edges) {
      const auto [a, b] = e.vertex;
      const auto [c, d] = f.vertex;
      if (a == c || a == d || b == c || b == d) continue;
      const double apart =
          std::sqrt(closest_edge_edge(rest.x[a], rest.x[b], rest.x[c], rest.x[d]).squared_distance);
      if (near.are_neighbours(e, f)) {
        // Both triangles of the edge come within the radius, and none is wider than 0.3 m.
        EXPECT_LT(apart, radius + 0.3);
        ++neighbours;
      } else {
        EXPECT_GE(apart, radius * (1 - 1e-8));
        ++others;
      }
    }
  }
  EXPECT_GT(neighbours, 100);
  EXPECT_GT(others, 100);
}

// A torus wraps on both axes, and the six patches of a sphere are sewn: neighbourhoods pass over
// the seams.
TEST(Neighbourhoods, PassOverSeams) {
  for (const Surface& surface : {make_torus(0.5, 0.2, 24, 12), make_sphere(0.4, 9)}) {
    const Mesh mesh = build_mesh(surface.atlas);
    const Rest rest{surface.atlas, surface.positions, mesh};
    constexpr double radius = 0.12;
    const Neighbourhoods near(mesh, surface.positions, radius);
    for (int v = 0; v < static_cast<int>(surface.positions.size()); ++v) {
      for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t) {
        EXPECT_EQ(near.contains(v, t), holds(rest, t, v) || distance(rest, rest.x, v, t) < radius);
      }
    }
  }
}

TEST(Neighbourhoods, DoNotDependOnTheNumberOfThreads) {
  const Rest rest = uneven_sheet(33, 9);
  const Neighbourhoods one(rest.mesh, rest.x, 0.1, 1), four(rest.mesh, rest.x, 0.1, 4);
  for (int v = 0; v < static_cast<int>(rest.x.size()); v += 7) {
    for (int t = 0; t < static_cast<int>(rest.mesh.triangles.size()); ++t)
      EXPECT_EQ(one.contains(v, t), four.contains(v, t));
  }
}

}  // namespace
}  // namespace weft::bsi::neighbourhoods_test
