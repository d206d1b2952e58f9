// Curves and gusts: their values, corners and statistics.
#include "sim/scene/time_curve.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace weft::sim::time_curve_test {
namespace {

Varying<double> curve(std::vector<double> times, std::vector<double> values, Between between) {
  Varying<double> result = 0.0;
  result.form = CurveCase<double>{std::move(times), std::move(values), between};
  return result;
}

// The value away from jumps.
double at(const TimeCurve<double>& of, double time) { return of.at({time, time}); }

TEST(TimeCurve, GoesThroughItsValuesAndHoldsTheFirstAndTheLast) {
  for (const Between between : {Between::linear, Between::smooth, Between::step}) {
    const TimeCurve<double> of(curve({1, 2, 4}, {3, -1, 7}, between));
    EXPECT_TRUE(of.varies());
    EXPECT_EQ(at(of, 0), 3);
    EXPECT_EQ(at(of, 1), 3);
    EXPECT_EQ(at(of, 2), -1);
    EXPECT_EQ(at(of, 4), 7);
    EXPECT_EQ(at(of, 1e9), 7);
  }
}

TEST(TimeCurve, IsStraightEasedOrConstantBetweenItsTimes) {
  EXPECT_DOUBLE_EQ(at(TimeCurve<double>(curve({1, 3}, {2, 6}, Between::linear)), 1.5), 3);
  EXPECT_EQ(at(TimeCurve<double>(curve({1, 3}, {2, 6}, Between::step)), 2.999), 2);
  // 6 s^5 - 15 s^4 + 10 s^3 at s = 1/4.
  const TimeCurve<double> eased(curve({1, 3}, {2, 6}, Between::smooth));
  EXPECT_DOUBLE_EQ(at(eased, 1.5), 2 + 4 * (6.0 / 1024 - 15.0 / 256 + 10.0 / 64));
  constexpr double h = 1e-3;
  for (const double corner : {1.0, 3.0}) {
    const double before = at(eased, corner - h), after = at(eased, corner + h);
    EXPECT_NEAR((after - before) / (2 * h), 0, 1e-4) << corner;
    EXPECT_NEAR((after - 2 * at(eased, corner) + before) / (h * h), 0, 0.05) << corner;
  }
}

TEST(TimeCurve, AJumpHasTwoSides) {
  const TimeCurve<double> of(curve({0, 2}, {1, 5}, Between::step));
  EXPECT_EQ(of.at({2, 1.9}), 1);
  EXPECT_EQ(of.at({2, 2.1}), 5);
}

TEST(TimeCurve, OfVectorsGoesComponentByComponent) {
  Varying<Vec3> wind = Vec3(0, 0, 0);
  wind.form = CurveCase<Vec3>{{0, 1}, {Vec3(0, 2, 4), Vec3(1, 0, 4)}, Between::linear};
  EXPECT_LT((TimeCurve<Vec3>(wind).at({0.25, 0.25}) - Vec3(0.25, 1.5, 4)).norm(), 1e-15);
}

TEST(TimeCurve, StepsEndWhereItsCourseChanges) {
  const auto times = [](const Varying<double>& source) {
    std::vector<double> events;
    for (const MotionEvent& event : times_of(source).events) events.push_back(event.time);
    return events;
  };
  using Times = std::vector<double>;
  EXPECT_EQ(times(curve({0, 1, 2, 3, 4}, {0, 1, 1, 1, 2}, Between::linear)), (Times{1, 3, 4}));
  EXPECT_EQ(times(curve({0, 1, 2, 3, 4}, {0, 1, 1, 1, 2}, Between::smooth)), (Times{1, 3, 4}));
  EXPECT_EQ(times(curve({0, 1, 2, 3, 4}, {0, 1, 1, 1, 2}, Between::step)), (Times{1, 4}));
  EXPECT_EQ(times(curve({0, 1}, {3, 3}, Between::linear)), Times{});
  EXPECT_FALSE(times_of(curve({0, 1}, {0, 1}, Between::linear)).events[0].jumps);
  EXPECT_TRUE(times_of(curve({0, 1}, {0, 1}, Between::step)).events[0].jumps);
}

TEST(TimeCurve, SaysWhenItChanges) {
  const CurveTimes straight = times_of(curve({1, 2, 3}, {0, 1, 1}, Between::linear));
  EXPECT_FALSE(straight.changes_between(0, 1));
  EXPECT_TRUE(straight.changes_between(0, 1.1));
  EXPECT_TRUE(straight.changes_between(1.9, 5));
  EXPECT_FALSE(straight.changes_between(2, 5));
  const CurveTimes jump = times_of(curve({0, 2}, {0, 1}, Between::step));
  EXPECT_FALSE(jump.changes_between(0, 2));
  EXPECT_TRUE(jump.changes_between(1.9, 2.1));
  EXPECT_FALSE(jump.changes_between(2, 5));
}

TEST(TimeCurve, OfEqualValuesIsAConstant) {
  const Varying<double> constant = curve({0, 1}, {3, 3}, Between::linear);
  EXPECT_FALSE(constant.varies());
  EXPECT_EQ(constant.constant(), 3);
  EXPECT_FALSE(constant.is_zero());
  EXPECT_TRUE(curve({0, 1}, {0, 0}, Between::step).is_zero());
  EXPECT_FALSE(curve({0, 1}, {0, 1}, Between::step).is_zero());
  EXPECT_EQ(smallest(curve({0, 1, 2}, {2, 0.5, 1}, Between::linear)), 0.5);
}

constexpr double scale = 2, speed = 5, intensity = 0.2;
constexpr double deviation = intensity * speed;

Gust gust(int seed = 1) {
  return Gust({.mean = {3, 0, -4}, .intensity = intensity, .time_scale = scale, .seed = seed});
}

// The speed along the mean wind.
double speed_at(const Gust& of, double time) { return of.at(time).dot(Vec3(0.6, 0, -0.8)); }

TEST(Gust, BlowsAlongItsMean) {
  const Gust of = gust();
  for (const double time : {0.0, 0.7, 31.0})
    EXPECT_LT(of.at(time).cross(Vec3(3, 0, -4)).norm(), 1e-12) << time;
}

TEST(Gust, OfASeedIsTheSameEverywhere) {
  EXPECT_EQ(speed_at(gust(7), 12.5), speed_at(gust(7), 12.5));
  EXPECT_GT(std::abs(speed_at(gust(7), 12.5) - speed_at(gust(8), 12.5)), 1e-3);
  // The standard fixes std::mt19937_64, so these numbers differ by the rounding of cosines alone.
  EXPECT_NEAR(speed_at(gust(1), 0), 5.2735493753702647, 1e-12);
  EXPECT_NEAR(speed_at(gust(1), 10), 5.2981737503594, 1e-11);
}

// Estimates over a time D scatter: with the autocorrelation sigma^2 exp(-|t| / T), a mean by sigma
// sqrt(2 T / D), a variance by sigma^2 sqrt(2 T / D) and other products by no more. The tests allow
// three times as much, and for correlations the share 2 / (pi w T) of the spectrum beyond the
// highest wave w, 0.8 %, besides.
constexpr double duration = 20000 * scale, interval = 0.05 * scale;
const double scatter = std::sqrt(2 * scale / duration);

std::vector<double> fluctuations(int seed) {
  const Gust of = gust(seed);
  std::vector<double> result;
  for (double time = 0; time < duration; time += interval)
    result.push_back(speed_at(of, time) - speed);
  return result;
}

double mean_product(const std::vector<double>& of, std::size_t lag) {
  double sum = 0;
  for (std::size_t i = 0; i + lag < of.size(); ++i) sum += of[i] * of[i + lag];
  return sum / static_cast<double>(of.size() - lag);
}

TEST(Gust, HasItsMeanDeviationAndCorrelationOverALongTime) {
  for (const int seed : {1, 2}) {
    const std::vector<double> of = fluctuations(seed);
    double mean = 0;
    for (const double each : of) mean += each / static_cast<double>(of.size());
    EXPECT_NEAR(mean, 0, 3 * scatter * deviation);
    const double variance = mean_product(of, 0);
    EXPECT_NEAR(variance / (deviation * deviation), 1, 3 * scatter);
    for (const double lag : {0.25, 0.5, 1.0, 2.0, 4.0}) {
      const auto places = static_cast<std::size_t>(std::lround(lag * scale / interval));
      EXPECT_NEAR(mean_product(of, places) / variance, std::exp(-lag), 3 * scatter + 0.008) << lag;
    }
  }
}

// The integral time scale: the integral of the correlation, by the trapezoid rule up to eight
// scales, beyond which an exponential has 0.03 % left. Scatter of correlations, each within that
// of the last test, is correlated over about one scale and adds up over the eight as a root.
TEST(Gust, HasItsIntegralTimeScale) {
  const std::vector<double> of = fluctuations(3);
  const double variance = mean_product(of, 0);
  double integral = 0.5 * interval;
  for (std::size_t lag = 1; static_cast<double>(lag) * interval < 8 * scale; ++lag)
    integral += interval * mean_product(of, lag) / variance;
  EXPECT_NEAR(integral / scale, 1, 3 * std::sqrt(8.0) * scatter);
}

// The power in octaves of frequency is that of Dryden's spectrum: 2 / pi (atan w1 T - atan w0 T).
TEST(Gust, HasDrydensSpectrum) {
  const std::vector<double> of = fluctuations(1);
  const double variance = mean_product(of, 0);
  // A window of 256 scales resolves frequencies of 2 pi / (256 T); averages over all windows.
  const auto window = static_cast<std::size_t>(std::lround(256 * scale / interval));
  for (const double from : {0.25, 1.0, 4.0}) {
    const double to = 2 * from, step = 2 * std::numbers::pi / 256;
    const auto first = static_cast<int>(std::ceil(from / step)),
               last = static_cast<int>(std::ceil(to / step));
    double power = 0;
    int windows = 0;
    for (std::size_t begin = 0; begin + window <= of.size(); begin += window, ++windows) {
      for (int k = first; k < last; ++k) {
        double real = 0, imaginary = 0;
        for (std::size_t i = 0; i < window; ++i) {
          const double angle =
              2 * std::numbers::pi * k * static_cast<double>(i) / static_cast<double>(window);
          real += of[begin + i] * std::cos(angle);
          imaginary += of[begin + i] * std::sin(angle);
        }
        const auto size = static_cast<double>(window);
        power += 2 * (real * real + imaginary * imaginary) / (size * size);
      }
    }
    const double exact = 2 / std::numbers::pi * (std::atan(last * step) - std::atan(first * step));
    // Bands of equal energy: 64 waves place the power of an octave to within one of them, 1.6 % of
    // all.
    EXPECT_NEAR(power / windows / variance, exact, 1.0 / Gust::waves + 0.1 * exact) << from;
  }
}

TEST(Gust, IsSmoothWithinItsLongestStep) {
  const Gust of = gust();
  // The fastest wave has the frequency tan(pi/2 (1 - 1/128)) / T.
  const double fastest = std::tan(std::numbers::pi / 2 * (1 - 1.0 / 128)) / scale;
  EXPECT_DOUBLE_EQ(of.longest_step(), std::numbers::pi / 2 / fastest);
  Varying<Vec3> wind = Vec3(0, 0, 0);
  wind.form = GustCase{.mean = {3, 0, -4}, .intensity = intensity, .time_scale = scale};
  EXPECT_EQ(times_of(wind).longest_step, of.longest_step());
  // Bounds of all waves together: the second difference is at most h^2 w^2 sum of amplitudes.
  const double h = 0.01 * of.longest_step();
  const double bound = h * h * fastest * fastest * deviation * std::sqrt(2.0 * Gust::waves);
  for (double time = 0; time < 20; time += 0.37) {
    const double bend = speed_at(of, time - h) - 2 * speed_at(of, time) + speed_at(of, time + h);
    EXPECT_LT(std::abs(bend), bound) << time;
  }
}

TEST(Gust, WithoutIntensityIsConstant) {
  Varying<Vec3> wind = Vec3(0, 0, 0);
  wind.form = GustCase{.mean = {3, 0, -4}, .intensity = 0, .time_scale = scale};
  EXPECT_FALSE(wind.varies());
  EXPECT_EQ(wind.constant(), Vec3(3, 0, -4));
}

}  // namespace
}  // namespace weft::sim::time_curve_test
