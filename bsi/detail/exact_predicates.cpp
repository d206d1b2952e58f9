// This file is compiled without contraction of a * b + c into one rounding (see CMakeLists.txt),
// because the sums below must round as written.
#include "bsi/detail/exact_predicates.h"

#include <cmath>

namespace weft::bsi {

namespace {

// Unit roundoff of float64.
constexpr double unit = 1.1102230246251565e-16;
// Error bounds of the determinants, relative to the sum of the magnitudes of their products.
// Shewchuk's bounds are 3 and 7 units; one more unit covers the rounding of the bound itself.
constexpr double plane_bound = 4 * unit, space_bound = 8 * unit;

// The rounded result of an operation and its rounding error. The sum of both is exact.
struct Exact {
  double rounded = 0, lost = 0;
};

Exact exact_sum(double a, double b) {
  const double sum = a + b;
  const double b_in_sum = sum - a;
  return {sum, (a - (sum - b_in_sum)) + (b - b_in_sum)};
}

Exact exact_difference(double a, double b) { return exact_sum(a, -b); }

Exact exact_product(double a, double b) {
  const double product = a * b;
  return {product, std::fma(a, b, -product)};
}

// An exact sum of doubles, stored as terms that do not overlap, smallest first, without zeros. The
// largest term exceeds the sum of all others in magnitude, so its sign is the sign of the whole
// sum.
class Expansion {
 public:
  // Adds a number by Shewchuk's GROW-EXPANSION.
  void add(double value) {
    int kept = 0;
    for (int i = 0; i < count_; ++i) {
      const Exact sum = exact_sum(value, term_[i]);
      if (sum.lost != 0) term_[kept++] = sum.lost;
      value = sum.rounded;
    }
    if (value != 0) term_[kept++] = value;
    count_ = kept;
  }

  void add_product(double a, double b) {
    const Exact product = exact_product(a, b);
    add(product.lost);
    add(product.rounded);
  }

  void add_product(const Exact& a, const Exact& b) {
    for (const double a_part : {a.lost, a.rounded})
      for (const double b_part : {b.lost, b.rounded})
        if (a_part != 0 && b_part != 0) add_product(a_part, b_part);
  }

  void add_product(const Exact& a, const Exact& b, const Exact& c) {
    for (const double a_part : {a.lost, a.rounded}) {
      for (const double b_part : {b.lost, b.rounded}) {
        if (a_part == 0 || b_part == 0) continue;
        const Exact product = exact_product(a_part, b_part);
        add_product(product, c);
      }
    }
  }

  int sign() const {
    if (count_ == 0) return 0;
    return term_[count_ - 1] > 0 ? 1 : -1;
  }

 private:
  // A determinant has six products of three differences. Each product expands into 2 x 2 x 2
  // products of three doubles, each of up to 4 terms.
  static constexpr int most_terms = 6 * 8 * 4;
  std::array<double, most_terms> term_;
  int count_ = 0;
};

Exact negated(const Exact& value) { return {-value.rounded, -value.lost}; }

int orientation_by_expansion(const Point2& a, const Point2& b, const Point2& c) {
  std::array<Exact, 2> ac, bc;
  for (int axis = 0; axis < 2; ++axis) {
    ac[axis] = exact_difference(a[axis], c[axis]);
    bc[axis] = exact_difference(b[axis], c[axis]);
  }
  Expansion determinant;
  determinant.add_product(ac[0], bc[1]);
  determinant.add_product(negated(ac[1]), bc[0]);
  return determinant.sign();
}

int orientation_by_expansion(const Point3& a, const Point3& b, const Point3& c, const Point3& d) {
  std::array<Exact, 3> ad, bd, cd;
  for (int axis = 0; axis < 3; ++axis) {
    ad[axis] = exact_difference(a[axis], d[axis]);
    bd[axis] = exact_difference(b[axis], d[axis]);
    cd[axis] = exact_difference(c[axis], d[axis]);
  }
  Expansion determinant;
  for (int x = 0; x < 3; ++x) {
    const int y = (x + 1) % 3, z = (x + 2) % 3;
    determinant.add_product(ad[x], bd[y], cd[z]);
    determinant.add_product(negated(ad[x]), bd[z], cd[y]);
  }
  return determinant.sign();
}

// Returns true if the sign of the rounded determinant is certain. An error bound of zero means that
// every product in the determinant has a factor of exactly zero, for example if all points share a
// coordinate.
bool is_decided(double determinant, double error_bound) {
  return std::abs(determinant) > error_bound || error_bound == 0;
}

int sign(double value) { return (value > 0) - (value < 0); }

}  // namespace

int orientation(const Point2& a, const Point2& b, const Point2& c) {
  const double left = (a[0] - c[0]) * (b[1] - c[1]);
  const double right = (a[1] - c[1]) * (b[0] - c[0]);
  const double determinant = left - right;
  const double error_bound = plane_bound * (std::abs(left) + std::abs(right));
  if (is_decided(determinant, error_bound)) return sign(determinant);
  return orientation_by_expansion(a, b, c);
}

int orientation(const Point3& a, const Point3& b, const Point3& c, const Point3& d) {
  const double ax = a[0] - d[0], ay = a[1] - d[1], az = a[2] - d[2];
  const double bx = b[0] - d[0], by = b[1] - d[1], bz = b[2] - d[2];
  const double cx = c[0] - d[0], cy = c[1] - d[1], cz = c[2] - d[2];
  const double bc = bx * cy, cb = cx * by, ca = cx * ay, ac = ax * cy, ab = ax * by, ba = bx * ay;
  const double determinant = az * (bc - cb) + bz * (ca - ac) + cz * (ab - ba);
  const double permanent = std::abs(az) * (std::abs(bc) + std::abs(cb)) +
                           std::abs(bz) * (std::abs(ca) + std::abs(ac)) +
                           std::abs(cz) * (std::abs(ab) + std::abs(ba));
  const double error_bound = space_bound * permanent;
  if (is_decided(determinant, error_bound)) return sign(determinant);
  return orientation_by_expansion(a, b, c, d);
}

}  // namespace weft::bsi
