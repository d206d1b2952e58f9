// Compiled once for every instruction set: see instruction_set.h for what that forbids.
#include "bsi/sphere_kernels.h"

#include "bsi/sphere_bounds.h"
#include "bsi/wide_lanes.h"

namespace weft::bsi::WEFT_KERNELS {

namespace {

// Not negative and not a number count as large.
struct LimitCheck {
  WideBits largest{};
  void add(Wide value) {
    const WideBits bits = magnitude_bits(value);
    largest = bits > largest ? bits : largest;
  }
  bool stays_below(float limit) const {
    bool below = true;
    for (int i = 0; i < width; ++i) {
      // As a number again: the bits of magnitudes are in the order of the magnitudes.
      below = below && __builtin_bit_cast(float, static_cast<std::int32_t>(largest[i])) < limit;
    }
    return below;
  }
};

bool load_vertices(const double* positions, const std::int32_t* particle, int count, float limit,
                   float* const component[3]) {
  if (particle == nullptr && count >= width) {
    LimitCheck check;
    // The last vector overlaps the one before, rather than what follows the row.
    for (int i = 0; i < count;
         i = i + width < count && i + 2 * width > count ? count - width : i + width) {
      const Wide a = load_rounded(positions + 3 * i);
      const Wide b = load_rounded(positions + 3 * i + width);
      const Wide c = load_rounded(positions + 3 * i + 2 * width);
      check.add(a);
      check.add(b);
      check.add(c);
      store_wide(component[0] + i, every_third<0>(a, b, c));
      store_wide(component[1] + i, every_third<1>(a, b, c));
      store_wide(component[2] + i, every_third<2>(a, b, c));
    }
    return check.stays_below(limit);
  }
  bool below = true;
  for (int i = 0; i < count; ++i) {
    const double* position =
        positions + 3 * static_cast<std::ptrdiff_t>(particle == nullptr ? i : particle[i]);
    for (int axis = 0; axis < 3; ++axis) {
      component[axis][i] = static_cast<float>(position[axis]);
      below = below & (__builtin_fabsf(component[axis][i]) < limit);
    }
  }
  return below;
}

void copy_runs(const float* row, const std::int32_t* from, const std::int32_t* length, int runs,
               float* out) {
  for (int run = 0; run < runs; ++run) {
    const float* source = row + from[run];
    // What is written beyond the run is written again by the next.
    for (int i = 0; i < length[run]; i += 4) {
      *reinterpret_cast<UnalignedQuad*>(out + i) = load_quad(source + i);
    }
    out += length[run];
  }
}

struct Vertices {
  Wide component[3];
};

WEFT_INLINE Vertices vertices(const SphereVertexRow& row, int i) {
  return {load_wide(row.component[0] + i), load_wide(row.component[1] + i),
          load_wide(row.component[2] + i)};
}

struct Boxes {
  Wide low[3], high[3];
};

WEFT_INLINE Boxes join(const Boxes& a, const Boxes& b) {
  return {smaller(a.low[0], b.low[0]),  smaller(a.low[1], b.low[1]),  smaller(a.low[2], b.low[2]),
          larger(a.high[0], b.high[0]), larger(a.high[1], b.high[1]), larger(a.high[2], b.high[2])};
}

WEFT_INLINE Boxes box_of(const Vertices& a, const Vertices& b) {
  return join(Boxes{a.component[0], a.component[1], a.component[2], a.component[0], a.component[1],
                    a.component[2]},
              Boxes{b.component[0], b.component[1], b.component[2], b.component[0], b.component[1],
                    b.component[2]});
}

WEFT_INLINE Vertices middle(const Boxes& box) {
  return {0.5F * (box.low[0] + box.high[0]), 0.5F * (box.low[1] + box.high[1]),
          0.5F * (box.low[2] + box.high[2])};
}

WEFT_INLINE Wide squared_distance(const Vertices& a, const Vertices& b) {
  return square(a.component[0] - b.component[0], a.component[1] - b.component[1],
                a.component[2] - b.component[2]);
}

// |x| + |y| + |z|.
WEFT_INLINE Wide sum_of_magnitudes(const Vertices& a) {
  return magnitude(a.component[0]) + magnitude(a.component[1]) + magnitude(a.component[2]);
}

// Radii that cover float64 vertices whose float32 roundings reach so far.
WEFT_INLINE Wide covering(Wide reach, const Vertices& centre) {
  return reach * round_up + (sum_of_magnitudes(centre) * centre_rounding + radius_floor);
}

WEFT_INLINE Boxes load_boxes(const SphereRow& row, int i) {
  return {load_wide(row.low[0] + i),  load_wide(row.low[1] + i),  load_wide(row.low[2] + i),
          load_wide(row.high[0] + i), load_wide(row.high[1] + i), load_wide(row.high[2] + i)};
}

WEFT_INLINE void store(const SphereRow& row, int i, const Boxes& box) {
  store_wide(row.low[0] + i, box.low[0]);
  store_wide(row.low[1] + i, box.low[1]);
  store_wide(row.low[2] + i, box.low[2]);
  store_wide(row.high[0] + i, box.high[0]);
  store_wide(row.high[1] + i, box.high[1]);
  store_wide(row.high[2] + i, box.high[2]);
}

// Spheres i and following of a row of `blocks`.
WEFT_INLINE void store_spheres(float* spheres, int i, int blocks, const Vertices& centre,
                               Wide radius) {
  const auto& [x, y, z] = centre.component;
  if (i + width <= blocks) {
    store_alternately(spheres + 4 * i, x, y, z, radius);
    return;
  }
  float all[4 * width];
  store_alternately(all, x, y, z, radius);
  for (int k = 0; k < 4 * (blocks - i); ++k) spheres[4 * i + k] = all[k];
}

// Vertices i and i + 1 of a row at all ends, with their box.
template <int ends>
struct Pairs {
  Vertices left[ends], right[ends];
  Boxes box;
};

template <int ends>
WEFT_INLINE Pairs<ends> load_pairs(const SphereVertexRows& rows, int row, int i) {
  Pairs<ends> pairs;
  for (int end = 0; end < ends; ++end) {
    pairs.left[end] = vertices(rows.row[end][row], i);
    pairs.right[end] = vertices(rows.row[end][row], i + 1);
    const Boxes box = box_of(pairs.left[end], pairs.right[end]);
    pairs.box = end == 0 ? box : join(pairs.box, box);
  }
  return pairs;
}

template <int ends>
WEFT_INLINE Wide squared_reach(const Pairs<ends>& pairs, const Vertices& centre) {
  Wide squared =
      larger(squared_distance(pairs.left[0], centre), squared_distance(pairs.right[0], centre));
  if (ends == 2) {
    squared = larger(squared, larger(squared_distance(pairs.left[ends - 1], centre),
                                     squared_distance(pairs.right[ends - 1], centre)));
  }
  return squared;
}

template <int ends, int quad_rows>
void bound_quads_of(const SphereVertexRows& rows, int blocks, const SphereRow* out,
                    float* const* spheres) {
  for (int i = 0; i < blocks; i += width) {
    Pairs<ends> upper = load_pairs<ends>(rows, 0, i);
    for (int row = 0; row < quad_rows; ++row) {
      const Pairs<ends> lower = load_pairs<ends>(rows, row + 1, i);
      const Boxes box = join(upper.box, lower.box);
      const Vertices centre = middle(box);
      const Wide squared = larger(squared_reach(upper, centre), squared_reach(lower, centre));
      const Wide radius = covering(square_root(squared), centre);
      store(out[row], i, box);
      store_wide(out[row].diameter + i, radius + radius);
      store_spheres(spheres[row], i, blocks, centre, radius);
      upper = lower;
    }
  }
}

void bound_quads(const SphereVertexRows& rows, int blocks, const SphereRow* out,
                 float* const* spheres) {
  if (rows.ends == 1) {
    rows.row_count == 3 ? bound_quads_of<1, 2>(rows, blocks, out, spheres)
                        : bound_quads_of<1, 1>(rows, blocks, out, spheres);
  } else {
    rows.row_count == 3 ? bound_quads_of<2, 2>(rows, blocks, out, spheres)
                        : bound_quads_of<2, 1>(rows, blocks, out, spheres);
  }
}

// The spheres of one triangle of every quad, the second (right upper, right lower, left lower) or
// the first (left upper, right upper, left lower), as quad_triangles says.
template <bool second>
WEFT_INLINE void bound_triangle(const SphereVertexRows& rows, int i, float* spheres) {
  Boxes box{};
  for (int end = 0; end < rows.ends; ++end) {
    const Vertices right = vertices(rows.row[end][0], i + 1), left = vertices(rows.row[end][1], i);
    const Vertices third =
        second ? vertices(rows.row[end][1], i + 1) : vertices(rows.row[end][0], i);
    const Boxes of_end = join(box_of(left, right), box_of(third, third));
    box = end == 0 ? of_end : join(box, of_end);
  }
  const Vertices centre = middle(box);
  Wide squared{};
  for (int end = 0; end < rows.ends; ++end) {
    const Vertices right = vertices(rows.row[end][0], i + 1), left = vertices(rows.row[end][1], i);
    const Vertices third =
        second ? vertices(rows.row[end][1], i + 1) : vertices(rows.row[end][0], i);
    squared = larger(squared, squared_distance(right, centre));
    squared = larger(squared, squared_distance(left, centre));
    squared = larger(squared, squared_distance(third, centre));
  }
  const auto& [x, y, z] = centre.component;
  store_alternately(spheres, x, y, z, covering(square_root(squared), centre));
}

void bound_triangles(const SphereVertexRows& rows, int blocks, float* spheres) {
  float first[4 * width], second[4 * width];
  for (int i = 0; i < blocks; i += width) {
    bound_triangle<false>(rows, i, first);
    bound_triangle<true>(rows, i, second);
    for (int k = 0; k < width && i + k < blocks; ++k) {
      for (int part = 0; part < 4; ++part) {
        spheres[8 * (i + k) + part] = first[4 * k + part];
        spheres[8 * (i + k) + 4 + part] = second[4 * k + part];
      }
    }
  }
}

// Twice the distance of the middles of children from those of their parents, of which `sum` is
// twice the middle, and twice the children's radii.
WEFT_INLINE Wide double_reach(const Boxes& child, const Wide* sum, const float* diameter) {
  return square_root(square(child.low[0] + child.high[0] - sum[0],
                            child.low[1] + child.high[1] - sum[1],
                            child.low[2] + child.high[2] - sum[2])) +
         load_wide(diameter);
}

// Boxes of neighbours 2 k and 2 k + 1 joined.
WEFT_INLINE Boxes join_neighbours(const Boxes& a, const Boxes& b) {
  Boxes joined;
  for (int axis = 0; axis < 3; ++axis) {
    joined.low[axis] = smaller(even(a.low[axis], b.low[axis]), odd(a.low[axis], b.low[axis]));
    joined.high[axis] = larger(even(a.high[axis], b.high[axis]), odd(a.high[axis], b.high[axis]));
  }
  return joined;
}

// Stores parents, given how far their children reach, twice.
WEFT_INLINE void store_parents(const Boxes& box, Wide reach, int i, int blocks,
                               const SphereRow& out, float* spheres) {
  const Vertices centre = middle(box);
  const Wide diagonal = square_root(
      square(box.high[0] - box.low[0], box.high[1] - box.low[1], box.high[2] - box.low[2]));
  const Wide of_children = reach * (0.5F * round_up) + radius_floor;
  const Wide of_box =
      diagonal * (0.5F * round_up) + (sum_of_magnitudes(centre) * box_rounding + radius_floor);
  const Wide radius = smaller(of_children, of_box);
  store(out, i, box);
  store_wide(out.diameter + i, radius + radius);
  store_spheres(spheres, i, blocks, centre, radius);
}

// Children are taken in the order in which they lie: two vectors of each row are a vector of
// parents.
WEFT_INLINE void merge_two(const SphereRow& upper, const SphereRow& lower, int i, int blocks,
                           const SphereRow& out, float* spheres) {
  const int left = 2 * i, right = 2 * i + width;
  const Boxes up_left = load_boxes(upper, left), up_right = load_boxes(upper, right);
  const Boxes down_left = load_boxes(lower, left), down_right = load_boxes(lower, right);
  const Boxes box = join_neighbours(join(up_left, down_left), join(up_right, down_right));
  Wide left_sum[3], right_sum[3];
  for (int axis = 0; axis < 3; ++axis) {
    const Wide sum = box.low[axis] + box.high[axis];
    left_sum[axis] = alternate_first(sum, sum);
    right_sum[axis] = alternate_second(sum, sum);
  }
  const Wide left_reach = larger(double_reach(up_left, left_sum, upper.diameter + left),
                                 double_reach(down_left, left_sum, lower.diameter + left));
  const Wide right_reach = larger(double_reach(up_right, right_sum, upper.diameter + right),
                                  double_reach(down_right, right_sum, lower.diameter + right));
  const Wide reach = larger(even(left_reach, right_reach), odd(left_reach, right_reach));
  store_parents(box, reach, i, blocks, out, spheres);
}

WEFT_INLINE void merge_one(const SphereRow& upper, const SphereRow& lower, int i, int blocks,
                           const SphereRow& out, float* spheres) {
  const Boxes up = load_boxes(upper, i), down = load_boxes(lower, i);
  const Boxes box = join(up, down);
  const Wide sum[3] = {box.low[0] + box.high[0], box.low[1] + box.high[1],
                       box.low[2] + box.high[2]};
  const Wide reach = larger(double_reach(up, sum, upper.diameter + i),
                            double_reach(down, sum, lower.diameter + i));
  store_parents(box, reach, i, blocks, out, spheres);
}

void merge(const SphereRow& upper, const SphereRow& lower, bool split_u, int blocks,
           const SphereRow& out, float* spheres) {
  for (int i = 0; i < blocks; i += width) {
    split_u ? merge_two(upper, lower, i, blocks, out, spheres)
            : merge_one(upper, lower, i, blocks, out, spheres);
  }
}

void merge_boxes(const SphereRow& upper, const SphereRow& lower, bool split_u, int blocks,
                 const SphereRow& out) {
  for (int i = 0; i < blocks; i += width) {
    if (split_u) {
      const int left = 2 * i, right = 2 * i + width;
      store(out, i,
            join_neighbours(join(load_boxes(upper, left), load_boxes(lower, left)),
                            join(load_boxes(upper, right), load_boxes(lower, right))));
    } else {
      store(out, i, join(load_boxes(upper, i), load_boxes(lower, i)));
    }
  }
}

void spread_centres(const SphereRow& row, int log, int columns, float* const centre[3]) {
  const int step = 1 << log;
  for (int axis = 0; axis < 3; ++axis) {
    float* out = centre[axis];
    for (int i = 0; i < columns; i += width * step) {
      Wide spread[8];
      const int block = i >> log;
      spread[0] = 0.5F * (load_wide(row.low[axis] + block) + load_wide(row.high[axis] + block));
      for (int count = 1; count < step; count *= 2) {
        for (int k = count - 1; k >= 0; --k) {
          const Wide values = spread[k];
          spread[2 * k] = alternate_first(values, values);
          spread[2 * k + 1] = alternate_second(values, values);
        }
      }
      for (int k = 0; k < step && i + k * width < columns; ++k) {
        store_wide(out + i + k * width, spread[k]);
      }
    }
  }
}

void reach(const SphereVertexRow& row, const float* const centre[3], int columns, float* squared) {
  const SphereVertexRow centres{{centre[0], centre[1], centre[2]}};
  for (int i = 0; i < columns; i += width) {
    const Vertices from = vertices(centres, i);
    const Wide of_row = larger(squared_distance(vertices(row, i), from),
                               squared_distance(vertices(row, i + 1), from));
    store_wide(squared + i, larger(load_wide(squared + i), of_row));
  }
}

void fold(int log, int blocks, float* squared) {
  for (; log > 0; --log) {
    for (int i = 0; i < blocks << (log - 1); i += width) {
      const Wide left = load_wide(squared + 2 * i), right = load_wide(squared + 2 * i + width);
      store_wide(squared + i, larger(even(left, right), odd(left, right)));
    }
  }
}

void cover(const float* squared, int blocks, const SphereRow& row, float* spheres) {
  for (int i = 0; i < blocks; i += width) {
    const Vertices centre = middle(load_boxes(row, i));
    const Wide radius = covering(square_root(load_wide(squared + i)), centre);
    store_wide(row.diameter + i, radius + radius);
    store_spheres(spheres, i, blocks, centre, radius);
  }
}

WEFT_INLINE Lanes squared_distance_of_eight(const SphereVertexRow& row, int i,
                                            const float* centre) {
  const Lanes x = load(row.component[0] + i) - broadcast(centre[0]);
  const Lanes y = load(row.component[1] + i) - broadcast(centre[1]);
  const Lanes z = load(row.component[2] + i) - broadcast(centre[2]);
  return x * x + y * y + z * z;
}

float reach_of_block(const SphereVertexRow* rows, int row_count, int begin, int columns,
                     const float* centre, float squared) {
  if (columns == 8) {
    Lanes largest = broadcast(squared);
    for (int row = 0; row < row_count; ++row) {
      const Lanes left = squared_distance_of_eight(rows[row], begin, centre);
      const Lanes right = squared_distance_of_eight(rows[row], begin + 1, centre);
      const Lanes of_row = left > right ? left : right;
      largest = largest > of_row ? largest : of_row;
    }
    for (int i = 0; i < 8; ++i) squared = larger(squared, largest[i]);
    return squared;
  }
  for (int row = 0; row < row_count; ++row) {
    for (int i = begin; i <= begin + columns; ++i) {
      const float x = rows[row].component[0][i] - centre[0];
      const float y = rows[row].component[1][i] - centre[1];
      const float z = rows[row].component[2][i] - centre[2];
      squared = larger(squared, x * x + y * y + z * z);
    }
  }
  return squared;
}

}  // namespace

extern const SphereKernels sphere_kernels;
const SphereKernels sphere_kernels = {load_vertices, copy_runs,   bound_quads,    bound_triangles,
                                      merge,         merge_boxes, spread_centres, reach,
                                      fold,          cover,       reach_of_block};

}  // namespace weft::bsi::WEFT_KERNELS
