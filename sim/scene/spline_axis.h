// Uniform B-splines along one axis of an image of control points.
#pragma once

#include <array>
#include <vector>

namespace weft::sim {

inline constexpr int highest_spline_degree = 3;

// The basis functions that may be nonzero at a point, with their first and second derivatives by
// the parameter. Entries from degree + 1 on are zero. Function i of an element belongs to the
// control point SplineAxis::control_point(element, i).
struct SplineBasis {
  using Values = std::array<double, highest_spline_degree + 1>;
  int element = 0;
  Values value{}, slope{}, second{};
};

// A point of a quadrature rule along an axis. The weight is a length in the parameter.
struct QuadraturePoint {
  double parameter = 0, weight = 0;
};

// B-splines of degree 2 or 3 whose coefficients are a row of control points. Knots are at the
// integers 0 .. elements(). An open axis repeats its end knots, so that the curve starts at the
// first control point and ends at the last. A closed axis is periodic.
//
// An image of points on the surface has as many points per axis as there are control points. Its
// points have equal distances in the parameter. An image whose points have equal spacing thus gives
// a uniform parametrisation.
class SplineAxis {
 public:
  // Preconditions: the degree is 2 or 3, and control_points >= least_control_points(degree).
  SplineAxis(int degree, int control_points, bool is_closed);
  static int least_control_points(int degree) { return degree + 1; }

  int degree() const { return degree_; }
  int control_points() const { return control_points_; }
  int elements() const { return is_closed_ ? control_points_ : control_points_ - degree_; }
  int control_point(int element, int i) const { return (element + i) % control_points_; }

  // Returns the basis functions at a parameter in [0, elements()]. An inner knot belongs to the
  // element that starts at it.
  SplineBasis at(double parameter) const;
  // Returns the basis functions of an element at a parameter within the element or at its ends.
  SplineBasis at(int element, double parameter) const;

  // Factors for control points of derivatives. The differences of neighbouring control points in an
  // element, times `first`, are the control points of the first derivative. The differences of
  // these, times `second`, are the control points of the second derivative.
  struct DifferenceFactors {
    std::array<double, highest_spline_degree> first{}, second{};
  };
  DifferenceFactors difference_factors(int element) const;

  // Returns the parameter of the image's point with the index `point`.
  double image_parameter(int point) const;
  // True if the curve of control_points_of() (spline_interpolation.h) passes through all points of
  // the image. On long open axes of degree 3, the curve through evenly spaced points would amplify
  // their rounding errors exponentially.
  bool passes_through_image() const;

  // Returns the Gauss-Legendre points with `per_element` points per element (2 to 4).
  std::vector<QuadraturePoint> gauss_points(int per_element) const;
  // Returns the points at which strains along the axis are integrated. Thin shells bend without
  // stretching only if these points are few. There is about one per element, where the slope of the
  // spline's shortest wave is largest. On closed axes the rule integrates smooth functions to any
  // order. On open axes it has order 6 for degree 3 and order 4 for degree 2. On short open axes
  // the order is lower: at least 3 for degree 3 (fewer than four elements), at least 2 for degree 2
  // (fewer than six elements).
  std::vector<QuadraturePoint> strain_points() const;
  // Returns the points at which joints along the axis are integrated: the strain points, and on
  // short open axes as many points as there are control points. Strain points are one fewer. A
  // spline that is zero at all of them, as the angle of a joint may be, has a mean of up to a third
  // of its largest coefficient on a short axis, where nothing else keeps it from growing.
  std::vector<QuadraturePoint> joint_points() const;
  // Returns the points at which strains across the axis are integrated. A spline that is zero at
  // all of them is zero everywhere. An open axis has `degree` Gauss points per element, or one more
  // if it has a single element. A closed axis has one point per element, where the value of the
  // spline's shortest wave is largest.
  std::vector<QuadraturePoint> value_points() const;
  // Returns the points at which bending is integrated: two Gauss points per element, or `degree`
  // Gauss points on an open axis with a single element.
  std::vector<QuadraturePoint> bending_points() const;

 private:
  std::vector<QuadraturePoint> points_of_elements(double offset) const;
  double knot(int i) const;
  std::vector<QuadraturePoint> greville_points(int degree) const;
  // Returns the values, on an element, of the degree + 1 basis functions of the given degree, which
  // may be lower than degree_.
  SplineBasis::Values lower(int element, double parameter, int degree) const;

  int degree_, control_points_;
  bool is_closed_;
};

}  // namespace weft::sim
