#include "materials/bending.h"

#include <algorithm>

#include "materials/crease.h"
#include "sim/base/parallel.h"
#include "sim/forces/crease_history.h"
#include "sim/forces/force_arrays.h"
#include "sim/forces/quad_hinges.h"
#include "sim/forces/quads.h"
#include "sim/forces/stencil_array.h"
#include "sim/forces/varying_numbers.h"
#include "sim/scene/scene.h"

namespace weft::sim {

namespace {

using materials::Crease;
using materials::CreaseOf;
using materials::lane_count;
using materials::Lanes;
using materials::Mat3;
using materials::Mat3Of;
using materials::Nodes3;
using materials::NodesOf;
using materials::Vec3Of;
using materials::YieldLaw;
using materials::YieldLawOf;

using Surroundings = std::array<int, QuadSurroundings::count>;

struct BendingQuads {
  std::vector<Surroundings> nodes;
  std::vector<std::array<Mat3, 2>> moduli;  // of both triangles, over the hinges of each
  std::vector<std::array<YieldLaw, 2>> laws;  // of both triangles
  // Bodies with the number of the first quad of each.
  struct Body {
    int case_body = 0;
    int first = 0, last = 0;  // quads
    bool yields = false;
  };
  std::vector<Body> bodies;
  VaryingNumbers damping_times;             // s
  bool is_damped = false;                   // at any time
};

// The symmetric matrix C of a triangle, row by row from its diagonal.
struct Modulus {
  std::array<Lanes, 6> entries;

  static constexpr int index(int i, int j) {
    return i <= j ? materials::StencilMatrix<Lanes, 3>::index(i, j) : index(j, i);
  }
  const Lanes& operator()(int i, int j) const { return entries[index(i, j)]; }
  Modulus scaled(const Lanes& factor) const {
    Modulus result = *this;
    for (Lanes& entry : result.entries) entry *= factor;
    return result;
  }
  Modulus plus(const Modulus& other) const {
    Modulus result = *this;
    for (int i = 0; i < 6; ++i) result.entries[i] += other.entries[i];
    return result;
  }
  // Returns C - factor a a^T.
  Modulus less_square(const Lanes& factor, const Vec3Of<Lanes>& a) const {
    Modulus result = *this;
    for (int i = 0; i < 3; ++i) {
      for (int j = i; j < 3; ++j) result.entries[index(i, j)] -= factor * a[i] * a[j];
    }
    return result;
  }
  Vec3Of<Lanes> operator*(const Vec3Of<Lanes>& a) const {
    const auto& c = entries;
    return {c[0] * a[0] + c[1] * a[1] + c[2] * a[2], c[1] * a[0] + c[3] * a[1] + c[4] * a[2],
            c[2] * a[0] + c[4] * a[1] + c[5] * a[2]};
  }
};

using Slopes = QuadSlopes<Lanes>;
using Nodes = Slopes::Nodes;
using Hinges = Slopes::Hinges;  // one number per hinge
using HingeVectors = std::array<materials::HingeVectorsOf<Lanes>, hinge_count>;

using Moduli = std::array<Modulus, 2>;  // of both triangles

// The plasticity of a batch of quads, by triangle.
struct CreasedBatch {
  std::array<YieldLawOf<Lanes>, 2> laws;
  std::array<CreaseOf<Lanes>, 2> creases;  // from which the step begins
};

// The moduli and rest angles of a batch of quads.
struct BendingBatch {
  Moduli moduli;
  Hinges rest_angles;

  Hinges strains(const HingeVectors& hinges) const {
    Hinges strains;
    for (int h = 0; h < hinge_count; ++h)
      strains[h] = materials::hinge_angle(hinges[h]) - rest_angles[h];
    return strains;
  }
  // Returns dW/d theta, N m. W is the energy of the quad's own triangles; those beyond its sides
  // add their own share of the sides' moments.
  Hinges moments(const Hinges& strains) const {
    Hinges sum;
    sum.fill(0);
    for (int t = 0; t < 2; ++t) add_moments(t, of_triangle(strains, t), sum);
    return sum;
  }
  Lanes energy(const Hinges& strains) const {
    Lanes sum = 0;
    for (int t = 0; t < 2; ++t) sum += energy_of(t, of_triangle(strains, t));
    return sum;
  }

