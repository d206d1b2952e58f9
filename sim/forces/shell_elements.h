// Energy, forces and derivatives of the elements of spline shells.
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "materials/shell.h"
#include "sim/forces/element_points.h"
#include "sim/forces/force.h"
#include "sim/forces/stencil_array.h"
#include "sim/forces/varying_numbers.h"
#include "sim/scene/scene.h"
#include "sim/scene/spline_surface.h"

namespace weft::sim {

// The elements of all dynamic shells of one degree. Bending is integrated at the bending points of
// both axes (SplineAxis::bending_points). The strain along a parameter line is integrated at the
// strain points of the line's axis and the value points of the other axis. The rest of the
// stretching is integrated at the strain points of both axes. With more points thin shells would
// lock. With fewer points some waves would have no stiffness (docs/theory.md).
template <int degree>
class ShellElements {
 public:
  static constexpr int nodes = (degree + 1) * (degree + 1);
  using Stencil = std::array<int, nodes>;
  using Basis = materials::ShellBasis<nodes>;
  using Nodes = materials::NodesOf<double, nodes>;
  using Blocks = materials::StencilMatrix<double, nodes>;

  void add_body(const SceneBody& body) {
    const int first = static_cast<int>(stencils_.size());
    for (std::size_t p = 0; p < body.spline->patches().size(); ++p)
      add_patch(body, static_cast<int>(p));
    const int added = static_cast<int>(stencils_.size()) - first;
    const auto append = [&](const Varying<double>& from, VaryingNumbers& numbers,
                            std::vector<double>& times) {
      numbers.append(added, from);
      times.resize(stencils_.size(), from.constant_or_zero());
    };
    const Varying<double> stretch_time = body.material->membrane_damping_time();
    const Varying<double> bend_time = body.material->bending_damping_time();
    append(stretch_time, stretch_damping_, stretch_time_);
    append(bend_time, bend_damping_, bend_time_);
    is_damped_ |= !stretch_time.is_zero() || !bend_time.is_zero();
  }
  // Must be called once, after the last add_body().
  void finish(int particle_count) {
    elements_ = StencilArray<nodes>(stencils_, particle_count);
    fibres_.finish(elements_.count());
    stretch_.finish(elements_.count());
    bend_.finish(elements_.count());
    set_time({});
  }

  bool is_empty() const { return stencils_.empty(); }
  bool is_damped() const { return is_damped_; }
  bool varies() const { return stretch_damping_.varies() || bend_damping_.varies(); }
  void set_time(const Instant& now) {
    const auto update = [&](VaryingNumbers& numbers, std::vector<double>& times) {
      numbers.visit_changed(now, [&](int first, int last, double time) {
        std::fill(times.begin() + first, times.begin() + last, time);
      });
    };
    update(stretch_damping_, stretch_time_);
    update(bend_damping_, bend_time_);
  }

  double energy(std::span<const Vec3> position, int first, int last) const {
    double sum = 0;
    for (int e = first; e < last; ++e) {
      const Nodes x = gather(e, position);
      for (const FibrePoint& point : fibres_.of(e)) {
        const double strain = Fibre(x * point.slope.matrix()).strain(point.law);
        sum += 0.5 * point.law.modulus * strain * strain;
      }
      visit(stretch_, e, [&](const Basis& basis, const ShellLaw& law) {
        const Vec3 strain = Stretch(materials::derivatives(basis, x)).strain(law);
        sum += 0.5 * strain.dot(law.modulus * strain);
      });
      visit(bend_, e, [&](const Basis& basis, const ShellLaw& law) {
        const Vec3 bending = Bend(materials::derivatives(basis, x)).bending(law);
        sum += 0.5 * bending.dot(law.modulus * bending);
      });
    }
    return sum;
  }
  int count() const { return elements_.count(); }

