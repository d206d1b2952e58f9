// Plans of sweeps: their runs, their hashes and the file that holds them.
#include "sim/sweep/sweep_plan.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <set>

#include "sim/base/file_error.h"
#include "sim/case/case_error.h"
#include "sim/case/case_reader.h"
#include "sim/sweep/plan_file.h"
#include "sim/sweep/run_identity.h"
#include "sim/sweep/sweep_reader.h"
#include "tests/temporary_folder.h"

namespace weft::sim::sweep_plan_test {
namespace {

constexpr const char* base_case = R"(
[world]
wind = { mean = [1, 0, 0], intensity = 0.1, time_scale = 0.5 }
[material.cotton]
density = 0.2
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [1, 1], resolution = [5, 9] }
)";

class SweepPlanTest : public testing::Test {
 protected:
  SweepPlanTest() { folder_.write("base.toml", base_case); }

  SweepPlan plan(const std::string& text, const std::vector<std::string>& overrides = {}) const {
    return plan_sweep(parse_sweep("case = \"base.toml\"\n" + text, folder_.path("sweep.toml")),
                      overrides);
  }
  std::vector<std::vector<std::string>> values(const std::string& text) const {
    std::vector<std::vector<std::string>> all;
    for (const PlannedRun& run : plan(text).runs) all.push_back(run.values);
    return all;
  }

  TemporaryFolder folder_;
};

using Values = std::vector<std::vector<std::string>>;

constexpr const char* two_factors = R"([factors]
"time.duration" = { list = [0.5, 1] }
"contact.friction" = { range = [0.1, 0.3], count = 3 }
)";

TEST_F(SweepPlanTest, AGridHasEveryCombination) {
  EXPECT_EQ(values(two_factors), (Values{{"0.5", "0.1"},
                                         {"0.5", "0.2"},
                                         {"0.5", "0.3"},
                                         {"1", "0.1"},
                                         {"1", "0.2"},
                                         {"1", "0.3"}}));
  EXPECT_EQ(plan(two_factors).factors,
            (std::vector<std::string>{"time.duration", "contact.friction"}));
}

TEST_F(SweepPlanTest, AZipTakesValuesTogether) {
  EXPECT_EQ(values(R"([factors]
"time.method" = { list = ["cvode", "euler"] }
"contact.friction" = { list = [0.1, 0.3] }
[sample]
method = "zip"
)"),
            (Values{{"\"cvode\"", "0.1"}, {"\"euler\"", "0.3"}}));
}

TEST_F(SweepPlanTest, AListHasItsRuns) {
  EXPECT_EQ(values(R"([sample]
method = "list"
[[run]]
set = { "contact.friction" = 0.1, "body.sheet.position" = [0, 0, 1] }
[[run]]
set = { "body.sheet.position" = [0, 0, 2], "contact.friction" = 0.3 }
)"),
            (Values{{"0.1", "[0, 0, 1]"}, {"0.3", "[0, 0, 2]"}}));
}

TEST_F(SweepPlanTest, SamplesTakeTheirDistributions) {
  EXPECT_EQ(values(R"([factors]
"contact.friction" = { uniform = [0.1, 0.5] }
"material.cotton.density" = { log_uniform = [0.01, 100] }
"body.sheet.shape.resolution.0" = { uniform = [5, 8] }
"time.method" = { list = ["cvode", "euler"] }
[sample]
method = "sobol"
runs = 3
)"),
            (Values{{"0.1", "0.01", "5", "\"cvode\""},
                    {"0.3", "1.0", "7", "\"euler\""},
                    {"0.4", "0.1", "6", "\"cvode\""}}));
}

TEST_F(SweepPlanTest, SeedsChooseSamples) {
  const auto sampled = [&](const std::string& method, int seed) {
    return values(
        "[factors]\n\"contact.friction\" = { uniform = [0.1, 0.5] }\n[sample]\nmethod = \"" +
        method + "\"\nruns = 5\nseed = " + std::to_string(seed) + "\n");
  };
  for (const char* method : {"random", "latin_hypercube", "sobol"}) {
    EXPECT_EQ(sampled(method, 1), sampled(method, 1)) << method;
    EXPECT_NE(sampled(method, 1), sampled(method, 2)) << method;
  }
  // A program of its own, from the definition of this generator, gave these values.
  EXPECT_EQ(sampled("random", 1), (Values{{"0.1535506576"},
                                          {"0.1545628145"},
                                          {"0.2804859615"},
                                          {"0.1084096914"},
                                          {"0.2403592455"}}));
}

