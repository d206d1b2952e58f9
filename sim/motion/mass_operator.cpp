#include "sim/motion/mass_operator.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cassert>

#include "sim/base/parallel.h"
#include "sim/motion/mass_matrix.h"
#include "sim/scene/spline_surface.h"

namespace weft::sim {

namespace {

using Matrix = Eigen::SparseMatrix<double>;

bool has_shells(const Scene& scene) {
  return std::any_of(scene.bodies.begin(), scene.bodies.begin() + scene.dynamic_bodies,
                     [](const SceneBody& body) { return body.spline != nullptr; });
}

}  // namespace

// The Cholesky factor L of M, restricted to the free particles of shells, in a fill-reducing order.
class MassOperator::Factor {
 public:
  Factor(const MassOperator& mass, const BlockPattern& pattern);
  void solve(std::span<Vec3> force);

 private:
  // A vector, padded to four numbers so that one instruction reads all of them.
  using Padded = Eigen::Array4d;

  std::vector<int> unknowns_;  // particles, in the order of the factor
  // L in compressed columns. The diagonal entry is the first of each column.
  std::vector<int> start_, row_;
  std::vector<double> value_;
  std::vector<Padded> x_;
};

MassOperator::Factor::Factor(const MassOperator& mass, const BlockPattern& pattern) {
  const Scene& scene = mass.scene_;
  std::vector<int> number(scene.dynamic_particles, -1), free;
  for (int b = 0; b < scene.dynamic_bodies; ++b) {
    const SceneBody& body = scene.bodies[b];
    for (int i = body.first_particle; i < body.first_particle + body.particle_count(); ++i) {
      if (!body.spline || scene.pinned[i] != 0) continue;
      number[i] = static_cast<int>(free.size());
      free.push_back(i);
    }
  }
  std::vector<Eigen::Triplet<double>> entries;
  for (const int i : free) {
    for (int slot = pattern.diagonal_slot(i); slot < pattern.row_end(i); ++slot) {
      const int column = number[pattern.column(slot)];
      if (column >= 0 && mass.at(i, slot) != 0)
        entries.emplace_back(column, number[i], mass.at(i, slot));
    }
  }
  const auto count = static_cast<Eigen::Index>(free.size());
  Matrix lower(count, count);
  lower.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLLT<Matrix> cholesky(lower);
  assert(count == 0 || cholesky.info() == Eigen::Success);
  const Matrix factor = cholesky.matrixL();
  start_.assign(factor.outerIndexPtr(), factor.outerIndexPtr() + count + 1);
  row_.assign(factor.innerIndexPtr(), factor.innerIndexPtr() + factor.nonZeros());
  value_.assign(factor.valuePtr(), factor.valuePtr() + factor.nonZeros());
  unknowns_.resize(free.size());
  const auto& order = cholesky.permutationP().indices();
  for (Eigen::Index i = 0; i < count; ++i)
    unknowns_[order.size() == 0 ? i : order[i]] = free[static_cast<std::size_t>(i)];
  x_.resize(free.size(), Padded::Zero());
}

void MassOperator::Factor::solve(std::span<Vec3> force) {
  const int count = static_cast<int>(unknowns_.size());
  for (int j = 0; j < count; ++j) x_[j].head<3>() = force[unknowns_[j]].array();
  for (int j = 0; j < count; ++j) {
    const Padded x = x_[j] /= value_[start_[j]];
    for (int k = start_[j] + 1; k < start_[j + 1]; ++k) x_[row_[k]] -= value_[k] * x;
  }
  for (int j = count - 1; j >= 0; --j) {
    Padded sum = x_[j];
    for (int k = start_[j] + 1; k < start_[j + 1]; ++k) sum -= value_[k] * x_[row_[k]];
    x_[j] = sum / value_[start_[j]];
  }
  for (int j = 0; j < count; ++j) force[unknowns_[j]] = x_[j].head<3>().matrix();
}

MassOperator::MassOperator(const Scene& scene, Form form)
    : scene_(scene), is_diagonal_(form == Form::lumped || !has_shells(scene)) {}

MassOperator::~MassOperator() = default;

void MassOperator::add_couplings(std::vector<std::vector<int>>& neighbours) const {
  if (is_diagonal_) return;
  for (int b = 0; b < scene_.dynamic_bodies; ++b) {
    const SceneBody& body = scene_.bodies[b];
    if (!body.spline) continue;
    for (std::size_t p = 0; p < body.spline->patches().size(); ++p) {
      const auto& [u, v] = body.spline->patches()[p];
      for (int element = 0; element < u.elements() * v.elements(); ++element) {
        const std::vector<int> control = body.spline->control_points(
            body.atlas, static_cast<int>(p), element % u.elements(), element / u.elements());
        for (const int i : control) {
          for (const int j : control)
            neighbours[body.first_particle + i].push_back(body.first_particle + j);
        }
      }
    }
  }
}

void MassOperator::attach(std::shared_ptr<const BlockPattern> pattern) {
  pattern_ = std::move(pattern);
  if (is_diagonal_) return;
  entries_.assign(pattern_->upper_count(), 0.0);
  const Matrix mass = mass_matrix(scene_);
  for (int row = 0; row < scene_.dynamic_particles; ++row) {
    for (Matrix::InnerIterator entry(mass, row); entry; ++entry) {
      const int column = static_cast<int>(entry.row());
      if (column >= row)
        entries_[pattern_->upper(row, pattern_->slot(row, column))] = entry.value();
    }
  }
}

Vec3 MassOperator::coupled_product(int row, const Vec3* in) const {
  Vec3 sum = Vec3::Zero();
  for (int slot = pattern_->row_begin(row); slot < pattern_->row_end(row); ++slot)
    sum += entries_[pattern_->upper(row, slot)] * in[pattern_->column(slot)];
  return sum;
}

void MassOperator::multiply(std::span<const Vec3> in, std::span<Vec3> out, int threads) const {
  parallel_chunks(static_cast<int>(in.size()), threads, [&](int first, int last) {
    for (int i = first; i < last; ++i) out[i] = row_product(i, in.data());
  });
}

double MassOperator::product(std::span<const Vec3> a, std::span<const Vec3> b, int threads) const {
  if (is_diagonal_) return mass_product(scene_.mass, a, b);
  return parallel_sum(static_cast<int>(a.size()), threads, [&](int first, int last) {
    double sum = 0;
    for (int i = first; i < last; ++i) sum += a[i].dot(coupled_product(i, b.data()));
    return sum;
  });
}

VibrationProducts MassOperator::vibration(std::span<const Vec3> before, std::span<const Vec3> a,
                                          std::span<const Vec3> after, int threads) const {
  if (is_diagonal_) return vibration_products(scene_.mass, before, a, after);
  std::vector<Vec3> weighted(a.size());
  multiply(a, weighted, threads);
  VibrationProducts sums;
  for (std::size_t i = 0; i < a.size(); ++i) {
    sums.all += weighted[i].dot(a[i]);
    sums.bent += weighted[i].dot(2 * a[i] - before[i] - after[i]);
  }
  return sums;
}

void MassOperator::solve(std::span<Vec3> force) {
  for (int b = 0; b < scene_.dynamic_bodies; ++b) {
    const SceneBody& body = scene_.bodies[b];
    for (int i = body.first_particle; i < body.first_particle + body.particle_count(); ++i) {
      if (scene_.pinned[i] != 0) {
        force[i].setZero();
      } else if (is_diagonal_ || !body.spline) {
        force[i] /= scene_.mass[i];
      }
    }
  }
  if (is_diagonal_) return;
  if (!factor_) factor_ = std::make_unique<Factor>(*this, *pattern_);
  factor_->solve(force);
}

}  // namespace weft::sim