  // The same of a material that yields. `rates` are changes of the strains that do not yield.
  Hinges moments(const CreasedBatch& creased, const Hinges& strains, const Hinges& rates) const {
    Hinges sum;
    sum.fill(0);
    for (int t = 0; t < 2; ++t)
      add_moments(t, elastic_part(creased, strains, t) + of_triangle(rates, t), sum);
    return sum;
  }
  Lanes energy(const CreasedBatch& creased, const Hinges& strains) const {
    Lanes sum = 0;
    for (int t = 0; t < 2; ++t) sum += energy_of(t, elastic_part(creased, strains, t));
    return sum;
  }
  // Returns the slopes of the moments by the strains.
  Moduli slopes(const CreasedBatch& creased, const Hinges& strains) const {
    Moduli result;
    for (int t = 0; t < 2; ++t) {
      const Vec3Of<Lanes> trial = trial_of(creased, strains, t), moment = moduli[t] * trial;
      const auto response = yielded(creased, t, trial, moment);
      result[t] = moduli[t].scaled(response.kept).less_square(response.drop, moment);
    }
    return result;
  }
  // Returns the crease of a triangle that follows from these strains.
  CreaseOf<Lanes> advanced(const CreasedBatch& creased, const Hinges& strains, int t) const {
    CreaseOf<Lanes> crease = creased.creases[t];
    const Vec3Of<Lanes> trial = trial_of(creased, strains, t);
    const auto response = yielded(creased, t, trial, moduli[t] * trial);
    crease.angles += (1.0 - response.kept) * trial;
    crease.curvature += response.flow;
    return crease;
  }

 private:
  static Vec3Of<Lanes> of_triangle(const Hinges& numbers, int t) {
    const auto& hinges = hinged_triangles[t].hinges;
    return {numbers[hinges[0]], numbers[hinges[1]], numbers[hinges[2]]};
  }
  void add_moments(int t, const Vec3Of<Lanes>& strains, Hinges& sum) const {
    const Vec3Of<Lanes> own = moduli[t] * strains;
    for (int i = 0; i < 3; ++i) sum[hinged_triangles[t].hinges[i]] += own[i];
  }
  Lanes energy_of(int t, const Vec3Of<Lanes>& strains) const {
    return 0.5 * materials::dot(strains, moduli[t] * strains);
  }
  static Vec3Of<Lanes> trial_of(const CreasedBatch& creased, const Hinges& strains, int t) {
    return of_triangle(strains, t) - creased.creases[t].angles;
  }
  static materials::YieldedOf<Lanes> yielded(const CreasedBatch& creased, int t,
                                             const Vec3Of<Lanes>& trial,
                                             const Vec3Of<Lanes>& moment) {
    return materials::yielded(creased.laws[t], creased.creases[t].curvature, trial, moment);
  }
  Vec3Of<Lanes> elastic_part(const CreasedBatch& creased, const Hinges& strains, int t) const {
    const Vec3Of<Lanes> trial = trial_of(creased, strains, t);
    return yielded(creased, t, trial, moduli[t] * trial).kept * trial;
  }
};

HingeVectors hinge_vectors(const Nodes& x) {
  HingeVectors vectors;
  for (int h = 0; h < hinge_count; ++h) {
    NodesOf<Lanes, 4> nodes;
    for (int k = 0; k < 4; ++k) nodes.col(k) = x.col(hinge_nodes[h][k]);
    vectors[h] = materials::hinge_vectors(nodes);
  }
  return vectors;
}

// The blocks of factor * B^T C B, where B = d theta / d x.
class ElasticBlocks {
 public:
  ElasticBlocks(const BendingBatch& batch, const Slopes& slopes, const Lanes& factor)
      : ElasticBlocks({batch.moduli[0].scaled(factor), batch.moduli[1].scaled(factor)}, slopes) {}
  ElasticBlocks(const Moduli& moduli, const Slopes& slopes) : moduli_(moduli), slopes_(slopes) {
    multiply<0>();
    multiply<1>();
  }

