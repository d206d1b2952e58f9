#include "bsi/detail/fold_watch.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include <Eigen/Geometry>

#include "bsi/detail/rounded_up.h"
#include "bsi/detail/team.h"

namespace weft::bsi {

namespace {

constexpr int windows_per_look = 32;
constexpr int texels_per_part = 1024;

// Number of texels or windows that are handled together, in vector registers.
constexpr int block_size = 16;
static_assert(texels_per_part % block_size == 0);

// Upper bound of the rounding errors in the motion and the room of a window, as a fraction of the
// distance of the farthest particle from the first one: those of eight numbers in float32, of sums,
// and of deviations within a plane, which may be small differences of 1e-8 of their terms.
constexpr float rounding_per_metre = 1e-6F;

// Part of the largest room that smooth_room() must find beyond what is needed. With less, windows
// are looked at more often; with more, their distances are measured more often.
constexpr double part_for_smooth = 0.0625;

// The features of a window, by its nine vertices: row by row, the middle is 4.
struct WindowFeatures {
  struct Triangle {
    int quad = 0, number = 0;  // of the window's four quads, and of the quad's two triangles
    std::array<int, 3> corner{};
  };
  struct Edge {
    int triangle = 0, number = 0;  // number of the opposite corner
    std::array<int, 2> vertex{};
  };
  struct Pair {
    std::array<int, 4> vertex{};
    int first = 0, second = 0;  // a vertex and a triangle, or two edges
  };
  std::vector<Triangle> triangles;
  std::vector<Edge> edges;
  std::array<std::vector<Pair>, 2> pairs;  // by FeatureKind, without common vertices

  WindowFeatures() {
    for (int quad = 0; quad < 4; ++quad) {
      const int corner = quad / 2 * 3 + quad % 2;
      const auto both = quad_triangles({corner, corner + 1, corner + 3, corner + 4});
      for (int number = 0; number < 2; ++number) {
        triangles.push_back({quad, number, both[number]});
        add_edges();
      }
    }
    pair_up();
  }

 private:
  void add_edges() {
    const auto& corner = triangles.back().corner;
    for (int e = 0; e < 3; ++e) {
      const auto [low, high] = std::minmax(corner[(e + 1) % 3], corner[(e + 2) % 3]);
      const std::array<int, 2> vertex{low, high};
      if (std::ranges::none_of(edges, [&](const Edge& edge) { return edge.vertex == vertex; }))
        edges.push_back({static_cast<int>(triangles.size()) - 1, e, vertex});
    }
  }

  void pair_up() {
    for (int v = 0; v < 9; ++v) {
      for (int t = 0; t < static_cast<int>(triangles.size()); ++t) {
        const auto& [a, b, c] = triangles[t].corner;
        if (v != a && v != b && v != c) pairs[0].push_back({{v, a, b, c}, v, t});
      }
    }
    for (int e = 0; e < static_cast<int>(edges.size()); ++e) {
      for (int f = e + 1; f < static_cast<int>(edges.size()); ++f) {
        const auto [a, b] = edges[e].vertex;
        const auto [c, d] = edges[f].vertex;
        if (a != c && a != d && b != c && b != d) pairs[1].push_back({{a, b, c, d}, e, f});
      }
    }
  }
};

const WindowFeatures& window_features() {
  static const WindowFeatures features;
  return features;
}

// The numbers of a block.
using Block = float __attribute__((vector_size(block_size * sizeof(float))));

template <class Floats>
Floats loaded(const float* at) {
  Floats result;
  std::memcpy(&result, at, sizeof(Floats));
  return result;
}
float square_root(float square) { return std::sqrt(square); }
Block square_root(const Block& square) {
  std::array<float, block_size> roots;
  std::memcpy(roots.data(), &square, sizeof(Block));
  for (float& each : roots) each = std::sqrt(each);
  return loaded<Block>(roots.data());
}
template <class Floats>
Floats larger(const Floats& a, const Floats& b) {
  return a > b ? a : b;
}

// Positions of a block of texels, m, relative to an origin.
class PlacedBlock {
 public:
  explicit PlacedBlock(const Vec3& origin) {
    for (int k = 0; k < block_size; ++k) std::ranges::copy(origin, &origin_[3 * k]);
  }
  // Places the whole block, whose positions follow each other in memory.
  void place(const double* from) {
    for (int i = 0; i < 3 * block_size; ++i) at_[i] = static_cast<float>(from[i] - origin_[i]);
  }
  void place(const Vec3& from, int k) {
    for (int i = 0; i < 3; ++i) at_[3 * k + i] = static_cast<float>(from[i] - origin_[i]);
  }
  // Copies the first `count` positions. With a constant count, the loop needs no branches.
  void copy_to(int count, float* x, float* y, float* z) {
    if (count == block_size) {
      separate(block_size, x, y, z);
    } else {
      separate(count, x, y, z);
    }
    for (int i = 0; i < 3 * block_size; ++i) largest_[i] = std::max(largest_[i], std::abs(at_[i]));
  }
  // Returns the largest component of all positions placed so far.
  float largest() const { return std::ranges::max(largest_); }

