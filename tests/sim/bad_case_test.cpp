// Case files wrong in one key or value are refused at its place, with a hint.
#include "bad_case.h"

namespace weft::sim::bad_case_test {

namespace {

// Lists one case per row: its name, the text, the whole message.
std::vector<BadCase> bad_texts() {
  return {
      // Texts that are not TOML are refused.
      {"toml_value_missing",
       R"([time]
duration =
)",
       R"(case.toml:2:11: not TOML: Error while parsing key-value pair
  expected value, saw '\n')"},
      {"toml_key_twice",
       R"([time]
duration = 1
duration = 2
)",
       R"(case.toml:3:12: not TOML: Error while parsing key-value pair: cannot redefine existing integer 'duration'
  expected TOML as in https://toml.io)"},
      {"toml_string_left_open",
       R"(title = "drape
)",
       R"(case.toml:1:15: not TOML: Error while parsing string: unescaped control characters other than TAB (U+0009) are explicitly prohibited
  expected TOML as in https://toml.io)"},
      {"toml_header_left_open",
       R"([time
duration = 1
)",
       R"(case.toml:1:6: not TOML: Error while parsing table header
  expected ']', saw '\n')"},
      // Unknown keys are refused at the key.
      {"unknown_table",
       R"([contcat]
friction = 0.3
)" + sheet,
       R"(case.toml:1:2: unknown key "contcat" in the case
  did you mean "contact"?)"},
      {"unknown_key",
       R"([contact]
  frictoin = 0.3
)" + sheet,
       R"(case.toml:2:3: unknown key "frictoin" in [contact]
  did you mean "friction"?)"},
      {"unknown_key_near_nothing",
       R"([world]
moonlight = 1
)" + sheet,
       R"(case.toml:2:1: unknown key "moonlight" in [world]
  expected one of "gravity", "wind", "air_density")"},
      {"unknown_key_of_dotted_keys",
       R"(time.durations = 1
)" + sheet,
       R"(case.toml:1:6: unknown key "durations" in [time]
  did you mean "duration"?)"},
      {"unknown_key_in_inline_table",
       R"([[body]]
name = "ball"
shape = { type = "sphere", radios = 1, resolution = [4] }
)",
       R"(case.toml:3:28: unknown key "radios" in [body.shape]
  did you mean "radius"?)"},
      {"unknown_key_of_pin", sheet + R"([[body.pin]]
corner = ["all"]
)",
       R"(case.toml:5:1: unknown key "corner" in [[body.pin]]
  did you mean "corners"?)"},
      {"unknown_key_first_in_text",
       R"([time]
zeta = 1
alpha = 1
)" + sheet,
       R"(case.toml:2:1: unknown key "zeta" in [time]
  expected one of "method", "duration", "frames_per_second", "scale", "accuracy", "position_tolerance", "velocity_tolerance", "relative_tolerance", "step", "newton", "maximum_order", "minimum_step", "maximum_step", "preconditioner", "sleep")"},
      // Wrong types are refused at the value.
      {"string_for_number",
       R"([time]
duration = "1"
)" + sheet,
       R"(case.toml:2:12: "duration" is a string
  expected a number > 0 (s))"},
      {"boolean_for_number",
       R"([time]
duration = true
)" + sheet,
       R"(case.toml:2:12: "duration" is a boolean
  expected a number > 0 (s))"},
      {"number_for_string",
       R"(title = 3
)" + sheet,
       R"(case.toml:1:9: "title" is a whole number
  expected a string)"},
      {"number_for_boolean",
       R"([contact]
enabled = 1
)" + sheet,
       R"(case.toml:2:11: "enabled" is a whole number
  expected true or false)"},
      {"point_in_whole_number",
       R"([compute]
threads = 2.0
)" + sheet,
       R"(case.toml:2:11: "threads" is a number with a point or exponent
  expected a whole number >= 1 and <= 1024 or "auto")"},
      {"date_for_number",
       R"([time]
duration = 2024-01-01
)" + sheet,
       R"(case.toml:2:12: "duration" is a date or time
  expected a number > 0 (s))"},
      {"number_for_vector",
       R"([world]
gravity = -9.81
)" + sheet,
       R"(case.toml:2:11: "gravity" is a number with a point or exponent
  expected an array of 3 numbers (m/s^2) or a curve)"},
      {"string_in_vector",
       R"([world]
gravity = [0, 0, "down"]
)" + sheet,
       R"(case.toml:2:18: "gravity[2]" is a string
  expected an array of 3 numbers (m/s^2) or a curve)"},
      {"number_for_table",
       R"(time = 1
)" + sheet,
       R"(case.toml:1:8: "time" is a whole number
  expected a table, [time])"},
      {"array_for_table",
       R"([[time]]
duration = 1
)" + sheet,
       R"(case.toml:1:1: "time" is an array
  expected a table, [time])"},
      {"table_for_array_of_tables",
       R"([body]
name = "sheet"
)",
       R"(case.toml:1:1: "body" is a table
  expected tables [[body]])"},
      {"number_in_array_of_tables",
       R"(body = [1]
)",
       R"(case.toml:1:9: "body[0]" is a whole number
  expected tables [[body]])"},
      {"number_for_material",
       R"([material]
density = 0.2
)" + sheet,
       R"(case.toml:2:11: "material.density" is a number with a point or exponent
  expected tables [material.NAME])"},
      {"table_for_pins", sheet + R"([body.pin]
corners = ["all"]
)",
       R"(case.toml:4:1: "pin" is a table
  expected tables [[body.pin]])"},
      // Impossible values are refused at the value.
      {"duration_zero",
       R"([time]
duration = 0
)" + sheet,
       R"(case.toml:2:12: "duration" is 0
  expected a number > 0 (s))"},
      {"duration_not_a_number",
       R"([time]
duration = nan
)" + sheet,
       R"(case.toml:2:12: "duration" is nan
  expected a number > 0 (s))"},
      {"duration_infinite",
       R"([time]
duration = inf
)" + sheet,
       R"(case.toml:2:12: "duration" is inf
  expected a number > 0 (s))"},
      {"frames_negative",
       R"([time]
frames_per_second = -60
)" + sheet,
       R"(case.toml:2:21: "frames_per_second" is -60
  expected a number > 0 (1/s))"},
      {"relative_tolerance_one",
       R"([time]
relative_tolerance = 1
)" + sheet,
       R"(case.toml:2:22: "relative_tolerance" is 1
  expected a number > 0 and < 1)"},
      {"order_six",
       R"([time]
maximum_order = 6
)" + sheet,
       R"(case.toml:2:17: "maximum_order" is 6
  expected a whole number >= 1 and <= 5)"},
      {"threads_beyond_int",
       R"([compute]
threads = 4294967297
)" + sheet,
       R"(case.toml:2:11: "threads" is 4294967297
  expected a whole number >= 1 and <= 1024 or "auto")"},
      {"friction_negative",
       R"([contact]
friction = -0.1
)" + sheet,
       R"(case.toml:2:12: "friction" is -0.1
  expected a number >= 0 or a curve)"},
      {"gravity_infinite",
       R"([world]
gravity = [0, 0, -inf]
)" + sheet,
       R"(case.toml:2:18: "gravity[2]" is -inf
  expected an array of 3 numbers (m/s^2) or a curve)"},
      {"gravity_of_two",
       R"([world]
gravity = [0, -9.81]
)" + sheet,
       R"(case.toml:2:11: "gravity" is an array of 2
  expected an array of 3 numbers (m/s^2) or a curve)"},
      {"density_zero",
       R"([material.cotton]
density = 0.0
)" + sheet,
       R"(case.toml:2:11: "density" is 0
  expected a number > 0 (kg/m^2))"},
      {"density_negative",
       R"([material.cotton]
density = -0.2
)" + sheet,
       R"(case.toml:2:11: "density" is -0.2
  expected a number > 0 (kg/m^2))"},
      {"stiffness_negative",
       R"([material.cotton]
membrane_stiffness = -1
)" + sheet,
       R"(case.toml:2:22: "membrane_stiffness" is -1
  expected a number >= 0 (N/m))"},
      {"poisson_ratio_one",
       R"([material.cotton]
poisson_ratio = 1.0
)" + sheet,
       R"(case.toml:2:17: "poisson_ratio" is 1
  expected a number > -1 and < 1)"},
      {"thickness_negative", sheet + R"(thickness = -1e-3
)",
       R"(case.toml:4:13: "thickness" is -0.001
  expected a number >= 0 (m))"},
      // Wrong names are refused at the value.
      {"enum_misspelt",
       R"([material.cotton]
membrane = "spring"
)" + sheet,
       R"(case.toml:2:12: "membrane" is "spring"
  did you mean "springs"?)"},
      {"enum_near_nothing",
       R"([[body]]
name = "a"
shape = { type = "teapot" }
)",
       R"(case.toml:3:18: "type" is "teapot"
  expected one of "rectangle", "plane", "disc", "annulus", "box", "cylinder", "capsule", "cone", "torus", "sphere", "sphere_sector", "blob", "file")"},
      {"corner_misspelt", sheet + R"([[body.pin]]
corners = ["first_first", "first_lats"]
)",
       R"(case.toml:5:27: "corners[1]" is "first_lats"
  did you mean "first_last"?)"},
      {"edge_misspelt", sheet + R"([[body.pin]]
edges = ["lastrow"]
)",
       R"(case.toml:5:10: "edges[0]" is "lastrow"
  did you mean "last_row"?)"},
      {"name_with_space",
       R"([[body]]
name = "my sheet"
shape = { type = "sphere", radius = 1, resolution = [4] }
)",
       R"(case.toml:2:8: "name" is "my sheet"
  expected a name of letters, digits, _ and -)"},
      {"name_empty",
       R"([[body]]
name = ""
shape = { type = "sphere", radius = 1, resolution = [4] }
)",
       R"(case.toml:2:8: "name" is ""
  expected a name of letters, digits, _ and -)"},
      {"material_name_with_point",
       R"([material."50.50"]
density = 0.2
)" + sheet,
       R"(case.toml:1:11: "50.50" is not a name
  expected a name of letters, digits, _ and -)"},
      {"two_bodies_of_one_name", sheet + sheet,
       R"(case.toml:5:8: a second "sheet"
  expected a name that no other body, obstacle or particles have; the first is in [[body]])"},
      {"obstacle_named_as_body", sheet + R"([[obstacle]]
name = "sheet"
shape = { type = "sphere", radius = 1, resolution = [4] }
)",
       R"(case.toml:5:8: a second "sheet"
  expected a name that no other body, obstacle or particles have; the first is in [[body]])"},
      {"material_unknown",
       R"([material.cotton]
[material.denim]
)" + sheet +
           R"(material = "coton"
)",
       R"(case.toml:6:12: unknown material "coton"
  did you mean "cotton"?)"},
      {"material_unknown_beside_default", sheet + R"(material = "silk"
)",
       R"(case.toml:4:12: unknown material "silk"
  expected "default")"},
      // Missing keys are refused at the header of the table.
      {"case_empty", "",
       R"(case.toml:1:1: the case has no "body"
  expected tables [[body]] or [[particles]])"},
      {"body_none",
       R"(title = "nothing"
[time]
duration = 1
)",
       R"(case.toml:1:1: the case has no "body"
  expected tables [[body]] or [[particles]])"},
      {"body_list_empty",
       R"(body = []
)",
       R"(case.toml:1:8: "body" is an array of 0
  expected tables [[body]])"},
      {"name_missing",
       R"(title = "x"
[[body]]
shape = { type = "sphere", radius = 1, resolution = [4] }
)",
       R"(case.toml:2:1: [[body]] has no "name"
  expected "name", a name of letters, digits, _ and -)"},
      {"shape_missing",
       R"([[body]]
name = "sheet"
)",
       R"(case.toml:1:1: [[body]] has no "shape"
  expected "shape", a table, [body.shape])"},
      {"shape_type_missing",
       R"([[body]]
name = "sheet"
[body.shape]
size = [1, 1]
)",
       R"(case.toml:3:1: [body.shape] has no "type"
  expected "type", one of "rectangle", "plane", "disc", "annulus", "box", "cylinder", "capsule", "cone", "torus", "sphere", "sphere_sector", "blob", "file")"},
      {"size_missing",
       R"([[body]]
name = "sheet"
[body.shape]
type = "rectangle"
resolution = [3, 3]
)",
       R"(case.toml:3:1: [body.shape] has no "size"
  expected "size", an array of 2 to 3 numbers > 0 (m))"},
      {"length_missing",
       R"([[body]]
name = "tube"
shape = { type = "cylinder", radius = 1, resolution = [3, 3] }
)",
       R"(case.toml:3:9: [body.shape] has no "length"
  expected "length", a number > 0 (m))"},
      {"material_not_chosen",
       R"([material.cotton]
[material.denim]
)" + sheet,
       R"(case.toml:3:1: [[body]] "sheet" has no "material"
  expected "material", one of "cotton", "denim")"},
      {"keyframe_time_missing", sheet + R"([[body.pin]]
corners = ["all"]
motion.keyframes = [{ translation = [0, 0, 1] }]
)",
       R"(case.toml:6:21: [[body.pin.motion.keyframes]] has no "time"
  expected "time", a number >= 0 (s))"},
      // A key that does not go with the others is refused at its place.
      {"radius_of_rectangle",
       R"([[body]]
name = "sheet"
shape = { type = "rectangle", size = [1, 1], resolution = [3, 3], radius = 1 }
)",
       R"(case.toml:3:67: "radius" does not belong to type = "rectangle"
  expected only with type = "disc", "cylinder", "capsule", "cone", "sphere", "sphere_sector", "blob")"},
      {"resolution_of_file",
       R"([[body]]
name = "scan"
shape = { type = "file", path = "a.h5", dataset = "x", resolution = [3, 3] }
)",
       R"(case.toml:3:56: "resolution" does not belong to type = "file"
  expected only with type = "rectangle", "disc", "annulus", "box", "cylinder", "capsule", "cone", "torus", "sphere", "sphere_sector", "blob")"},
      {"springs_of_triangles",
       R"([material.cotton]
structural_stiffness = 500
)" + sheet,
       R"(case.toml:2:1: "structural_stiffness" does not belong to membrane = "triangles"
  expected only with membrane = "springs")"},
      {"velocity_with_keyframes", sheet + R"([[body.pin]]
corners = ["all"]
[body.pin.motion]
velocity = [0, 0, 1]
keyframes = [{ time = 0 }]
)",
       R"(case.toml:7:1: "velocity" does not go with "keyframes"
  expected only one of the two)"},
  };
}

}  // namespace

class BadText : public testing::TestWithParam<BadCase> {};

TEST_P(BadText, IsRefused) { expect_refused(GetParam()); }

INSTANTIATE_TEST_SUITE_P(Row, BadText, testing::ValuesIn(bad_texts()), bad_case_name);

TEST(BadFile, MissingIsNamed) {
  try {
    read_case("no_such_case.toml");
    FAIL() << "read";
  } catch (const CaseError& error) {
    EXPECT_STREQ(error.what(),
                 "no_such_case.toml: cannot be read: No such file or directory\n"
                 "  expected a case file");
    EXPECT_EQ(error.where().line, 0);
  }
}

TEST(BadFile, DirectoryIsNamed) {
  try {
    read_case("/");
    FAIL() << "read";
  } catch (const CaseError& error) {
    EXPECT_STREQ(error.what(), "/: is a directory\n  expected a case file");
  }
}

}  // namespace weft::sim::bad_case_test
