// Snapshots: which points they record anew, and what they say about the motion of all of them.
#include "sim/contact/snapshot.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
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

struct Strip {
  explicit Strip(const std::vector<std::string>& overrides = {})
      : scene(build_scene(parse_case(strip, "strip.toml", overrides))) {}

  std::unique_ptr<const Scene> scene;
  Snapshot snapshot{*scene, scene->point_count};
  std::vector<Vec3> x = scene->initial_position;

  BodyPaths at_rest() const { return {.start = x, .end = x}; }
  std::ptrdiff_t renewed() const { return std::ranges::count(snapshot.renewed(), 1); }
};

TEST(Snapshot, RecordsPointsThatHaveMovedFarAndThoseThatAreAskedFor) {
  Strip strip;
  const Scene& scene = *strip.scene;
  Snapshot& snapshot = strip.snapshot;
  std::vector<Vec3>& x = strip.x;
  snapshot.renew(0, strip.at_rest(), {.limit = 0.1, .short_path = 0.05});
  EXPECT_EQ(strip.renewed(), scene.point_count);
  snapshot.forget_renewed();

  const std::vector<Vec3> before = x;
  for (Vec3& each : x) each.z() += 0.06;
  x[3].z() += 0.1;
  std::vector<char> asked(scene.point_count, 0);
  asked[5] = 1;
  snapshot.measure(0, strip.at_rest());
  EXPECT_NEAR(snapshot.displacement(0), 0.16, 1e-6);
  snapshot.renew(0, strip.at_rest(), {.limit = 0.1, .short_path = 0.05, .others = asked});
  for (int i = 0; i < scene.point_count; ++i) {
    const bool is_new = i == 3 || i == 5;
    EXPECT_EQ(snapshot.renewed()[i] != 0, is_new) << i;
    EXPECT_EQ(snapshot.end()[i], is_new ? x[i] : before[i]) << i;
    EXPECT_NEAR(snapshot.displacements()[i], is_new ? 0 : 0.06, 1e-6) << i;
  }
  EXPECT_NEAR(snapshot.displacement(0), 0.06, 1e-6);
}

TEST(Snapshot, EveryPointOfAWideBodyCounts) {
  Strip strip({"body.strip.shape.resolution=[37, 29]"});
  Snapshot& snapshot = strip.snapshot;
  snapshot.renew(0, strip.at_rest(), {.limit = 0.1, .short_path = 0.05});
  snapshot.measure(0, strip.at_rest());
  snapshot.choose(0);
  for (int i = 0; i < strip.scene->point_count; ++i) {
    strip.x[i].y() += 0.3;
    snapshot.measure(0, strip.at_rest());
    EXPECT_NEAR(snapshot.displacement(0), 0.3, 1e-6) << i;
    EXPECT_GE(snapshot.displacement(0), 0.3) << i;
    EXPECT_NEAR(snapshot.displacements()[i], 0.3, 1e-6) << i;
    EXPECT_NEAR(snapshot.growth(0), 0.3, 1e-5) << i;
    strip.x[i].y() -= 0.3;
  }
  snapshot.measure(0, strip.at_rest());
  EXPECT_LT(snapshot.displacement(0), 1e-12);
}

// Bounds of features stay what they were at the choice, plus the growth since.
TEST(Snapshot, GrowthIsThatOfThePointThatHasGrownMost) {
  Strip strip;
  Snapshot& snapshot = strip.snapshot;
  EXPECT_EQ(snapshot.growth(0), std::numeric_limits<double>::infinity());
  snapshot.renew(0, strip.at_rest(), {.limit = 0.1, .short_path = 0.05});
  EXPECT_EQ(snapshot.growth(0), std::numeric_limits<double>::infinity());
  strip.x[2].y() += 0.2;
  snapshot.measure(0, strip.at_rest());
  snapshot.choose(0);
  EXPECT_EQ(snapshot.growth(0), 0);
  strip.x[2].y() -= 0.1;
  strip.x[7].x() += 0.05;
  snapshot.measure(0, strip.at_rest());
  EXPECT_NEAR(snapshot.growth(0), 0.05, 1e-6);
  EXPECT_GE(snapshot.growth(0), 0.05);
}

