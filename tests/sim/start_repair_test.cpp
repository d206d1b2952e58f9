#include "sim/run/start_repair.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "sim/case/case_error.h"
#include "sim/case/case_reader.h"
#include "sim/run/initial_state.h"
#include "sim/run/start_shapes.h"
#include "tests/temporary_folder.h"

namespace weft::sim::start_repair_test {
namespace {

// Edges of 62.5 mm, but for the diagonals.
constexpr const char* two_sheets = R"(
[time]
duration = 0.1
[contact]
range = 0.004
[[body]]
name = "lower"
thickness = 0.002
shape = { type = "rectangle", size = [0.5, 0.5], resolution = [9, 9] }
[[body]]
name = "upper"
thickness = 0.004
position = [0, 0, 0.2]
shape = { type = "rectangle", size = [0.5, 0.5], resolution = [9, 9] }
)";

constexpr const char* sheet_and_ball = R"(
[time]
duration = 0.1
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [0.5, 0.5], resolution = [17, 17] }
[[obstacle]]
name = "ball"
position = [0.02, 0.01, 0]
shape = { type = "sphere", radius = 0.2, resolution = [13] }
)";

class StartRepairs : public testing::Test {
 protected:
  std::unique_ptr<const Scene> scene_of(const std::string& text,
                                        const std::vector<std::string>& overrides = {}) const {
    return build_scene(parse_case(text, folder_.path("test.toml"), overrides));
  }

  // The scene with its bodies started from the file that the repair writes.
  std::unique_ptr<const Scene> started_from_file(const Scene& scene,
                                                 const StartRepair& repair) const {
    std::vector<int> moved;
    for (const RepairedBody& body : repair.bodies) moved.push_back(body.body);
    const std::string path =
        write_start_shapes(folder_.path("start.h5"), scene, moved, repair.position);
    Case source = scene.source;
    for (const int body : moved)
      source.body[scene.case_index(body)].start = start_from_file(path, scene.bodies[body]);
    return build_scene(source);
  }

  // Repairs a scene whose start is refused, and tests what every repair keeps.
  StartRepair repaired(const Scene& scene) const {
    EXPECT_THROW(check_initial_state(scene), CaseError);
    StartRepair repair = repair_start(scene);
    EXPECT_FALSE(repair.bodies.empty());
    int moved = 0;
    for (const RepairedBody& body : repair.bodies) {
      EXPECT_FALSE(scene.bodies[body.body].is_obstacle);
      EXPECT_GT(body.farthest, 0);
      moved += body.moved;
    }
    int different = 0;
    for (int p = 0; p < scene.particle_count; ++p)
      different += repair.position[p] != scene.initial_position[p];
    EXPECT_EQ(moved, different);
    const auto again = started_from_file(scene, repair);
    check_initial_state(*again);
    for (int p = 0; p < scene.particle_count; ++p)
      EXPECT_LT((again->initial_position[p] - repair.position[p]).norm(), 1e-14);
    // A repaired scene needs no repair.
    EXPECT_TRUE(repair_start(*again).bodies.empty());
    return repair;
  }

  std::string refusal_of(const Scene& scene) const {
    try {
      repair_start(scene);
    } catch (const CaseError& error) {
      return error.what();
    }
    return "";
  }

  TemporaryFolder folder_;
};

TEST_F(StartRepairs, ApartSheetsStayAsTheyAre) {
  const auto scene = scene_of(two_sheets);
  const StartRepair repair = repair_start(*scene);
  EXPECT_TRUE(repair.bodies.empty());
  EXPECT_EQ(repair.crossings, 0);
  EXPECT_EQ(repair.position, scene->initial_position);
}

// The sheets cross along a line; at their ends they are up to 35 mm on the wrong side.
TEST_F(StartRepairs, SheetsThatCrossSlightlyAreSeparated) {
  for (const char* rotation : {"[8, 0, 0]", "[0, -6, 0]", "[5, 3, 0]"}) {
    for (const char* position : {"[0, 0, 0]", "[0.013, 0.021, 0.004]", "[0, 0.1, -0.002]"}) {
      SCOPED_TRACE(std::string(rotation) + " " + position);
      const auto scene = scene_of(two_sheets, {std::string("body.upper.rotation_deg=") + rotation,
                                               std::string("body.upper.position=") + position});
      const StartRepair repair = repaired(*scene);
      EXPECT_GT(repair.crossings, 10);
      for (const RepairedBody& body : repair.bodies) EXPECT_LT(body.farthest, 0.08);
    }
  }
}

// A corner of the upper sheet reaches 12 mm through the lower one. Only what is near moves.
TEST_F(StartRepairs, ACornerIsTakenBack) {
  const auto scene = scene_of(two_sheets, {"body.upper.rotation_deg=[20, -20, 0]",
                                           "body.upper.position=[0.183, 0.161, 0.155]"});
  const StartRepair repair = repaired(*scene);
  for (const RepairedBody& body : repair.bodies) {
    EXPECT_LT(body.moved, 30);
    EXPECT_LT(body.farthest, 0.03);
  }
}

TEST_F(StartRepairs, ASheetIsTakenOutOfAnObstacle) {
  for (const double height : {0.195, 0.19, 0.182}) {
    SCOPED_TRACE(height);
    const auto scene =
        scene_of(sheet_and_ball, {"body.sheet.position.2=" + std::to_string(height)});
    const StartRepair repair = repaired(*scene);
    ASSERT_EQ(repair.bodies.size(), 1U);
    EXPECT_LT(repair.bodies[0].moved, 17 * 17 / 3);
    EXPECT_LT(repair.bodies[0].farthest, 0.2 - height + 0.02);
    // The ball has not moved, and the sheet lies above it.
    const SceneBody& ball = scene->bodies[1];
    for (int i = 0; i < 17 * 17; ++i) {
      const Vec3 from_centre = repair.position[i] - Vec3(0.02, 0.01, 0);
      EXPECT_GT(from_centre.norm(), 0.19);
      EXPECT_GT(from_centre.z(), 0.17);
    }
    for (int p = ball.first_particle; p < scene->particle_count; ++p)
      EXPECT_EQ(repair.position[p], scene->initial_position[p]);
  }
}

