// The stability test detects the faults that it is made for.
#include <gtest/gtest.h>

#include <atomic>
#include <csignal>
#include <limits>
#include <set>

#include "bench/child_runs.h"
#include "bench/stability_cell.h"
#include "bench/stability_verdict.h"
#include "sim/case/case_reader.h"
#include "sim/run/recorded_run.h"

namespace weft::bench::stability_test {
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

// The sheet is pushed straight down until it cuts the plate, and then until it is below.
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
  const auto results = run_cells(cells, {}, 60, 2, [&](const Cell&, const CellResult&) { ++told; });
  EXPECT_EQ(told, 3);
  EXPECT_EQ(results[0].outcome, Outcome::finished) << results[0].message;
  EXPECT_GT(results[0].steps, 0);
  EXPECT_EQ(results[1].outcome, Outcome::refused) << results[1].message;
  EXPECT_EQ(results[2].outcome, Outcome::failed) << results[2].message;
  // This limit is exceeded within a few steps.
  const std::vector<Cell> long_cells{cell({"body.sheet.shape.resolution=[65, 65]"})};
  const auto limited = run_cells(long_cells, {}, 1e-9, 1, [](auto&, auto&) {});
  EXPECT_EQ(limited[0].outcome, Outcome::limited) << limited[0].message;
  EXPECT_FALSE(is_forbidden(limited[0].outcome));
}

// The judge finds a fault that the run itself does not check.
TEST(StabilityJudge, FindsAnEndThatIsFarFromAConvergedRun) {
  const auto scene = scene_of("hang");
  const std::vector<double> y = start_of(*scene);
  ConvergedEnd converged{scene->initial_position, 0};
  for (Vec3& x : converged.position) x.z() -= 0.1;  // has fallen
  const auto reason_after = [&](double fall, double tolerance) {
    std::vector<double> end = y;
    for (std::size_t i = 2; i < end.size() / 2; i += 3) end[i] -= fall;
    Judge judge(*scene);
    CellResult result;
    const std::string reason = inexactness(*scene, judge, &converged, tolerance, 0.1, end, result);
    if (std::isfinite(fall)) {
      EXPECT_NEAR(result.error, std::abs(fall - 0.1), 1e-12);
    }
    return reason;
  };
  EXPECT_EQ(reason_after(0.095, 0), "");
  EXPECT_NE(reason_after(0.085, 0).find("converged"), std::string::npos);
  EXPECT_EQ(reason_after(0.085, 1e-4), "");  // what a loose tolerance allows
  EXPECT_NE(reason_after(std::numeric_limits<double>::quiet_NaN(), 0), "");
}

TEST(StabilityJudge, FindsEnergyThatHasGone) {
  const auto lost_of = [](const std::string& name, double factor) {
    const auto scene = scene_of(name);
    std::vector<double> y = start_of(*scene);
    Judge judge(*scene);
    EXPECT_FALSE(judge.check(0, y));
    for (std::size_t i = y.size() / 2; i < y.size(); ++i) y[i] *= factor;
    CellResult result;
    const std::string reason = inexactness(*scene, judge, nullptr, 0, 0.1, y, result);
    EXPECT_EQ(reason.empty(), !(result.lost > lost_share));
    return result.lost;
  };
  EXPECT_NEAR(lost_of("invert", 1), 0, 1e-12);
  EXPECT_NEAR(lost_of("invert", 0.5), 0.75, 1e-12);
  // Contact takes energy, and rotating pins add it.
  EXPECT_TRUE(std::isnan(lost_of("impact", 0.5)));
  EXPECT_TRUE(std::isnan(lost_of("pole", 0.5)));
}

// Long steps of backward Euler finish with no more energy than was put in.
TEST(StabilityCell, ALongStepIsInexactBesideAConvergedRun) {
  Cell exact;
  exact.path = "bench/stability/hang.toml";
  exact.overrides = {"time.duration=0.1"};
  exact.duration = 0.1;
  exact.tolerance = 1e-4;
  Cell coarse = exact;
  coarse.tolerance = 0;
  coarse.overrides = {"time.duration=0.1", "time.method=euler", "time.step=0.05"};
  EXPECT_EQ(exact.physics(), coarse.physics());
  const std::vector<Cell> cells{exact, coarse};
  ConvergedEnds converged;
  converged.find(cells, 1e-6, 60, 1);
  ASSERT_TRUE(converged.at_end_of(exact));
  const auto results = run_cells(cells, converged, 60, 2, [](auto&, auto&) {});
  EXPECT_EQ(results[0].outcome, Outcome::finished) << results[0].message;
  EXPECT_LT(results[0].error, 1e-3);
  EXPECT_EQ(results[1].outcome, Outcome::inexact) << results[1].error;
}

