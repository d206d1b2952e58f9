// Geometric multigrid on the images: one V(1,1) cycle as a preconditioner.
#pragma once

#include <Eigen/SparseCholesky>
#include <memory>
#include <vector>

#include "sim/solver/galerkin_product.h"
#include "sim/solver/gauss_seidel.h"
#include "sim/solver/preconditioner.h"

namespace weft::sim {

// Coarse matrices are P^T A P level by level. A forward block Gauss-Seidel sweep precedes each
// coarse correction and a backward one follows it; the coarsest level is solved by sparse Cholesky.
// Matrices hold their upper halves in single precision, and sums are in double: the memory traffic
// is a quarter, and the iterations stay the same.
//
// Contact pairs are couplings like any other, in the sweeps and in the coarse matrices: with each
// set-up in which there are some, all patterns are found anew (docs/decisions/0015).
//
// Without contact the finest level uses the current A; with contact it uses that of the last
// set_up(), as the coarse levels always do. The cycle is symmetric and positive definite however
// old that is.
class Multigrid : public Preconditioner {
 public:
  // Finds the coarse images and patterns. The finest `w_cycle_levels` levels make W-cycles: each
  // takes two cycles of the next level instead of one. O(blocks).
  Multigrid(const Scene& scene, std::shared_ptr<const BlockPattern> pattern,
            std::size_t w_cycle_levels);
  // Chooses the fastest number of levels with W-cycles: two on fine images and for equilibria, none
  // elsewhere (docs/decisions/0015).
  Multigrid(const Scene& scene, const std::shared_ptr<const BlockPattern>& pattern);

  // Takes over A on all levels. False where a diagonal block, or the coarsest matrix, is not
  // positive definite; the cycle must then not be used. O(blocks).
  [[nodiscard]] bool set_up(const VelocityMatrix& matrix);
  // Takes over A on the finest level. Precondition: a set_up() that returned true.
  [[nodiscard]] bool update(const VelocityMatrix& matrix) override;
  void apply(const VelocityMatrix& matrix, std::span<const Vec3> r, std::span<Vec3> z) override;
  // Empty with contact, where the finest matrix may be an old one.
  std::span<const Vec3> residual() const override {
    return with_contact_ ? std::span<const Vec3>() : residual_;
  }

  int level_count() const { return static_cast<int>(levels_.size()); }

 private:
  struct Level {
    explicit Level(const std::shared_ptr<const BlockPattern>& pattern);

    SingleBlockMatrix matrix;
    GaussSeidel sweeps;
    std::vector<Mat3> inverse_diagonal;
    std::vector<Vec3> b, x;  // of the coarse levels
  };

  void find_patterns(std::shared_ptr<const BlockPattern> finest);
  bool take_finest(const VelocityMatrix& matrix);
  bool factor_coarsest();
  void solve_coarsest();
  void cycle(std::size_t level, std::span<const Vec3> b, std::span<Vec3> x, int threads);
  void correct(std::size_t level, std::span<const Vec3> b, std::span<Vec3> x, int threads);
  void find_residual(std::size_t level, std::span<Vec3> residual, int threads);

  std::shared_ptr<const BlockPattern> pattern_;  // without contact
  bool with_contact_ = false;                    // the levels' patterns
  std::vector<Level> levels_;                    // from the finest
  std::vector<Prolongation> prolongations_;      // of level i + 1 to level i
  std::vector<GalerkinProduct> products_;        // the matrix of level i + 1 from that of level i
  std::vector<Vec3> residual_;                   // of the level at work
  std::vector<Vec3> change_;                     // by the last backward sweep
  std::size_t w_cycle_levels_;                   // from the finest
  std::int64_t version_ = -1;                    // of A
  Eigen::SparseMatrix<double> coarsest_;
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> cholesky_;
  bool analysed_ = false;
};

}  // namespace weft::sim
