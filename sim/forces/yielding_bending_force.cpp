// Bending that yields and leaves creases.
#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>

#include "materials/crease.h"
#include "sim/forces/crease_history.h"
#include "sim/forces/force_arrays.h"
#include "sim/forces/linear_bending.h"

namespace weft::sim {

namespace {

using materials::Crease;
using materials::CreaseOf;
using materials::lane_count;
using materials::Lanes;
using materials::Vec3Of;
using materials::YieldLaw;
using materials::YieldLawOf;
using Hinges = QuadBending::Hinges;
using Modulus = QuadBending::Modulus;

// A batch of quads that yield, from the creases with which the step begins (materials/crease.h).
struct YieldingBending : LinearBending {
  static constexpr bool damps_like_stiffness = false;
  std::array<YieldLawOf<Lanes>, 2> laws;
  std::array<CreaseOf<Lanes>, 2> creases;

  // Damping is that of the elastic material: rates do not yield.
  Hinges moments(const Hinges& strains, const Lanes& damping_time, const Hinges& rates) const {
    return QuadBending::sum_of_triangles([&](int t) -> Vec3Of<Lanes> {
      return own[t] *
             (elastic_part(strains, t) + damping_time * QuadBending::of_triangle(rates, t));
    });
  }
  Hinges moments(const Hinges& strains) const {
    return QuadBending::sum_of_triangles([&](int t) { return own[t] * elastic_part(strains, t); });
  }
  Lanes energy(const Hinges& strains) const {
    Lanes sum = 0;
    for (int t = 0; t < 2; ++t) {
      const Vec3Of<Lanes> angles = elastic_part(strains, t);
      sum += 0.5 * materials::dot(angles, own[t] * angles);
    }
    return sum;
  }
  // The slopes of the moments are semi-definite.
  std::array<Modulus, 2> joined(const Hinges& strains, Definiteness /*kind*/, double inverse_gamma,
                                const Lanes& damping_time) const {
    std::array<Modulus, 2> sum;
    for (int t = 0; t < 2; ++t) {
      const Vec3Of<Lanes> trial = trial_of(strains, t), moment = own[t] * trial;
      const materials::YieldedOf<Lanes> response = yielded(t, trial, moment);
      sum[t] = own[t].scaled(response.kept + inverse_gamma * damping_time);
      for (int i = 0; i < 3; ++i) {
        for (int j = i; j < 3; ++j) sum[t](i, j) -= response.drop * moment[i] * moment[j];
      }
    }
    return sum;
  }
  // Returns the crease of triangle t that follows from these strains.
  CreaseOf<Lanes> advanced(const Hinges& strains, int t) const {
    CreaseOf<Lanes> crease = creases[t];
    const Vec3Of<Lanes> trial = trial_of(strains, t);
    const materials::YieldedOf<Lanes> response = yielded(t, trial, own[t] * trial);
    crease.angles += (1.0 - response.kept) * trial;
    crease.curvature += response.flow;
    return crease;
  }

 private:
  Vec3Of<Lanes> trial_of(const Hinges& strains, int t) const {
    return QuadBending::of_triangle(strains, t) - creases[t].angles;
  }
  materials::YieldedOf<Lanes> yielded(int t, const Vec3Of<Lanes>& trial,
                                      const Vec3Of<Lanes>& moment) const {
    return materials::yielded(laws[t], creases[t].curvature, trial, moment);
  }
  Vec3Of<Lanes> elastic_part(const Hinges& strains, int t) const {
    const Vec3Of<Lanes> trial = trial_of(strains, t);
    return yielded(t, trial, own[t] * trial).kept * trial;
  }
};

std::vector<YieldingBending> yielding_batches(const BendingQuads& quads) {
  std::vector<YieldingBending> batches = linear_batches<YieldingBending>(quads);
  for (std::size_t q = 0; q < quads.laws.size(); ++q) {
    for (int t = 0; t < 2; ++t) {
      YieldLawOf<Lanes>& laws = batches[q / lane_count].laws[t];
      laws.compliance.values[q % lane_count] = quads.laws[q][t].compliance;
      laws.yield_curvature.values[q % lane_count] = quads.laws[q][t].yield_curvature;
      laws.hardening_slope.values[q % lane_count] = quads.laws[q][t].hardening_slope;
    }
  }
  return batches;
}
// The bending of bodies that yield. Their creases are those of a history.
class YieldingForce final : public BendingForce<YieldingBending> {
 public:
  YieldingForce(const BendingQuads& quads, const std::vector<Vec3>& rest)
      : BendingForce(quads, yielding_batches(quads), rest),
        bodies_(quads.yielding),
        laws_(quads.laws) {}