 private:
  [[gnu::always_inline]] void separate(int count, float* x, float* y, float* z) const {
    for (int k = 0; k < count; ++k) {
      x[k] = at_[3 * k];
      y[k] = at_[3 * k + 1];
      z[k] = at_[3 * k + 2];
    }
  }

  std::array<double, 3 * block_size> origin_{};
  std::array<float, 3 * block_size> at_{}, largest_{};
};

}  // namespace

FoldWatch::FoldWatch(const Atlas& atlas, const Mesh& mesh, const Neighbourhoods* neighbourhoods,
                     const Reach& reach, double largest_room)
    : mesh_(mesh),
      neighbourhoods_(neighbourhoods),
      reach_(reach),
      largest_room_(largest_room),
      windows_(atlas.quad_count(), {-1, -1, -1, -1}),
      inner_stride_(atlas.quad_count(), 0) {
  for (int p = 0; p < static_cast<int>(atlas.patches().size()); ++p) add_patch(atlas, p);
  for (int texel = 0; texel < static_cast<int>(particle_.size()); texel += block_size)
    runs_.push_back(are_consecutive(texel) ? 1 : 0);
  const std::size_t count = grid_of_window_.size();
  start_ = end_ = Components(particle_.size());
  recorded_.fill(Components(count));
  room_.assign(count, std::numeric_limits<float>::infinity());  // none has been looked at
  moved_.assign(count, 0);
  largest_reach_.assign(count, -1);
  is_closed_.assign(count, 0);
}

void FoldWatch::add_patch(const Atlas& atlas, int p) {
  const Patch& patch = atlas.patches()[p];
  Grid grid;
  grid.rows = patch.rows + (patch.wrap_v ? 2 : 0);
  grid.cols = patch.cols + (patch.wrap_u ? 2 : 0);
  grid.first_texel = static_cast<int>(particle_.size());
  grid.first_window = static_cast<int>(grid_of_window_.size());
  for (int row = 0; row < grid.rows; ++row) {
    for (int col = 0; col < grid.cols; ++col) {
      const int r = row % patch.rows, c = col % patch.cols;
      particle_.push_back(atlas.particle(p, r, c));
      quad_.push_back(atlas.first_quad(p) + r * patch.quad_cols() + c);
    }
  }
  for (int row = 0; row < grid.window_rows(); ++row) {
    for (int col = 0; col < grid.window_cols(); ++col) {
      const int window = static_cast<int>(grid_of_window_.size());
      const int texel = grid.first_texel + row * grid.cols + col;
      // The middle of the window is the last corner of its first quad, and so on.
      for (int k = 0; k < 4; ++k)
        windows_[quad_[texel + k / 2 * grid.cols + k % 2]][3 - k] = window;
      grid_of_window_.push_back(static_cast<int>(grids_.size()));
    }
  }
  grids_.push_back(grid);
  for (int row = 1; row < patch.quad_rows() - 1; ++row) {
    for (int col = 1; col < patch.quad_cols() - 1; ++col)
      inner_stride_[atlas.first_quad(p) + row * patch.quad_cols() + col] = patch.quad_cols();
  }
}

int FoldWatch::middle_of(int window) const {
  const Grid& grid = grid_of(window);
  const int local = window - grid.first_window;
  return grid.first_texel + (local / grid.window_cols() + 1) * grid.cols +
         local % grid.window_cols() + 1;
}

// Sets `at` to the positions relative to the first texel, which loses less to rounding than
// positions do. Returns the bound of rounding errors.
float FoldWatch::place(std::span<const Vec3> x, Components& at, int threads) const {
  const Vec3 origin = x[particle_.front()];
  const int count = static_cast<int>(particle_.size());
  std::vector<float> largest((count + texels_per_part - 1) / texels_per_part, 0.0F);
  parallel_for(static_cast<int>(largest.size()), threads, [&](int part) {
    const int first = part * texels_per_part, last = std::min(count, first + texels_per_part);
    PlacedBlock block(origin);
    for (int i = first; i < last; i += block_size) {
      if (runs_[i / block_size] != 0) {
        block.place(x[particle_[i]].data());
      } else {
        for (int k = 0; k < std::min(block_size, last - i); ++k)
          block.place(x[particle_[i + k]], k);
      }
      block.copy_to(std::min(block_size, last - i), &at.x[i], &at.y[i], &at.z[i]);
    }
    largest[part] = block.largest();
  });
  return rounding_per_metre * std::ranges::max(largest);
}

// True if the texels of a block have consecutive particles.
bool FoldWatch::are_consecutive(int texel) const {
  if (texel + block_size > static_cast<int>(particle_.size())) return false;
  for (int i = 1; i < block_size; ++i) {
    if (particle_[texel + i] != particle_[texel] + i) return false;
  }
  return true;
}

// Finds the motion of windows of one row since their last look. The last two blocks may share
// windows.
void FoldWatch::measure(int first, int count, bool is_path) {
  if (count < block_size) {
    for (int w = 0; w < count; ++w) measure_block<float>(first + w, is_path);
    return;
  }
  for (int w = 0; w < count; w += block_size)
    measure_block<Block>(first + std::min(w, count - block_size), is_path);
}

// Does the same for one window (Floats = float) or for as many as `Floats` has numbers.
template <class Floats>
void FoldWatch::measure_block(int first, bool is_path) {
  Floats squared = squared_motion<Floats>(first, end_);
  if (is_path) squared = larger(squared, squared_motion<Floats>(first, start_));
  const Floats moved = square_root(squared);
  std::memcpy(&moved_[first], &moved, sizeof(Floats));
}

// Returns the squares of the motion of windows to the positions `at`.
template <class Floats>
Floats FoldWatch::squared_motion(int first, const Components& at) const {
  const int middle = middle_of(first), cols = grid_of(first).cols;
  Floats largest{};
  for (int k = 0; k < ring_size; ++k) {
    // The texel of the vertex, as texel_of() gives it by a division for each.
    const int vertex = k < 4 ? k : k + 1;
    const int texel = middle + (vertex / 3 - 1) * cols + vertex % 3 - 1;
    const auto difference = [&](const std::vector<float>& now, const std::vector<float>& recorded) {
      return loaded<Floats>(&now[texel]) - loaded<Floats>(&now[middle]) -
             loaded<Floats>(&recorded[first]);
    };
    const Floats dx = difference(at.x, recorded_[k].x), dy = difference(at.y, recorded_[k].y);
    const Floats dz = difference(at.z, recorded_[k].z);
    largest = larger(largest, dx * dx + dy * dy + dz * dz);
  }
  return largest;
}

void FoldWatch::record(int window) {
  const int middle = middle_of(window);
  for (int k = 0; k < ring_size; ++k) {
    const int texel = texel_of(window, k < 4 ? k : k + 1);
    recorded_[k].x[window] = end_.x[texel] - end_.x[middle];
    recorded_[k].y[window] = end_.y[texel] - end_.y[middle];
    recorded_[k].z[window] = end_.z[texel] - end_.z[middle];
  }
}

// Returns the reach (m) of a pair of a window's features.
double FoldWatch::reach_of_pair(int window, FeatureKind kind, int pair) const {
  const bool edges = kind == FeatureKind::edge_edge;
  const double reach = edges ? reach_.edges : reach_.vertices;
  if (neighbourhoods_ == nullptr) return reach;
  const WindowFeatures& features = window_features();
  const auto& [vertex, first, second] = features.pairs[edges ? 1 : 0][pair];
  const auto triangle_of = [&](int t) {
    const auto& triangle = features.triangles[t];
    const int texel = texel_of(window, triangle.quad / 2 * 3 + triangle.quad % 2);
    return 2 * quad_[texel] + triangle.number;
  };
  const auto edge_of = [&](int e) -> const Edge& {
    const auto& edge = features.edges[e];
    return mesh_.edges[mesh_.triangle_edges[triangle_of(edge.triangle)][edge.number]];
  };
  const bool near =
      edges ? neighbourhoods_->are_neighbours(edge_of(first), edge_of(second))
            : neighbourhoods_->contains(particle_[texel_of(window, first)], triangle_of(second));
  return near ? 0 : reach;
}

// Returns the largest reach (m) of any pair of a window's features.
float FoldWatch::largest_reach(int window) {
  float& largest = largest_reach_[window];
  if (largest >= 0) return largest;
  for (const FeatureKind kind : {FeatureKind::vertex_triangle, FeatureKind::edge_edge}) {
    const auto& pairs = window_features().pairs[kind == FeatureKind::edge_edge ? 1 : 0];
    for (int pair = 0; pair < static_cast<int>(pairs.size()); ++pair)
      largest = std::max(largest, rounded_up(reach_of_pair(window, kind, pair)));
  }
  return largest;
}

// Returns a lower bound of the room (m) of a window, which may be negative. It is close to the room
// where the surface is smooth, its texels are about square, and all pairs have about the same
// reach.
float FoldWatch::smooth_room(int window, std::span<const Vec3> x) {
  std::array<Vec3, 9> at;
  for (int v = 0; v < 9; ++v) at[v] = x[particle_[texel_of(window, v)]];
  const auto row = [&](int r) -> Vec3 { return at[3 * r] + at[3 * r + 1] + at[3 * r + 2]; };
  const auto col = [&](int c) -> Vec3 { return at[c] + at[c + 3] + at[c + 6]; };
  // The linear image that fits the vertices best.
  const Vec3 down = (row(2) - row(0)) / 6, right = (col(2) - col(0)) / 6;
  const Vec3 middle = (row(0) + row(1) + row(2)) / 9, normal = down.cross(right);
  const double squared_area = normal.squaredNorm();
  if (!(squared_area > 0)) return -INFINITY;
  double squared = 0;  // of the largest deviation within the plane
  for (int v = 0; v < 9; ++v) {
    const Vec3 deviation = at[v] - middle - (v / 3 - 1) * down - (v % 3 - 1) * right;
    const double across = normal.dot(deviation);
    squared = std::max(squared, deviation.squaredNorm() - across * across / squared_area);
  }
  // The squares of the singular values are the eigenvalues of a symmetric 2 x 2 matrix.
  const double a = down.squaredNorm(), b = right.squaredNorm(), c = down.dot(right);
  const double smaller = 0.5 * (1 - 1e-12) * (a + b) - std::hypot(0.5 * (a - b), c);
  const double room = std::sqrt(std::max(0.0, 0.5 * smaller)) - 2 * std::sqrt(squared) -
                      static_cast<double>(largest_reach(window));
  return std::nextafter(static_cast<float>(std::min(room, largest_room_)), -INFINITY);
}

// Sets the rooms of windows by the distances of their features.
void FoldWatch::measure_rooms(std::span<const int> windows, std::span<const Vec3> x) {
  for (const int w : windows) room_[w] = static_cast<float>(largest_room_);
  std::vector<FourParticles> pairs;
  std::vector<PairInReach> found;
  for (const FeatureKind kind : {FeatureKind::vertex_triangle, FeatureKind::edge_edge}) {
    const bool edges = kind == FeatureKind::edge_edge;
    const auto& of_window = window_features().pairs[edges ? 1 : 0];
    const int count = static_cast<int>(of_window.size());
    pairs.clear();
    found.clear();
    for (const int w : windows) {
      std::array<int, 9> particle{};
      for (int v = 0; v < 9; ++v) particle[v] = particle_[texel_of(w, v)];
      for (const auto& [v, first, second] : of_window)
        pairs.push_back({particle[v[0]], particle[v[1]], particle[v[2]], particle[v[3]]});
    }
    const double reach = edges ? reach_.edges : reach_.vertices;
    find_in_reach(kind, x, pairs, reach + largest_room_, found);
    for (const PairInReach& each : found) {
      const int w = windows[each.pair / count];
      if (!(each.distance - reach < static_cast<double>(room_[w]))) continue;
      const double room = each.distance - reach_of_pair(w, kind, each.pair % count);
      room_[w] = std::min(room_[w], std::nextafter(static_cast<float>(room), -INFINITY));
    }
  }
  for (const int w : windows) room_[w] -= rounding_;
}

// Looks at windows at the ends of the paths. Their rooms are measured where the surface is not so
// smooth that they prove to be `needed` (m), and some more.
void FoldWatch::look_at(std::span<const int> windows, const Paths& paths, double needed,
                        int threads) {
  const double enough = needed + part_for_smooth * largest_room_;
  const int count = static_cast<int>(windows.size());
  parallel_for((count + windows_per_look - 1) / windows_per_look, threads, [&](int look) {
    const int first = look * windows_per_look;
    std::vector<int> others;
    for (const int w : windows.subspan(first, std::min(windows_per_look, count - first))) {
      room_[w] = smooth_room(w, paths.end) - rounding_;
      record(w);
      measure(w, 1, paths.is_path());
      if (!has_room(w, enough)) others.push_back(w);
    }
    measure_rooms(others, paths.end);
  });
}

bool FoldWatch::follow(const Paths& paths, double stray, std::span<char> marks, int threads) {
  if (window_count() == 0) return false;
  rounding_ = place(paths.end, end_, threads);
  if (paths.is_path()) rounding_ = std::max(rounding_, place(paths.start, start_, threads));
  for (const Grid& grid : grids_) {
    parallel_for(grid.window_rows(), threads, [&](int row) {
      measure(grid.first_window + row * grid.window_cols(), grid.window_cols(), paths.is_path());
    });
  }
  std::vector<int> used_up;
  for (int w = 0; w < window_count(); ++w)
    if (is_closed_[w] != 0 && !has_room(w, stray)) used_up.push_back(w);
  look_at(used_up, paths, stray, threads);
  std::erase_if(used_up, [&](int w) { return has_room(w, stray); });
  for (const int w : used_up) {
    is_closed_[w] = 0;
    for (int v = 0; v < 9; ++v) marks[particle_[texel_of(w, v)]] = 1;
  }
  return !used_up.empty();
}

void FoldWatch::close(const Paths& paths, double stray, double room, int threads) {
  std::vector<int> open;
  for (int w = 0; w < window_count(); ++w) {
    if (is_closed_[w] != 0) continue;
    const double most = static_cast<double>(room_[w]) + 2 * static_cast<double>(moved_[w]);
    if (most >= stray + room) open.push_back(w);
  }
  look_at(open, paths, stray + room, threads);
  for (const int w : open) is_closed_[w] = has_room(w, stray + room) ? 1 : 0;
}

bool FoldWatch::covers(int quad, int other) const {
  // Most pairs are adjacent quads in the midst of a patch, all of whose windows are closed.
  const int stride = inner_stride_[quad], column = other - quad + stride + 1;
  if (stride > 0 && column >= 0 && column % stride < 3 && column < 3 * stride &&
      is_amid_closed(quad))
    return true;
  for (const int w : windows_[quad]) {
    if (w < 0 || is_closed_[w] == 0) continue;
    if (std::ranges::find(windows_[other], w) != windows_[other].end()) return true;
  }
  return false;
}

int FoldWatch::closed_count() const { return static_cast<int>(std::ranges::count(is_closed_, 1)); }

}  // namespace weft::bsi
