// Shells that must be refused, with place and hint.
#include <hdf5.h>

#include <array>
#include <functional>

#include "sim/case/case_error.h"
#include "sim/scene/scene.h"
#include "tests/sim/bad_case.h"
#include "tests/temporary_folder.h"

namespace weft::sim::bad_shell_test {

namespace {

// A shell of 5 x 9 control points with this modulus (line 3) and this ratio (line 4), and with more
// keys from line 7 on.
std::string shell(const std::string& modulus, const std::string& ratio,
                  const std::string& more = "") {
  return "[material.m]\nmodel = \"shell\"\nyoungs_modulus = " + modulus +
         "\npoisson_ratio = " + ratio + "\nshell_thickness = 1e-3\nvolume_density = 1000\n" + more;
}

// Lists one case per row: its name, the text, the whole message.
std::vector<BadCase> bad_shells() {
  return {
      {"modulus_of_zero", shell("0", "0.3") + sheet,
       R"(case.toml:3:18: "youngs_modulus" is 0
  expected a number > 0 (Pa))"},
      {"negative_modulus", shell("-1e9", "0.3") + sheet,
       R"(case.toml:3:18: "youngs_modulus" is -1e+09
  expected a number > 0 (Pa))"},
      {"ratio_beyond_a_half", shell("1e9", "0.6") + sheet,
       R"(case.toml:4:17: poisson_ratio is 0.6
  expected at most 0.5 with model = "shell": a solid whose ratio is larger would gain energy under pressure)"},
      {"ratio_of_minus_one", shell("1e9", "-1") + sheet,
       R"(case.toml:4:17: "poisson_ratio" is -1
  expected a number > -1 and < 1)"},
      {"ratio_below_minus_one", shell("1e9", "-1.5") + sheet,
       R"(case.toml:4:17: "poisson_ratio" is -1.5
  expected a number > -1 and < 1)"},
      {"no_modulus",
       "[material.m]\nmodel = \"shell\"\nshell_thickness = 1e-3\nvolume_density = 1000\n" + sheet,
       R"(case.toml:1:1: [material.m] has no "youngs_modulus"
  expected "youngs_modulus", a number > 0 (Pa))"},
      {"no_thickness",
       "[material.m]\nmodel = \"shell\"\nyoungs_modulus = 1e9\nvolume_density = 1000\n" + sheet,
       R"(case.toml:1:1: [material.m] has no "shell_thickness"
  expected "shell_thickness", a number > 0 (m))"},
      {"membrane_of_cloth", shell("1e9", "0.3", "membrane_stiffness = 10\n") + sheet,
       R"(case.toml:7:1: "membrane_stiffness" does not belong to model = "shell"
  expected only with model = "cloth")"},
  };
}

class BadShell : public testing::TestWithParam<BadCase> {};
TEST_P(BadShell, IsRefused) { expect_refused(GetParam()); }
INSTANTIATE_TEST_SUITE_P(All, BadShell, testing::ValuesIn(bad_shells()), bad_case_name);

// Images that are found too small when the scene is built.
std::vector<BadCase> small_images() {
  return {
      {"too_few_control_points",
       shell("1e9", "0.3") +
           "[[body]]\nname = \"s\"\nshape = { type = \"rectangle\", size = [1, 1], resolution = "
           "[3, 8] }\n",
       R"(case.toml:9:9: the image of "s" has 3 x 8 control points
  expected at least 4 x 4 with spline_degree = 3)"},
      {"too_few_for_degree_two",
       shell("1e9", "0.3", "spline_degree = 2\n") +
           "[[body]]\nname = \"s\"\nshape = { type = \"rectangle\", size = [1, 1], resolution = "
           "[2, 8] }\n",
       R"(case.toml:10:9: the image of "s" has 2 x 8 control points
  expected at least 3 x 3 with spline_degree = 2)"},
  };
}

class SmallImage : public testing::TestWithParam<BadCase> {};
TEST_P(SmallImage, IsRefused) {
  try {
    static_cast<void>(build_scene(parse_case(GetParam().text, "case.toml")));
    FAIL() << "accepted:\n" << GetParam().text;
  } catch (const CaseError& error) {
    EXPECT_EQ(error.what(), GetParam().what);
  }
}
INSTANTIATE_TEST_SUITE_P(All, SmallImage, testing::ValuesIn(small_images()), bad_case_name);

// The largest ratio of a solid, and one near the smallest, are accepted.
TEST(BadShell, RatiosOfSolidsAreAccepted) {
  for (const char* ratio : {"0.5", "0", "-0.99"})
    EXPECT_NO_THROW(build_scene(parse_case(shell("1e9", ratio) + sheet, "case.toml"))) << ratio;
}

// Shells whose image of 5 x 9 points comes from a file.
class ShellOfFile : public testing::Test {
 protected:
  using Place = std::function<std::array<double, 3>(int row, int col)>;
  // Returns the message of the refusal, without the folder.
  std::string refusal(const Place& place, const std::string& more = "") const {
    std::vector<double> values;
    for (int i = 0; i < 45; ++i) {
      for (const double each : place(i / 9, i % 9)) values.push_back(each);
    }
    write(values);
    const std::string text =
        shell("1e9", "0.3") +
        "[[body]]\nname = \"s\"\nshape = { type = \"file\", path = \"shape.h5\", dataset = "
        "\"shape\" }\n" +
        more;
    try {
      static_cast<void>(build_scene(parse_case(text, folder_.path("case.toml"))));
    } catch (const CaseError& error) {
      const std::string what = error.what();
      return what.substr(what.find("case.toml"));
    }
    return "accepted";
  }

