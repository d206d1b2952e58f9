#include "sim/scene/spline_axis.h"

#include <Eigen/LU>
#include <Eigen/SparseLU>
#include <algorithm>
#include <cassert>
#include <cmath>

#include "sim/scene/spline_interpolation.h"

namespace weft::sim {

namespace {

// A Gauss-Legendre rule: abscissae on [0, 1] and their weights.
struct GaussRule {
  std::vector<double> abscissae, weights;
};
GaussRule gauss_rule(int points) {
  assert(points >= 2 && points <= 4);
  const auto both_sides = [](std::vector<std::pair<double, double>> positive) {
    GaussRule rule;
    for (const auto& [x, w] : positive) {
      for (const double side : {-1.0, 1.0}) {
        rule.abscissae.push_back(0.5 * (1 + side * x));
        rule.weights.push_back(0.5 * w);
      }
    }
    return rule;
  };
  if (points == 2) return both_sides({{std::sqrt(1.0 / 3), 1}});
  if (points == 3) {
    GaussRule rule = both_sides({{std::sqrt(3.0 / 5), 5.0 / 9}});
    rule.abscissae.push_back(0.5);
    rule.weights.push_back(4.0 / 9);
    return rule;
  }
  const double part = 2.0 / 7 * std::sqrt(6.0 / 5), root = std::sqrt(30.0);
  return both_sides({{std::sqrt(3.0 / 7 - part), (18 + root) / 36},
                     {std::sqrt(3.0 / 7 + part), (18 - root) / 36}});
}

// Returns the matrix that maps control points to the points of the curve at `parameters`.
Eigen::SparseMatrix<double> values_at(const SplineAxis& axis,
                                      const std::vector<double>& parameters) {
  const int count = axis.control_points();
  std::vector<Eigen::Triplet<double>> entries;  // added up where a short axis meets a point twice
  for (int row = 0; row < count; ++row) {
    const SplineBasis basis = axis.at(parameters[row]);
    for (int i = 0; i <= axis.degree(); ++i)
      entries.emplace_back(row, axis.control_point(basis.element, i), basis.value[i]);
  }
  Eigen::SparseMatrix<double> values(count, count);
  values.setFromTriplets(entries.begin(), entries.end());
  return values;
}

// The strain points at the start of an open axis. The points after them are at `next`, `next` + 1
// and so on, with weight 1.
struct EndRule {
  std::vector<QuadraturePoint> points;
  double next;
  int least_elements;  // least number of elements of an axis with this rule at both ends
};
// Returns the end rule for a degree. For degree 3 it is a hybrid Gauss-trapezoidal rule of order 6
// (Alpert 1999, SIAM J. Sci. Comput. 20). For degree 2 it is Gregory's rule of order 4, whose
// points are knots.
const EndRule& end_rule(int degree) {
  static const EndRule quadratic{{{0, 3.0 / 8}, {1, 7.0 / 6}, {2, 23.0 / 24}}, 3, 6};
  static const EndRule cubic{{{0.092043746485430549, 0.267358028130155544},
                              {0.612987968366781725, 0.756204019420385195},
                              {1.505657097358756584, 0.976437952449459259}},
                             2.5,
                             4};
  return degree == 2 ? quadratic : cubic;
}

// Largest number of control points of an open cubic axis whose curve passes through the image
// exactly. The image's points are evenly spaced, and near an end they leave the Greville abscissae
// by almost one element. The inverse of their matrix grows exponentially with the number of points:
// its norm is 41 for 17 points, and 5e9 for 129 (docs/decisions/0053).
constexpr int most_points_passed = 17;

// Number of image points between which the image is interpolated at a Greville abscissa.
constexpr int points_of_sample = 6;

// Returns the matrix that maps the image's points, at parameters `spacing` apart from 0 on, to the
// values at `parameters` of the polynomials through the nearest six of them.
Eigen::SparseMatrix<double> samples_of_image(const std::vector<double>& parameters,
                                             double spacing) {
  const int count = static_cast<int>(parameters.size());
  std::vector<Eigen::Triplet<double>> entries;
  for (int row = 0; row < count; ++row) {
    const double at = parameters[row] / spacing;
    const int first = std::clamp(static_cast<int>(std::floor(at)) - (points_of_sample / 2 - 1), 0,
                                 count - points_of_sample);
    for (int i = 0; i < points_of_sample; ++i) {
      double weight = 1;
      for (int j = 0; j < points_of_sample; ++j) {
        if (j != i) weight *= (at - first - j) / (i - j);
      }
      entries.emplace_back(row, first + i, weight);
    }
  }
  Eigen::SparseMatrix<double> samples(count, count);
  samples.setFromTriplets(entries.begin(), entries.end());
  return samples;
}

}  // namespace

SplineAxis::SplineAxis(int degree, int control_points, bool is_closed)
    : degree_(degree), control_points_(control_points), is_closed_(is_closed) {
  assert(degree >= 2 && degree <= highest_spline_degree);
  assert(control_points >= least_control_points(degree));
}

// Returns knot i of the knot vector. Basis function i of the axis has the knots i .. i + degree +
// 1.
double SplineAxis::knot(int i) const {
  return is_closed_ ? i - degree_ : std::clamp(i - degree_, 0, elements());
}

// The recursion of Cox and de Boor (The NURBS Book, Piegl and Tiller 1997, A2.2).
SplineBasis::Values SplineAxis::lower(int element, double parameter, int degree) const {
  const int span = element + degree_;  // index of the knot at the start of the element
  SplineBasis::Values values{1};
  for (int d = 1; d <= degree; ++d) {
    double saved = 0;
    for (int i = 0; i < d; ++i) {
      const double right = knot(span + i + 1) - parameter;
      const double left = parameter - knot(span + 1 - d + i);
      const double share = values[i] / (right + left);
      values[i] = saved + right * share;
      saved = left * share;
    }
    values[d] = saved;
  }
  return values;
}

SplineBasis SplineAxis::at(int element, double parameter) const {
  SplineBasis basis;
  basis.element = element;
  basis.value = lower(element, parameter, degree_);
  const int span = element + degree_;
  // The derivative of function i of degree d is
  //   d (low_(i-1) / (t_(i+d) - t_i) - low_i / (t_(i+d+1) - t_(i+1))),
  // where t are its knots, and `low` has the functions of degree d - 1. Terms with functions that
  // are not in `low` are zero.
  const auto differentiate = [&](const SplineBasis::Values& low, int d) {
    SplineBasis::Values slope{};
    for (int i = 0; i <= d; ++i) {
      const int first = span - d + i;  // index of the first knot of function i
      if (i > 0) slope[i] += d * low[i - 1] / (knot(first + d) - knot(first));
      if (i < d) slope[i] -= d * low[i] / (knot(first + d + 1) - knot(first + 1));
    }
    return slope;
  };
  basis.slope = differentiate(lower(element, parameter, degree_ - 1), degree_);
  basis.second =
      differentiate(differentiate(lower(element, parameter, degree_ - 2), degree_ - 1), degree_);
  return basis;
}

SplineBasis SplineAxis::at(double parameter) const {
  const int element = std::clamp(static_cast<int>(std::floor(parameter)), 0, elements() - 1);
  return at(element, parameter);
}

// The factors are p / (u_{i+p+1} - u_{i+1}) for the first derivative of degree p. For the second
// they are (p - 1) / (u_{i+p+1} - u_{i+2}) (Piegl and Tiller 1997, The NURBS Book, chapter 3).
SplineAxis::DifferenceFactors SplineAxis::difference_factors(int element) const {
  DifferenceFactors factors;
  for (int i = 0; i < degree_; ++i) {
    const double end = knot(element + i + degree_ + 1);
    factors.first[i] = degree_ / (end - knot(element + i + 1));
    if (i + 1 < degree_) factors.second[i] = (degree_ - 1) / (end - knot(element + i + 2));
  }
  return factors;
}

// On a closed axis, the points of the image are at the maxima of the basis functions.
double SplineAxis::image_parameter(int point) const {
  if (!is_closed_) return static_cast<double>(point) * elements() / (control_points_ - 1);
  const double centre = point - 0.5 * (degree_ - 1);
  return centre < 0 ? centre + elements() : centre;
}

Eigen::MatrixXd control_points_of(const SplineAxis& axis, const Eigen::MatrixXd& images) {
  using Factors = Eigen::SparseLU<Eigen::SparseMatrix<double>>;
  const auto parameters = [&](const auto& parameter) {
    std::vector<double> all;
    for (int i = 0; i < axis.control_points(); ++i) all.push_back(parameter(i));
    return all;
  };
  if (axis.passes_through_image()) {
    const Factors factors(
        values_at(axis, parameters([&](int i) { return axis.image_parameter(i); })));
    return factors.solve(images);
  }
  const std::vector<double> greville = parameters([&](int i) {
    double sum = 0;
    for (int k = 1; k <= axis.degree(); ++k)
      sum += std::clamp(i + k - axis.degree(), 0, axis.elements());  // a knot of an open axis
    return sum / axis.degree();
  });
  const Factors factors(values_at(axis, greville));
  return factors.solve(samples_of_image(greville, axis.image_parameter(1)) * images);
}

bool SplineAxis::passes_through_image() const {
  return is_closed_ || degree_ < 3 || control_points_ <= most_points_passed;
}

std::vector<QuadraturePoint> SplineAxis::gauss_points(int per_element) const {
  const GaussRule rule = gauss_rule(per_element);
  std::vector<QuadraturePoint> points;
  for (int e = 0; e < elements(); ++e) {
    for (std::size_t i = 0; i < rule.weights.size(); ++i)
      points.push_back({e + rule.abscissae[i], rule.weights[i]});
  }
  return points;
}

// Away from open ends, the strain points integrate smooth functions to any order. For degree 2, one
// point is at the end itself, because two points inside the first element would keep the element
// from bending. A point at the end does not restrain a clamped end, where the strain is zero
// anyway.
std::vector<QuadraturePoint> SplineAxis::strain_points() const {
  if (is_closed_) return points_of_elements(degree_ == 3 ? 0.5 : 0);
  const auto& [end, next, least_elements] = end_rule(degree_);
  if (elements() < least_elements) return greville_points(degree_ - 1);
  const auto length = static_cast<double>(elements());
  std::vector<QuadraturePoint> points = end;
  for (double x = next; x < length - next + 0.25; ++x) points.push_back({x, 1});
  for (std::size_t i = end.size(); i-- > 0;)
    points.push_back({length - end[i].parameter, end[i].weight});
  return points;
}

std::vector<QuadraturePoint> SplineAxis::joint_points() const {
  const bool is_short = !is_closed_ && elements() < end_rule(degree_).least_elements;
  return is_short ? greville_points(degree_) : strain_points();
}

// A single element needs one Gauss point more than `degree`. A spline that is zero at `degree`
// Gauss points would have no stiffness.
std::vector<QuadraturePoint> SplineAxis::value_points() const {
  if (is_closed_) return points_of_elements(degree_ == 3 ? 0 : 0.5);
  return gauss_points(elements() == 1 ? degree_ + 1 : degree_);
}

// A single cubic element needs three Gauss points. A spline whose second derivatives are zero at
// two Gauss points would have no stiffness.
std::vector<QuadraturePoint> SplineAxis::bending_points() const {
  return gauss_points(!is_closed_ && elements() == 1 ? degree_ : 2);
}

std::vector<QuadraturePoint> SplineAxis::points_of_elements(double offset) const {
  std::vector<QuadraturePoint> points;
  for (int e = 0; e < elements(); ++e) points.push_back({e + offset, 1});
  return points;
}

// Returns the Greville abscissae of the splines of the given degree on the same knots of an open
// axis. Their weights integrate the basis functions of these splines exactly.
std::vector<QuadraturePoint> SplineAxis::greville_points(int degree) const {
  const int count = elements() + degree;
  const auto knot = [&](int i) { return std::clamp(i - degree, 0, elements()); };
  Eigen::MatrixXd values = Eigen::MatrixXd::Zero(count, count);
  Eigen::VectorXd integrals(count);
  std::vector<QuadraturePoint> points(count);
  for (int i = 0; i < count; ++i) {
    double& at = points[i].parameter;
    for (int k = 1; k <= degree; ++k) at += static_cast<double>(knot(i + k)) / degree;
    const int element = std::min(static_cast<int>(at), elements() - 1);
    const SplineBasis::Values basis = lower(element, at, degree);
    for (int k = 0; k <= degree; ++k) values(element + k, i) += basis[k];
    integrals[i] = static_cast<double>(knot(i + degree + 1) - knot(i)) / (degree + 1);
  }
  const Eigen::VectorXd weights = values.fullPivLu().solve(integrals);
  for (int i = 0; i < count; ++i) points[i].weight = weights[i];
  return points;
}

}  // namespace weft::sim
