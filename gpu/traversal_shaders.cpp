// The compute shaders of the traversals.
#include "bsi/detail/sphere_bounds.h"
#include "gpu/compute_shaders.h"
#include "gpu/shader_parts.h"

namespace weft::gpu::shaders {
namespace {

const char* const queries = R"(
layout(local_size_x = 64) in;
struct Query {
  double certificate_margin;  // m; negative: no certificate
  float half_margin;
  uint flags;
  float x, y, z;
  float sphere_reach;
  float filter_reach;
  uint unused;
};
layout(std430, binding = 3) readonly buffer Queries { Query queries[]; };

bool is_self(Query query) { return (query.flags & 1u) != 0u; }
bool is_point(Query query) { return (query.flags & 2u) != 0u; }
Box point_of(Query query) {
  vec3 point = vec3(query.x, query.y, query.z);
  return Box(point, point);
}
// Returns true if the boxes overlap when each is widened by half_margin on all sides.
bool overlap(Box a, Box b, float half_margin) {
  precise vec3 a_low = a.low - half_margin, a_high = a.high + half_margin;
  precise vec3 b_low = b.low - half_margin, b_high = b.high + half_margin;
  return all(lessThanEqual(a_low, b_high)) && all(lessThanEqual(b_low, a_high));
}

// Lists to which shaders append. x is the number of work groups that the next reader of the list
// needs, at most group_limit. w is the number of items appended. Items beyond the capacity are
// counted but not stored.
layout(std430, binding = 5) buffer Lists { uvec4 lists[]; };
uniform uint group_limit;
// Reserves indices for `added` items, each read by `readers` invocations. Returns the first index.
uint append(uint list, uint added, uint readers) {
  uint first = atomicAdd(lists[list].w, added);
  uint groups = (readers * (first + added) + 63u) / 64u;
  if (groups > (readers * first + 63u) / 64u) atomicMax(lists[list].x, min(groups, group_limit));
  return first;
}
)";

const char* const expand_main = R"(
// Pairs of blocks: a, b, the indices of their levels (16 bits each), and the number of the query.
layout(std430, binding = 1) readonly buffer PairsIn { uvec4 pairs_in[]; };
layout(std430, binding = 2) writeonly buffer PairsOut { uvec4 pairs_out[]; };
layout(std430, binding = 7) writeonly buffer LeafPairs { uvec4 leaf_pairs[]; };
uniform uint list_in, list_out, list_leaves, pair_capacity, leaf_capacity;

// The children of a block, or the block itself. Child i is block first + (i & mask_u) +
// (i >> mask_u) * stride, and its level has the index level + i * level_step. Only groups have
// children on different levels. Their level_step and stride may be negative (modulo 2^32).
struct Children { uint level, level_step, first, stride, mask_u, count; };
Children children_of_group(Level group) {
  uint first = levels[group.first_child].first;
  return Children(group.first_child, group.second_child - group.first_child, first,
                  levels[group.second_child].first - first, 0u,
                  group.second_child == group.first_child ? 1u : 2u);
}
// Returns the children of a block. The result is the block itself if it is a leaf block, or if it
// is a block of a patch and the pair contains a group (`with_group`).
Children children_of(uint block, uint number, bool with_group) {
  Level level = levels[number];
  if (is_group(level)) return children_of_group(level);
  if (with_group || level.leaf != 0u) return Children(number, 0u, block, 0u, 0u, 1u);
  Level below = levels[number + 1u];
  uint split_u = below.log_u - level.log_u, split_v = below.log_v - level.log_v;
  uint place = block - level.first;
  uint u = place & ((1u << level.log_u) - 1u), v = place >> level.log_u;
  return Children(number + 1u, 0u, below.first + (v << split_v << below.log_u) + (u << split_u),
                  1u << below.log_u, split_u, 1u << (split_u + split_v));
}
uint child(Children children, uint i) {
  return children.first + (i & children.mask_u) + (i >> children.mask_u) * children.stride;
}
uint level_of(Children children, uint i) { return children.level + i * children.level_step; }

// --- The tangent certificate: operation by operation as in bsi/kernels/tangent_certificate.h ---

double dot_of(dvec3 a, dvec3 b) {
  precise double sum = a.x * b.x + a.y * b.y + a.z * b.z;
  return sum;
}
bool is_beyond(dvec3 p, dvec3 stray_p, dvec3 q, dvec3 stray_q, dvec3 size, double margin) {
  dvec3 side = q - p;
  precise dvec3 normal = p * dot_of(side, side) - side * dot_of(p, side);
  dvec3 magnitude = abs(normal);
  precise double reach_p = dot_of(normal, p) - dot_of(magnitude, stray_p);
  precise double reach_q = dot_of(normal, q) - dot_of(magnitude, stray_q);
  precise double needed = sqrt(dot_of(normal, normal)) * margin * certificate_factor +
                          certificate_rounding * dot_of(magnitude, size);
  return min(reach_p, reach_q) > needed;
}
bool certified(Tangent t, double margin) {
  dvec3 low_u = -dvec3(t.minus_low_u), low_v = -dvec3(t.minus_low_v);
  dvec3 high_u = dvec3(t.high_u), high_v = dvec3(t.high_v);
  dvec3 a = 0.5lf * (high_u + low_u), b = 0.5lf * (high_v + low_v);
  dvec3 stray_u = 0.5lf * (high_u - low_u), stray_v = 0.5lf * (high_v - low_v);
  dvec3 diagonal = b - a, stray_diagonal = stray_u + stray_v;
  precise dvec3 size = abs(a) + abs(b) + stray_diagonal;
  return is_beyond(a, stray_u, b, stray_v, size, margin) &&
         is_beyond(b, stray_v, diagonal, stray_diagonal, size, margin) &&
         is_beyond(diagonal, stray_diagonal, -a, stray_u, size, margin);
}

// Returns the step from block a to block b along an axis: -1, 0 or 1, or 2 if they are farther
// apart.
int step_between(uint a, uint b, uint blocks, bool wraps) {
  int step = int(b) - int(a);
  if (wraps && step == int(blocks) - 1) step = -1;
  if (wraps && step == 1 - int(blocks)) step = 1;
  return abs(step) <= 1 ? step : 2;
}

// Returns true if the certificate proves that the two blocks of a pair cannot touch. The result is
// false unless they are neighbours or one and the same block. For neighbours, the certificate tests
// the window of up to 2 x 2 blocks that contains both blocks.
bool cannot_touch(Query query, uvec4 pair) {
  if (query.certificate_margin < 0.0lf || (pair.z & 0xFFFFu) != pair.z >> 16) return false;
  Level level = levels[pair.z >> 16];
  if (level.leaf != 0u || is_group(level)) return false;
  uint mask = (1u << level.log_u) - 1u;
  uint a = pair.x - level.first, b = pair.y - level.first;
  uvec2 at_a = uvec2(a & mask, a >> level.log_u), at_b = uvec2(b & mask, b >> level.log_u);
  int step_u = step_between(at_a.x, at_b.x, 1u << level.log_u, level.quad_cols == level.cols);
  int step_v = step_between(at_a.y, at_b.y, 1u << level.log_v, level.quad_rows == level.rows);
  if (step_u == 2 || step_v == 2) return false;
  Tangent bound = load_tangent(level.first_tangent + a);
  uint first = level.first_tangent;
  if (step_u != 0) bound = join(bound, load_tangent(first + (at_a.y << level.log_u) + at_b.x));
  if (step_v != 0) bound = join(bound, load_tangent(first + (at_b.y << level.log_u) + at_a.x));
  if (step_u != 0 && step_v != 0) bound = join(bound, load_tangent(first + b));
  return certified(bound, query.certificate_margin);
}

// Compares two spheres as touch() of bsi/kernels/box_lanes.h does.
bool touch(vec4 a, vec4 b, float sphere_reach) {
  precise float reach = (a.w + (b.w + sphere_reach)) * touch_factor;
  precise float square = reach * reach;
  return squared(a.xyz - b.xyz) <= square;
}

void expand(uvec4 pair) {
  Query query = queries[pair.w];
  if (cannot_touch(query, pair)) return;
  bool point = is_point(query);
  bool itself = is_self(query) && pair.x == pair.y;
  uint number_a = pair.z & 0xFFFFu, number_b = pair.z >> 16;
  bool grouped = is_group(levels[number_b]) || (!point && is_group(levels[number_a]));
  Children a = point ? Children(0u, 0u, pair.x, 0u, 0u, 1u)
                     : children_of(pair.x, number_a, grouped);
  Children b = children_of(pair.y, number_b, grouped);
  uint near = 0u;
  for (uint i = 0u; i < a.count; ++i) {
    Box box = point ? point_of(query) : load_box(child(a, i));
    vec4 sphere = point ? vec4(box.low, 0.0) : load_sphere(child(a, i));
    for (uint j = itself ? i : 0u; j < b.count; ++j) {
      if (uses_spheres && !grouped && !touch(sphere, load_sphere(child(b, j)), query.sphere_reach)) continue;
      if ((uses_boxes || grouped) && !overlap(box, load_box(child(b, j)), query.half_margin)) {
        continue;
      }
      near |= 1u << (4u * i + j);
    }
  }
  if (near == 0u) return;
  bool leaves = !grouped && (point || levels[a.level].leaf != 0u) && levels[b.level].leaf != 0u;
  uint place = append(leaves ? list_leaves : list_out, uint(bitCount(near)), leaves ? 4u : 1u);
  for (; near != 0u; near &= near - 1u, ++place) {
    uint bit = uint(findLSB(near));
    uint level_a = level_of(a, bit >> 2), level_b = level_of(b, bit & 3u);
    uvec4 next = uvec4(child(a, bit >> 2), child(b, bit & 3u), level_a | level_b << 16, pair.w);
    // Groups contain patches in any order. Within one body, `a` must nevertheless be the block
    // whose level has the lower index.
    if (grouped && is_self(query) && level_a > level_b) {
      next = uvec4(next.y, next.x, level_b | level_a << 16, pair.w);
    }
    if (leaves) {
      if (place < leaf_capacity) leaf_pairs[place] = next;
    } else if (place < pair_capacity) {
      pairs_out[place] = next;
    }
  }
}

void main() {
  uint count = min(lists[list_in].w, pair_capacity);
  for (uint i = gl_GlobalInvocationID.x; i < count; i += gl_NumWorkGroups.x * 64u) {
    expand(pairs_in[i]);
  }
}
)";

