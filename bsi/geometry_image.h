// Geometry images: surfaces stored as rectangular images of vertices, and their triangles.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <string>
#include <vector>

namespace weft::bsi {

using Vec3 = Eigen::Vector3d;

// A rectangular image of `rows` x `cols` vertices, row-major: u counts columns, v counts rows. A
// wrapped axis is closed: its last vertex is adjacent to its first, and neither is stored twice.
struct Patch {
  int rows = 0;
  int cols = 0;
  bool wrap_u = false;
  bool wrap_v = false;

  int texel_count() const { return rows * cols; }
  int quad_rows() const { return wrap_v ? rows : rows - 1; }
  int quad_cols() const { return wrap_u ? cols : cols - 1; }
  int quad_count() const { return quad_rows() * quad_cols(); }
};

// Location of a texel or a quad in an atlas.
struct TexelAddress {
  int patch = 0;
  int row = 0;
  int col = 0;
};

// One or more patches sewn into a surface. Texels and quads are numbered patch by patch, row by
// row. Texels at the same point of a seam share one particle, so a sewn body cannot come apart.
// Immutable.
class Atlas {
 public:
  Atlas() = default;
  // `texel_to_particle` holds the particle of each texel and uses every index from 0 to its
  // maximum. If it is empty, texel i is particle i. Throws std::invalid_argument, with the reason,
  // if the map breaks these rules or a patch has no quad. An open axis needs at least 2 vertices, a
  // wrapped one 3.
  explicit Atlas(std::vector<Patch> patches, std::vector<int> texel_to_particle = {});

  const std::vector<Patch>& patches() const { return patches_; }
  int texel_count() const { return first_texel_.back(); }
  int particle_count() const { return particle_count_; }
  int quad_count() const { return first_quad_.back(); }
  int first_texel(int patch) const { return first_texel_[patch]; }
  int first_quad(int patch) const { return first_quad_[patch]; }
  // Returns true if texel i is particle i for every texel. Arrays by particle are then also arrays
  // by texel.
  bool is_identity() const { return texel_to_particle_.empty(); }

  // Returns the particle of each texel; empty if is_identity().
  std::span<const int> texel_to_particle() const { return texel_to_particle_; }
  int particle_of_texel(int texel) const {
    return texel_to_particle_.empty() ? texel : texel_to_particle_[texel];
  }
  // Returns the particle at (row, col) of a patch. On a wrapped axis, row == rows or col == cols
  // stands for 0.
  int particle(int patch, int row, int col) const {
    const Patch& p = patches_[patch];
    if (row >= p.rows) row -= p.rows;
    if (col >= p.cols) col -= p.cols;
    return particle_of_texel(first_texel_[patch] + row * p.cols + col);
  }
  // Returns the particles at the corners of a quad: (r,c), (r,c+1), (r+1,c), (r+1,c+1).
  std::array<int, 4> quad_particles(int quad) const;
  TexelAddress quad_address(int quad) const;
  TexelAddress texel_address(int texel) const;
  // Returns the first texel of a particle. O(texels) on a sewn atlas: meant for messages.
  TexelAddress particle_address(int particle) const;

 private:
  std::vector<Patch> patches_;
  std::vector<int> texel_to_particle_;
  std::vector<int> first_texel_{0};
  std::vector<int> first_quad_{0};
  int particle_count_ = 0;
};

// Splits a quad into its two triangles. Physics, collision and pictures all use this rule. `corner`
// is in the order of quad_particles(). The diagonal runs from (r,c+1) to (r+1,c) in every quad,
// because a uniform diagonal keeps the bending model free of bias. Both triangles are
// counter-clockwise when seen from the side to which u x v points.
inline std::array<std::array<int, 3>, 2> quad_triangles(const std::array<int, 4>& corner) {
  return {{{corner[0], corner[1], corner[2]}, {corner[1], corner[3], corner[2]}}};
}

// An edge and the one or two triangles that share it.
struct Edge {
  std::array<int, 2> vertex{};          // particle indices, in the direction of the first triangle
  std::array<int, 2> triangle{-1, -1};  // triangle indices; second is -1 on the border
  std::array<int, 2> opposite{-1, -1};  // the corner of each triangle that is not on the edge
};

// Triangles, edges and their owners, in particle indices. Triangle t belongs to quad t / 2. Edge
// triangle_edges[t][e] is opposite corner e of triangle t. The first quad that contains a particle
// or an edge owns it. A search over pairs of quads that combines only owned features therefore
// finds each pair of features once. Edges are numbered in the order of their owners.
struct Mesh {
  std::vector<std::array<int, 3>> triangles;
  std::vector<std::array<int, 3>> triangle_edges;
  std::vector<Edge> edges;
  std::vector<int> owned_vertex_start, owned_vertices;  // compressed rows, one per quad
  std::vector<int> owned_edge_start, owned_edges;       // compressed rows, one per quad

  std::span<const int> vertices_of_quad(int quad) const {
    return std::span(owned_vertices)
        .subspan(owned_vertex_start[quad], owned_vertex_start[quad + 1] - owned_vertex_start[quad]);
  }
  std::span<const int> edges_of_quad(int quad) const {
    return std::span(owned_edges)
        .subspan(owned_edge_start[quad], owned_edge_start[quad + 1] - owned_edge_start[quad]);
  }
};

// Builds the mesh of an atlas. O(texels). Throws std::invalid_argument, naming a quad, if the image
// is not an orientable surface. An edge may have at most two triangles, which traverse it in
// opposite directions. A triangle must not use a particle twice.
Mesh build_mesh(const Atlas& atlas);

}  // namespace weft::bsi
