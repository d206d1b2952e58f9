// Loads, sliding supports and load paths that must be refused.
#include "bad_case.h"

namespace weft::sim {
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
      {"no_force", load_on_sheet + "corners = [\"all\"]\n", ""},
      {"pressure_without_pressure", load_on_sheet + "type = \"pressure\"\n", ""},
      {"unknown_type", load_on_sheet + "type = \"presure\"\npressure = 1\n", ""},
      {"force_of_a_pressure",
       load_on_sheet + "type = \"pressure\"\npressure = 1\nforce = [0, 0, 1]\n", ""},
      {"follower_of_a_pressure",
       load_on_sheet + "type = \"pressure\"\npressure = 1\nfollower = true\n", ""},
      {"point_without_vertices", load_on_sheet + "force = [0, 0, 1]\n", ""},
      {"line_without_edges", load_on_sheet + "type = \"line\"\nforce = [0, 0, 1]\n", ""},
      {"line_with_corners",
       load_on_sheet + "type = \"line\"\nforce = [0, 0, 1]\ncorners = [\"all\"]\n", ""},
      {"area_with_rows", load_on_sheet + "type = \"area\"\nforce = [0, 0, 1]\nrows = [0, 1]\n", ""},
      {"half_a_box", load_on_sheet + "type = \"area\"\nforce = [0, 0, 1]\nregion_min = [0, 0, 0]\n",
       ""},
      {"rows_outside", load_on_sheet + "force = [0, 0, 1]\nrows = [0, 5]\n", ""},
      {"patch_outside",
       load_on_sheet + "type = \"line\"\nforce = [0, 0, 1]\nedges = [\"first_row\"]\npatch = 1\n",
       ""},
      {"moment_on_cloth",
       load_on_sheet + "type = \"moment\"\nmoment = 1\nedges = [\"first_row\"]\n", ""},
      {"falling_times",
       load_on_sheet + "type = \"pressure\"\npressure = { times = [1, 0], values = [0, 1] }\n", ""},
      {"axes_twice", sheet + "[[body.pin]]\nedges = [\"first_row\"]\naxes = [\"x\", \"x\"]\n", ""},
      {"unknown_axis", sheet + "[[body.pin]]\nedges = [\"first_row\"]\naxes = [\"w\"]\n", ""},
      {"all_axes", sheet + "[[body.pin]]\nedges = [\"first_row\"]\naxes = [\"x\", \"y\", \"z\"]\n",
       ""},
      {"axes_of_a_clamp",
       sheet + "[[body.pin]]\nedges = [\"first_row\"]\naxes = [\"x\"]\nclamp = true\n", ""},
      {"axes_and_symmetry",
       sheet +
           "[[body.pin]]\nedges = [\"first_row\"]\naxes = [\"x\"]\nsymmetry_normal = [0, 1, 0]\n",
       ""},
      {"symmetry_of_cloth",
       sheet + "[[body.pin]]\nedges = [\"first_row\"]\nsymmetry_normal = [0, 1, 0]\n", ""},
      {"symmetry_without_direction",
       shell_sheet + "[[body.pin]]\nedges = [\"first_row\"]\nsymmetry_normal = [0, 0, 0]\n", ""},
      {"symmetry_that_moves",
       shell_sheet + "[[body.pin]]\nedges = [\"first_row\"]\nsymmetry_normal = [0, 1, 0]\nmotion = "
                     "{ velocity = [1, 0, 0] }\n",
       ""},
      {"axes_that_let_go",
       sheet + "[[body.pin]]\nedges = [\"first_row\"]\naxes = [\"x\"]\nrelease_time = 0.5\n", ""},
      {"static_table_of_another_method", "[static]\nloading = \"in_time\"\n" + sheet, ""},
      {"unknown_loading",
       static_case + "[static]\nloading = \"arclength\"\n" + load_on_sheet +
           "corners = [\"all\"]\nforce = [0, 0, 1]\n",
       ""},
      {"key_of_another_loading",
       static_case + "[static]\nloading = \"in_time\"\nscale_gravity = true\n" + sheet, ""},
      {"jump_of_another_loading",
       static_case + "[static]\nloading = \"arc_length\"\nat_limit_point = \"jump\"\n" +
           load_on_sheet + "corners = [\"all\"]\nforce = [0, 0, 1]\n",
       ""},
      {"arc_length_without_a_load", static_case + "[static]\nloading = \"arc_length\"\n" + sheet,
       ""},
      {"arc_length_of_no_gravity",
       static_case +
           "[world]\ngravity = [0, 0, 0]\n[static]\nloading = \"arc_length\"\nscale_gravity = "
           "true\n" +
           sheet,
       ""},
      {"arc_length_in_time",
       static_case + "[static]\nloading = \"arc_length\"\n" + load_on_sheet +
           "type = \"pressure\"\npressure = { times = [0, 1], values = [0, 1] }\n",
       ""},
      {"arc_length_with_moving_pins",
       static_case + "[static]\nloading = \"arc_length\"\n" + sheet +
           "[[body.pin]]\nedges = [\"first_row\"]\nmotion = { velocity = [1, 0, 0] "
           "}\n[[load]]\nbody = \"sheet\"\ncorners = [\"all\"]\nforce = [0, 0, 1]\n",
       ""},
      {"arc_length_with_moving_obstacles",
       static_case + "[static]\nloading = \"arc_length\"\n" + load_on_sheet +
           "corners = [\"all\"]\nforce = [0, 0, 1]\n[[obstacle]]\nname = \"plate\"\nshape = { type "
           "= \"rectangle\", size = [1, 1], resolution = [3, 3] }\nmotion = { velocity = [1, 0, 0] "
           "}\n",
       ""},
      {"path_without_steps",
       static_case + "[static]\nloading = \"arc_length\"\nfirst_load_factor = 0\n" + load_on_sheet +
           "corners = [\"all\"]\nforce = [0, 0, 1]\n",
       ""},
  };
}

class BadLoad : public testing::TestWithParam<BadCase> {};
TEST_P(BadLoad, IsRefusedWithPlaceAndHint) { expect_refused(GetParam()); }
INSTANTIATE_TEST_SUITE_P(All, BadLoad, testing::ValuesIn(bad_loads()), bad_case_name);

}  // namespace
}  // namespace weft::sim
