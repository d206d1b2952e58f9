#include "sim/matrix/diagonal_storage.h"

#include <gtest/gtest.h>

#include <cstdlib>
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
struct Product {
  explicit Product(const Neighbours& neighbours)
      : matrix(std::make_shared<const BlockPattern>(neighbours)), in(neighbours.size()) {
    fill();
    for (Vec3& each : in) each = Vec3(numbers.next(), numbers.next(), numbers.next());
  }
  void fill() {
    for (int i = 0; i < matrix.pattern().upper_count(); ++i) {
      for (int entry = 0; entry < 9; ++entry)
        matrix.upper_block(i).data()[entry] = static_cast<float>(numbers.next());
    }
  }
  // Returns the largest difference to the sum over the blocks of each row, one by one.
  double error_of(const DiagonalStorage& storage) const {
    const BlockPattern& pattern = matrix.pattern();
    const std::vector<Vec3> out = multiplied(storage, 1);
    double error = 0;
    for (int row = 0; row < pattern.rows(); ++row) {
      Vec3 sum = Vec3::Zero();
      for (int slot = pattern.row_begin(row); slot < pattern.row_end(row); ++slot)
        sum += matrix.block(row, slot).cast<double>() * in[pattern.column(slot)];
      error = std::max(error, (out[row] - sum).norm());
    }
    return error;
  }
  std::vector<Vec3> multiplied(const DiagonalStorage& storage, int threads) const {
    std::vector<Vec3> out(in.size(), Vec3::Constant(1e9));
    storage.multiply(matrix, in, out, threads);
    return out;
  }

  Numbers numbers;
  SingleBlockMatrix matrix;
  std::vector<Vec3> in;
};

DiagonalStorage storage_of(const Product& product) {
  DiagonalStorage storage(product.matrix.shared_pattern());
  storage.assign(product.matrix, 2);
  return storage;
}

constexpr double rounding = 1e-13;  // of sums of some 60 numbers of about 1

TEST(DiagonalStorage, MultipliesImagesSeveralRowsAtOnce) {
  const Product product(image(20, 33));
  const DiagonalStorage storage = storage_of(product);
  EXPECT_GE(storage.grouped_rows(), 0.95 * 20 * 33);
  EXPECT_LT(product.error_of(storage), rounding);
}

TEST(DiagonalStorage, MultipliesImagesOfSeveralSizes) {
  Neighbours all;
  for (const auto& [rows, columns] : {std::pair(17, 9), {3, 3}, {30, 21}, {1, 40}, {12, 50}})
    add_image(all, rows, columns);
  const Product product(all);
  const DiagonalStorage storage = storage_of(product);
  EXPECT_GE(storage.grouped_rows(), 0.5 * static_cast<double>(all.size()));
  EXPECT_LT(product.error_of(storage), rounding);
}

// The two sides of a seam, and a few particles tied to others.
TEST(DiagonalStorage, MultipliesRowsWithCouplingsOfTheirOwn) {
  Neighbours all = image(30, 30);
  for (int row = 0; row < 30; ++row) couple(all, 30 * row, 30 * row + 29);
  for (int i : {7, 100, 101, 555}) couple(all, i, 899 - i);
  const Product product(all);
  const DiagonalStorage storage = storage_of(product);
  EXPECT_GE(storage.grouped_rows(), 450);
  EXPECT_LT(product.error_of(storage), rounding);
}

TEST(DiagonalStorage, MultipliesRowsWithNothingInCommonOneByOne) {
  Neighbours all(500);
  Numbers numbers;
  for (int i = 0; i < 500; ++i) {
    for (int k = 0; k < 10; ++k) {
      const int other = static_cast<int>(250 * (1 + numbers.next()));
      if (other != i) couple(all, i, other);
    }
  }
  const Product product(all);
  const DiagonalStorage storage = storage_of(product);
  EXPECT_EQ(storage.grouped_rows(), 0);
  EXPECT_LT(product.error_of(storage), rounding);
}

TEST(DiagonalStorage, MultipliesMatricesOfEverySize) {
  for (int rows = 1; rows <= 40; ++rows) {
    const Product product(image(rows, 1));
    EXPECT_LT(product.error_of(storage_of(product)), rounding) << rows;
  }
  for (int columns = 1; columns <= 80; ++columns) {
    const Product product(image(3, columns));
    EXPECT_LT(product.error_of(storage_of(product)), rounding) << columns;
  }
}

TEST(DiagonalStorage, TakesTheBlocksOfTheLastMatrix) {
  Product product(image(20, 20));
  DiagonalStorage storage = storage_of(product);
  product.fill();
  storage.assign(product.matrix, 1);
  EXPECT_LT(product.error_of(storage), rounding);
}

TEST(DiagonalStorage, GivesTheSameBitsForAnyNumberOfThreads) {
  const Product product(image(40, 33));
  const DiagonalStorage storage = storage_of(product);
  const std::vector<Vec3> one = product.multiplied(storage, 1);
  for (int threads : {2, 3, 8}) EXPECT_EQ(product.multiplied(storage, threads), one) << threads;
}

}  // namespace
}  // namespace weft::sim
