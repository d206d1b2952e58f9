// Compiled once for every instruction set: see instruction_set.h for what that forbids.
#include "bsi/box_descent_kernels.h"

#include "bsi/box_lanes.h"
#include "bsi/leaf_pair.h"

namespace weft::bsi::WEFT_KERNELS {

namespace {

constexpr float largest_float = 3.402823466e38F;

WEFT_INLINE const BoxLevel& level_of(const BoxTree& tree, BoxNode node) {
  return tree.levels[node.level];
}
WEFT_INLINE bool is_leaf(const BoxLevel& level) { return level.groups == nullptr; }
WEFT_INLINE std::size_t block_of(const BoxLevel& level, BoxNode node) {
  return (static_cast<std::size_t>(node.v) << level.log_u) + node.u;
}
WEFT_INLINE bool same(BoxNode a, BoxNode b) {
  return a.level == b.level && a.u == b.u && a.v == b.v;
}
WEFT_INLINE BoxNode child_of(const BoxLevel& level, BoxNode node, int child) {
  return {node.level + 1, static_cast<std::uint16_t>((node.u << level.split_u) + (child & 1)),
          static_cast<std::uint16_t>((node.v << level.split_v) + (child >> 1))};
}

// The two rows of lanes: low - h and high + h of four boxes, one after the other in both halves.
WEFT_INLINE LaneBoxes both_halves(const BoxGroup& group, float half_margin) {
  LaneBoxes boxes;
  for (int axis = 0; axis < 3; ++axis) {
    const Quad low = load_quad(group.low[axis]) - half_margin;
    const Quad high = load_quad(group.high[axis]) + half_margin;
    boxes.low[axis] = __builtin_shufflevector(low, low, 0, 1, 2, 3, 0, 1, 2, 3);
    boxes.high[axis] = __builtin_shufflevector(high, high, 0, 1, 2, 3, 0, 1, 2, 3);
  }
  return boxes;
}

// Boxes `first` and first + 1 of four, each four times over.
template <int first>
WEFT_INLINE LaneBoxes each_four_times(const LaneBoxes& boxes) {
  LaneBoxes result;
  for (int axis = 0; axis < 3; ++axis) {
    const Lanes low = boxes.low[axis], high = boxes.high[axis];
    constexpr int f = first;
    result.low[axis] = __builtin_shufflevector(low, low, f, f, f, f, f + 1, f + 1, f + 1, f + 1);
    result.high[axis] = __builtin_shufflevector(high, high, f, f, f, f, f + 1, f + 1, f + 1, f + 1);
  }
  return result;
}

// Bit 4 i + j: child i of the one overlaps child j of the other.
WEFT_INLINE unsigned overlap_of_children(const BoxGroup& a, const BoxGroup& b, float half_margin) {
  const LaneBoxes of_a = both_halves(a, half_margin);
  const LaneBoxes of_b = both_halves(b, half_margin);
  return overlap(each_four_times<0>(of_a), of_b) | overlap(each_four_times<2>(of_a), of_b) << 8;
}

struct WideBox {
  float low[3], high[3];
};

WEFT_INLINE WideBox box_of(const BoxTree& tree, BoxNode node, float half_margin) {
  WideBox box;
  const BoxLevel& level = level_of(tree, node);
  const BoxPatch& patch = tree.patches[level.patch];
  if (node.level == patch.first_level) {
    for (int axis = 0; axis < 3; ++axis) {
      box.low[axis] = patch.low[axis] - half_margin;
      box.high[axis] = patch.high[axis] + half_margin;
    }
    return box;
  }
  const BoxLevel& above = tree.levels[node.level - 1];
  const BoxNode parent{node.level - 1, static_cast<std::uint16_t>(node.u >> above.split_u),
                       static_cast<std::uint16_t>(node.v >> above.split_v)};
  const int child = 2 * (above.split_v * (node.v & 1)) + above.split_u * (node.u & 1);
  const BoxGroup& group = above.groups[block_of(above, parent)];
  for (int axis = 0; axis < 3; ++axis) {
    box.low[axis] = group.low[axis][child] - half_margin;
    box.high[axis] = group.high[axis][child] + half_margin;
  }
  return box;
}

WEFT_INLINE LaneBoxes in_all_lanes(const float low[3], const float high[3]) {
  LaneBoxes boxes;
  for (int axis = 0; axis < 3; ++axis) {
    boxes.low[axis] = broadcast(low[axis]);
    boxes.high[axis] = broadcast(high[axis]);
  }
  return boxes;
}

WEFT_INLINE unsigned overlap_of_box(const WideBox& box, const BoxGroup& group, float half_margin) {
  return overlap(in_all_lanes(box.low, box.high), both_halves(group, half_margin)) & 15U;
}

// --- The tangent certificate
// -------------------------------------------------------------------------

WEFT_INLINE double dot(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// One side of the hexagon, from p to q, which stray by so much along each axis: true only if all
// that it can be lies beyond the margin, seen along about the perpendicular from the origin. `size`
// is no smaller than any component of what was computed on the way to p and q.
WEFT_INLINE bool is_beyond(const double p[3], const double stray_p[3], const double q[3],
                           const double stray_q[3], const double size[3], double margin) {
  const double side[3] = {q[0] - p[0], q[1] - p[1], q[2] - p[2]};
  const double along = dot(side, side), back = dot(p, side);
  double normal[3], magnitude[3];
  for (int i = 0; i < 3; ++i) {
    normal[i] = p[i] * along - side[i] * back;
    magnitude[i] = __builtin_fabs(normal[i]);
  }
  const double reach_p = dot(normal, p) - dot(magnitude, stray_p);
  const double reach_q = dot(normal, q) - dot(magnitude, stray_q);
  const double reach = reach_p < reach_q ? reach_p : reach_q;
  // Rounding takes less than 2^-46 of the last product.
  return reach > __builtin_sqrt(dot(normal, normal)) * margin + 0x1p-46 * dot(magnitude, size);
}

// True only if no two points of a rectangle of quads whose steps have these bounds come within the
// margin of each other, unless they lie on triangles with a common vertex (docs/theory.md, "The
// tangent certificate"): the hexagon of the steps along u, along v and along the diagonals keeps
// clear of the margin. In float64: a fourth power of a coordinate is out of the range of float32.
WEFT_INLINE bool certified(const float bound[16], double margin) {
  double mean[2][3], stray[2][3];
  for (int i = 0; i < 6; ++i) {
    const double low = -static_cast<double>(bound[i]), high = static_cast<double>(bound[6 + i]);
    mean[i / 3][i % 3] = 0.5 * (high + low);
    stray[i / 3][i % 3] = 0.5 * (high - low);
  }
  double diagonal[3], stray_diagonal[3], back[3], size[3];
  for (int i = 0; i < 3; ++i) {
    diagonal[i] = mean[1][i] - mean[0][i];
    stray_diagonal[i] = stray[0][i] + stray[1][i];
    back[i] = -mean[0][i];
    size[i] = __builtin_fabs(mean[0][i]) + __builtin_fabs(mean[1][i]) + stray_diagonal[i];
  }
  return is_beyond(mean[0], stray[0], mean[1], stray[1], size, margin) &&
         is_beyond(mean[1], stray[1], diagonal, stray_diagonal, size, margin) &&
         is_beyond(diagonal, stray_diagonal, back, stray[0], size, margin);
}

// Where two blocks of one level are neighbours (or one and the same): true, and their distance in
// blocks along an axis, -1 .. 1.
WEFT_INLINE bool are_neighbours(int a, int b, int blocks, bool wraps, int& step) {
  step = b - a;
  if (wraps && step == blocks - 1) step = -1;
  if (wraps && step == 1 - blocks) step = 1;
  return step >= -1 && step <= 1;
}

// A block with itself, or two neighbours in the window of up to 2 x 2 blocks that holds both.
WEFT_INLINE bool cannot_touch(const DescentQuery& query, const NodePair& pair,
                              DescentCounters& counters) {
  const BoxLevel& level = level_of(*query.a, pair.a);
  if (query.certificate_margin < 0 || level.tangents == nullptr || pair.a.level != pair.b.level) {
    return false;
  }
  const BoxPatch& patch = query.a->patches[level.patch];
  int step_u = 0, step_v = 0;
  if (!are_neighbours(pair.a.u, pair.b.u, 1 << level.log_u, patch.wrap_u != 0, step_u) ||
      !are_neighbours(pair.a.v, pair.b.v, 1 << level.log_v, patch.wrap_v != 0, step_v)) {
    return false;
  }
  ++counters.certificate_tests;
  alignas(64) float bound[16];
  const TangentBounds& own = level.tangents[block_of(level, pair.a)];
  for (int i = 0; i < 16; ++i) bound[i] = own.bound[i];
  const auto join = [&](std::uint16_t u, std::uint16_t v) {
    const TangentBounds& other = level.tangents[block_of(level, {pair.a.level, u, v})];
    for (int i = 0; i < 16; ++i) bound[i] = larger(bound[i], other.bound[i]);
  };
  if (step_u != 0) join(pair.b.u, pair.a.v);
  if (step_v != 0) join(pair.a.u, pair.b.v);
  if (step_u != 0 && step_v != 0) join(pair.b.u, pair.b.v);
  const bool proved = certified(bound, query.certificate_margin);
  counters.certified += proved ? 1 : 0;
  return proved;
}

// --- Leaves
// ------------------------------------------------------------------------------------------

// The leaves of a leaf block, widened: lane 2 r + c holds the first triangle (or the quad) of quad
// (r, c) of the 2 x 2, lane 4 + 2 r + c the second triangle. Lanes without a leaf overlap nothing.
struct alignas(64) Leaves {
  BoxNode node;
  float low[3][8], high[3][8];
  float whole_low[3], whole_high[3];
  alignas(32) int number[8];
  int row, col, rows, cols;  // of the quads
};

WEFT_INLINE int boundary(int k, int count, int log) {
  return static_cast<int>((static_cast<std::int64_t>(k) * count) >> log);
}

struct QuadCornerBounds {
  Quad low[2], high[2];
};

// One axis, at one end: bounds of the first and second triangles of the four quads.
WEFT_INLINE void bound_corners(const VertexImage& image, int axis, const Leaves& leaves,
                               bool triangles, bool join, Quad low[2], Quad high[2]) {
  const float* first = image.component[axis] + leaves.row * image.stride + leaves.col;
  const Quad row0 = load_quad(first);
  const Quad row1 = load_quad(first + image.stride);
  const Quad row2 = load_quad(leaves.rows > 1 ? first + 2 * image.stride : first + image.stride);
  const Quad corner00 = __builtin_shufflevector(row0, row1, 0, 1, 4, 5);
  const Quad corner01 = __builtin_shufflevector(row0, row1, 1, 2, 5, 6);
  const Quad corner10 = __builtin_shufflevector(row1, row2, 0, 1, 4, 5);
  const Quad corner11 = __builtin_shufflevector(row1, row2, 1, 2, 5, 6);
  const Quad diagonal_low = smaller(corner01, corner10);
  const Quad diagonal_high = larger(corner01, corner10);
  Quad first_low = smaller(corner00, diagonal_low), second_low = smaller(corner11, diagonal_low);
  Quad first_high = larger(corner00, diagonal_high), second_high = larger(corner11, diagonal_high);
  if (!triangles) {
    first_low = smaller(first_low, second_low);
    first_high = larger(first_high, second_high);
  }
  low[0] = join ? smaller(low[0], first_low) : first_low;
  low[1] = join ? smaller(low[1], second_low) : second_low;
  high[0] = join ? larger(high[0], first_high) : first_high;
  high[1] = join ? larger(high[1], second_high) : second_high;
}

// Sets the lanes for which there is no leaf to boxes that overlap nothing.
void blank_absent_leaves(Leaves& leaves, bool triangles) {
  for (int lane = 0; lane < 8; ++lane) {
    const bool there =
        lane / 2 % 2 < leaves.rows && lane % 2 < leaves.cols && (triangles || lane < 4);
    if (there) continue;
    for (int axis = 0; axis < 3; ++axis) {
      leaves.low[axis][lane] = largest_float;
      leaves.high[axis][lane] = -largest_float;
    }
  }
}

void make_leaves(const DescentQuery& query, const BoxTree& tree, BoxNode node, Leaves& leaves) {
  const BoxLevel& level = level_of(tree, node);
  const BoxPatch& patch = tree.patches[level.patch];
  leaves.node = node;
  leaves.row = boundary(node.v, patch.quad_rows, level.log_v);
  leaves.rows = boundary(node.v + 1, patch.quad_rows, level.log_v) - leaves.row;
  leaves.col = boundary(node.u, patch.quad_cols, level.log_u);
  leaves.cols = boundary(node.u + 1, patch.quad_cols, level.log_u) - leaves.col;
  for (int axis = 0; axis < 3; ++axis) {
    Quad low[2], high[2];
    bound_corners(patch.vertices[0], axis, leaves, query.triangles, false, low, high);
    if (tree.swept != 0) {
      bound_corners(patch.vertices[1], axis, leaves, query.triangles, true, low, high);
    }
    store(leaves.low[axis],
          __builtin_shufflevector(low[0], low[1], 0, 1, 2, 3, 4, 5, 6, 7) - query.half_margin);
    store(leaves.high[axis],
          __builtin_shufflevector(high[0], high[1], 0, 1, 2, 3, 4, 5, 6, 7) + query.half_margin);
  }
  if (!query.triangles || leaves.rows < 2 || leaves.cols < 2)
    blank_absent_leaves(leaves, query.triangles);
  const WideBox whole = box_of(tree, node, query.half_margin);
  for (int axis = 0; axis < 3; ++axis) {
    leaves.whole_low[axis] = whole.low[axis];
    leaves.whole_high[axis] = whole.high[axis];
  }
  for (int lane = 0; lane < 8; ++lane) {
    const int quad =
        patch.first_quad + (leaves.row + lane / 2 % 2) * patch.quad_cols + leaves.col + lane % 2;
    leaves.number[lane] = query.triangles ? 2 * quad + lane / 4 : quad;
  }
}

// Writes the pairs (a, b[j]), the smaller number first if `sorted`, for the bits j of the mask;
// returns their number. May write up to eight.
WEFT_INLINE int store_pairs(LeafPair* to, unsigned mask, int a, const int b[8], bool sorted) {
#if defined(__AVX512VL__)
  const __m256i of_b = _mm256_load_si256(reinterpret_cast<const __m256i*>(b));
  const __m256i of_a = _mm256_set1_epi32(a);
  const __m256i first = sorted ? _mm256_min_epi32(of_a, of_b) : of_a;
  const __m256i second = sorted ? _mm256_max_epi32(of_a, of_b) : of_b;
  const __m512i pairs = _mm512_or_si512(_mm512_cvtepu32_epi64(first),
                                        _mm512_slli_epi64(_mm512_cvtepu32_epi64(second), 32));
  _mm512_storeu_si512(to, _mm512_maskz_compress_epi64(static_cast<__mmask8>(mask), pairs));
  return __builtin_popcount(mask);
#else
  int count = 0;
  for (; mask != 0; mask &= mask - 1) {
    const int j = __builtin_ctz(mask);
    const bool swap = sorted && a > b[j];
    to[count++] = swap ? LeafPair{b[j], a} : LeafPair{a, b[j]};
  }
  return count;
#endif
}

// A few leaf blocks made last: a descent comes back to each of them a few times.
constexpr int cache_size = 32;
struct LeafCache {
  Leaves entry[cache_size];
};

WEFT_INLINE void clear(LeafCache& cache) {
  for (Leaves& leaves : cache.entry) leaves.node.level = -1;
}

WEFT_INLINE const Leaves& leaves_of(const DescentQuery& query, const BoxTree& tree, BoxNode node,
                                    LeafCache& cache) {
  Leaves& leaves = cache.entry[(node.u + 5U * node.v) % cache_size];
  if (!same(leaves.node, node)) make_leaves(query, tree, node, leaves);
  return leaves;
}

WEFT_INLINE LaneBoxes boxes_of(const Leaves& leaves) {
  LaneBoxes boxes;
  for (int axis = 0; axis < 3; ++axis) {
    boxes.low[axis] = load(leaves.low[axis]);
    boxes.high[axis] = load(leaves.high[axis]);
  }
  return boxes;
}

void particles_of(const BoxTree& tree, const Leaves& leaves, int lane, int particle[3]) {
  const BoxPatch& patch = tree.patches[level_of(tree, leaves.node).patch];
  const auto at = [&](int row, int col) {
    row += leaves.row + lane / 2 % 2;
    col += leaves.col + lane % 2;
    if (row == patch.rows) row = 0;
    if (col == patch.cols) col = 0;
    const int texel = patch.first_texel + row * patch.cols + col;
    return tree.texel_to_particle == nullptr ? texel : tree.texel_to_particle[texel];
  };
  particle[0] = lane < 4 ? at(0, 0) : at(1, 1);
  particle[1] = at(0, 1);
  particle[2] = at(1, 0);
}

bool share_particle(const BoxTree& tree, const Leaves& a, int lane_a, const Leaves& b, int lane_b) {
  int of_a[3], of_b[3];
  particles_of(tree, a, lane_a, of_a);
  particles_of(tree, b, lane_b, of_b);
  for (int i : of_a) {
    for (int j : of_b) {
      if (i == j) return true;
    }
  }
  return false;
}

// --- Triangles that share a vertex
// ------------------------------------------------------------------

// Pairs of lanes of two leaf blocks: bit 8 i + j for lane i of the first and lane j of the second.
typedef std::uint64_t LanePairs;

// Lane pairs of shared[R + 2][C + 2]: in a grid, these triangles of a leaf block and of the one
// that begins R rows and C columns after it share a vertex.
struct SharedVertices {
  LanePairs shared[5][5];
};

constexpr SharedVertices find_shared_vertices() {
  // Row and column of the corners of the first and the second triangle of a quad.
  constexpr int corner[2][3][2] = {{{0, 0}, {0, 1}, {1, 0}}, {{1, 1}, {0, 1}, {1, 0}}};
  SharedVertices table{};
  for (int pair = 0; pair < 25 * 64; ++pair) {
    const int i = pair / 8 % 8, j = pair % 8;
    const int rows = pair / 320 - 2, cols = pair / 64 % 5 - 2;
    for (int corners = 0; corners < 9; ++corners) {
      const int* a = corner[i / 4][corners / 3];
      const int* b = corner[j / 4][corners % 3];
      if (a[0] + i / 2 % 2 == b[0] + j / 2 % 2 + rows && a[1] + i % 2 == b[1] + j % 2 + cols) {
        table.shared[rows + 2][cols + 2] |= LanePairs{1} << (8 * i + j);
      }
    }
  }
  return table;
}

constexpr SharedVertices shared_vertices = find_shared_vertices();

// How the triangles of two leaf blocks that share a particle are told.
struct SharedParticles {
  LanePairs lanes;
  bool look;  // compare the particles themselves instead
};

// From a to b along an axis, the short way round a wrapped one.
WEFT_INLINE int offset(int a, int b, int quads, bool wraps) {
  const int direct = b - a;
  if (!wraps) return direct;
  if (2 * direct > quads) return direct - quads;
  return 2 * direct < -quads ? direct + quads : direct;
}

WEFT_INLINE SharedParticles shared_particles(const DescentQuery& query, const Leaves& a,
                                             const Leaves& b) {
  if (!query.self || !query.triangles) return {0, false};
  const BoxTree& tree = *query.a;
  if (tree.texel_to_particle != nullptr) return {0, true};
  if (a.node.level != b.node.level) return {0, false};  // patches that are not sewn
  const BoxPatch& patch = tree.patches[level_of(tree, a.node).patch];
  // Round a ring as short as this, blocks are neighbours on both sides.
  constexpr int short_ring = 8;
  if ((patch.wrap_u != 0 && patch.quad_cols < short_ring) ||
      (patch.wrap_v != 0 && patch.quad_rows < short_ring)) {
    return {0, true};
  }
  const int rows = offset(a.row, b.row, patch.quad_rows, patch.wrap_v != 0);
  const int cols = offset(a.col, b.col, patch.quad_cols, patch.wrap_u != 0);
  if (rows < -2 || rows > 2 || cols < -2 || cols > 2) return {0, false};
  return {shared_vertices.shared[rows + 2][cols + 2], false};
}

LanePairs without_shared_particles(const BoxTree& tree, const Leaves& a, const Leaves& b,
                                   LanePairs near) {
  LanePairs kept = near;
  for (; near != 0; near &= near - 1) {
    const int pair = __builtin_ctzll(near);
    if (share_particle(tree, a, pair / 8, b, pair % 8)) kept &= ~(LanePairs{1} << pair);
  }
  return kept;
}

// The lane pairs whose boxes overlap; `near_a` has all lanes of the first that can have one.
WEFT_INLINE LanePairs overlap_of_leaves(const Leaves& a, const Leaves& b, unsigned near_a) {
  LanePairs near = 0;
#if defined(__AVX512DQ__)
  static_cast<void>(near_a);
  __m512 low_a[3], high_a[3], low_b[3], high_b[3];
  for (int axis = 0; axis < 3; ++axis) {
    low_a[axis] = _mm512_castps256_ps512(_mm256_load_ps(a.low[axis]));
    high_a[axis] = _mm512_castps256_ps512(_mm256_load_ps(a.high[axis]));
    low_b[axis] = _mm512_broadcast_f32x8(_mm256_load_ps(b.low[axis]));
    high_b[axis] = _mm512_broadcast_f32x8(_mm256_load_ps(b.high[axis]));
  }
  // Two lanes of the first against all of the second at a time.
  __m512i lanes = _mm512_setr_epi32(0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1);
  for (int i = 0; i < 8; i += 2) {
    __mmask16 mask = 0xffff;
    for (int axis = 0; axis < 3; ++axis) {
      mask = _mm512_mask_cmp_ps_mask(mask, _mm512_permutexvar_ps(lanes, low_a[axis]), high_b[axis],
                                     _CMP_LE_OQ);
      mask = _mm512_mask_cmp_ps_mask(mask, low_b[axis], _mm512_permutexvar_ps(lanes, high_a[axis]),
                                     _CMP_LE_OQ);
    }
    near |= static_cast<LanePairs>(mask) << (8 * i);
    lanes = _mm512_add_epi32(lanes, _mm512_set1_epi32(2));
  }
#else
  const LaneBoxes boxes_b = boxes_of(b);
  for (; near_a != 0; near_a &= near_a - 1) {
    const int i = __builtin_ctz(near_a);
    const float low[3] = {a.low[0][i], a.low[1][i], a.low[2][i]};
    const float high[3] = {a.high[0][i], a.high[1][i], a.high[2][i]};
    near |= static_cast<LanePairs>(overlap(in_all_lanes(low, high), boxes_b)) << (8 * i);
  }
#endif
  return near;
}

// Each pair of lanes of one block once.
constexpr LanePairs upper_triangle = 0x80c0e0f0f8fcfeff;
constexpr LanePairs diagonal = 0x8040201008040201;

void pair_leaves(const DescentQuery& query, const NodePair& pair, LeafCache& cache_a,
                 LeafCache& cache_b, PairSink& sink, DescentCounters& counters) {
  const Leaves& a = leaves_of(query, *query.a, pair.a, cache_a);
  const Leaves& b = leaves_of(query, *query.b, pair.b, cache_b);
  const unsigned near_a = overlap(boxes_of(a), in_all_lanes(b.whole_low, b.whole_high));
  counters.box_tests += 8 + 8 * __builtin_popcount(near_a);
  if (near_a == 0) return;
  const SharedParticles shared = shared_particles(query, a, b);
  LanePairs near = overlap_of_leaves(a, b, near_a) & ~shared.lanes;
  // A quad is paired with itself too: it can fold.
  if (query.self && same(pair.a, pair.b)) {
    near &= query.triangles ? upper_triangle & ~diagonal : upper_triangle;
  }
  if (shared.look) near = without_shared_particles(*query.a, a, b, near);
  if (near == 0) return;
  if (sink.count + pairs_a_flush > sink.capacity) sink.flush(sink);
  for (int count = sink.count; near != 0;) {
    const int i = __builtin_ctzll(near) / 8;
    const auto of_lane = static_cast<unsigned>(near >> (8 * i) & 0xff);
    count += store_pairs(sink.pairs + count, of_lane, a.number[i], b.number, query.self);
    near &= ~(LanePairs{0xff} << (8 * i));
    sink.count = count;
  }
}

// --- The descent
// -------------------------------------------------------------------------------------

int expand_itself(const DescentQuery& query, const NodePair& pair, NodePair* next,
                  DescentCounters& counters) {
  const BoxLevel& level = level_of(*query.a, pair.a);
  const BoxGroup& group = level.groups[block_of(level, pair.a)];
  const unsigned near = overlap_of_children(group, group, query.half_margin);
  counters.box_tests += 6;
  int count = 0;
  for (int i = 0; i < 4; ++i) {
    // A child that is not there does not even meet itself.
    for (int j = i; j < 4; ++j) {
      if ((near >> (4 * i + j) & 1U) == 0) continue;
      next[count++] = {child_of(level, pair.a, i), child_of(level, pair.a, j)};
    }
  }
  return count;
}

int expand_pair(const DescentQuery& query, const NodePair& pair, NodePair* next,
                DescentCounters& counters) {
  if (query.self && cannot_touch(query, pair, counters)) return 0;
  const BoxLevel& level_a = level_of(*query.a, pair.a);
  const BoxLevel& level_b = level_of(*query.b, pair.b);
  const bool leaf_a = is_leaf(level_a), leaf_b = is_leaf(level_b);
  if (leaf_a && leaf_b) return -1;
  if (query.self && same(pair.a, pair.b)) return expand_itself(query, pair, next, counters);
  int count = 0;
  if (!leaf_a && !leaf_b) {
    counters.box_tests += 16;
    unsigned near =
        overlap_of_children(level_a.groups[block_of(level_a, pair.a)],
                            level_b.groups[block_of(level_b, pair.b)], query.half_margin);
    for (; near != 0; near &= near - 1) {
      const int bit = __builtin_ctz(near);
      next[count++] = {child_of(level_a, pair.a, bit >> 2), child_of(level_b, pair.b, bit & 3)};
    }
    return count;
  }
  counters.box_tests += 4;
  const BoxTree& whole_tree = leaf_a ? *query.a : *query.b;
  const WideBox whole = box_of(whole_tree, leaf_a ? pair.a : pair.b, query.half_margin);
  const BoxLevel& split = leaf_a ? level_b : level_a;
  const BoxNode node = leaf_a ? pair.b : pair.a;
  unsigned near = overlap_of_box(whole, split.groups[block_of(split, node)], query.half_margin);
  for (; near != 0; near &= near - 1) {
    const BoxNode child = child_of(split, node, __builtin_ctz(near));
    next[count++] = leaf_a ? NodePair{pair.a, child} : NodePair{child, pair.b};
  }
  return count;
}

// Every step takes one pair off and puts at most sixteen on, on at most 2 x 17 levels.
constexpr int stack_size = 16 * 2 * 18;

void descend(const DescentQuery& query, const NodePair& start, PairSink& sink,
             DescentCounters& counters) {
  NodePair stack[stack_size];
  LeafCache cache_a, cache_b;
  clear(cache_a);
  clear(cache_b);
  int count = 0;
  stack[count++] = start;
  while (count > 0) {
    const NodePair pair = stack[--count];
    const int expanded = expand_pair(query, pair, stack + count, counters);
    if (expanded >= 0) {
      count += expanded;
    } else {
      pair_leaves(query, pair, cache_a, cache_b, sink, counters);
    }
  }
}

// --- Points
// ------------------------------------------------------------------------------------------

// The widened boxes of eight points of a list, and by how much each is widened.
struct PointLanes {
  LaneBoxes boxes;
  Lanes half;
};

WEFT_INLINE PointLanes point_lanes(const PointSet& points, const std::int32_t* list) {
  alignas(32) float x[8], y[8], z[8], half[8];
  for (int i = 0; i < 8; ++i) {
    x[i] = points.x[list[i]];
    y[i] = points.y[list[i]];
    z[i] = points.z[list[i]];
    half[i] = points.half[list[i]];
  }
  const Lanes h = load(half);
  return {{{load(x) - h, load(y) - h, load(z) - h}, {load(x) + h, load(y) + h, load(z) + h}}, h};
}

WEFT_INLINE int store_marked(std::int32_t* to, unsigned mask, const std::int32_t* list) {
#if defined(__AVX512VL__)
  const __m256i all = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(list));
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(to),
                      _mm256_maskz_compress_epi32(static_cast<__mmask8>(mask), all));
  return __builtin_popcount(mask);
#else
  int count = 0;
  for (; mask != 0; mask &= mask - 1) to[count++] = list[__builtin_ctz(mask)];
  return count;
#endif
}

// Some points of the set, by their numbers, that come near a block.
struct PointList {
  BoxNode node;
  std::int32_t first, count;  // in the workspace
};

// The lists of the children of a block, one after the other from `end` on; the workspace may be
// written and read eight numbers past the end of a list.
int share_points(const BoxGroup& group, const BoxLevel& level, const PointSet& points,
                 const PointList& list, std::int32_t* workspace, PointList* next) {
  const std::int32_t end = list.first + list.count + 8;
  std::int32_t counts[4] = {};
  for (int i = 0; i < list.count; i += 8) {
    const std::int32_t* from = workspace + list.first + i;
    const PointLanes lanes = point_lanes(points, from);
    const unsigned there = list.count - i < 8 ? (1U << (list.count - i)) - 1 : 0xffU;
    for (int child = 0; child < 4; ++child) {
      LaneBoxes box;
      for (int axis = 0; axis < 3; ++axis) {
        box.low[axis] = broadcast(group.low[axis][child]) - lanes.half;
        box.high[axis] = broadcast(group.high[axis][child]) + lanes.half;
      }
      std::int32_t* to = workspace + end + child * (list.count + 8) + counts[child];
      counts[child] += store_marked(to, overlap(box, lanes.boxes) & there, from);
    }
  }
  int lists = 0;
  for (int child = 0; child < 4; ++child) {
    if (counts[child] == 0) continue;
    next[lists++] = {child_of(level, list.node, child), end + child * (list.count + 8),
                     counts[child]};
  }
  return lists;
}

void pair_points(const DescentQuery& query, const PointSet& points, const PointList& list,
                 const std::int32_t* workspace, int first_number, PairSink& sink) {
  Leaves leaves;
  make_leaves(query, *query.a, list.node, leaves);
  for (int i = list.first; i < list.first + list.count; ++i) {
    const int point = workspace[i];
    const float half = points.half[point];
    const float at[3] = {points.x[point], points.y[point], points.z[point]};
    LaneBoxes boxes = boxes_of(leaves), box;
    for (int axis = 0; axis < 3; ++axis) {
      boxes.low[axis] -= half;
      boxes.high[axis] += half;
      box.low[axis] = broadcast(at[axis] - half);
      box.high[axis] = broadcast(at[axis] + half);
    }
    if (sink.count + pairs_a_flush > sink.capacity) sink.flush(sink);
    sink.count += store_pairs(sink.pairs + sink.count, overlap(boxes, box), first_number + point,
                              leaves.number, false);
  }
}

void descend_points(const DescentQuery& query, int patch, const PointSet& points, int first_number,
                    std::int32_t* workspace, PairSink& sink, DescentCounters& counters) {
  const BoxTree& tree = *query.a;
  PointList stack[4 * 18];
  for (int i = 0; i < points.count + 8; ++i) workspace[i] = i < points.count ? i : 0;
  stack[0] = {{tree.patches[patch].first_level, 0, 0}, 0, points.count};
  for (int count = 1; count > 0;) {
    const PointList list = stack[--count];
    const BoxLevel& level = level_of(tree, list.node);
    // Numbers read past the end of a list need only be those of points.
    for (int i = 0; i < 8; ++i) workspace[list.first + list.count + i] = 0;
    if (is_leaf(level)) {
      counters.box_tests += 8 * list.count;
      pair_points(query, points, list, workspace, first_number, sink);
    } else {
      counters.box_tests += 4 * list.count;
      const BoxGroup& group = level.groups[block_of(level, list.node)];
      count += share_points(group, level, points, list, workspace, stack + count);
    }
  }
}

}  // namespace

extern const DescentKernels descent_kernels;
const DescentKernels descent_kernels = {expand_pair, descend, descend_points};

}  // namespace weft::bsi::WEFT_KERNELS