// A strip whose points move at steady velocities, those of a rotation about the first of them.
class Moving : public Strip {
 public:
  Moving() {
    for (const Vec3& p : x) velocity.emplace_back(Vec3(0, 0, 0.1).cross(p - x[0]));
  }
  // Moves the points for `duration` (s) at their velocities.
  void go_on(double duration) {
    before = x;
    for (std::size_t i = 0; i < x.size(); ++i) x[i] += duration * velocity[i];
    time += duration;
  }
  BodyPaths now() const {
    BodyPaths paths = at_rest();
    paths.start_time = paths.end_time = time;
    paths.velocity = velocity;
    return paths;
  }
  BodyPaths last_path() const {
    return {.start = before, .end = x, .start_time = time - 0.25, .end_time = time};
  }
  // Returns the displacement after a measurement and, if it is beyond 0.1 m, a renewal.
  double follow(const BodyPaths& paths) {
    snapshot.measure(0, paths);
    if (!(snapshot.displacement(0) <= 0.1)) {
      snapshot.forget_renewed();
      snapshot.renew(0, paths, rules);
      ++renewals;
    }
    return snapshot.displacement(0);
  }

  double time = 3;  // s
  int renewals = 0;
  std::vector<Vec3> velocity, before;
  RecordRules rules{.limit = 0.02, .short_path = 0.05, .ahead = 0.5};
};

// Velocities are 0.29 m/s as a root mean square, so that paths go ahead for 1.7 s.
TEST(Snapshot, SteadyMotionIsExpected) {
  for (const bool on_paths : {false, true}) {
    SCOPED_TRACE(on_paths);
    Moving moving;
    int expected = 0;
    for (int step = 0; step < 24; ++step) {
      moving.go_on(0.25);
      const int before = moving.renewals;
      EXPECT_LE(moving.follow(on_paths ? moving.last_path() : moving.now()), 0.1);
      EXPECT_TRUE(moving.snapshot.looks_ahead(0));
      if (moving.renewals == before) ++expected;
      if (step == 0 || moving.renewals > before) {
        EXPECT_NEAR(moving.snapshot.displacement(0), 0, 1e-6);
      }
    }
    EXPECT_GE(moving.renewals, 2);
    EXPECT_GE(expected, 18);
  }
}

// Points that leave their expected paths are recorded on new ones, which lead through the places
// where the points are now. The others keep their paths.
TEST(Snapshot, PointsThatTurnAsideAreRecordedOnNewPaths) {
  Moving moving;
  moving.go_on(0.25);
  moving.follow(moving.now());
  const std::vector<Vec3> start(moving.snapshot.start().begin(), moving.snapshot.start().end());
  moving.go_on(0.25);
  moving.x[4].z() += 0.2;
  moving.velocity[4].z() += 0.4;
  moving.follow(moving.now());
  EXPECT_EQ(moving.renewals, 2);
  EXPECT_EQ(moving.renewed(), 1);
  EXPECT_NEAR(moving.snapshot.displacement(0), 0, 1e-6);
  for (int i = 0; i < moving.scene->point_count; ++i)
    EXPECT_EQ(moving.snapshot.start()[i] == start[i], i != 4) << i;
  moving.go_on(0.25);
  EXPECT_NEAR(moving.follow(moving.now()), 0, 1e-6);
  EXPECT_EQ(moving.renewals, 2);
}

// A step that is tried again ends earlier, and a wrong time costs no more than a renewal.
TEST(Snapshot, EveryTimeGivesABoundOfTheDisplacement) {
  Moving moving;
  moving.go_on(0.25);
  moving.follow(moving.now());
  const std::vector<Vec3> recorded = moving.x;
  moving.go_on(0.5);
  for (const double time : {-1e300, 0.0, 3.2, 3.25, 3.75, 5.0, 1e9}) {
    SCOPED_TRACE(time);
    moving.time = time;
    moving.snapshot.measure(0, moving.now());
    const double gone = std::clamp(time - 3.25, 0.0, 1.7277);
    for (std::size_t i = 0; i < moving.x.size(); ++i) {
      const Vec3 expected = recorded[i] + gone * moving.velocity[i];
      EXPECT_NEAR(moving.snapshot.displacements()[i], (moving.x[i] - expected).norm(), 1e-4) << i;
    }
  }
}

