// Compiled once for every instruction set: see instruction_set.h for what that forbids.
#include "bsi/sphere_kernels.h"

#include "bsi/sphere_bounds.h"
#include "bsi/wide_lanes.h"

namespace weft::bsi::WEFT_KERNELS {

namespace {

void copy_runs(const float* row, const std::int32_t* from, const std::int32_t* length, int runs,
               float* out) {
  for (int run = 0; run < runs; ++run) {
    const float* source = row + from[run];
    // What is written beyond the run is written again by the next.
    if (length[run] >= width) {
      for (int i = 0; i < length[run]; i += width) store_wide(out + i, load_wide(source + i));
    } else {
      for (int i = 0; i < length[run]; i += 4) {
        *reinterpret_cast<UnalignedQuad*>(out + i) = load_quad(source + i);
      }
    }
    out += length[run];
  }
}

// Named fields and no loops over them: g++ 12 keeps arrays of vectors in memory.
struct Vertices {
  Wide x, y, z;
};
struct Boxes {
  Vertices low, high;
};

WEFT_INLINE Vertices vertices(const SphereVertexRow& row, int i) {
  return {load_wide(row.component[0] + i), load_wide(row.component[1] + i),
          load_wide(row.component[2] + i)};
}

WEFT_INLINE Boxes join(const Boxes& a, const Boxes& b) {
  return {{smaller(a.low.x, b.low.x), smaller(a.low.y, b.low.y), smaller(a.low.z, b.low.z)},
          {larger(a.high.x, b.high.x), larger(a.high.y, b.high.y), larger(a.high.z, b.high.z)}};
}

WEFT_INLINE Boxes box_of(const Vertices& a, const Vertices& b) {
  return join(Boxes{a, a}, Boxes{b, b});
}

WEFT_INLINE Vertices middle(const Boxes& box) {
  return {0.5F * (box.low.x + box.high.x), 0.5F * (box.low.y + box.high.y),
          0.5F * (box.low.z + box.high.z)};
}

WEFT_INLINE Wide squared_distance(const Vertices& a, const Vertices& b) {
  return square(a.x - b.x, a.y - b.y, a.z - b.z);
}

// Of vertices i and i + 1 of a row.
WEFT_INLINE Wide squared_reach(const SphereVertexRow& row, int i, const Vertices& centre) {
  return larger(squared_distance(vertices(row, i), centre),
                squared_distance(vertices(row, i + 1), centre));
}

// |x| + |y| + |z|.
WEFT_INLINE Wide sum_of_magnitudes(const Vertices& a) {
  return magnitude(a.x) + magnitude(a.y) + magnitude(a.z);
}

// Radii that cover float64 vertices whose float32 roundings reach so far.
WEFT_INLINE Wide covering(Wide reach, const Vertices& centre) {
  return reach * round_up + (sum_of_magnitudes(centre) * centre_rounding + radius_floor);
}

WEFT_INLINE Boxes load_boxes(const SphereRow& row, int i) {
  return {{load_wide(row.low[0] + i), load_wide(row.low[1] + i), load_wide(row.low[2] + i)},
          {load_wide(row.high[0] + i), load_wide(row.high[1] + i), load_wide(row.high[2] + i)}};
}

WEFT_INLINE void store(const SphereRow& row, int i, const Boxes& box) {
  store_wide(row.low[0] + i, box.low.x);
  store_wide(row.low[1] + i, box.low.y);
  store_wide(row.low[2] + i, box.low.z);
  store_wide(row.high[0] + i, box.high.x);
  store_wide(row.high[1] + i, box.high.y);
  store_wide(row.high[2] + i, box.high.z);
}

// Spheres i and following of a row of `blocks`.
WEFT_INLINE void store_spheres(float* spheres, int i, int blocks, const Vertices& centre,
                               Wide radius) {
  if (i + width <= blocks) {
    store_alternately(spheres + 4 * i, centre.x, centre.y, centre.z, radius);
    return;
  }
  float all[4 * width];
  store_alternately(all, centre.x, centre.y, centre.z, radius);
  for (int k = 0; k < 4 * (blocks - i); ++k) spheres[4 * i + k] = all[k];
}

// Two rows of vertices at all ends of their paths. These and rows of blocks are passed by value:
// what is stored might otherwise change them, for all that the compiler knows, and they would be
// read again for every vector.
template <int ends>
struct QuadRow {
  SphereVertexRow upper[ends], lower[ends];
};

template <int ends>
QuadRow<ends> quad_row(const SphereVertexRows& rows, int row) {
  QuadRow<ends> result;
  for (int end = 0; end < ends; ++end) {
    result.upper[end] = rows.row[end][row];
    result.lower[end] = rows.row[end][row + 1];
  }
  return result;
}

// The corners of quads i and following.
struct Corners {
  Vertices upper_left, upper_right, lower_left, lower_right;
};

WEFT_INLINE Corners corners(const SphereVertexRow& upper, const SphereVertexRow& lower, int i) {
  return {vertices(upper, i), vertices(upper, i + 1), vertices(lower, i), vertices(lower, i + 1)};
}

WEFT_INLINE Boxes box_of(const Corners& quad) {
  return join(box_of(quad.upper_left, quad.upper_right), box_of(quad.lower_left, quad.lower_right));
}

WEFT_INLINE Wide squared_reach(const Corners& quad, const Vertices& centre) {
  return larger(
      larger(squared_distance(quad.upper_left, centre), squared_distance(quad.upper_right, centre)),
      larger(squared_distance(quad.lower_left, centre),
             squared_distance(quad.lower_right, centre)));
}

template <int ends>
void bound_quad_row(QuadRow<ends> row, int blocks, SphereRow out, float* spheres) {
  for (int i = 0; i < blocks; i += width) {
    const Corners start = corners(row.upper[0], row.lower[0], i);
    const Corners end = corners(row.upper[ends - 1], row.lower[ends - 1], i);
    const Boxes box = ends == 1 ? box_of(start) : join(box_of(start), box_of(end));
    // Before the corners are used again: g++ 12 would load them once more.
    store(out, i, box);
    const Vertices centre = middle(box);
    Wide squared = squared_reach(start, centre);
    if (ends == 2) squared = larger(squared, squared_reach(end, centre));
    const Wide radius = covering(square_root(squared), centre);
    store_wide(out.diameter + i, radius + radius);
    store_spheres(spheres, i, blocks, centre, radius);
  }
}

void bound_quads(const SphereVertexRows& rows, int blocks, const SphereRow* out,
                 float* const* spheres) {
  for (int row = 0; row < rows.row_count - 1; ++row) {
    if (rows.ends == 1) {
      bound_quad_row(quad_row<1>(rows, row), blocks, out[row], spheres[row]);
    } else {
      bound_quad_row(quad_row<2>(rows, row), blocks, out[row], spheres[row]);
    }
  }
}

// The spheres of one triangle of every quad, the second (right upper, right lower, left lower) or
// the first (left upper, right upper, left lower), as quad_triangles says.
template <int ends, bool second>
WEFT_INLINE void bound_triangle(const QuadRow<ends>& row, int i, float* spheres) {
  const auto third = [&](int end) {
    return second ? vertices(row.lower[end], i + 1) : vertices(row.upper[end], i);
  };
  const auto box_at = [&](int end) {
    return join(box_of(vertices(row.upper[end], i + 1), vertices(row.lower[end], i)),
                Boxes{third(end), third(end)});
  };
  const auto reach_at = [&](int end, const Vertices& centre) {
    return larger(larger(squared_distance(vertices(row.upper[end], i + 1), centre),
                         squared_distance(vertices(row.lower[end], i), centre)),
                  squared_distance(third(end), centre));
  };
  Boxes box = box_at(0);
  if constexpr (ends == 2) box = join(box, box_at(1));
  const Vertices centre = middle(box);
  Wide squared = reach_at(0, centre);
  if constexpr (ends == 2) squared = larger(squared, reach_at(1, centre));
  store_alternately(spheres, centre.x, centre.y, centre.z, covering(square_root(squared), centre));
}

template <int ends>
void bound_triangle_row(QuadRow<ends> row, int blocks, float* spheres) {
  float first[4 * width], second[4 * width];
  for (int i = 0; i < blocks; i += width) {
    bound_triangle<ends, false>(row, i, first);
    bound_triangle<ends, true>(row, i, second);
    for (int k = 0; k < width && i + k < blocks; ++k) {
      for (int part = 0; part < 4; ++part) {
        spheres[8 * (i + k) + part] = first[4 * k + part];
        spheres[8 * (i + k) + 4 + part] = second[4 * k + part];
      }
    }
  }
}

void bound_triangles(const SphereVertexRows& rows, int blocks, float* spheres) {
  if (rows.ends == 1) {
    bound_triangle_row(quad_row<1>(rows, 0), blocks, spheres);
  } else {
    bound_triangle_row(quad_row<2>(rows, 0), blocks, spheres);
  }
}

// Twice what children reach: the distance of their middles from those of their parents, of which
// `sum` is twice the middle, and their radii.
WEFT_INLINE Wide double_reach(const Boxes& child, const Vertices& sum, const float* diameter) {
  return square_root(square(child.low.x + child.high.x - sum.x, child.low.y + child.high.y - sum.y,
                            child.low.z + child.high.z - sum.z)) +
         load_wide(diameter);
}

WEFT_INLINE Vertices sum_of_bounds(const Boxes& box) {
  return {box.low.x + box.high.x, box.low.y + box.high.y, box.low.z + box.high.z};
}

// Of neighbours 2 k and 2 k + 1 in a and b, one after the other.
WEFT_INLINE Wide smaller_of_neighbours(Wide a, Wide b) { return smaller(even(a, b), odd(a, b)); }
WEFT_INLINE Wide larger_of_neighbours(Wide a, Wide b) { return larger(even(a, b), odd(a, b)); }
WEFT_INLINE Boxes join_neighbours(const Boxes& a, const Boxes& b) {
  return {{smaller_of_neighbours(a.low.x, b.low.x), smaller_of_neighbours(a.low.y, b.low.y),
           smaller_of_neighbours(a.low.z, b.low.z)},
          {larger_of_neighbours(a.high.x, b.high.x), larger_of_neighbours(a.high.y, b.high.y),
           larger_of_neighbours(a.high.z, b.high.z)}};
}

// Boxes of two rows of children, joined by neighbours along u where that axis is split.
template <bool split_u>
WEFT_INLINE Boxes boxes_of_parents(const SphereRow& upper, const SphereRow& lower, int i) {
  if constexpr (split_u) {
    const int left = 2 * i, right = 2 * i + width;
    return join_neighbours(join(load_boxes(upper, left), load_boxes(lower, left)),
                           join(load_boxes(upper, right), load_boxes(lower, right)));
  } else {
    return join(load_boxes(upper, i), load_boxes(lower, i));
  }
}

// Children are taken in the order in which they lie; two vectors of each row make one of parents.
template <bool split_u>
WEFT_INLINE Wide reach_of_children(const SphereRow& upper, const SphereRow& lower, int i,
                                   const Vertices& sum) {
  const auto reach = [&](int first, const Vertices& of_parent) {
    return larger(double_reach(load_boxes(upper, first), of_parent, upper.diameter + first),
                  double_reach(load_boxes(lower, first), of_parent, lower.diameter + first));
  };
  if constexpr (split_u) {
    const Vertices left{alternate_first(sum.x, sum.x), alternate_first(sum.y, sum.y),
                        alternate_first(sum.z, sum.z)};
    const Vertices right{alternate_second(sum.x, sum.x), alternate_second(sum.y, sum.y),
                         alternate_second(sum.z, sum.z)};
    return larger_of_neighbours(reach(2 * i, left), reach(2 * i + width, right));
  } else {
    return reach(i, sum);
  }
}

template <bool split_u>
void merge_by(SphereRow upper, SphereRow lower, int blocks, SphereRow out, float* spheres) {
  for (int i = 0; i < blocks; i += width) {
    const Boxes box = boxes_of_parents<split_u>(upper, lower, i);
    const Wide reach = reach_of_children<split_u>(upper, lower, i, sum_of_bounds(box));
    const Vertices centre = middle(box);
    const Wide diagonal =
        square_root(square(box.high.x - box.low.x, box.high.y - box.low.y, box.high.z - box.low.z));
    const Wide of_children = reach * (0.5F * round_up) + radius_floor;
    const Wide of_box =
        diagonal * (0.5F * round_up) + (sum_of_magnitudes(centre) * box_rounding + radius_floor);
    const Wide radius = smaller(of_children, of_box);
    store(out, i, box);
    store_wide(out.diameter + i, radius + radius);
    store_spheres(spheres, i, blocks, centre, radius);
  }
}

void merge(const SphereRow& upper, const SphereRow& lower, bool split_u, int blocks,
           const SphereRow& out, float* spheres) {
  split_u ? merge_by<true>(upper, lower, blocks, out, spheres)
          : merge_by<false>(upper, lower, blocks, out, spheres);
}

template <bool split_u>
void merge_boxes_by(SphereRow upper, SphereRow lower, int blocks, SphereRow out) {
  for (int i = 0; i < blocks; i += width) {
    store(out, i, boxes_of_parents<split_u>(upper, lower, i));
  }
}

void merge_boxes(const SphereRow& upper, const SphereRow& lower, bool split_u, int blocks,
                 const SphereRow& out) {
  split_u ? merge_boxes_by<true>(upper, lower, blocks, out)
          : merge_boxes_by<false>(upper, lower, blocks, out);
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

void reach(const SphereVertexRow& vertex_row, const float* const centre[3], int columns,
           float* squared) {
  const SphereVertexRow row = vertex_row, centres{{centre[0], centre[1], centre[2]}};
  for (int i = 0; i < columns; i += width) {
    const Wide of_row = squared_reach(row, i, vertices(centres, i));
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

void cover(const float* squared, int blocks, const SphereRow& block_row, float* spheres) {
  const SphereRow row = block_row;
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

// Of eight spheres in any order: their x, y, z and radii, from the four vectors they lie in.
WEFT_INLINE Lanes reach_of_eight(const float* spheres, const float* centre) {
  const Lanes a = load(spheres), b = load(spheres + 8);
  const Lanes c = load(spheres + 16), d = load(spheres + 24);
  const Lanes xy_first = __builtin_shufflevector(a, b, 0, 8, 1, 9, 4, 12, 5, 13);
  const Lanes zr_first = __builtin_shufflevector(a, b, 2, 10, 3, 11, 6, 14, 7, 15);
  const Lanes xy_second = __builtin_shufflevector(c, d, 0, 8, 1, 9, 4, 12, 5, 13);
  const Lanes zr_second = __builtin_shufflevector(c, d, 2, 10, 3, 11, 6, 14, 7, 15);
  const Lanes x = __builtin_shufflevector(xy_first, xy_second, 0, 1, 8, 9, 4, 5, 12, 13);
  const Lanes y = __builtin_shufflevector(xy_first, xy_second, 2, 3, 10, 11, 6, 7, 14, 15);
  const Lanes z = __builtin_shufflevector(zr_first, zr_second, 0, 1, 8, 9, 4, 5, 12, 13);
  const Lanes radius = __builtin_shufflevector(zr_first, zr_second, 2, 3, 10, 11, 6, 7, 14, 15);
  const Lanes dx = x - broadcast(centre[0]), dy = y - broadcast(centre[1]);
  const Lanes dz = z - broadcast(centre[2]);
  const Lanes squared = dx * dx + dy * dy + dz * dz;
  Lanes distance;
  for (int i = 0; i < 8; ++i) distance[i] = __builtin_sqrtf(squared[i]);
  return radius < 0 ? radius : distance + radius;
}

float reach_of_spheres(const float* spheres, std::size_t stride, int rows, int columns,
                       const float* centre) {
  float reach = -1;
  if (columns == 8) {
    Lanes largest = broadcast(reach);
    for (int row = 0; row < rows; ++row) {
      const Lanes of_row = reach_of_eight(spheres + row * stride, centre);
      largest = largest > of_row ? largest : of_row;
    }
    for (int i = 0; i < 8; ++i) reach = larger(reach, largest[i]);
    return reach;
  }
  for (int row = 0; row < rows; ++row) {
    for (int i = 0; i < columns; ++i) {
      const float* sphere = spheres + row * stride + 4 * i;
      const float x = sphere[0] - centre[0], y = sphere[1] - centre[1], z = sphere[2] - centre[2];
      const float distance = __builtin_sqrtf(x * x + y * y + z * z);
      reach = larger(reach, sphere[3] < 0 ? sphere[3] : distance + sphere[3]);
    }
  }
  return reach;
}

}  // namespace

extern const SphereKernels sphere_kernels;
const SphereKernels sphere_kernels = {copy_runs,   bound_quads,    bound_triangles, merge,
                                      merge_boxes, spread_centres, reach,           fold,
                                      cover,       reach_of_block, reach_of_spheres};

}  // namespace weft::bsi::WEFT_KERNELS
