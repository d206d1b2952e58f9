// Probes of a trajectory whose values are known.
#include "sim/probes/probe.h"

#include <cmath>

#include "sim/case/case_error.h"
#include "sim/probes/outputs.h"
#include "tests/sim/trajectory_fixture.h"

namespace weft::sim::probe_test {

namespace {

// A sheet of 3 x 5 vertices, 2 m long and 1 m wide, over a floor. In frame f, at the times 0, 0.1,
// 0.3 and 0.4 s, it has risen by h = 0, 1, 2 and 4 m, and its last column has moved by h / 2 along
// x, so that its last quads are stretched.
class ProbedTrajectory : public TrajectoryFolder {
 protected:
  static constexpr double times[] = {0, 0.1, 0.3, 0.4};
  static constexpr double heights[] = {0, 1, 2, 4};

  void SetUp() override {
    std::vector<TrajectoryBody> bodies{make_body("floor", {{.rows = 2, .cols = 2}}),
                                       make_body("sheet", {{.rows = 3, .cols = 5}})};
    bodies[0].moves = false;
    bodies[0].is_obstacle = true;
    bodies[1].fields = {{"strain", "1", "membrane_strain", 1}, {"velocity", "m/s", "velocity", 3}};
    TrajectoryWriter::Options options;
    options.case_text = "[outputs]\ntop = \"max(position('sheet', 0, 0).z)\"\n";
    options.step_series = {{"time", "s"}, {"smallest_gap", "m"}};
    options.records = {{"reactions/sheet/pin_1/force", "N", "reactions", 3},
                       {"body_energy/sheet/elastic", "J", "body_energy", 1}};
    const std::vector<Vec3> floor = {{0, 0, -1}, {1, 0, -1}, {0, 1, -1}, {1, 1, -1}};
    std::vector<Vec3> sheet(15);
    TrajectoryWriter writer(path("run.h5"), bodies,
                            {{"energy_kinetic", "J"}, {"smallest_gap", "m"}}, options,
                            {floor, sheet});
    for (int f = 0; f < 4; ++f) {
      const double h = heights[f];
      std::vector<double> strain(15);
      for (int i = 0; i < 15; ++i) {
        sheet[i] = {0.5 * (i % 5) + (i % 5 == 4 ? h / 2 : 0), 0.5 * (i / 5), h};
        strain[i] = i + 100 * f;
      }
      const std::vector<double> velocity = [&] {
        std::vector<double> numbers;
        for (int i = 0; i < 15; ++i) numbers.insert(numbers.end(), {3.0 * f, 4.0 * f, 0.0});
        return numbers;
      }();
      const std::vector<double> records = {h, -h, 2 * h, 10 + h};
      // Nothing is in reach in the second frame.
      const std::vector<double> series = {h * h, f == 1 ? NAN : 0.1 * (f + 1)};
      // A step in the middle of the interval before the frame, and one at the frame.
      std::vector<double> steps;
      if (f > 0) steps = {0.5 * (times[f - 1] + times[f]), 0.01 * f, times[f], 0.02 * f};
      writer.write_frame(times[f], {floor, sheet}, {{{}, {strain, velocity}}, records}, series,
                         steps);
    }
    RunEnd end;
    end.status = "done";
    end.bill.total = {.wall = 7, .cpu = 12};
    writer.finish(end);
  }

  double value(const std::string& text) const {
    const TrajectoryReader reader(path("run.h5"));
    RecordedValues values(reader);
    return Probe({text, {}}, values.contents()).value(values);
  }

