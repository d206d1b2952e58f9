// Uniform B-splines along one axis of an image of control points.
#pragma once

#include <array>
#include <vector>

namespace weft::sim {

inline constexpr int highest_spline_degree = 3;

// The basis functions that may be other than zero at a point, with their first and second
// derivatives by the parameter. Entries from degree + 1 on are zero. Function i of an element
// belongs to the control point SplineAxis::control_point(element, i).
struct SplineBasis {
  using Values = std::array<double, highest_spline_degree + 1>;
  int element = 0;
  Values value{}, slope{}, second{};
};

// A point of a quadrature rule with its weight, in the parameter.
struct QuadraturePoint {
  double parameter = 0, weight = 0;
};

// A row of control points as the coefficients of B-splines of degree 2 or 3. Knots are at 0, 1 ..
// elements(). An open axis repeats its end knots, so that the curve starts at the first control
// point and ends at the last. A closed axis is periodic.
//
// An image of points on the surface has as many points per axis as there are control points. Its
// points have equal distances in the parameter. An image of equal spacing thus gives a surface of
// uniform parametrisation.
class SplineAxis {
 public:
  // Preconditions: degree 2 or 3, and at least least_control_points(degree) control points.
  SplineAxis(int degree, int control_points, bool is_closed);
  static int least_control_points(int degree) { return degree + 1; }

  int degree() const { return degree_; }
  int control_points() const { return control_points_; }
  int elements() const { return is_closed_ ? control_points_ : control_points_ - degree_; }
  int control_point(int element, int i) const { return (element + i) % control_points_; }

  // Returns the functions at a parameter in [0, elements()]. An inner knot belongs to the element
  // that starts at it.
  SplineBasis at(double parameter) const;
  // Returns the functions of an element at a parameter within the element or at its ends.
  SplineBasis at(int element, double parameter) const;

  // Factors that turn differences of control points into control points of derivatives. Differences
  // of neighbours in an element times `first` are the control points of the derivative. Differences
  // of the latter times `second` are those of the second derivative.
  struct DifferenceFactors {
    std::array<double, highest_spline_degree> first{}, second{};
  };
  DifferenceFactors difference_factors(int element) const;

  // Returns the parameter of point number `point` of the image.
  double image_parameter(int point) const;
  // Returns the matrix from the image's points to the control points of the curve through them, row
  // by row. Row i has the weights of the points in control point i. O(points^3).
  std::vector<double> interpolation() const;

  // Returns the Gauss-Legendre points, 2 to 4 per element.
  std::vector<QuadraturePoint> gauss_points(int per_element) const;
  // Returns the points at which strains along the axis are integrated. Thin shells need them to be
  // few, to bend without stretching: there is about one per element, where the slope of the
  // spline's shortest wave is largest. The rule has order 6 for degree 3 and order 4 for degree 2.
  // On short open axes the order is lower: at least 3 for degree 3 (fewer than four elements), at
  // least 2 for degree 2 (fewer than six).
  std::vector<QuadraturePoint> strain_points() const;
  // Returns the points at which strains across the axis are integrated. They suffice for all values
  // of the spline: `degree` Gauss points per element of an open axis, one more if it has a single
  // element. A closed axis has one per element, where the value of the spline's shortest wave is
  // largest.
  std::vector<QuadraturePoint> value_points() const;
  // Returns the points at which bending is integrated: two Gauss points per element, or `degree` on
  // an open axis of a single element.
  std::vector<QuadraturePoint> bending_points() const;

 private:
  std::vector<QuadraturePoint> points_of_elements(double offset) const;
  double knot(int i) const;
  std::vector<QuadraturePoint> greville_points_below() const;
  // Returns the values of the degree + 1 basis functions of a lower degree on an element.
  SplineBasis::Values lower(int element, double parameter, int degree) const;

  int degree_, control_points_;
  bool is_closed_;
};

}  // namespace weft::sim
