#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "bsi/shapes.h"
#include "sim/scene/spline_axis.h"
#include "sim/scene/spline_interpolation.h"
#include "sim/scene/spline_surface.h"

namespace weft::sim::spline_test {
namespace {

using Vec3 = Eigen::Vector3d;

// The value of a curve with scalar control points.
double value(const SplineAxis& axis, const std::vector<double>& control, double t,
             const SplineBasis::Values SplineBasis::*what = &SplineBasis::value) {
  const SplineBasis basis = axis.at(t);
  double sum = 0;
  for (int i = 0; i <= axis.degree(); ++i)
    sum += (basis.*what)[i] * control[axis.control_point(basis.element, i)];
  return sum;
}

// Returns the control points of the curve through an image of scalars.
std::vector<double> interpolated(const SplineAxis& axis, const std::vector<double>& image) {
  const Eigen::VectorXd points = Eigen::Map<const Eigen::VectorXd>(image.data(), std::ssize(image));
  const Eigen::VectorXd control = control_points_of(axis, points);
  return {control.begin(), control.end()};
}

struct Axis {
  int degree, control_points;
  bool is_closed;
};
class Splines : public testing::TestWithParam<Axis> {
 protected:
  SplineAxis axis() const {
    return {GetParam().degree, GetParam().control_points, GetParam().is_closed};
  }
  // Scalars that look random.
  std::vector<double> some_control_points() const {
    std::vector<double> control;
    for (int i = 0; i < GetParam().control_points; ++i) control.push_back(std::sin(3.0 * i * i));
    return control;
  }
};

TEST_P(Splines, ValuesSumToOneAndSlopesAreDerivatives) {
  const SplineAxis splines = axis();
  const std::vector<double> control = some_control_points();
  constexpr double step = 1e-5;
  for (double t = 0.013; t + step < splines.elements(); t += 0.171) {
    const SplineBasis basis = splines.at(t);
    double sum = 0;
    for (const double each : basis.value) sum += each;
    EXPECT_NEAR(sum, 1, 1e-14);
    const auto difference = [&](const SplineBasis::Values SplineBasis::*what) {
      return (value(splines, control, t + step, what) - value(splines, control, t - step, what)) /
             (2 * step);
    };
    EXPECT_NEAR(value(splines, control, t, &SplineBasis::slope), difference(&SplineBasis::value),
                1e-8);
    EXPECT_NEAR(value(splines, control, t, &SplineBasis::second), difference(&SplineBasis::slope),
                1e-8);
  }
}

TEST_P(Splines, ValueAndSlopeAreContinuousAtKnots) {
  const SplineAxis splines = axis();
  const std::vector<double> control = some_control_points();
  for (int knot = 1; knot < splines.elements(); ++knot) {
    for (const auto what : {&SplineBasis::value, &SplineBasis::slope}) {
      const auto at = [&](int element) {
        const SplineBasis basis = splines.at(element, knot);
        double sum = 0;
        for (int i = 0; i <= splines.degree(); ++i)
          sum += (basis.*what)[i] * control[splines.control_point(element, i)];
        return sum;
      };
      EXPECT_NEAR(at(knot - 1), at(knot), 1e-13);
    }
  }
}

TEST_P(Splines, CurvePassesThroughTheImage) {
  const SplineAxis splines = axis();
  const std::vector<double> image = some_control_points();
  const std::vector<double> control = interpolated(splines, image);
  for (int i = 0; i < splines.control_points(); ++i)
    EXPECT_NEAR(value(splines, control, splines.image_parameter(i)), image[i], 1e-11);
}

// The curve through evenly spaced points amplifies their errors exponentially in their number.
TEST(LongSplines, AmplifyErrorsOfTheImageLittle) {
  for (const int count : {17, 18, 33, 129, 257}) {
    const Eigen::MatrixXd matrix =
        control_points_of(SplineAxis(3, count, false), Eigen::MatrixXd::Identity(count, count));
    EXPECT_LT(matrix.cwiseAbs().rowwise().sum().maxCoeff(), count == 17 ? 41 : 6) << count;
  }
}

// Returns the largest distance of the curve from an image of f(x), 0 <= x <= 1, at its points.
double distance_from_image(int count, const std::function<double(double)>& f) {
  const SplineAxis splines(3, count, false);
  std::vector<double> image;
  for (int i = 0; i < count; ++i) image.push_back(f(i / (count - 1.0)));
  const std::vector<double> control = interpolated(splines, image);
  double largest = 0;
  for (int i = 0; i < count; ++i) {
    const double found = value(splines, control, splines.image_parameter(i));
    largest = std::max(largest, std::abs(found - f(i / (count - 1.0))));
  }
  return largest;
}

TEST(LongSplines, PassByTheImageWithOrderFour) {
  // A matrix of the longest one would take 80 GB.
  for (const int count : {18, 33, 129, 257, 100000}) {
    const double distance =
        distance_from_image(count, [](double x) { return 1 + x * (2 - x * (3 + 5 * x)); });
    EXPECT_LT(distance, count > 1000 ? 1e-11 : 1e-13) << count;
  }
  const auto wave = [](double x) { return std::sin(5 * x); };
  double before = distance_from_image(33, wave);
  EXPECT_LT(before, 1e-5);
  for (const int count : {65, 129}) {
    const double distance = distance_from_image(count, wave);
    EXPECT_LT(distance, before / 12) << count;
    before = distance;
  }
}

// The integral of a polynomial, or of a constant on a closed axis.
TEST_P(Splines, QuadratureIsOfItsOrder) {
  const SplineAxis splines = axis();
  const bool is_short = splines.elements() < (splines.degree() == 3 ? 4 : 6);
  const int of_strain = splines.degree() == 3 ? (is_short ? 2 : 5) : (is_short ? 1 : 3);
  const auto expect_order = [&](const std::vector<QuadraturePoint>& points, int degree) {
    for (int power = 0; power <= (GetParam().is_closed ? 0 : degree); ++power) {
      const double length = splines.elements();
      double sum = 0;
      for (const auto& [t, weight] : points) {
        EXPECT_GT(weight, 0);
        sum += weight * std::pow(t / length, power);
      }
      EXPECT_NEAR(sum, length / (power + 1), 1e-13 * length) << power;
    }
  };
  expect_order(splines.strain_points(), of_strain);
  expect_order(splines.value_points(), 2 * splines.degree() - 1);
  expect_order(splines.gauss_points(2), 3);
  expect_order(splines.gauss_points(3), 5);
  expect_order(splines.gauss_points(4), 7);
}

INSTANTIATE_TEST_SUITE_P(All, Splines,
                         testing::Values(Axis{3, 4, false}, Axis{3, 6, false}, Axis{3, 7, false},
                                         Axis{3, 13, false}, Axis{3, 4, true}, Axis{3, 9, true},
                                         Axis{2, 3, false}, Axis{2, 6, false}, Axis{2, 11, false},
                                         Axis{2, 3, true}, Axis{2, 8, true}));

TEST(SplineSurface, OfAnImageOfEqualSpacingIsUniform) {
  const bsi::Surface plate = bsi::make_rectangle(2, 1, 6, 9);
  const SplineSurface surface(plate.atlas, 3);
  const std::vector<Vec3> control = surface.interpolate(plate.atlas, plate.positions);
  const auto& [u, v] = surface.patches()[0];
  for (double t = 0; t <= u.elements(); t += 0.7) {
    const SplineSurface::Point point = surface.at(plate.atlas, {0, t, 1.3});
    EXPECT_NEAR(point.tangent_u(control).x(), 2.0 / u.elements(), 1e-13);
    EXPECT_NEAR(point.tangent_v(control).y(), 1.0 / v.elements(), 1e-13);
    EXPECT_NEAR(point.position(control).x(), -1 + 2 * t / u.elements(), 1e-13);
  }
}

TEST(SplineSurface, PassesThroughAnImageOfSewnPatches) {
  const bsi::Surface ball = bsi::make_sphere(1, 9);
  const SplineSurface surface(ball.atlas, 3);
  const std::vector<Vec3> control = surface.interpolate(ball.atlas, ball.positions);
  const std::vector<SplineSurface::Place> places = surface.image_places(ball.atlas);
  const SurfaceMap map = surface.map_to(ball.atlas, places);
  double farthest = 0;
  for (int i = 0; i < map.point_count(); ++i)
    farthest = std::max(farthest, (map.apply(i, control) - ball.positions[i]).norm());
  EXPECT_LT(farthest, 1e-12);
}

// Returns the largest distance from the unit sphere of the surface through points of it.
double distance_from_sphere(const bsi::Surface& part) {
  const SplineSurface surface(part.atlas, 3);
  const std::vector<Vec3> control = surface.interpolate(part.atlas, part.positions);
  const auto& [u, v] = surface.patches()[0];
  double worst = 0;
  for (double a = 0; a <= u.elements(); a += 0.23) {
    for (double b = 0; b <= v.elements(); b += 0.31) {
      const Vec3 x = surface.at(part.atlas, {0, a, b}).position(control);
      worst = std::max(worst, std::abs(x.norm() - 1));
    }
  }
  return worst;
}
bsi::Surface part_of_sphere(int n) { return bsi::make_sphere_sector(1, 0, 60, n, n, 90); }

// The interpolated sphere approaches the sphere with the fourth power of the spacing.
TEST(SplineSurface, ApproachesTheShapeWithOrderFour) {
  const double coarse = distance_from_sphere(part_of_sphere(11));
  const double fine = distance_from_sphere(part_of_sphere(21));
  EXPECT_LT(fine, 1e-6);
  EXPECT_GT(std::log2(coarse / fine), 3.5);
}

// Trajectories hold images in single precision.
TEST(SplineSurface, IsSmoothThroughALargeImageInSinglePrecision) {
  bsi::Surface part = part_of_sphere(65);
  for (Vec3& point : part.positions) point = point.cast<float>().cast<double>();
  EXPECT_LT(distance_from_sphere(part), 1e-6);
}

}  // namespace
}  // namespace weft::sim::spline_test
