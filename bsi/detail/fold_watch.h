// Finds out where a surface may be folded so sharply that it comes within reach of itself.
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "bsi/detail/feature_batches.h"
#include "bsi/detail/neighbourhoods.h"
#include "bsi/geometry_image.h"

namespace weft::bsi {

// Most pairs of quads that are near each other share a vertex. Their features without a common
// vertex are within reach only where a fold is about as sharp as the mesh is fine.
//
// A window is the four quads around an inner texel, so that any two quads of a patch that share a
// texel have a common window. A look at a window measures the distances of all pairs of its
// features, and records its vertices relative to the one in the middle. The `room` of a window is
// the least distance of a pair, less the reach of its kind. Until a vertex has moved by half of the
// room, relative to the middle, no pair comes within reach. Surfaces that bend slowly therefore
// need few looks, however fast they move as a whole. Windows without room are open: what they
// contain must be found by other means.
//
// A look first tries to do without distances. If the vertices were an image c + F u of their places
// u in the grid, with a vector c and a matrix F, features without a common vertex would be at least
// s / sqrt(2) apart, where s is the smaller singular value of F: in the grid itself, the nearest
// ones are 1 / sqrt(2) apart, as a vertex and the diagonal across its quad. Vertices that deviate
// from the image by at most e within its plane take no more than 2 e off; deviations across the
// plane take nothing. Where a surface is smooth on the scale of its mesh, what is left proves
// enough room.
//
// Windows extend across wrapped borders, and not across seams.
class FoldWatch {
 public:
  // The distances (m) within which a vertex and a triangle, or two edges, are in reach. That of
  // neighbours at rest is zero.
  struct Reach {
    double vertices = 0, edges = 0;
  };
  // Straight paths of the particles, m. Both are the same list if nothing moves.
  struct Paths {
    std::span<const Vec3> start, end;
    bool is_path() const { return start.data() != end.data(); }
  };

  // Rooms are measured up to `largest_room`, m. `neighbourhoods` is null if only features with a
  // common vertex are neighbours. All windows are open at first. `mesh` and `neighbourhoods` must
  // outlive the object. O(texels).
  FoldWatch(const Atlas& atlas, const Mesh& mesh, const Neighbourhoods* neighbourhoods,
            const Reach& reach, double largest_room);

  // Opens the windows in which pairs may come within reach plus `stray` (m) on the paths, and marks
  // their particles. Returns true if there are any. Windows that have used up their room are looked
  // at once more before. 10 ns for each window, 50 ns for each one looked at that is smooth, and
  // 2 us for each other one.
  bool follow(const Paths& paths, double stray, std::span<char> marks, int threads);
  // Closes the open windows that have room for `stray` and `room` (m) on the paths of the last
  // follow(). Those that cannot have gained that room since the last look are not looked at.
  void close(const Paths& paths, double stray, double room, int threads);
  // Returns true if a closed window contains both quads: no pair of their features without a common
  // vertex is then within reach.
  bool covers(int quad, int other) const;

  int window_count() const { return static_cast<int>(is_closed_.size()); }
  int closed_count() const;

 private:
  // The texels of a patch. A wrapped axis has two more of them than the patch, so that windows can
  // extend across its border.
  struct Grid {
    int rows = 0, cols = 0;
    int first_texel = 0, first_window = 0;
    int window_rows() const { return rows - 2; }
    int window_cols() const { return cols - 2; }
  };
  // A list for each component of vectors, so that loops over them need no shuffles.
  struct Components {
    std::vector<float> x, y, z;
    explicit Components(std::size_t count = 0) : x(count), y(count), z(count) {}
  };
  static constexpr int ring_size = 8;

  void add_patch(const Atlas& atlas, int patch);
  const Grid& grid_of(int window) const { return grids_[grid_of_window_[window]]; }
  int middle_of(int window) const;
  // Returns the texel that belongs to a vertex of a window, 0 to 8, row by row.
  int texel_of(int window, int vertex) const {
    return middle_of(window) + (vertex / 3 - 1) * grid_of(window).cols + vertex % 3 - 1;
  }
  bool is_amid_closed(int quad) const {
    return std::ranges::all_of(windows_[quad], [&](int w) { return w >= 0 && is_closed_[w] != 0; });
  }
  bool are_consecutive(int texel) const;
  float place(std::span<const Vec3> x, Components& at, int threads) const;
  void measure(int first, int count, bool is_path);
  template <class Floats>
  void measure_block(int first, bool is_path);
  template <class Floats>
  Floats squared_motion(int first, const Components& at) const;
  void look_at(std::span<const int> windows, const Paths& paths, double needed, int threads);
  void measure_rooms(std::span<const int> windows, std::span<const Vec3> x);
  float smooth_room(int window, std::span<const Vec3> x);
  float largest_reach(int window);
  double reach_of_pair(int window, FeatureKind kind, int pair) const;
  void record(int window);
  bool has_room(int window, double needed) const {
    return static_cast<double>(room_[window]) - 2 * static_cast<double>(moved_[window]) >=
           needed + rounding_;
  }

  const Mesh& mesh_;
  const Neighbourhoods* neighbourhoods_;
  Reach reach_;
  double largest_room_;
  std::vector<Grid> grids_;
  std::vector<int> particle_, quad_;         // by texel of the grids: itself, the quad at its right
  std::vector<char> runs_;                   // by block of texels: nonzero if are_consecutive()
  std::vector<int> grid_of_window_;          // by window
  std::vector<std::array<int, 4>> windows_;  // by quad: around its corners, -1 where there is none
  // By quad: columns of its patch, or 0 if the quad is at a border of its patch.
  std::vector<int> inner_stride_;
  // By texel: present positions at the ends of the paths, m, relative to one of them. `rounding_`
  // (m) bounds what their rounding adds to the motion of a window.
  Components start_, end_;
  float rounding_ = 0;
  std::array<Components, ring_size> recorded_;  // by window, m, relative to the middle
  std::vector<float> room_, moved_;             // by window, m
  // By window: the largest reach of its pairs, m; negative until it is needed.
  std::vector<float> largest_reach_;
  std::vector<char> is_closed_;  // by window
};

}  // namespace weft::bsi