  void add_forces(const Kinematics& state, std::span<Vec3> force, int threads) const {
    elements_.for_each(threads, [&](int e) {
      const Nodes x = gather(e, state.position), v = gather(e, state.velocity);
      Nodes gradient = Nodes::Zero();
      for (const FibrePoint& point : fibres_.of(e)) {
        const Fibre fibre(x * point.slope.matrix());
        fibre.template add_gradient<nodes>(stress(fibre, point, v, e), point.slope, gradient);
      }
      visit(stretch_, e, [&](const Basis& basis, const ShellLaw& law) {
        const Stretch stretch(materials::derivatives(basis, x));
        stretch.add_gradient(stress(stretch, law, basis, v, e), basis, gradient);
      });
      visit(bend_, e, [&](const Basis& basis, const ShellLaw& law) {
        const Bend bend(materials::derivatives(basis, x));
        bend.add_gradient(moment(bend, law, basis, v, e), basis, gradient);
      });
      scatter(e, -gradient, force);
    });
  }

  void add_couplings(std::vector<std::vector<int>>& neighbours) const {
    elements_.add_couplings(neighbours);
  }
  void attach(const BlockPattern& pattern) { elements_.attach(pattern); }

  void add_derivatives(const Kinematics& state, const Derivatives& into, Definiteness definiteness,
                       int threads) const {
    elements_.for_each(threads, [&](int e) {
      const Nodes x = gather(e, state.position), v = gather(e, state.velocity);
      Blocks stiffness = zero();
      add_stiffness(e, x, v, into, definiteness == Definiteness::exact, stiffness);
      elements_.add_blocks(e, stiffness, into.stiffness);
      if (is_damped_) add_damping(e, x, into);
    });
  }

 private:
  using ShellLaw = materials::ShellLaw;
  using Fibre = materials::ShellFibre;
  using Stretch = materials::ShellStretch;
  using Bend = materials::ShellBend;

  struct Point {
    SplineBasis u, v;
    ShellLaw law;
  };
  struct FibrePoint {
    typename Basis::Numbers slope;  // derivatives of the basis functions along the fibre
    materials::FibreLaw law;
  };
  using Points = ElementPoints<Point>;

  // Calls body(basis, law) for each quadrature point of an element.
  template <class Body>
  static void visit(const Points& points, int element, const Body& body) {
    for (const Point& point : points.of(element)) body(basis_of(point.u, point.v), point.law);
  }

  // Returns the tensor product of two bases. Node (degree + 1) j + i has function i along u and
  // function j along v.
  static Basis basis_of(const SplineBasis& u, const SplineBasis& v) {
    Basis basis;
    for (int j = 0, node = 0; j <= degree; ++j) {
      for (int i = 0; i <= degree; ++i, ++node) {
        basis.u[node] = u.slope[i] * v.value[j];
        basis.v[node] = u.value[i] * v.slope[j];
        basis.uu[node] = u.second[i] * v.value[j];
        basis.vv[node] = u.value[i] * v.second[j];
        basis.uv[node] = u.slope[i] * v.slope[j];
      }
    }
    return basis;
  }

