// Geometry images: surfaces stored as rectangular images of vertices, and their triangles.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <string>
#include <vector>

namespace weft::bsi {

using Vec3 = Eigen::Vector3d;

// A rectangular image of `rows` x `cols` vertices, stored row by row: u counts columns, v counts
// rows. A wrapped axis is closed: its last vertex is adjacent to its first, and neither is stored
// twice.
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

// The position of a texel or a quad in an atlas.
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
  // Makes an atlas without patches, to which another atlas can be assigned.
  Atlas() = default;
  // `texel_to_particle` holds the particle of each texel and uses every index from 0 to its
  // maximum. If it is empty, texel i is particle i. An open axis needs at least 2 vertices, a
  // wrapped axis 3. Throws std::invalid_argument, with the reason, if a rule is broken, if there is
  // no patch, or if there are more than INT_MAX / 6 texels.
  explicit Atlas(std::vector<Patch> patches, std::vector<int> texel_to_particle = {});
  // Returns an atlas of separate points: one row of `count` texels, without quads. Throws
  // std::invalid_argument if `count` is not positive or exceeds INT_MAX / 6.
  static Atlas of_points(int count);
  bool is_of_points() const { return patches_.size() == 1 && patches_.front().rows == 1; }

  const std::vector<Patch>& patches() const { return patches_; }
  int texel_count() const { return first_texel_.back(); }
  int particle_count() const { return particle_count_; }
  int quad_count() const { return first_quad_.back(); }
  int first_texel(int patch) const { return first_texel_[patch]; }
  int first_quad(int patch) const { return first_quad_[patch]; }
  // Returns true if the atlas was made without a map. Texel i is then particle i, and arrays by
  // particle are also arrays by texel.
  bool is_identity() const { return texel_to_particle_.empty(); }

  // Returns the particle of each texel; empty if is_identity().
  std::span<const int> texel_to_particle() const { return texel_to_particle_; }
  int particle_of_texel(int texel) const {
    return texel_to_particle_.empty() ? texel : texel_to_particle_[texel];
  }
  // Returns the particle at (row, col) of a patch. On a wrapped axis of n vertices, the indices n
  // to 2 n - 1 stand for 0 to n - 1.
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
  // Returns the first texel of a particle. O(texels) on a sewn atlas, so it suits error messages
  // only.
  TexelAddress particle_address(int particle) const;

 private:
  std::vector<Patch> patches_;
  std::vector<int> texel_to_particle_;
  std::vector<int> first_texel_{0};
  std::vector<int> first_quad_{0};
  int particle_count_ = 0;
};

// Returns the two triangles of a quad whose corners are in the order of quad_particles(). The
// diagonal runs from (r,c+1) to (r+1,c) in every quad. On a regular grid with one diagonal, the
// bending model is exact for constant curvature in any direction. Both triangles are
// counter-clockwise when seen from the side to which u x v points.
inline std::array<std::array<int, 3>, 2> quad_triangles(const std::array<int, 4>& corner) {
  return {{{corner[0], corner[1], corner[2]}, {corner[1], corner[3], corner[2]}}};
}

// An edge of a mesh and the one or two triangles that share it.
struct Edge {
  std::array<int, 2> vertex{};          // particles, in the direction of the first triangle
  std::array<int, 2> triangle{-1, -1};  // the second is -1 on the border
  std::array<int, 2> opposite{-1, -1};  // corner of each triangle off the edge, or -1
};

// The triangles and edges of an atlas, and the quads that own particles and edges. Corners are
// particle indices. Triangle t belongs to quad t / 2. Edge triangle_edges[t][e] is opposite corner
// e of triangle t. The owner of a particle or an edge is the first quad that contains it, and edges
// are numbered in the order of their owners. A search over pairs of quads that combines only owned
// particles and edges therefore finds no pair of features twice.
struct Mesh {
  std::vector<std::array<int, 3>> triangles;
  std::vector<std::array<int, 3>> triangle_edges;
  std::vector<Edge> edges;
  // Particles owned by each quad, in compressed rows.
  std::vector<int> owned_vertex_start, owned_vertices;
  // Edges owned by each quad, in compressed rows.
  std::vector<int> owned_edge_start, owned_edges;

  std::span<const int> vertices_of_quad(int quad) const {
    return std::span(owned_vertices)
        .subspan(owned_vertex_start[quad], owned_vertex_start[quad + 1] - owned_vertex_start[quad]);
  }
  std::span<const int> edges_of_quad(int quad) const {
    return std::span(owned_edges)
        .subspan(owned_edge_start[quad], owned_edge_start[quad + 1] - owned_edge_start[quad]);
  }
};

// Builds the mesh of an atlas. O(texels), and quadratic in the number of edges that meet at one
// particle. Throws std::invalid_argument, naming a quad, if the image
// is not an orientable surface. At most two triangles may share an edge, and they must traverse it
// in opposite directions. A triangle must have three different particles.
Mesh build_mesh(const Atlas& atlas);

}  // namespace weft::bsi
