#include "sim/sweep/sample_points.h"

#include <algorithm>
#include <boost/random/sobol.hpp>
#include <numeric>
#include <random>
#include <utility>

namespace weft::sim {

namespace {

// The C++ standard fixes the numbers of this engine, but not those of its distributions.
using Engine = std::mt19937_64;

// Returns the upper 53 bits of `bits` as a fraction of one.
double fraction(std::uint64_t bits) { return static_cast<double>(bits >> 11U) * 0x1p-53; }

// Returns a whole number below `bound`. The numbers that would make some results more probable than
// others are drawn again.
std::uint64_t below(std::uint64_t bound, Engine& engine) {
  const std::uint64_t rejected = (0 - bound) % bound;  // 2^64 modulo bound
  std::uint64_t bits = engine();
  while (bits < rejected) bits = engine();
  return bits % bound;
}

std::vector<UnitPoint> origins(std::size_t count, std::size_t dimensions) {
  return std::vector<UnitPoint>(count, UnitPoint(dimensions, 0.0));
}

}  // namespace

std::vector<UnitPoint> random_points(std::size_t count, std::size_t dimensions,
                                     std::uint64_t seed) {
  Engine engine(seed);
  std::vector<UnitPoint> points = origins(count, dimensions);
  for (UnitPoint& point : points) {
    for (double& coordinate : point) coordinate = fraction(engine());
  }
  return points;
}

std::vector<UnitPoint> latin_hypercube_points(std::size_t count, std::size_t dimensions,
                                              std::uint64_t seed) {
  Engine engine(seed);
  std::vector<UnitPoint> points = origins(count, dimensions);
  std::vector<std::size_t> interval(count);
  for (std::size_t d = 0; d < dimensions; ++d) {
    std::iota(interval.begin(), interval.end(), std::size_t{0});
    for (std::size_t i = count; i > 1; --i) std::swap(interval[i - 1], interval[below(i, engine)]);
    for (std::size_t i = 0; i < count; ++i) {
      const double place = static_cast<double>(interval[i]) + fraction(engine());
      points[i][d] = std::min(place / static_cast<double>(count), 1 - 0x1p-53);
    }
  }
  return points;
}

std::vector<UnitPoint> sobol_points(std::size_t count, std::size_t dimensions, std::uint64_t seed) {
  std::vector<std::uint64_t> shift(dimensions, 0);
  Engine engine(seed);
  if (seed != 0) {
    for (std::uint64_t& bits : shift) bits = engine();
  }
  std::vector<UnitPoint> points = origins(count, dimensions);
  boost::random::sobol sequence(dimensions);  // begins with the point after the origin
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t d = 0; d < dimensions; ++d) {
      const std::uint64_t bits = i == 0 ? 0 : sequence();
      points[i][d] = fraction(bits ^ shift[d]);
    }
  }
  return points;
}

}  // namespace weft::sim