  void add_patch(const SceneBody& body, int patch) {
    const auto& [u, v] = body.spline->patches()[patch];
    const int first = static_cast<int>(stencils_.size());
    for (int ev = 0; ev < v.elements(); ++ev) {
      for (int eu = 0; eu < u.elements(); ++eu) {
        const std::vector<int> control = body.spline->control_points(body.atlas, patch, eu, ev);
        Stencil& stencil = stencils_.emplace_back();
        for (int i = 0; i < nodes; ++i) stencil[i] = body.first_particle + control[i];
      }
    }
    add_fibres(materials::FibreAxis::u, body, first, u, v);
    add_fibres(materials::FibreAxis::v, body, first, u, v);
    add_points(body, first, u, v, u.strain_points(), v.strain_points(), materials::membrane_law,
               stretch_);
    add_points(body, first, u, v, u.bending_points(), v.bending_points(), materials::bending_law,
               bend_);
  }
  template <class MakeLaw>
  void add_points(const SceneBody& body, int first, const SplineAxis& u, const SplineAxis& v,
                  const std::vector<QuadraturePoint>& along_u,
                  const std::vector<QuadraturePoint>& along_v, const MakeLaw& make_law,
                  Points& points) {
    const MaterialCase& material = *body.material;
    visit_grid(u, v, along_u, along_v, [&](const SplineBasis& bu, const SplineBasis& bv, double w) {
      const int element = first + bv.element * u.elements() + bu.element;
      points.add(element,
                 {bu, bv,
                  make_law(rest_derivatives(body, element, bu, bv), material.youngs_modulus,
                           material.poisson_ratio, material.shell_thickness, w)});
    });
  }
  void add_fibres(materials::FibreAxis axis, const SceneBody& body, int first, const SplineAxis& u,
                  const SplineAxis& v) {
    const MaterialCase& material = *body.material;
    const bool is_u = axis == materials::FibreAxis::u;
    visit_grid(u, v, is_u ? u.strain_points() : u.value_points(),
               is_u ? v.value_points() : v.strain_points(),
               [&](const SplineBasis& bu, const SplineBasis& bv, double w) {
                 const int element = first + bv.element * u.elements() + bu.element;
                 const Basis basis = basis_of(bu, bv);
                 fibres_.add(element,
                             {is_u ? basis.u : basis.v,
                              materials::fibre_law(axis, rest_derivatives(body, element, bu, bv),
                                                   material.youngs_modulus, material.poisson_ratio,
                                                   material.shell_thickness, w)});
               });
  }
  // Calls body(basis along u, basis along v, weight) for each point of the tensor
  // product of two quadrature rules.
  template <class Body>
  static void visit_grid(const SplineAxis& u, const SplineAxis& v,
                         const std::vector<QuadraturePoint>& along_u,
                         const std::vector<QuadraturePoint>& along_v, const Body& body) {
    for (const QuadraturePoint& at_v : along_v) {
      for (const QuadraturePoint& at_u : along_u)
        body(u.at(at_u.parameter), v.at(at_v.parameter), at_u.weight * at_v.weight);
    }
  }
  materials::SurfaceDerivatives rest_derivatives(const SceneBody& body, int element,
                                                 const SplineBasis& u, const SplineBasis& v) const {
    Nodes rest;
    for (int i = 0; i < nodes; ++i)
      rest.col(i) = body.rest[stencils_[element][i] - body.first_particle];
    return materials::derivatives(basis_of(u, v), rest);
  }

  Nodes gather(int element, std::span<const Vec3> values) const {
    Nodes result;
    for (int i = 0; i < nodes; ++i) result.col(i) = values[stencils_[element][i]];
    return result;
  }
  void scatter(int element, const Nodes& values, std::span<Vec3> sums) const {
    for (int i = 0; i < nodes; ++i) sums[stencils_[element][i]] += values.col(i);
  }
  static Blocks zero() {
    Blocks blocks;
    blocks.blocks.fill(Mat3::Zero());
    return blocks;
  }

  // stress() and moment() return the modulus times (e + beta de/dt). e is the strain or the bending
  // at a point, and beta the damping time of the element (s).
  double stress(const Fibre& fibre, const FibrePoint& point, const Nodes& v, int element) const {
    double strain = fibre.strain(point.law);
    if (is_damped_) strain += stretch_time_[element] * fibre.strain_rate(v * point.slope.matrix());
    return point.law.modulus * strain;
  }
  Vec3 stress(const Stretch& stretch, const ShellLaw& law, const Basis& basis, const Nodes& v,
              int element) const {
    Vec3 strain = stretch.strain(law);
    if (is_damped_)
      strain += stretch_time_[element] * stretch.strain_rate(materials::derivatives(basis, v));
    return law.modulus * strain;
  }
  Vec3 moment(const Bend& bend, const ShellLaw& law, const Basis& basis, const Nodes& v,
              int element) const {
    Vec3 bending = bend.bending(law);
    if (is_damped_)
      bending += bend_time_[element] * bend.bending_rate(materials::derivatives(basis, v));
    return law.modulus * bending;
  }

