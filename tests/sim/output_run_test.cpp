// [outputs] of cases, and `weft outputs`.
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "bad_case.h"
#include "sim/case/located_text.h"
#include "sim/command/run_command.h"
#include "sim/run/recorded_run.h"
#include "tests/sim/weft_process.h"

namespace weft::sim::output_run_test {
namespace {

// A sheet of 5 x 5 vertices swings from one edge.
constexpr const char* swing = R"([time]
duration = 0.2
[contact]
enabled = false
[output]
channels = ["velocity", "reactions"]
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [0.1, 0.1], resolution = [5, 5] }
[[body.pin]]
edges = ["first_row"]
[outputs]
)";

std::vector<BadCase> bad_outputs() {
  return {{"number", sheet + "[outputs]\na = 1\n",
           R"_(case.toml:5:5: "outputs.a" is a whole number
  expected an expression in quotes, such as "max(largest_stretch)")_"},
          {"no_table", "outputs = \"max(largest_stretch)\"\n" + sheet,
           R"(case.toml:1:11: "outputs" is a string
  expected a table, [outputs])"},
          {"bad_name", sheet + "[outputs]\n\"a b\" = \"1\"\n",
           R"(case.toml:5:1: "a b" is not a name
  expected a name of letters, digits, _ and -)"},
          {"key_of_an_output",
           sheet,
           R"(--set outputs.a.b=1: "a" has no keys of its own
  expected an expression)",
           {"outputs.a.b=1"}}};
}

class BadOutputs : public testing::TestWithParam<BadCase> {};
TEST_P(BadOutputs, AreRefusedWithTheirPlaceAndAHint) { expect_refused(GetParam()); }
INSTANTIATE_TEST_SUITE_P(All, BadOutputs, testing::ValuesIn(bad_outputs()), bad_case_name);

TEST(Outputs, AreReadInTheOrderOfTheFile) {
  const std::string text = sheet + "[outputs]\nb = \"1 + \\\"\"\na = '''\n2'''\n";
  const Case source = parse_case(text, "case.toml", {"outputs.c=max(time)", "outputs.0=3"});
  ASSERT_EQ(source.outputs.size(), 4U);
  EXPECT_EQ(source.outputs[0].name, "b");
  EXPECT_EQ(source.outputs[0].text.text, "1 + \"");
  EXPECT_EQ(source.outputs[0].text.at(4).column, 10);
  EXPECT_EQ(source.outputs[1].name, "a");
  EXPECT_EQ(source.outputs[1].text.at(0).line, 7);
  EXPECT_EQ(source.outputs[1].text.at(0).column, 1);
  EXPECT_EQ(source.outputs[2].text.text, "3");
  EXPECT_EQ(source.outputs[3].text.text, "max(time)");
  // The resolved case has them too.
  const Case again = parse_case(source.resolved_text, "case.toml");
  ASSERT_EQ(again.outputs.size(), 4U);
  EXPECT_EQ(again.outputs[0].text.text, "1 + \"");
  EXPECT_EQ(again.resolved_text, source.resolved_text);
}

class OutputRun : public WeftCommand {
 protected:
  std::string trajectory(const std::string& name) const { return path(name).string(); }
};

TEST_F(OutputRun, ReportsTheOutputsOfTheCase) {
  const Case source = parse_case(std::string(swing) +
                                     "low = \"min(lower('sheet').z)\"\n"
                                     "stretch = \"max(largest_stretch)\"\n"
                                     "steps = \"last(steps)\"\n"
                                     "never = \"first_time(largest_stretch > 99)\"\n"
                                     "cost = \"cpu_time >= 0\"\n",
                                 "swing.toml");
  RunOptions options;
  options.trajectory = trajectory("swing.h5");
  const RunReport report = run_simulation(source, options);
  ASSERT_EQ(report.outputs.size(), 5U);
  EXPECT_EQ(report.outputs[0].first, "low");
  EXPECT_LT(report.outputs[0].second, -0.01);
  EXPECT_EQ(report.outputs[1].second, report.largest_stretch);
  EXPECT_EQ(report.outputs[2].second, static_cast<double>(report.counts.steps));
  EXPECT_TRUE(std::isnan(report.outputs[3].second));
  EXPECT_EQ(report.outputs[4].second, 1);
}

TEST_F(OutputRun, UsesTheMeasuredError) {
  const std::string text = std::string(swing) + "error = \"max(error_estimate_sheet)\"\n";
  RunOptions options;
  options.trajectory = trajectory("swing.h5");
  options.estimate_error = true;
  const RunReport report = run_simulation(parse_case(text, "swing.toml"), options);
  EXPECT_EQ(report.outputs.at(0).second, report.error_estimate->bodies.at(0).largest);
  // Without the measurement, there is no such series.
  write("swing.toml", text);
  const Result refused = weft({"check", "swing.toml"});
  EXPECT_EQ(refused.code, exit_code::bad_case);
  EXPECT_EQ(refused.err.substr(0, refused.err.find('\n')),
            "swing.toml:13:14: unknown name \"error_estimate_sheet\"");
}

