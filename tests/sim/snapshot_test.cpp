// Snapshots: which points they record anew, and what they say about the motion of all of them.
#include "sim/contact/snapshot.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "sim/case/case_reader.h"
#include "sim/scene/scene.h"

namespace weft::sim::snapshot_test {
namespace {

const std::string strip = R"(
[time]
duration = 1
[[body]]
name = "strip"
shape = { type = "rectangle", size = [4, 1], resolution = [5, 2] }
)";

TEST(Snapshot, RecordsPointsThatHaveMovedFarAndThoseThatAreAskedFor) {
  const auto built = build_scene(parse_case(strip, "strip.toml"));
  const Scene& scene = *built;
  Snapshot snapshot(scene, scene.point_count);
  std::vector<Vec3> x = scene.initial_position;
  snapshot.renew(0, {x, x}, 0.1, 0.05);
  EXPECT_EQ(std::ranges::count(snapshot.renewed(), 1), scene.point_count);
  snapshot.forget_renewed();

  const std::vector<Vec3> before = x;
  for (Vec3& each : x) each.z() += 0.06;
  x[3].z() += 0.1;
  std::vector<char> asked(scene.point_count, 0);
  asked[5] = 1;
  snapshot.measure(0, {x, x});
  EXPECT_NEAR(snapshot.displacement(0), 0.16, 1e-6);
  snapshot.renew(0, {x, x}, 0.1, 0.05, asked);
  for (int i = 0; i < scene.point_count; ++i) {
    const bool is_new = i == 3 || i == 5;
    EXPECT_EQ(snapshot.renewed()[i] != 0, is_new) << i;
    EXPECT_EQ(snapshot.end()[i], is_new ? x[i] : before[i]) << i;
    EXPECT_NEAR(snapshot.displacements()[i], is_new ? 0 : 0.06, 1e-6) << i;
  }
  EXPECT_NEAR(snapshot.displacement(0), 0.06, 1e-6);
}

}  // namespace
}  // namespace weft::sim::snapshot_test
