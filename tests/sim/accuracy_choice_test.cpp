// The choice of a method and its tolerances for an accuracy, and the resulting error.
#include "sim/accuracy/accuracy_choice.h"

#include <cmath>

#include "sim/accuracy/accuracy_pilot.h"
#include "sim/case/case_error.h"
#include "sim/motion/energy_watch.h"
#include "simulated_case.h"

namespace weft::sim::accuracy_choice_test {
namespace {

const std::string hanging_sheet = R"(
[time]
duration = 0.2
[contact]
enabled = false
[material.cloth]
membrane_stiffness = 400
stiffness_damping = 2e-3
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [0.8, 0.8], resolution = [11, 11] }
[[body.pin]]
corners = ["last_first", "last_last"]
)";

const std::string swinging_strip = R"(
[time]
duration = 0.2
[contact]
enabled = false
[material.plastic]
density = 0.4
membrane_stiffness = 2000
bending_stiffness = 1e-3
stiffness_damping = 5e-4
bending_damping = 2e-3
[[body]]
name = "strip"
shape = { type = "rectangle", size = [0.3, 0.08], resolution = [5, 17] }
[[body.pin]]
cols = [0, 1]
)";

const std::string undamped_drum = R"(
[time]
duration = 0.1
[contact]
enabled = false
[material.skin]
density = 0.3
membrane_stiffness = 800
[[body]]
name = "drum"
velocity = [0, 0, 1.5]
shape = { type = "rectangle", size = [0.6, 0.6], resolution = [9, 9] }
[[body.pin]]
edges = ["first_row", "last_row", "first_col", "last_col"]
)";

Case chosen(const std::string& text, const Overrides& overrides) {
  Case source = parse_case(text, "test.toml", overrides);
  choose_accuracy(source);
  return source;
}

std::string refusal(const std::string& text, const Overrides& overrides) {
  try {
    chosen(text, overrides);
  } catch (const CaseError& error) {
    return error.what();
  }
  return "";
}

double largest_error(const std::string& text, const Overrides& overrides) {
  Case source = parse_case(text, "test.toml", overrides);
  correct_accuracy(source);
  SimulatedCase run(source.resolved_text);
  SimulatedCase exact(text, {"time.position_tolerance=1e-9", "time.relative_tolerance=1e-8"});
  double largest = 0;
  for (int frame = 1; frame <= 20; ++frame) {
    const double time = run.scene().source.time.duration * frame / 20;
    largest = std::max(largest, position_difference(run.advance_to(time), exact.advance_to(time)));
  }
  return largest;
}

// The benchmark `weft bench calibrate --verify` does the same on larger scenes.
TEST(AccuracyChoice, IsKeptWithinAFactorThree) {
  for (const std::string& scene : {hanging_sheet, swinging_strip, undamped_drum}) {
    for (const double asked : {1e-3, 1e-4}) {
      SCOPED_TRACE(scene);
      const std::string accuracy = "time.accuracy=" + std::to_string(asked);
      EXPECT_LT(largest_error(scene, {accuracy}), asked * 3);
      const double error = largest_error(scene, {accuracy, "time.method=cvode"});
      EXPECT_LT(error, asked * 3);
      // The errors of an undamped drum shrink faster with the tolerance than those of other scenes.
      if (scene != undamped_drum) {
        EXPECT_GT(error, asked / 3);
      }
    }
  }
}

TEST(AccuracyChoice, TightensWithTheAccuracyAndTheDuration) {
  const auto tolerance = [](const Overrides& overrides) {
    return chosen(hanging_sheet, overrides).time.position_tolerance;
  };
  const Overrides method{"time.method=cvode"};
  const double base = tolerance({"time.accuracy=1e-3", method[0]});
  EXPECT_LT(tolerance({"time.accuracy=2e-4", method[0]}), base);
  // The error per second decides the tolerance.
  EXPECT_DOUBLE_EQ(tolerance({"time.accuracy=2e-3", "time.duration=0.4", method[0]}), base);
}

TEST(AccuracyChoice, SaysWhatItChoseAndWritesACaseThatRunsTheSame) {
  const Case source = chosen(hanging_sheet, {"time.accuracy=5e-4"});
  EXPECT_NE(source.accuracy_choice.find("for an accuracy of 0.0005 m over 0.2 s"),
            std::string::npos)
      << source.accuracy_choice;
  const Case again = parse_case(source.resolved_text, "again.toml");
  EXPECT_FALSE(again.time.accuracy);
  EXPECT_EQ(again.time.method, source.time.method);
  EXPECT_EQ(again.time.position_tolerance, source.time.position_tolerance);
  EXPECT_EQ(again.time.relative_tolerance, source.time.relative_tolerance);
  EXPECT_EQ(chosen(hanging_sheet, {}).accuracy_choice, "");
}

