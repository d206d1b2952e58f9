#include "gpu/renderer.h"

namespace weft::gpu {
namespace {

// Rows (or columns) that get a line: every step-th, and the last one of an open axis.
std::vector<int> lined_places(int quads, int count) {
  int step = 1;
  while (quads / step > 12) step *= 2;
  std::vector<int> places;
  for (int place = 0; place < count; place += step) places.push_back(place);
  if (places.back() != count - 1 && count > quads) places.push_back(count - 1);
  return places;
}

}  // namespace

std::vector<std::array<int, 2>> grid_lines(const bsi::Atlas& atlas) {
  std::vector<std::array<int, 2>> lines;
  for (int number = 0; number < static_cast<int>(atlas.patches().size()); ++number) {
    const bsi::Patch& patch = atlas.patches()[number];
    for (const int row : lined_places(patch.quad_rows(), patch.rows)) {
      for (int col = 0; col < patch.quad_cols(); ++col) {
        lines.push_back({atlas.particle(number, row, col), atlas.particle(number, row, col + 1)});
      }
    }
    for (const int col : lined_places(patch.quad_cols(), patch.cols)) {
      for (int row = 0; row < patch.quad_rows(); ++row) {
        lines.push_back({atlas.particle(number, row, col), atlas.particle(number, row + 1, col)});
      }
    }
  }
  return lines;
}

}  // namespace weft::gpu
