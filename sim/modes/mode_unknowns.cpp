#include "sim/modes/mode_unknowns.h"

#include <Eigen/QR>
#include <algorithm>

#include "sim/base/islands.h"
#include "sim/scene/scene.h"
#include "sim/scene/sliding_supports.h"

namespace weft::sim {

namespace {

// Largest component of a unit direction that supports are thought to hold twice.
constexpr double held_twice = 1e-9;

// A support with particles by their indices in the scene.
struct Support {
  int particle = 0, base = -1;  // base -1: no base
  Vec3 direction{0, 0, 0};
};

std::vector<Support> supports_of(const Scene& scene) {
  std::vector<Support> all;
  for (int b = 0; b < scene.dynamic_bodies; ++b) {
    const SceneBody& body = scene.bodies[b];
    if (!body.supports) continue;
    for (const SlidingSupport& each : body.supports->all) {
      all.push_back({body.first_particle + each.particle,
                     each.base < 0 ? -1 : body.first_particle + each.base, each.direction});
    }
  }
  return all;
}

// Supported particles that depend on each other, and the supports that connect them.
struct Island {
  std::vector<int> unknowns;  // first unknown of each free particle
  std::vector<Support> supports;
};

// Returns the islands of free particles. `first` has the first unknown of each dynamic particle, or
// -1 if it is pinned. A particle without supports is an island of its own.
std::vector<Island> islands_of(const std::vector<Support>& supports,
                               const std::vector<int>& first) {
  const int count = static_cast<int>(first.size());
  Islands islands;
  islands.clear(count);
  for (const Support& each : supports) {
    if (each.base >= 0) islands.connect(each.particle, each.base);
  }
  std::vector<Island> all(count);
  for (int i = 0; i < count; ++i) {
    if (first[i] >= 0) all[islands.island_of(i)].unknowns.push_back(first[i]);
  }
  for (const Support& each : supports)
    all[islands.island_of(each.particle)].supports.push_back(each);
  std::erase_if(all, [](const Island& island) { return island.unknowns.empty(); });
  return all;
}

// Returns an orthonormal basis of the displacements of an island's particles that its supports
// allow, one column per unknown.
Eigen::MatrixXd allowed_displacements(const Island& island, const std::vector<int>& first) {
  const auto size = static_cast<Eigen::Index>(3 * island.unknowns.size());
  const auto held = static_cast<Eigen::Index>(island.supports.size());
  if (held == 0) return Eigen::MatrixXd::Identity(size, size);
  Eigen::MatrixXd directions = Eigen::MatrixXd::Zero(size, held);
  for (Eigen::Index s = 0; s < held; ++s) {
    const Support& support = island.supports[s];
    const auto add = [&](int particle, const Vec3& direction) {
      if (particle < 0 || first[particle] < 0) return;
      const auto at = std::ranges::find(island.unknowns, first[particle]) - island.unknowns.begin();
      directions.col(s).segment<3>(3 * at) += direction;
    };
    add(support.particle, support.direction);
    add(support.base, -support.direction);
  }
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> factors(directions);
  factors.setThreshold(held_twice);
  const Eigen::MatrixXd all = factors.householderQ();
  return all.rightCols(size - factors.rank());
}

}  // namespace

ModeUnknowns::ModeUnknowns(const Scene& scene) : free_(scene) {
  const std::vector<Support> supports = supports_of(scene);
  if (supports.empty()) return;
  std::vector<int> first(scene.dynamic_particles, -1);
  for (Eigen::Index i = 0; i < free_.count(); i += 3)
    first[free_.particle(i)] = static_cast<int>(i);
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::Index count = 0;
  for (const Island& island : islands_of(supports, first)) {
    const Eigen::MatrixXd allowed = allowed_displacements(island, first);
    for (Eigen::Index column = 0; column < allowed.cols(); ++column, ++count) {
      for (Eigen::Index row = 0; row < allowed.rows(); ++row) {
        if (allowed(row, column) == 0) continue;
        entries.emplace_back(island.unknowns[row / 3] + row % 3, count, allowed(row, column));
      }
    }
  }
  basis_.emplace(free_.count(), count);
  basis_->setFromTriplets(entries.begin(), entries.end());
}

int ModeUnknowns::particle(Eigen::Index unknown) const {
  if (!basis_) return free_.particle(unknown);
  Eigen::Index farthest = 0;
  double largest = -1;
  for (Matrix::InnerIterator each(*basis_, unknown); each; ++each) {
    if (std::abs(each.value()) <= largest) continue;
    largest = std::abs(each.value());
    farthest = each.row();
  }
  return free_.particle(farthest);
}

ModeUnknowns::Vector ModeUnknowns::gather(std::span<const Vec3> of_particles) const {
  const Vector of_free = free_.gather(of_particles);
  return basis_ ? Vector(basis_->transpose() * of_free) : of_free;
}

void ModeUnknowns::scatter(const Vector& values, std::span<Vec3> of_particles) const {
  free_.scatter(basis_ ? Vector(*basis_ * values) : values, of_particles);
}

ModeUnknowns::Matrix ModeUnknowns::restricted(const Matrix& of_free) const {
  if (!basis_) return of_free;
  const Matrix whole = of_free.selfadjointView<Eigen::Lower>();
  const Matrix product = basis_->transpose() * Matrix(whole * *basis_);
  return product.triangularView<Eigen::Lower>();
}

std::optional<ModeUnknowns::Matrix> ModeUnknowns::stiffness(Dynamics& dynamics, double time,
                                                            std::span<const double> state,
                                                            std::string& fault) const {
  // Contacts contribute K + D / gamma. With this large gamma (s), their damping is negligible.
  constexpr double contact_gamma = 1e6;
  std::vector<Vec3> force(dynamics.particle_count());
  if (const auto found = dynamics.net_forces(time, state, force)) {
    fault = found->describe(dynamics.scene());
    return std::nullopt;
  }
  dynamics.leave_out_supports(true);
  dynamics.assemble(time, state);
  dynamics.leave_out_supports(false);
  return restricted(free_.stiffness(dynamics, contact_gamma));
}

ModeUnknowns::Matrix ModeUnknowns::mass(const Matrix& of_particles) const {
  return restricted(free_.mass(of_particles));
}

}  // namespace weft::sim
