#include "sim/matrix/tiled_matrix.h"

#include <algorithm>
#include <cassert>

#include "sim/base/parallel.h"

namespace weft::sim {

namespace {

constexpr int register_size = 8 * materials::lane_count;  // bytes

template <class Number>
struct Register {
  typedef Number Vector __attribute__((vector_size(register_size)));
  typedef Number Unaligned
      __attribute__((vector_size(register_size), aligned(sizeof(Number)), may_alias));
  static constexpr int size = register_size / sizeof(Number);
  static Vector load(const Number* at) { return *reinterpret_cast<const Unaligned*>(at); }
};

// A product of blocks with vectors. It sums the products with each component of the vectors apart,
// so that additions need not wait for each other.
template <class Number>
struct Sums {
  using Vector = typename Register<Number>::Vector;
  Vector x0{}, x1{}, x2{}, y0{}, y1{}, y2{}, z0{}, z1{}, z2{};

  static Vector entry(const Number* block, int index) {
    return Register<Number>::load(block + index * BlockLayout::stride);
  }
  // Adds the products of blocks with the vectors (x, y, z), column by column.
  void add(const Number* block, Vector x, Vector y, Vector z) {
    x0 += entry(block, 0) * x;
    x1 += entry(block, 1) * x;
    x2 += entry(block, 2) * x;
    y0 += entry(block, 3) * y;
    y1 += entry(block, 4) * y;
    y2 += entry(block, 5) * y;
    z0 += entry(block, 6) * z;
    z1 += entry(block, 7) * z;
    z2 += entry(block, 8) * z;
  }
  void add_transposed(const Number* block, Vector x, Vector y, Vector z) {
    x0 += entry(block, 0) * x;
    y0 += entry(block, 1) * y;
    z0 += entry(block, 2) * z;
    x1 += entry(block, 3) * x;
    y1 += entry(block, 4) * y;
    z1 += entry(block, 5) * z;
    x2 += entry(block, 6) * x;
    y2 += entry(block, 7) * y;
    z2 += entry(block, 8) * z;
  }
  std::array<Vector, 3> components() const { return {x0 + y0 + z0, x1 + y1 + z1, x2 + y2 + z2}; }
};

}  // namespace

template <class Number>
TiledMatrix<Number>::TiledMatrix(std::shared_ptr<const BlockPattern> pattern)
    : pattern_(std::move(pattern)), layout_(&pattern_->layout()), values_(layout().size()) {
  const std::size_t size = BlockLayout::margin + pattern_->rows() + layout().numbers_after();
  for (std::vector<Number>& component : in_) component.resize(size);
}

template <class Number>
void TiledMatrix<Number>::set_zero(int threads) {
  if (is_empty()) return;
  parallel_chunks(layout().size(), threads, [&](int first, int last) {
    std::fill(values() + first, values() + last, Number(0));
  });
}

template <class Number>
void TiledMatrix<Number>::set_to_sum(double a, const TiledMatrix<double>& one, double b,
                                     const TiledMatrix<double>& other, int threads) {
  assert(&one.pattern() == &pattern() && &other.pattern() == &pattern());
  const double *const from_one = one.values(), *const from_other = other.values();
  Number* const to = values();
  parallel_chunks(layout().size(), threads, [&](int first, int last) {
    for (int i = first; i < last; ++i)
      to[i] = static_cast<Number>(a * from_one[i] + b * from_other[i]);
  });
}

template <class Number>
Vec3 TiledMatrix<Number>::row_product(int row, std::span<const Vec3> in) const {
  Vec3 sum = Vec3::Zero();
  for (int slot = pattern_->row_begin(row); slot < pattern_->row_end(row); ++slot)
    sum += block(row, slot).template cast<double>() * in[pattern_->column(slot)];
  return sum;
}

template <class Number>
void TiledMatrix<Number>::multiply(std::span<const Vec3> in, std::span<Vec3> out,
                                   int threads) const {
  const int rows = pattern_->rows();
  assert(static_cast<int>(in.size()) == rows && in.size() == out.size());
  parallel_chunks(rows, threads, [&](int first, int last) {
    for (int row = first; row < last; ++row) {
      for (int i = 0; i < 3; ++i)
        in_[i][BlockLayout::margin + row] = static_cast<Number>(in[row][i]);
    }
  });
  const BlockLayout::Groups& in_groups = layout().groups_for(Number());
  const int count = static_cast<int>(in_groups.groups.size()), size = in_groups.size;
  parallel_chunks(count, threads, [&](int first, int last) {
    for (int group = first; group < last; ++group) {
      multiply_group(group, out);
      const int begin = group * size, end = begin + size;
      if (layout().loose_of(begin, end).empty()) continue;
      for (int row = begin; row < end; ++row) add_loose_product(row, in, out[row]);
    }
  });
  for (int row = count * size; row < rows; ++row) out[row] = row_product(row, in);
}

template <class Number>
void TiledMatrix<Number>::add_loose_product(int row, std::span<const Vec3> in, Vec3& out) const {
  for (const auto& [first, column] : layout().loose_of(row, row + 1)) {
    const Mat3 stored = block_at(first).template cast<double>();
    if (column < row) {
      out += stored.transpose() * in[column];
    } else {
      out += stored * in[column];
    }
  }
}

template <class Number>
void TiledMatrix<Number>::multiply_group(int index, std::span<Vec3> out) const {
  using Vector = typename Register<Number>::Vector;
  const auto& [size, groups, terms] = layout().groups_for(Number());
  const BlockLayout::Group& group = groups[index];
  const auto component = [&](int i, int column) {
    return Register<Number>::load(in_[i].data() + BlockLayout::margin + column);
  };
  Sums<Number> sums;
  const BlockLayout::Term* term = terms.data() + group.first_term;
  for (const auto* end = terms.data() + group.first_upper_term; term < end; ++term)
    sums.add_transposed(values() + term->first, component(0, term->column),
                        component(1, term->column), component(2, term->column));
  for (const auto* end = terms.data() + group.end_term; term < end; ++term)
    sums.add(values() + term->first, component(0, term->column), component(1, term->column),
             component(2, term->column));
  const std::array<Vector, 3> components = sums.components();
  for (int lane = 0; lane < Register<Number>::size; ++lane) {
    for (int i = 0; i < 3; ++i)
      out[index * size + lane][i] = static_cast<double>(components[i][lane]);
  }
}

template class TiledMatrix<double>;
template class TiledMatrix<float>;

}  // namespace weft::sim