  template <int a, int b>
  Mat3Of<Lanes> block() const {
    Mat3Of<Lanes> sum = Mat3Of<Lanes>::Zero();
    add<0, a, b>(sum);
    add<1, a, b>(sum);
    return sum;
  }

 private:
  template <int t>
  void multiply() {
    const auto of_node = [&]<int a>(std::integral_constant<int, a>) {
      constexpr int node = hinged_triangles[t].nodes[a];
      const Vec3Of<Lanes> g0 = slopes_.of<t, 0, node>(), g1 = slopes_.of<t, 1, node>(),
                          g2 = slopes_.of<t, 2, node>();
      for (int i = 0; i < 3; ++i) {
        const Modulus& modulus = moduli_[t];
        products_[t][i][a] = modulus(i, 0) * g0 + modulus(i, 1) * g1 + modulus(i, 2) * g2;
      }
    };
    of_node(std::integral_constant<int, 0>());
    of_node(std::integral_constant<int, 1>());
    of_node(std::integral_constant<int, 2>());
  }

  // The angle of a triangle's edge depends on the triangle's nodes and on the node across the edge.
  template <int t, int a, int b>
  void add(Mat3Of<Lanes>& sum) const {
    constexpr HingedTriangle triangle = hinged_triangles[t];
    constexpr int own_a = triangle.own(a), own_b = triangle.own(b);
    constexpr int across_a = triangle.across(a), across_b = triangle.across(b);
    const auto& products = products_[t];
    if constexpr (own_a >= 0 && own_b >= 0) {
      sum += materials::outer(slopes_.of<t, 0, a>(), products[0][own_b]);
      sum += materials::outer(slopes_.of<t, 1, a>(), products[1][own_b]);
      sum += materials::outer(slopes_.of<t, 2, a>(), products[2][own_b]);
    } else if constexpr (own_a >= 0 && across_b >= 0) {
      sum += materials::outer(products[across_b][own_a], slopes_.of<t, across_b, b>());
    } else if constexpr (across_a >= 0 && own_b >= 0) {
      sum += materials::outer(slopes_.of<t, across_a, a>(), products[across_a][own_b]);
    } else if constexpr (across_a >= 0 && across_b >= 0) {
      const Vec3Of<Lanes> product = moduli_[t](across_a, across_b) * slopes_.of<t, across_a, a>();
      sum += materials::outer(product, slopes_.of<t, across_b, b>());
    }
  }

  Moduli moduli_;
  const Slopes& slopes_;
  Vec3Of<Lanes> products_[2][3][3];  // C d theta / d x: [triangle][hinge][own node]
};

// The blocks of sum_h moment_h d^2 theta_h / dx dx, from the quad's triangles and those beyond its
// sides.
class StressBlocks {
 public:
  StressBlocks(const Nodes& x, const Hinges& moments)
      : parts_{of_own(x, moments, 0),    of_own(x, moments, 1),    of_beyond(x, moments, 1),
               of_beyond(x, moments, 2), of_beyond(x, moments, 3), of_beyond(x, moments, 4)} {}

  template <int a, int b>
  void add(Mat3Of<Lanes>& sum) const {
    add_part<0, a, b>(sum);
    add_part<1, a, b>(sum);
    add_part<2, a, b>(sum);
    add_part<3, a, b>(sum);
    add_part<4, a, b>(sum);
    add_part<5, a, b>(sum);
  }

 private:
  using Stress = materials::HingeStress<Lanes>;

  static constexpr std::array<int, 3> nodes_of(int part) {
    if (part < 2) return hinged_triangles[part].nodes;
    const auto& nodes = hinge_nodes[part - 1];
    return {nodes[1], nodes[0], nodes[3]};
  }
  template <int part, int a, int b>
  void add_part(Mat3Of<Lanes>& sum) const {
    constexpr HingedTriangle triangle{nodes_of(part), {}};
    constexpr int row = triangle.own(a), column = triangle.own(b);
    if constexpr (row >= 0 && column >= 0) sum += parts_[part].block(row, column);
  }

