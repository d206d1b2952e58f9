// Describes the tables of materials whose stiffness depends on the direction.
#include "sim/case/case_schema.h"
#include "sim/case/field_makers.h"

namespace weft::sim {

Table describe(StretchCurveCase& target) {
  auto& [strains, tensions] = target;
  return {{
      field("strains", &strains, "", {-1, infinity, true, false},
            "Strains, increasing, with 0 among them. Beyond the first and the last the curve goes "
            "on straight.")
          .needed()
          .entries(2, 0),
      field("tensions", &tensions, "N/m", any,
            "Forces per width at these strains: 0 at 0, and never less than the one before.")
          .needed()
          .entries(2, 0),
  }};
}

Table describe(OrthotropicMembraneCase& target) {
  auto& [warp_stiffness, weft_stiffness, shear_modulus, poisson_ratio, warp_curve, weft_curve,
         shear_curve] = target;
  return {{
      field("warp_stiffness", &warp_stiffness, "N/m", positive,
            "Young's modulus times thickness along the warp. Needed without warp_curve.")
          .not_with("warp_curve"),
      field("weft_stiffness", &weft_stiffness, "N/m", positive,
            "Young's modulus times thickness along the weft. Needed without weft_curve.")
          .not_with("weft_curve"),
      field("shear_modulus", &shear_modulus, "N/m", not_negative,
            "Shear modulus times thickness. Needed without shear_curve.")
          .not_with("shear_curve"),
      field("poisson_ratio", &poisson_ratio, "", any,
            "Contraction along the weft under a pull along the warp, as a share of the stretch. "
            "Its square is less than warp_stiffness / weft_stiffness; 0 beside a curve."),
      field("warp_curve", table(&warp_curve),
            "Tension along the warp against its stretch, length / length at rest - 1."),
      field("weft_curve", table(&weft_curve),
            "Tension along the weft against its stretch, length / length at rest - 1."),
      field("shear_curve", table(&shear_curve),
            "Shear force per length against the tangent of the shear angle, from 0 on; the other "
            "direction is its mirror image."),
  }};
}

Table describe(MeasuredMembraneCase& target) {
  auto& [warp, coupling, weft, shear, factor] = target;
  return {{
      field("warp", &warp, "N/m", not_negative, "Tension along the warp per strain along the warp.")
          .needed()
          .entries(6, 6),
      field("coupling", &coupling, "N/m", not_negative,
            "Tension along either per strain along the other; its square is at most warp x weft.")
          .needed()
          .entries(6, 6),
      field("weft", &weft, "N/m", not_negative, "Tension along the weft per strain along the weft.")
          .needed()
          .entries(6, 6),
      field("shear", &shear, "N/m", not_negative,
            "Shear tension per shear strain E_12, half the tangent of the shear angle.")
          .needed()
          .entries(6, 6),
      field("factor", &factor, "", positive, "Multiplies all of these coefficients."),
  }};
}

Table describe(OrthotropicBendingCase& target) {
  auto& [warp, bias, weft, curvatures, factor] = target;
  return {{
      field("warp", &warp, "N m", positive,
            "Stiffness against curvature along the warp, at each of the curvatures.")
          .needed()
          .entries(1, 0),
      field("bias", &bias, "N m", positive,
            "Stiffness against curvature at 45 degrees to the warp; more than (sqrt(warp) - "
            "sqrt(weft))^2 / 4.")
          .needed()
          .entries(1, 0),
      field("weft", &weft, "N m", positive, "Stiffness against curvature along the weft.")
          .needed()
          .entries(1, 0),
      field("curvatures", &curvatures, "1/m", not_negative,
            "Curvatures, increasing from 0, where there are several stiffnesses: straight between "
            "them, constant beyond the last.")
          .entries(1, 0),
      field("factor", &factor, "", positive, "Multiplies all of these stiffnesses."),
  }};
}

}  // namespace weft::sim