// Points that rest need not be recorded again when others have come to the ends of their paths.
TEST(Snapshot, PointsThatRestKeepTheirRecords) {
  Moving moving;
  for (std::size_t i = 0; i < 5; ++i) moving.velocity[i].setZero();
  moving.go_on(0.25);
  moving.follow(moving.now());
  EXPECT_EQ(moving.renewed(), moving.scene->point_count);
  moving.go_on(20);
  moving.follow(moving.now());
  EXPECT_EQ(moving.renewals, 2);
  EXPECT_EQ(moving.renewed(), moving.scene->point_count - 5);
}

// Points that speed up get new paths, no longer than before.
TEST(Snapshot, PathsAreNewWhereTheBodySpeedsUp) {
  Moving moving;
  for (Vec3& v : moving.velocity) v *= 0.01;
  moving.go_on(0.25);
  moving.follow(moving.now());
  for (Vec3& v : moving.velocity) v *= 100;
  moving.go_on(0.5);
  moving.follow(moving.now());
  EXPECT_EQ(moving.renewals, 2);
  double sum = 0;
  for (std::size_t i = 0; i < moving.x.size(); ++i)
    sum += (moving.snapshot.end()[i] - moving.snapshot.start()[i]).squaredNorm();
  EXPECT_NEAR(std::sqrt(sum / static_cast<double>(moving.x.size())), moving.rules.ahead, 1e-9);
}

// At the end of the recorded paths, the part of a new path that lies in the past would be long.
TEST(Snapshot, PathsAreNewWhereTheBodySpeedsUpLate) {
  Moving moving;
  moving.go_on(0.25);
  moving.follow(moving.now());
  moving.go_on(1.5);
  for (Vec3& v : moving.velocity) v *= 100;
  moving.x[3].z() += 0.5;
  moving.follow(moving.now());
  EXPECT_EQ(moving.renewals, 2);
  for (std::size_t i = 0; i < moving.x.size(); ++i)
    EXPECT_LE((moving.snapshot.end()[i] - moving.snapshot.start()[i]).norm(),
              3 * moving.rules.ahead);
}

// A path ahead would be left before the step after the next one.
TEST(Snapshot, LongStepsAreRecordedAsTheyAre) {
  Moving moving;
  moving.go_on(1.5);
  BodyPaths step = moving.last_path();
  step.start_time = moving.time - 1.5;
  moving.follow(step);
  EXPECT_FALSE(moving.snapshot.looks_ahead(0));
  for (std::size_t i = 0; i < moving.x.size(); ++i) {
    EXPECT_EQ(moving.snapshot.start()[i], moving.before[i]);
    EXPECT_EQ(moving.snapshot.end()[i], moving.x[i]);
  }
}

// Beside another body that moves, a body is recorded where it is.
TEST(Snapshot, BodiesStopLookingAhead) {
  Moving moving;
  moving.go_on(0.25);
  moving.follow(moving.now());
  EXPECT_TRUE(moving.snapshot.looks_ahead(0));
  moving.rules.ahead = 0;
  moving.go_on(9);
  moving.follow(moving.now());
  EXPECT_EQ(moving.renewals, 2);
  EXPECT_FALSE(moving.snapshot.looks_ahead(0));
  EXPECT_FALSE(moving.snapshot.has_paths(0));
  EXPECT_EQ(moving.renewed(), moving.scene->point_count);
}

// Velocities that are not finite, or whose squares are not, give no paths.
TEST(Snapshot, BadVelocitiesAreNotUsed) {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), 1e200}) {
    Moving moving;
    moving.velocity[3].x() = bad;
    moving.follow(moving.now());
    EXPECT_FALSE(moving.snapshot.looks_ahead(0));
    EXPECT_EQ(moving.snapshot.displacement(0), 0);
  }
}

}  // namespace
}  // namespace weft::sim::snapshot_test
