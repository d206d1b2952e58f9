// Judges the triangle pairs of leaf blocks, one pair per lane. Vertices are read block by block and
// distributed to the lanes. Compiled once per instruction set: see bsi/detail/instruction_set.h.
#include "bsi/kernels/block_judge_kernels.h"

#include "bsi/kernels/leaf_quads.h"
#include "bsi/kernels/triangle_lanes.h"

namespace weft::bsi::WEFT_KERNELS {

namespace {

constexpr int lanes = lane_count<float>;

// The vertices of a leaf block, at most 3 x 3, by axis. Vertex (r, c) is at index 4 r + c.
struct alignas(64) BlockVertices {
  float value[3][16];
};

WEFT_INLINE void read_vertices(const BoxTree& tree, BoxNode node, BlockVertices& vertices) {
  const BoxPatch& patch = tree.patches[tree.levels[node.level].patch];
  const LeafQuads quads = quads_of(tree, node);
  for (int axis = 0; axis < 3; ++axis) {
    const VertexImage& image = patch.vertices[0];
    for (int row = 0; row < 3; ++row) {
      const int there = row <= quads.rows ? row : quads.rows;
      const float* from = image.component[axis] + (quads.row + there) * image.stride + quads.col;
      __builtin_memcpy(vertices.value[axis] + 4 * row, from, 4 * sizeof(float));
    }
  }
}

// Indices in BlockVertices of the corners of leaves, by corner and leaf. Leaf 4 k + 2 r + c is
// triangle k of the quad in row r and column c. The two triangles of a quad share their last two
// corners.
constexpr int corner_vertex[3][8] = {
    {0, 1, 4, 5, 5, 6, 9, 10}, {1, 2, 5, 6, 1, 2, 5, 6}, {4, 5, 8, 9, 4, 5, 8, 9}};

// The data of a leaf block from which its triangle pairs are judged.
struct Block {
  BlockVertices vertices;
  alignas(32) int number[8];  // triangle index of each leaf
};

WEFT_INLINE void read_block(const BoxTree& tree, BoxNode node, Block& block) {
  read_vertices(tree, node, block.vertices);
  number_leaves(tree, node, true, block.number);
}

// Largest number of pairs of blocks in a chunk.
constexpr int slots = 32;
// A chunk of pairs of blocks and their pairs of triangles. Entry 64 s + 8 i + j stands for leaf i
// of the first block and leaf j of the second block of pair s.
struct Chunk {
  Block a[slots], b[slots];
  int of_a[slots];  // index in `a` of each pair's first block, which consecutive pairs may share
  alignas(64) int entry[64 * slots + 16];
  int count;
};

// The corners of triangle pairs, one pair per lane, relative to corner 0 of the first triangle.
struct Corners {
  Lanes3<Lanes<float>> a[3], b[3];
};

#if defined(__AVX512DQ__)

// Lists `base` + i for each set bit i, in ascending order, and returns the number of set bits. May
// write up to sixteen entries past the end.
WEFT_INLINE int list_bits(std::uint64_t bits, int base, int* list) {
  const __m512i first = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
  int count = 0;
#pragma GCC unroll 4
  for (int part = 0; part < 4; ++part) {
    const auto mask = static_cast<__mmask16>(bits >> (16 * part));
    _mm512_storeu_si512(list + count,
                        _mm512_maskz_compress_epi32(
                            mask, _mm512_add_epi32(first, _mm512_set1_epi32(base + 16 * part))));
    count += __builtin_popcount(mask);
  }
  return count;
}

WEFT_INLINE __m512i in_both_halves(const int* eight) {
  return _mm512_broadcast_i32x8(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(eight)));
}

WEFT_INLINE void store_numbers(__m512i a, __m512i b, bool sorted, LeafPair* to) {
  const __m512i first = sorted ? _mm512_min_epi32(a, b) : a;
  const __m512i second = sorted ? _mm512_max_epi32(a, b) : b;
  for (int half = 0; half < 2; ++half) {
    const __m512i low = _mm512_cvtepu32_epi64(half == 0 ? _mm512_castsi512_si256(first)
                                                        : _mm512_extracti32x8_epi32(first, 1));
    const __m512i high = _mm512_cvtepu32_epi64(half == 0 ? _mm512_castsi512_si256(second)
                                                         : _mm512_extracti32x8_epi32(second, 1));
    _mm512_storeu_si512(to + 8 * half, _mm512_or_si512(low, _mm512_slli_epi64(high, 32)));
  }
}

// Loads the triangle pairs of 16 entries. Vertices are permuted to the lanes block by block,
// because gathers would take several times as long.
WEFT_INLINE void load_pairs(const Chunk& chunk, const int* entries, Corners& corners) {
  const __m512i entry = _mm512_loadu_si512(entries), slot = _mm512_srli_epi32(entry, 6);
  const __m512i seven = _mm512_set1_epi32(7);
  const __m512i i = _mm512_and_si512(_mm512_srli_epi32(entry, 3), seven);
  const __m512i j = _mm512_and_si512(entry, seven);
  __m512i vertex_a[3], vertex_b[3];
#pragma GCC unroll 3
  for (int k = 0; k < 3; ++k) {
    const __m512i vertex = in_both_halves(corner_vertex[k]);
    vertex_a[k] = _mm512_permutexvar_epi32(i, vertex);
    vertex_b[k] = _mm512_permutexvar_epi32(j, vertex);
  }
  __m512 a[3][3] = {}, b[3][3] = {};  // coordinates by axis and corner
  for (unsigned left = 0xffff; left != 0;) {
    const int s = entries[__builtin_ctz(left)] >> 6;
    const __mmask16 mask = _mm512_cmpeq_epi32_mask(slot, _mm512_set1_epi32(s));
    left &= ~static_cast<unsigned>(mask);
    const BlockVertices& of_a = chunk.a[chunk.of_a[s]].vertices;
    const BlockVertices& of_b = chunk.b[s].vertices;
#pragma GCC unroll 3
    for (int axis = 0; axis < 3; ++axis) {
      const __m512 all_a = _mm512_load_ps(of_a.value[axis]);
      const __m512 all_b = _mm512_load_ps(of_b.value[axis]);
#pragma GCC unroll 3
      for (int k = 0; k < 3; ++k) {
        a[axis][k] = _mm512_mask_permutexvar_ps(a[axis][k], mask, vertex_a[k], all_a);
        b[axis][k] = _mm512_mask_permutexvar_ps(b[axis][k], mask, vertex_b[k], all_b);
      }
    }
  }
  corners.a[0] = Lanes3<Lanes<float>>{};
#pragma GCC unroll 3
  for (int k = 0; k < 3; ++k) {
    if (k > 0) corners.a[k] = {a[0][k] - a[0][0], a[1][k] - a[1][0], a[2][k] - a[2][0]};
    corners.b[k] = {b[0][k] - a[0][0], b[1][k] - a[1][0], b[2][k] - a[2][0]};
  }
}

// Writes the triangle indices of `count` entries, all of which belong to pair of blocks s.
WEFT_INLINE void number_pairs(const Chunk& chunk, int s, const int* entries, int count, bool sorted,
                              LeafPair* pairs) {
  const __m512i seven = _mm512_set1_epi32(7);
  const __m512i of_a = in_both_halves(chunk.a[chunk.of_a[s]].number);
  const __m512i of_b = in_both_halves(chunk.b[s].number);
  for (int k = 0; k < count; k += 16) {
    const __m512i entry = _mm512_loadu_si512(entries + k);
    const __m512i i = _mm512_and_si512(_mm512_srli_epi32(entry, 3), seven);
    const __m512i j = _mm512_and_si512(entry, seven);
    store_numbers(_mm512_permutexvar_epi32(i, of_a), _mm512_permutexvar_epi32(j, of_b), sorted,
                  pairs + k);
  }
}

// Lists first + l for each marked lane l and returns the number of marked lanes. May write sixteen
// entries, however many lanes are marked.
WEFT_INLINE int list_lanes(unsigned marked, int first, int* list) {
  const __m512i lane = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
  _mm512_storeu_si512(
      list, _mm512_maskz_compress_epi32(static_cast<__mmask16>(marked),
                                        _mm512_add_epi32(lane, _mm512_set1_epi32(first))));
  return __builtin_popcount(marked);
}

// Stores one verdict per lane. Returns a mask of the undecided lanes.
WEFT_INLINE unsigned store_verdicts(__m512 result, Verdict* verdict) {
  const __m512i number = _mm512_cvttps_epi32(result);
  _mm_storeu_si128(reinterpret_cast<__m128i*>(verdict), _mm512_cvtepi32_epi8(number));
  return _mm512_cmpeq_epi32_mask(number, _mm512_set1_epi32(static_cast<int>(Verdict::undecided)));
}

// Copies the pairs whose verdict is `wanted`, in order, and returns the number of copies. May write
// up to eight pairs past the end.
WEFT_INLINE int select(const LeafPair* pairs, const Verdict* verdict, int count, Verdict wanted,
                       LeafPair* to) {
  int selected = 0;
  const __m128i value = _mm_set1_epi8(static_cast<char>(wanted));
  for (int k = 0; k < count; k += 8) {
    unsigned mask =
        _mm_cmpeq_epi8_mask(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(verdict + k)), value);
    mask &= count - k < 8 ? (1U << (count - k)) - 1 : 0xffU;
    _mm512_storeu_si512(to + selected,
                        _mm512_maskz_compress_epi64(
                            static_cast<__mmask8>(mask),
                            _mm512_maskz_loadu_epi64(static_cast<__mmask8>(mask), pairs + k)));
    selected += __builtin_popcount(mask);
  }
  return selected;
}

