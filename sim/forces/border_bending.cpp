#include "sim/forces/border_bending.h"

#include <algorithm>

#include "materials/bending.h"
#include "materials/hinge.h"
#include "sim/forces/crease_history.h"
#include "sim/forces/force_arrays.h"
#include "sim/scene/easing.h"

namespace weft::sim {

namespace {

using materials::Mat3;
using materials::Nodes3;
using materials::Nodes4;

constexpr int most_nodes = 6;  // three nodes of the triangle and three across its edges

// The hinges of a triangle at given positions: `strains` are the changes of their angles times
// BorderTriangle::factors and closed_parts (rad), `slopes` the derivatives of the strains by the
// node positions (1/m), and `hinges` the node positions of each hinge (m).
struct Angles {
  Vec3 strains{0, 0, 0};
  Eigen::Matrix<double, 3, 3 * most_nodes> slopes =
      Eigen::Matrix<double, 3, 3 * most_nodes>::Zero();
  std::array<Nodes4, 3> hinges;
};

class BorderBending final : public Force {
 public:
  BorderBending(std::string_view name, BorderTriangles of, const std::vector<Vec3>& rest)
      : name_(name),
        triangles_(std::move(of.triangles)),
        damping_times_(std::move(of.damping_times)),
        is_damped_(of.is_damped),
        ghosts_(std::move(of.ghosts)) {
    for (BorderTriangle& triangle : triangles_) {
      const Vec3 rest_angles = find_angles(triangle, rest).strains;
      for (int i = 0; i < 3; ++i) {
        if (triangle.ghosts[i] == no_particle && !triangle.is_sewn[i])
          triangle.rest_angles[i] = rest_angles[i];
      }
      close_ |= !triangle.closing_times.isZero(0);
    }
  }

  std::string_view name() const override { return name_; }
  bool has_damping() const override { return is_damped_; }
  bool varies() const override { return close_ || ghosts_.move() || damping_times_.varies(); }
  bool has_moving_points() const override { return close_ || ghosts_.move(); }
  void set_time(const Instant& now) override {
    ghosts_.set_time(now);
    damping_times_.visit_changed(now, [&](int first, int last, double time) {
      for (int t = first; t < last; ++t) triangles_[t].damping_time = time;
    });
    if (close_) close_seams(now.time);
  }
  double evaluation_work() const override { return 1.2; }

  double energy(const Kinematics& state, int /*threads*/) override {
    double sum = 0;
    for (const BorderTriangle& triangle : triangles_) {
      const Vec3 strains = elastic_part(triangle, find_angles(triangle, state.position).strains);
      sum += triangle.curved ? materials::law_energy(triangle.map, *triangle.curved, strains)
                             : 0.5 * strains.dot(triangle.modulus * strains);
    }
    return sum;
  }

  double power_of_moving_points(const Kinematics& state) override {
    double power = 0;
    for (const BorderTriangle& triangle : triangles_) {
      const Angles angles = find_angles(triangle, state.position);
      const Vec3 moments = moments_of(triangle, angles, state);
      if (close_)
        power += elastic_moments(triangle, angles.strains)
                     .dot(triangle.closing_rates.cwiseProduct(angles.strains));
      for (int i = 0; i < 3; ++i) {
        if (triangle.ghosts[i] == no_particle) continue;
        power += (angles.slopes.middleCols<3>(3 * (i + 3)).transpose() * moments)
                     .dot(ghosts_.velocity(triangle.ghosts[i]));
      }
    }
    return power;
  }

  void list_outer_forces(const Kinematics& state, std::vector<OuterForce>& all) override {
    for (const BorderTriangle& triangle : triangles_) {
      const Angles angles = find_angles(triangle, state.position);
      const Vec3 moments = moments_of(triangle, angles, state);
      for (int i = 0; i < 3; ++i) {
        if (triangle.ghosts[i] == no_particle) continue;
        OuterForce& outer = all.emplace_back();
        const bool is_sewn = triangle.is_sewn[i];
        outer.by = is_sewn ? OuterForce::By::tied_body : OuterForce::By::clamp;
        outer.body = is_sewn ? triangle.bodies[i] : triangle.body;
        outer.pin = triangle.pins[i];
        outer.place = ghosts_.position(triangle.ghosts[i]);
        outer.force = angles.slopes.middleCols<3>(3 * (i + 3)).transpose() * moments;
      }
    }
  }

