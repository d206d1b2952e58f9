#include <algorithm>
#include <cassert>
#include <cmath>

#include "gpu/renderer.h"

namespace weft::gpu {
namespace {

constexpr int most_cells = 12;  // largest number of cells along the longest axis

// One axis of a patch's image: down its rows or across its columns.
struct Axis {
  int quads = 0;
  double edge = 0;  // mean length of the edges along the axis, m
  double length() const { return quads * edge; }
};

// The direction along the rows of a patch, or along its columns.
enum class Direction : bool { along_rows, along_cols };

Axis measure(const bsi::Atlas& atlas, int number, Direction direction,
             std::span<const Vec3> positions) {
  const bsi::Patch& patch = atlas.patches()[number];
  const bool is_down = direction == Direction::along_cols;
  double sum = 0;
  int count = 0;
  for (int row = 0; row < (is_down ? patch.quad_rows() : patch.rows); ++row) {
    for (int col = 0; col < (is_down ? patch.cols : patch.quad_cols()); ++col) {
      const int from = atlas.particle(number, row, col);
      const int to = atlas.particle(number, row + (is_down ? 1 : 0), col + (is_down ? 0 : 1));
      sum += (positions[to] - positions[from]).norm();
      ++count;
    }
  }
  return {is_down ? patch.quad_rows() : patch.quad_cols(), count == 0 ? 0 : sum / count};
}

// Returns the side of a cell (m): a whole number of edges of the longest axis. It is the smallest
// number that gives at most most_cells cells or, preferably, a slightly larger number that divides
// the number of quads along the axis.
double cell_size(const Axis& longest) {
  const double wanted = std::max(1.0, static_cast<double>(longest.quads) / most_cells);
  int step = static_cast<int>(std::ceil(wanted));
  for (int each = step; each < 1.5 * wanted; ++each) {
    if (longest.quads % each != 0) continue;
    step = each;
    break;
  }
  return step * longest.edge;
}

// Returns the indices of the rows (or columns) that get a line. Lines are one cell apart, rounded
// to whole quads. The last row of an axis that does not wrap also gets a line.
std::vector<int> lined_places(const Axis& axis, int count, double cell) {
  const int step = axis.edge > 0 ? std::max(1, static_cast<int>(std::lround(cell / axis.edge)))
                                 : std::max(1, axis.quads);
  std::vector<int> places;
  for (int place = 0; place < count; place += step) places.push_back(place);
  if (places.back() != count - 1 && count > axis.quads) places.push_back(count - 1);
  return places;
}

}  // namespace

std::vector<std::array<int, 2>> grid_lines(const bsi::Atlas& atlas,
                                           std::span<const Vec3> positions) {
  assert(static_cast<int>(positions.size()) >= atlas.particle_count());
  std::vector<std::array<Axis, 2>> axes;  // by patch: down its rows, then across its columns
  Axis longest;
  for (int number = 0; number < static_cast<int>(atlas.patches().size()); ++number) {
    axes.push_back({measure(atlas, number, Direction::along_cols, positions),
                    measure(atlas, number, Direction::along_rows, positions)});
    for (const Axis& axis : axes.back()) {
      if (axis.length() > longest.length()) longest = axis;
    }
  }
  const double cell = cell_size(longest);
  std::vector<std::array<int, 2>> lines;
  for (int number = 0; number < static_cast<int>(atlas.patches().size()); ++number) {
    const bsi::Patch& patch = atlas.patches()[number];
    for (const int row : lined_places(axes[number][0], patch.rows, cell)) {
      for (int col = 0; col < patch.quad_cols(); ++col) {
        lines.push_back({atlas.particle(number, row, col), atlas.particle(number, row, col + 1)});
      }
    }
    for (const int col : lined_places(axes[number][1], patch.cols, cell)) {
      for (int row = 0; row < patch.quad_rows(); ++row) {
        lines.push_back({atlas.particle(number, row, col), atlas.particle(number, row + 1, col)});
      }
    }
  }
  return lines;
}

}  // namespace weft::gpu