#else

WEFT_INLINE int list_bits(std::uint64_t bits, int base, int* list) {
  int count = 0;
  for (; bits != 0; bits &= bits - 1) list[count++] = base + __builtin_ctzll(bits);
  return count;
}

WEFT_INLINE void load_pairs(const Chunk& chunk, const int* entries, Corners& corners) {
  alignas(64) float a[3][3][lanes], b[3][3][lanes];  // coordinates by corner and axis
  for (int lane = 0; lane < lanes; ++lane) {
    const int s = entries[lane] >> 6, i = entries[lane] >> 3 & 7, j = entries[lane] & 7;
    const BlockVertices& of_a = chunk.a[chunk.of_a[s]].vertices;
    const BlockVertices& of_b = chunk.b[s].vertices;
    for (int axis = 0; axis < 3; ++axis) {
      const float origin = of_a.value[axis][corner_vertex[0][i]];
      for (int k = 0; k < 3; ++k) {
        a[k][axis][lane] = of_a.value[axis][corner_vertex[k][i]] - origin;
        b[k][axis][lane] = of_b.value[axis][corner_vertex[k][j]] - origin;
      }
    }
  }
  const auto load = [](const float(&values)[3][lanes]) {
    using V = Lanes<float>;
    return Lanes3<V>{*reinterpret_cast<const V*>(values[0]), *reinterpret_cast<const V*>(values[1]),
                     *reinterpret_cast<const V*>(values[2])};
  };
  for (int k = 0; k < 3; ++k) {
    corners.a[k] = load(a[k]);
    corners.b[k] = load(b[k]);
  }
}

