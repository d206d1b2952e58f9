// The main task in small: cloth falls on obstacles and on itself, and nothing passes through.
#include "simulated_case.h"

namespace weft::sim::drape_test {
namespace {

// Simulates a shipped case, smaller and shorter, and counts intersections in every frame.
void expect_nothing_passes_through(const std::string& name, const Overrides& overrides,
                                   double duration) {
  const auto scene =
      build_scene(read_case(std::string(WEFT_CASES_DIR) + "/" + name + ".toml", overrides));
  Statistics statistics;
  Dynamics dynamics(*scene, statistics);
  const auto integrator = make_integrator(*scene, dynamics);
  std::vector<double> y(dynamics.state_size());
  std::vector<Vec3> position, velocity;
  double smallest_gap = 1;
  for (double frame = 1.0 / 60; frame <= duration; frame += 1.0 / 60) {
    while (integrator->time() < frame) {
      const auto failure = integrator->step();
      ASSERT_FALSE(failure) << failure->text;
      smallest_gap = std::min(smallest_gap, dynamics.contact()->smallest_gap().value_or(1));
    }
    ASSERT_EQ(integrator->state_at(frame, y), std::nullopt);
    dynamics.expand_all(frame, y, position, velocity);
    ASSERT_EQ(crossings(*scene, position), 0) << "t = " << frame;
    EXPECT_LT(dynamics.largest_stretch(position), 0.05);
  }
  EXPECT_GT(smallest_gap, 0);
  EXPECT_LT(smallest_gap, scene->source.contact.range);  // they did meet
}

TEST(Drape, SheetOverATorus) {
  expect_nothing_passes_through("drape_torus", {"body.sheet.shape.resolution=[33, 33]"}, 0.45);
}

TEST(Drape, SheetOnASphereOfSixPatches) {
  expect_nothing_passes_through(
      "sheet_on_sphere",
      {"body.sheet.shape.resolution=[25, 25]", "obstacle.sphere.shape.resolution=[17]"}, 0.3);
}

TEST(Drape, SheetsFallOnEachOther) {
  expect_nothing_passes_through(
      "falling_box_of_sheets",
      {"body.first.shape.resolution=[11, 11]", "body.second.shape.resolution=[11, 11]",
       "body.third.shape.resolution=[11, 11]", "body.fourth.shape.resolution=[11, 11]",
       "body.fifth.shape.resolution=[11, 11]"},
      0.3);
}

}  // namespace
}  // namespace weft::sim::drape_test
