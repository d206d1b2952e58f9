#include "sim/modes/vibration_modes.h"

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "sim/modes/largest_eigenpairs.h"
#include "sim/modes/mode_shape.h"
#include "sim/motion/mass_matrix.h"
#include "sim/scene/scene.h"

namespace weft::sim {

namespace {

using Matrix = Eigen::SparseMatrix<double>;
using Vector = Eigen::VectorXd;
using Kind = VibrationMode::Kind;

// An eigenvalue counts as zero if the energy of its shape is at most this number of rounding
// errors, plus what rounded positions may cause (PositionRounding). The rounding error is that of
// the energy in K + shift M (rounding_scale()).
constexpr double shift_roundings = 1e4;
// Largest deviation of a rigid shape from rigid motions, relative to its norm.
constexpr double rigid_tolerance = 1e-4;
// The bisection for the scale of the wanted eigenvalues ends when the ratio of its limits is at
// most `scale_ratio`. Its first lower limit is `smallest_scale` times the upper limit.
constexpr double scale_ratio = 16, smallest_scale = 1e-14;
constexpr int most_shifts = 40;

// Returns the number of eigenvalues below `limit` (1/s^2).
int count_below(const Matrix& stiffness, const Matrix& mass, double limit,
                SymmetricFactors& factors) {
  for (const double moved : {1.0, 1.01, 0.99}) {
    if (factors.factorise(stiffness - moved * limit * mass)) return factors.negative_pivots();
  }
  return 0;
}

// Returns a limit (1/s^2) with at least `count` eigenvalues below it, not far above the `count`-th.
double scale_of(const Matrix& stiffness, const Matrix& mass, int count, SymmetricFactors& factors) {
  double above = Vector(stiffness.diagonal()).cwiseAbs().sum() / Vector(mass.diagonal()).sum();
  for (int i = 0; i < most_shifts && count_below(stiffness, mass, above, factors) < count; ++i)
    above *= scale_ratio;
  double below = smallest_scale * above;
  while (above > scale_ratio * below) {
    const double middle = std::sqrt(above * below);
    (count_below(stiffness, mass, middle, factors) < count ? below : above) = middle;
  }
  return above;
}

// Finds a positive shift (1/s^2) for which K + shift M is positive definite, and stores the factors
// of this matrix in `factors`. Returns the shift, or 0 if no shift is found.
double factorise_shifted(const Matrix& stiffness, const Matrix& mass, double scale,
                         SymmetricFactors& factors) {
  double shift = scale / scale_ratio;
  for (int i = 0; i < most_shifts; ++i) {
    if (factors.factorise(stiffness + shift * mass) && factors.negative_pivots() == 0) return shift;
    shift *= scale_ratio;
  }
  return 0;
}

// Fits a rigid motion to the displacements of one body. Holds the squared norms of the
// displacements and of their deviations from that motion.
class RigidPart {
 public:
  RigidPart(std::span<const Vec3> position, std::span<const Vec3> shape) {
    const auto count = static_cast<Eigen::Index>(position.size());
    Vec3 centre = Vec3::Zero();
    for (const Vec3& each : position) centre += each / static_cast<double>(count);
    Eigen::MatrixXd motions(3 * count, 6);
    Vector all(3 * count);
    for (Eigen::Index i = 0; i < count; ++i) {
      motions.block<3, 3>(3 * i, 0) = Mat3::Identity();
      for (int axis = 0; axis < 3; ++axis)
        motions.block<3, 1>(3 * i, 3 + axis) = Vec3::Unit(axis).cross(position[i] - centre);
      all.segment<3>(3 * i) = shape[i];
    }
    const Vector rest = all - motions * motions.completeOrthogonalDecomposition().solve(all);
    whole_ = all.squaredNorm();
    rest_ = rest.squaredNorm();
  }
  double whole() const { return whole_; }  // squared norm of the displacements
  double rest() const { return rest_; }

