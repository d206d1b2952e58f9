// `weft modes` and `weft buckling`: tables, objects, files, and what they refuse.
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "sim/command/run_command.h"
#include "sim/trajectory/trajectory.h"
#include "tests/sim/weft_process.h"

namespace weft::sim::command_modes_test {
namespace {

using Json = nlohmann::json;

class CommandModes : public WeftCommand {
 protected:
  static std::string benchmark(const std::string& name) {
    return std::string(WEFT_CASES_DIR) + "/benchmarks/" + name + ".toml";
  }
  // Runs a command on a benchmark of fewer control points.
  Result run(const std::string& command, const std::string& name,
             const WeftProcess::Arguments& more) const {
    WeftProcess::Arguments all{command, benchmark(name), "--quiet", "--set",
                               "body.plate.shape.resolution=[8, 8]"};
    all.insert(all.end(), more.begin(), more.end());
    return weft(all);
  }
  // Expects that nothing is done and written.
  void expect_refused(const Result& result, int code, const std::string& message) const {
    EXPECT_EQ(result.code, code);
    EXPECT_NE(result.err.find(message), std::string::npos) << message << "\nin\n" << result.err;
    EXPECT_FALSE(exists("out"));
  }
};

TEST_F(CommandModes, PrintsFrequencies) {
  const Result result = run("modes", "plate_modes_ffff", {"-n", "7"});
  EXPECT_EQ(result.code, exit_code::done) << result.err;
  EXPECT_EQ(result.err, "");
  EXPECT_NE(result.out.find("Modes about the equilibrium at t = 1 s\n"
                            "mode  frequency Hz   omega rad/s\n"
                            "   1             0             0  rigid motion\n"),
            std::string::npos)
      << result.out;
  EXPECT_NE(result.out.find("192 unknowns"), std::string::npos);
  EXPECT_FALSE(exists("out"));
}

TEST_F(CommandModes, PrintsOneObject) {
  const Result result = run("modes", "plate_modes_ssss", {"-n", "3", "--json"});
  ASSERT_EQ(result.code, exit_code::done) << result.err;
  const Json json = Json::parse(result.out);
  EXPECT_EQ(json["status"], "done");
  EXPECT_EQ(json["exit_code"], 0);
  EXPECT_EQ(json["about"], "equilibrium");
  EXPECT_EQ(json["title"], "Square plate, simply supported");
  EXPECT_TRUE(json["trajectory"].is_null());
  ASSERT_EQ(json["modes"].size(), 3U);
  const Json& first = json["modes"][0];
  EXPECT_EQ(first["kind"], "vibration");
  const double omega = first["angular_frequency_rad_per_s"];
  EXPECT_NEAR(omega, 2 * std::pow(std::numbers::pi, 2), 0.1);
  EXPECT_NEAR(first["frequency_hz"], omega / (2 * std::numbers::pi), 1e-12 * omega);
  EXPECT_NEAR(first["eigenvalue_per_s2"], omega * omega, 1e-9 * omega * omega);
  EXPECT_GT(first["modal_mass_kg"], 0);
  EXPECT_LT(first["error"], 1e-10);
}

TEST_F(CommandModes, PrintsCriticalLoadFactors) {
  const Result result = run("buckling", "plate_buckling", {"-n", "2", "--json"});
  ASSERT_EQ(result.code, exit_code::done) << result.err;
  const Json json = Json::parse(result.out);
  EXPECT_EQ(json["load_factor"], 0);
  ASSERT_EQ(json["modes"].size(), 2U);
  EXPECT_NEAR(json["modes"][0]["load_factor"], 4 * std::pow(std::numbers::pi, 2), 0.5);
  const Result table = run("buckling", "plate_buckling", {"-n", "1"});
  EXPECT_NE(table.out.find("mode  critical load factor\n   1               39."), std::string::npos)
      << table.out;
}

// Frame i is mode i: the equilibrium, displaced by a tenth of the size.
TEST_F(CommandModes, WritesAFrameForEachMode) {
  ASSERT_EQ(run("modes", "plate_modes_ssss", {"-n", "2", "-o", "out"}).code, exit_code::done);
  EXPECT_TRUE(exists("out/plate_modes_ssss_modes.xdmf"));
  const TrajectoryReader reader(path("out/plate_modes_ssss_modes.h5").string());
  ASSERT_EQ(reader.frames(), 3);
  const std::vector<Vec3> rest = reader.positions(0, 0);
  for (int frame = 0; frame < 3; ++frame) {
    EXPECT_EQ(reader.time(frame), frame);
    const std::vector<Vec3> position = reader.positions(0, frame);
    const std::vector<double> way = reader.field_values(0, "displacement", frame);
    double largest = 0;
    for (std::size_t i = 0; i < rest.size(); ++i) {
      for (int axis = 0; axis < 3; ++axis)
        EXPECT_NEAR(position[i][axis], rest[i][axis] + way[3 * i + axis], 1e-6);
      largest = std::max(largest, (position[i] - rest[i]).norm());
    }
    // The control point that moves most is displaced by a tenth; points of the surface by less.
    EXPECT_LE(largest, frame == 0 ? 0 : 0.1 * std::sqrt(2));
    if (frame > 0) {
      EXPECT_GT(largest, 0.11);
    }
  }
  EXPECT_TRUE(std::isnan(reader.series_values("frequency")[0]));
  EXPECT_EQ(reader.series_values("mode")[2], 2);
  EXPECT_NEAR(reader.series_values("frequency")[1], std::numbers::pi, 0.02);
  EXPECT_EQ(reader.end()->status, "done");
  EXPECT_EQ(weft({"info", "out/plate_modes_ssss_modes.h5"}).code, exit_code::done);
}

TEST_F(CommandModes, AnimatesEachModeOverAPeriod) {
  ASSERT_EQ(run("buckling", "plate_buckling", {"-n", "2", "-o", "out", "--animate", "8"}).code,
            exit_code::done);
  const TrajectoryReader reader(path("out/plate_buckling_buckling.h5").string());
  ASSERT_EQ(reader.frames(), 17);
  EXPECT_EQ(reader.time(10), 1.25);
  EXPECT_NEAR(reader.series_values("load_factor")[8], reader.series_values("load_factor")[1], 0);
  const auto height = [&](int frame) {
    return reader.field_values(0, "displacement", frame)[3 * 27 + 2];
  };
  EXPECT_GT(std::abs(height(2)), 0.01);
  EXPECT_NEAR(height(1), std::sqrt(0.5) * height(2), 1e-6);
  EXPECT_NEAR(height(6), -height(2), 1e-6);
  EXPECT_NEAR(height(8), 0, 1e-6);
}

TEST_F(CommandModes, OverwritesOnlyWithForce) {
  const WeftProcess::Arguments once{"-n", "1", "-o", "out"};
  ASSERT_EQ(run("modes", "plate_modes_ssss", once).code, exit_code::done);
  const Result again = run("modes", "plate_modes_ssss", once);
  EXPECT_EQ(again.code, exit_code::input_output);
  EXPECT_EQ(again.out, "");
  EXPECT_EQ(run("modes", "plate_modes_ssss", {"-n", "1", "-o", "out", "--force"}).code,
            exit_code::done);
}

TEST_F(CommandModes, RefusesWhatItCannotDo) {
  expect_refused(run("modes", "plate_modes_ssss", {"-n", "0"}), exit_code::bad_case,
                 "--count: Value 0 not in range 1 to 1000");
  expect_refused(run("modes", "plate_modes_ssss", {"--animate", "8"}), exit_code::bad_case,
                 "--output");
  expect_refused(run("modes", "plate_modes_ssss", {"--set", "time.durations=1"}),
                 exit_code::bad_case, "did you mean \"duration\"?");
  expect_refused(run("buckling", "plate_buckling", {"--load-factor", "nan"}), exit_code::bad_case,
                 "\"nan\" is not a load factor");
  expect_refused(run("buckling", "plate_modes_ssss", {"-o", "out"}), exit_code::bad_case,
                 "plate_modes_ssss.toml:16:1: nothing loads the case");
  for (const char* command : {"modes", "buckling"}) {
    expect_refused(weft({command, benchmark("particles_torus_10000"), "-o", "out"}),
                   exit_code::bad_case, "particles have no part in modes");
  }
}

// A free plate under its weight has no equilibrium (see below). Its start shape has modes: those
// without weight.
TEST_F(CommandModes, TakesTheStartShapeIfAsked) {
  const WeftProcess::Arguments as_it_is{"--set",  "world.gravity.2=-1", "-n", "8",
                                        "--json", "--start-shape"};
  const Result taken = run("modes", "plate_modes_ffff", as_it_is);
  ASSERT_EQ(taken.code, exit_code::done) << taken.err;
  const Json json = Json::parse(taken.out);
  EXPECT_EQ(json["about"], "start_shape");
  const Json weightless = Json::parse(run("modes", "plate_modes_ffff", {"-n", "8", "--json"}).out);
  ASSERT_EQ(json["modes"].size(), 8U);
  for (const int mode : {6, 7}) {
    const double frequency = weightless["modes"][mode]["frequency_hz"];
    EXPECT_GT(frequency, 0);
    EXPECT_NEAR(json["modes"][mode]["frequency_hz"], frequency, 1e-6 * frequency);
  }
}

// A strained start shape that no support holds in its strain still counts as it is: a strip that
// starts stretched sounds higher than the one at rest, to which the equilibrium returns.
TEST_F(CommandModes, KeepsTheStrainOfTheStartShape) {
  const std::string text = R"(
[time]
method = "static"
[world]
gravity = [0, 0, 0]
[contact]
enabled = false
[material.m]
model = "shell"
youngs_modulus = 1e7
poisson_ratio = 0
shell_thickness = 1e-3
volume_density = 1000
[[body]]
name = "strip"
stretch = [1.001, 1, 1]
shape = { type = "rectangle", size = [0.2, 0.02], resolution = [4, 9] }
pin = [{ edges = ["first_col"], clamp = true }]
)";
  write("strip.toml", text);
  const auto first = [&](const WeftProcess::Arguments& more) {
    WeftProcess::Arguments all{"modes", path("strip.toml").string(), "--quiet", "-n", "1",
                               "--json"};
    all.insert(all.end(), more.begin(), more.end());
    const Result result = weft(all);
    EXPECT_EQ(result.code, exit_code::done) << result.err;
    return Json::parse(result.out)["modes"][0]["frequency_hz"].get<double>();
  };
  EXPECT_GT(first({"--start-shape"}), 1.05 * first({}));
}

TEST_F(CommandModes, FailsWithTheReasonAndWithoutAFile) {
  const Result loose = run("buckling", "plate_buckling",
                           {"--set", "body.plate.pin.1.axes=[\"z\"]", "-o", "out", "--json"});
  EXPECT_EQ(loose.code, exit_code::numerical_failure);
  const Json json = Json::parse(loose.out);
  EXPECT_EQ(json["status"], "failed");
  EXPECT_EQ(json["reason_kind"], "solver");
  EXPECT_TRUE(json["modes"].empty());
  EXPECT_NE(loose.err.find("is singular; it is weakest at body \"plate\""), std::string::npos)
      << loose.err;
  EXPECT_FALSE(exists("out"));
  expect_refused(run("modes", "plate_modes_ffff", {"--set", "world.gravity.2=-1", "-o", "out"}),
                 exit_code::numerical_failure, "no equilibrium is found");
}

// The commands keep them even with --force: the case starts from there.
TEST_F(CommandModes, KeepTheFilesOfTheirCase) {
  ASSERT_EQ(weft({"run", benchmark("plate_modes_ssss"), "--quiet", "-o", "first", "--set",
                  "time.duration=0.001", "--set", "output.velocity=true", "--set",
                  "time.method=\"cvode\""})
                .code,
            exit_code::done);
  std::filesystem::create_directory(path("out"));
  for (const std::string file :
       {"out/plate_modes_ssss_modes.h5", "out/plate_modes_ssss_modes.xdmf"}) {
    std::filesystem::copy_file(path("first/plate_modes_ssss.h5"), path(file));
    const std::string before = read_bytes(path(file));
    const Result result = run("modes", "plate_modes_ssss",
                              {"-n", "1", "-o", "out", "--force", "--set",
                               "restart={path=\"" + path(file).string() + "\", time=0}"});
    EXPECT_EQ(result.code, exit_code::bad_case) << result.err;
    EXPECT_NE(result.err.find("the case reads this file"), std::string::npos) << result.err;
    EXPECT_EQ(read_bytes(path(file)), before);
    std::filesystem::remove(path(file));
  }
}

// A force that turns with a free edge has no potential, but a pressure on a held surface has one.
TEST_F(CommandModes, WarnOfWhatTheyLeaveOut) {
  const auto warnings_of = [&](const std::string& pin, const std::string& load,
                               const WeftProcess::Arguments& more) {
    write("case.toml", R"(
[world]
gravity = [0, 0, 0]
[contact]
enabled = false
[material.m]
model = "shell"
youngs_modulus = 1e9
poisson_ratio = 0
shell_thickness = 0.01
volume_density = 1000
[[body]]
name = "strip"
shape = { type = "rectangle", size = [1, 0.1], resolution = [5, 14] }
pin = [{ clamp = true, edges = )" +
                           pin + "}]\n" + load);
    WeftProcess::Arguments all{"modes", path("case.toml").string(), "--json", "-n", "1"};
    all.insert(all.end(), more.begin(), more.end());
    const Result result = weft(all);
    EXPECT_EQ(result.code, exit_code::done) << result.err;
    return Json::parse(result.out)["warnings"];
  };
  const std::string one = "[\"first_col\"]";
  const std::string all = R"(["first_row", "last_row", "first_col", "last_col"])";
  const std::string load = "[[load]]\nbody = \"strip\"\ntype = ";
  const std::string push = load + "\"line\"\nedges = [\"last_col\"]\nforce = [0, 1, 0]\n";
  const std::string pressure = load + "\"pressure\"\npressure = 10\n";
  EXPECT_TRUE(warnings_of(one, push, {}).empty());
  EXPECT_TRUE(warnings_of(all, pressure, {}).empty());
  const Json flutter = warnings_of(one, push + "follower = true\n", {});
  ASSERT_EQ(flutter.size(), 1U);
  EXPECT_NE(std::string(flutter[0]).find("have no potential"), std::string::npos);
  const WeftProcess::Arguments wind{"--set", "world.wind=[-10, 0, 0]"};
  EXPECT_TRUE(warnings_of(one, "", wind).empty());
  WeftProcess::Arguments drag = wind;
  drag.insert(drag.end(), {"--set", "material.m.normal_drag=1"});
  const Json blown = warnings_of(one, "", drag);
  ASSERT_EQ(blown.size(), 1U);
  EXPECT_NE(std::string(blown[0]).find("the wind acts on bodies with drag"), std::string::npos);
}

}  // namespace
}  // namespace weft::sim::command_modes_test
