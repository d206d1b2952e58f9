// Batches of numbers in single precision, compared with one number after the other.
#include "sim/particles/float_lanes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace weft::sim::float_lanes_test {
namespace {

constexpr int count = FloatLanes::count;

FloatLanes ascending(float first, float step) {
  FloatLanes numbers;
  for (int lane = 0; lane < count; ++lane)
    numbers.values[lane] = first + step * static_cast<float>(lane);
  return numbers;
}

TEST(FloatLanes, FoursInMemoryAreReadAndStoredLaneByLane) {
  struct alignas(16) Four {
    float numbers[4];
  };
  std::array<Four, 3 * count> fours{};
  for (int i = 0; i < 3 * count; ++i) {
    for (int k = 0; k < 4; ++k) fours[i].numbers[k] = static_cast<float>(10 * i + k);
  }
  // Every second record, in descending order, so that their places and their lanes differ.
  const auto record = [](int lane) { return 2 * (count - lane); };
  auto loaded = load_fours([&](int lane) { return fours[record(lane)].numbers; });
  for (int lane = 0; lane < count; ++lane) {
    for (int k = 0; k < 4; ++k)
      EXPECT_EQ(loaded[k].values[lane], static_cast<float>(10 * record(lane) + k));
  }
  for (int k = 0; k < 4; ++k) loaded[k] += FloatLanes(1000.0F * static_cast<float>(k + 1));
  store_fours(loaded, [&](int lane) { return fours[record(lane)].numbers; });
  for (int i = 0; i < 3 * count; ++i) {
    const bool is_stored = i % 2 == 0 && i > 0 && i <= 2 * count;
    for (int k = 0; k < 4; ++k) {
      const int expected = 10 * i + k + (is_stored ? 1000 * (k + 1) : 0);
      EXPECT_EQ(fours[i].numbers[k], static_cast<float>(expected));
    }
  }
}

TEST(FloatLanes, ComparisonsAndChoices) {
  const FloatLanes numbers = ascending(0, 1);
  EXPECT_EQ(bits_of(numbers < FloatLanes(0)), 0U);
  EXPECT_EQ(bits_of(numbers < FloatLanes(3)), 7U);
  EXPECT_EQ(bits_of(numbers < FloatLanes(99)), (1U << count) - 1);
  EXPECT_EQ(bits_of((numbers < FloatLanes(1)) | (FloatLanes(5) < numbers)), 0b11000001U);
  const FloatLanes chosen = choose(numbers < FloatLanes(2), numbers, FloatLanes(-1)),
                   positive = magnitude(ascending(-3, 1)), most = larger(numbers, FloatLanes(4)),
                   roots = square_root(numbers);
  for (int lane = 0; lane < count; ++lane) {
    EXPECT_EQ(chosen.values[lane], lane < 2 ? static_cast<float>(lane) : -1);
    EXPECT_EQ(positive.values[lane], std::abs(static_cast<float>(lane - 3)));
    EXPECT_EQ(most.values[lane], static_cast<float>(std::max(lane, 4)));
    EXPECT_EQ(roots.values[lane], std::sqrt(static_cast<float>(lane)));
  }
}

TEST(FloatLanes, VectorsHoldOneVectorPerLane) {
  FloatLaneVec3 a = FloatLaneVec3::Constant(0.0F), b = a;
  for (int lane = 0; lane < count; ++lane) {
    set_lane(a, lane, Vec3(lane, 1, -2));
    set_lane(b, lane, Vec3(3, -lane, 0.5));
  }
  const FloatLaneVec3 product = a.cross(b);
  const FloatLanes dot = a.dot(b);
  for (int lane = 0; lane < count; ++lane) {
    const Vec3 one(lane, 1, -2), other(3, -lane, 0.5);
    EXPECT_EQ(get_lane(product, lane), one.cross(other));
    EXPECT_EQ(dot.values[lane], static_cast<float>(one.dot(other)));
  }
}

}  // namespace
}  // namespace weft::sim::float_lanes_test
