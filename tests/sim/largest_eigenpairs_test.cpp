// Eigenpairs of sparse matrices against dense solutions, and matrices with many equal eigenvalues.
#include <cmath>
#include <random>

#include "sim/modes/largest_eigenpairs.h"
#include "tests/dense_algebra.h"

namespace weft::sim::largest_eigenpairs_test {
namespace {

using Matrix = Eigen::SparseMatrix<double>;
using Vector = Eigen::VectorXd;

// The Laplacian of a square grid: most of its eigenvalues are double.
Matrix laplacian(int side, double diagonal = 4) {
  Matrix matrix(side * side, side * side);
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < side * side; ++i) {
    entries.emplace_back(i, i, diagonal);
    if (i % side > 0) {
      entries.emplace_back(i, i - 1, -1);
      entries.emplace_back(i - 1, i, -1);
    }
    if (i >= side) {
      entries.emplace_back(i, i - side, -1);
      entries.emplace_back(i - side, i, -1);
    }
  }
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

Matrix random_symmetric(int size, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> number(-1, 1);
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < size; ++i) {
    entries.emplace_back(i, i, number(random));
    for (const int j : {(i + 1) % size, (7 * i + 3) % size}) {
      const double value = number(random);
      entries.emplace_back(i, j, value);
      entries.emplace_back(j, i, value);
    }
  }
  Matrix matrix(size, size);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

std::vector<Eigenpair> solve(const Matrix& a, const Matrix& f, int count) {
  SymmetricFactors factors;
  EXPECT_TRUE(factors.factorise(f));
  EXPECT_EQ(factors.negative_pivots(), 0);
  auto pairs = largest_eigenpairs(a, f, factors, count);
  EXPECT_TRUE(pairs);
  return pairs.value_or(std::vector<Eigenpair>{});
}

void expect_solutions(const Matrix& a, const Matrix& f, const std::vector<Eigenpair>& pairs) {
  const Vector dense = eigenvalues(Eigen::MatrixXd(a), Eigen::MatrixXd(f));
  std::vector<double> values(dense.begin(), dense.end());
  std::ranges::sort(values, std::ranges::greater{}, [](double x) { return std::abs(x); });
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    EXPECT_NEAR(std::abs(pairs[i].value), std::abs(values[i]), 1e-10 * std::abs(values[0])) << i;
    const Vector residual = a * pairs[i].vector - pairs[i].value * (f * pairs[i].vector);
    EXPECT_LT(residual.norm(), 1e-9 * (a * pairs[0].vector).norm()) << i;
    for (std::size_t j = 0; j <= i; ++j)
      EXPECT_NEAR(pairs[i].vector.dot(f * pairs[j].vector), i == j ? 1 : 0, 1e-9) << i << ' ' << j;
  }
}

TEST(LargestEigenpairs, AreThoseOfADenseSolver) {
  for (const int count : {1, 4, 11}) {
    const Matrix a = random_symmetric(120, 5), f = laplacian(11, 5).topLeftCorner(120, 120);
    const std::vector<Eigenpair> pairs = solve(a, f, count);
    ASSERT_EQ(std::ssize(pairs), count);
    expect_solutions(a, f, pairs);
  }
}

TEST(LargestEigenpairs, ReadOnlyTheLowerHalves) {
  const Matrix a = random_symmetric(120, 5), f = laplacian(11, 5).topLeftCorner(120, 120);
  const Matrix lower_a = a.triangularView<Eigen::Lower>(),
               lower_f = f.triangularView<Eigen::Lower>();
  const auto whole = solve(a, f, 5), half = solve(lower_a, lower_f, 5);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(whole[i].value, half[i].value);
}

TEST(LargestEigenpairs, HaveAllCopiesOfMultipleValues) {
  const Matrix f = laplacian(20), a = Matrix(Vector::Ones(400).asDiagonal());
  for (const int count : {2, 3, 6, 12}) expect_solutions(a, f, solve(a, f, count));
  // Five uncoupled copies of one matrix: each value comes five times.
  const Matrix one = laplacian(6, 4.1);
  std::vector<Eigen::Triplet<double>> entries;
  for (int copy = 0; copy < 5; ++copy) {
    for (int column = 0; column < 36; ++column) {
      for (Matrix::InnerIterator each(one, column); each; ++each)
        entries.emplace_back(36 * copy + each.row(), 36 * copy + column, each.value());
    }
  }
  Matrix copies(180, 180);
  copies.setFromTriplets(entries.begin(), entries.end());
  const Matrix identity = Matrix(Vector::Ones(180).asDiagonal());
  expect_solutions(identity, copies, solve(identity, copies, 12));
}

TEST(LargestEigenpairs, AreAllOfASmallMatrix) {
  const Matrix a = random_symmetric(9, 3), f = laplacian(3, 5);
  const std::vector<Eigenpair> pairs = solve(a, f, 30);
  EXPECT_EQ(pairs.size(), 9U);
  expect_solutions(a, f, pairs);
}

TEST(LargestEigenpairs, AreNoneOfZero) {
  EXPECT_TRUE(solve(Matrix(121, 121), laplacian(11, 5), 3).empty());
}

// Spectra's own test of convergence is absolute below 4e-11.
TEST(LargestEigenpairs, DependOnNoUnit) {
  const Matrix a = random_symmetric(120, 5), f = laplacian(11, 5).topLeftCorner(120, 120);
  const auto pairs = solve(a, f, 4), small = solve(1e-20 * a, f, 4);
  for (int i = 0; i < 4; ++i)
    EXPECT_NEAR(1e20 * small[i].value, pairs[i].value, 1e-10 * std::abs(pairs[0].value));
}

TEST(SymmetricFactors, CountNegativeDirectionsAndNameTheWeakest) {
  const Matrix one = Matrix(Vector::Ones(400).asDiagonal());
  const Vector dense = eigenvalues(Eigen::MatrixXd(laplacian(20)));
  SymmetricFactors factors;
  // A limit of 3 is an eigenvalue of two neighbours alone, whose pivot vanishes without pivoting.
  for (const double limit : {0.03, 0.5, 2.9}) {
    ASSERT_TRUE(factors.factorise(laplacian(20) - limit * one));
    EXPECT_EQ(factors.negative_pivots(), (dense.array() < limit).count());
  }
  Matrix singular = laplacian(20);
  for (const int i : {136, 138, 117, 157})
    singular.coeffRef(137, i) = singular.coeffRef(i, 137) = 0;
  singular.coeffRef(137, 137) = 0;
  EXPECT_FALSE(factors.factorise(singular));
  EXPECT_EQ(factors.weakest(), 137);
}

TEST(SymmetricFactors, RootsMakeTheMatrix) {
  const Matrix f = laplacian(11, 5);
  SymmetricFactors factors;
  ASSERT_TRUE(factors.factorise(f));
  const Vector x = Vector::LinSpaced(121, -1, 2);
  // R^-1 F R^-T = 1, and R^-T R^-1 = F^-1.
  EXPECT_LT((factors.solve_root(f * factors.solve_transposed_root(x)) - x).norm(), 1e-12);
  EXPECT_LT((factors.solve_transposed_root(factors.solve_root(x)) - factors.solve(x)).norm(),
            1e-12);
}

}  // namespace
}  // namespace weft::sim::largest_eigenpairs_test
