// The checks of `weft bench shells`: cases of cases/benchmarks/ with what is measured in them and
// the figures that it is compared with.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "sim/base/vectors.h"

namespace weft::bench {

// A figure from outside, of tests/reference/closed_forms.csv.
struct ReferenceFigure {
  double value = 0;
  std::string source;
};
// Throws std::runtime_error if the file has no figure of this name.
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

// A quantity of one frame and its figure.
struct Measured {
  std::string quantity;
  double value = 0;
  ReferenceFigure reference;
  double scale = 0;  // the error is |value - reference| / scale
};

// Images of a check's body: `resolution` as in the case, `limit` of the error, or 0 for none.
struct CheckedImage {
  std::vector<int> resolution;
  double limit = 0;
};

struct ShellCheck {
  std::string name;
  std::string case_name;  // of cases/benchmarks/, without .toml
  std::string body;
  std::vector<std::string> overrides;  // KEY=VALUE
  std::vector<CheckedImage> images;
  // Measures a frame; the worst quantity of all frames is the row's. Frame 0 is the start.
  std::function<std::vector<Measured>(const FramedBody&, int frame)> measure;
};

const std::vector<ShellCheck>& shell_checks();

}  // namespace weft::bench