  static NodesOf<Lanes, 3> nodes(const Nodes& x, const std::array<int, 3>& places) {
    NodesOf<Lanes, 3> nodes;
    for (int i = 0; i < 3; ++i) nodes.col(i) = x.col(places[i]);
    return nodes;
  }
  static Stress of_own(const Nodes& x, const Hinges& moments, int t) {
    const HingedTriangle& triangle = hinged_triangles[t];
    Stress stress(nodes(x, triangle.nodes), 0, moments[triangle.hinges[0]]);
    stress.add(1, moments[triangle.hinges[1]]);
    stress.add(2, moments[triangle.hinges[2]]);
    return stress;
  }
  static Stress of_beyond(const Nodes& x, const Hinges& moments, int hinge) {
    return Stress(nodes(x, nodes_of(hinge + 1)), 2, moments[hinge]);
  }

  std::array<Stress, 6> parts_;
};

class BendingForce final : public Force {
 public:
  BendingForce(const BendingQuads& quads, const std::vector<Vec3>& rest)
      : quads_(quads.nodes, static_cast<int>(rest.size())),
        varying_times_(quads.damping_times),
        damping_times_(varying_times_.numbers()),
        is_damped_(quads.is_damped),
        bodies_(quads.bodies) {
    batches_.resize((quads.nodes.size() + lane_count - 1) / lane_count);
    for (std::size_t q = 0; q < lane_count * batches_.size(); ++q) {
      for (int t = 0; t < 2; ++t) {
        const Mat3 modulus = q < quads.moduli.size() ? quads.moduli[q][t] : Mat3(Mat3::Zero());
        auto& entries = batches_[q / lane_count].moduli[t].entries;
        for (int i = 0; i < 3; ++i) {
          for (int j = i; j < 3; ++j)
            entries[Modulus::index(i, j)].values[q % lane_count] = modulus(i, j);
        }
      }
    }
    // Rest angles are computed by the operations that later compute angles: a body at rest then
    // feels no force at all.
    quads_.for_each_batch(1, [&](int first) {
      BendingBatch& batch = batches_[first / lane_count];
      batch.rest_angles.fill(0);
      batch.rest_angles = batch.strains(hinge_vectors(quads_.gather(first, rest)));
    });
    set_laws(quads);
  }

  std::string_view name() const override { return "bending"; }
  bool has_damping() const override { return is_damped_; }
  bool varies() const override { return varying_times_.varies(); }
  void set_time(const Instant& now) override { varying_times_.update(now, damping_times_); }
  double evaluation_work() const override { return 1.2; }

  double energy(const Kinematics& state, int threads) override {
    refresh_creases();
    return parallel_sum(static_cast<int>(batches_.size()), threads, [&](int first, int last) {
      Lanes sum = 0;
      for (int batch = first; batch < last; ++batch)
        sum += batch_energy(lane_count * batch, state.position);
      return materials::sum_of_lanes(sum);
    });
  }

  void add_forces(const Kinematics& state, std::span<Vec3> force, int threads) override {
    refresh_creases();
    quads_.for_each_batch(threads, [&](int first) { add_batch(first, state, force); });
  }

  void add_couplings(std::vector<std::vector<int>>& neighbours) const override {
    quads_.add_couplings(neighbours);
  }
  void attach(const BlockPattern& pattern) override { quads_.attach(pattern); }

  // K = B^T C B + sum_h moment_h d^2 theta_h / dx dx, the Gauss-Newton part plus the stress part. D
  // = beta B^T C B.
  void add_derivatives(const Kinematics& state, const Derivatives& into, Definiteness definiteness,
                       int threads) override {
    refresh_creases();
    quads_.for_each_batch(
        threads, [&](int first) { add_batch_derivatives(first, state, into, definiteness); });
  }

  void use_creases(CreaseHistory& creases) override {
    creases_ = &creases;
    version_ = no_version;
  }
  void advance_creases(const Kinematics& state, CreaseHistory& into, int threads) override {
    refresh_creases();
    visit_advanced(state, threads, [&](const BendingQuads::Body& body, int quad, int t,
                                       const Crease& crease) {
      into.advanced(body.case_body)[2 * (quad - body.first) + t] = crease;
    });
  }
  double dissipated(const Kinematics& state, int /*threads*/) override {
    refresh_creases();
    double sum = 0;
    visit_advanced(state, 1, [&](const BendingQuads::Body&, int quad, int t,
                                 const Crease& crease) {
      YieldLaw law;
      const YieldLawOf<Lanes>& laws = creased_[quad / lane_count].laws[t];
      const int lane = quad % lane_count;
      law.compliance = laws.compliance.values[lane];
      law.yield_curvature = laws.yield_curvature.values[lane];
      law.hardening_slope = laws.hardening_slope.values[lane];
      sum += law.dissipated(crease.curvature);
    });
    return sum;
  }

