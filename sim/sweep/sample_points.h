// Points of the unit cube at which a sweep samples its factors.
//
// All numbers are made of whole ones by steps that are exact in floating point, so they are the
// same on every machine.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace weft::sim {

// A point has one coordinate in [0, 1) per factor.
using UnitPoint = std::vector<double>;

// Returns independent uniform points (Mersenne Twister, 64 bits).
std::vector<UnitPoint> random_points(std::size_t count, std::size_t dimensions, std::uint64_t seed);

// Returns a Latin hypercube: each of `count` equal intervals of each coordinate holds one point, at
// a random place in the interval.
std::vector<UnitPoint> latin_hypercube_points(std::size_t count, std::size_t dimensions,
                                              std::uint64_t seed);

// Returns the first points of the Sobol sequence with the direction numbers of Joe and Kuo
// ("Constructing Sobol sequences with better two-dimensional projections", SIAM J. Sci. Comput. 30,
// 2008), beginning with the origin. A seed other than 0 shifts all points by one random number per
// coordinate, bit by bit (exclusive or), which keeps their uniformity. Precondition: dimensions <=
// most_sobol_dimensions.
std::vector<UnitPoint> sobol_points(std::size_t count, std::size_t dimensions, std::uint64_t seed);
inline constexpr std::size_t most_sobol_dimensions = 1000;

}  // namespace weft::sim