// A sheet folded over itself, whose upper end reaches through its lower half.
TEST_F(StartRepairs, ASheetIsTakenOutOfItself) {
  const std::string flat = R"(
[time]
duration = 0.1
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [0.2, 0.6], resolution = [9, 25] }
)";
  const auto rest = scene_of(flat);
  const double pi = std::acos(-1.0), radius = 0.04, straight = 0.5 * (0.6 - pi * radius);
  std::vector<Vec3> folded;
  for (const Vec3& x : rest->initial_position) {
    const double s = x.y() + 0.3, turn = std::clamp((s - straight) / radius, 0.0, pi);
    const double back = std::max(0.0, s - straight - pi * radius);
    // The way back goes down by 0.09 m, to 10 mm below the lower half.
    folded.emplace_back(x.x(), std::min(s, straight) + radius * std::sin(turn) - back,
                        radius * (1 - std::cos(turn)) - 0.09 / straight * back);
  }
  const std::vector<int> all{0};
  Case source = rest->source;
  source.body[0].start = start_from_file(
      write_start_shapes(folder_.path("folded.h5"), *rest, all, folded), rest->bodies[0]);
  const auto scene = build_scene(source);
  const StartRepair repair = repaired(*scene);
  EXPECT_GT(repair.crossings, 3);
  EXPECT_LT(repair.bodies[0].farthest, 0.05);
  EXPECT_LT(repair.bodies[0].moved, 9 * 25 / 2);
}

TEST_F(StartRepairs, SurfacesThatAreTooCloseArePushedApart) {
  const auto scene = scene_of(two_sheets, {"body.upper.position=[0.01, 0.02, 0.001]"});
  const StartRepair repair = repaired(*scene);
  EXPECT_EQ(repair.crossings, 0);
  // From 1 mm apart to the thickness, 3 mm, and half of the range, 2 mm; both give way.
  ASSERT_EQ(repair.bodies.size(), 2U);
  for (const RepairedBody& body : repair.bodies) EXPECT_LT(body.farthest, 0.003);
}

// A sheet that lies too close above a floor is lifted to half of the range everywhere.
TEST_F(StartRepairs, ASheetIsLiftedFromAFloorByAsMuchEverywhere) {
  const auto scene = scene_of(R"(
[[body]]
name = "sheet"
position = [0, 0, 0.0004]
shape = { type = "rectangle", size = [0.3, 0.3], resolution = [11, 11] }
[[obstacle]]
name = "floor"
shape = { type = "plane", size = [1, 0.5] }
)",
                              {});
  const StartRepair repair = repaired(*scene);
  ASSERT_EQ(repair.bodies.size(), 1U);
  EXPECT_EQ(repair.bodies[0].moved, 121);
  const double thickness = scene->bodies[0].thickness, range = scene->source.contact.range;
  for (int i = 0; i < scene->bodies[0].particle_count(); ++i) {
    const double height = repair.position[scene->bodies[0].first_particle + i].z();
    EXPECT_GT(height, thickness + 0.39 * range);
    EXPECT_LT(height, thickness + 0.75 * range);
  }
}

TEST_F(StartRepairs, PinsDoNotMove) {
  const auto scene = scene_of(
      two_sheets, {"body.upper.rotation_deg=[5, 3, 0]", "body.upper.position=[0.013, 0.021, 0.004]",
                   "body.upper.pin=[{ edges = [\"first_row\"] }]"});
  const StartRepair repair = repaired(*scene);
  for (int p = 0; p < scene->dynamic_particles; ++p) {
    if (scene->pinned[p] == 0) continue;
    EXPECT_EQ(repair.position[p], scene->initial_position[p]);
  }
}

TEST_F(StartRepairs, DeepAndInterlockedSurfacesAreRefusedWithTheReason) {
  const std::string deep = refusal_of(*scene_of(
      two_sheets, {"body.upper.rotation_deg=[30, 0, 0]", "body.upper.position=[0.01, 0.02, 0]"}));
  EXPECT_NE(deep.find("on the wrong side of"), std::string::npos) << deep;
  EXPECT_NE(deep.find("row"), std::string::npos) << deep;
  const std::string slotted =
      refusal_of(*scene_of(two_sheets, {"body.upper.rotation_deg=[90, 0, 0]",
                                        "body.upper.position=[0.26, 0.02, 0.01]"}));
  EXPECT_NE(slotted.find("the initial state is not repaired: "), std::string::npos) << slotted;
  const std::string held = refusal_of(*scene_of(
      two_sheets, {"body.upper.rotation_deg=[5, 0, 0]", "body.upper.position=[0.01, 0.02, 0]",
                   "body.upper.pin=[{ corners = [\"all\"], rows = [0, -1] }]",
                   "body.lower.pin=[{ corners = [\"all\"], rows = [0, -1] }]"}));
  EXPECT_NE(held.find("not repaired"), std::string::npos) << held;
}

TEST_F(StartRepairs, AreTheSameEveryTime) {
  const auto scene = scene_of(two_sheets, {"body.upper.rotation_deg=[5, 3, 0]",
                                           "body.upper.position=[0.013, 0.021, 0.004]"});
  EXPECT_EQ(repair_start(*scene).position, repair_start(*scene).position);
}

}  // namespace
}  // namespace weft::sim::start_repair_test
