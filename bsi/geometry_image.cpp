#include "bsi/geometry_image.h"

#include <algorithm>
#include <cassert>
#include <cstdint>
#include <limits>
#include <numeric>
#include <stdexcept>

namespace weft::bsi {

namespace {

std::string text_of(const TexelAddress& place) {
  return "patch " + std::to_string(place.patch) + ", row " + std::to_string(place.row) +
         ", column " + std::to_string(place.col);
}

void check_axis(const char* name, int vertices, bool wrapped, std::size_t patch) {
  const int least = wrapped ? 3 : 2;
  if (vertices >= least) return;
  throw std::invalid_argument(
      "patch " + std::to_string(patch) + " has " + std::to_string(vertices) + " " + name +
      (wrapped ? " (wrapped)" : "") + ": at least " + std::to_string(least) + " are needed");
}

// Returns the number of particles of a map. Throws unless every index from 0 to the maximum occurs.
int check_particles(const std::vector<int>& texel_to_particle) {
  const auto texels = static_cast<int>(texel_to_particle.size());
  const int count = *std::ranges::max_element(texel_to_particle) + 1;
  // A valid map has at least as many texels as particles. Checking this first limits the allocation
  // below.
  if (count > texels || *std::ranges::min_element(texel_to_particle) < 0) {
    throw std::invalid_argument("a texel's particle index is outside 0.." +
                                std::to_string(texels - 1));
  }
  std::vector<bool> used(count, false);
  for (const int particle : texel_to_particle) used[particle] = true;
  const auto gap = std::ranges::find(used, false);
  if (gap != used.end()) {
    throw std::invalid_argument("no texel holds particle " + std::to_string(gap - used.begin()));
  }
  return count;
}

// Returns the patch that contains item `index`. `first` holds the first item of each patch, then
// the number of items.
int patch_of(const std::vector<int>& first, int index) {
  assert(index >= 0 && index < first.back());
  return static_cast<int>(std::ranges::upper_bound(first, index) - first.begin()) - 1;
}

}  // namespace

Atlas::Atlas(std::vector<Patch> patches, std::vector<int> texel_to_particle)
    : patches_(std::move(patches)), texel_to_particle_(std::move(texel_to_particle)) {
  if (patches_.empty()) throw std::invalid_argument("an atlas needs at least one patch");
  std::int64_t texels = 0;
  for (std::size_t i = 0; i < patches_.size(); ++i) {
    const Patch& patch = patches_[i];
    check_axis("rows", patch.rows, patch.wrap_v, i);
    check_axis("columns", patch.cols, patch.wrap_u, i);
    texels += static_cast<std::int64_t>(patch.rows) * patch.cols;
    // The corners of all triangles, up to 6 per texel, must also be countable by an int.
    if (texels > std::numeric_limits<int>::max() / 6) {
      throw std::invalid_argument("the atlas has more vertices than can be numbered");
    }
    first_texel_.push_back(static_cast<int>(texels));
    first_quad_.push_back(first_quad_.back() + patch.quad_count());
  }
  if (texel_to_particle_.empty()) {
    particle_count_ = texel_count();
    return;
  }
  if (static_cast<std::int64_t>(texel_to_particle_.size()) != texels) {
    throw std::invalid_argument("the particle map has " +
                                std::to_string(texel_to_particle_.size()) + " entries for " +
                                std::to_string(texels) + " texels");
  }
  particle_count_ = check_particles(texel_to_particle_);
}

Atlas Atlas::of_points(int count) {
  if (count <= 0 || count > std::numeric_limits<int>::max() / 6)
    throw std::invalid_argument("an atlas cannot have " + std::to_string(count) + " points");
  Atlas atlas;
  atlas.patches_ = {Patch{.rows = 1, .cols = count}};
  atlas.first_texel_ = {0, count};
  atlas.first_quad_ = {0, 0};
  atlas.particle_count_ = count;
  return atlas;
}

std::array<int, 4> Atlas::quad_particles(int quad) const {
  const auto [patch, row, col] = quad_address(quad);
  return {particle(patch, row, col), particle(patch, row, col + 1), particle(patch, row + 1, col),
          particle(patch, row + 1, col + 1)};
}

TexelAddress Atlas::quad_address(int quad) const {
  const int patch = patch_of(first_quad_, quad);
  const int local = quad - first_quad_[patch];
  const int width = patches_[patch].quad_cols();
  return {patch, local / width, local % width};
}

TexelAddress Atlas::texel_address(int texel) const {
  const int patch = patch_of(first_texel_, texel);
  const int local = texel - first_texel_[patch];
  const int width = patches_[patch].cols;
  return {patch, local / width, local % width};
}

TexelAddress Atlas::particle_address(int particle) const {
  assert(particle >= 0 && particle < particle_count_);
  if (is_identity()) return texel_address(particle);
  const auto found = std::ranges::find(texel_to_particle_, particle);
  return texel_address(static_cast<int>(found - texel_to_particle_.begin()));
}

namespace {

// Collects the edges of triangles that are added one by one. Each particle has a linked list of its
// edges to particles with higher indices. A list has no more entries than the particle has
// neighbours, so no hashing is needed.
class EdgeBuilder {
 public:
  EdgeBuilder(const Atlas& atlas, Mesh& mesh)
      : atlas_(atlas), mesh_(mesh), first_in_chain_(atlas.particle_count(), -1) {
    mesh_.edges.reserve(3 * static_cast<std::size_t>(atlas.quad_count()) +
                        static_cast<std::size_t>(atlas.texel_count()));
  }

