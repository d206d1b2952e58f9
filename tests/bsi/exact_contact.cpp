#include "tests/bsi/exact_contact.h"

#include <algorithm>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

namespace weft::bsi {

namespace exact_contact {
namespace {

using Integer = boost::multiprecision::cpp_int;

// Coefficients, the constant one first. The last one is not 0; the zero polynomial has none.
using Polynomial = std::vector<Integer>;
using Polynomial3 = std::array<Polynomial, 3>;

int sign_of(const Integer& value) { return value.sign(); }

Polynomial trimmed(Polynomial p) {
  while (!p.empty() && p.back() == 0) p.pop_back();
  return p;
}

Polynomial operator+(const Polynomial& p, const Polynomial& q) {
  Polynomial sum(std::max(p.size(), q.size()));
  for (std::size_t i = 0; i < p.size(); ++i) sum[i] += p[i];
  for (std::size_t i = 0; i < q.size(); ++i) sum[i] += q[i];
  return trimmed(std::move(sum));
}

Polynomial operator-(const Polynomial& p, const Polynomial& q) {
  Polynomial difference(std::max(p.size(), q.size()));
  for (std::size_t i = 0; i < p.size(); ++i) difference[i] += p[i];
  for (std::size_t i = 0; i < q.size(); ++i) difference[i] -= q[i];
  return trimmed(std::move(difference));
}

Polynomial operator*(const Polynomial& p, const Polynomial& q) {
  if (p.empty() || q.empty()) return {};
  Polynomial product(p.size() + q.size() - 1);
  for (std::size_t i = 0; i < p.size(); ++i)
    for (std::size_t j = 0; j < q.size(); ++j) product[i + j] += p[i] * q[j];
  return product;
}

Polynomial3 operator-(const Polynomial3& p, const Polynomial3& q) {
  return {p[0] - q[0], p[1] - q[1], p[2] - q[2]};
}

Polynomial3 cross(const Polynomial3& p, const Polynomial3& q) {
  return {p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]};
}

Polynomial dot(const Polynomial3& p, const Polynomial3& q) {
  return p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
}

// Divides by the greatest common divisor of the coefficients.
Polynomial reduced(Polynomial p) {
  Integer divisor = 0;
  for (const Integer& c : p) divisor = boost::multiprecision::gcd(divisor, c);
  if (divisor > 1)
    for (Integer& c : p) c /= divisor;
  return p;
}

Polynomial derivative(const Polynomial& p) {
  Polynomial result;
  for (std::size_t i = 1; i < p.size(); ++i) result.push_back(p[i] * i);
  return result;
}

// Quotient and remainder of a positive multiple of p by q.
struct Division {
  Polynomial quotient, remainder;
};

Division divide(Polynomial p, const Polynomial& q) {
  Polynomial quotient(p.size() < q.size() ? 0 : p.size() - q.size() + 1);
  const Integer lead = boost::multiprecision::abs(q.back());
  const int sign = sign_of(q.back());
  while (p.size() >= q.size()) {
    const std::size_t shift = p.size() - q.size();
    const Integer factor = sign * p.back();
    for (Integer& c : p) c *= lead;
    for (Integer& c : quotient) c *= lead;
    quotient[shift] += factor;
    for (std::size_t i = 0; i < q.size(); ++i) p[i + shift] -= factor * q[i];
    p = trimmed(std::move(p));
  }
  return {trimmed(std::move(quotient)), std::move(p)};
}

Polynomial common_divisor(Polynomial p, Polynomial q) {
  while (!q.empty()) {
    Polynomial rest = reduced(divide(std::move(p), q).remainder);
    p = std::move(q);
    q = std::move(rest);
  }
  return reduced(std::move(p));
}

// Returns a polynomial with the same roots, each of them once. Precondition: p is not zero.
Polynomial without_multiple_roots(const Polynomial& p) {
  const Polynomial divisor = common_divisor(p, derivative(p));
  return divisor.size() < 2 ? reduced(p) : reduced(divide(p, divisor).quotient);
}

// The time numerator / 2^exponent.
struct Dyadic {
  Integer numerator;
  int exponent = 0;
};

bool operator<(const Dyadic& a, const Dyadic& b) {
  return (a.numerator << b.exponent) < (b.numerator << a.exponent);
}

Dyadic middle_of(const Dyadic& a, const Dyadic& b) {
  return {(a.numerator << b.exponent) + (b.numerator << a.exponent), a.exponent + b.exponent + 1};
}

Dyadic shortened(Dyadic time) {
  while (time.exponent > 0 && !boost::multiprecision::bit_test(time.numerator, 0)) {
    time.numerator >>= 1;
    --time.exponent;
  }
  return time;
}

int sign_at(const Polynomial& p, const Dyadic& time) {
  Integer value = 0;
  int shift = 0;
  for (std::size_t i = p.size(); i-- > 0;) {
    value = value * time.numerator + (p[i] << shift);
    shift += time.exponent;
  }
  return sign_of(value);
}

// The roots of a polynomial without multiple roots, counted by Sturm's theorem.
class Roots {
 public:
  explicit Roots(Polynomial p) {
    Polynomial next = derivative(p);
    chain_.push_back(std::move(p));
    while (!next.empty()) {
      chain_.push_back(reduced(std::move(next)));
      next = divide(chain_[chain_.size() - 2], chain_.back()).remainder;
      for (Integer& c : next) c = -c;
    }
  }
  const Polynomial& polynomial() const { return chain_.front(); }
  // Returns the number of roots in (low, high].
  int count(const Dyadic& low, const Dyadic& high) const { return changes(low) - changes(high); }