TEST_F(SweepPlanTest, RulesLeaveRunsOut) {
  const std::string rules = R"([sample]
include = ["contact.friction < 0.25"]
exclude = ["time.duration == 1 && contact.friction > 0.15", "time.duration > 2"]
)";
  EXPECT_EQ(values(two_factors + rules), (Values{{"0.5", "0.1"}, {"0.5", "0.2"}, {"1", "0.1"}}));
  EXPECT_EQ(plan(two_factors + rules).left_out, 3);
  EXPECT_EQ(values(R"([factors]
"time.method" = { list = ["cvode", "euler"] }
"contact.enabled" = { list = [true, false] }
[sample]
exclude = ["time.method == 'euler' && contact.enabled"]
)"),
            (Values{{"\"cvode\"", "true"}, {"\"cvode\"", "false"}, {"\"euler\"", "false"}}));
}

TEST_F(SweepPlanTest, RepeatsDifferInTheirKey) {
  const SweepPlan repeated = plan(R"([factors]
"contact.friction" = { list = [0.1, 0.3] }
[sample]
repeats = 2
repeat_key = "world.wind.seed"
)");
  EXPECT_EQ(repeated.factors, (std::vector<std::string>{"contact.friction", "world.wind.seed"}));
  std::set<std::string> hashes;
  Values all;
  for (const PlannedRun& run : repeated.runs) {
    all.push_back(run.values);
    hashes.insert(run.hash);
  }
  EXPECT_EQ(all, (Values{{"0.1", "1"}, {"0.1", "2"}, {"0.3", "1"}, {"0.3", "2"}}));
  EXPECT_EQ(hashes.size(), 4U);
}

TEST_F(SweepPlanTest, CasesHaveTheValuesOfTheirRuns) {
  const SweepPlan planned = plan(std::string(two_factors) + "[set]\n\"contact.range\" = 3e-3\n",
                                 {"body.sheet.thickness=2e-3"});
  for (const PlannedRun& run : planned.runs) {
    const Case source = parse_case(run.case_text, folder_.path("run.toml"));
    EXPECT_EQ(source.time.duration, std::stod(run.values[0]));
    EXPECT_EQ(source.contact.friction.constant(), std::stod(run.values[1]));
    EXPECT_EQ(source.contact.range, 3e-3);
    EXPECT_EQ(source.body[0].thickness, 2e-3);
  }
}

// Keys of a table that are of no use alone are set together.
TEST_F(SweepPlanTest, SetsKeysThatNeedEachOther) {
  folder_.write("base.toml",
                std::string(base_case).substr(std::string(base_case).find("[material")));
  const SweepPlan planned = plan(std::string(two_factors) + R"([set]
"world.wind.mean" = [2, 0, 0]
"world.wind.intensity" = 0.1
"world.wind.time_scale" = 0.5
)");
  const Case source = parse_case(planned.runs[0].case_text, folder_.path("run.toml"));
  ASSERT_NE(source.world.wind.gust(), nullptr);
  EXPECT_EQ(source.world.wind.gust()->mean.x(), 2);
  try {
    plan(std::string(two_factors) +
         "[set]\n\"world.wind.mean\" = [2, 0, 0]\n"
         "\"world.wind.intensity\" = -1\n"
         "\"world.wind.time_scale\" = 0.5\n");
    FAIL();
  } catch (const CaseError&) {
  }
}

// Outputs that the sweep replaces need not be those that the runs can compute.
TEST_F(SweepPlanTest, ItsOutputsReplaceThoseOfTheCase) {
  folder_.write("base.toml", std::string(base_case) + R"case([outputs]
low = "min(lower('sheet').z)"
high = "max(upper('sheet').z)"
)case");
  const SweepPlan planned = plan(std::string(two_factors) + R"case([outputs]
low = "2 * max(time)"
)case");
  for (const PlannedRun& run : planned.runs) {
    const Case source = parse_case(run.case_text, folder_.path("run.toml"));
    ASSERT_EQ(source.outputs.size(), 1U);
    EXPECT_EQ(source.outputs[0].name, "high");
  }
}

TEST_F(SweepPlanTest, RefusesToOverrideAFactor) {
  try {
    plan(two_factors, {"contact.friction=0.2"});
    FAIL();
  } catch (const CaseError& error) {
    EXPECT_STREQ(error.what(),
                 "--set contact.friction=0.2: \"contact.friction\" varies in this sweep\n"
                 "  expected a key that is no factor");
  }
}

// A rule between keys refuses one combination; the others can run.
TEST_F(SweepPlanTest, KeepsRunsBesideARefusedOne) {
  const SweepPlan planned = plan(R"([factors]
"body.sheet.material" = { list = ["cotton", "silk"] }
)");
  ASSERT_EQ(planned.runs.size(), 2U);
  EXPECT_EQ(planned.runs[0].refusal, "");
  EXPECT_EQ(planned.runs[1].refusal,
            folder_.path("sweep.toml") + ":3:45: unknown material \"silk\"\n  expected \"cotton\"");
  EXPECT_NE(planned.runs[1].hash, planned.runs[0].hash);
}