  void add_forces(const Kinematics& state, std::span<Vec3> force, int /*threads*/) override {
    for (const BorderTriangle& triangle : triangles_) {
      const Angles angles = find_angles(triangle, state.position);
      add_pull(triangle, angles, -moments_of(triangle, angles, state), force);
    }
  }

  void use_creases(CreaseHistory& creases) override { creases_ = &creases; }
  void advance_creases(const Kinematics& state, CreaseHistory& into, int /*threads*/) override {
    for (const BorderTriangle& triangle : triangles_) {
      if (triangle.yielding.compliance == 0) continue;
      into.advanced(triangle.case_body)[triangle.triangle] =
          advanced(triangle, find_angles(triangle, state.position).strains);
    }
  }
  double dissipated(const Kinematics& state, int /*threads*/) override {
    double sum = 0;
    for (const BorderTriangle& triangle : triangles_) {
      if (triangle.yielding.compliance == 0) continue;
      const Vec3 strains = find_angles(triangle, state.position).strains;
      sum += triangle.yielding.dissipated(advanced(triangle, strains).curvature);
    }
    return sum;
  }

  void add_couplings(std::vector<std::vector<int>>& neighbours) const override {
    for (const BorderTriangle& triangle : triangles_) {
      for (const int a : triangle.particles) {
        for (const int b : triangle.particles) {
          if (a != no_particle && b != no_particle) neighbours[a].push_back(b);
        }
      }
    }
  }
  void attach(const BlockPattern& /*pattern*/) override {}

  // Adds K = B^T C B + sum_i moment_i d^2 theta_i / dx dx and D = beta B^T V B, with the strains
  // theta and B = d theta / dx. The semi-definite form of K leaves out the sum and uses the
  // viscosity V in place of the tangent modulus C of a law that depends on the curvature.
  void add_derivatives(const Kinematics& state, const Derivatives& into, Definiteness definiteness,
                       int /*threads*/) override {
    for (const BorderTriangle& triangle : triangles_) {
      const Angles angles = find_angles(triangle, state.position);
      const Mat3 viscosity = viscosity_of(triangle, angles.strains);
      const Eigen::Matrix<double, 3, 3 * most_nodes> moduli = viscosity * angles.slopes;
      Block elastic = angles.slopes.transpose() * moduli;
      if (triangle.damping_time > 0 && !into.is_joined())
        add_blocks(triangle, triangle.damping_time * elastic, *into.damping);
      if (triangle.damping_time > 0 && into.is_joined()) {
        const Vec3 rates = angles.slopes * gathered(triangle, into.along);
        add_pull(triangle, angles, triangle.damping_time * viscosity * rates, into.product);
        elastic *= 1 + into.inverse_gamma * triangle.damping_time;
      }
      if (triangle.yielding.compliance > 0) {
        elastic -= angles.slopes.transpose() *
                   (triangle.modulus - yielded_modulus(triangle, angles.strains)) * angles.slopes;
      }
      if (triangle.curved && definiteness == Definiteness::exact)
        elastic += angles.slopes.transpose() * (tangent_of(triangle, angles.strains) - viscosity) *
                   angles.slopes;
      if (definiteness == Definiteness::exact)
        add_stress(triangle, angles, moments_of(triangle, angles, state), elastic);
      add_blocks(triangle, elastic, into.stiffness);
    }
  }

 private:
  using Block = Eigen::Matrix<double, 3 * most_nodes, 3 * most_nodes>;
  using Values = Eigen::Matrix<double, 3 * most_nodes, 1>;