 private:
  static constexpr std::int64_t no_version = -1;

  // Batches have laws of yielding only if a body yields. Elastic bodies beside it never do.
  void set_laws(const BendingQuads& quads) {
    if (std::ranges::none_of(bodies_, &BendingQuads::Body::yields)) return;
    creased_.resize(batches_.size());
    for (std::size_t q = 0; q < quads.laws.size(); ++q) {
      for (int t = 0; t < 2; ++t) {
        YieldLawOf<Lanes>& laws = creased_[q / lane_count].laws[t];
        laws.compliance.values[q % lane_count] = quads.laws[q][t].compliance;
        laws.yield_curvature.values[q % lane_count] = quads.laws[q][t].yield_curvature;
        laws.hardening_slope.values[q % lane_count] = quads.laws[q][t].hardening_slope;
      }
    }
  }

  // Reads the selected creases of the history, if they have changed. Without one there are none.
  void refresh_creases() {
    if (creased_.empty() || creases_ == nullptr || version_ == creases_->version()) return;
    version_ = creases_->version();
    for (const BendingQuads::Body& body : bodies_) {
      if (!body.yields) continue;
      const std::span<const Crease> creases = creases_->of_body(body.case_body);
      for (int q = body.first; q < body.last; ++q) {
        for (int t = 0; t < 2; ++t) {
          CreaseOf<Lanes>& target = creased_[q / lane_count].creases[t];
          const Crease& crease = creases[2 * (q - body.first) + t];
          for (int i = 0; i < 3; ++i) target.angles[i].values[q % lane_count] = crease.angles[i];
          target.curvature.values[q % lane_count] = crease.curvature;
        }
      }
    }
  }

  // Calls visit(body, quad, triangle, crease) with the creases that follow from a state, for the
  // triangles that yield. With one thread the calls are in order.
  template <class Visit>
  void visit_advanced(const Kinematics& state, int threads, const Visit& visit) const {
    if (creased_.empty()) return;
    parallel_chunks(static_cast<int>(batches_.size()), threads, [&](int begin, int end) {
      for (int batch = begin; batch < end; ++batch) {
        const std::array<CreaseOf<Lanes>, 2> now = advanced_batch(lane_count * batch, state);
        for (int lane = 0; lane < lane_count; ++lane)
          visit_lane(lane_count * batch + lane, lane, now, visit);
      }
    });
  }
  template <class Visit>
  void visit_lane(int quad, int lane, const std::array<CreaseOf<Lanes>, 2>& creases,
                  const Visit& visit) const {
    const auto body = std::ranges::find_if(
        bodies_, [&](const BendingQuads::Body& each) { return quad < each.last; });
    if (body == bodies_.end() || !body->yields) return;
    for (int t = 0; t < 2; ++t) {
      Crease crease;
      for (int i = 0; i < 3; ++i) crease.angles[i] = creases[t].angles[i].values[lane];
      crease.curvature = creases[t].curvature.values[lane];
      // Clamps and seams take over the triangles at their edges.
      if (creased_[quad / lane_count].laws[t].compliance.values[lane] == 0) continue;
      visit(*body, quad, t, crease);
    }
  }
  WEFT_FLATTEN std::array<CreaseOf<Lanes>, 2> advanced_batch(int first,
                                                             const Kinematics& state) const {
    const BendingBatch& batch = batches_[first / lane_count];
    const CreasedBatch& creased = creased_[first / lane_count];
    const Hinges strains = batch.strains(hinge_vectors(quads_.gather(first, state.position)));
    return {batch.advanced(creased, strains, 0), batch.advanced(creased, strains, 1)};
  }
  // Returns theta - theta_rest + beta theta', rad.
  Hinges strains(int first, const HingeVectors& hinges, const Slopes& slopes,
                 const Kinematics& state) const {
    Hinges strains = batches_[first / lane_count].strains(hinges);
    if (!is_damped_) return strains;
    const Lanes damping_times = damping_times_.batch(first);
    const Hinges rates = slopes.along(quads_.gather(first, state.velocity));
    for (int h = 0; h < hinge_count; ++h) strains[h] += damping_times * rates[h];
    return strains;
  }

