// Case files whose values contradict each other, and overrides that do not fit the case.
#include "bad_case.h"

namespace weft::sim::bad_rule_test {

namespace {

// Lists one case per row: its name, the text, the whole message, the overrides.
std::vector<BadCase> broken_rules() {
  return {
      // Shapes.
      {"size_zero",
       R"([[obstacle]]
name = "thing"
shape = { type = "rectangle", size = [1, 0], resolution = [3, 3] }
)" + sheet,
       R"(case.toml:3:42: "size[1]" is 0
  expected an array of 2 to 3 numbers > 0 (m))"},
      {"size_of_one_number",
       R"([[obstacle]]
name = "thing"
shape = { type = "rectangle", size = 1, resolution = [3, 3] }
)" + sheet,
       R"(case.toml:3:38: "size" is a whole number
  expected an array of 2 to 3 numbers > 0 (m))"},
      {"image_of_one_row",
       R"([[obstacle]]
name = "thing"
shape = { type = "rectangle", size = [1, 1], resolution = [1, 9] }
)" + sheet,
       R"(case.toml:3:60: "resolution[0]" is 1
  expected an array of 1 to 3 whole numbers >= 2)"},
      {"resolution_of_three",
       R"([[obstacle]]
name = "thing"
shape = { type = "rectangle", size = [1, 1], resolution = [3, 3, 3] }
)" + sheet,
       R"(case.toml:3:59: "resolution" is an array of 3
  expected [rows, cols])"},
      {"rectangle_of_one_number",
       R"([[obstacle]]
name = "thing"
shape = { type = "rectangle", size = [1, 1], resolution = [3] }
)" + sheet,
       R"(case.toml:3:59: "resolution" is an array of 1
  expected [rows, cols])"},
      {"sphere_of_two_numbers",
       R"([[obstacle]]
name = "thing"
shape = { type = "sphere", radius = 1, resolution = [4, 4] }
)" + sheet,
       R"(case.toml:3:53: "resolution" is an array of 2
  expected [n], the vertices along an edge of each patch)"},
      {"cylinder_of_two_columns",
       R"([[obstacle]]
name = "thing"
shape = { type = "cylinder", radius = 1, length = 1, resolution = [9, 2] }
)" + sheet,
       R"(case.toml:3:71: a cylinder of 2 columns
  expected at least 3: columns go around)"},
      {"torus_of_two_rows",
       R"([[obstacle]]
name = "thing"
shape = { type = "torus", major_radius = 1, minor_radius = 0.5, resolution = [2, 9] }
)" + sheet,
       R"(case.toml:3:79: a torus of 2 rows
  expected at least 3: rows go around the axis)"},
      {"torus_too_thick",
       R"([[obstacle]]
name = "thing"
shape = { type = "torus", major_radius = 1, minor_radius = 1, resolution = [9, 9] }
)" + sheet,
       R"(case.toml:3:60: minor_radius is 1 m
  expected less than major_radius, 1 m)"},
      {"box_of_two_lengths",
       R"([[obstacle]]
name = "thing"
shape = { type = "box", size = [1, 2], resolution = [3, 3, 3] }
)" + sheet,
       R"(case.toml:3:32: "size" is an array of 2
  expected [x, y, z])"},
      {"rectangle_of_three_lengths",
       R"([[obstacle]]
name = "thing"
shape = { type = "rectangle", size = [1, 2, 3], resolution = [3, 3] }
)" + sheet,
       R"(case.toml:3:38: "size" is an array of 3
  expected [x, y])"},
      {"box_of_two_numbers",
       R"([[obstacle]]
name = "thing"
shape = { type = "box", size = [1, 2, 1], resolution = [3, 3] }
)" + sheet,
       R"(case.toml:3:56: "resolution" is an array of 2
  expected [x, y, z], the vertices along each axis)"},
      {"box_of_too_many_vertices",
       R"([[obstacle]]
name = "thing"
shape = { type = "box", size = [1, 1, 1], resolution = [2147483647, 2147483647, 2] }
)" + sheet,
       R"(case.toml:3:56: too many vertices
  expected at most 100000000)"},
      {"disc_of_two_numbers",
       R"([[obstacle]]
name = "thing"
shape = { type = "disc", radius = 1, resolution = [9, 9] }
)" + sheet,
       R"(case.toml:3:51: "resolution" is an array of 2
  expected [n], the vertices along an edge of each patch)"},
      {"capsule_of_one_number",
       R"([[obstacle]]
name = "thing"
shape = { type = "capsule", radius = 1, length = 1, resolution = [9] }
)" + sheet,
       R"(case.toml:3:66: "resolution" is an array of 1
  expected [rows, n]: rows of the straight part, vertices along an eighth of the way around)"},
      {"cone_with_rows_of_an_apex",
       R"([[obstacle]]
name = "thing"
shape = { type = "cone", radius = 1, length = 1, resolution = [9, 9] }
)" + sheet,
       R"(case.toml:3:63: "resolution" is an array of 2
  expected [n], the vertices along an edge of each patch)"},
      {"frustum_of_two_columns",
       R"([[obstacle]]
name = "thing"
shape = { type = "cone", radius = 1, top_radius = 0.5, length = 1, resolution = [9, 2] }
)" + sheet,
       R"(case.toml:3:85: a cone of 2 columns
  expected at least 3: columns go around)"},
      {"annulus_without_surface",
       R"([[obstacle]]
name = "thing"
shape = { type = "annulus", inner_radius = 1, outer_radius = 0.5, resolution = [3, 9] }
)" + sheet,
       R"(case.toml:3:44: inner_radius is 1 m
  expected less than outer_radius, 0.5 m)"},
      {"annulus_of_two_columns",
       R"([[obstacle]]
name = "thing"
shape = { type = "annulus", inner_radius = 1, outer_radius = 2, resolution = [3, 2] }
)" + sheet,
       R"(case.toml:3:82: an annulus of 2 columns
  expected at least 3: columns go around)"},
      {"cylinder_beyond_a_turn",
       R"([[obstacle]]
name = "thing"
shape = { type = "cylinder", radius = 1, length = 1, angle_deg = 361, resolution = [3, 9] }
)" + sheet,
       R"(case.toml:3:66: "angle_deg" is 361
  expected a number > 0 and <= 360 (degrees))"},
      {"sphere_sector_to_the_pole",
       R"([[obstacle]]
name = "thing"
shape = { type = "sphere_sector", radius = 1, latitude_deg = [0, 90], resolution = [3, 9] }
)" + sheet,
       R"(case.toml:3:66: "latitude_deg[1]" is 90
  expected an array of 2 numbers >= -85 and <= 85 (degrees))"},
      {"sphere_sector_upside_down",
       R"([[obstacle]]
name = "thing"
shape = { type = "sphere_sector", radius = 1, latitude_deg = [10, -20], resolution = [3, 9] }
)" + sheet,
       R"(case.toml:3:67: latitude_deg ends at -20 degrees
  expected [south, north], north of 10 degrees)"},
      {"resolution_of_plane",
       R"([[obstacle]]
name = "thing"
shape = { type = "plane", size = [9, 9], resolution = [3, 3] }
)" + sheet,
       R"(case.toml:3:42: "resolution" does not belong to type = "plane"
  expected only with type = "rectangle", "disc", "annulus", "box", "cylinder", "capsule", "cone", "torus", "sphere", "sphere_sector", "blob")"},
      {"angle_of_torus",
       R"([[obstacle]]
name = "thing"
shape = { type = "torus", major_radius = 2, minor_radius = 1, angle_deg = 90, resolution = [9, 9] }
)" + sheet,
       R"(case.toml:3:63: "angle_deg" does not belong to type = "torus"
  expected only with type = "annulus", "cylinder", "sphere_sector")"},
      {"patches_that_do_not_divide",
       R"([[obstacle]]
name = "thing"
shape = { type = "cylinder", radius = 1, length = 1, resolution = [9, 12], patches = [2, 5] }
)" + sheet,
       R"(case.toml:3:90: 12 columns of quads do not divide into 5 patches
  expected a divisor of 12)"},
      {"patches_of_sphere",
       R"([[obstacle]]
name = "thing"
shape = { type = "sphere", radius = 1, resolution = [9], patches = [2, 2] }
)" + sheet,
       R"(case.toml:3:58: "patches" does not belong to type = "sphere"
  expected only with type = "rectangle", "annulus", "cylinder", "torus", "sphere_sector")"},
      {"latitude_missing",
       R"([[obstacle]]
name = "thing"
shape = { type = "sphere_sector", radius = 1, resolution = [3, 9] }
)" + sheet,
       R"(case.toml:3:9: [obstacle.shape] has no "latitude_deg"
  expected "latitude_deg", an array of 2 numbers >= -85 and <= 85 (degrees))"},
      {"shape_misspelt",
       R"([[obstacle]]
name = "thing"
shape = { type = "capsul" }
)" + sheet,
       R"(case.toml:3:18: "type" is "capsul"
  did you mean "capsule"?)"},
      {"inner_radius_misspelt",
       R"([[obstacle]]
name = "thing"
shape = { type = "annulus", iner_radius = 1, outer_radius = 2, resolution = [3, 9] }
)" + sheet,
       R"(case.toml:3:29: unknown key "iner_radius" in [obstacle.shape]
  did you mean "inner_radius"?)"},
      {"too_many_vertices",
       R"([[obstacle]]
name = "thing"
shape = { type = "sphere", radius = 1, resolution = [30000] }
)" + sheet,
       R"(case.toml:3:53: too many vertices
  expected at most 100000000)"},
      {"shape_file_missing",
       R"([[obstacle]]
name = "thing"
shape = { type = "file", path = "none.h5", dataset = "x" }
)" + sheet,
       R"(case.toml:3:33: no file "none.h5"
  expected an HDF5 file, here none.h5)"},
      // Bodies without support have no equilibrium; without contact, the floor is no support.
      {"static_without_support",
       sheet,
       R"(case.toml:2:8: nothing holds body "sheet": under gravity it has no equilibrium (time.method = "static")
  expected a pin, a tie, a seam, or an obstacle or a pinned body that it can rest on, with contact)",
       {"time.method=static"}},
      {"static_without_contact",
       sheet + R"([[obstacle]]
name = "floor"
position = [0, 0, -1]
shape = { type = "rectangle", size = [9, 9], resolution = [3, 3] }
)",
       R"(case.toml:2:8: nothing holds body "sheet": under gravity it has no equilibrium (time.method = "static")
  expected a pin, a tie, a seam, or an obstacle or a pinned body that it can rest on, with contact)",
       {"time.method=static", "contact.enabled=false"}},
      // Pins; the sheet has 5 rows and 9 columns.
      {"pin_of_nothing", sheet + R"([[body.pin]]
motion.velocity = [1, 0, 0]
)",
       R"(case.toml:4:1: the pin selects nothing
  expected corners, edges, rows, cols, or region_min and region_max)"},
      {"pin_corners_empty", sheet + R"([[body.pin]]
corners = []
)",
       R"(case.toml:5:11: "corners" is an array of 0
  expected an array of 1 to 4 names out of "first_first", "first_last", "last_first", "last_last", "all")"},
      {"pin_corner_twice", sheet + R"([[body.pin]]
corners = ["last_last", "last_last"]
)",
       R"(case.toml:5:25: "last_last" again
  expected each name once)"},
      {"pin_all_and_one", sheet + R"([[body.pin]]
corners = ["last_last", "all"]
)",
       R"(case.toml:5:25: "all" beside other corners
  expected "all" alone)"},
      {"pin_row_outside", sheet + R"([[body.pin]]
rows = [0, 5]
)",
       R"(case.toml:5:12: no row 5
  expected -5 to 4)"},
      {"pin_column_outside", sheet + R"([[body.pin]]
cols = [-10, 0]
)",
       R"(case.toml:5:9: no column -10
  expected -9 to 8)"},
      {"pin_rows_backwards", sheet + R"([[body.pin]]
rows = [-1, 2]
)",
       R"(case.toml:5:8: an empty range of rows
  expected [first, last], first <= last)"},
      {"pin_patch_outside", sheet + R"([[body.pin]]
corners = ["all"]
patch = 1
)",
       R"(case.toml:6:9: patch 1 of 1
  expected 0)"},
      {"pin_region_half", sheet + R"([[body.pin]]
region_max = [1, 1, 1]
)",
       R"(case.toml:5:14: region_max without region_min
  expected both corners of the box)"},
      {"pin_region_inside_out", sheet + R"([[body.pin]]
region_min = [0, 0, 0]
region_max = [1, -1, 1]
)",
       R"(case.toml:6:18: an empty region
  expected region_min <= region_max along each axis)"},
      {"pin_patch_of_region",
       R"([[body]]
name = "ball"
shape = { type = "sphere", radius = 1, resolution = [4] }
pin = [{ patch = 1, region_min = [0, 0, 0], region_max = [1, 1, 1] }]
)",
       R"(case.toml:4:18: "patch" does not go with a region alone
  expected corners, edges, rows or cols with it)"},
      // Motions.
      {"motion_stops_before_start", sheet + R"([[body.pin]]
corners = ["all"]
[body.pin.motion]
start_time = 2
stop_time = 1
)",
       R"(case.toml:8:13: stop_time is 1 s
  expected later than start_time, 2 s)"},
      {"motion_stops_at_once", sheet + R"([[obstacle]]
name = "ball"
shape = { type = "sphere", radius = 1, resolution = [4] }
motion = { start_time = 1, stop_time = 1.0 }
)",
       R"(case.toml:7:40: stop_time is 1 s
  expected later than start_time, 1 s)"},
      {"keyframes_at_one_time", sheet + R"([[body.pin]]
corners = ["all"]
[body.pin.motion]
keyframes = [
  { time = 0 },
  { time = 1 },
  { time = 1, translation = [0, 0, 1] },
]
)",
       R"(case.toml:10:12: a keyframe at 1 s
  expected later than the keyframe before, 1 s)"},
      {"keyframe_before_start", sheet + R"([[body.pin]]
corners = ["all"]
[body.pin.motion]
keyframes = [{ time = -1 }]
)",
       R"(case.toml:7:23: "time" is -1
  expected a number >= 0 (s))"},
      // Times, tolerances and orders.
      {"position_tolerance_loose",
       R"([time]
position_tolerance = 1e-4
)" + sheet,
       R"(case.toml:2:22: a position_tolerance of 1e-04 m is too loose for a contact.range of 0.002 m
  expected a position_tolerance <= 0.005 of contact.range, 1e-05 m)"},
      {"contact_range_small",
       R"([contact]
range = 1e-3
)" + sheet,
       R"(case.toml:2:9: a position_tolerance of 1e-05 m is too loose for a contact.range of 0.001 m
  expected a position_tolerance <= 0.005 of contact.range, 5e-06 m)"},
      // In doubles, 0.005 of 1e-4 is 5.000000000000001e-07.
      {"contact_range_tiny",
       R"([contact]
range = 1e-4
[time]
position_tolerance = 1e-6
)" + sheet,
       R"(case.toml:4:22: a position_tolerance of 1e-06 m is too loose for a contact.range of 1e-04 m
  expected a position_tolerance <= 0.005 of contact.range, 5e-07 m)"},
      {"velocity_tolerance_loose",
       R"([time]
velocity_tolerance = 0.01
)" + sheet,
       R"(case.toml:2:22: a velocity_tolerance of 0.01 m/s is too loose for a contact.range of 0.002 m
  expected a velocity_tolerance <= 0.5 /s of contact.range, 0.001 m/s)"},
      {"minimum_step_long",
       R"([time]
minimum_step = 0.02
)" + sheet,
       R"(case.toml:2:16: the minimum_step is 0.02 s
  expected less than the time between frames, 0.0166667 s)"},
      {"frames_too_many",
       R"([time]
frames_per_second = 1e8
)" + sheet,
       R"(case.toml:2:21: the minimum_step is 1e-07 s
  expected less than the time between frames, 1e-08 s)"},
      {"maximum_step_short",
       R"([time]
minimum_step = 1e-3
maximum_step = 1e-3
)" + sheet,
       R"(case.toml:3:16: the maximum_step is 0.001 s
  expected more than the minimum_step, 0.001 s)"},
      {"step_of_cvode",
       R"([time]
step = 1e-3
)" + sheet,
       R"(case.toml:2:1: "step" does not belong to method = "cvode"
  expected only with method = "euler", "implicit_midpoint", "verlet", "impulses")"},
      {"newton_of_arkode",
       R"([time]
method = "arkode"
newton = 1
)" + sheet,
       R"(case.toml:3:1: "newton" does not belong to method = "arkode"
  expected only with method = "euler", "implicit_midpoint")"},
      {"midpoint_without_step",
       R"([time]
method = "implicit_midpoint"
)" + sheet,
       R"(case.toml:2:10: this method needs a step
  expected time.step)"},
      {"step_and_longest_step",
       R"([time]
method = "euler"
step = 1e-3
maximum_step = 1e-2
)" + sheet,
       R"(case.toml:4:16: a maximum_step beside a fixed step
  expected one of maximum_step and step)"},
      {"step_below_the_shortest",
       R"([time]
method = "euler"
step = 1e-8
)" + sheet,
       R"(case.toml:3:8: the step is 1e-08 s
  expected more than the minimum_step, 1e-07 s)"},
      {"step_longer_than_the_run",
       R"([time]
duration = 0.5
method = "euler"
step = 0.6
)" + sheet,
       R"(case.toml:4:8: the step is 0.6 s, longer than the run
  expected at most the duration, 0.5 s)"},
      {"order_three_loose",
       R"([time]
maximum_order = 3
[material.cotton]
mass_damping = 1
)" + sheet,
       R"(case.toml:2:17: order 3 is wrong at loose tolerances
  expected a position_tolerance <= 1e-06 with it, or maximum_order = 2)"},
      {"order_five_undamped",
       R"([time]
maximum_order = 5
position_tolerance = 1e-6
[material.cotton]
mass_damping = 1
[material.silk]
)" + sheet +
           R"(material = "silk"
)",
       R"(case.toml:2:17: order 5 is wrong without damping
  expected mass_damping, stiffness_damping or loss_factor > 0 in [material.silk], or maximum_order = 2)"},
      // Overrides are refused at the override, without a line number.
      {"set_without_value",
       R"([material.cotton]
)" + sheet,
       R"(--set contact.friction: no "="
  expected KEY=VALUE)",
       {"contact.friction"}},
      {"set_unknown_key",
       R"([material.cotton]
)" + sheet,
       R"(--set contact.frictoin=1: unknown key "frictoin" in [contact]
  did you mean "friction"?)",
       {"contact.frictoin=1"}},
      {"set_unknown_table",
       R"([material.cotton]
)" + sheet,
       R"(--set contcat.friction=1: unknown key "contcat" in the case
  did you mean "contact"?)",
       {"contcat.friction=1"}},
      {"set_unknown_inner_key",
       R"([material.cotton]
)" + sheet,
       R"(--set body.sheet.shape.sise=[1, 1]: unknown key "sise" in [body.shape]
  did you mean "size"?)",
       {"body.sheet.shape.sise=[1, 1]"}},
      {"set_wrong_type",
       R"([material.cotton]
)" + sheet,
       R"(--set contact.friction=high: "friction" is a string
  expected a number >= 0 or a curve)",
       {"contact.friction=high"}},
      {"set_out_of_range",
       R"([material.cotton]
)" + sheet,
       R"(--set contact.friction=-1: "friction" is -1
  expected a number >= 0 or a curve)",
       {"contact.friction=-1"}},
      {"set_unknown_body",
       R"([material.cotton]
)" + sheet,
       R"(--set body.shet.thickness=1e-3: the case has no "body.shet"
  did you mean "sheet"?)",
       {"body.shet.thickness=1e-3"}},
      {"set_index_outside",
       R"([material.cotton]
)" + sheet,
       R"(--set body.1.thickness=1e-3: the case has no "body.1"
  expected "sheet")",
       {"body.1.thickness=1e-3"}},
      {"set_absent_list",
       R"([material.cotton]
)" + sheet,
       R"(--set obstacle.0.thickness=1e-3: the case has no "obstacle"
  expected it in the case file, or all of it in one override)",
       {"obstacle.0.thickness=1e-3"}},
      {"set_unknown_material",
       R"([material.cotton]
)" + sheet,
       R"(--set material.coton.density=1: the case has no "material.coton"
  did you mean "cotton"?)",
       {"material.coton.density=1"}},
      {"set_below_a_number",
       R"([material.cotton]
)" + sheet,
       R"(--set contact.friction_speed.x=1: "friction_speed" has no keys of its own
  expected a number > 0 (m/s))",
       {"contact.friction_speed.x=1"}},
      {"set_entry_outside",
       R"([material.cotton]
)" + sheet,
       R"(--set body.sheet.shape.size.2=1: "size" has no entry "2"
  expected an index from 0 to 1)",
       {"body.sheet.shape.size.2=1"}},
      {"set_entry_of_absent",
       sheet + R"([[body.pin]]
cols = [0, 0]
)",
       R"(--set body.sheet.pin.0.rows.1=1: the case has no "body[0].pin[0].rows"
  expected it in the case file, or all of it in one override)",
       {"body.sheet.pin.0.rows.1=1"}},
      {"set_whole_entry",
       R"([material.cotton]
)" + sheet,
       R"(--set body.sheet={}: an entry cannot be replaced as a whole
  expected a key of it)",
       {"body.sheet={}"}},
      {"release_before_hold", sheet + R"([[body.pin]]
corners = ["all"]
hold_time = 0.5
release_time = 0.25
)",
       R"(case.toml:7:16: release_time is 0.25 s
  expected later than hold_time, 0.5 s)"},
      {"release_at_the_start", sheet + R"([[body.pin]]
corners = ["all"]
release_time = 0
)",
       R"(case.toml:6:16: "release_time" is 0
  expected a number > 0 (s))"},
      {"hold_before_the_start", sheet + R"([[body.pin]]
corners = ["all"]
hold_time = -1
)",
       R"(case.toml:6:13: "hold_time" is -1
  expected a number >= 0 (s))"},
      {"release_by_a_word", sheet + R"([[body.pin]]
corners = ["all"]
release_time = "never"
)",
       R"(case.toml:6:16: "release_time" is a string
  expected a number > 0 (s))"},
      {"release_in_an_equilibrium",
       R"(time.method = "static"
)" + sheet +
           R"([[body.pin]]
