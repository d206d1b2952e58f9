#include "sim/matrix/diagonal_storage.h"

#include <algorithm>
#include <cassert>

#if defined(__AVX__)
#include <immintrin.h>
#endif

#include "sim/base/parallel.h"

namespace weft::sim {

namespace {

using materials::Lanes;

// Lanes without a block multiply zeros. Rows are grouped if at most this many products are made for
// each block that there is: a product costs less than half of one by itself.
constexpr int most_products_per_block = 2;

// GCC 12 converts a whole register of floats in two halves, which takes five instructions.
Lanes load(const float* at) {
#if defined(__AVX512F__)
  return Lanes(Lanes::Vector(_mm512_cvtps_pd(_mm256_loadu_ps(at))));
#elif defined(__AVX__)
  return Lanes(Lanes::Vector(_mm256_cvtps_pd(_mm_loadu_ps(at))));
#else
  Lanes values;
  for (int i = 0; i < materials::lane_count; ++i) values.values[i] = at[i];
  return values;
#endif
}
Lanes load(const double* at) {
  return Lanes(Lanes::Vector(*reinterpret_cast<const materials::UnalignedLanes*>(at)));
}

// A product of blocks with vectors. It sums the products with each component of the vectors apart,
// so that additions need not wait for each other.
struct Sums {
  Lanes x0 = 0, x1 = 0, x2 = 0, y0 = 0, y1 = 0, y2 = 0, z0 = 0, z1 = 0, z2 = 0;

