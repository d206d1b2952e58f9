// The stability test finds what it is there to find.
#include <gtest/gtest.h>

#include <limits>

#include "bench/stability_cell.h"
#include "sim/case/case_reader.h"
#include "sim/simulation.h"

namespace weft::bench {
namespace {

using namespace sim;

std::unique_ptr<const Scene> scene_of(const std::string& name) {
  return build_scene(read_case(WEFT_SOURCE_DIR "/bench/stability/" + name + ".toml"));
}

std::vector<double> start_of(const Scene& scene) {
  Statistics statistics;
  return Dynamics(scene, statistics).initial_state();
}

TEST(StabilityJudge, FindsEnergyThatNobodyPutIn) {
  const auto scene = scene_of("invert");
  Judge judge(*scene);
  std::vector<double> y = start_of(*scene);
  EXPECT_FALSE(judge.check(0, y));
  for (std::size_t i = y.size() / 2; i < y.size(); ++i) y[i] *= 1.1;
  const auto reason = judge.check(0.01, y);
  ASSERT_TRUE(reason);
  EXPECT_NE(reason->find("energy"), std::string::npos) << *reason;
}

TEST(StabilityJudge, FindsMomentumThatHasGone) {
  const auto scene = scene_of("free");
  Judge judge(*scene);
  std::vector<double> y = start_of(*scene);
  EXPECT_FALSE(judge.check(0, y));
  for (std::size_t i = y.size() / 2; i < y.size(); ++i) y[i] *= 0.9;
  const auto reason = judge.check(0.01, y);
  ASSERT_TRUE(reason);
  EXPECT_NE(reason->find("momentum"), std::string::npos) << *reason;
}

// Pushed straight down by so much that it stands in the plate, and then below it.
TEST(StabilityJudge, FindsSurfacesThatCrossOrHaveCrossed) {
  const auto scene = scene_of("impact");
  const auto reason_after = [&](double fall) {
    std::vector<double> y = start_of(*scene);
    for (std::size_t i = 2; i < y.size() / 2; i += 3) y[i] -= fall;
    return Judge(*scene).check(0.01, y).value_or("");
  };
  EXPECT_EQ(reason_after(0), "");
  EXPECT_NE(reason_after(0.08).find("triangles cross"), std::string::npos);
  EXPECT_NE(reason_after(0.5).find("come through"), std::string::npos);
}

TEST(StabilityJudge, FindsForcesLeftAtRest) {
  const auto scene = scene_of("hang");
  EXPECT_TRUE(Judge(*scene).check_rest(0.1, start_of(*scene)));
}

TEST(StabilityJudge, FindsWhatIsNotFinite) {
  EXPECT_TRUE(all_finite(std::vector<double>{0, -1e300}));
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    EXPECT_FALSE(all_finite(std::vector<double>{0, bad, 1}));
  }
}

TEST(StabilityJudge, AClearMessageNamesBodyAndTime) {
  EXPECT_TRUE(is_clear("no step is short enough at t = 0.1 s: see body \"sheet\", row 1"));
  EXPECT_FALSE(is_clear("no step is short enough at t = 0.1 s"));
  EXPECT_FALSE(is_clear("no step is short enough: see body \"sheet\", row 1"));
  EXPECT_FALSE(is_clear(""));
}

TEST(StabilityCell, EndsAsItShould) {
  const auto cell = [](std::vector<std::string> overrides) {
    Cell made;
    made.path = "bench/stability/hang.toml";
    made.overrides = std::move(overrides);
    return made;
  };
  const std::vector<Cell> cells{cell({"time.duration=0.01"}), cell({"material.cloth.density=0"}),
                                cell({"time.method=verlet", "time.step=0.1"})};
  int told = 0;
  const auto results = run_cells(cells, 60, 2, [&](const Cell&, const CellResult&) { ++told; });
  EXPECT_EQ(told, 3);
  EXPECT_EQ(results[0].outcome, Outcome::finished) << results[0].message;
  EXPECT_GT(results[0].steps, 0);
  EXPECT_EQ(results[1].outcome, Outcome::refused) << results[1].message;
  EXPECT_EQ(results[2].outcome, Outcome::failed) << results[2].message;
  // Spent within a few steps.
  const std::vector<Cell> long_cells{cell({"body.sheet.shape.resolution=[65, 65]"})};
  const auto limited = run_cells(long_cells, 1e-9, 1, [](auto&, auto&) {});
  EXPECT_EQ(limited[0].outcome, Outcome::limited) << limited[0].message;
  EXPECT_FALSE(is_forbidden(limited[0].outcome));
}

TEST(StabilityGrid, EveryCellIsAValidCase) {
  for (const Slice& slice : make_slices({}, false)) {
    for (const Cell& cell : slice.cells) {
      EXPECT_NO_THROW(static_cast<void>(read_case(WEFT_SOURCE_DIR "/" + cell.path, cell.overrides)))
          << cell.command();
    }
  }
}

}  // namespace
}  // namespace weft::bench