  void add_triangle(int triangle) {
    const std::array<int, 3>& corner = mesh_.triangles[triangle];
    for (int e = 0; e < 3; ++e) {
      const int from = corner[(e + 1) % 3];
      const int to = corner[(e + 2) % 3];
      mesh_.triangle_edges[triangle][e] = add_side(triangle, from, to, corner[e]);
    }
  }

 private:
  int add_side(int triangle, int from, int to, int opposite) {
    if (from == to) fail(triangle, "uses one particle twice");
    int& head = first_in_chain_[std::min(from, to)];
    for (int index = head; index >= 0; index = next_in_chain_[index]) {
      Edge& edge = mesh_.edges[index];
      if (std::max(edge.vertex[0], edge.vertex[1]) != std::max(from, to)) continue;
      if (edge.triangle[1] >= 0) fail(triangle, "has an edge that two other triangles share");
      if (edge.vertex[0] == from) fail(triangle, "runs along a shared edge the wrong way");
      edge.triangle[1] = triangle;
      edge.opposite[1] = opposite;
      return index;
    }
    const auto index = static_cast<int>(mesh_.edges.size());
    mesh_.edges.push_back({{from, to}, {triangle, -1}, {opposite, -1}});
    next_in_chain_.push_back(head);
    head = index;
    return index;
  }

  [[noreturn]] void fail(int triangle, const std::string& what) const {
    throw std::invalid_argument("the image is not an orientable surface: the quad at " +
                                text_of(atlas_.quad_address(triangle / 2)) + " " + what);
  }

  const Atlas& atlas_;
  Mesh& mesh_;
  std::vector<int> first_in_chain_;
  std::vector<int> next_in_chain_;  // edge that follows each edge in its list, or -1
};

// Assigns each particle to the first quad that has it as a corner.
void own_vertices(const Atlas& atlas, Mesh& mesh) {
  std::vector<bool> owned(atlas.particle_count(), false);
  mesh.owned_vertices.reserve(atlas.particle_count());
  mesh.owned_vertex_start.reserve(static_cast<std::size_t>(atlas.quad_count()) + 1);
  mesh.owned_vertex_start.push_back(0);
  for (int quad = 0; quad < atlas.quad_count(); ++quad) {
    // The two triangles of the quad together have its four corners.
    const auto& first = mesh.triangles[2 * quad];
    for (const int particle : {first[0], first[1], first[2], mesh.triangles[2 * quad + 1][1]}) {
      if (owned[particle]) continue;
      owned[particle] = true;
      mesh.owned_vertices.push_back(particle);
    }
    mesh.owned_vertex_start.push_back(static_cast<int>(mesh.owned_vertices.size()));
  }
}

}  // namespace

Mesh build_mesh(const Atlas& atlas) {
  Mesh mesh;
  const std::size_t quads = atlas.quad_count();
  mesh.triangles.reserve(2 * quads);
  for (std::size_t patch = 0; patch < atlas.patches().size(); ++patch) {
    const Patch& size = atlas.patches()[patch];
    const auto p = static_cast<int>(patch);
    for (int row = 0; row < size.quad_rows(); ++row) {
      for (int col = 0; col < size.quad_cols(); ++col) {
        const auto both =
            quad_triangles({atlas.particle(p, row, col), atlas.particle(p, row, col + 1),
                            atlas.particle(p, row + 1, col), atlas.particle(p, row + 1, col + 1)});
        mesh.triangles.insert(mesh.triangles.end(), both.begin(), both.end());
      }
    }
  }
  mesh.triangle_edges.resize(mesh.triangles.size());
  mesh.owned_edge_start.reserve(quads + 1);
  mesh.owned_edge_start.push_back(0);
  EdgeBuilder builder(atlas, mesh);
  for (int quad = 0; quad < atlas.quad_count(); ++quad) {
    builder.add_triangle(2 * quad);
    builder.add_triangle(2 * quad + 1);
    mesh.owned_edge_start.push_back(static_cast<int>(mesh.edges.size()));
  }
  // Edges have been created in the order of their owners, so the list of owned edges counts
  // upwards.
  mesh.owned_edges.resize(mesh.edges.size());
  std::iota(mesh.owned_edges.begin(), mesh.owned_edges.end(), 0);
  own_vertices(atlas, mesh);
  return mesh;
}

}  // namespace weft::bsi