// FIPS 180-4, example of one block.
TEST(RunIdentity, DigestIsThePublishedOne) {
  EXPECT_EQ(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

TEST(RunIdentity, HashChangesWithWhatTheResultDependsOn) {
  const auto hash = [](const std::vector<std::string>& overrides) {
    return RunHasher().hash(parse_case(base_case, "case.toml", overrides));
  };
  EXPECT_EQ(hash({}), hash({}));
  EXPECT_EQ(hash({}), hash({"contact.friction=0"}));  // the default, written out
  EXPECT_EQ(hash({}), hash({"compute.threads=3"}));
  EXPECT_EQ(hash({}), hash({"compute.backend=cpu"}));
  EXPECT_NE(hash({}), hash({"contact.friction=0.1"}));
  EXPECT_NE(hash({}), hash({"time.duration=1.0000000000000002"}));
}

// A run that measures its error is another one.
TEST_F(SweepPlanTest, ErrorEstimatesArePartOfThePlan) {
  const SweepPlan without = plan(two_factors),
                  with = plan(std::string("estimate_error = true\n") + two_factors);
  EXPECT_TRUE(with.estimate_error);
  EXPECT_NE(with.runs[0].hash, without.runs[0].hash);
  EXPECT_EQ(with.runs[0].case_text, without.runs[0].case_text);
  write_plan(folder_.path(), with);
  EXPECT_TRUE(read_plan(folder_.path()).estimate_error);
}

// A run whose shape lies in a file is known by the bytes of the file. Its case names the file by
// its whole path, so that it can run from another folder.
TEST_F(SweepPlanTest, HashesKnowTheBytesOfFiles) {
  std::string text = base_case;
  const std::string rectangle = R"({ type = "rectangle", size = [1, 1], resolution = [5, 9] })";
  text.replace(text.find(rectangle), rectangle.size(),
               R"({ type = "file", path = "shape.h5", dataset = "positions" })");
  folder_.write("shape.h5", "one");
  const Case source = parse_case(text, folder_.path("case.toml"));
  const auto hash_with = [&](const std::string& bytes) {
    folder_.write("shape.h5", bytes);
    return RunHasher().hash(source);
  };
  EXPECT_EQ(hash_with("one"), hash_with("one"));
  EXPECT_NE(hash_with("one"), hash_with("two"));
  const Case elsewhere = parse_case(portable_case_text(source), "/elsewhere/case.toml");
  EXPECT_EQ(elsewhere.body[0].shape.path, folder_.path("shape.h5"));
  std::filesystem::remove(folder_.path("shape.h5"));
  EXPECT_THROW(RunHasher().hash(source), FileError);
}

TEST_F(SweepPlanTest, APlanComesBackFromItsFile) {
  const SweepPlan written = plan(R"([factors]
"body.sheet.material" = { list = ["cotton", "silk"] }
"time.duration" = { list = [0.5, 1] }
[limits]
time = 2.5
[sample]
exclude = ["time.duration > 0.7"]
)");
  EXPECT_FALSE(written.estimate_error);
  write_plan(folder_.path() / "new" / "folder", written);
  const SweepPlan read = read_plan(folder_.path() / "new" / "folder");
  EXPECT_EQ(read.sweep, written.sweep);
  EXPECT_EQ(read.factors, written.factors);
  EXPECT_EQ(read.limits.time, 2.5);
  EXPECT_EQ(read.limits.memory, std::nullopt);
  EXPECT_EQ(read.left_out, 2);
  ASSERT_EQ(read.runs.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(read.runs[i].hash, written.runs[i].hash);
    EXPECT_EQ(read.runs[i].values, written.runs[i].values);
    EXPECT_EQ(read.runs[i].refusal, written.runs[i].refusal);
    EXPECT_EQ(read.runs[i].case_text, written.runs[i].case_text);
  }
}

// A plan has the files that its runs read, with their digests.
TEST_F(SweepPlanTest, APlanKnowsTheFilesOfItsRuns) {
  std::string text = base_case;
  const std::string rectangle = R"({ type = "rectangle", size = [1, 1], resolution = [5, 9] })";
  text.replace(text.find(rectangle), rectangle.size(),
               R"({ type = "file", path = "shape.h5", dataset = "positions" })");
  folder_.write("base.toml", text);
  folder_.write("shape.h5", "one");
  write_plan(folder_.path(), plan(two_factors));
  const SweepPlan read = read_plan(folder_.path());
  const std::string shape = folder_.path("shape.h5");
  EXPECT_EQ(read.runs.at(5).inputs, std::vector{shape});
  EXPECT_EQ(read.digests, (std::map<std::string, std::string>{{shape, sha256("one")}}));
  InputCheck check(read.digests);
  const auto state = [&] { return check.look_at({shape}).state; };
  EXPECT_EQ(state(), InputCheck::State::as_planned);
  folder_.write("shape.h5", "another");
  EXPECT_EQ(state(), InputCheck::State::changed);
  EXPECT_EQ(check.look_at({shape}).reason,
            shape + " has changed since the sweep was planned; call weft sweep again");
  std::filesystem::remove(shape);
  EXPECT_EQ(state(), InputCheck::State::unreadable);
  folder_.write("shape.h5", "one");
  EXPECT_EQ(state(), InputCheck::State::as_planned);
}

// A run may start from the state of another one, whose checkpoint it then reads.
TEST_F(SweepPlanTest, RestartsAreKnownByTrajectoryAndCheckpoint) {
  folder_.write("first.h5", "frames");
  const std::string sweep = "[set]\n\"restart.path\" = \"first.h5\"\n\"restart.time\" = 1\n";
  const auto planned = [&] { return plan(sweep + two_factors); };
  const SweepPlan without = planned();
  const std::string trajectory = folder_.path("first.h5"),
                    checkpoint = folder_.path("first.checkpoint");
  EXPECT_EQ(without.runs[0].inputs, (std::vector{trajectory, checkpoint}));
  InputCheck check(without.digests);
  EXPECT_EQ(check.look_at(without.runs[0].inputs).state, InputCheck::State::as_planned);
  folder_.write("first.checkpoint", "state");
  EXPECT_EQ(check.look_at(without.runs[0].inputs).state, InputCheck::State::changed);
  EXPECT_NE(planned().runs[0].hash, without.runs[0].hash);
  EXPECT_EQ(planned().digests.at(checkpoint), sha256("state"));
}

// Behind a link to a folder, "link/.." is not the folder of the link.
TEST_F(SweepPlanTest, FilesBehindLinksAreTheOnesThatTheCaseNames) {
  std::filesystem::create_directories(folder_.path() / "store" / "cases");
  std::filesystem::create_directory_symlink("store/cases", folder_.path() / "cases");
  folder_.write("shape.h5", "beside the link");
  folder_.write("store/shape.h5", "beside the case");
  std::string text = base_case;
  const std::string rectangle = R"({ type = "rectangle", size = [1, 1], resolution = [5, 9] })";
  text.replace(text.find(rectangle), rectangle.size(),
               R"({ type = "file", path = "../shape.h5", dataset = "positions" })");
  const Case source = parse_case(text, folder_.path("cases/case.toml"));
  RunHasher hasher;
  hasher.hash(source);
  const Case elsewhere = parse_case(portable_case_text(source), "/elsewhere/case.toml");
  EXPECT_EQ(hasher.digests().at(elsewhere.body[0].shape.path), sha256("beside the case"));
  EXPECT_TRUE(
      std::filesystem::equivalent(elsewhere.body[0].shape.path, folder_.path("store/shape.h5")));
}

// The measure of the cost of a run may be beyond the largest double, which JSON cannot hold.
TEST_F(SweepPlanTest, HugeRunsComeBackFromTheirFile) {
  write_plan(folder_.path(), plan("[factors]\n\"time.duration\" = { list = [1, 1e307] }\n"));
  const SweepPlan read = read_plan(folder_.path());
  EXPECT_GT(read.runs.at(1).work, 1e308);
}

// A key has one set of values, by whatever name of an entry.
TEST_F(SweepPlanTest, OptionsForFactorsByAnotherNameAreRefused) {
  const std::string heights = "[factors]\n\"body.0.position.2\" = { list = [1.0, 2.0] }\n";
  try {
    plan(heights, {"body.sheet.position.2=3"});
    FAIL() << "accepted";
  } catch (const CaseError& error) {
    EXPECT_EQ(std::string(error.what()),
              folder_.path("sweep.toml") +
                  ":3:1: \"body.0.position.2\" is the same key as "
                  "\"body.sheet.position.2\"\n  expected it once in a sweep");
  }
  // An entry of a value that is set as a whole is another key.
  EXPECT_EQ(plan(heights, {"body.sheet.position=[1, 2, 3]"}).runs.size(), 2U);
}

TEST_F(SweepPlanTest, DamagedPlansAreRefused) {
  EXPECT_THROW(read_plan(folder_.path()), FileError);
  for (const char* text : {"", "{", "[]", "{\"plan_format\": 1}", "{\"plan_format\": 3}"}) {
    folder_.write("plan.json", text);
    EXPECT_THROW(read_plan(folder_.path()), FileError) << text;
  }
}

}  // namespace
}  // namespace weft::sim::sweep_plan_test
