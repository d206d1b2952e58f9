// Loads, sliding supports and load paths that must be refused.
#include "bad_case.h"

namespace weft::sim::bad_load_test {
namespace {

const std::string load_on_sheet = sheet + "[[load]]\nbody = \"sheet\"\n";
const std::string shell_sheet = R"([material.wall]
model = "shell"
youngs_modulus = 1e6
shell_thickness = 1e-3
volume_density = 1000
)" + sheet;
const std::string static_case = "[time]\nmethod = \"static\"\n[contact]\nenabled = false\n";

std::vector<BadCase> bad_loads() {
  return {
      {"unknown_body",
       sheet + "[[load]]\nbody = \"shet\"\nforce = [0, 0, 1]\ncorners = [\"all\"]\n",
       R"(case.toml:5:8: no body "shet"
  did you mean "sheet"?)"},
      {"no_force", load_on_sheet + "corners = [\"all\"]\n",
       R"(case.toml:4:1: [[load]] has no "force"
  expected "force", an array of 3 numbers (N) or a curve)"},
      {"pressure_without_pressure", load_on_sheet + "type = \"pressure\"\n",
       R"(case.toml:4:1: [[load]] has no "pressure"
  expected "pressure", a number (Pa) or a curve)"},
      {"unknown_type", load_on_sheet + "type = \"presure\"\npressure = 1\n",
       R"(case.toml:6:8: "type" is "presure"
  did you mean "pressure"?)"},
      {"force_of_a_pressure",
       load_on_sheet + "type = \"pressure\"\npressure = 1\nforce = [0, 0, 1]\n",
       R"(case.toml:8:1: "force" does not belong to type = "pressure"
  expected only with type = "point", "line", "area")"},
      {"follower_of_a_pressure",
       load_on_sheet + "type = \"pressure\"\npressure = 1\nfollower = true\n",
       R"(case.toml:8:1: "follower" does not belong to type = "pressure"
  expected only with type = "point", "line", "area")"},
      {"point_without_vertices", load_on_sheet + "force = [0, 0, 1]\n",
       R"(case.toml:4:1: the load selects nothing
  expected corners, edges, rows, cols, or region_min and region_max)"},
      {"line_without_edges", load_on_sheet + "type = \"line\"\nforce = [0, 0, 1]\n",
       R"(case.toml:4:1: the load names no edge
  expected edges = ["first_row"] or others)"},
      {"line_with_corners",
       load_on_sheet + "type = \"line\"\nforce = [0, 0, 1]\ncorners = [\"all\"]\n",
       R"(case.toml:8:11: "corners" does not select what this type of load acts on
  expected "edges", "patch")"},
      {"area_with_rows", load_on_sheet + "type = \"area\"\nforce = [0, 0, 1]\nrows = [0, 1]\n",
       R"(case.toml:8:8: "rows" does not select what this type of load acts on
  expected "region_min", "region_max")"},
      {"half_a_box", load_on_sheet + "type = \"area\"\nforce = [0, 0, 1]\nregion_min = [0, 0, 0]\n",
       R"(case.toml:8:14: region_min without region_max
  expected both corners of the box)"},
      {"patch_of_a_pressure", load_on_sheet + "type = \"pressure\"\npressure = 1\npatch = 0\n",
       R"(case.toml:8:1: "patch" does not belong to type = "pressure"
  expected only with type = "point", "line", "moment")"},
      {"patch_of_an_area", load_on_sheet + "type = \"area\"\nforce = [0, 0, 1]\npatch = 1\n",
       R"(case.toml:8:1: "patch" does not belong to type = "area"
  expected only with type = "point", "line", "moment")"},
      {"rows_outside", load_on_sheet + "force = [0, 0, 1]\nrows = [0, 5]\n",
       R"(case.toml:7:12: no row 5
  expected -5 to 4)"},
      {"patch_outside",
       load_on_sheet + "type = \"line\"\nforce = [0, 0, 1]\nedges = [\"first_row\"]\npatch = 1\n",
       R"(case.toml:9:9: patch 1 of 1
  expected 0)"},
      {"moment_on_cloth",
       load_on_sheet + "type = \"moment\"\nmoment = 1\nedges = [\"first_row\"]\n",
       R"(case.toml:6:8: a moment on body "sheet", which is no shell
  expected model = "shell" in [material.default])"},
      {"falling_times",
       load_on_sheet + "type = \"pressure\"\npressure = { times = [1, 0], values = [0, 1] }\n",
       R"(case.toml:7:26: "times[1]" is 0
  expected later than the time before, 1 s)"},
      {"axes_twice", sheet + "[[body.pin]]\nedges = [\"first_row\"]\naxes = [\"x\", \"x\"]\n",
       R"(case.toml:6:8: "axes" names a direction twice
  expected each once)"},
      {"unknown_axis", sheet + "[[body.pin]]\nedges = [\"first_row\"]\naxes = [\"w\"]\n",
       R"(case.toml:6:9: "axes[0]" is "w"
  did you mean "x"?)"},
      {"all_axes", sheet + "[[body.pin]]\nedges = [\"first_row\"]\naxes = [\"x\", \"y\", \"z\"]\n",
       R"(case.toml:6:8: "axes" is an array of 3
  expected an array of 1 to 2 names out of "x", "y", "z")"},
      {"axes_of_a_clamp",
       sheet + "[[body.pin]]\nedges = [\"first_row\"]\naxes = [\"x\"]\nclamp = true\n",
       R"(case.toml:6:1: "axes" does not go with "clamp"
  expected only one of the two)"},
      {"axes_and_symmetry",
       sheet +
           "[[body.pin]]\nedges = [\"first_row\"]\naxes = [\"x\"]\nsymmetry_normal = [0, 1, 0]\n",
       R"(case.toml:7:1: "symmetry_normal" does not go with "axes"
  expected only one of the two)"},
      {"axes_without_stiffness",
       "[material.m]\nmembrane_stiffness = 0\n" + sheet +
           "[[body.pin]]\nedges = [\"first_row\"]\naxes = [\"z\"]\n",
       R"(case.toml:8:8: axes of a membrane without stiffness, which give it no hold
  expected membrane_stiffness > 0 in [material.m], or a pin without axes)"},
      {"axes_of_slack_fabric",
       "[material.m]\northotropic_membrane = { warp_curve = { strains = [0, 0.2], tensions = [0, "
       "0] "
       "}, weft_curve = { strains = [0, 0.2], tensions = [0, 0] }, shear_modulus = 100 }\n" +
           sheet + "[[body.pin]]\nedges = [\"first_row\"]\naxes = [\"z\"]\n",
       R"(case.toml:8:8: axes of a membrane without stiffness, which give it no hold
  expected membrane_stiffness > 0 in [material.m], or a pin without axes)"},
      {"symmetry_of_cloth",
       sheet + "[[body.pin]]\nedges = [\"first_row\"]\nsymmetry_normal = [0, 1, 0]\n",
       R"(case.toml:6:19: a plane of symmetry of body "sheet", which is no shell
  expected model = "shell" in [material.default], or axes, which hold vertices in a plane)"},
      {"symmetry_without_direction",
       shell_sheet + "[[body.pin]]\nedges = [\"first_row\"]\nsymmetry_normal = [0, 0, 0]\n",
       R"(case.toml:11:19: the normal has no direction
  expected a vector that is not zero)"},
      {"symmetry_that_moves",
       shell_sheet + "[[body.pin]]\nedges = [\"first_row\"]\nsymmetry_normal = [0, 1, 0]\nmotion = "
                     "{ velocity = [1, 0, 0] }\n",
       R"(case.toml:12:10: a plane of symmetry does not move
  expected axes, whose motion is prescribed)"},
      {"axes_that_let_go",
       sheet + "[[body.pin]]\nedges = [\"first_row\"]\naxes = [\"x\"]\nrelease_time = 0.5\n",
       R"(case.toml:6:8: "axes" does not go with a hold_time or release_time of the same body
  expected pins that hold all the time)"},
      {"static_table_of_another_method", "[static]\nloading = \"in_time\"\n" + sheet,
       R"(case.toml:2:11: "loading" does not go with time.method = "cvode"
  expected time.method = "static", or no [static])"},
      {"unknown_loading",
       static_case + "[static]\nloading = \"arclength\"\n" + load_on_sheet +
           "corners = [\"all\"]\nforce = [0, 0, 1]\n",
       R"(case.toml:6:11: "loading" is "arclength"
  did you mean "arc_length"?)"},
      {"key_of_another_loading",
       static_case + "[static]\nloading = \"in_time\"\nscale_gravity = true\n" + sheet,
       R"(case.toml:7:1: "scale_gravity" does not belong to loading = "in_time"
  expected only with loading = "arc_length")"},
      {"jump_of_another_loading",
       static_case + "[static]\nloading = \"arc_length\"\nat_limit_point = \"jump\"\n" +
           load_on_sheet + "corners = [\"all\"]\nforce = [0, 0, 1]\n",
       R"(case.toml:7:1: "at_limit_point" does not belong to loading = "arc_length"
  expected only with loading = "in_time")"},
      {"arc_length_without_a_load", static_case + "[static]\nloading = \"arc_length\"\n" + sheet,
       R"(case.toml:6:11: "arc_length" without a load to scale
  expected a [[load]], or static.scale_gravity = true with gravity)"},
      {"arc_length_of_no_gravity",
       static_case +
           "[world]\ngravity = [0, 0, 0]\n[static]\nloading = \"arc_length\"\nscale_gravity = "
           "true\n" +
           sheet,
       R"(case.toml:8:11: "arc_length" without a load to scale
  expected a [[load]], or static.scale_gravity = true with gravity)"},
      {"arc_length_in_time",
       static_case + "[static]\nloading = \"arc_length\"\n" + load_on_sheet +
           "type = \"pressure\"\npressure = { times = [0, 1], values = [0, 1] }\n",
       R"(case.toml:13:12: "pressure" varies in time, which static.loading = "arc_length" does not follow
  expected a constant, static.loading = "in_time", or a method that follows the motion in time)"},
      {"arc_length_with_moving_pins",
       static_case + "[static]\nloading = \"arc_length\"\n" + sheet +
           "[[body.pin]]\nedges = [\"first_row\"]\nmotion = { velocity = [1, 0, 0] "
           "}\n[[load]]\nbody = \"sheet\"\ncorners = [\"all\"]\nforce = [0, 0, 1]\n",
       R"(case.toml:12:10: the pin moves in time, which static.loading = "arc_length" does not follow
  expected a pin at rest, static.loading = "in_time", or a method that follows the motion in time)"},
      {"arc_length_with_moving_obstacles",
       static_case + "[static]\nloading = \"arc_length\"\n" + load_on_sheet +
           "corners = [\"all\"]\nforce = [0, 0, 1]\n[[obstacle]]\nname = \"plate\"\nshape = { type "
           "= \"rectangle\", size = [1, 1], resolution = [3, 3] }\nmotion = { velocity = [1, 0, 0] "
           "}\n",
       R"(case.toml:17:10: the obstacle moves in time, which static.loading = "arc_length" does not follow
  expected an obstacle at rest, static.loading = "in_time", or a method that follows the motion in time)"},
      {"path_without_steps",
       static_case + "[static]\nloading = \"arc_length\"\nfirst_load_factor = 0\n" + load_on_sheet +
           "corners = [\"all\"]\nforce = [0, 0, 1]\n",
       R"(case.toml:7:21: "first_load_factor" is 0
  expected a number > 0)"},
  };
}

class BadLoad : public testing::TestWithParam<BadCase> {};
TEST_P(BadLoad, IsRefusedWithPlaceAndHint) { expect_refused(GetParam()); }
INSTANTIATE_TEST_SUITE_P(All, BadLoad, testing::ValuesIn(bad_loads()), bad_case_name);

}  // namespace
}  // namespace weft::sim::bad_load_test