 private:
  int changes(const Dyadic& time) const {
    int count = 0, last = 0;
    for (const Polynomial& p : chain_) {
      const int sign = sign_at(p, time);
      if (sign == 0) continue;
      count += last != 0 && sign != last;
      last = sign;
    }
    return count;
  }
  std::vector<Polynomial> chain_;
};

// A root: the only one in (low, high].
struct Root {
  const Roots* all = nullptr;
  Dyadic low, high;

  void halve() {
    Dyadic middle = shortened(middle_of(low, high));
    if (all->count(low, middle) == 1) {
      high = std::move(middle);
    } else {
      low = std::move(middle);
    }
  }
};

// Appends the roots in (low, high], in order.
void isolate(const Roots& all, const Dyadic& low, const Dyadic& high, std::vector<Root>& found) {
  const int count = all.count(low, high);
  if (count == 1) found.push_back({&all, low, high});
  if (count < 2) return;
  const Dyadic middle = shortened(middle_of(low, high));
  isolate(all, low, middle, found);
  isolate(all, middle, high, found);
}

// Returns the sign of a polynomial of degree 4 or less in [low, high] if its Bernstein coefficients
// there show that it has one, else 0.
int constant_sign(const Polynomial& p, const Dyadic& low, const Dyadic& high) {
  const Integer from = low.numerator << high.exponent, to = high.numerator << low.exponent;
  const int exponent = low.exponent + high.exponent;
  const Polynomial time{from, to - from};  // times 2^exponent, at the part s of the interval
  Polynomial q;
  int shift = 0;
  for (std::size_t i = p.size(); i-- > 0;) {
    q = q * time + trimmed({p[i] << shift});
    shift += exponent;
  }
  constexpr int choices[5][5] = {
      {1, 0, 0, 0, 0}, {1, 1, 0, 0, 0}, {1, 2, 1, 0, 0}, {1, 3, 3, 1, 0}, {1, 4, 6, 4, 1}};
  const std::size_t degree = p.size() - 1;
  int sign = 0;
  for (std::size_t j = 0; j <= degree; ++j) {
    Integer coefficient = 0;
    for (std::size_t i = 0; i <= std::min(j, q.size() - 1); ++i)
      coefficient += choices[j][i] * (12 / choices[degree][i]) * q[i];
    if (sign_of(coefficient) == 0 || (j > 0 && sign_of(coefficient) != sign)) return 0;
    sign = sign_of(coefficient);
  }
  return sign;
}

int sign_at(const Polynomial& p, Root root) {
  constexpr int quick_halvings = 24;
  if (p.empty()) return 0;
  for (int i = 0; i < quick_halvings; ++i) {
    if (const int sign = constant_sign(p, root.low, root.high); sign != 0) return sign;
    root.halve();
  }
  const Roots common(common_divisor(root.all->polynomial(), p));
  if (common.count(root.low, root.high) > 0) return 0;
  const Roots own(without_multiple_roots(p));
  while (own.count(root.low, root.high) > 0) root.halve();
  return sign_at(p, root.high);
}

// Conditions on the time that hold together.
struct Conditions {
  std::vector<Polynomial> zero{}, not_negative{}, positive{};

