#include "sim/solver/coarse_axis.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>

namespace weft::sim::coarse_axis_test {
namespace {

// Returns all levels of an axis, the finest first.
std::vector<CoarseAxis> levels(int quads, bool wraps, int degree) {
  std::vector<CoarseAxis> all{{quads, quads, wraps, degree}};
  while (all.back().can_be_coarsened()) all.push_back(all.back().coarser());
  return all;
}

// Coefficients of the function that is 0 up to a knot and (x - knot)^degree beyond it: for each
// basis function, the product over its inner knots (Marsden's identity).
std::vector<double> truncated_power(const CoarseAxis& axis, double knot) {
  std::vector<double> result;
  for (int i = 0; i < axis.nodes(); ++i) {
    double product = 1;
    for (int k = 1; k <= axis.degree; ++k)
      product *= std::max(0.0, axis.start(i + k - axis.degree) - knot);
    result.push_back(product);
  }
  return result;
}

std::vector<double> refined(const CoarseAxis& fine, const CoarseAxis& coarse,
                            const std::vector<double>& values) {
  std::vector<double> result;
  for (const auto& shares : fine.shares(coarse)) {
    double sum = 0;
    for (const auto& [node, weight] : shares) sum += weight * values[node];
    result.push_back(sum);
  }
  return result;
}

// The truncated powers at the knots of an open axis and the polynomials span its splines.
TEST(CoarseAxis, SplinesOfOpenAxesStayTheSameFunctions) {
  for (const int degree : {2, 3}) {
    for (int elements = 4; elements < 70; ++elements) {
      const std::vector<CoarseAxis> axes = levels(elements, false, degree);
      for (std::size_t l = 0; l + 1 < axes.size(); ++l) {
        const CoarseAxis &fine = axes[l], &coarse = axes[l + 1];
        ASSERT_LT(coarse.nodes(), fine.nodes());
        for (int j = -degree; j < coarse.intervals; ++j) {
          const double knot = j < 0 ? j : coarse.start(j);
          const std::vector<double> expected = truncated_power(fine, knot);
          const std::vector<double> found = refined(fine, coarse, truncated_power(coarse, knot));
          for (std::size_t i = 0; i < found.size(); ++i)
            ASSERT_NEAR(found[i], expected[i], 1e-10 * std::pow(elements + degree, degree));
        }
      }
    }
  }
}

// The value of a closed spline of degree 3 or 2 by the recursion of Cox and de Boor.
double value_of(const CoarseAxis& axis, const std::vector<double>& coefficients, double x) {
  const std::function<double(int, int)> basis = [&](int i, int degree) -> double {
    const double first = axis.start(i);
    if (degree == 0) return x >= first && x < axis.start(i + 1) ? 1 : 0;
    const double last = axis.start(i + degree), before = axis.start(i + 1);
    const double end = axis.start(i + degree + 1);
    return (x - first) / (last - first) * basis(i, degree - 1) +
           (end - x) / (end - before) * basis(i + 1, degree - 1);
  };
  double sum = 0;
  for (int i = -axis.degree; i < axis.intervals; ++i)
    sum += basis(i, axis.degree) * coefficients[(i + axis.degree) % axis.nodes()];
  return sum;
}

TEST(CoarseAxis, SplinesOfClosedAxesStayTheSameFunctions) {
  for (const int degree : {2, 3}) {
    for (const int elements : {8, 9, 11, 16, 23, 24}) {
      const std::vector<CoarseAxis> axes = levels(elements, true, degree);
      ASSERT_GT(axes.size(), 1U);
      for (std::size_t l = 0; l + 1 < axes.size(); ++l) {
        std::vector<double> coarse;
        for (int i = 0; i < axes[l + 1].nodes(); ++i) coarse.push_back(std::sin(3.7 * i * i));
        const std::vector<double> fine = refined(axes[l], axes[l + 1], coarse);
        for (double x = 0.13; x < elements; x += 0.49)
          ASSERT_NEAR(value_of(axes[l], fine, x), value_of(axes[l + 1], coarse, x), 1e-12);
      }
    }
  }
}

TEST(CoarseAxis, NearestNodesAreDistinctAndMirrored) {
  for (const int degree : {0, 2, 3}) {
    for (const bool wraps : {false, true}) {
      for (int quads = 8; quads < 140; ++quads) {
        const std::vector<CoarseAxis> axes = levels(quads, wraps, degree);
        for (std::size_t l = 0; l + 1 < axes.size(); ++l) {
          const std::vector<int> nearest = axes[l].nearest_nodes(axes[l + 1]);
          ASSERT_EQ(nearest.size(), static_cast<std::size_t>(axes[l + 1].nodes()));
          ASSERT_LT(nearest.back(), axes[l].nodes());
          for (std::size_t j = 1; j < nearest.size(); ++j) ASSERT_GT(nearest[j], nearest[j - 1]);
          if (wraps) continue;
          ASSERT_EQ(nearest.front(), 0);
          for (std::size_t j = 0; 2 * j + 1 < nearest.size(); ++j)
            ASSERT_EQ(nearest[j], axes[l].nodes() - 1 - nearest[nearest.size() - 1 - j]);
        }
      }
    }
  }
}

}  // namespace
}  // namespace weft::sim::coarse_axis_test