// This shader runs four invocations per pair of leaf blocks: one per quad that the first block can
// have. In the query of a ball, three of them return at once.
const char* const leaves_main = R"(
layout(std430, binding = 6) readonly buffer LeafPairs { uvec4 leaf_pairs[]; };
layout(std430, binding = 7) writeonly buffer Results { uint results[]; };
uniform uint list_leaves, list_results, leaf_capacity, result_capacity, triangles;

struct Quad { uint number; uint row, col; };
// Finds quad `i` of the up to 2 x 2 quads of a leaf block. Returns false if the block has no such
// quad.
bool find_quad(Level level, uint block, uint i, out Quad quad) {
  uint place = block - level.first;
  uint u = place & ((1u << level.log_u) - 1u), v = place >> level.log_u;
  quad.row = ((v * level.quad_rows) >> level.log_v) + (i >> 1);
  quad.col = ((u * level.quad_cols) >> level.log_u) + (i & 1u);
  quad.number = level.first_quad + quad.row * level.quad_cols + quad.col;
  return quad.row < ((v + 1u) * level.quad_rows) >> level.log_v &&
         quad.col < ((u + 1u) * level.quad_cols) >> level.log_u;
}
Box join(Box a, Box b) { return Box(min(a.low, b.low), max(a.high, b.high)); }
Box bound_vertex(uint vertex, bool swept) {
  vec3 p = start_of(vertex);
  if (!swept) return Box(p, p);
  vec3 q = end_of(vertex);
  return Box(min(p, q), max(p, q));
}
uvec4 corners_of(Level level, Quad quad) {
  return uvec4(vertex_of(level, texel_at(level, quad.row, quad.col)),
               vertex_of(level, texel_at(level, quad.row, quad.col + 1u)),
               vertex_of(level, texel_at(level, quad.row + 1u, quad.col)),
               vertex_of(level, texel_at(level, quad.row + 1u, quad.col + 1u)));
}
// The boxes of a quad's two triangles. If leaves are quads, `first` is the box of the whole quad.
struct Leaves { Box first, second; };
Leaves bound_leaves(uvec4 corner, bool swept) {
  Box diagonal = join(bound_vertex(corner.y, swept), bound_vertex(corner.z, swept));
  Leaves leaves = Leaves(join(diagonal, bound_vertex(corner.x, swept)),
                         join(diagonal, bound_vertex(corner.w, swept)));
  if (triangles == 0u) leaves.first = join(leaves.first, leaves.second);
  return leaves;
}
uvec3 triangle_of(uvec4 corner, uint i) { return uvec3(i == 0u ? corner.x : corner.w, corner.yz); }
bool share_particle(uvec3 a, uvec3 b) {
  return any(equal(a, b)) || any(equal(a, b.yzx)) || any(equal(a, b.zxy));
}