  bool hold_at(const auto& time) const {
    return std::ranges::all_of(zero, [&](const auto& p) { return sign_at(p, time) == 0; }) &&
           std::ranges::all_of(not_negative,
                               [&](const auto& p) { return sign_at(p, time) >= 0; }) &&
           std::ranges::all_of(positive, [&](const auto& p) { return sign_at(p, time) > 0; });
  }
};

const Dyadic path_start{0, 0}, path_end{1, 0};

bool hold_at_a_root(const Conditions& conditions, const Polynomial& p) {
  const Roots roots(without_multiple_roots(p));
  std::vector<Root> found;
  isolate(roots, path_start, path_end, found);
  return std::ranges::any_of(found, [&](const Root& root) { return conditions.hold_at(root); });
}

// True if the inequalities hold at some time in (0, 1]. They are tried at their roots and at a time
// before each of these; the ends of the path are tried elsewhere.
bool hold_between_roots(const Conditions& conditions) {
  Polynomial product{1};
  for (const auto* list : {&conditions.not_negative, &conditions.positive})
    for (const Polynomial& p : *list)
      if (!p.empty()) product = product * p;
  const Roots roots(without_multiple_roots(product));
  std::vector<Root> found;
  isolate(roots, path_start, path_end, found);
  for (std::size_t i = 1; i < found.size(); ++i) {
    while (!(found[i - 1].high < found[i].low)) {
      found[i - 1].halve();
      found[i].halve();
    }
  }
  return std::ranges::any_of(found, [&](const Root& root) {
    return conditions.hold_at(root) || conditions.hold_at(root.low);
  });
}

// True if all conditions hold at some time in [0, 1].
bool hold_somewhere(const Conditions& conditions) {
  if (conditions.hold_at(path_start) || conditions.hold_at(path_end)) return true;
  const Polynomial* equation = nullptr;
  for (const Polynomial& p : conditions.zero)
    if (!p.empty() && (equation == nullptr || p.size() < equation->size())) equation = &p;
  return equation != nullptr ? hold_at_a_root(conditions, *equation)
                             : hold_between_roots(conditions);
}

// True if the vertex a meets the segment from b to c.
bool meets_segment(const Polynomial3& a, const Polynomial3& b, const Polynomial3& c) {
  const Polynomial3 to_b = b - a, to_c = c - a, normal = cross(to_b, to_c);
  return hold_somewhere({.zero = {normal[0], normal[1], normal[2]},
                         .not_negative = {Polynomial{} - dot(to_b, to_c)}});
}

// True if a cubic polynomial certainly has no root in [0, 1]: its Bernstein coefficients have one
// sign.
bool keeps_its_sign(const Polynomial& p) {
  const auto c = [&](std::size_t i) { return i < p.size() ? p[i] : Integer(0); };
  const int sign = sign_of(c(0));
  return sign != 0 && sign_of(3 * c(0) + c(1)) == sign &&
         sign_of(3 * c(0) + 2 * c(1) + c(2)) == sign && sign_of(c(0) + c(1) + c(2) + c(3)) == sign;
}

bool vertex_meets_triangle(std::span<const Polynomial3, 4> x) {
  const Polynomial3 normal = cross(x[2] - x[1], x[3] - x[1]);
  const Polynomial height = dot(normal, x[0] - x[1]);
  if (keeps_its_sign(height)) return false;
  const auto inside = [&](int from, int to) {
    return dot(normal, cross(x[to] - x[from], x[0] - x[from]));
  };
  return hold_somewhere({.zero = {height},
                         .not_negative = {inside(1, 2), inside(2, 3), inside(3, 1)},
                         .positive = {dot(normal, normal)}}) ||
         meets_segment(x[0], x[1], x[2]) || meets_segment(x[0], x[2], x[3]) ||
         meets_segment(x[0], x[3], x[1]);
}

bool edges_meet(std::span<const Polynomial3, 4> x) {
  const Polynomial3 first = x[1] - x[0], second = x[3] - x[2], between = x[2] - x[0];
  const Polynomial3 normal = cross(first, second);
  const Polynomial height = dot(normal, between);
  if (keeps_its_sign(height)) return false;
  const Polynomial square = dot(normal, normal);
  const Polynomial s = dot(normal, cross(between, second));
  const Polynomial t = dot(normal, cross(between, first));
  return hold_somewhere({.zero = {height},
                         .not_negative = {s, square - s, t, square - t},
                         .positive = {square}}) ||
         meets_segment(x[0], x[2], x[3]) || meets_segment(x[1], x[2], x[3]) ||
         meets_segment(x[2], x[0], x[1]) || meets_segment(x[3], x[0], x[1]);
}

// The number value * 2^-exponent, without rounding. Precondition: it is an integer.
Integer integer_of(double value, int exponent) {
  int own = 0;
  const double mantissa = std::frexp(value, &own);
  const Integer whole = static_cast<std::int64_t>(std::ldexp(mantissa, 53));
  const int shift = own - 53 - exponent;
  if (shift >= 0) return whole << shift;
  return sign_of(whole) < 0 ? Integer(-(Integer(-whole) >> -shift)) : Integer(whole >> -shift);
}

// The exponent of the lowest bit of any of the numbers.
int lowest_exponent(std::span<const double> values) {
  int lowest = std::numeric_limits<int>::max();
  for (const double value : values) {
    int own = 0;
    if (std::frexp(value, &own) != 0) lowest = std::min(lowest, own - 53);
  }
  return lowest == std::numeric_limits<int>::max() ? 0 : lowest;
}

}  // namespace
}  // namespace exact_contact

bool features_meet(FeatureKind kind, const FourPoints& start, const FourPoints& end, double until) {
  using namespace exact_contact;
  std::vector<double> values;
  for (int i = 0; i < 4; ++i)
    for (int k = 0; k < 3; ++k) values.insert(values.end(), {start[i][k], end[i][k]});
  const int exponent = lowest_exponent(values), until_exponent = lowest_exponent({&until, 1});
  // until = part / 2^halvings
  Dyadic part{integer_of(until, until_exponent), -until_exponent};
  part = shortened(std::move(part));
  // All coordinates are multiplied by 2^(halvings - exponent).
  std::array<Polynomial3, 4> x;
  for (int i = 0; i < 4; ++i) {
    for (int k = 0; k < 3; ++k) {
      const Integer from = integer_of(start[i][k], exponent), to = integer_of(end[i][k], exponent);
      x[i][k] = trimmed({from << part.exponent, (to - from) * part.numerator});
    }
  }
  return kind == FeatureKind::vertex_triangle ? vertex_meets_triangle(x) : edges_meet(x);
}

}  // namespace weft::bsi
