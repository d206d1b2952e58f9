// The interface of a library that simulates point masses joined by springs, for benchmarks.
//
// Each library is a program of its own, weft-bench-NAME, which reads settings and a problem from
// standard input and writes the outcome. What it links never meets another build of the same
// library: Bullet's pairs are found in float32, its cloth moves in float64. A library that crashes
// costs one row of a table.
#pragma once

#include <array>
#include <iosfwd>
#include <string>
#include <vector>

namespace weft::bench {

struct ClothSpring {
  std::array<int, 2> ends{};
  double rest_length = 0;  // L, m
  double stiffness = 0;    // k, N/m: W = k/2 (l - L)^2
};

// Springs without damping between point masses under gravity, and nothing else: no air, no contact.
struct ClothProblem {
  std::array<double, 3> gravity{};                        // m/s^2
  std::vector<std::array<double, 3>> position, velocity;  // at the start, m, m/s
  std::vector<double> mass;                               // kg; 0: held where it is
  std::vector<ClothSpring> springs;
};

struct ClothSettings {
  std::string method;  // one word, of those of the library
  double step = 0;     // s
  long steps = 0;
  int iterations = 1;        // of a step, in the method's own sense
  double tolerance = 0;      // of its linear solver, in its own sense; 0: the library's
  bool line_search = false;  // of Newton's method
  double budget = 0;         // s of CPU time, at which it gives up
};

struct ClothOutcome {
  std::string failure;                          // empty: reached the end
  double cpu = 0;                               // s, without setting up
  std::vector<std::array<double, 3>> position;  // at the end, m
};

// Throws std::invalid_argument for a method that is not the library's, or springs that it cannot
// express.
ClothOutcome simulate_cloth(const ClothProblem& problem, const ClothSettings& settings);

// As text, exact to the last bit. Reading leaves the stream failed where something is missing.
std::ostream& operator<<(std::ostream& stream, const ClothSettings& settings);
std::istream& operator>>(std::istream& stream, ClothSettings& settings);
std::ostream& operator<<(std::ostream& stream, const ClothProblem& problem);
std::istream& operator>>(std::istream& stream, ClothProblem& problem);
std::ostream& operator<<(std::ostream& stream, const ClothOutcome& outcome);
std::istream& operator>>(std::istream& stream, ClothOutcome& outcome);

}  // namespace weft::bench
