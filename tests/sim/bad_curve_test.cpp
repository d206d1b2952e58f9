// Curves and gusts that must be refused, each with its place, reason and hint.
#include "tests/sim/bad_case.h"

namespace weft::sim::bad_curve_test {
namespace {

class BadCurve : public testing::TestWithParam<BadCase> {};

TEST_P(BadCurve, IsRefusedWithPlaceAndHint) { expect_refused(GetParam()); }

std::vector<BadCase> bad_curves() {
  const auto world = [](const std::string& line) { return "[world]\n" + line + '\n' + sheet; };
  const auto contact = [](const std::string& line) { return "[contact]\n" + line + '\n' + sheet; };
  return {
      {"times_not_increasing", contact("friction = { times = [0, 2, 2], values = [0, 1, 0] }"),
       R"(case.toml:2:29: "times[2]" is 2
  expected later than the time before, 2 s)"},
      {"times_negative", contact("friction = { times = [-1, 2], values = [0, 1] }"),
       R"(case.toml:2:23: "times[0]" is -1
  expected an array of numbers >= 0 (s))"},
      {"times_empty", contact("friction = { times = [], values = [] }"),
       R"(case.toml:2:22: "times" is an array of 0
  expected an array of numbers >= 0 (s))"},
      {"times_not_finite", contact("friction = { times = [0, inf], values = [0, 1] }"),
       R"(case.toml:2:26: "times[1]" is inf
  expected an array of numbers >= 0 (s))"},
      {"times_a_number", contact("friction = { times = 1, values = [0] }"),
       R"(case.toml:2:22: "times" is a whole number
  expected an array of numbers >= 0 (s))"},
      {"lengths_differ", contact("friction = { times = [0, 1, 2], values = [0, 1] }"),
       R"(case.toml:2:42: "values" has 2 entries beside 3 in "times"
  expected a value for each time)"},
      {"one_value", contact("friction = { times = [0, 1], values = [0] }"),
       R"(case.toml:2:39: "values" has 1 entry beside 2 in "times"
  expected a value for each time)"},
      {"no_values", contact("friction = { times = [0, 1] }"),
       R"(case.toml:2:12: [contact.friction] has no "values"
  expected "values", an array of numbers >= 0)"},
      {"no_times", world("wind = { values = [[0, 0, 0]] }"),
       R"(case.toml:2:8: [world.wind] has no "times"
  expected "times", an array of numbers >= 0 (s))"},
      {"empty_table", world("wind = {}"),
       R"(case.toml:2:8: [world.wind] has no "times"
  expected "times", an array of numbers >= 0 (s))"},
      {"friction_negative_inside",
       contact("friction = { times = [0, 1, 2], values = [0.5, -0.1, 0.5] }"),
       R"(case.toml:2:48: "values[1]" is -0.1
  expected an array of numbers >= 0)"},
      {"value_not_finite", world("air_density = { times = [0, 1], values = [1, nan] }"),
       R"(case.toml:2:46: "values[1]" is nan
  expected an array of numbers >= 0 (kg/m^3))"},
      {"vector_for_a_number", contact("friction = { times = [0], values = [[0, 0, 1]] }"),
       R"(case.toml:2:37: "values[0]" is an array
  expected an array of numbers >= 0)"},
      {"number_for_a_vector", world("gravity = { times = [0, 1], values = [0, -9.81] }"),
       R"(case.toml:2:39: "values[0]" is a whole number
  expected an array of arrays of 3 numbers (m/s^2))"},
      {"two_components", world("wind = { times = [0, 1], values = [[1, 0, 0], [1, 0]] }"),
       R"(case.toml:2:47: "values[1]" is an array of 2
  expected an array of arrays of 3 numbers (m/s))"},
      {"component_not_a_number", world("wind = { times = [0], values = [[1, \"x\", 0]] }"),
       R"(case.toml:2:37: "values[0][1]" is a string
  expected an array of arrays of 3 numbers (m/s))"},
      {"between_misspelt",
       contact("friction = { times = [0, 1], values = [0, 1], between = \"smoth\" }"),
       R"(case.toml:2:57: "between" is "smoth"
  did you mean "smooth"?)"},
      {"unknown_key", contact("friction = { times = [0, 1], valeus = [0, 1] }"),
       R"(case.toml:2:30: unknown key "valeus" in [contact.friction]
  did you mean "values"?)"},
      {"gust_of_gravity", world("gravity = { mean = [0, 0, -9], intensity = 0.1, time_scale = 1 }"),
       R"(case.toml:2:13: unknown key "mean" in [world.gravity]
  expected one of "times", "values", "between")"},
      {"curve_and_gust", world("wind = { mean = [5, 0, 0], intensity = 0.1, times = [0, 1] }"),
       R"(case.toml:2:45: "times" does not belong to a gust
  expected either times and values, or mean, intensity and time_scale)"},
      {"gust_negative_intensity",
       world("wind = { mean = [5, 0, 0], intensity = -0.1, time_scale = 1 }"),
       R"(case.toml:2:40: "intensity" is -0.1
  expected a number >= 0)"},
      {"gust_without_time_scale", world("wind = { mean = [5, 0, 0], intensity = 0.1 }"),
       R"(case.toml:2:8: [world.wind] has no "time_scale"
  expected "time_scale", a number > 0 (s))"},
      {"gust_time_scale_zero",
       world("wind = { mean = [5, 0, 0], intensity = 0.1, time_scale = 0 }"),
       R"(case.toml:2:58: "time_scale" is 0
  expected a number > 0 (s))"},
      {"gust_faster_than_steps",
       world("wind = { mean = [5, 0, 0], intensity = 0.1, time_scale = 1e-6 }"),
       R"(case.toml:2:58: the time_scale of the gusts is 1e-06 s
  expected at least 104 times the minimum_step, 1.04e-05 s)"},
      {"gust_seed_negative",
       world("wind = { mean = [5, 0, 0], intensity = 0.1, time_scale = 1, seed = -1 }"),
       R"(case.toml:2:68: "seed" is -1
  expected a whole number >= 0)"},
      {"gust_without_mean_wind",
       world("wind = { mean = [0, 0, 0], intensity = 0.1, time_scale = 1 }"),
       R"(case.toml:2:17: the mean of a gust is zero
  expected a mean wind, of which intensity is a fraction)"},
      {"gust_unknown_key", world("wind = { mean = [5, 0, 0], intensity = 0.1, timescale = 1 }"),
       R"(case.toml:2:45: unknown key "timescale" in [world.wind]
  did you mean "time_scale"?)"},
      {"key_that_cannot_vary",
       "[material.cloth]\ndensity = { times = [0, 1], values = [1, 2] }\n" + sheet,
       R"(case.toml:2:11: "density" cannot vary in time
  expected a number > 0 (kg/m^2); these can vary: "world.gravity", "world.wind", )"
       R"("world.air_density", "contact.friction", "material.NAME.mass_damping", )"
       R"("material.NAME.stiffness_damping", "material.NAME.bending_damping", )"
       R"("material.NAME.normal_drag", "material.NAME.tangential_drag", )"
       R"("load.force", "load.pressure", "load.moment")"},
      {"static_varies",
       "[time]\nmethod = \"static\"\n[world]\ngravity = { times = [0, 1], values = [[0, 0, 0], "
       "[0, 0, -9]] }\n" +
           sheet,
       R"(case.toml:4:11: "gravity" varies in time, which static.loading = "proportional" does not follow
  expected a constant, static.loading = "in_time", or a method that follows the motion in time)"},
      {"static_material_varies",
       "[time]\nmethod = \"static\"\n[material.cloth]\nmass_damping = { times = [0, 1], values = "
       "[0, 1] }\n" +
           sheet,
       R"(case.toml:4:16: "mass_damping" varies in time, which static.loading = "proportional" does not follow
  expected a constant, static.loading = "in_time", or a method that follows the motion in time)"},
      {"high_order_undamped_at_times",
       "[time]\nmaximum_order = 4\nposition_tolerance = 1e-7\n[material.cloth]\nmass_damping = { "
       "times = [0, 1], values = [0, 1] }\n" +
           sheet,
       R"(case.toml:2:17: order 4 is wrong without damping
  expected mass_damping, stiffness_damping or loss_factor > 0 in [material.cloth], or maximum_order = 2)"},
      {"set_below_a_constant",
       world("wind = [1, 0, 0]"),
       R"(--set world.wind.values=[[1,0,0]]: "wind" is an array in the case
  expected a table)",
       {"world.wind.values=[[1,0,0]]"}},
      {"set_unknown_key_of_a_curve",
       contact("friction = { times = [0, 1], values = [0, 1] }"),
       R"(--set contact.friction.valeus=[0, 2]: unknown key "valeus" in [contact.friction]
  did you mean "values"?)",
       {"contact.friction.valeus=[0, 2]"}},
      {"set_entry_outside",
       contact("friction = { times = [0, 1], values = [0, 1] }"),
       R"(--set contact.friction.values.2=1: "values" has no entry "2"
  expected an index from 0 to 1)",
       {"contact.friction.values.2=1"}},
      {"set_component_outside",
       world("wind = { times = [0], values = [[0, 0, 1]] }"),
       R"(--set world.wind.values.0.3=1: "values" has no entry "3"
  expected an index from 0 to 2)",
       {"world.wind.values.0.3=1"}},
      {"set_index_of_a_number",
       contact("friction = 0.5"),
       R"(--set contact.friction.0=1: "friction" has no keys of its own
  expected a number >= 0 or a curve)",
       {"contact.friction.0=1"}},
  };
}

INSTANTIATE_TEST_SUITE_P(All, BadCurve, testing::ValuesIn(bad_curves()), bad_case_name);

}  // namespace
}  // namespace weft::sim::bad_curve_test