  WEFT_FLATTEN Lanes batch_energy(int first, std::span<const Vec3> position) const {
    const BendingBatch& batch = batches_[first / lane_count];
    const Hinges strains = batch.strains(hinge_vectors(quads_.gather(first, position)));
    return creased_.empty() ? batch.energy(strains)
                            : batch.energy(creased_[first / lane_count], strains);
  }
  // Returns the moments C (theta - theta_rest - plastic part + beta theta'), N m.
  Hinges moments(int first, const HingeVectors& hinges, const Slopes& slopes,
                 const Kinematics& state) const {
    const BendingBatch& batch = batches_[first / lane_count];
    if (creased_.empty()) return batch.moments(strains(first, hinges, slopes, state));
    Hinges rates;
    rates.fill(0);
    if (is_damped_) {
      const Lanes damping_times = damping_times_.batch(first);
      rates = slopes.along(quads_.gather(first, state.velocity));
      for (Lanes& rate : rates) rate *= damping_times;
    }
    return batch.moments(creased_[first / lane_count], batch.strains(hinges), rates);
  }
  WEFT_FLATTEN void add_batch(int first, const Kinematics& state, std::span<Vec3> force) const {
    const HingeVectors hinges = hinge_vectors(quads_.gather(first, state.position));
    const Slopes slopes(hinges);
    Hinges pulls = moments(first, hinges, slopes, state);
    for (Lanes& pull : pulls) pull = -pull;
    quads_.scatter(first, slopes.times(pulls), force);
  }

  WEFT_FLATTEN void add_batch_derivatives(int first, const Kinematics& state,
                                          const Derivatives& into,
                                          Definiteness definiteness) const {
    const BendingBatch& batch = batches_[first / lane_count];
    const Nodes x = quads_.gather(first, state.position);
    const HingeVectors hinges = hinge_vectors(x);
    const Slopes slopes(hinges);
    const Lanes factor = is_damped_ ? add_damping(first, into, slopes) : 1;
    const ElasticBlocks elastic =
        creased_.empty() ? ElasticBlocks(batch, slopes, factor)
                         : ElasticBlocks(yielded_moduli(first, hinges, factor), slopes);
    if (definiteness == Definiteness::semi_definite)
      return add_elastic(first, elastic, into.stiffness);
    Hinges stresses = moments(first, hinges, slopes, state);
    for (int h = 0; h < hinge_count; ++h)
      stresses[h] = materials::choose(hinges[h].flat_triangle, 0.0, stresses[h]);
    const StressBlocks stress(x, stresses);
    quads_.scatter_blocks(
        first,
        [&](auto a, auto b) {
          Mat3Of<Lanes> block = elastic.block<a, b>();
          stress.add<a, b>(block);
          return block;
        },
        into.stiffness);
  }

  // The slopes of the moments. Damping, the part of `factor` above 1, does not yield.
  Moduli yielded_moduli(int first, const HingeVectors& hinges, const Lanes& factor) const {
    const BendingBatch& batch = batches_[first / lane_count];
    Moduli moduli = batch.slopes(creased_[first / lane_count], batch.strains(hinges));
    for (int t = 0; t < 2; ++t) moduli[t] = moduli[t].plus(batch.moduli[t].scaled(factor - 1.0));
    return moduli;
  }

  // Adds D, the elastic blocks times beta, unless it is joined to K. Returns the factor of the
  // elastic blocks in the stiffness.
  Lanes add_damping(int first, const Derivatives& into, const Slopes& slopes) const {
    const Lanes damping_times = damping_times_.batch(first);
    const BendingBatch& batch = batches_[first / lane_count];
    if (!into.is_joined()) {
      add_elastic(first, ElasticBlocks(batch, slopes, damping_times), *into.damping);
      return 1;
    }
    Hinges pulls = batch.moments(slopes.along(quads_.gather(first, into.along)));
    for (Lanes& pull : pulls) pull *= damping_times;
    quads_.scatter(first, slopes.times(pulls), into.product);
    return 1.0 + into.inverse_gamma * damping_times;
  }
  void add_elastic(int first, const ElasticBlocks& elastic, BlockMatrix& matrix) const {
    quads_.scatter_blocks(
        first, [&](auto a, auto b) { return elastic.block<a, b>(); }, matrix);
  }

