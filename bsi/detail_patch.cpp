#include "bsi/detail_patch.h"

#include <numeric>

namespace weft::bsi {

DetailPatch::DetailPatch(const Pyramid& pyramid, int patch, bool as_it_is)
    : pyramid_(pyramid), patch_(patch), size_(pyramid.atlas().patches()[patch]) {
  vertex_of_.resize(size_.texel_count());
  std::iota(vertex_of_.begin(), vertex_of_.end(), 0);
  if (as_it_is) return;
  // Fewer than three blocks round a wrap would touch each other on both sides: the surface would be
  // folded onto itself. On level 2 no two blocks reach round, however unequal.
  const int level = size_.wrap_u || size_.wrap_v ? 2 : 0;
  for (int v = 0; v < pyramid_.blocks_v(patch_, level); ++v) {
    for (int u = 0; u < pyramid_.blocks_u(patch_, level); ++u) add({patch_, level, u, v});
  }
}

void DetailPatch::add(const Block& block) {
  QuadRange texels = pyramid_.quads(block.patch, block.level, block.u, block.v);
  const double row = 0.5 * (texels.row_begin + texels.row_end);
  const double col = 0.5 * (texels.col_begin + texels.col_end);
  // A texel goes with the quad to its lower right; those of an open border go with none.
  if (!size_.wrap_v) texels.row_begin = std::max(texels.row_begin, 1);
  if (!size_.wrap_u) texels.col_begin = std::max(texels.col_begin, 1);
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

void DetailPatch::split(int vertex) {
  std::array<Block, 4> child;
  const int count = pyramid_.children(block(vertex), child);
  for (int i = 0; i < count; ++i) add(child[i]);
}

void DetailPatch::split_to_level(int level) {
  // Children are added at the end, where the loop comes to them in their turn.
  for (int i = 0; i < block_count(); ++i) {
    if (blocks_[i].block.level < level) split(texel_count() + i);
  }
}

}  // namespace weft::bsi
