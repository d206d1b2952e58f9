// Cloth by direction whose keys contradict each other, and presets that do not exist.
#include "bad_case.h"
#include "sim/case/case_text.h"
#include "sim/case/material_presets.h"

namespace weft::sim::bad_fabric_test {

namespace {

const std::string woven = R"([material.m.orthotropic_membrane]
warp_stiffness = 800
weft_stiffness = 300
shear_modulus = 15
)";

// An orthotropic membrane with a curve along the warp, in the lines 5 and 6.
std::string curve(const std::string& strains, const std::string& tensions) {
  return R"([material.m.orthotropic_membrane]
weft_stiffness = 300
shear_modulus = 15
[material.m.orthotropic_membrane.warp_curve]
strains = )" +
         strains + "\ntensions = " + tensions + '\n' + sheet;
}

std::string bending(const std::string& lines) {
  return "[material.m.orthotropic_bending]\n" + lines + sheet;
}

std::vector<BadCase> broken_fabrics() {
  return {
      {"curve_that_falls", curve("[0, 0.01, 0.02, 0.03]", "[0, 5, 4, 9]"),
       R"(case.toml:6:19: "tensions[2]" is 4
  expected a curve that does not fall: at least the entry before, 5)"},
      {"strains_that_do_not_rise", curve("[0, 0.02, 0.02]", "[0, 5, 6]"),
       R"(case.toml:5:21: "strains[2]" is 0.02
  expected more than the entry before, 0.02)"},
      {"tensions_for_fewer_strains", curve("[0, 0.02, 0.03]", "[0, 5]"),
       R"(case.toml:6:12: "tensions" has 2 entries beside 3 in "strains"
  expected as many)"},
      {"curve_without_zero", curve("[0.01, 0.02, 0.03]", "[0, 5, 6]"),
       R"(case.toml:5:11: "strains" has no 0
  expected the strain 0, where the tension is 0, among them)"},
      {"tension_at_rest", curve("[-0.1, 0, 0.03]", "[0, 5, 6]"),
       R"(case.toml:6:16: "tensions[1]" is 5
  expected 0 at the strain 0: cloth at rest has no tension)"},
      {"curve_of_one_point", curve("[0]", "[0]"),
       R"(case.toml:5:11: "strains" is an array of 1
  expected an array of numbers > -1)"},
      {"strain_of_minus_one", curve("[-1, 0]", "[-2, 0]"),
       R"(case.toml:5:12: "strains[0]" is -1
  expected an array of numbers > -1)"},
      {"shear_curve_of_both_sides",
       R"([material.m.orthotropic_membrane]
warp_stiffness = 800
weft_stiffness = 300
shear_curve = { strains = [-0.1, 0, 0.1], tensions = [-1, 0, 1] }
)" + sheet,
       R"(case.toml:4:28: "strains[0]" is -0.1
  expected 0: the other direction is the mirror image)"},
      {"constant_beside_curve",
       R"([material.m.orthotropic_membrane]
warp_stiffness = 800
warp_curve = { strains = [0, 0.1], tensions = [0, 1] }
weft_stiffness = 300
shear_modulus = 15
)" + sheet,
       R"(case.toml:2:1: "warp_stiffness" does not go with "warp_curve"
  expected only one of the two)"},
      {"no_warp",
       R"([material.m.orthotropic_membrane]
weft_stiffness = 300
shear_modulus = 15
)" + sheet,
       R"(case.toml:1:1: [material.m.orthotropic_membrane] has no "warp_stiffness"
  expected "warp_stiffness", a number (N/m), or "warp_curve", a table)"},
      {"poisson_ratio_too_large", woven + "poisson_ratio = 1.7\n" + sheet,
       R"(case.toml:5:17: "poisson_ratio" is 1.7
  expected between -1.63299 and 1.63299, the root of warp_stiffness / weft_stiffness: cloth beyond would gain energy by stretching)"},
      {"poisson_ratio_beside_curve",
       R"([material.m.orthotropic_membrane]
warp_curve = { strains = [0, 0.1], tensions = [0, 1] }
weft_stiffness = 300
shear_modulus = 15
poisson_ratio = 0.1
)" + sheet,
       R"(case.toml:5:17: "poisson_ratio" is 0.1 beside a curve
  expected 0: curves have no Poisson effect, which they would contradict)"},
      {"stiffness_zero", R"([material.m.orthotropic_membrane]
warp_stiffness = 0
)" + sheet,
       R"(case.toml:2:18: "warp_stiffness" is 0
  expected a number > 0 (N/m))"},
      {"misspelt_key", R"([material.m.orthotropic_membrane]
wrap_stiffness = 1
)" + sheet,
       R"(case.toml:2:1: unknown key "wrap_stiffness" in [material.m.orthotropic_membrane]
  did you mean "warp_stiffness"?)"},
      {"isotropic_beside_orthotropic", "[material.m]\nmembrane_stiffness = 500\n" + woven + sheet,
       R"(case.toml:2:1: "membrane_stiffness" does not go with "orthotropic_membrane"
  expected only one of the two)"},
      {"orthotropic_springs", "[material.m]\nmembrane = \"springs\"\n" + woven + sheet,
       R"(case.toml:3:13: "orthotropic_membrane" does not belong to membrane = "springs"
  expected only with membrane = "triangles")"},
      {"orthotropic_shell",
       "[material.m]\nmodel = \"shell\"\nyoungs_modulus = 1e9\nshell_thickness = 1e-3\n"
       "volume_density = 1000\n" +
           woven + sheet,
       R"(case.toml:6:13: "orthotropic_membrane" does not belong to model = "shell"
  expected only with model = "cloth")"},
      {"measured_of_five",
       R"([material.m.measured_membrane]
warp = [1, 1, 1, 1, 1]
)" + sheet,
       R"(case.toml:2:8: "warp" is an array of 5
  expected an array of 6 numbers >= 0 (N/m))"},
      {"measured_negative",
       R"([material.m.measured_membrane]
warp = [1, 1, 1, 1, 1, -1]
)" + sheet,
       R"(case.toml:2:24: "warp[5]" is -1
  expected an array of 6 numbers >= 0 (N/m))"},
      {"coupling_too_large",
       R"([material.m.measured_membrane]
warp = [1, 1, 1, 1, 1, 1]
coupling = [0, 0, 2.5, 0, 0, 0]
weft = [1, 1, 4, 1, 1, 1]
shear = [1, 1, 1, 1, 1, 1]
)" + sheet,
       R"(case.toml:3:19: "coupling[2]" is 2.5
  expected at most 2, the root of warp x weft: cloth beyond would gain energy by stretching)"},
      {"bending_of_several_sizes", bending("warp = [1e-5, 2e-5]\nbias = [1e-5]\nweft = [1e-5]\n"),
       R"(case.toml:3:8: "bias" has 1 entry beside 2 in "warp"
  expected as many)"},
      {"bending_without_curvatures",
       bending("warp = [1e-5, 2e-5]\nbias = [1e-5, 2e-5]\nweft = [1e-5, 2e-5]\n"),
       R"(case.toml:1:1: "curvatures" has 0 entries beside 2 in "warp"
  expected as many)"},
      {"curvatures_from_one",
       bending("warp = [1e-5, 2e-5]\nbias = [1e-5, 2e-5]\nweft = [1e-5, 2e-5]\ncurvatures = [1, "
               "2]\n"),
       R"(case.toml:5:15: "curvatures[0]" is 1
  expected 0, the flat cloth)"},
      {"curvatures_that_fall",
       bending("warp = [1, 1, 1]\nbias = [1, 1, 1]\nweft = [1, 1, 1]\ncurvatures = [0, 20, 10]\n"),
       R"(case.toml:5:22: "curvatures[2]" is 10
  expected more than the entry before, 20)"},
      {"bias_too_soft", bending("warp = [4]\nbias = [0.25]\nweft = [1]\n"),
       R"(case.toml:3:9: "bias[0]" is 0.25
  expected more than 0.25, (sqrt(warp) - sqrt(weft))^2 / 4: some curvature would otherwise gain energy)"},
      {"bending_zero", bending("warp = [0]\nbias = [1]\nweft = [1]\n"),
       R"(case.toml:2:9: "warp[0]" is 0
  expected an array of numbers > 0 (N m))"},
      {"two_bending_stiffnesses",
       "[material.m]\nbending_stiffness = 1e-5\n" + bending("warp = [1]\nbias = [1]\nweft = [1]\n"),
       R"(case.toml:2:1: "bending_stiffness" does not go with "orthotropic_bending"
  expected only one of the two)"},
      {"unknown_preset", "[material.m]\npreset = \"11oz-blak-denim\"\n" + sheet,
       R"(case.toml:2:10: unknown preset "11oz-blak-denim"
  did you mean "11oz-black-denim"?)"},
      {"preset_of_a_number", "[material.m]\npreset = 11\n" + sheet,
       R"(case.toml:2:10: "preset" is a whole number
  expected one of )" +
           quoted_list(preset_names())},
      {"preset_without_a_key", "[material.m]\npreset = \"steel-sheet\"\n" + sheet,
       R"(case.toml:1:1: [material.m] has no "shell_thickness"
  expected "shell_thickness", a number > 0 (m))"},
      {"preset_by_override",
       "[material.m]\n" + sheet,
       R"(--set material.m.preset=silc: unknown preset "silc"
  did you mean "silk"?)",
       {"material.m.preset=silc"}},
      {"preset_with_a_bad_entry",
       "[material.m]\npreset = \"royal-target\"\n" + sheet,
       R"(--set material.m.measured_membrane.coupling.0=1e9: "coupling[0]" is 1e+09
  expected at most 2025.74, the root of warp x weft: cloth beyond would gain energy by stretching)",
       {"material.m.measured_membrane.coupling.0=1e9"}},
  };
}

class BrokenFabrics : public testing::TestWithParam<BadCase> {};

TEST_P(BrokenFabrics, AreRefused) { expect_refused(GetParam()); }

INSTANTIATE_TEST_SUITE_P(All, BrokenFabrics, testing::ValuesIn(broken_fabrics()), bad_case_name);

}  // namespace
}  // namespace weft::sim::bad_fabric_test
