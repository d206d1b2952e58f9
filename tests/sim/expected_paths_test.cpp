// The contact search of points whose velocities are known: its lists against every pair of features
// while the points follow their expected paths, leave them, or try a step again.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "tests/sim/contact_oracle.h"
#include "tests/sim/contact_scenes.h"

namespace weft::sim::expected_paths_test {
namespace {

using namespace contact_scenes;  // NOLINT: scenes of this test

const std::string plate = R"(
[[obstacle]]
name = "plate"
shape = { type = "rectangle", size = [1, 1], resolution = [7, 7] }
)";

// Positions (m) of all surface points, and their velocities (m/s).
struct Motion {
  Positions x, v;
};
using MotionAt = std::function<Motion(double time)>;

class Followed {
 public:
  explicit Followed(const std::string& text)
      : scene(scene_of(text)),
        oracle(*scene),
        search(*scene, statistics, {make_cpu_search(*scene), {}}) {}

  // Follows a motion by steps of `step` (s). A third of the steps are tried first with four times
  // the length. Without hints, velocities and times are kept from the search.
  void follow(const MotionAt& motion, int steps, double step, bool with_hints) {
    std::mt19937 random(3);
    double time = 0;
    Motion start = motion(0);
    for (int k = 0; k < steps; ++k) {
      const auto try_step = [&](double length) {
        const Motion end = motion(time + length);
        update(end, with_hints ? time + length : 0, with_hints);
        update_path(start.x, end.x, with_hints ? time : 0, with_hints ? time + length : 0);
        return end;
      };
      if (random() % 3 == 0) try_step(4 * step);
      start = try_step(step);
      time += step;
    }
  }

  std::unique_ptr<const Scene> scene;
  ContactOracle oracle;
  Statistics statistics;
  ContactSearch search;
  std::size_t in_reach = 0;

 private:
  void update(const Motion& now, double time, bool with_velocity) {
    ASSERT_FALSE(
        search.update({now.x, time}, with_velocity ? std::span(now.v) : std::span<const Vec3>()));
    ASSERT_EQ(oracle.missing(search.lists(), now.x), "") << time;
    in_reach += oracle.in_reach(now.x).size();
  }
  void update_path(const Positions& start, const Positions& end, double from, double to) {
    ASSERT_FALSE(search.update_path({start, from}, {end, to}));
    for (const double part : {0.0, 0.4, 0.7, 1.0}) {
      Positions between = start;
      for (std::size_t i = 0; i < start.size(); ++i) between[i] += part * (end[i] - start[i]);
      ASSERT_EQ(oracle.missing(search.lists(), between), "") << from << " s, part " << part;
    }
  }
};

// Runs a motion with and without hints. With hints, `factor` times the searches are no more than
// those without them.
void expect_complete_lists(const std::string& text,
                           const std::function<MotionAt(const Scene&)>& motion_of, int steps,
                           double step, double factor) {
  Followed with(text), without(text);
  with.follow(motion_of(*with.scene), steps, step, true);
  without.follow(motion_of(*without.scene), steps, step, false);
  EXPECT_GT(with.in_reach, 200U);
  EXPECT_EQ(with.in_reach, without.in_reach);
  EXPECT_LE(factor * static_cast<double>(with.statistics.counters.rebuilds),
            static_cast<double>(without.statistics.counters.rebuilds));
}

// Points of dynamic bodies swing about `middle`, each in a direction and with a frequency of its
// own, by up to `amplitude`, m.
MotionAt swinging(const Scene& scene, const Positions& middle, double amplitude, double frequency) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> part(-1, 1);
  std::vector<Vec3> way;
  std::vector<double> rate;
  for (int i = 0; i < scene.dynamic_points; ++i) {
    const double along_x = part(random), along_y = part(random), along_z = part(random);
    way.emplace_back(amplitude * Vec3(along_x, along_y, along_z));
    rate.push_back(frequency * (1.5 + 0.5 * part(random)));
  }
  return [=](double time) {
    Motion now{middle, std::vector<Vec3>(middle.size(), Vec3::Zero())};
    for (std::size_t i = 0; i < way.size(); ++i) {
      now.x[i] += std::sin(rate[i] * time) * way[i];
      now.v[i] = rate[i] * std::cos(rate[i] * time) * way[i];
    }
    return now;
  };
}

TEST(ExpectedPaths, ListsOfASwingingFoldedSheetAreComplete) {
  expect_complete_lists(
      one_sheet,
      [](const Scene& scene) {
        return swinging(scene, folded(scene, reach + 0.3 * slack), 0.06, 1);
      },
      120, 0.05, 2);
}

// The sheet falls onto the plate at 1 m/s, one corner first, and is thrown back.
TEST(ExpectedPaths, ListsOfASheetThatFallsOnAPlateAreComplete) {
  expect_complete_lists(
      one_sheet + plate,
      [](const Scene& scene) {
        return [&scene](double time) {
          Motion now{scene.initial_position,
                     std::vector<Vec3>(scene.initial_position.size(), Vec3::Zero())};
          const double turn = 0.1;  // s
          for (int i = 0; i < scene.dynamic_points; ++i) {
            const double tilt = 0.01 * (now.x[i].x() + now.x[i].y() + 1);
            now.x[i].z() += 0.3 * reach + tilt + (1 + tilt) * std::abs(time - turn);
            now.v[i].z() = (1 + tilt) * (time < turn ? -1 : 1);
          }
          return now;
        };
      },
      100, 0.002, 0);
}

// Lists of two bodies that move do not look ahead, those of each with itself or the plate do.
TEST(ExpectedPaths, ListsOfBodiesThatMoveBesideAPlateAreComplete) {
  const std::string two_sheets = contact_head + rectangle("upper", "0.5, 0.5", "5, 5") +
                                 rectangle("lower", "0.5, 0.5", "5, 5") + plate;
  expect_complete_lists(
      two_sheets,
      [](const Scene& scene) {
        Positions middle = scene.initial_position;
        for (int i = 0; i < scene.dynamic_points; ++i)
          middle[i].z() += (i < scene.bodies[1].first_point ? 5 : 1.5) * reach;
        const MotionAt swing = swinging(scene, middle, 0.02, 1);
        return [&scene, swing](double time) {
          Motion now = swing(time);
          // The upper sheet comes down to the lower one, and leaves it again.
          for (int i = 0; i < scene.bodies[1].first_point; ++i) {
            now.x[i].z() -= 3.2 * reach * std::sin(time);
            now.v[i].z() -= 3.2 * reach * std::cos(time);
          }
          return now;
        };
      },
      80, 0.04, 1.1);
}

// Hints that are wrong cost searches, and lose no pair.
TEST(ExpectedPaths, ListsAreCompleteWhereVelocitiesAndTimesAreWrong) {
  Followed misled(one_sheet + plate);
  const MotionAt truth = swinging(
      *misled.scene,
      [&] {
        Positions lifted = misled.scene->initial_position;
        for (int i = 0; i < misled.scene->dynamic_points; ++i) lifted[i].z() += reach;
        return lifted;
      }(),
      0.06, 1);
  std::mt19937 random(7);
  std::normal_distribution<double> wrong(0, 1);
  const MotionAt lie = [&](double time) {
    Motion now = truth(time + 0.3 * std::sin(40 * time));
    for (Vec3& v : now.v) v = Vec3(wrong(random), wrong(random), wrong(random));
    return now;
  };
  misled.follow(lie, 80, 0.05, true);
  EXPECT_GT(misled.in_reach, 200U);
}

}  // namespace
}  // namespace weft::sim::expected_paths_test