  StencilArray<QuadSurroundings::count, QuadSurroundings> quads_;
  std::vector<BendingBatch> batches_;
  VaryingNumbers varying_times_;
  StencilNumbers damping_times_;  // s, at the time set
  bool is_damped_ = false;        // at any time
  std::vector<BendingQuads::Body> bodies_;
  std::vector<CreasedBatch> creased_;  // empty: no body yields
  CreaseHistory* creases_ = nullptr;
  std::int64_t version_ = no_version;  // of the history in `creased_`
};

// The edges of a triangle that are hinges, and the nodes across them.
struct TriangleHinges {
  std::array<bool, 3> has_angle{};
  std::array<int, 3> across{no_node, no_node, no_node};
};
TriangleHinges hinges_of(const bsi::Mesh& mesh, int triangle) {
  TriangleHinges hinges;
  for (int i = 0; i < 3; ++i) {
    const bsi::Edge& edge = mesh.edges[mesh.triangle_edges[triangle][i]];
    hinges.has_angle[i] = edge.triangle[1] >= 0;
    if (hinges.has_angle[i]) hinges.across[i] = edge.opposite[edge.triangle[0] == triangle ? 1 : 0];
  }
  return hinges;
}

void add_body(const Scene& scene, int index, BendingQuads& quads) {
  const SceneBody& body = scene.bodies[index];
  const MaterialCase& material = *body.material;
  const std::vector<char> at_edges = triangles_at_edges(scene, index);
  const int first = static_cast<int>(quads.nodes.size());
  quads.bodies.push_back({scene.case_index(index), first, first + quad_count(body),
                          material.yields()});
  const bsi::Mesh mesh = bsi::build_mesh(body.atlas);  // the body's own mesh may have no edges
  for (int q = 0; q < quad_count(body); ++q) {
    Surroundings nodes;
    nodes.fill(no_node);
    const Quad corners = quad_corners(body, q);
    for (int i = 0; i < 4; ++i) nodes[quad_corner_nodes[i]] = corners[i];
    auto& moduli = quads.moduli.emplace_back();
    auto& laws = quads.laws.emplace_back();
    for (int t = 0; t < 2; ++t) {
      const TriangleHinges hinges = hinges_of(mesh, 2 * q + t);
      Nodes3 rest;
      for (int i = 0; i < 3; ++i) {
        const auto& of_hinge = hinge_nodes[hinged_triangles[t].hinges[i]];
        rest.col(i) = body.rest[corners[corners_of[t][i]]];
        if (hinged_triangles[t].hinges[i] != 0) nodes[of_hinge[3]] = hinges.across[i];
      }
      const bool is_at_edge = !at_edges.empty() && at_edges[2 * q + t] != 0;
      moduli[t] = is_at_edge ? Mat3(Mat3::Zero())
                             : materials::triangle_bending_modulus(rest, hinges.has_angle,
                                                                   material.bending_stiffness,
                                                                   material.poisson_ratio);
      laws[t] = is_at_edge ? YieldLaw() : yield_law_of(rest, material);
    }
    for (int& node : nodes) {
      if (node != no_node) node += body.first_particle;
    }
    quads.nodes.push_back(nodes);
  }
  quads.damping_times.append(quad_count(body), material.bending_damping_time());
  quads.is_damped |= !material.bending_damping_time().is_zero();
}

}  // namespace

std::unique_ptr<Force> make_bending_force(const Scene& scene) {
  BendingQuads quads;
  for (int b = 0; b < scene.dynamic_bodies; ++b) {
    if (scene.bodies[b].material->bending_stiffness > 0) add_body(scene, b, quads);
  }
  if (quads.nodes.empty()) return nullptr;
  return std::make_unique<BendingForce>(quads, rest_positions(scene));
}

}  // namespace weft::sim