  // Sets the parts of the angles that count at a time (s).
  void close_seams(double time) {
    for (BorderTriangle& triangle : triangles_) {
      for (int i = 0; i < 3; ++i) {
        const double closing_time = triangle.closing_times[i];
        if (closing_time == 0) continue;
        const double passed = std::min(time / closing_time, 1.0), part = eased(passed);
        triangle.closed_parts[i] = part;
        triangle.closing_rates[i] = part > 0 ? eased_slope(passed) / (closing_time * part) : 0;
      }
    }
  }

  Angles find_angles(const BorderTriangle& triangle, std::span<const Vec3> position) const {
    Angles angles;
    for (int i = 0; i < 3; ++i) {
      const int across = triangle.particles[i + 3], ghost = triangle.ghosts[i];
      if (across == no_particle && ghost == no_particle) continue;
      const std::array<int, 4> places = {(i + 1) % 3, (i + 2) % 3, i, i + 3};
      Nodes4& x = angles.hinges[i];
      for (int k = 0; k < 3; ++k) x.col(k) = position[triangle.particles[places[k]]];
      x.col(3) = ghost != no_particle ? ghosts_.position(ghost) : position[across];
      const double factor = triangle.factors[i] * triangle.closed_parts[i];
      angles.strains[i] = factor * (materials::hinge_angle(x) - triangle.rest_angles[i]);
      const Nodes4 gradient = materials::hinge_gradient(x);
      for (int k = 0; k < 4; ++k)
        angles.slopes.block<1, 3>(i, 3 * places[k]) = factor * gradient.col(k).transpose();
    }
    return angles;
  }

  // Returns the values at the nodes of a triangle, with zero at ghosts and beyond borders.
  static Values gathered(const BorderTriangle& triangle, std::span<const Vec3> values) {
    Values all = Values::Zero();
    for (int a = 0; a < most_nodes; ++a) {
      if (triangle.particles[a] != no_particle)
        all.segment<3>(3 * a) = values[triangle.particles[a]];
    }
    return all;
  }

  // Returns the crease of a triangle; zero without a history.
  materials::Crease crease_of(const BorderTriangle& triangle) const {
    if (creases_ == nullptr) return {};
    return creases_->of_body(triangle.case_body)[triangle.triangle];
  }
  // Returns the response of a triangle that yields. Sets `trial` to the strains (rad) from which it
  // follows.
  materials::YieldedOf<double> yielded(const BorderTriangle& triangle, const Vec3& strains,
                                       Vec3& trial) const {
    const materials::Crease crease = crease_of(triangle);
    trial = strains - crease.angles;
    return materials::yielded<double>(triangle.yielding, crease.curvature, trial,
                                      triangle.modulus * trial);
  }
  Vec3 elastic_part(const BorderTriangle& triangle, const Vec3& strains) const {
    if (triangle.yielding.compliance == 0) return strains;
    Vec3 trial;
    const double kept = yielded(triangle, strains, trial).kept;
    return kept * trial;
  }
  Mat3 yielded_modulus(const BorderTriangle& triangle, const Vec3& strains) const {
    Vec3 trial;
    const auto response = yielded(triangle, strains, trial);
    const Vec3 moment = triangle.modulus * trial;
    return response.kept * triangle.modulus - response.drop * (moment * moment.transpose());
  }
  materials::Crease advanced(const BorderTriangle& triangle, const Vec3& strains) const {
    Vec3 trial;
    const auto response = yielded(triangle, strains, trial);
    materials::Crease crease = crease_of(triangle);
    crease.angles += (1 - response.kept) * trial;
    crease.curvature += response.flow;
    return crease;
  }

