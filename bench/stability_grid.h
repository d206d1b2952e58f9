// The grid of the stability test. Each slice varies one or two quantities in a scene of
// bench/stability/.
#pragma once

#include <string>
#include <vector>

namespace weft::bench {

// One run: the file of the case and the keys that are changed in it.
struct Cell {
  std::string slice, method, path;
  int x = 0, y = 0;  // along the axes of the slice; of a sweep, y is the method
  std::vector<std::string> overrides;
  double size = 1;                // factor of its limit
  double duration = 0;            // s, simulated
  double tolerance = 0;           // m, of a method that controls its error; 0: of fixed steps
  bool has_moving_parts = false;  // obstacles or pins that move
  bool is_static = false;

  std::string command() const;  // reproduces the run, without its limit
  // The file and all keys outside [time]. Cells with equal ones simulate the same physics.
  std::vector<std::string> physics() const;
};

struct Slice {
  std::string name;
  std::string x_title, y_title;  // y_title is empty for a sweep, whose rows are methods
  std::vector<std::string> x_labels, y_labels;
  std::vector<std::string> methods;
  std::vector<Cell> cells;  // by method, y, x
};

std::vector<std::string> slice_names();
// Returns all slices, or those named. With `quick`, a sweep has only its start and one point, up to
// which backward Euler and the error-controlled methods are known to do well.
std::vector<Slice> make_slices(const std::vector<std::string>& names, bool quick);
// Returns every n-th cell of the slices, counted through all of them; empty slices are dropped.
std::vector<Slice> every_nth(std::vector<Slice> slices, int n);

}  // namespace weft::bench
