// The elements of spline shells, as a force uses them.
#pragma once

#include <algorithm>
#include <array>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "materials/shell.h"
#include "sim/forces/force.h"
#include "sim/forces/stencil_array.h"
#include "sim/forces/varying_numbers.h"
#include "sim/scene/scene.h"
#include "sim/scene/spline_surface.h"

namespace weft::sim {

// The elements of all shells of one degree. Bending is integrated at two Gauss points per element
// and axis. Stretching is integrated at about one point per element (SplineAxis::strain_points),
// but for a fraction (t / size)^2 of it, which the Gauss points of bending integrate: the few
// points alone leave three waves of a flat patch without energy, and more points alone would lock
// thin shells (docs/theory.md, docs/decisions/0052).
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
    append(body.material->stiffness_damping, stretch_damping_, stretch_time_);
    append(body.material->bending_damping, bend_damping_, bend_time_);
    is_damped_ |=
        !body.material->stiffness_damping.is_zero() || !body.material->bending_damping.is_zero();
  }
  // Must be called once, after the last body.
  void finish(int particle_count) {
    elements_ = StencilArray<nodes>(stencils_, particle_count);
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
      stretch_.visit(e, [&](const Basis& basis, const ShellLaw& law) {
        sum += energy_of(Stretch(materials::derivatives(basis, x)).strain(law), law);
      });
      bend_.visit(e, [&](const Basis& basis, const BendLaws& laws) {
        const materials::SurfaceDerivatives now = materials::derivatives(basis, x);
        sum += energy_of(Stretch(now).strain(laws.stretch), laws.stretch);
        sum += energy_of(Bend(now).bending(laws.bend), laws.bend);
      });
    }
    return sum;
  }
  int count() const { return elements_.count(); }

  void add_forces(const Kinematics& state, std::span<Vec3> force, int threads) const {
    elements_.for_each(threads, [&](int e) {
      const Nodes x = gather(e, state.position), v = gather(e, state.velocity);
      Nodes gradient = Nodes::Zero();
      stretch_.visit(e, [&](const Basis& basis, const ShellLaw& law) {
        const Stretch stretch(materials::derivatives(basis, x));
        stretch.add_gradient(stress(stretch, law, basis, v, e), basis, gradient);
      });
      bend_.visit(e, [&](const Basis& basis, const BendLaws& laws) {
        const materials::SurfaceDerivatives now = materials::derivatives(basis, x);
        const Stretch stretch(now);
        stretch.add_gradient(stress(stretch, laws.stretch, basis, v, e), basis, gradient);
        const Bend bend(now);
        bend.add_gradient(moment(bend, laws.bend, basis, v, e), basis, gradient);
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
  using Stretch = materials::ShellStretch;
  using Bend = materials::ShellBend;
  // Of a Gauss point.
  struct BendLaws {
    ShellLaw bend, stretch;
  };

  // The points of one quadrature rule with their laws, element by element.
  template <class Law>
  class Points {
   public:
    void add(int element, const SplineBasis& u, const SplineBasis& v, const Law& law) {
      unsorted_.push_back({element, {u, v, law}});
    }
    void finish(int elements) {
      first_.assign(elements + 1, 0);
      for (const auto& [element, point] : unsorted_) ++first_[element + 1];
      std::partial_sum(first_.begin(), first_.end(), first_.begin());
      std::vector<int> place(first_);
      points_.resize(unsorted_.size());
      for (const auto& [element, point] : unsorted_) points_[place[element]++] = point;
      unsorted_ = {};
    }
    // Calls body(basis, law) for the points of an element.
    template <class Body>
    void visit(int element, const Body& body) const {
      for (int i = first_[element]; i < first_[element + 1]; ++i)
        body(basis_of(points_[i].u, points_[i].v), points_[i].law);
    }

   private:
    struct Point {
      SplineBasis u, v;
      Law law;
    };
    std::vector<std::pair<int, Point>> unsorted_;
    std::vector<Point> points_;
    std::vector<int> first_;  // by element
  };

  // The basis of a tensor product: node (degree + 1) j + i has function i along u and j along v.
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
    const MaterialCase& material = *body.material;
    add_points(body, first, u, v, u.strain_points(), v.strain_points(), stretch_,
               [&](const materials::SurfaceDerivatives& rest, double weight) {
                 return stretch_law(rest, material, weight * (1 - gauss_part(rest, material)));
               });
    add_points(body, first, u, v, u.gauss_points(2), v.gauss_points(2), bend_,
               [&](const materials::SurfaceDerivatives& rest, double weight) {
                 return BendLaws{
                     materials::bending_law(rest, material.youngs_modulus, material.poisson_ratio,
                                            material.shell_thickness, weight),
                     stretch_law(rest, material, weight * gauss_part(rest, material))};
               });
  }
  static ShellLaw stretch_law(const materials::SurfaceDerivatives& rest,
                              const MaterialCase& material, double weight) {
    return materials::membrane_law(rest, material.youngs_modulus, material.poisson_ratio,
                                   material.shell_thickness, weight);
  }
  // The fraction of stretching that the Gauss points integrate. A wave that the other points do not
  // see then has about the energy of bending at its length.
  static double gauss_part(const materials::SurfaceDerivatives& rest,
                           const MaterialCase& material) {
    const double size = rest.u.squaredNorm() + rest.v.squaredNorm();
    return std::min(1.0, material.shell_thickness * material.shell_thickness / size);
  }
  template <class Law, class MakeLaw>
  void add_points(const SceneBody& body, int first, const SplineAxis& u, const SplineAxis& v,
                  const std::vector<QuadraturePoint>& along_u,
                  const std::vector<QuadraturePoint>& along_v, Points<Law>& points,
                  const MakeLaw& make_law) {
    for (const QuadraturePoint& at_v : along_v) {
      for (const QuadraturePoint& at_u : along_u) {
        const SplineBasis bu = u.at(at_u.parameter), bv = v.at(at_v.parameter);
        const int element = first + bv.element * u.elements() + bu.element;
        Nodes rest;
        for (int i = 0; i < nodes; ++i)
          rest.col(i) = body.rest[stencils_[element][i] - body.first_particle];
        points.add(
            element, bu, bv,
            make_law(materials::derivatives(basis_of(bu, bv), rest), at_u.weight * at_v.weight));
      }
    }
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

  static double energy_of(const Vec3& strain, const ShellLaw& law) {
    return 0.5 * strain.dot(law.modulus * strain);
  }
  // The stress, damping included.
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

  // K. If D is joined to it, the part of the moduli is larger.
  void add_stiffness(int e, const Nodes& x, const Nodes& v, const Derivatives& into, bool exact,
                     Blocks& sum) const {
    const double joined = into.is_joined() ? into.inverse_gamma : 0;
    const auto add_stretch = [&](const Stretch& stretch, const Basis& basis, const ShellLaw& law) {
      const Vec3 now = stress(stretch, law, basis, v, e);
      stretch.add_stiffness((1 + joined * stretch_time_[e]) * law.modulus,
                            exact ? now : materials::pulling_part(now), basis, sum);
    };
    stretch_.visit(e, [&](const Basis& basis, const ShellLaw& law) {
      add_stretch(Stretch(materials::derivatives(basis, x)), basis, law);
    });
    bend_.visit(e, [&](const Basis& basis, const BendLaws& laws) {
      const materials::SurfaceDerivatives now = materials::derivatives(basis, x);
      add_stretch(Stretch(now), basis, laws.stretch);
      const Bend bend(now);
      bend.add_stiffness((1 + joined * bend_time_[e]) * laws.bend.modulus,
                         moment(bend, laws.bend, basis, v, e), exact, basis, sum);
    });
  }
  // D, or its product if it is joined to K.
  void add_damping(int e, const Nodes& x, const Derivatives& into) const {
    Blocks damping = zero();
    Nodes product = Nodes::Zero();
    const bool joined = into.is_joined();
    const Nodes along = joined ? gather(e, into.along) : product;
    const auto add_stretch = [&](const Stretch& stretch, const Basis& basis, const ShellLaw& law) {
      const Mat3 modulus = stretch_time_[e] * law.modulus;
      if (!joined) return stretch.add_stiffness(modulus, Vec3::Zero(), basis, damping);
      stretch.add_gradient(modulus * stretch.strain_rate(materials::derivatives(basis, along)),
                           basis, product);
    };
    stretch_.visit(e, [&](const Basis& basis, const ShellLaw& law) {
      add_stretch(Stretch(materials::derivatives(basis, x)), basis, law);
    });
    bend_.visit(e, [&](const Basis& basis, const BendLaws& laws) {
      const materials::SurfaceDerivatives now = materials::derivatives(basis, x);
      add_stretch(Stretch(now), basis, laws.stretch);
      const Bend bend(now);
      const Mat3 modulus = bend_time_[e] * laws.bend.modulus;
      if (!joined) return bend.add_stiffness(modulus, Vec3::Zero(), false, basis, damping);
      bend.add_gradient(modulus * bend.bending_rate(materials::derivatives(basis, along)), basis,
                        product);
    });
    if (joined) scatter(e, product, into.product);
    if (!joined) elements_.add_blocks(e, damping, *into.damping);
  }

  std::vector<Stencil> stencils_;
  StencilArray<nodes> elements_;
  Points<ShellLaw> stretch_;
  Points<BendLaws> bend_;
  VaryingNumbers stretch_damping_, bend_damping_;
  std::vector<double> stretch_time_, bend_time_;  // s, by element, at the time set
  bool is_damped_ = false;                        // at any time
};

}  // namespace weft::sim