TEST(AccuracyChoice, IsCorrectedByAPilotRun) {
  const Case first = chosen(hanging_sheet, {"time.accuracy=5e-4"});
  Case corrected = first;
  correct_accuracy(corrected);
  EXPECT_NE(corrected.time.position_tolerance, first.time.position_tolerance);
  EXPECT_NE(corrected.accuracy_choice.find("a pilot run finds"), std::string::npos);
  EXPECT_EQ(parse_case(corrected.resolved_text, "again.toml").time.position_tolerance,
            corrected.time.position_tolerance);
  Case plain = chosen(hanging_sheet, {});
  correct_accuracy(plain);
  EXPECT_EQ(plain.time.position_tolerance, chosen(hanging_sheet, {}).time.position_tolerance);
}

// Explicit steps suit motion whose stiffness is small beside its duration. They are more exact than
// requested, since longer ones are unstable.
TEST(AccuracyChoice, TakesVerletWhereThatIsLessWork) {
  const std::string pinned = R"(
[time]
duration = 0.2
[contact]
enabled = false
[material.cloth]
membrane_stiffness = 1000
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [1.0, 1.0], resolution = [13, 13] }
[[body.pin]]
corners = ["last_first", "last_last"]
)";
  const auto corrected = [&](const Overrides& overrides) {
    Case source = chosen(pinned, overrides);
    correct_accuracy(source);
    return source;
  };
  const Case source = corrected({"time.accuracy=1e-3"});
  EXPECT_EQ(source.time.method, TimeMethod::verlet) << source.accuracy_choice;
  EXPECT_NE(source.accuracy_choice.find("less work than cvode"), std::string::npos);
  const Case again = parse_case(source.resolved_text, "again.toml");
  EXPECT_EQ(again.time.method, TimeMethod::verlet);
  EXPECT_EQ(again.time.relative_tolerance, source.time.relative_tolerance);
  EXPECT_LT(largest_error(pinned, {"time.accuracy=1e-3"}), 1e-3);
  const auto method_of = [&](const std::string& override) {
    return corrected({"time.accuracy=1e-3", override}).time.method;
  };
  EXPECT_EQ(method_of("time.method=cvode"), TimeMethod::cvode);
  EXPECT_EQ(method_of("contact.enabled=true"), TimeMethod::cvode);
  EXPECT_EQ(method_of("material.cloth.stiffness_damping=1e-2"), TimeMethod::cvode);
  EXPECT_EQ(method_of("material.cloth.strain_limit=0.5"), TimeMethod::cvode);
}

TEST(AccuracyChoice, KeepsTheMethodOfTheCase) {
  const Case source = chosen(hanging_sheet, {"time.accuracy=5e-4", "time.method=cvode"});
  EXPECT_EQ(source.time.method, TimeMethod::cvode);
  EXPECT_NE(source.accuracy_choice.find("the method is that of the case"), std::string::npos);
  EXPECT_NE(refusal(hanging_sheet, {"time.accuracy=5e-4", "time.method=verlet"})
                .find("expected no method beside \"accuracy\", or one of \"cvode\", \"arkode\", "
                      "\"euler\""),
            std::string::npos);
}

TEST(AccuracyChoice, DoesNotGoWithTolerances) {
  for (const char* key : {"position_tolerance", "velocity_tolerance", "relative_tolerance"}) {
    const std::string message =
        refusal(hanging_sheet, {"time.accuracy=5e-4", std::string("time.") + key + "=1e-5"});
    EXPECT_NE(message.find(std::string(key) + "\" does not go with \"accuracy\""),
              std::string::npos)
        << message;
  }
}

TEST(AccuracyChoice, RefusesWhatIsFinerThanTheCalibrationAndSaysWhatItCovers) {
  const std::string message = refusal(hanging_sheet, {"time.accuracy=1e-9"});
  EXPECT_NE(message.find("over 0.2 s"), std::string::npos) << message;
  EXPECT_NE(message.find(" m (cvode)"), std::string::npos) << message;
}

TEST(AccuracyChoice, TakesTheCoarsestOfTheCalibrationWhereLessWouldDo) {
  const Case source = chosen(hanging_sheet, {"time.accuracy=1", "time.method=cvode"});
  EXPECT_NE(source.accuracy_choice.find("so the error will be smaller"), std::string::npos)
      << source.accuracy_choice;
}

TEST(AccuracyChoice, StaysWithinWhatContactAllows) {
  const std::string text = R"(
[contact]
range = 1e-3
[[body]]
name = "sheet"
thickness = 0
shape = { type = "rectangle", size = [1.0, 1.0], resolution = [5, 5] }
)";
  const Case source = chosen(text, {"time.accuracy=1e-2", "time.method=cvode"});
  EXPECT_EQ(source.time.position_tolerance, 0.005 * 1e-3);
  EXPECT_NE(source.accuracy_choice.find("so the error will be smaller"), std::string::npos)
      << source.accuracy_choice;
}