float longest_path(uvec4 corner) {
  vec4 path = vec4(distance(start_of(corner.x), end_of(corner.x)),
                   distance(start_of(corner.y), end_of(corner.y)),
                   distance(start_of(corner.z), end_of(corner.z)),
                   distance(start_of(corner.w), end_of(corner.w)));
  return max(max(path.x, path.y), max(path.z, path.w));
}
// Returns the corners at the ends of their paths, as columns.
mat4x3 corners_at_end(uvec4 corner, bool swept) {
  uvec4 at = swept ? corner + uvec4(vertex_count) : corner;
  return mat4x3(start_of(at.x), start_of(at.y), start_of(at.z), start_of(at.w));
}
float least(vec4 v) { return min(min(v.x, v.y), min(v.z, v.w)); }
float greatest(vec4 v) { return max(max(v.x, v.y), max(v.z, v.w)); }
// Returns true if a plane proves that, at the ends of their paths, the quads are farther apart than
// filter_reach plus twice the longest path of their corners (docs/theory.md, "The distance
// filter"). The normal of the plane is that of either quad, or the line between their centres. A
// normal whose length is at most shortest_normal proves nothing, because its squares may be flushed
// to zero.
bool are_apart(Query query, uvec4 corner_a, uvec4 corner_b) {
  if (query.filter_reach < 0.0) return false;
  bool swept_a = (query.flags & 4u) != 0u, swept_b = (query.flags & 8u) != 0u;
  mat4x3 a = corners_at_end(corner_a, swept_a), b = corners_at_end(corner_b, swept_b);
  float path = max(swept_a ? longest_path(corner_a) : 0.0, swept_b ? longest_path(corner_b) : 0.0);
  float needed = (query.filter_reach + 2.0 * path) * filter_factor;
  vec3 directions[3] = vec3[](cross(a[3] - a[0], a[2] - a[1]), cross(b[3] - b[0], b[2] - b[1]),
                              b[0] + b[1] + b[2] + b[3] - a[0] - a[1] - a[2] - a[3]);
  for (int i = 0; i < 3; ++i) {
    vec4 along_a = directions[i] * a, along_b = directions[i] * b;
    float gap = max(least(along_b) - greatest(along_a), least(along_a) - greatest(along_b));
    float size = length(directions[i]);
    if (size > shortest_normal && gap > size * needed) return true;
  }
  return false;
}