WEFT_INLINE void number_pairs(const Chunk& chunk, int s, const int* entries, int count, bool sorted,
                              LeafPair* pairs) {
  for (int k = 0; k < count; ++k) {
    const int a = chunk.a[chunk.of_a[s]].number[entries[k] >> 3 & 7];
    const int b = chunk.b[s].number[entries[k] & 7];
    pairs[k] = sorted && b < a ? LeafPair{b, a} : LeafPair{a, b};
  }
}

WEFT_INLINE int list_lanes(unsigned marked, int first, int* list) {
  int count = 0;
  for (; marked != 0; marked &= marked - 1) list[count++] = first + __builtin_ctz(marked);
  return count;
}

template <class V>
WEFT_INLINE unsigned store_verdicts(const V& result, Verdict* verdict) {
  unsigned undecided = 0;
  for (int lane = 0; lane < lanes; ++lane) {
    verdict[lane] = static_cast<Verdict>(static_cast<unsigned char>(result[lane]));
    undecided |= verdict[lane] == Verdict::undecided ? 1U << lane : 0U;
  }
  return undecided;
}

// Writes every pair, but advances the destination only past wanted pairs. A branch would often be
// mispredicted, because verdicts are nearly random.
WEFT_INLINE int select(const LeafPair* pairs, const Verdict* verdict, int count, Verdict wanted,
                       LeafPair* to) {
  int selected = 0;
  for (int k = 0; k < count; ++k) {
    to[selected] = pairs[k];
    selected += verdict[k] == wanted ? 1 : 0;
  }
  return selected;
}