 private:
  void write(const std::vector<double>& values) const {
    const std::array<hsize_t, 3> dimensions{5, 9, 3};
    const hid_t file =
        H5Fcreate(folder_.path("shape.h5").c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    const hid_t space = H5Screate_simple(3, dimensions.data(), nullptr);
    const hid_t dataset =
        H5Dcreate2(file, "shape", H5T_IEEE_F64LE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    H5Dwrite(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    H5Dclose(dataset);
    H5Sclose(space);
    H5Fclose(file);
  }
  TemporaryFolder folder_;
};

TEST_F(ShellOfFile, IsAcceptedIfItIsRegular) {
  EXPECT_EQ(refusal([](int row, int col) {
              return std::array{0.1 * col, 0.1 * row, 0.01 * col * col};
            }),
            "accepted");
}

// A column of points that lies on the one before.
TEST_F(ShellOfFile, OfCollapsedPointsIsRefused) {
  for (const char* more : {"", "control_net = true\n"}) {
    EXPECT_EQ(
        refusal(
            [](int row, int col) {
              return std::array{0.1 * (col == 4 ? 3 : col), 0.1 * row, 0.0};
            },
            more),
        R"(case.toml:9:9: the rest shape of "s" has a triangle without area at patch 0, row 0, column 3
  expected vertices that do not coincide or lie on one line)")
        << more;
  }
}

// All points on one line.
TEST_F(ShellOfFile, OfALineIsRefused) {
  EXPECT_EQ(
      refusal([](int row, int col) {
        return std::array{0.1 * (col + 9 * row), 0.0, 0.0};
      }),
      R"(case.toml:9:9: the rest shape of "s" has a triangle without area at patch 0, row 0, column 0
  expected vertices that do not coincide or lie on one line)");
}

// A column of points behind the one before: the triangles have area, but the surface turns over.
TEST_F(ShellOfFile, ThatFoldsBackIsRefused) {
  for (const char* more : {"", "control_net = true\n"}) {
    EXPECT_EQ(
        refusal(
            [](int row, int col) {
              return std::array{0.1 * (col == 5 ? 3.2 : col), 0.1 * row, 0.0};
            },
            more),
        R"(case.toml:9:9: the rest surface of "s" has no area or folds back on itself near row 0, column 4 of the image
  expected points that do not coincide, and a surface that turns by less than 90 degrees from each point of the image to the next)")
        << more;
  }
}

// A surface that crosses itself within a row of cells: its rows run in opposite directions.
TEST_F(ShellOfFile, ThatIsTwistedIsRefused) {
  EXPECT_EQ(
      refusal([](int row, int col) {
        return std::array{0.1 * (row < 2 ? col - 4 : 4 - col), 0.1 * row, 0.0};
      }),
      R"(case.toml:9:9: the rest surface of "s" has no area or folds back on itself near row 2, column 0 of the image
  expected points that do not coincide, and a surface that turns by less than 90 degrees from each point of the image to the next)");
}

}  // namespace

}  // namespace weft::sim::bad_shell_test
