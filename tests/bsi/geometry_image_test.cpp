#include "bsi/geometry_image.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <stdexcept>
#include <string>

namespace weft::bsi::geometry_image_test {
namespace {

int euler_characteristic(const Atlas& atlas, const Mesh& mesh) {
  return atlas.particle_count() - static_cast<int>(mesh.edges.size()) +
         static_cast<int>(mesh.triangles.size());
}

int border_edges(const Mesh& mesh) {
  return static_cast<int>(
      std::ranges::count_if(mesh.edges, [](const Edge& edge) { return edge.triangle[1] < 0; }));
}

// Checks every relation between triangles, edges and owners that the header promises.
void expect_consistent(const Atlas& atlas, const Mesh& mesh) {
  ASSERT_EQ(mesh.triangles.size(), 2 * static_cast<std::size_t>(atlas.quad_count()));
  std::vector<int> uses(mesh.edges.size(), 0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& corner = mesh.triangles[t];
    for (int e = 0; e < 3; ++e) {
      const int index = mesh.triangle_edges[t][e];
      const Edge& edge = mesh.edges[index];
      const int side = edge.triangle[0] == static_cast<int>(t) ? 0 : 1;
      ++uses[index];
      EXPECT_EQ(edge.triangle[side], static_cast<int>(t));
      EXPECT_EQ(edge.opposite[side], corner[e]);
      // The first triangle runs along the edge forwards, the second backwards.
      EXPECT_EQ(edge.vertex[side], corner[(e + 1) % 3]);
      EXPECT_EQ(edge.vertex[1 - side], corner[(e + 2) % 3]);
    }
  }
  for (std::size_t e = 0; e < mesh.edges.size(); ++e) {
    EXPECT_EQ(uses[e], mesh.edges[e].triangle[1] < 0 ? 1 : 2);
  }
  std::vector<int> vertex_owners(atlas.particle_count(), 0);
  std::vector<int> edge_owners(mesh.edges.size(), 0);
  for (int quad = 0; quad < atlas.quad_count(); ++quad) {
    const auto corners = atlas.quad_particles(quad);
    for (const int vertex : mesh.vertices_of_quad(quad)) {
      ++vertex_owners[vertex];
      EXPECT_NE(std::ranges::find(corners, vertex), corners.end());
    }
    for (const int edge : mesh.edges_of_quad(quad)) {
      ++edge_owners[edge];
      const auto& triangle = mesh.edges[edge].triangle;
      EXPECT_TRUE(triangle[0] / 2 == quad || (triangle[1] >= 0 && triangle[1] / 2 == quad));
    }
  }
  EXPECT_TRUE(std::ranges::all_of(vertex_owners, [](int n) { return n == 1; }));
  EXPECT_TRUE(std::ranges::all_of(edge_owners, [](int n) { return n == 1; }));
}

TEST(Atlas, NumbersTexelsAndQuadsPatchByPatchRowByRow) {
  const Atlas atlas({{3, 4, true, false}, {2, 5}});
  EXPECT_EQ(atlas.texel_count(), 12 + 10);
  EXPECT_EQ(atlas.particle_count(), 22);
  EXPECT_EQ(atlas.quad_count(), 2 * 4 + 1 * 4);
  EXPECT_TRUE(atlas.is_identity());
  EXPECT_EQ(atlas.quad_particles(3), (std::array{3, 0, 7, 4}));  // across the wrap
  EXPECT_EQ(atlas.quad_particles(9), (std::array{13, 14, 18, 19}));
  const TexelAddress quad = atlas.quad_address(9);
  EXPECT_EQ(std::tuple(quad.patch, quad.row, quad.col), std::tuple(1, 0, 1));
  for (int texel = 0; texel < atlas.texel_count(); ++texel) {
    const TexelAddress place = atlas.texel_address(texel);
    EXPECT_EQ(atlas.particle(place.patch, place.row, place.col), texel);
  }
}

TEST(Atlas, SharesParticlesAlongSeams) {
  // Two patches of 2 x 2, the right column of the first being the left one of the second.
  const Atlas atlas({{2, 2}, {2, 2}}, {0, 1, 2, 3, 1, 4, 3, 5});
  EXPECT_EQ(atlas.particle_count(), 6);
  EXPECT_FALSE(atlas.is_identity());
  EXPECT_EQ(atlas.quad_particles(1), (std::array{1, 4, 3, 5}));
  const TexelAddress place = atlas.particle_address(5);
  EXPECT_EQ(std::tuple(place.patch, place.row, place.col), std::tuple(1, 1, 1));
  EXPECT_EQ(atlas.particle_address(3).patch, 0);
  const Mesh mesh = build_mesh(atlas);
  expect_consistent(atlas, mesh);
  EXPECT_EQ(euler_characteristic(atlas, mesh), 1);
  EXPECT_EQ(border_edges(mesh), 6);
}

TEST(Atlas, RefusesSizesWithoutQuads) {
  EXPECT_THROW(Atlas(std::vector<Patch>{}), std::invalid_argument);
  EXPECT_THROW(Atlas({{1, 5}}), std::invalid_argument);
  EXPECT_THROW(Atlas({{5, 1}}), std::invalid_argument);
  EXPECT_THROW(Atlas({{-4, -4}}), std::invalid_argument);
  EXPECT_THROW(Atlas({{5, 2, true, false}}), std::invalid_argument);
  EXPECT_THROW(Atlas({{2, 5, false, true}}), std::invalid_argument);
  EXPECT_THROW(Atlas({{1 << 16, 1 << 16}}), std::invalid_argument);
  EXPECT_NO_THROW(Atlas({{2, 2}}));
  EXPECT_NO_THROW(Atlas({{3, 3, true, true}}));
}

TEST(Atlas, RefusesParticleMapsThatDoNotFit) {
  EXPECT_THROW(Atlas({{2, 2}}, {0, 1, 2}), std::invalid_argument);
  EXPECT_THROW(Atlas({{2, 2}}, {0, 1, 2, 4}), std::invalid_argument);
  EXPECT_THROW(Atlas({{2, 2}}, {0, 1, 2, -1}), std::invalid_argument);
  EXPECT_THROW(Atlas({{2, 3}}, {0, 1, 3, 4, 0, 1}), std::invalid_argument);
  EXPECT_NO_THROW(Atlas({{2, 2}}, {3, 2, 1, 0}));
}

TEST(Mesh, HasTheEulerCharacteristicOfItsSurface) {
  struct Case {
    Patch patch;
    int characteristic;
    int border;
  };
  for (const auto& [patch, characteristic, border] :
       {Case{{2, 2}, 1, 4}, Case{{7, 4}, 1, 18}, Case{{2, 3, true, false}, 0, 6},
        Case{{3, 2, false, true}, 0, 6}, Case{{5, 8, true, false}, 0, 16},
        Case{{3, 3, true, true}, 0, 0}, Case{{4, 9, true, true}, 0, 0}}) {
    const Atlas atlas({patch});
    const Mesh mesh = build_mesh(atlas);
    expect_consistent(atlas, mesh);
    EXPECT_EQ(euler_characteristic(atlas, mesh), characteristic);
    EXPECT_EQ(border_edges(mesh), border);
  }
}

TEST(Mesh, SplitsEveryQuadAlongTheSameDiagonal) {
  const Atlas atlas({{3, 4}});
  const Mesh mesh = build_mesh(atlas);
  for (int quad = 0; quad < atlas.quad_count(); ++quad) {
    const auto corner = atlas.quad_particles(quad);
    const Edge& diagonal = mesh.edges[mesh.triangle_edges[2 * quad][0]];
    EXPECT_EQ(diagonal.vertex, (std::array{corner[1], corner[2]}));
    EXPECT_EQ(diagonal.triangle, (std::array{2 * quad, 2 * quad + 1}));
  }
}

std::string reason_for_refusing(const Atlas& atlas) {
  try {
    build_mesh(atlas);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(Mesh, RefusesWhatIsNotAnOrientableSurface) {
  // Three patches at one edge (particles 0 and 1).
  const std::string three =
      reason_for_refusing(Atlas({{2, 2}, {2, 2}, {2, 2}}, {0, 1, 2, 3, 1, 0, 4, 5, 0, 1, 6, 7}));
  EXPECT_NE(three.find("patch 2, row 0, column 0"), std::string::npos) << three;
  // Two patches that run along their common edge the same way.
  const std::string twisted =
      reason_for_refusing(Atlas({{2, 2}, {2, 2}}, {0, 1, 2, 3, 0, 1, 4, 5}));
  EXPECT_NE(twisted.find("wrong way"), std::string::npos) << twisted;
  // A Moebius band: a strip of three quads whose last column is the first one, turned round.
  EXPECT_NE(reason_for_refusing(Atlas({{2, 4}}, {0, 1, 2, 3, 3, 4, 5, 0})), "");
  // A quad pinched to a triangle.
  const std::string pinched = reason_for_refusing(Atlas({{2, 3}}, {0, 1, 2, 0, 3, 4}));
  EXPECT_NE(pinched.find("patch 0, row 0, column 0"), std::string::npos) << pinched;
}

}  // namespace
}  // namespace weft::bsi::geometry_image_test