  double energy(const Kinematics& state, int threads) override {
    refresh();
    return BendingForce::energy(state, threads);
  }
  void add_forces(const Kinematics& state, std::span<Vec3> force, int threads) override {
    refresh();
    BendingForce::add_forces(state, force, threads);
  }
  void add_derivatives(const Kinematics& state, const Derivatives& into, Definiteness definiteness,
                       int threads) override {
    refresh();
    BendingForce::add_derivatives(state, into, definiteness, threads);
  }

  void use_creases(CreaseHistory& creases) override {
    history_ = &creases;
    version_ = no_version;
  }
  void advance_creases(const Kinematics& state, CreaseHistory& into, int threads) override {
    refresh();
    visit_advanced(state, threads, [&](int body, int triangle, const YieldLaw&, const Crease& now) {
      into.advanced(body)[triangle] = now;
    });
  }
  double dissipated(const Kinematics& state, int /*threads*/) override {
    refresh();
    double sum = 0;
    visit_advanced(state, 1,
                   [&](int /*body*/, int /*triangle*/, const YieldLaw& law, const Crease& now) {
                     sum += law.dissipated(now.curvature);
                   });
    return sum;
  }

 private:
  static constexpr std::int64_t no_version = -1;

  // Reads the selected creases of the history, if they have changed. Without one there are none.
  void refresh() {
    if (history_ == nullptr || version_ == history_->version()) return;
    version_ = history_->version();
    for (const BendingQuads::Body& body : bodies_) {
      const std::span<const Crease> creases = history_->of_body(body.case_body);
      for (int q = body.first; q < body.last; ++q) {
        for (int t = 0; t < 2; ++t) {
          CreaseOf<Lanes>& target = batches()[q / lane_count].creases[t];
          const Crease& crease = creases[2 * (q - body.first) + t];
          for (int i = 0; i < 3; ++i) target.angles[i].values[q % lane_count] = crease.angles[i];
          target.curvature.values[q % lane_count] = crease.curvature;
        }
      }
    }
  }

  // Calls visit(body of the case, triangle, its law, crease) with the creases that follow from a
  // state, for the triangles that yield. With one thread the calls are in order.
  template <class Visit>
  void visit_advanced(const Kinematics& state, int threads, const Visit& visit) {
    parallel_chunks(static_cast<int>(batches().size()), threads, [&](int begin, int end) {
      for (int batch = begin; batch < end; ++batch) {
        const std::array<CreaseOf<Lanes>, 2> now = advanced(batch, state.position);
        for (int lane = 0; lane < lane_count; ++lane)
          visit_quad(lane_count * batch + lane, now, visit);
      }
    });
  }
  template <class Visit>
  void visit_quad(int quad, const std::array<CreaseOf<Lanes>, 2>& creases,
                  const Visit& visit) const {
    const auto body = std::ranges::find_if(
        bodies_, [&](const BendingQuads::Body& each) { return quad < each.last; });
    if (body == bodies_.end()) return;
    const int lane = quad % lane_count;
    for (int t = 0; t < 2; ++t) {
      const YieldLaw& law = laws_[quad][t];
      if (law.compliance == 0) continue;  // at a clamp or seam, which bends it
      Crease crease;
      for (int i = 0; i < 3; ++i) crease.angles[i] = creases[t].angles[i].values[lane];
      crease.curvature = creases[t].curvature.values[lane];
      visit(body->case_body, 2 * (quad - body->first) + t, law, crease);
    }
  }
  WEFT_FLATTEN std::array<CreaseOf<Lanes>, 2> advanced(int batch, std::span<const Vec3> position) {
    const Hinges strains = strains_at(lane_count * batch, position);
    return {batches()[batch].advanced(strains, 0), batches()[batch].advanced(strains, 1)};
  }

  std::vector<BendingQuads::Body> bodies_;
  std::vector<std::array<YieldLaw, 2>> laws_;  // by quad
  CreaseHistory* history_ = nullptr;
  std::int64_t version_ = no_version;  // of the history in the batches
};

}  // namespace

std::unique_ptr<Force> make_yielding_bending_force(const Scene& scene) {
  const BendingQuads quads =
      bending_quads(scene, [](const MaterialCase& material) { return material.yields(); });
  if (quads.nodes.empty()) return nullptr;
  return std::make_unique<YieldingForce>(quads, rest_positions(scene));
}

}  // namespace weft::sim
