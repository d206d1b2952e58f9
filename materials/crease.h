// Plastic bending of a triangle: bending that yields, hardens and leaves a crease.
//
// The angles t of a triangle's edges since rest (materials/bending.h) are the sum of an elastic
// part e and a plastic part p. The elastic curvature is measured by the energy,
//   |e| = sqrt(e^T C e / (A D)) = sqrt((1 - nu) tr(kappa^2) + nu tr(kappa)^2)    1/m,
// which is the curvature itself where the surface bends to a cylinder, whatever its direction. It
// never exceeds y + beta q, with the yield curvature y, the plastic curvature q accumulated so far
// and beta = hardening / (1 - hardening). Plastic flow is along e (associated: normal to the yield
// surface in the metric of the energy). From (p, q) at the start of a step, with the trial value e*
// = t - p,
//   delta = max(0, |e*| - y - beta q) / (1 + beta),    e = (1 - delta / |e*|) e*,
//   p <- t - e,    q <- q + delta,
// which is exact as long as e* grows along one direction in the step (radial return; Simo and
// Hughes 1998, Computational Inelasticity, section 3). The moment C e has the slope D before
// yielding and `hardening` D after, and derives from the potential e^T C e / 2 + A D (y q + beta
// q^2 / 2). The second term is what the crease has dissipated.
#pragma once

#include "materials/types.h"

namespace weft::materials {

// A triangle's plastic angles (rad) and its accumulated plastic curvature (1/m).
template <class Real>
struct CreaseOf {
  Vec3Of<Real> angles = Vec3Of<Real>::Zero();
  Real curvature = 0;
};
using Crease = CreaseOf<double>;

template <class Real>
struct YieldLawOf {
  Real compliance = 0;       // 1 / (A D), 1/(N m^3); 0: never yields
  Real yield_curvature = 1;  // y, 1/m
  Real hardening_slope = 0;  // beta

  // Returns what the crease of a triangle has dissipated, J.
  Real dissipated(const Real& curvature) const {
    const Real rise = 0.5 * hardening_slope * curvature;
    return choose(curvature <= 0.0, 0.0,
                  curvature * (yield_curvature + rise) / choose(curvature <= 0.0, 1.0, compliance));
  }
};
using YieldLaw = YieldLawOf<double>;

// Makes the law of a triangle of the given rest area (m^2). `stiffness` is D > 0 (N m);
// yield_curvature > 0 (1/m); 0 <= hardening < 1.
inline YieldLaw make_yield_law(double area, double stiffness, double yield_curvature,
                               double hardening) {
  return {1 / (area * stiffness), yield_curvature, hardening / (1 - hardening)};
}

// The response of a triangle to trial angles e*, C e* being known.
template <class Real>
struct YieldedOf {
  Real kept = 1;  // e = kept e*
  Real drop = 0;  // the slope of the moment is kept C - drop (C e*)(C e*)^T, semi-definite
  Real flow = 0;  // delta, 1/m
};

// A trial value beyond the yield surface by no more than this part of itself counts as elastic. A
// crease that has just flowed lies on the surface but for rounding. Its slope is then the elastic
// one, by which small motions to either side are measured, and not that of further flow.
inline constexpr double yield_rounding = 1e-10;

template <class Real>
YieldedOf<Real> yielded(const YieldLawOf<Real>& law, const Real& accumulated,
                        const Vec3Of<Real>& trial, const Vec3Of<Real>& trial_moments) {
  const Real squared = dot(trial, trial_moments) * law.compliance;
  const Real size = square_root(larger(squared, 0.0));
  const Real excess = size - law.yield_curvature - law.hardening_slope * accumulated;
  const auto is_elastic = excess <= yield_rounding * size;
  const Real divisor = choose(is_elastic, 1.0, size);
  YieldedOf<Real> result;
  result.flow = choose(is_elastic, 0.0, excess / (1.0 + law.hardening_slope));
  result.kept = 1.0 - result.flow / divisor;
  const Real hardening = law.hardening_slope / (1.0 + law.hardening_slope);
  result.drop =
      choose(is_elastic, 0.0, (result.kept - hardening) * law.compliance / (divisor * divisor));
  return result;
}

}  // namespace weft::materials