  static Mat3 matrix_of(const materials::Symmetric3Of<double>& entries) {
    return Mat3::NullaryExpr([&](Eigen::Index i, Eigen::Index j) {
      return entries(static_cast<int>(i), static_cast<int>(j));
    });
  }
  // viscosity_of() returns the modulus V of damping, tangent_of() the tangent modulus C of a
  // nonlinear law, N m.
  static Mat3 viscosity_of(const BorderTriangle& triangle, const Vec3& strains) {
    if (!triangle.curved) return triangle.modulus;
    return matrix_of(materials::law_viscosity(triangle.map, *triangle.curved, strains));
  }
  static Mat3 tangent_of(const BorderTriangle& triangle, const Vec3& strains) {
    return matrix_of(materials::law_tangent(triangle.map, *triangle.curved, strains, false));
  }

  // Returns the moments dW/de, N m.
  Vec3 elastic_moments(const BorderTriangle& triangle, const Vec3& strains) const {
    const Vec3 elastic = elastic_part(triangle, strains);
    if (!triangle.curved) return triangle.modulus * elastic;
    return materials::law_slope(triangle.map, *triangle.curved, elastic);
  }
  // Returns the moments dW/de + beta V d theta/dt, N m. The elastic part e of the strains theta is
  // theta itself unless the triangle yields.
  Vec3 moments_of(const BorderTriangle& triangle, const Angles& angles,
                  const Kinematics& state) const {
    Vec3 strains = elastic_part(triangle, angles.strains), rates = Vec3::Zero();
    if (triangle.damping_time > 0) {
      Values velocity = gathered(triangle, state.velocity);
      for (int i = 0; i < 3; ++i) {
        if (triangle.ghosts[i] != no_particle)
          velocity.segment<3>(3 * (i + 3)) = ghosts_.velocity(triangle.ghosts[i]);
      }
      if (!triangle.curved) strains += triangle.damping_time * (angles.slopes * velocity);
      if (triangle.curved) rates = triangle.damping_time * (angles.slopes * velocity);
    }
    if (!triangle.curved) return triangle.modulus * strains;
    return materials::law_slope(triangle.map, *triangle.curved, strains) +
           viscosity_of(triangle, strains) * rates;
  }

  static void add_pull(const BorderTriangle& triangle, const Angles& angles, const Vec3& moments,
                       std::span<Vec3> sums) {
    for (int a = 0; a < most_nodes; ++a) {
      if (triangle.particles[a] != no_particle)
        sums[triangle.particles[a]] += angles.slopes.middleCols<3>(3 * a).transpose() * moments;
    }
  }

  // Adds sum_i moment_i d^2 theta_i / dx dx.
  static void add_stress(const BorderTriangle& triangle, const Angles& angles, const Vec3& moments,
                         Block& sum) {
    for (int i = 0; i < 3; ++i) {
      if (triangle.particles[i + 3] == no_particle && triangle.ghosts[i] == no_particle) continue;
      const Nodes4& x = angles.hinges[i];
      const double moment = triangle.factors[i] * triangle.closed_parts[i] * moments[i];
      const int p = (i + 1) % 3, q = (i + 2) % 3;
      Nodes3 own, beyond;
      own << x.col(0), x.col(1), x.col(2);
      beyond << x.col(1), x.col(0), x.col(3);
      add_stress(materials::HingeStress<double>(own, 2, moment), {p, q, i}, sum);
      add_stress(materials::HingeStress<double>(beyond, 2, moment), {q, p, i + 3}, sum);
    }
  }
  static void add_stress(const materials::HingeStress<double>& stress,
                         const std::array<int, 3>& places, Block& sum) {
    for (int a = 0; a < 3; ++a) {
      for (int b = 0; b < 3; ++b)
        sum.block<3, 3>(3 * places[a], 3 * places[b]) += stress.block(a, b);
    }
  }

  static void add_blocks(const BorderTriangle& triangle, const Block& blocks, BlockMatrix& matrix) {
    const BlockPattern& pattern = matrix.pattern();
    for (int a = 0; a < most_nodes; ++a) {
      for (int b = 0; b < most_nodes; ++b) {
        const int row = triangle.particles[a], column = triangle.particles[b];
        if (row == no_particle || column == no_particle || row > column) continue;
        matrix.upper_block(pattern.upper(row, pattern.slot(row, column))) +=
            blocks.block<3, 3>(3 * a, 3 * b);
      }
    }
  }

