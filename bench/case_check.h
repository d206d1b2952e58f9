// Checks of cases: what is measured in a case of cases/benchmarks/, and the figures with which it
// is compared.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "bench/check_row.h"
#include "sim/base/vectors.h"
#include "sim/case/case_reader.h"
#include "sim/simulation/simulation.h"

namespace weft::bench {

// A figure from outside.
struct ReferenceFigure {
  double value = 0;
  std::string source;
};
// Returns a figure of tests/reference/closed_forms.csv. Throws std::runtime_error if the file has
// none of this name.
ReferenceFigure reference_figure(const std::string& name);

// The vertices of a body in a frame, by row and column; negative numbers count from the end.
class FramedBody {
 public:
  FramedBody(std::vector<sim::Vec3> start, std::vector<sim::Vec3> now, int columns)
      : start_(std::move(start)), now_(std::move(now)), columns_(columns) {}
  const sim::Vec3& start(int row, int col) const { return start_[index(row, col)]; }
  const sim::Vec3& now(int row, int col) const { return now_[index(row, col)]; }
  sim::Vec3 way(int row, int col) const { return now(row, col) - start(row, col); }
  int columns() const { return columns_; }
  int rows() const { return static_cast<int>(start_.size()) / columns_; }

 private:
  std::size_t index(int row, int col) const {
    return static_cast<std::size_t>((row < 0 ? rows() + row : row) * columns_ +
                                    (col < 0 ? columns_ + col : col));
  }
  std::vector<sim::Vec3> start_, now_;
  int columns_;
};

// A quantity and its figure.
struct Measured {
  std::string quantity;
  double value = 0;
  ReferenceFigure reference;
  double scale = 0;  // the error is |value - reference| / scale
};
// The error is relative to the figure.
Measured relative(std::string quantity, double value, ReferenceFigure reference);
// Likewise for a figure of closed_forms.csv.
Measured by_name(std::string quantity, double value, const std::string& name);

// Images of a check's body: `resolution` as in the case, `limit` of the error by Bound::error, or 0
// for none.
struct CheckedImage {
  std::vector<int> resolution;
  double limit = 0;
};
// Strips of 4 rows: columns and limits.
std::vector<CheckedImage> strips(const std::vector<std::pair<int, double>>& columns);
// Square images: sides and limits.
std::vector<CheckedImage> squares(const std::vector<std::pair<int, double>>& sides);

struct CaseCheck {
  std::string name = {};
  std::string case_name = {};               // of cases/benchmarks/, without .toml
  std::vector<std::string> overrides = {};  // KEY=VALUE
  std::vector<CheckedImage> images = {};
  Bound bound = Bound::error;  // of images with a limit; another demand holds for all images
  // Measures a frame of the first body; the worst quantity of all frames is the row's. Frame 0 is
  // the start. Empty: `measure_case` measures.
  std::function<std::vector<Measured>(const FramedBody&, int frame)> measure = {};
  // Measures the case as a whole, such as by its modes. Throws std::runtime_error if that fails.
  std::function<std::vector<Measured>(const sim::Case&)> measure_case = {};
};

std::string benchmark_path(const std::string& case_name);
// Reads the case with the image in place of that of its first body.
sim::Case case_of(const CaseCheck& check, const CheckedImage& image);

// Steps the simulation to a time (s). Throws std::runtime_error if it fails.
void advance_to(sim::Simulation& simulation, double time);

// Reads and runs the case. A failure is part of the row.
CheckRow run_check(const CaseCheck& check, const CheckedImage& image);

}  // namespace weft::bench