 private:
  double whole_ = 0, rest_ = 0;
};

bool is_rigid(const Scene& scene, std::span<const Vec3> position, std::span<const Vec3> shape) {
  double whole = 0, rest = 0;
  for (int b = 0; b < scene.dynamic_bodies; ++b) {
    const SceneBody& body = scene.bodies[b];
    const RigidPart part(position.subspan(body.first_particle, body.particle_count()),
                         shape.subspan(body.first_particle, body.particle_count()));
    whole += part.whole();
    rest += part.rest();
  }
  return rest <= rigid_tolerance * rigid_tolerance * whole;
}

// The unknowns and the matrices of the eigenvalue problem, and the shift (1/s^2) at which it is
// solved.
struct System {
  ModeUnknowns unknowns;
  Matrix stiffness, mass;
  double shift = 0;
  std::optional<PositionRounding> rounding = {};
};

Kind kind_of(const VibrationMode& mode, const System& system, const Scene& scene,
             std::span<const Vec3> position) {
  // For a shape without energy, rounding_scale() of K may be zero. The energy of the shift is then
  // the scale.
  const double scale = rounding_scale(system.stiffness, system.unknowns.gather(mode.shape)) +
                       system.shift * mode.modal_mass;
  const double rounding = shift_roundings * std::numeric_limits<double>::epsilon() * scale +
                          system.rounding->energy(mode.shape);
  if (std::abs(mode.eigenvalue) * mode.modal_mass > rounding)
    return mode.eigenvalue < 0 ? Kind::growth : Kind::vibration;
  return is_rigid(scene, position, mode.shape) ? Kind::rigid : Kind::slack;
}

VibrationMode mode_of(double eigenvalue, const Vector& vector, const System& system) {
  VibrationMode mode;
  mode.eigenvalue = eigenvalue;
  mode.shape = shape_of(system.unknowns, vector);
  const Vector shape = system.unknowns.gather(mode.shape);
  mode.modal_mass = shape.dot(system.mass.selfadjointView<Eigen::Lower>() * shape);
  mode.error = equation_error(system.stiffness, system.mass, eigenvalue, shape);
  return mode;
}

}  // namespace

double VibrationMode::angular_frequency() const {
  return kind == Kind::vibration ? std::sqrt(eigenvalue) : 0;
}
double VibrationMode::frequency() const { return angular_frequency() / (2 * std::numbers::pi); }
double VibrationMode::growth_rate() const {
  return kind == Kind::growth ? std::sqrt(-eigenvalue) : 0;
}

const char* kind_name(Kind kind) {
  switch (kind) {
    case Kind::vibration:
      return "vibration";
    case Kind::growth:
      return "growth";
    case Kind::rigid:
      return "rigid";
    case Kind::slack:
      return "slack";
  }
  return "";
}

VibrationModes find_vibration_modes(Dynamics& dynamics, double time, std::span<const double> state,
                                    int count) {
  VibrationModes result;
  const auto fail = [&](const std::string& text) {
    result.failure = Failure{Failure::Kind::solver, time, -1, text};
    return result;
  };
  System system{ModeUnknowns(dynamics.scene()), {}, {}};
  result.unknowns = static_cast<int>(system.unknowns.count());
  if (result.unknowns == 0) return result;
  std::string fault;
  auto stiffness = system.unknowns.stiffness(dynamics, time, state, fault);
  if (!stiffness) return fail(fault);
  system.stiffness.swap(*stiffness);
  system.rounding.emplace(dynamics.stiffness(), StateView::of(state).position);
  system.mass = system.unknowns.mass(mass_matrix(dynamics.scene()));
  count = std::min(count, result.unknowns);
  SymmetricFactors factors;
  const double scale = scale_of(system.stiffness, system.mass, count, factors);
  system.shift = factorise_shifted(system.stiffness, system.mass, scale, factors);
  if (system.shift == 0) return fail("no shift makes the tangent stiffness definite");
  const auto pairs = largest_eigenpairs(system.mass, system.stiffness + system.shift * system.mass,
                                        factors, count);
  if (!pairs) return fail("the search for eigenvalues does not converge");
  for (const Eigenpair& pair : *pairs) {
    result.modes.push_back(mode_of(1 / pair.value - system.shift, pair.vector, system));
    VibrationMode& mode = result.modes.back();
    mode.kind = kind_of(mode, system, dynamics.scene(), StateView::of(state).position);
  }
  return result;
}

}  // namespace weft::sim
