#include "sim/view/field_extremes.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "sim/view/trajectory_info.h"
#include "tests/sim/field_trajectory.h"

namespace weft::sim::field_extremes_test {
namespace {

constexpr double nothing = std::numeric_limits<double>::quiet_NaN();

class FieldExtremes : public FieldTrajectory {
 protected:
  // The strain is 10 x frame + x + y / 16, so that each texel of each frame has a value of its own;
  // the corner (0, 0) of frame 2 has no number. x and y go from -1/2 to 1/2 in steps of 1/16.
  void write() const {
    write_frames(4, [](int frame, const Vec3& place) {
      const bool is_corner = place.x() < -0.49 && place.y() < -0.49;
      return frame == 2 && is_corner ? nothing : 10.0 * frame + place.x() + place.y() / 16;
    });
  }
};

TEST_F(FieldExtremes, SayWhereAndWhenTheyAre) {
  write();
  const std::vector<FieldSummary> fields = field_extremes(TrajectoryReader(path("run.h5")));
  ASSERT_EQ(fields.size(), 2);
  const FieldSummary& velocity = fields[1];
  EXPECT_EQ(velocity.name, "velocity");
  EXPECT_EQ(velocity.units, "m/s");
  EXPECT_TRUE(velocity.magnitude);
  EXPECT_EQ(velocity.minimum.value, 0);
  EXPECT_EQ(velocity.minimum.frame, 0);
  EXPECT_EQ(velocity.maximum.value, 15);
  EXPECT_EQ(velocity.maximum.frame, 3);
  EXPECT_EQ(velocity.not_finite, 0);

  const FieldSummary& strain = fields[0];
  EXPECT_EQ(strain.name, "strain");
  EXPECT_FALSE(strain.magnitude);
  EXPECT_TRUE(strain.has_extremes);
  EXPECT_EQ(strain.not_finite, 1);
  EXPECT_EQ(strain.minimum.value, -0.5 - 0.5 / 16);
  EXPECT_EQ(strain.minimum.frame, 0);
  EXPECT_EQ(strain.minimum.time, 0);
  EXPECT_EQ(strain.minimum.body, "sheet");
  EXPECT_EQ(strain.maximum.value, 30.5 + 0.5 / 16);
  EXPECT_EQ(strain.maximum.frame, 3);
  EXPECT_DOUBLE_EQ(strain.maximum.time, 0.1 * 3);
  // The columns run along x, the rows along y.
  EXPECT_EQ(strain.minimum.texel.row, 0);
  EXPECT_EQ(strain.minimum.texel.col, 0);
  EXPECT_EQ(strain.maximum.texel.row, 16);
  EXPECT_EQ(strain.maximum.texel.col, 16);
}

TEST_F(FieldExtremes, AreInTheSummaryForPeopleAndMachines) {
  write();
  const TrajectorySummary summary = summarise_trajectory(path("run.h5"));
  const std::string text = to_text(summary);
  for (const char* part : {"field     velocity: magnitude 0 m/s at 0 s, sheet patch 0 row 0 col 0\n"
                           "          to 15 m/s at 0.3 s, sheet patch 0 row 0 col 0\n",
                           "field     strain: -0.53125 at 0 s, sheet patch 0 row 0 col 0\n"
                           "          to 30.5312 at 0.3 s, sheet patch 0 row 16 col 16\n"
                           "          values that are not finite: 1\n"}) {
    EXPECT_NE(text.find(part), std::string::npos) << part << "\nin\n" << text;
  }
  const auto fields = nlohmann::json::parse(to_json(summary)).at("fields");
  ASSERT_EQ(fields.size(), 2);
  EXPECT_EQ(fields[1].at("magnitude"), true);
  EXPECT_EQ(fields[0].at("name"), "strain");
  EXPECT_EQ(fields[0].at("maximum"), nlohmann::json({{"value", 30.5 + 0.5 / 16},
                                                     {"frame", 3},
                                                     {"time_s", 0.1 * 3},
                                                     {"body", "sheet"},
                                                     {"patch", 0},
                                                     {"row", 16},
                                                     {"col", 16}}));
}

TEST_F(FieldExtremes, HaveNoneWithoutANumber) {
  write_frames(2, [](int, const Vec3&) { return nothing; });
  const TrajectorySummary summary = summarise_trajectory(path("run.h5"));
  ASSERT_EQ(summary.fields.size(), 2);
  EXPECT_FALSE(summary.fields[0].has_extremes);
  EXPECT_NE(to_text(summary).find("field     strain: no finite value\n"), std::string::npos);
  const auto fields = nlohmann::json::parse(to_json(summary)).at("fields");
  EXPECT_TRUE(fields[0].at("maximum").is_null());
}

// The force of a pin grows as (3, 4, 12) times the frame, and a number per body falls.
TEST_F(FieldExtremes, AreSaidOfRecordsToo) {
  const std::vector<TrajectoryBody> bodies = {make_body("sheet", {{.rows = 2, .cols = 2}})};
  const auto positions = scene_values(bodies, 0);
  {
    TrajectoryWriter writer(
        path("run.h5"), bodies, {},
        {.records = {{"reactions/sheet/pin_1/force", "N", "reactions", 3},
                     {"body_energy/sheet/kinetic", "J", "body_energy", 1},
                     {"largest_stretch_place/row", "1", "largest_stretch_place", 1}}},
        views(positions));
    for (int f = 0; f < 3; ++f) {
      const double n = f;
      writer.write_frame(0.5 * f, views(positions),
                         {{{}}, std::array{3 * n, 4 * n, 12 * n, 2 - n, f == 1 ? nothing : 0}}, {});
    }
  }
  const TrajectorySummary summary = summarise_trajectory(path("run.h5"));
  ASSERT_EQ(summary.records.size(), 2);
  const std::string text = to_text(summary);
  EXPECT_NE(text.find("record    reactions/sheet/pin_1/force: magnitude 0 N at 0 s\n"
                      "          to 26 N at 1 s\n"
                      "record    body_energy/sheet/kinetic: 0 J at 1 s\n"
                      "          to 2 J at 0 s\n"),
            std::string::npos)
      << text;
  const auto records = nlohmann::json::parse(to_json(summary)).at("records");
  EXPECT_EQ(records[0].at("path"), "reactions/sheet/pin_1/force");
  EXPECT_EQ(records[0].at("maximum"), nlohmann::json({{"value", 26}, {"frame", 2}, {"time_s", 1}}));
}

}  // namespace
}  // namespace weft::sim::field_extremes_test