// Returns the message of the energy watch for the whole run, or the run's failure.
std::string complaint(const Case& source) {
  const auto scene = build_scene(source);
  Statistics statistics;
  Dynamics dynamics(*scene, statistics);
  const auto integrator = make_integrator(*scene, dynamics);
  EnergyWatch watch(dynamics, integrator->state());
  while (integrator->time() < source.time.duration) {
    if (const auto reason = integrator->step()) return reason->text;
    const auto reason = watch.check(integrator->time(), integrator->state(),
                                    dynamics.energies(integrator->time(), integrator->state()));
    if (reason) return reason->text;
  }
  return "";
}

const std::string stiff_sheet = R"(
[time]
duration = 0.1
[contact]
enabled = false
[material.membrane]
membrane_stiffness = 1000
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [1.0, 1.0], resolution = [13, 13] }
[[body.pin]]
corners = ["last_first", "last_last"]
)";

TEST(AccuracyChoice, TakesNoToleranceWhoseRunGainsEnergy) {
  bool retreated = false;
  for (const char* method_name : {"cvode", "arkode"}) {
    for (const char* stiffness : {"1e3", "1e5", "1e7"}) {
      for (const char* asked : {"2e-3", "1e-1"}) {
        Case source = chosen(
            stiff_sheet, method(method_name, {std::string("time.accuracy=") + asked,
                                              std::string("material.membrane.membrane_stiffness=") +
                                                  stiffness}));
        correct_accuracy(source);
        EXPECT_EQ(complaint(source), "") << source.accuracy_choice;
        retreated =
            retreated || source.accuracy_choice.find("since a run with") != std::string::npos;
      }
    }
  }
  EXPECT_TRUE(retreated);
}

const std::string curtain = R"(
[time]
duration = 1.2
method = "cvode"
accuracy = 1e-3
[contact]
enabled = false
[material.cloth]
bending_stiffness = 1e-5
stiffness_damping = 1e-3
[[body]]
name = "curtain"
rotation_deg = [60, 0, 0]
shape = { type = "rectangle", size = [1.0, 1.0], resolution = [13, 13] }
[[body.pin]]
edges = ["last_row"]

[body.pin.motion]
keyframes = [
  { time = 0.5, translation = [0.3, 0, 0] },
  { time = 0.8, translation = [-0.2, 0.2, 0], rotation_deg = [0, 0, 60] },
]
)";

TEST(AccuracyChoice, SaysThatChaosAllowsNoAccuracyAndKeepsTheTolerance) {
  Case source = chosen(curtain, {});
  const double tolerance = source.time.position_tolerance;
  correct_accuracy(source);
  EXPECT_NE(source.accuracy_choice.find("chaotic: this accuracy cannot be had: from t = "),
            std::string::npos)
      << source.accuracy_choice;
  EXPECT_EQ(source.time.position_tolerance, tolerance);
}

TEST(AccuracyChoice, SaysWhatItsPilotDoesAndShowsHowFarItIs) {
  Case source = chosen(hanging_sheet, {"time.accuracy=5e-4", "time.method=cvode"});
  std::vector<std::string> said;
  double furthest = 0;
  PilotOptions options;
  options.notice = [&](const std::string& text) { said.push_back(text); };
  options.progress = [&](double time) { furthest = std::max(furthest, time); };
  const PilotReport report = correct_accuracy(source, options);
  ASSERT_FALSE(said.empty());
  EXPECT_NE(said.front().find("pilot of time.accuracy: runs with position_tolerance"),
            std::string::npos)
      << said.front();
  EXPECT_GT(furthest, 0.19);
  EXPECT_GT(report.cost.cpu, 0);
  EXPECT_FALSE(report.ended_run());
}

TEST(AccuracyChoice, EndsItsPilotWhereTheRunWouldEnd) {
  const Case before = chosen(curtain, {"compute.cpu_limit=0.05"});
  Case source = before;
  const PilotReport limited = correct_accuracy(source);
  EXPECT_TRUE(limited.ended_run());
  EXPECT_NE(limited.limit_reason.find("the limit of 0.05 s of CPU time (compute.cpu_limit)"),
            std::string::npos)
      << limited.limit_reason;
  EXPECT_EQ(source.resolved_text, before.resolved_text);
  const std::atomic<int> stop{1};
  PilotOptions options;
  options.stop_signal = &stop;
  EXPECT_TRUE(correct_accuracy(source, options).interrupted);
  EXPECT_EQ(source.resolved_text, before.resolved_text);
}

}  // namespace
}  // namespace weft::sim::accuracy_choice_test
