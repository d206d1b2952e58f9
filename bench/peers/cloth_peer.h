// The interface of a library that simulates point masses joined by springs, for benchmarks.
//
// Each library has its own program, weft-bench-NAME, which reads settings and a problem from
// standard input and writes the outcome. Programs keep two builds of one library apart: Bullet
// finds pairs in float32 but moves cloth in float64. A crash costs only one row of a table.
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

// A ball at rest that point masses keep out of.
struct ClothBall {
  std::array<double, 3> centre{};  // m
  double radius = 0;               // m; 0: no ball
  double gap = 0;                  // m, distance that point masses keep from it
  double friction = 0;             // Coulomb coefficient
};

// Undamped springs between point masses under gravity, without air and without contact but that
// with a ball.
struct ClothProblem {
  std::array<double, 3> gravity{};                        // m/s^2
  std::vector<std::array<double, 3>> position, velocity;  // at the start, m, m/s
  std::vector<double> mass;                               // kg; 0: held in place
  std::vector<ClothSpring> springs;
  ClothBall ball = {};
};

struct ClothSettings {
  std::string method;  // one word, by the library's naming
  double step = 0;     // s
  long steps = 0;
  int iterations = 1;        // per step, as the method defines them
  double tolerance = 0;      // of its linear solver, as that defines it; 0: its default
  bool line_search = false;  // of Newton's method
  double budget = 0;         // s of CPU time, after which it fails
};

struct ClothOutcome {
  std::string failure;                          // empty: reached the end
  double cpu = 0;                               // s, without setting up
  std::vector<std::array<double, 3>> position;  // at the end, m
};

// Simulates cloth. Throws std::invalid_argument for an unknown method, springs that the library
// cannot express, or a ball that the method does not know.
ClothOutcome simulate_cloth(const ClothProblem& problem, const ClothSettings& settings);

// Text form, exact to the last bit. Reading incomplete text sets the stream's failure state.
std::ostream& operator<<(std::ostream& stream, const ClothSettings& settings);
std::istream& operator>>(std::istream& stream, ClothSettings& settings);
std::ostream& operator<<(std::ostream& stream, const ClothProblem& problem);
std::istream& operator>>(std::istream& stream, ClothProblem& problem);
std::ostream& operator<<(std::ostream& stream, const ClothOutcome& outcome);
std::istream& operator>>(std::istream& stream, ClothOutcome& outcome);

}  // namespace weft::bench
