#include "sim/matrix/tiled_matrix.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <limits>
#include <random>

namespace weft::sim {
namespace {

using Neighbours = std::vector<std::vector<int>>;

void couple(Neighbours& all, int a, int b) {
  all[a].push_back(b);
  all[b].push_back(a);
}

// Adds the couplings of an image of bending cloth: particles up to two steps away, but not along
// both directions.
void add_image(Neighbours& all, int rows, int columns) {
  const int start = static_cast<int>(all.size());
  all.resize(start + rows * columns);
  for (int i = 0; i < rows * columns; ++i) {
    for (int j = 0; j < i; ++j) {
      const int up = i / columns - j / columns, across = std::abs(i % columns - j % columns);
      if (up <= 2 && across <= 2 && up + across < 4) couple(all, start + i, start + j);
    }
  }
}

Neighbours image(int rows, int columns) {
  Neighbours all;
  add_image(all, rows, columns);
  return all;
}

class Numbers {
 public:
  double next() { return uniform_(generator_); }

 private:
  std::mt19937 generator_{1};
  std::uniform_real_distribution<double> uniform_{-1, 1};
};

// A matrix with random blocks, and a random vector.
template <class Number>
struct Product {
  explicit Product(const Neighbours& neighbours)
      : matrix(std::make_shared<const BlockPattern>(neighbours)), in(neighbours.size()) {
    for (int i = 0; i < matrix.pattern().upper_count(); ++i)
      matrix.upper_block(i) = TiledMatrix<Number>::Block::NullaryExpr(
          [&] { return static_cast<Number>(numbers.next()); });
    for (Vec3& each : in) each = Vec3(numbers.next(), numbers.next(), numbers.next());
  }
  // Returns the largest difference to the sum over the blocks of each row, one by one, in units of
  // the rounding error of a number of about 1.
  double error() const {
    const BlockPattern& pattern = matrix.pattern();
    const std::vector<Vec3> out = multiplied(1);
    double error = 0;
    for (int row = 0; row < pattern.rows(); ++row) {
      Vec3 sum = Vec3::Zero();
      for (int slot = pattern.row_begin(row); slot < pattern.row_end(row); ++slot)
        sum += matrix.block(row, slot).template cast<double>() * in[pattern.column(slot)];
      error = std::max(error, (out[row] - sum).norm());
    }
    return error / std::numeric_limits<Number>::epsilon();
  }
  // Returns the share of blocks that are multiplied one by one.
  double loose_share() const {
    const BlockPattern& pattern = matrix.pattern();
    return static_cast<double>(pattern.layout().loose_of(0, pattern.rows()).size()) /
           pattern.block_count();
  }
  std::vector<Vec3> multiplied(int threads) const {
    std::vector<Vec3> out(in.size(), Vec3::Constant(1e9));
    matrix.multiply(in, out, threads);
    return out;
  }

