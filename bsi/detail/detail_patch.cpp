#include "bsi/detail/detail_patch.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace weft::bsi {

DetailPatch::DetailPatch(const Pyramid& pyramid, int patch, bool as_it_is)
    : pyramid_(pyramid), patch_(patch), size_(pyramid.atlas().patches()[patch]) {
  vertex_of_.resize(size_.texel_count());
  std::iota(vertex_of_.begin(), vertex_of_.end(), 0);
  if (as_it_is) return;
  // Fewer than three blocks around a wrapped axis would touch each other on both sides and fold the
  // surface onto itself.
  const int level = size_.wrap_u || size_.wrap_v ? 2 : 0;
  for (int v = 0; v < pyramid_.blocks_v(patch_, level); ++v) {
    for (int u = 0; u < pyramid_.blocks_u(patch_, level); ++u) add({patch_, level, u, v});
  }
}

QuadRange DetailPatch::texels_of(const PatchBlock& block) const {
  QuadRange texels = pyramid_.quads(block.patch, block.level, block.u, block.v);
  // A texel belongs to the block of its lower right quad. Texels of an open border belong to no
  // block.
  if (!size_.wrap_v) texels.row_begin = std::max(texels.row_begin, 1);
  if (!size_.wrap_u) texels.col_begin = std::max(texels.col_begin, 1);
  return texels;
}

void DetailPatch::add(const PatchBlock& block) {
  const QuadRange quads = pyramid_.quads(block.patch, block.level, block.u, block.v);
  const double row = 0.5 * (quads.row_begin + quads.row_end);
  const double col = 0.5 * (quads.col_begin + quads.col_end);
  const QuadRange texels = texels_of(block);
  const int rows = texels.row_end - texels.row_begin;
  const int cols = texels.col_end - texels.col_begin;
  if (rows <= 0 || cols <= 0) return;
  const bool alone = rows == 1 && cols == 1;
  const int first = texels.row_begin * size_.cols + texels.col_begin;
  const int vertex = alone ? first : texel_count() + block_count();
  if (!alone) blocks_.push_back({block, row, col});
  for (int i = 0; i < rows; ++i) {
    std::fill_n(vertex_of_.begin() + first + static_cast<std::ptrdiff_t>(i) * size_.cols, cols,
                vertex);
  }
}

int DetailPatch::middle_texel(int vertex) const {
  if (!is_block(vertex)) return vertex;
  const PlacedBlock& placed = blocks_[vertex - texel_count()];
  return static_cast<int>(placed.row) * size_.cols + static_cast<int>(placed.col);
}

void DetailPatch::release(const PatchBlock& block) {
  const QuadRange texels = texels_of(block);
  for (int row = texels.row_begin; row < texels.row_end; ++row) {
    for (int col = texels.col_begin; col < texels.col_end; ++col) {
      const int texel = row * size_.cols + col;
      vertex_of_[texel] = texel;
    }
  }
}

void DetailPatch::sample_borders(std::span<const int> sample_of) {
  std::vector<std::array<int, 2>> border;  // pairs of particle and texel
  for (int row = 0; row < size_.rows; ++row) {
    const bool is_end = !size_.wrap_v && (row == 0 || row + 1 == size_.rows);
    for (int col = 0; col < size_.cols; ++col) {
      const bool is_side = !size_.wrap_u && (col == 0 || col + 1 == size_.cols);
      if (!is_end && !is_side) continue;
      border.push_back({pyramid_.atlas().particle(patch_, row, col), row * size_.cols + col});
    }
  }
  std::ranges::sort(border);
  for (const auto& [particle, texel] : border) {
    if (sample_of[particle] == particle) continue;
    const auto sample = std::ranges::lower_bound(border, std::array{sample_of[particle], 0});
    vertex_of_[texel] = (*sample)[1];
  }
}

void DetailPatch::split(int vertex) {
  const PatchBlock parent = block(vertex);
  const int below = parent.level + 1;
  if (below == pyramid_.levels(patch_)) {
    release(parent);
    return;
  }
  const int split_u = pyramid_.blocks_u(patch_, below) / pyramid_.blocks_u(patch_, parent.level);
  const int split_v = pyramid_.blocks_v(patch_, below) / pyramid_.blocks_v(patch_, parent.level);
  for (int v = 0; v < split_v; ++v) {
    for (int u = 0; u < split_u; ++u) {
      add({patch_, below, split_u * parent.u + u, split_v * parent.v + v});
    }
  }
}

void DetailPatch::split_to_level(int level) {
  // Children are appended, so the loop reaches them, too.
  for (int i = 0; i < block_count(); ++i) {
    if (blocks_[i].block.level < level) split(texel_count() + i);
  }
}

}  // namespace weft::bsi