  // Adds K of element e to `sum`, or K + D / gamma if K and D are joined.
  void add_stiffness(int e, const Nodes& x, const Nodes& v, const Derivatives& into, bool exact,
                     Blocks& sum) const {
    const double joined = into.is_joined() ? into.inverse_gamma : 0;
    for (const FibrePoint& point : fibres_.of(e)) {
      const Fibre fibre(x * point.slope.matrix());
      const double now = stress(fibre, point, v, e);
      fibre.template add_stiffness<nodes>((1 + joined * stretch_time_[e]) * point.law.modulus,
                                          exact ? now : std::max(now, 0.0), point.slope, sum);
    }
    visit(stretch_, e, [&](const Basis& basis, const ShellLaw& law) {
      const Stretch stretch(materials::derivatives(basis, x));
      const Vec3 now = stress(stretch, law, basis, v, e);
      stretch.add_stiffness((1 + joined * stretch_time_[e]) * law.modulus,
                            exact ? now : materials::pulling_part(now), basis, sum);
    });
    visit(bend_, e, [&](const Basis& basis, const ShellLaw& law) {
      const Bend bend(materials::derivatives(basis, x));
      bend.add_stiffness((1 + joined * bend_time_[e]) * law.modulus, moment(bend, law, basis, v, e),
                         exact, basis, sum);
    });
  }
  // Adds D of element e to the damping matrix. If K and D are joined, adds D times `into.along` to
  // `into.product` instead.
  void add_damping(int e, const Nodes& x, const Derivatives& into) const {
    Blocks damping = zero();
    Nodes product = Nodes::Zero();
    const bool joined = into.is_joined();
    const Nodes along = joined ? gather(e, into.along) : product;
    for (const FibrePoint& point : fibres_.of(e)) {
      const Fibre fibre(x * point.slope.matrix());
      const double modulus = stretch_time_[e] * point.law.modulus;
      if (joined) {
        const double rate = fibre.strain_rate(along * point.slope.matrix());
        fibre.template add_gradient<nodes>(modulus * rate, point.slope, product);
      } else {
        fibre.template add_stiffness<nodes>(modulus, 0, point.slope, damping);
      }
    }
    visit(stretch_, e, [&](const Basis& basis, const ShellLaw& law) {
      const Stretch stretch(materials::derivatives(basis, x));
      const Mat3 modulus = stretch_time_[e] * law.modulus;
      if (!joined) return stretch.add_stiffness(modulus, Vec3::Zero(), basis, damping);
      stretch.add_gradient(modulus * stretch.strain_rate(materials::derivatives(basis, along)),
                           basis, product);
    });
    visit(bend_, e, [&](const Basis& basis, const ShellLaw& law) {
      const Bend bend(materials::derivatives(basis, x));
      const Mat3 modulus = bend_time_[e] * law.modulus;
      if (!joined) return bend.add_stiffness(modulus, Vec3::Zero(), false, basis, damping);
      bend.add_gradient(modulus * bend.bending_rate(materials::derivatives(basis, along)), basis,
                        product);
    });
    if (joined) scatter(e, product, into.product);
    if (!joined) elements_.add_blocks(e, damping, *into.damping);
  }

  std::vector<Stencil> stencils_;
  StencilArray<nodes> elements_;
  ElementPoints<FibrePoint> fibres_;
  Points stretch_, bend_;
  VaryingNumbers stretch_damping_, bend_damping_;
  std::vector<double> stretch_time_, bend_time_;  // s, by element, at the time of set_time()
  bool is_damped_ = false;                        // true if damped at any time
};

}  // namespace weft::sim
