// How the spheres of a pyramid are built from an image, for pyramid.cpp alone. Costs: see
// Pyramid::rebuild.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "bsi/aligned_vector.h"
#include "bsi/block_levels.h"
#include "bsi/sphere.h"
#include "bsi/sphere_kernels.h"

namespace weft::bsi {

// The float32 vertices of a patch, row by row: row v of `last` + 1. One vertex for every boundary
// between two blocks of the last level, so that every block of a level spans as many: where the
// quads of an axis are no power of two in number, some vertices come twice.
struct SphereVertices {
  float* first[2] = {};  // by end of the path
  float* last_row[2] = {};
  int last = 0;
  int row_mask = -1;       // 3 where only four rows are held, row v in place v mod 4
  std::size_t stride = 0;  // from component to component
  int ends = 1;
  float* at(int end, int index) const {
    return index == last ? last_row[end] : first[end] + 3 * stride * (index & row_mask);
  }
  SphereVertexRow row(int end, int index) const {
    const float* x = at(end, index);
    return {{x, x + stride, x + 2 * stride}};
  }
};

// Spheres of the quad levels in the order of BlockLevels, then of the groups from the top down,
// then, where leaves are triangles, those of the triangles, patch by patch.
struct SphereTree {
  const Atlas* atlas = nullptr;
  const BlockLevels* numbers = nullptr;
  Sphere* spheres = nullptr;
  Sphere* groups = nullptr;
  Sphere* triangles = nullptr;
};

// Boxes of patches, which groups are bounded from.
struct PatchBox {
  std::array<float, 3> low{}, high{};
};

class SphereBuild {
 public:
  SphereBuild() = default;
  SphereBuild(const Atlas& atlas, const BlockLevels& numbers, RadiusPolicy policy);

  // Fills every sphere of the tree from positions at one end of the paths or at both, on so many
  // threads. Returns the first texel whose position reaches the limit or is not a number.
  std::optional<TexelAddress> run(const SphereTree& tree,
                                  std::span<const std::span<const Vec3>> ends, float limit,
                                  int threads);
  // True where several threads share a rebuild.
  bool is_parallel() const { return is_parallel_; }
  std::size_t bytes() const;

 private:
  struct PatchPlan {
    int depth_u = 0, depth_v = 0;
    int strip_level = 0;     // the blocks of whose rows are the strips
    std::size_t stride = 0;  // of vertex rows
    std::size_t first_vertex = 0;
    std::size_t first_triangle = 0;
    // How a row of an image becomes one of SphereVertices; none where it is one.
    std::vector<std::int32_t> run_from, run_length;
    std::vector<int> empty_columns;   // of the last level
    AlignedVector<float> strip_tops;  // rows of blocks
    PatchBox box;
  };
  struct Strip {
    int patch = 0;
    int index = 0;
  };
  // Of one thread.
  struct Scratch {
    AlignedVector<float> block_rows;                  // by level, an even and an odd one
    std::array<AlignedVector<float>, 2> vertex_rows;  // by end: four
    AlignedVector<float> image_row;
    AlignedVector<float> centres, squared;
  };

  void plan_patch(const Atlas& atlas, const BlockLevels& numbers, int patch);
  void make_scratch(int threads);
  bool bound_strip(const Strip& strip, Scratch& scratch);
  bool load_row(int patch, int row, const SphereVertices& vertices, Scratch& scratch);
  void bound_leaf_rows(int patch, int v, const SphereVertexRows& rows, Scratch& scratch);
  void bound_triangles(int patch, int v, const SphereVertexRows& rows, int first);
  void clear_empty(int patch, int level, int v, const SphereRow& row);
  void climb(int patch, int level, int v, int top, const SphereVertices& vertices,
             Scratch& scratch);
  void reach_vertices(int patch, int level, int v, const SphereVertices& vertices,
                      const SphereRow& row, Scratch& scratch);
  SphereRow block_row(int patch, int level, int v, Scratch& scratch);
  SphereVertices kept_vertices(int patch);
  SphereVertices vertices_of_strip(int patch, int last, Scratch& scratch);
  void join_strips(int patch);
  void tighten_top_levels(int patch);
  void bound_groups();
  TexelAddress first_unbounded() const;
  float* spheres_of_row(int patch, int level, int v) const;
  int boundary_row(int patch, int v) const;

  bool is_parallel_ = false;
  bool keeps_vertices_ = false;
  std::vector<PatchPlan> patches_;
  std::vector<Strip> strips_;
  std::array<AlignedVector<float>, 2> vertices_;  // where kept
  std::vector<std::size_t> level_row_;            // into Scratch::block_rows, by level
  std::size_t block_row_floats_ = 0, vertex_stride_ = 0, triangle_count_ = 0;
  std::vector<Scratch> scratch_;

  // Of the run in progress.
  SphereTree tree_;
  std::array<std::span<const Vec3>, 2> ends_;
  int end_count_ = 1;
  float limit_ = 0;
};

}  // namespace weft::bsi
