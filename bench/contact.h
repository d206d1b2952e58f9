// Runs whose time goes to contact, and what they pay for.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/case/case.h"

namespace weft::bench {

// A moment of a run: work per force evaluation since the moment before.
struct ContactMoment {
  double time = 0;              // s
  double pairs_in_contact = 0;  // mean over the steps
  double microseconds = 0;      // of search and narrow phase, per evaluation
};

// The cost of a run from t = 0 to the end of the case.
struct ContactRun {
  std::string failure;       // empty: reached the end
  int vertices = 0;          // dynamic particles
  double simulated = 0;      // s
  double cpu = 0, wall = 0;  // s, of the process, without setting up the scene
  double detection = 0;      // s: rebuilds, traversals and the narrow phase
  double linear_solve = 0;   // s
  double steps = 0, vetoed = 0;
  double evaluations = 0;       // of the forces
  double pairs_measured = 0;    // feature pairs whose distance or path was checked
  double pairs_in_contact = 0;  // mean over the steps
  double solves = 0, iterations = 0, factorisations = 0;
  int crossings = 0;           // pairs of triangles, all looks together
  double largest_strain = 0;   // principal, at the looks
  std::size_t trajectory = 0;  // a hash of the positions at all looks
  std::vector<ContactMoment> moments;

  double cpu_per_second() const { return cpu / simulated; }
  // CPU time per vertex and 1/60 s, microseconds.
  double per_vertex() const { return 1e6 * cpu_per_second() / 60 / vertices; }
  double iterations_per_solve() const { return solves > 0 ? iterations / solves : 0; }
};

// Runs the case and looks at its surfaces at equal times, `looks` times. Crossings are exact. A
// failure is part of the result.
ContactRun measure_contact(const sim::Case& source, int looks);

// Returns the path of the program of Bullet's soft bodies; empty if it was not built.
std::optional<std::string> ball_program();
// Runs a sheet that falls on the ball at obstacle 0 by Bullet's soft bodies, with springs as stiff
// as its membrane, and without bending and damping. Crossings and strain are those at the end.
ContactRun measure_soft_body(const std::string& program, const sim::Case& source,
                             int steps_per_second, int iterations);

}  // namespace weft::bench
