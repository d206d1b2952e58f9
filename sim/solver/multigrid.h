// Geometric multigrid on the images: one V(1,1) cycle as a preconditioner.
#pragma once

#include <Eigen/SparseCholesky>
#include <memory>
#include <vector>

#include "sim/solver/galerkin_product.h"
#include "sim/solver/gauss_seidel.h"
#include "sim/solver/preconditioner.h"

namespace weft::sim {

// Coarse matrices are P^T A P level by level; a forward block Gauss-Seidel sweep before and a
// backward one after each coarse correction; sparse Cholesky on the coarsest level.
//
// The finest level always works with the current A, the coarse ones with that of the last
// set_up(): the cycle stays symmetric and positive definite however old these are.
class Multigrid : public Preconditioner {
 public:
  // Finds the coarse images and patterns. O(blocks).
  Multigrid(const Scene& scene, const BlockPattern& pattern);

  // Forms the coarse matrices. False where one of them is not positive definite; the cycle must
  // then not be used. O(blocks).
  [[nodiscard]] bool set_up(const VelocityMatrix& matrix);
  // Inverts the finest diagonal.
  bool update(const VelocityMatrix& matrix) override;
  void apply(const VelocityMatrix& matrix, std::span<const Vec3> r, std::span<Vec3> z) override;

  int level_count() const { return static_cast<int>(coarse_.size()) + 1; }

 private:
  // Of the coarse levels. Sums are in double; single precision of the entries is enough here.
  using CoarseMatrix = BlockMatrixOf<float>;
  struct Level {
    Level(Prolongation from_coarse, std::shared_ptr<const BlockPattern> pattern);

    Prolongation prolongation;  // to the next finer level
    CoarseMatrix matrix;
    GaussSeidel sweeps;
    std::vector<Mat3> inverse_diagonal;
    std::vector<Vec3> b, x, residual;
  };

  void add_contact(const VelocityMatrix& matrix, Level& level) const;
  bool factor_coarsest();
  void solve_coarsest();
  void correct_from(std::size_t level, int threads);
  void cycle(std::size_t level, int threads);

  GaussSeidel sweeps_;
  std::vector<Mat3> inverse_diagonal_;
  std::vector<Vec3> residual_;
  std::vector<Level> coarse_;
  Eigen::SparseMatrix<double> coarsest_;
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> cholesky_;
  bool analysed_ = false;
};

}  // namespace weft::sim