// Returns a mask of the pairs of leaves that are near each other. Bit 4 j + 2 s + t stands for leaf
// s of the quad and leaf t of quad j of block b. s and t are 0 if leaves are quads.
uint near_leaves(Query query, bool itself, uint quad, Leaves leaves, uvec4 corners, uint block_b,
                 Level level_b) {
  bool swept_b = (query.flags & 8u) != 0u;
  uint near = 0u;
  for (uint j = itself ? quad : 0u; j < 4u; ++j) {
    Quad other;
    if (!find_quad(level_b, block_b, j, other)) continue;
    uvec4 other_corners = corners_of(level_b, other);
    if (!is_point(query) && are_apart(query, corners, other_corners)) continue;
    Leaves others = bound_leaves(other_corners, swept_b);
    for (uint s = 0u; s <= triangles; ++s) {
      if (is_point(query) && s == 1u) break;
      for (uint t = 0u; t <= triangles; ++t) {
        if (itself && triangles != 0u && quad == j) continue;  // a quad's triangles share particles
        if (!overlap(s == 0u ? leaves.first : leaves.second, t == 0u ? others.first : others.second,
                    query.half_margin)) {
          continue;
        }
        if (is_self(query) && triangles != 0u &&
            share_particle(triangle_of(corners, s), triangle_of(other_corners, t))) {
          continue;
        }
        near |= 1u << (4u * j + 2u * s + t);
      }
    }
  }
  return near;
}

