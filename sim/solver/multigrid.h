// Geometric multigrid on the images: one cycle, V(1,1) or W(1,1), as a preconditioner.
#pragma once

#include <Eigen/SparseCholesky>
#include <memory>
#include <vector>

#include "sim/base/state_archive.h"
#include "sim/solver/galerkin_product.h"
#include "sim/solver/gauss_seidel.h"
#include "sim/solver/preconditioner.h"

namespace weft::sim {

// The coarse matrices are P^T A P, level by level. A forward block Gauss-Seidel sweep precedes each
// coarse correction, and a backward sweep follows it. Sparse Cholesky solves the coarsest level.
// Matrices hold their upper halves in single precision, which quarters the memory traffic. Sums are
// formed in double, which keeps the number of iterations of double matrices.
//
// Contact pairs enter the sweeps and the coarse matrices like any other coupling. The patterns of
// all levels are found again only if a pair couples particles that they do not couple yet. They
// keep the couplings of earlier pairs, until these have made the finest pattern half as large again
// as it must be (docs/decisions/0015).
//
// If the last set_up() was without contact, the finest level uses the current A, without contact.
// Otherwise it uses the A of the last set_up(), as the coarse levels always do. The cycle is
// symmetric and positive definite even with outdated matrices.
class Multigrid : public Preconditioner {
 public:
  // Finds the coarse images and patterns. On the finest `w_cycle_levels` levels, two cycles of the
  // next level are run instead of one, unless that is the coarsest. O(blocks).
  Multigrid(const Scene& scene, std::shared_ptr<const BlockPattern> pattern,
            std::size_t w_cycle_levels);
  // Chooses the number of W-cycle levels: two for 100 000 particles or more and for equilibria,
  // otherwise zero (docs/decisions/0015).
  Multigrid(const Scene& scene, const std::shared_ptr<const BlockPattern>& pattern);

  // Forms the matrices of all levels from A. Returns false if a diagonal block or the coarsest
  // matrix is not positive definite; apply() must then not be called. Costs O(blocks) and a
  // factorisation of the coarsest matrix.
  [[nodiscard]] bool set_up(const VelocityMatrix& matrix);
  // Copies A to the finest level, unless the matrices include contact or A is unchanged. Returns
  // false if a diagonal block is not positive definite. Precondition: the last set_up() returned
  // true.
  [[nodiscard]] bool update(const VelocityMatrix& matrix) override;
  // True if the last set_up() was with contact.
  bool has_contact() const { return with_contact_; }
  double apply(const VelocityMatrix& matrix, std::span<const Vec3> r, std::span<Vec3> z) override;
  // Returns nothing if the last set_up() was with contact, because the finest matrix may then be
  // outdated.
  std::span<const Vec3> residual() const override {
    return with_contact_ ? std::span<const Vec3>() : residual_;
  }

  // Writes or reads the couplings that earlier contact pairs have left in the patterns. The order
  // of the sweeps depends on them. Reading makes the patterns; set_up() must follow.
  void transfer_patterns(StateArchive& archive);
  // Writes or reads the finest matrix of a set_up() with contact, from which reading forms the
  // others. Returns false as set_up() does. The `matrix` tells which particles are pinned.
  [[nodiscard]] bool transfer_finest(StateArchive& archive, const VelocityMatrix& matrix);

  int level_count() const { return static_cast<int>(levels_.size()); }

 private:
  struct Level {
    explicit Level(const std::shared_ptr<const BlockPattern>& pattern);

    SingleBlockMatrix matrix;
    GaussSeidel sweeps;
    std::vector<Mat3> inverse_diagonal;
    std::vector<Vec3> b, x;  // right-hand side and solution; on coarse levels only
  };

  void find_patterns(std::shared_ptr<const BlockPattern> finest);
  void choose_patterns(const VelocityMatrix& matrix);
  bool take_finest(const VelocityMatrix& matrix);
  bool invert_finest(const VelocityMatrix& matrix);
  bool form_coarse(int threads);
  bool factor_coarsest();
  void solve_coarsest();
  void cycle(std::size_t level, std::span<const Vec3> b, std::span<Vec3> x, int threads);
  void correct(std::size_t level, std::span<const Vec3> b, std::span<Vec3> x, int threads);
  void find_residual(std::size_t level, std::span<Vec3> residual, int threads);

  std::shared_ptr<const BlockPattern> pattern_;  // pattern of A without contact
  bool with_contact_ = false;  // true if the matrices of the levels include contact pairs
  std::vector<Level> levels_;  // finest first
  std::vector<Prolongation> prolongations_;  // entry i interpolates from level i + 1 to level i
  // Entry i forms the matrix of level i + 1 from the matrix of level i.
  std::vector<GalerkinProduct> products_;
  std::vector<Vec3> residual_;  // residual on the level in progress
  std::vector<Vec3> change_;    // change of x in the last backward sweep
  std::size_t w_cycle_levels_;  // number of finest levels that run two coarse cycles
  std::int64_t version_ = -1;   // VelocityMatrix::version() of the A on the finest level
  Eigen::SparseMatrix<double> coarsest_;
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> cholesky_;
  bool analysed_ = false;
};

}  // namespace weft::sim