TEST(ChildRuns, TellHowTheyEndedAndWhatTheySaid) {
  const std::string much(1 << 20, 'x');  // more than a pipe holds
  std::vector<ChildEnd> ends(4);
  run_children(
      4, 2, [](std::size_t) { return 1; },
      [&](std::size_t i) {
        if (i == 1) std::raise(SIGKILL);
        for (std::atomic<bool> spins = i == 2; spins;) {
        }
        return i == 0 ? much : std::string("short");
      },
      [&](std::size_t i, const ChildEnd& end) { ends[i] = end; });
  EXPECT_TRUE(ends[0].is_well);
  EXPECT_EQ(ends[0].result, much);
  EXPECT_EQ(ends[1].signal, SIGKILL);
  EXPECT_EQ(ends[2].signal, SIGXCPU);
  EXPECT_EQ(ends[3].result, "short");
}

// A run with as many failures as when the limits were set passes; one with more does not.
TEST(StabilityVerdict, TooManyFailuresOrLimitsAreNotPassed) {
  const auto shares_of = [](int failed, int limited, int inexact) {
    Shares shares;
    Cell cell, controlled, moving;
    controlled.tolerance = 1e-5;
    moving.has_moving_parts = true;
    CellResult result;
    for (int i = 0; i < 2181; ++i) {
      result.outcome = i < failed             ? Outcome::failed
                       : i < failed + limited ? Outcome::limited
                                              : Outcome::finished;
      const bool strayed = i >= failed + limited && i < failed + limited + inexact;
      if (strayed) result.outcome = Outcome::inexact;
      shares.add(strayed ? controlled : cell, result);
    }
    result.outcome = Outcome::inexact;
    shares.add(cell, result);  // no failure: a fixed step promises no accuracy
    result.outcome = Outcome::failed;
    for (int i = 0; i < 1000; ++i) shares.add(moving, result);
    EXPECT_EQ(shares.cells, 2182);
    return shares;
  };
  EXPECT_TRUE(shares_of(279, 94, 0).are_small());
  EXPECT_TRUE(shares_of(279, 94, 218).are_small());
  EXPECT_FALSE(shares_of(279, 94, 219).are_small());
  EXPECT_FALSE(shares_of(328, 0, 0).are_small());
  EXPECT_FALSE(shares_of(0, 110, 0).are_small());
}

TEST(StabilityGrid, ATenthOfTheCellsTakesASecondAndMore) {
  SimulatedTimes times;
  std::set<std::string> moving;
  int at_rest = 0;
  for (const Slice& slice : make_slices({}, false)) {
    for (const Cell& cell : slice.cells) {
      times.add(cell);
      if (cell.has_moving_parts) moving.insert(cell.path);
      at_rest += cell.has_moving_parts ? 0 : 1;
      const Case source = read_case(WEFT_SOURCE_DIR "/" + cell.path, cell.overrides);
      ASSERT_DOUBLE_EQ(source.time.duration, cell.duration);
    }
  }
  EXPECT_EQ(at_rest, 2181);
  EXPECT_EQ(moving.size(), 3U);
  EXPECT_GE(10 * times.long_cells, times.cells);
}

TEST(StabilityGrid, ASampleIsEveryNthCell) {
  const auto count = [](const std::vector<Slice>& slices) {
    std::size_t cells = 0;
    for (const Slice& slice : slices) cells += slice.cells.size();
    return cells;
  };
  const std::size_t all = count(make_slices({}, false));
  EXPECT_EQ(count(every_nth(make_slices({}, false), 25)), (all + 24) / 25);
  EXPECT_EQ(count(every_nth(make_slices({}, false), 1)), all);
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
}  // namespace weft::bench::stability_test