void find(uvec4 pair, uint i) {
  Query query = queries[pair.w];
  bool point = is_point(query);
  Quad quad = Quad(pair.x, 0u, 0u);
  Leaves leaves = Leaves(point_of(query), point_of(query));
  uvec4 corners = uvec4(0u);
  if (point) {
    if (i != 0u) return;
  } else {
    Level level_a = levels[pair.z & 0xFFFFu];
    if (!find_quad(level_a, pair.x, i, quad)) return;
    corners = corners_of(level_a, quad);
    leaves = bound_leaves(corners, (query.flags & 4u) != 0u);
    Box both = triangles == 0u ? leaves.first : join(leaves.first, leaves.second);
    if (!overlap(both, load_box(pair.y), query.half_margin)) return;
  }
  Level level_b = levels[pair.z >> 16];
  bool itself = is_self(query) && pair.x == pair.y;
  uint near = near_leaves(query, itself, i, leaves, corners, pair.y, level_b);
  if (near == 0u) return;
  uint place = append(list_results, uint(bitCount(near)), 1u);
  for (; near != 0u; near &= near - 1u, ++place) {
    if (place >= result_capacity) return;
    uint bit = uint(findLSB(near));
    Quad other;
    find_quad(level_b, pair.y, bit >> 2, other);
    uint a = quad.number, b = other.number;
    if (triangles != 0u) {
      if (!point) a = 2u * a + ((bit >> 1) & 1u);
      b = 2u * b + (bit & 1u);
    }
    bool swap = is_self(query) && a > b;
    results[3u * place] = pair.w;
    results[3u * place + 1u] = swap ? b : a;
    results[3u * place + 2u] = swap ? a : b;
  }
}

void main() {
  uint count = 4u * min(lists[list_leaves].w, leaf_capacity);
  for (uint i = gl_GlobalInvocationID.x; i < count; i += gl_NumWorkGroups.x * 64u) {
    find(leaf_pairs[i / 4u], i % 4u);
  }
}
)";

}  // namespace

std::string expand_pairs(bsi::Bound bound, bool rounds_like_the_cpu) {
  const auto flag = [](bool value) { return value ? "true" : "false"; };
  // GLSL guarantees the same relative accuracy for float64 as for float32: 2^-24 for products and
  // 2^-20 for roots.
  const double rounding = rounds_like_the_cpu ? 0x1p-46 : 0x1p-16;
  const double factor = rounds_like_the_cpu ? 1 : 1 + 0x1p-16;
  return std::string("#version 450 core\n") + levels + boxes + tangents + queries +
         "const double certificate_rounding = " + exactly(rounding) +
         ";\nconst double certificate_factor = " + exactly(factor) +
         ";\nconst float touch_factor = " + exactly(bsi::touch_factor) +
         ";\nconst bool uses_spheres = " + flag(bound != bsi::Bound::box) +
         ";\nconst bool uses_boxes = " + flag(bound != bsi::Bound::sphere) + ";\n" + expand_main;
}

std::string find_leaves() {
  // The factor covers the relative error of GLSL's length(), at most 2^-19.
  return std::string("#version 450 core\n") + levels + vertices + boxes + queries +
         "const float filter_factor = " + exactly(1 + 0x1p-16F) +
         ";\nconst float shortest_normal = " + exactly(0x1p-50F) + ";\n" + leaves_main;
}

}  // namespace weft::gpu::shaders
