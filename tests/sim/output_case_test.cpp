// Cases whose [output] must be refused.
#include "bad_case.h"
#include "sim/scene/recorded_bodies.h"
#include "sim/scene/scene.h"

namespace weft::sim::output_case_test {

namespace {

const std::string still = sheet + "[output]\n";

// Lists one case per row: its name, the text, the whole message.
std::vector<BadCase> bad_outputs() {
  const std::string run = "[time]\nduration = 2\n" + still;  // [output] is line 6
  return {
      {"frame_times_that_repeat", run + "frame_times = [0.5, 1, 1]\n",
       R"(case.toml:7:24: the frame at 1 s follows one at 1 s
  expected increasing times)"},
      {"frame_times_that_fall", run + "frame_times = [0.5, 0.25]\n",
       R"(case.toml:7:21: the frame at 0.25 s follows one at 0.5 s
  expected increasing times)"},
      {"frame_time_before_the_start", run + "frame_times = [-0.5]\n",
       R"(case.toml:7:16: "frame_times[0]" is -0.5
  expected an array of numbers >= 0 (s))"},
      {"frame_time_after_the_end", run + "frame_times = [0, 2.5]\n",
       R"(case.toml:7:19: a frame at 2.5 s is after the end of the run
  expected at most the duration, 2 s)"},
      {"no_frame_times", run + "frame_times = []\n",
       R"(case.toml:7:15: "frame_times" is an array of 0
  expected an array of numbers >= 0 (s))"},
      {"frame_times_of_equilibria",
       "[time]\nmethod = \"static\"\n" + sheet + "pin = [{ edges = [\"first_row\"] }]\n" +
           "[output]\nframe_times = [0.5]\n",
       R"(case.toml:8:15: frame_times with a method that finds equilibria
  expected time.frames_per_second: each frame is an equilibrium)"},
      {"unknown_body", still + "bodies = [\"sheet\", \"shet\"]\n",
       R"(case.toml:5:20: no body, obstacle or group of particles is called "shet"
  did you mean "sheet"?)"},
      {"body_that_is_no_name", still + "bodies = [\"a sheet\"]\n",
       R"(case.toml:5:11: "bodies[0]" is "a sheet"
  expected a name of letters, digits, _ and -)"},
      {"body_twice", still + "bodies = [\"sheet\", \"sheet\"]\n",
       R"(case.toml:5:20: "sheet" again
  expected each name once)"},
      {"no_bodies", still + "bodies = []\n",
       R"(case.toml:5:10: "bodies" is an array of 0
  expected an array of names)"},
      {"part_of_an_unknown_body", still + "[[output.part]]\nbody = \"sheed\"\n",
       R"(case.toml:6:8: no body, obstacle or group of particles is called "sheed"
  did you mean "sheet"?)"},
      {"part_of_nothing", still + "[[output.part]]\nevery = 2\n",
       R"(case.toml:5:1: [[output.part]] has no "body"
  expected "body", a name of letters, digits, _ and -)"},
      {"two_parts_of_a_body",
       still + "[[output.part]]\nbody = \"sheet\"\n[[output.part]]\nbody = \"sheet\"\n",
       R"(case.toml:8:8: a second part of "sheet"
  expected one part for each body)"},
      {"part_of_a_body_that_is_not_recorded",
       still + "bodies = [\"floor\"]\n[[output.part]]\nbody = \"sheet\"\n[[obstacle]]\n" +
           "name = \"floor\"\nshape = { type = \"sphere\", radius = 1, resolution = [5] }\n",
       R"(case.toml:7:8: "sheet" is not recorded
  expected a name that output.bodies lists: "floor")"},
      {"rows_of_a_part_outside", still + "[[output.part]]\nbody = \"sheet\"\nrows = [0, 5]\n",
       R"(case.toml:7:12: no row 5
  expected -5 to 4)"},
      {"columns_of_a_part_outside", still + "[[output.part]]\nbody = \"sheet\"\ncols = [-10, 5]\n",
       R"(case.toml:7:9: no column -10
  expected -9 to 8)"},
      {"rows_of_a_part_in_reverse", still + "[[output.part]]\nbody = \"sheet\"\nrows = [3, 1]\n",
       R"(case.toml:7:8: an empty range of rows
  expected [first, last], first <= last)"},
      {"part_of_every_zeroth", still + "[[output.part]]\nbody = \"sheet\"\nevery = 0\n",
       R"(case.toml:7:9: "every" is 0
  expected a whole number >= 1)"},
      {"unknown_compression", still + "compression = \"losless\"\n",
       R"(case.toml:5:15: "compression" is "losless"
  did you mean "lossless"?)"},
      {"unknown_precision", still + "precision = \"float46\"\n",
       R"(case.toml:5:13: "precision" is "float46"
  did you mean "float64"?)"},
      {"compression_error_of_zero", still + "compression = \"bounded\"\ncompression_error = 0\n",
       R"(case.toml:6:21: "compression_error" is 0
  expected a number > 0 (m))"},
      {"compression_error_without_a_bound",
       still + "compression = \"lossless\"\ncompression_error = 1e-6\n",
       R"(case.toml:6:1: "compression_error" does not belong to compression = "lossless"
  expected only with compression = "bounded")"},
  };
}

class BadOutput : public testing::TestWithParam<BadCase> {};

TEST_P(BadOutput, IsRefusedWithItsPlaceAndAHint) { expect_refused(GetParam()); }

INSTANTIATE_TEST_SUITE_P(All, BadOutput, testing::ValuesIn(bad_outputs()), bad_case_name);

}  // namespace

// A row or a column alone is no surface; only the scene knows that of shapes from files.
TEST(OutputPart, OfOneRowIsRefused) {
  const std::string text = sheet + "[[output.part]]\nbody = \"sheet\"\nrows = [3, 3]\n";
  try {
    build_scene(parse_case(text, "case.toml"));
    ADD_FAILURE();
  } catch (const CaseError& error) {
    EXPECT_EQ(std::string(error.what()),
              "case.toml:4:1: a part of 1 row\n  expected at least 2, as a surface needs");
  }
}

// Sheets of 1 mm are kept 1 mm apart. float32 rounds a position 8 km from the origin by up to
// 8000 m / 2^24 = 0.48 mm, one 9 km from it by 0.54 mm.
TEST(OutputRounding, IsNoticedWhereSurfacesMayCrossInFrames) {
  const auto notice_of = [](const std::string& keys) {
    const std::string text = sheet + "thickness = 1e-3\n" + keys;
    return rounding_notice(*build_scene(parse_case(text, "case.toml")));
  };
  EXPECT_EQ(notice_of("position = [0, 8000, 0]\n"), "");
  // Gaps keep surfaces without a thickness apart: of a part of the range, 2 mm.
  EXPECT_EQ(notice_of("position = [0, 10, 0]\n[[obstacle]]\nname = \"thin\"\nthickness = 0\n"
                      "shape = { type = \"sphere\", radius = 1, resolution = [5] }\n"),
            "");
  EXPECT_EQ(notice_of("position = [0, 9000, 0]\n"),
            "body \"sheet\" is 9000.5 m from the origin: float32 rounds its positions by up to "
            "0.000536472 m, more than half of what keeps surfaces apart, and surfaces may cross in "
            "frames; "
            "output.precision = \"float64\" shows them as they are");
  EXPECT_EQ(notice_of("position = [0, 9000, 0]\n[output]\nprecision = \"float64\"\n"), "");
  EXPECT_EQ(notice_of("position = [0, 9000, 0]\n[[obstacle]]\nname = \"post\"\n"
                      "shape = { type = \"sphere\", radius = 1, resolution = [5] }\n"
                      "[output]\nbodies = [\"post\"]\n"),
            "");
}

}  // namespace weft::sim::output_case_test
