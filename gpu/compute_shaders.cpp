#include "gpu/compute_shaders.h"

#include <bit>
#include <limits>

#include "bsi/pyramid.h"
#include "bsi/sphere_bounds.h"

namespace weft::gpu::shaders {
namespace {

// A float32 with all its bits.
std::string exactly(float value) {
  return "uintBitsToFloat(" + std::to_string(std::bit_cast<std::uint32_t>(value)) + "u)";
}

const char* const levels_and_vertices = R"(
struct Level {
  uint first, log_u, log_v, leaf;
  uint quad_rows, quad_cols, rows, cols;
  uint first_vertex, first_map, first_quad, first_texel;
  uint body, unused_0, unused_1, unused_2;
};
layout(std430, binding = 0) readonly buffer Levels { Level levels[]; };
layout(std430, binding = 1) readonly buffer Starts { float starts[]; };
layout(std430, binding = 2) readonly buffer Ends { float ends[]; };
layout(std430, binding = 3) readonly buffer Map { uint particle_of_texel[]; };

// Row and column of a vertex may be one past the end of a wrapped axis.
uint texel_at(Level level, uint row, uint col) {
  return (row < level.rows ? row : 0u) * level.cols + (col < level.cols ? col : 0u);
}
uint vertex_of(Level level, uint texel) {
  if (level.first_map == 0xFFFFFFFFu) return level.first_vertex + texel;
  return level.first_vertex + particle_of_texel[level.first_map + texel];
}
vec3 start_of(uint vertex) {
  return vec3(starts[3u * vertex], starts[3u * vertex + 1u], starts[3u * vertex + 2u]);
}
vec3 end_of(uint vertex) {
  return vec3(ends[3u * vertex], ends[3u * vertex + 1u], ends[3u * vertex + 2u]);
}
)";

const char* const tasks = R"(
layout(local_size_x = 64) in;
layout(std430, binding = 4) readonly buffer Tasks { uvec4 tasks[]; };
uniform uint first_task, task_count, from_image;

// The task of this work group: the last one that begins no later.
uvec4 find_task() {
  uint low = 0u, high = task_count;
  while (high - low > 1u) {
    uint middle = (low + high) / 2u;
    if (tasks[first_task + middle].x <= gl_WorkGroupID.x) low = middle; else high = middle;
  }
  return tasks[first_task + low];
}

// Calls that differ from kernel to kernel visit the vertices of a leaf block: rows and columns
// range.x .. range.y and range.z .. range.w, both included.
uvec4 vertices_of_leaf(Level level, uint u, uint v) {
  return uvec4((v * level.quad_rows) >> level.log_v, ((v + 1u) * level.quad_rows) >> level.log_v,
               (u * level.quad_cols) >> level.log_u, ((u + 1u) * level.quad_cols) >> level.log_u);
}
)";

const char* const boxes = R"(
layout(std430, binding = 5) buffer Lows { float low[]; };
layout(std430, binding = 6) buffer Highs { float high[]; };
const float far = 3.402823466e38;
struct Box { vec3 low, high; };
Box load_box(uint block) {
  return Box(vec3(low[3u * block], low[3u * block + 1u], low[3u * block + 2u]),
             vec3(high[3u * block], high[3u * block + 1u], high[3u * block + 2u]));
}
)";

// The functions that bounds_main calls, for boxes.
const char* const box_bounds = R"(
layout(std430, binding = 7) buffer Unbounded { uint first_unbounded[]; };
#define Bound Box
Box start(uint block) { return Box(vec3(far), vec3(-far)); }
Box join(Box a, Box b) { return Box(min(a.low, b.low), max(a.high, b.high)); }
Box finish(Box box, uint block) { return box; }
Box load(uint block) { return load_box(block); }
void store(uint block, Box box) {
  low[3u * block] = box.low.x; low[3u * block + 1u] = box.low.y; low[3u * block + 2u] = box.low.z;
  high[3u * block] = box.high.x; high[3u * block + 1u] = box.high.y;
  high[3u * block + 2u] = box.high.z;
}

// Largest bits of a coordinate, sign apart: those of NaN and infinity are larger than the others.
uint size_of(vec3 p) {
  uvec3 bits = floatBitsToUint(p) & 0x7FFFFFFFu;
  return max(bits.x, max(bits.y, bits.z));
}

Box bound_leaf(Level level, uint block, uvec4 range, bool swept) {
  Box box = start(0u);
  for (uint row = range.x; row <= range.y; ++row) {
    for (uint col = range.z; col <= range.w; ++col) {
      uint texel = texel_at(level, row, col);
      uint vertex = vertex_of(level, texel);
      vec3 p = start_of(vertex);
      uint size = size_of(p);
      box = join(box, Box(p, p));
      if (swept) {
        p = end_of(vertex);
        size = max(size, size_of(p));
        box = join(box, Box(p, p));
      }
      if (size >= coordinate_limit) {
        atomicMin(first_unbounded[level.body], level.first_texel + texel);
      }
    }
  }
  return box;
}
)";