  Numbers numbers;
  TiledMatrix<Number> matrix;
  std::vector<Vec3> in;
};

constexpr double most = 50;  // rounding errors of a sum of some 60 numbers of about 1

template <class Number>
class TiledMatrices : public testing::Test {};
using NumberTypes = testing::Types<double, float>;
TYPED_TEST_SUITE(TiledMatrices, NumberTypes);

TYPED_TEST(TiledMatrices, MultiplyImagesSeveralRowsAtOnce) {
  const Product<TypeParam> product(image(20, 33));
  EXPECT_EQ(product.loose_share(), 0);
  EXPECT_LT(product.error(), most);
}

TYPED_TEST(TiledMatrices, MultiplyImagesOfSeveralSizes) {
  Neighbours all;
  for (const auto& [rows, columns] : {std::pair(17, 9), {3, 3}, {30, 21}, {1, 40}, {12, 50}})
    add_image(all, rows, columns);
  const Product<TypeParam> product(all);
  EXPECT_LT(product.loose_share(), 0.1);
  EXPECT_LT(product.error(), most);
}

// The two sides of a seam, and a few particles tied to others: only these couplings are loose.
TYPED_TEST(TiledMatrices, MultiplyRowsWithCouplingsOfTheirOwn) {
  Neighbours all = image(30, 30);
  for (int row = 0; row < 30; ++row) couple(all, 30 * row, 30 * row + 29);
  for (int i : {7, 100, 101, 555}) couple(all, i, 899 - i);
  const Product<TypeParam> product(all);
  EXPECT_GT(product.loose_share(), 0);
  EXPECT_LE(product.loose_share(), 2.0 * 34 / product.matrix.pattern().block_count());
  EXPECT_LT(product.error(), most);
}

Neighbours random_couplings(int rows) {
  Neighbours all(rows);
  Numbers numbers;
  for (int i = 0; i < rows; ++i) {
    for (int k = 0; k < 10; ++k) {
      const int other = static_cast<int>(0.5 * rows * (1 + numbers.next()));
      if (other != i) couple(all, i, other);
    }
  }
  return all;
}

TYPED_TEST(TiledMatrices, MultiplyBlocksOfRowsWithNothingInCommonOneByOne) {
  const Product<TypeParam> product(random_couplings(500));
  // All have a diagonal block.
  EXPECT_DOUBLE_EQ(product.loose_share(), 1 - 500.0 / product.matrix.pattern().block_count());
  EXPECT_LT(product.error(), most);
}

// Rows without a common pattern take little more memory than their blocks, for diagonal blocks.
TEST(BlockLayout, StoresLittleMoreThanTheBlocks) {
  const BlockPattern any(random_couplings(500));
  EXPECT_LT(any.layout().size(), 1.1 * 9 * any.upper_count());
  const BlockPattern sheet(image(65, 65));
  EXPECT_LT(sheet.layout().size(), 1.5 * 9 * sheet.upper_count());
}

// An image beside rows without a common pattern.
TYPED_TEST(TiledMatrices, MultiplyBothKindsOfRows) {
  Neighbours all = random_couplings(200);
  add_image(all, 20, 20);
  for (int i = 0; i < 150; ++i) couple(all, i, 200 + 2 * i);
  const Product<TypeParam> product(all);
  EXPECT_GT(product.loose_share(), 0.2);
  EXPECT_LT(product.loose_share(), 0.8);
  EXPECT_LT(product.error(), most);
}

TYPED_TEST(TiledMatrices, MultiplyImagesOfEverySize) {
  for (int rows = 1; rows <= 40; ++rows) {
    const Product<TypeParam> product(image(rows, 1));
    EXPECT_LT(product.error(), most) << rows;
  }
  for (int columns = 1; columns <= 150; ++columns) {
    const Product<TypeParam> product(image(3, columns));
    EXPECT_LT(product.error(), most) << columns;
  }
}

TYPED_TEST(TiledMatrices, AreSums) {
  const Neighbours neighbours = image(20, 20);
  const auto pattern = std::make_shared<const BlockPattern>(neighbours);
  TiledMatrix<double> one(pattern), other(pattern);
  TiledMatrix<TypeParam> sum(pattern);
  Numbers numbers;
  for (int i = 0; i < pattern->upper_count(); ++i) {
    one.upper_block(i) = Mat3::NullaryExpr([&] { return numbers.next(); });
    other.upper_block(i) = Mat3::NullaryExpr([&] { return numbers.next(); });
  }
  sum.set_to_sum(2, one, -0.5, other, 2);
  for (int i = 0; i < pattern->upper_count(); ++i) {
    const Mat3 expected = 2 * one.upper_block(i) - 0.5 * other.upper_block(i);
    EXPECT_EQ(sum.upper_block(i), expected.template cast<TypeParam>()) << i;
  }
}

TYPED_TEST(TiledMatrices, GiveTheSameBitsForAnyNumberOfThreads) {
  const Product<TypeParam> product(image(40, 33));
  const std::vector<Vec3> one = product.multiplied(1);
  for (int threads : {2, 3, 8}) EXPECT_EQ(product.multiplied(threads), one) << threads;
}

}  // namespace
}  // namespace weft::sim