  // Adds the products of blocks, whose entries begin `stride` numbers apart, column by column.
  void add(const float* block, int stride, Lanes x, Lanes y, Lanes z) {
    x0 += load(block) * x;
    x1 += load(block + stride) * x;
    x2 += load(block + 2 * stride) * x;
    y0 += load(block + 3 * stride) * y;
    y1 += load(block + 4 * stride) * y;
    y2 += load(block + 5 * stride) * y;
    z0 += load(block + 6 * stride) * z;
    z1 += load(block + 7 * stride) * z;
    z2 += load(block + 8 * stride) * z;
  }
  void add_transposed(const float* block, int stride, Lanes x, Lanes y, Lanes z) {
    x0 += load(block) * x;
    y0 += load(block + stride) * y;
    z0 += load(block + 2 * stride) * z;
    x1 += load(block + 3 * stride) * x;
    y1 += load(block + 4 * stride) * y;
    z1 += load(block + 5 * stride) * z;
    x2 += load(block + 6 * stride) * x;
    y2 += load(block + 7 * stride) * y;
    z2 += load(block + 8 * stride) * z;
  }
  std::array<Lanes, 3> components() const { return {x0 + y0 + z0, x1 + y1 + z1, x2 + y2 + z2}; }
};

void make_unique(std::vector<int>& numbers) {
  std::ranges::sort(numbers);
  numbers.erase(std::ranges::unique(numbers).begin(), numbers.end());
}

}  // namespace

DiagonalStorage::DiagonalStorage(std::shared_ptr<const BlockPattern> pattern)
    : pattern_(std::move(pattern)) {
  find_tiles();
  find_groups();
}

void DiagonalStorage::find_tiles() {
  const int rows = pattern_->rows();
  tiles_.resize((rows + rows_per_tile - 1) / rows_per_tile);
  std::ptrdiff_t count = 0;
  int farthest = 0;
  for (int t = 0; t < std::ssize(tiles_); ++t) {
    std::vector<int>& diagonals = tiles_[t].diagonals;
    const int first = t * rows_per_tile, last = std::min(first + stored_rows, rows);
    for (int row = first; row < last; ++row) {
      for (int slot = pattern_->diagonal_slot(row); slot < pattern_->row_end(row); ++slot)
        diagonals.push_back(pattern_->column(slot) - row);
    }
    const std::size_t blocks = diagonals.size();
    make_unique(diagonals);
    if (diagonals.size() * (last - first) > most_products_per_block * blocks) diagonals.clear();
    if (!diagonals.empty()) farthest = std::max(farthest, diagonals.back());
    tiles_[t].first_value = count;
    count += std::ssize(diagonals) * 9 * stored_rows;
  }
  values_.resize(count);
  for (std::vector<double>& component : in_) component.resize(rows + farthest + lane_count);
}

void DiagonalStorage::find_groups() {
  for (int row = 0; row + lane_count <= pattern_->rows(); row += lane_count) {
    Group group;
    group.first_term = static_cast<int>(terms_.size());
    if (!add_terms(row)) terms_.resize(group.first_term);
    group.end_term = static_cast<int>(terms_.size());
    group.first_upper_term = group.first_term;
    while (group.first_upper_term < group.end_term && terms_[group.first_upper_term].column < row)
      ++group.first_upper_term;
    groups_.push_back(group);
  }
}

// Adds the terms of the group that begins at `row`. Returns false if the rows have too little in
// common, or if a block is in no tile.
bool DiagonalStorage::add_terms(int row) {
  std::vector<int> diagonals;
  for (int i = row; i < row + lane_count; ++i) {
    for (int slot = pattern_->row_begin(i); slot < pattern_->row_end(i); ++slot)
      diagonals.push_back(pattern_->column(slot) - i);
  }
  const std::size_t blocks = diagonals.size();
  make_unique(diagonals);
  if (diagonals.size() * lane_count > most_products_per_block * blocks) return false;
  for (int diagonal : diagonals) {
    const int column = row + diagonal;
    const std::ptrdiff_t value =
        diagonal < 0 ? find_value(column, -diagonal) : find_value(row, diagonal);
    if (value < 0) return false;
    terms_.push_back({value, column});
  }
  return true;
}

// Returns the index of the first entry of the block of `row` on a diagonal >= 0, or -1 if it is in
// no tile.
std::ptrdiff_t DiagonalStorage::find_value(int row, int diagonal) const {
  if (row < 0) return -1;
  const Tile& tile = tiles_[row / rows_per_tile];
  const auto found = std::ranges::lower_bound(tile.diagonals, diagonal);
  if (found == tile.diagonals.end() || *found != diagonal) return -1;
  return tile.first_value + (found - tile.diagonals.begin()) * 9 * stored_rows +
         row % rows_per_tile;
}

int DiagonalStorage::grouped_rows() const {
  return lane_count * static_cast<int>(std::ranges::count_if(
                          groups_, [](const Group& g) { return !g.is_empty(); }));
}

void DiagonalStorage::assign(const SingleBlockMatrix& matrix, int threads) {
  assert(&matrix.pattern() == pattern_.get());
  parallel_chunks(static_cast<int>(tiles_.size()), threads, [&](int first, int last) {
    for (int tile = first; tile < last; ++tile) copy_tile(matrix, tile);
  });
}

// Writes the blocks that there are. Those that are missing stay zero.
void DiagonalStorage::copy_tile(const SingleBlockMatrix& matrix, int index) {
  const Tile& tile = tiles_[index];
  if (tile.diagonals.empty()) return;
  const int first = index * rows_per_tile, last = std::min(first + stored_rows, pattern_->rows());
  for (int row = first; row < last; ++row) {
    float* to = values_.data() + tile.first_value + (row - first);
    const int diagonal = pattern_->diagonal_slot(row);
    auto at = tile.diagonals.begin();
    for (int slot = diagonal; slot < pattern_->row_end(row); ++slot) {
      for (; *at != pattern_->column(slot) - row; ++at) to += 9 * stored_rows;
      const float* block = matrix.upper_block(pattern_->upper(row, slot)).data();
      for (int entry = 0; entry < 9; ++entry) to[entry * stored_rows] = block[entry];
    }
  }
}

void DiagonalStorage::multiply(const SingleBlockMatrix& matrix, std::span<const Vec3> in,
                               std::span<Vec3> out, int threads) const {
  const int rows = pattern_->rows(), groups = static_cast<int>(groups_.size());
  assert(static_cast<int>(in.size()) == rows && in.size() == out.size());
  parallel_chunks(rows, threads, [&](int first, int last) {
    for (int row = first; row < last; ++row) {
      for (int i = 0; i < 3; ++i) in_[i][row] = in[row][i];
    }
  });
  parallel_chunks(groups, threads, [&](int first, int last) {
    for (int group = first; group < last; ++group) {
      if (!groups_[group].is_empty()) {
        multiply_group(group, out);
        continue;
      }
      for (int row = group * lane_count; row < (group + 1) * lane_count; ++row)
        out[row] = matrix.row_product(row, in.data());
    }
  });
  for (int row = groups * lane_count; row < rows; ++row)
    out[row] = matrix.row_product(row, in.data());
}

void DiagonalStorage::multiply_group(int index, std::span<Vec3> out) const {
  const Group& group = groups_[index];
  const double *const x = in_[0].data(), *const y = in_[1].data(), *const z = in_[2].data();
  const float* const values = values_.data();
  Sums sums;
  const Term* term = terms_.data() + group.first_term;
  for (const Term* end = terms_.data() + group.first_upper_term; term < end; ++term)
    sums.add_transposed(values + term->value, stored_rows, load(x + term->column),
                        load(y + term->column), load(z + term->column));
  for (const Term* end = terms_.data() + group.end_term; term < end; ++term)
    sums.add(values + term->value, stored_rows, load(x + term->column), load(y + term->column),
             load(z + term->column));
  const std::array<Lanes, 3> components = sums.components();
  for (int lane = 0; lane < lane_count; ++lane) {
    for (int i = 0; i < 3; ++i) out[index * lane_count + lane][i] = components[i].values[lane];
  }
}

}  // namespace weft::sim