corners = ["all"]
release_time = 0.5
)",
       R"(case.toml:7:16: "release_time" does not go with time.method = "static"
  expected a method that follows the motion in time, or a pin that always holds)"},
      {"hold_in_an_equilibrium_by_override",
       sheet + R"([[body.pin]]
corners = ["all"]
)",
       R"(--set body.sheet.pin.0.hold_time=0.5: "hold_time" does not go with time.method = "static"
  expected a method that follows the motion in time, or a pin that always holds)",
       {"time.method=static", "body.sheet.pin.0.hold_time=0.5"}},
      {"set_rule_broken",
       R"([material.cotton]
)" + sheet,
       R"(--set contact.range=1e-3: a position_tolerance of 1e-05 m is too loose for a contact.range of 0.001 m
  expected a position_tolerance <= 0.005 of contact.range, 5e-06 m)",
       {"time.duration=2", "contact.range=1e-3"}},
      {"set_table_lacks_key",
       R"([material.cotton]
)" + sheet,
       R"(--set body.sheet.shape={ type = "sphere", radius = 1 }: [body.shape] has no "resolution"
  expected "resolution", an array of 1 to 3 whole numbers >= 2)",
       {"body.sheet.shape={ type = \"sphere\", radius = 1 }"}},
      {"set_misplaced_key",
       R"([material.cotton]
)" + sheet,
       R"(--set body.sheet.shape.radius=1: "radius" does not belong to type = "rectangle"
  expected only with type = "disc", "cylinder", "capsule", "cone", "sphere", "sphere_sector", "blob")",
       {"body.sheet.shape.radius=1"}},
  };
}

}  // namespace

class BrokenRule : public testing::TestWithParam<BadCase> {};

TEST_P(BrokenRule, IsRefused) { expect_refused(GetParam()); }

INSTANTIATE_TEST_SUITE_P(Row, BrokenRule, testing::ValuesIn(broken_rules()), bad_case_name);

}  // namespace weft::sim::bad_rule_test