  std::string_view name_;
  std::vector<BorderTriangle> triangles_;
  CreaseHistory* creases_ = nullptr;
  VaryingNumbers damping_times_;  // s, by triangle
  bool is_damped_;                // true if damped at any time
  bool close_ = false;            // true if a seam has a closing_time
  MovingPoints ghosts_;
};

void join_fold(const Scene& scene, const Seam& seam, const SeamFold& fold, BorderTriangle& triangle,
               MovingPoints& ghosts) {
  const int i = fold.edge, body = scene.case_order[fold.other];
  const SceneBody& other = scene.bodies[body];
  const int across = other.first_particle + fold.across;
  triangle.is_sewn[i] = true;
  triangle.factors[i] = fold.share;
  triangle.rest_angles[i] = fold.angle;
  triangle.closing_times[i] = seam.source->closing_time;
  if (other.dynamic) {
    triangle.particles[i + 3] = across;
  } else {
    triangle.bodies[i] = body;
    triangle.ghosts[i] = ghosts.add_on_body(scene, other, scene.initial_position[across]);
  }
}

}  // namespace

BorderTriangle border_triangle(const Scene& scene, int body, const bsi::Mesh& mesh, int index) {
  const SceneBody& of = scene.bodies[body];
  BorderTriangle triangle;
  for (int i = 0; i < 3; ++i) {
    triangle.particles[i] = of.first_particle + mesh.triangles[index][i];
    const bsi::Edge& edge = mesh.edges[mesh.triangle_edges[index][i]];
    triangle.particles[i + 3] =
        edge.triangle[1] < 0 ? no_particle
                             : of.first_particle + edge.opposite[edge.triangle[0] == index ? 1 : 0];
  }
  triangle.body = body;
  triangle.case_body = scene.case_index(body);
  triangle.triangle = index;
  triangle.damping_time = of.material->bending_damping_time().constant_or_zero();
  return triangle;
}

void join_folds(const Scene& scene, BorderTriangle& triangle, MovingPoints& ghosts) {
  for (const Seam& seam : scene.seams) {
    for (const SeamFold& fold : seam.folds) {
      const bool is_own = scene.case_order[fold.body] == triangle.body;
      if (is_own && fold.triangle == triangle.triangle)
        join_fold(scene, seam, fold, triangle, ghosts);
    }
  }
}

void find_laws(const Scene& scene, const bsi::Mesh& mesh, BorderTriangle& triangle) {
  const SceneBody& body = scene.bodies[triangle.body];
  Nodes3 rest;
  std::array<bool, 3> has_angle{};
  for (int i = 0; i < 3; ++i) {
    rest.col(i) = body.rest[mesh.triangles[triangle.triangle][i]];
    has_angle[i] = triangle.particles[i + 3] != no_particle || triangle.ghosts[i] != no_particle;
  }
  const MaterialCase& material = *body.material;
  triangle.yielding = yield_law_of(rest, material);
  if (!material.orthotropic_bending) {
    triangle.modulus = materials::triangle_bending_modulus(
        rest, has_angle, material.bending_stiffness, material.poisson_ratio);
    return;
  }
  const Vec3 warp = warp_direction(body, triangle.triangle);
  const materials::OrthotropicModuli moduli = flat_bending_moduli(material);
  triangle.modulus = materials::triangle_bending_modulus(rest, warp, has_angle, moduli);
  const BendingLaw law = *bending_law(material);
  if (const auto* curved = std::get_if<materials::CurvedBending>(&law)) {
    triangle.curved = std::make_shared<const materials::CurvedBending>(*curved);
    triangle.map = materials::bending_map(rest, warp, has_angle, moduli);
  }
}

std::unique_ptr<Force> make_border_bending(std::string_view name, BorderTriangles triangles,
                                           const Scene& scene) {
  return std::make_unique<BorderBending>(name, std::move(triangles), rest_positions(scene));
}

}  // namespace weft::sim