// For spheres: operation by operation what bsi/sphere_bounds.h and bsi/block_row.cpp do.
const char* const sphere_bounds = R"(
layout(std430, binding = 7) buffer Spheres { vec4 sphere[]; };
#define Bound vec4
vec3 middle_of(Box box) { return 0.5 * (box.low + box.high); }
float squared(vec3 d) {
  precise float sum = d.x * d.x + d.y * d.y + d.z * d.z;
  return sum;
}
float cover(float reach, Box box) {
  vec3 m = max(abs(box.low), abs(box.high));
  precise float sum =
      reach * round_up + (max(m.x, max(m.y, m.z)) * vertex_rounding + radius_floor);
  return sum;
}
vec4 start(uint block) { return vec4(middle_of(load_box(block)), -1.0); }
vec4 join(vec4 a, vec4 b) {
  precise float reach = sqrt(squared(b.xyz - a.xyz)) + b.w;
  return vec4(a.xyz, max(a.w, reach));
}
vec4 finish(vec4 joined, uint block) {
  Box box = load_box(block);
  precise float carried = joined.w * round_up + radius_floor;
  vec3 half_side = max(box.high - joined.xyz, joined.xyz - box.low);
  return vec4(joined.xyz, min(cover(sqrt(squared(half_side)), box), carried));
}
vec4 load(uint block) { return sphere[block]; }
void store(uint block, vec4 bound) { sphere[block] = bound; }

vec4 bound_leaf(Level level, uint block, uvec4 range, bool swept) {
  Box box = load_box(block);
  vec3 centre = middle_of(box);
  float reach = 0.0;
  for (uint row = range.x; row <= range.y; ++row) {
    for (uint col = range.z; col <= range.w; ++col) {
      uint vertex = vertex_of(level, texel_at(level, row, col));
      reach = max(reach, squared(start_of(vertex) - centre));
      if (swept) reach = max(reach, squared(end_of(vertex) - centre));
    }
  }
  return vec4(centre, cover(sqrt(reach), box));
}
)";

const char* const bounds_main = R"(
void main() {
  uvec4 task = find_task();
  Level lowest = levels[task.y];
  Level middle = levels[task.z];
  Level top = levels[task.w & 0x7FFFFFFFu];
  bool swept = task.w >> 31 != 0u;
  uint index = (gl_WorkGroupID.x - task.x) * 64u + gl_LocalInvocationID.x;
  if (index >= 1u << (top.log_u + top.log_v)) return;
  uint u = index & ((1u << top.log_u) - 1u), v = index >> top.log_u;
  // Which axes are split: masks of one bit.
  uint mu = middle.log_u - top.log_u, mv = middle.log_v - top.log_v;
  uint lu = lowest.log_u - middle.log_u, lv = lowest.log_v - middle.log_v;
  Bound whole = start(top.first + index);
  for (uint i = 0u; i < 1u << (mu + mv); ++i) {
    uint u_middle = (u << mu) + (i & mu), v_middle = (v << mv) + (i >> mu);
    uint part_block = middle.first + (v_middle << middle.log_u) + u_middle;
    Bound part = start(part_block);
    for (uint j = 0u; j < 1u << (lu + lv); ++j) {
      uint u_lowest = (u_middle << lu) + (j & lu), v_lowest = (v_middle << lv) + (j >> lu);
      uint block = lowest.first + (v_lowest << lowest.log_u) + u_lowest;
      Bound bound;
      if (from_image != 0u) {
        uvec4 range = vertices_of_leaf(lowest, u_lowest, v_lowest);
        bound = bound_leaf(lowest, block, range, swept);
        store(block, bound);
      } else {
        bound = load(block);
      }
      part = join(part, bound);
    }
    if (task.z != task.y) {
      part = finish(part, part_block);
      store(part_block, part);
    }
    whole = join(whole, part);
  }
  if (task.z != (task.w & 0x7FFFFFFFu)) store(top.first + index, finish(whole, top.first + index));
}
)";

}  // namespace

std::string bound_boxes() {
  return std::string("#version 450 core\n") + levels_and_vertices + tasks + boxes +
         "const uint coordinate_limit = " +
         std::to_string(std::bit_cast<std::uint32_t>(bsi::Pyramid::coordinate_limit)) + "u;\n" +
         box_bounds + bounds_main;
}

std::string bound_spheres() {
  return std::string("#version 450 core\n") + levels_and_vertices + tasks + boxes +
         "const float round_up = " + exactly(bsi::round_up) +
         ";\nconst float vertex_rounding = " + exactly(bsi::vertex_rounding) +
         ";\nconst float radius_floor = " + exactly(bsi::radius_floor) + ";\n" + sphere_bounds +
         bounds_main;
}

}  // namespace weft::gpu::shaders
