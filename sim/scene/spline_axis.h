// Uniform B-splines along one axis of an image of control points.
#pragma once

#include <array>
#include <vector>

namespace weft::sim {

inline constexpr int highest_spline_degree = 3;

// The basis functions that are not zero at a point, with their first and second derivatives by the
// parameter. Entries from degree + 1 on are zero. Function i of an element belongs to the control
// point SplineAxis::control_point(element, i).
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
// elements(). An open axis repeats its end knots: its ends interpolate the first and the last
// control point. A closed axis is periodic.
//
// An image of points on the surface has as many points per axis as there are control points. Its
// points lie at equal distances in the parameter, so that an image of equal spacing gives a surface
// of uniform parametrisation.
class SplineAxis {
 public:
  // Precondition: degree 2 or 3, and at least least_control_points(degree).
  SplineAxis(int degree, int control_points, bool is_closed);
  static int least_control_points(int degree) { return degree + 1; }

  int degree() const { return degree_; }
  int control_points() const { return control_points_; }
  int elements() const { return is_closed_ ? control_points_ : control_points_ - degree_; }
  int control_point(int element, int i) const { return (element + i) % control_points_; }

  // The functions at a parameter in [0, elements()]. At a knot those of the element behind it; the
  // functions of an element that has no part in the value there are zero.
  SplineBasis at(double parameter) const;
  // The functions at a parameter within an element or at its ends.
  SplineBasis at(int element, double parameter) const;

  // Factors of differences of the control points of an element. Differences of neighbours times
  // `first` are control points of the derivative; differences of these times `second` are those of
  // the second derivative.
  struct DifferenceFactors {
    std::array<double, highest_spline_degree> first{}, second{};
  };
  DifferenceFactors difference_factors(int element) const;

  // The parameter of an image's points, by number.
  double image_parameter(int point) const;
  // Returns the control points whose curve passes through the image's points, as a matrix: row i
  // has the weights of the points in control point i. O(points^3), once for each length.
  std::vector<double> interpolation() const;

  // Gauss-Legendre points, 2 to 4 per element.
  std::vector<QuadraturePoint> gauss_points(int per_element) const;
  // Points at which strains along the axis are integrated: about one per element, so that thin
  // shells are free to bend without stretching. There the slope of the spline's shortest wave is
  // largest. Order 6 for degree 3, order 4 for degree 2; at least 3 on open axes of fewer than four
  // elements of degree 3, and 2 on those of fewer than six of degree 2.
  std::vector<QuadraturePoint> strain_points() const;
  // Points at which strains across the axis are integrated, enough for all values of the spline:
  // `degree` Gauss points per element of an open axis, one more if it is a single element. A closed
  // axis has one per element, where the value of the spline's shortest wave is largest.
  std::vector<QuadraturePoint> value_points() const;
  // Points at which bending is integrated: two Gauss points per element, `degree` on an open axis
  // of a single element.
  std::vector<QuadraturePoint> bending_points() const;

 private:
  std::vector<QuadraturePoint> points_of_elements(double offset) const;
  double knot(int i) const;
  std::vector<QuadraturePoint> greville_points_below() const;
  // Values of the degree + 1 functions of a lower degree on an element.
  SplineBasis::Values lower(int element, double parameter, int degree) const;

  int degree_, control_points_;
  bool is_closed_;
};

}  // namespace weft::sim