  // Returns the message about an expression in line 2 of a case: `a = "TEXT"`.
  std::string error(const std::string& text) const {
    const TrajectoryReader reader(path("run.h5"));
    try {
      const Probe probe(
          located_text(text, {"case.toml", 2, 5}, "[outputs]\na = \"" + text + "\"\n"),
          reader.contents());
    } catch (const CaseError& fault) {
      return fault.what();
    }
    return "no error";
  }
};

TEST_F(ProbedTrajectory, ReducesSeriesOverTime) {
  EXPECT_EQ(value("first(energy_kinetic)"), 0);
  EXPECT_EQ(value("last(energy_kinetic)"), 16);
  EXPECT_EQ(value("min(energy_kinetic)"), 0);
  EXPECT_EQ(value("max(energy_kinetic)"), 16);
  // Trapezia: 0.5 * 0.1 * (0 + 1) + 0.5 * 0.2 * (1 + 4) + 0.5 * 0.1 * (4 + 16), over 0.4 s.
  EXPECT_NEAR(value("mean(energy_kinetic)"), 1.55 / 0.4, 1e-14);
  EXPECT_NEAR(value("at(energy_kinetic, 0.2)"), 2.5, 1e-14);
  EXPECT_EQ(value("at(energy_kinetic, 0.3)"), 4);
  EXPECT_NEAR(value("at(energy_kinetic, duration / 2)"), 2.5, 1e-14);
  EXPECT_EQ(value("first_time(energy_kinetic > 3)"), 0.3);
  EXPECT_EQ(value("first_time(energy_kinetic >= 0)"), 0);
}

TEST_F(ProbedTrajectory, HasNoNumberWhereNothingIsRecorded) {
  EXPECT_TRUE(std::isnan(value("at(energy_kinetic, 0.5)")));
  EXPECT_TRUE(std::isnan(value("at(energy_kinetic, -1)")));
  EXPECT_TRUE(std::isnan(value("first_time(energy_kinetic > 99)")));
  EXPECT_TRUE(std::isnan(value("at(smallest_gap, 0.1)")));
}

TEST_F(ProbedTrajectory, LeavesOutInstantsWithoutANumber) {
  EXPECT_EQ(value("min(smallest_gap)"), 0.1);
  EXPECT_EQ(value("max(smallest_gap)"), 0.4);
  // Only the last interval has numbers at both ends.
  EXPECT_NEAR(value("mean(smallest_gap)"), 0.35, 1e-14);
}

TEST_F(ProbedTrajectory, ComputesWithNumbersOfTheRun) {
  EXPECT_EQ(value("cpu_time"), 12);
  EXPECT_EQ(value("wall_time"), 7);
  EXPECT_EQ(value("duration"), 0.4);
  EXPECT_EQ(value("frames"), 4);
  EXPECT_EQ(value("max(energy_kinetic) / frames + min(cpu_time, 3)"), 7);
}

TEST_F(ProbedTrajectory, NestsFunctionsOverTime) {
  EXPECT_EQ(value("max(energy_kinetic - first(energy_kinetic))"), 16);
  EXPECT_EQ(value("first_time(energy_kinetic > max(energy_kinetic) / 5)"), 0.3);
  EXPECT_EQ(value("max(max(energy_kinetic, 100 * time))"), 40);
  EXPECT_EQ(value("at(time, at(time, 0.25))"), 0.25);
}

TEST_F(ProbedTrajectory, MeasuresTexels) {
  EXPECT_EQ(value("last(position('sheet', 2, 4).x)"), 4);
  EXPECT_EQ(value("last(position('sheet', -1, -1).x)"), 4);
  EXPECT_EQ(value("last(position('sheet', 0, 2, 4).y)"), 1);
  EXPECT_EQ(value("max(displacement('sheet', -1, -1).z)"), 4);
  EXPECT_NEAR(value("last(displacement('sheet', 1, 4).length)"), std::sqrt(20), 1e-12);
  EXPECT_EQ(value("last(position('floor', 0, 1).z)"), -1);
  EXPECT_EQ(value("last(position('sheet', 1, 1).z - position('floor', 0, 0).z)"), 5);
  EXPECT_EQ(value("last(field('strain', 'sheet', 1, 2))"), 307);
  EXPECT_EQ(value("last(field('velocity', 'sheet', 0, 0).length)"), 15);
}

TEST_F(ProbedTrajectory, MeasuresBodies) {
  EXPECT_EQ(value("last(upper('sheet').x)"), 4);
  EXPECT_EQ(value("first(size('sheet').x)"), 2);
  EXPECT_EQ(value("last(lower('sheet').z)"), 4);
  EXPECT_EQ(value("first(shadow('sheet').z)"), 2);
  EXPECT_EQ(value("last(shadow('sheet').z)"), 4);
  EXPECT_EQ(value("last(shadow('sheet').x)"), 0);
  EXPECT_EQ(value("last(area('sheet'))"), 4);
  EXPECT_EQ(value("max(largest('strain', 'sheet'))"), 314);
  EXPECT_EQ(value("last(smallest('strain', 'sheet'))"), 300);
  EXPECT_EQ(value("at(largest('velocity', 'sheet'), 0.1)"), 5);
}

TEST_F(ProbedTrajectory, ReadsRecordsAndSteps) {
  EXPECT_EQ(value("last(record('reactions/sheet/pin_1/force').z)"), 8);
  EXPECT_NEAR(value("max(record('reactions/sheet/pin_1/force').length)"), std::sqrt(96), 1e-12);
  EXPECT_EQ(value("last(record('body_energy/sheet/elastic'))"), 14);
  EXPECT_EQ(value("min(step.smallest_gap)"), 0.01);
  EXPECT_EQ(value("first_time(step.smallest_gap > 0.035)"), 0.3);
  EXPECT_NEAR(value("at(time + 0 * step.smallest_gap, 0.07)"), 0.07, 1e-15);
}

TEST_F(ProbedTrajectory, SaysWhereAProbeIsWrong) {
  const std::pair<const char*, const char*> errors[] = {
      {"energy_kinetic",
       "case.toml:2:6: \"energy_kinetic\" varies in time\n"
       "  expected a function over time around it, such as last(energy_kinetic)"},
      {"1 + area('sheet')",
       "case.toml:2:10: \"area\" varies in time\n"
       "  expected a function over time around it, such as last(area('sheet'))"},
      {"max(energy_kinetc)",
       "case.toml:2:10: unknown name \"energy_kinetc\"\n  did you mean \"energy_kinetic\"?"},
      {"energy_kinetc",
       "case.toml:2:6: unknown name \"energy_kinetc\"\n  did you mean \"energy_kinetic\"?"},
      {"lst(time)", "case.toml:2:6: unknown function \"lst\"\n  did you mean \"last\"?"},
      {"last(positon('sheet', 0, 0).z)",
       "case.toml:2:11: unknown function \"positon\"\n  did you mean \"position\"?"},
      {"last(time, 1)",
       "case.toml:2:6: \"last\" has 2 arguments\n  expected 1 argument, which varies in time"},
      {"at(time)",
       "case.toml:2:6: \"at\" has 1 argument\n  expected a quantity and a time: at(q, t)"},
      {"last(time", "case.toml:2:10: the bracket is not closed\n  expected a matching )"},
      {"last()",
       "case.toml:2:6: \"last\" has 0 arguments\n  expected 1 argument, which varies in time"},
      {"last(time).z",
       "case.toml:2:16: nothing here has a part .z\n"
       "  expected .x, .y, .z or .length only behind a vector"},
      {"last(position('sheet', 0, 0))",
       "case.toml:2:33: \"position\" is a vector\n  expected .x, .y, .z or .length behind it"},
      {"last(position('sheet', 0, 0).w)",
       "case.toml:2:34: \"position\" has no part .w\n  expected .x, .y, .z or .length"},
      {"last(shadow('sheet'))",
       "case.toml:2:25: \"shadow\" has no axis\n  expected .x, .y or .z behind it"},
      {"last(area('sheet').x)", "case.toml:2:24: \"area\" is a number\n  expected no .x"},
      {"last(position('shet', 0, 0).z)",
       "case.toml:2:20: no body \"shet\" is recorded\n  did you mean \"sheet\"?"},
      {"last(position('sheet', 3, 0).z)",
       "case.toml:2:29: row 3 lies outside of the image\n"
       "  expected 0 to 2, or -1 to -3 from the end"},
      {"last(position('sheet', 0, -6).z)",
       "case.toml:2:32: column -6 lies outside of the image\n"
       "  expected 0 to 4, or -1 to -5 from the end"},
      {"last(position('sheet', 1, 0, 0).z)",
       "case.toml:2:29: body \"sheet\" has no patch 1\n  expected 0 to 0"},
      {"last(position('sheet').z)",
       "case.toml:2:11: \"position\" has 1 argument\n"
       "  expected position('BODY', ROW, COLUMN).z; PATCH before ROW for a body of several"},
      {"last(position(sheet, 0, 0).z)",
       "case.toml:2:20: this is no argument of \"position\"\n"
       "  expected position('BODY', ROW, COLUMN).z, with texts in quotes and whole numbers"},
      {"last(position('sheet', 0.5, 0).z)",
       "case.toml:2:29: this is no argument of \"position\"\n"
       "  expected position('BODY', ROW, COLUMN).z, with texts in quotes and whole numbers"},
      {"last(field('strian', 'sheet', 0, 0))",
       "case.toml:2:17: body \"sheet\" has no field \"strian\"\n  did you mean \"strain\"?"},
      {"last(largest('strain', 'floor'))",
       "case.toml:2:19: body \"floor\" has no field \"strain\"\n"
       "  expected a field that output.channels records; it has none"},
      {"last(record('reactions/sheet/pin_2/force').x)",
       "case.toml:2:18: there is no record \"reactions/sheet/pin_2/force\"\n"
       "  did you mean \"reactions/sheet/pin_1/force\"?"},
      {"max(step.smallest_gap + smallest_gap)",
       "case.toml:2:10: series of steps are mixed with quantities of frames\n"
       "  expected only names step.NAME, or none of them, within one function over time"},
      {"max(time) > 1 > 0",
       "case.toml:2:20: a comparison is compared\n"
       "  expected && between comparisons: 0 < a && a < 1"}};
  for (const auto& [text, message] : errors) EXPECT_EQ(error(text), message) << text;
}

TEST_F(ProbedTrajectory, FindsTheOutputsOfItsCase) {
  const TrajectoryReader reader(path("run.h5"));
  const auto outputs = recorded_outputs(reader, "run.h5");
  EXPECT_EQ(evaluate_outputs(outputs, reader), (OutputValues{{"top", 4}}));
  EXPECT_EQ(outputs.at(0).text.at(0).line, 2);
  EXPECT_EQ(outputs.at(0).text.at(0).column, 8);
}

TEST_F(ProbedTrajectory, ReadsOutputsFromTexts) {
  const OutputExpression output = output_of(" tip=  last(time) ");
  EXPECT_EQ(output.name, "tip");
  EXPECT_EQ(output.text.text, "last(time)");
  EXPECT_EQ(to_text(OutputValues{{"a", 1.5}, {"long", NAN}}), "a     1.5\nlong  no number\n");
  EXPECT_EQ(to_json(OutputValues{{"a", 1.5}, {"b", NAN}}), "{\n  \"a\": 1.5,\n  \"b\": null\n}");
  for (const auto& [text, message] : {std::pair("tip",
                                                "tip: no \"=\"\n  expected NAME = EXPRESSION,"
                                                " such as stretch = max(largest_stretch)"),
                                      std::pair("a b = 1",
                                                "a b = 1: \"a b\" is not a name\n"
                                                "  expected a name of letters, digits, "
                                                "_ and -")}) {
    try {
      output_of(text);
      FAIL() << text;
    } catch (const CaseError& error) {
      EXPECT_STREQ(error.what(), message);
    }
  }
}

TEST_F(ProbedTrajectory, RefusesANameOfTwoOutputs) {
  EXPECT_EQ(outputs_of({"a = 1", "b = 2"}).at(1).name, "b");
  try {
    outputs_of({"a = 1", "b = 2", " a=3"});
    FAIL();
  } catch (const CaseError& error) {
    EXPECT_STREQ(error.what(),
                 " a=3: \"a\" is given twice\n  expected a name of its own for each output");
  }
}

TEST_F(ProbedTrajectory, HasNoTimesOfARunThatHasNotEnded) {
  TrajectoryWriter writer(path("going.h5"), {make_body("a", {{.rows = 2, .cols = 2}})}, {}, {},
                          {{}});
  writer.commit();
  const TrajectoryReader reader(path("going.h5"));
  RecordedValues values(reader);
  for (const char* text : {"cpu_time", "duration", "last(time)", "max(time)", "mean(time)"}) {
    EXPECT_TRUE(std::isnan(Probe({text, {}}, values.contents()).value(values))) << text;
  }
  EXPECT_EQ(Probe({"frames", {}}, values.contents()).value(values), 0);
}

// A part of a body has the rows and columns of the whole.
TEST_F(ProbedTrajectory, CountsRowsInTheWholeImage) {
  TrajectoryContents contents;
  contents.bodies = {make_body("part", {{.rows = 3, .cols = 2}})};
  contents.bodies[0].part_rows = {0, 4, 8};
  contents.bodies[0].part_cols = {2, 3};
  const auto particle = [&](const std::string& call) {
    const LocatedText text{call, {}};
    const std::vector<Token> tokens = tokens_of(text);
    return read_quantity(text, tokens, 0, tokens.size() - 3, contents).quantity.particle;
  };
  EXPECT_EQ(particle("position('part', 4, 3).x"), 3);
  EXPECT_EQ(particle("position('part', -1, -2).x"), 4);
  try {
    particle("position('part', 5, 3).x");
    FAIL() << "row 5";
  } catch (const CaseError& error) {
    EXPECT_STREQ(error.what(),
                 "row 5 is not recorded (character 18 of \"position('part', 5, 3).x\")\n"
                 "  expected one of 0, 4, 8");
  }
}

}  // namespace

}  // namespace weft::sim::probe_test