#endif

// Lists the triangle pairs of `blocks` in chunk.entry, and writes their triangle indices to
// `pairs`.
void fill_chunk(const JudgedBlocks& judged, const LeafBlockPair* blocks, int block_count,
                Chunk& chunk, LeafPair* pairs) {
  chunk.count = 0;
  for (int s = 0; s < block_count; ++s) {
    const BoxNode a = blocks[s].a, b = blocks[s].b;
    const bool again = s > 0 && a.level == blocks[s - 1].a.level && a.u == blocks[s - 1].a.u &&
                       a.v == blocks[s - 1].a.v;
    chunk.of_a[s] = again ? chunk.of_a[s - 1] : s;
    if (!again) read_block(*judged.a, a, chunk.a[s]);
    read_block(*judged.b, b, chunk.b[s]);
    int* entries = chunk.entry + chunk.count;
    const int count = list_bits(blocks[s].leaves, 64 * s, entries);
    number_pairs(chunk, s, entries, count, judged.self, pairs + chunk.count);
    chunk.count += count;
  }
  // Repeats the last entry to fill the last vector.
  for (int k = chunk.count; k % lanes != 0; ++k) chunk.entry[k] = chunk.entry[chunk.count - 1];
}

// Decides most pairs by the cheap tests of sifted(). The undecided pairs are then packed into full
// vectors, and their distances are computed.
void judge_chunk(const Chunk& chunk, float margin_low, float margin_high, Verdict* verdict) {
  int open[64 * slots + 16];
  int open_count = 0;
  Corners corners;
  for (int k = 0; k < chunk.count; k += lanes) {
    load_pairs(chunk, chunk.entry + k, corners);
    const auto result = sifted(corners.a, corners.b, margin_low, margin_high);
    unsigned undecided = store_verdicts(result, verdict + k);
    if (chunk.count - k < lanes) undecided &= (1U << (chunk.count - k)) - 1;
    open_count += list_lanes(undecided, k, open + open_count);
  }
  for (int k = 0; k < open_count; k += lanes) {
    alignas(64) int entries[lanes];
    for (int lane = 0; lane < lanes; ++lane)
      entries[lane] = chunk.entry[open[k + lane < open_count ? k + lane : open_count - 1]];
    load_pairs(chunk, entries, corners);
    const auto frame = frame_of<float>(corners.a, corners.b);
    Verdict settled[lanes];
    store_verdicts(verdict_of(frame, nearest_points<float>(frame), margin_low, margin_high),
                   settled);
    for (int lane = 0; lane < lanes && k + lane < open_count; ++lane)
      verdict[open[k + lane]] = settled[lane];
  }
}

int judge(const JudgedBlocks& judged, float margin_low, float margin_high, LeafPair* pairs,
          Verdict* verdict) {
  Chunk chunk;
  int count = 0;
  for (int k = 0; k < judged.count; k += slots) {
    const int blocks = judged.count - k < slots ? judged.count - k : slots;
    fill_chunk(judged, judged.blocks + k, blocks, chunk, pairs + count);
    judge_chunk(chunk, margin_low, margin_high, verdict + count);
    count += chunk.count;
  }
  return count;
}

int select_pairs(const LeafPair* pairs, const Verdict* verdict, int count, Verdict wanted,
                 LeafPair* to) {
  return select(pairs, verdict, count, wanted, to);
}

}  // namespace

extern const BlockJudgeKernels block_judge_kernels;
const BlockJudgeKernels block_judge_kernels{judge, select_pairs};

}  // namespace weft::bsi::WEFT_KERNELS