// A sheet falls by 2 mm and comes to rest on a floor, which carries its weight.
TEST_F(OutputRun, MeasuresASheetAtRest) {
  const std::string text = R"_([time]
duration = 0.5
[output]
channels = ["reactions", "contact_force", "membrane_strain"]
[material.cloth]
density = 0.2
mass_damping = 20
stiffness_damping = 1e-3
[[body]]
name = "sheet"
position = [0, 0, 0.005]
shape = { type = "rectangle", size = [0.1, 0.1], resolution = [5, 5] }
[[obstacle]]
name = "floor"
shape = { type = "rectangle", size = [1, 1], resolution = [3, 3] }
[outputs]
weight = "last(record('reactions/floor/force').z)"
pressed = "last(largest('contact_force', 'sheet'))"
strain = "last(largest('membrane_strain_major', 'sheet'))"
drop = "last(displacement('sheet', -1, -1).z)"
wide = "last(size('sheet').x)"
shadow = "last(shadow('sheet').z)"
touch = "first_time(smallest_gap < 2e-3)"
speed = "last(energy_kinetic) / max(energy_kinetic)"
)_";
  RunOptions options;
  options.trajectory = trajectory("rest.h5");
  const RunReport report = run_simulation(parse_case(text, "rest.toml"), options);
  ASSERT_EQ(report.status, RunReport::Status::done) << report.reason;
  std::map<std::string, double> values(report.outputs.begin(), report.outputs.end());
  const double weight = 0.2 * 0.01 * 9.81;  // N
  EXPECT_NEAR(values.at("weight"), weight, 0.05 * weight);
  // The weight of an inner vertex is a sixteenth of the whole.
  EXPECT_NEAR(values.at("pressed"), weight / 16, 0.05 * weight / 16);
  EXPECT_LT(std::abs(values.at("strain")), 1e-3);
  EXPECT_LT(values.at("drop"), -0.001);
  EXPECT_GT(values.at("drop"), -0.005);
  EXPECT_NEAR(values.at("wide"), 0.1, 1e-4);
  EXPECT_NEAR(values.at("shadow"), 0.01, 1e-4);
  EXPECT_GT(values.at("touch"), 0);
  EXPECT_LT(values.at("touch"), 0.1);
  EXPECT_LT(values.at("speed"), 0.01);
}

TEST_F(OutputRun, RefusesOutputsBeforeAnythingIsWritten) {
  write("swing.toml", std::string(swing) + "low = \"min(lower(\\\"shet\\\").z)\"\n");
  const std::string message =
      "swing.toml:13:18: no body \"shet\" is recorded\n  did you mean \"sheet\"?\n";
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"run", "swing.toml"},
        {"run", "swing.toml", "--set", "time.accuracy=1e-3"},
        {"check", "swing.toml"}}) {
    const Result refused = weft(arguments);
    EXPECT_EQ(refused.code, exit_code::bad_case);
    EXPECT_EQ(refused.err, message);
    EXPECT_FALSE(exists("out"));
  }
}

TEST_F(OutputRun, ComputesOutputsOfATrajectory) {
  write("swing.toml", std::string(swing) + "stretch = \"max(largest_stretch)\"\n");
  const Result run = weft({"run", "swing.toml", "--json", "--quiet"});
  ASSERT_EQ(run.code, 0) << run.err;
  const auto report = nlohmann::json::parse(run.out);
  const double stretch = report["outputs"]["stretch"];
  EXPECT_EQ(stretch, report["largest_stretch"]);
  const Result recorded = weft({"outputs", "out/swing.h5", "--json"});
  EXPECT_EQ(nlohmann::json::parse(recorded.out)["stretch"], stretch) << recorded.err;
  // New probes are evaluated on the old trajectory.
  const Result added =
      weft({"outputs", "out/swing.h5", "pull = max(record(\"reactions/sheet/pin_1/force\").z)",
            "none = 0/0", "--json"});
  ASSERT_EQ(added.code, 0) << added.err;
  const auto values = nlohmann::json::parse(added.out);
  EXPECT_GT(values["pull"], 0.2 * 0.01 * 9.81 * 0.2);
  EXPECT_TRUE(values["none"].is_null());
  EXPECT_EQ(weft({"outputs", "out/swing.h5", "n = frames"}).out, "n  13\n");
}

TEST_F(OutputRun, RefusesExpressionsAtFault) {
  write("swing.toml", swing);
  ASSERT_EQ(weft({"run", "swing.toml", "--quiet"}).code, 0);
  const Result none = weft({"outputs", "out/swing.h5"});
  EXPECT_EQ(none.code, exit_code::bad_case);
  EXPECT_EQ(none.err,
            "out/swing.h5: its case has no [outputs]\n  expected NAME = EXPRESSION, such "
            "as 'stretch = max(largest_stretch)'\n");
  const Result wrong = weft({"outputs", "out/swing.h5", "a = max(largest_strech)"});
  EXPECT_EQ(wrong.code, exit_code::bad_case);
  EXPECT_EQ(wrong.err,
            "output a: unknown name \"largest_strech\" (character 5 of "
            "\"max(largest_strech)\")\n  did you mean \"largest_stretch\"?\n");
  EXPECT_EQ(weft({"outputs", "missing.h5", "a = 1"}).code, exit_code::input_output);
}

}  // namespace
}  // namespace weft::sim::output_run_test
