#include "sim/view/trajectory_info.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "tests/sim/trajectory_fixture.h"

namespace weft::sim::trajectory_info_test {
namespace {

class TrajectoryInfo : public TrajectoryFolder {
 protected:
  // A square of 2 x 2 vertices in the plane z = `height`, with its corner at (x, 0).
  static std::vector<Vec3> square(double x, double height) {
    return {{x, 0, height}, {x + 1, 0, height}, {x, 1, height}, {x + 1, 1, height}};
  }
  // An upright unit square at y = 1/4; its lowest edge is at the height `bottom`.
  static std::vector<Vec3> upright(double bottom) {
    return {{0.25, 0.25, bottom},
            {0.75, 0.25, bottom},
            {0.25, 0.25, bottom + 1},
            {0.75, 0.25, bottom + 1}};
  }
  // The reason why crossings cannot be counted; empty if they can.
  std::string refusal_of_crossings() const {
    try {
      count_crossings(path("run.h5"));
      return "";
    } catch (const FileError& error) {
      return error.what();
    }
  }
  // Writes frames in which the upright square sinks by 1/2 each; it reaches the floor in frame 2.
  void write_sinking() const {
    std::vector<TrajectoryBody> bodies = {make_body("sheet", {{.rows = 2, .cols = 2}}),
                                          make_body("floor", {{.rows = 2, .cols = 2}}),
                                          make_body("wall", {{.rows = 2, .cols = 2}})};
    bodies[0].thickness = 0.25;
    for (int b = 1; b < 3; ++b) {
      bodies[b].moves = false;
      bodies[b].is_obstacle = true;
    }
    // The wall stands in the floor: obstacles may overlap.
    std::vector<std::vector<Vec3>> positions = {{}, square(0, 0), upright(-0.5)};
    for (Vec3& corner : positions[2]) corner.y() += 0.5;
    TrajectoryWriter writer(path("run.h5"), bodies, {{"energy", "J"}, {"odd", ""}},
                            {.title = "sink"}, views(positions));
    for (int f = 0; f < 4; ++f) {
      positions[0] = upright(0.75 - 0.5 * f);
      const std::vector<double> series = {3.0 - f, std::numeric_limits<double>::quiet_NaN()};
      writer.write_frame(0.5 * f, views(positions), {}, series);
    }
  }
};

TEST_F(TrajectoryInfo, SummarisesTheFile) {
  write_sinking();
  const TrajectorySummary summary = summarise_trajectory(path("run.h5"));
  EXPECT_EQ(summary.title, "sink");
  EXPECT_EQ(summary.frames, 4);
  EXPECT_EQ(summary.last_time, 1.5);
  EXPECT_FALSE(summary.has_velocity);
  ASSERT_EQ(summary.bodies.size(), 3);
  const BodySummary& sheet = summary.bodies[0];
  EXPECT_EQ(sheet.name, "sheet");
  EXPECT_EQ(sheet.particles, 4);
  EXPECT_EQ(sheet.triangles, 2);
  EXPECT_EQ(sheet.thickness, 0.25);
  EXPECT_TRUE(sheet.has_bounds);
  EXPECT_EQ(sheet.lower, Vec3(0.25, 0.25, -0.75));
  EXPECT_EQ(sheet.upper, Vec3(0.75, 0.25, 0.25));
  EXPECT_TRUE(summary.bodies[1].is_obstacle);
  ASSERT_EQ(summary.series.size(), 2);
  EXPECT_EQ(summary.series[0].last, 0);
  EXPECT_EQ(summary.series[0].minimum, 0);
  EXPECT_EQ(summary.series[0].maximum, 3);
  EXPECT_TRUE(std::isnan(summary.series[1].last));
  EXPECT_EQ(summary.series[1].maximum, 0);
}

TEST_F(TrajectoryInfo, SaysTheSameToPeopleAndMachines) {
  write_sinking();
  const TrajectorySummary summary = summarise_trajectory(path("run.h5"));
  const std::string text = to_text(summary);
  for (const char* part : {"title     sink\n", "frames    4, 0 to 1.5 s\n",
                           "body      sheet: 2 x 2, 4 particles, 2 triangles, 0.25 m thick\n",
                           "from (0.25, 0.25, -0.75) to (0.75, 0.25, 0.25) m\n",
                           "obstacle  floor: 2 x 2, 4 particles, 2 triangles, fixed\n",
                           "series    energy: last 0, 0 to 3 J\n"}) {
    EXPECT_NE(text.find(part), std::string::npos) << part << "\nin\n" << text;
  }
  const auto object = nlohmann::json::parse(to_json(summary));
  EXPECT_EQ(object["last_time_s"], 1.5);
  EXPECT_EQ(object["bodies"][0]["lower_m"], (std::vector<double>{0.25, 0.25, -0.75}));
  EXPECT_EQ(object["series"][0]["maximum"], 3);
  EXPECT_TRUE(object["series"][1]["last"].is_null());  // JSON has no NaN
}

TEST_F(TrajectoryInfo, HasAWordForAFileWithoutFrames) {
  const std::vector<TrajectoryBody> bodies = {make_body("sheet", {{.rows = 2, .cols = 2}})};
  const auto initial = scene_values(bodies, 0);
  { const TrajectoryWriter writer(path("run.h5"), bodies, {{"energy", "J"}}, {}, views(initial)); }
  const TrajectorySummary summary = summarise_trajectory(path("run.h5"));
  EXPECT_EQ(summary.frames, 0);
  EXPECT_FALSE(summary.bodies[0].has_bounds);
  EXPECT_NE(to_text(summary).find("frames    0\n"), std::string::npos);
  EXPECT_EQ(refusal_of_crossings(), path("run.h5") + ": has no complete frame to judge");
}

TEST_F(TrajectoryInfo, SaysHowTheRunEnded) {
  const std::vector<TrajectoryBody> bodies = {make_body("sheet", {{.rows = 2, .cols = 2}})};
  const auto initial = scene_values(bodies, 0);
  const auto status = [&] { return summarise_trajectory(path("run.h5")).status; };
  {
    TrajectoryWriter writer(path("run.h5"), bodies, {}, {.commit_interval = 1000}, views(initial));
    EXPECT_EQ(status(), "running");
    writer.write_frame(0, views(initial), {}, {});
    writer.finish({.status = "failed",
                   .reason = "it broke",
                   .bill = {.setup = {1, 2},
                            .pilot = {},
                            .run = {},
                            .record = {3, 4},
                            .error_estimate = {},
                            .total = {5, 6}}});
    EXPECT_EQ(status(), "failed");
    EXPECT_THROW(writer.write_frame(1, views(initial), {}, {}), FileError);
  }
  const TrajectorySummary summary = summarise_trajectory(path("run.h5"));
  EXPECT_EQ(summary.frames, 1);
  EXPECT_EQ(summary.bill.record.cpu, 4);
  EXPECT_EQ(summary.bill.total.wall, 5);
  const std::string text = to_text(summary);
  EXPECT_NE(text.find("run       failed: it broke\ncost      5 s, 6 s of CPU\n"), std::string::npos)
      << text;
  EXPECT_EQ(nlohmann::json::parse(to_json(summary)).at("record_cpu_s"), 4);

  { const TrajectoryWriter writer(path("run.h5"), bodies, {}, {.force = true}, views(initial)); }
  EXPECT_EQ(status(), "killed");
  // Earlier versions had no such group.
  const hid_t file = H5Fopen(path("run.h5").c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  ASSERT_GE(H5Ldelete(file, "run", H5P_DEFAULT), 0);
  H5Fclose(file);
  EXPECT_EQ(status(), "unknown");
}

// A count of 0 would be false comfort: NaN crosses nothing.
TEST_F(TrajectoryInfo, RefusesToJudgeWhatIsNoSurface) {
  const std::vector<TrajectoryBody> bodies = {make_body("sheet", {{.rows = 2, .cols = 2}})};
  const auto refusal_with = [&](double z) {
    std::vector<std::vector<Vec3>> positions = {square(0, 0)};
    TrajectoryWriter writer(path("run.h5"), bodies, {}, {.force = true}, views(positions));
    writer.write_frame(0, views(positions), {}, {});
    positions[0][2].z() = z;
    writer.write_frame(1, views(positions), {}, {});
    return refusal_of_crossings();
  };
  EXPECT_EQ(refusal_with(0), "");
  const std::string where =
      path("run.h5") +
      ": crossings cannot be counted: frame 1, body \"sheet\", patch 0 row 1 col 0 "
      "has a position that is not finite";
  EXPECT_EQ(refusal_with(std::numeric_limits<double>::quiet_NaN()), where);
  EXPECT_EQ(refusal_with(std::numeric_limits<double>::infinity()), where);
  const TrajectorySummary summary = summarise_trajectory(path("run.h5"));
  EXPECT_FALSE(summary.bodies[0].has_bounds);
  EXPECT_NE(to_text(summary).find("not finite at the last frame\n"), std::string::npos);
}

TEST_F(TrajectoryInfo, RefusesToJudgeObstaclesAlone) {
  std::vector<TrajectoryBody> bodies = {make_body("floor", {{.rows = 2, .cols = 2}})};
  bodies[0].is_obstacle = true;
  const std::vector<std::vector<Vec3>> positions = {square(0, 0)};
  TrajectoryWriter writer(path("run.h5"), bodies, {}, {}, views(positions));
  writer.write_frame(0, views(positions), {}, {});
  EXPECT_EQ(refusal_of_crossings(),
            path("run.h5") + ": has no body to judge, only obstacles or particles");
}

TEST_F(TrajectoryInfo, SaysThatNothingWasInReach) {
  const std::vector<TrajectoryBody> bodies = {make_body("sheet", {{.rows = 2, .cols = 2}})};
  const std::vector<std::vector<Vec3>> positions = {square(0, 0)};
  const double nothing = std::numeric_limits<double>::quiet_NaN();
  {
    TrajectoryWriter writer(path("run.h5"), bodies, {{"smallest_gap", "m"}, {"odd", "J"}}, {},
                            views(positions));
    writer.write_frame(0, views(positions), {}, std::array{nothing, nothing});
    const TrajectorySummary summary = summarise_trajectory(path("run.h5"));
    const std::string text = to_text(summary);
    EXPECT_NE(text.find("series    smallest_gap: nothing was in reach\n"), std::string::npos)
        << text;
    EXPECT_NE(text.find("series    odd: not finite in any frame\n"), std::string::npos) << text;
    EXPECT_TRUE(nlohmann::json::parse(to_json(summary))["series"][0]["minimum"].is_null());
    writer.write_frame(1, views(positions), {}, std::array{0.5, 1.0});
    writer.write_frame(2, views(positions), {}, std::array{nothing, 2.0});
  }
  const std::string text = to_text(summarise_trajectory(path("run.h5")));
  EXPECT_NE(text.find("smallest_gap: last nothing in reach, 0.5 to 0.5 m\n"), std::string::npos)
      << text;
}

TEST_F(TrajectoryInfo, CountsCrossingsFrameByFrame) {
  write_sinking();
  const std::vector<FrameCrossings> frames = count_crossings(path("run.h5"));
  ASSERT_EQ(frames.size(), 4);
  EXPECT_EQ(frames[0].count, 0);
  EXPECT_EQ(frames[1].count, 0);
  for (int f = 2; f < 4; ++f) {
    EXPECT_GT(frames[f].count, 0);
    EXPECT_EQ(frames[f].time, 0.5 * f);
    EXPECT_EQ(frames[f].a.body, "sheet");
    EXPECT_EQ(frames[f].b.body, "floor");
    EXPECT_EQ(frames[f].b.texel.row, 0);
  }
  const std::string text = to_text(frames);
  EXPECT_NE(text.find("frame 2 (1 s): "), std::string::npos) << text;
  EXPECT_NE(text.find("between sheet patch 0 row 0 col 0 and floor"), std::string::npos) << text;
  EXPECT_NE(text.find(" crossings in 4 frames\n"), std::string::npos) << text;
  FrameCrossings one = frames[2];
  one.count = 1;
  const std::string singular = to_text({one});
  EXPECT_NE(singular.find("): 1 crossing, the first"), std::string::npos) << singular;
  EXPECT_NE(singular.find("\n1 crossing in 1 frame\n"), std::string::npos) << singular;
  const auto object = nlohmann::json::parse(to_json(frames));
  EXPECT_EQ(object["crossings"], frames[2].count + frames[3].count);
  EXPECT_FALSE(object["frames"][0].contains("first"));
  EXPECT_EQ(object["frames"][2]["first"][1]["body"], "floor");
}

}  // namespace
}  // namespace weft::sim::trajectory_info_test
