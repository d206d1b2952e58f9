#include "gpu/compute_shaders.h"

#include <bit>
#include <limits>

#include "bsi/detail/sphere_bounds.h"
#include "bsi/pyramid.h"
#include "gpu/shader_parts.h"

namespace weft::gpu::shaders {

std::string exactly(float value) {
  return "uintBitsToFloat(" + std::to_string(std::bit_cast<std::uint32_t>(value)) + "u)";
}

std::string exactly(double value) {
  const auto bits = std::bit_cast<std::uint64_t>(value);
  return "packDouble2x32(uvec2(" + std::to_string(bits & 0xFFFFFFFF) + "u, " +
         std::to_string(bits >> 32) + "u))";
}

const char* const levels = R"(
struct Level {
  uint first, log_u, log_v, leaf;
  uint quad_rows, quad_cols, rows, cols;
  uint first_vertex, first_map, first_quad, first_texel;
  uint body, first_tangent, first_child, second_child;
};
layout(std430, binding = 0) readonly buffer Levels { Level levels[]; };
bool is_group(Level level) { return level.first_child != 0xFFFFFFFFu; }
)";

const char* const vertices = R"(
// Coordinates of the vertices at the starts of all paths, then of the vertices at the ends.
layout(std430, binding = 1) readonly buffer Vertices { float coordinates[]; };
layout(std430, binding = 2) readonly buffer Map { uint particle_of_texel[]; };
uniform uint vertex_count;

// Returns the texel of a vertex within its patch. Row and column may be one past the end of a
// wrapped axis.
uint texel_at(Level level, uint row, uint col) {
  return (row < level.rows ? row : 0u) * level.cols + (col < level.cols ? col : 0u);
}
uint vertex_of(Level level, uint texel) {
  if (level.first_map == 0xFFFFFFFFu) return level.first_vertex + texel;
  return level.first_vertex + particle_of_texel[level.first_map + texel];
}
vec3 start_of(uint vertex) {
  uint i = 3u * vertex;
  return vec3(coordinates[i], coordinates[i + 1u], coordinates[i + 2u]);
}
vec3 end_of(uint vertex) { return start_of(vertex_count + vertex); }
)";

// Two vec4 per block: the low bounds of its box with the radius of its sphere, then the high bounds
// with an unused number. The sphere's centre is the middle of the box.
const char* const boxes = R"(
layout(std430, binding = 4) buffer Bounds { vec4 bounds[]; };
struct Box { vec3 low, high; };
Box load_box(uint block) { return Box(bounds[2u * block].xyz, bounds[2u * block + 1u].xyz); }
vec3 middle_of(Box box) { return 0.5 * (box.low + box.high); }
// Returns centre and radius.
vec4 load_sphere(uint block) { return vec4(middle_of(load_box(block)), bounds[2u * block].w); }
float squared(vec3 d) {
  precise float sum = d.x * d.x + d.y * d.y + d.z * d.z;
  return sum;
}
)";

// Bounds of the differences between adjacent vertices, along u and along v. Lower bounds are
// negated, so that the union of two bounds is a maximum. Leaf blocks have no such bounds.
const char* const tangents = R"(
layout(std430, binding = 6) buffer Tangents { float tangents[]; };
struct Tangent { vec3 minus_low_u, minus_low_v, high_u, high_v; };
vec3 tangent_at(uint i) { return vec3(tangents[i], tangents[i + 1u], tangents[i + 2u]); }
Tangent load_tangent(uint block) {
  uint i = 12u * block;
  return Tangent(tangent_at(i), tangent_at(i + 3u), tangent_at(i + 6u), tangent_at(i + 9u));
}
Tangent join(Tangent a, Tangent b) {
  return Tangent(max(a.minus_low_u, b.minus_low_u), max(a.minus_low_v, b.minus_low_v),
                 max(a.high_u, b.high_u), max(a.high_v, b.high_v));
}
)";

namespace {

const char* const tasks = R"(
layout(local_size_x = 64) in;
layout(std430, binding = 3) readonly buffer Tasks { uvec4 tasks[]; };
uniform uint first_task, task_count, from_image;

// Returns the task of this work group: the last task that begins at this work group or before it.
uvec4 find_task() {
  uint low = 0u, high = task_count;
  while (high - low > 1u) {
    uint middle = (low + high) / 2u;
    if (tasks[first_task + middle].x <= gl_WorkGroupID.x) low = middle; else high = middle;
  }
  return tasks[first_task + low];
}

// Returns the vertices of a leaf block: rows range.x .. range.y and columns range.z .. range.w,
// inclusive.
uvec4 vertices_of_leaf(Level level, uint u, uint v) {
  return uvec4((v * level.quad_rows) >> level.log_v, ((v + 1u) * level.quad_rows) >> level.log_v,
               (u * level.quad_cols) >> level.log_u, ((u + 1u) * level.quad_cols) >> level.log_u);
}
)";

// The functions that bounds_main calls, in the version for boxes.
const char* const box_bounds = R"(
layout(std430, binding = 5) buffer Unbounded { uint first_unbounded[]; };
#define Bound Box
#define FIRST first
#define KEEPS_LOWEST true
const float far = 3.402823466e38;
Box start(uint block) { return Box(vec3(far), vec3(-far)); }
Box join(Box a, Box b) { return Box(min(a.low, b.low), max(a.high, b.high)); }
Box finish(Box box, uint block) { return box; }
Box load(uint block) { return load_box(block); }
void store(uint block, Box box) {
  bounds[2u * block] = vec4(box.low, -1.0);
  bounds[2u * block + 1u] = vec4(box.high, 0.0);
}

// Returns the bits of the largest |coordinate|. The bits of NaN and infinity exceed those of all
// other numbers.
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

// The functions that bounds_main calls, in the version for spheres, as in bsi/sphere_build.cpp. The
// sphere of a leaf block is computed from its box.
const char* const sphere_bounds = R"(
#define Bound vec4
#define FIRST first
#define KEEPS_LOWEST true
float cover(float reach, vec3 centre, float rounding) {
  precise float sum =
      reach * round_up + ((abs(centre.x) + abs(centre.y) + abs(centre.z)) * rounding + radius_floor);
  return sum;
}
vec4 start(uint block) { return vec4(middle_of(load_box(block)), 0.0); }
vec4 join(vec4 a, vec4 b) {
  precise float reach = sqrt(squared(b.xyz - a.xyz)) + b.w;
  return vec4(a.xyz, max(a.w, reach));
}
// Returns half the diagonal of a block's box, enlarged by the rounding allowance.
float half_diagonal(uint block, vec3 centre) {
  Box box = load_box(block);
  vec3 half_side = max(box.high - centre, centre - box.low);
  return cover(sqrt(squared(half_side)), centre, box_rounding);
}
vec4 finish(vec4 joined, uint block) {
  precise float carried = joined.w * round_up + radius_floor;
  return vec4(joined.xyz, min(half_diagonal(block, joined.xyz), carried));
}
vec4 load(uint block) { return load_sphere(block); }
void store(uint block, vec4 bound) { bounds[2u * block].w = bound.w; }

vec4 bound_leaf(Level level, uint block, uvec4 range, bool swept) {
  vec3 centre = middle_of(load_box(block));
  return vec4(centre, half_diagonal(block, centre));
}
)";

const char* const tangent_bounds = R"(
#define Bound Tangent
#define FIRST first_tangent
#define KEEPS_LOWEST false
const float far = 3.402823466e38;
Tangent start(uint block) {
  return Tangent(vec3(-far), vec3(-far), vec3(-far), vec3(-far));
}
Tangent finish(Tangent tangent, uint block) { return tangent; }
Tangent load(uint block) { return load_tangent(block); }
void store_vector(uint i, vec3 p) {
  tangents[i] = p.x; tangents[i + 1u] = p.y; tangents[i + 2u] = p.z;
}
void store(uint block, Tangent tangent) {
  uint i = 12u * block;
  store_vector(i, tangent.minus_low_u);
  store_vector(i + 3u, tangent.minus_low_v);
  store_vector(i + 6u, tangent.high_u);
  store_vector(i + 9u, tangent.high_v);
}

Tangent bound_leaf_at(Level level, uvec4 range, uint ends) {
  Tangent all = start(0u);
  for (uint row = range.x; row <= range.y; ++row) {
    for (uint col = range.z; col <= range.w; ++col) {
      vec3 p = start_of(ends + vertex_of(level, texel_at(level, row, col)));
      if (col < range.w) {
        vec3 step = start_of(ends + vertex_of(level, texel_at(level, row, col + 1u))) - p;
        all.minus_low_u = max(all.minus_low_u, -step);
        all.high_u = max(all.high_u, step);
      }
      if (row < range.y) {
        vec3 step = start_of(ends + vertex_of(level, texel_at(level, row + 1u, col))) - p;
        all.minus_low_v = max(all.minus_low_v, -step);
        all.high_v = max(all.high_v, step);
      }
    }
  }
  return all;
}
Tangent bound_leaf(Level level, uint block, uvec4 range, bool swept) {
  Tangent tangent = bound_leaf_at(level, range, 0u);
  return swept ? join(tangent, bound_leaf_at(level, range, vertex_count)) : tangent;
}
)";

const char* const groups_main = R"(
layout(local_size_x = 64) in;
layout(std430, binding = 3) readonly buffer Groups { uint groups[]; };
uniform uint first_group, group_count;
void main() {
  if (gl_GlobalInvocationID.x >= group_count) return;
  Level group = levels[groups[first_group + gl_GlobalInvocationID.x]];
  Box a = load_box(levels[group.first_child].first), b = load_box(levels[group.second_child].first);
  bounds[2u * group.first] = vec4(min(a.low, b.low), -1.0);
  bounds[2u * group.first + 1u] = vec4(max(a.high, b.high), 0.0);
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
  // mu is 1 if `middle` splits the blocks of `top` along u, else 0. mv is the same along v. lu and
  // lv are the same for `lowest` and `middle`. mu and lu also mask a child's index.
  uint mu = middle.log_u - top.log_u, mv = middle.log_v - top.log_v;
  uint lu = lowest.log_u - middle.log_u, lv = lowest.log_v - middle.log_v;
  uint whole_block = top.FIRST + index;
  Bound whole = start(whole_block);
  for (uint i = 0u; i < 1u << (mu + mv); ++i) {
    uint u_middle = (u << mu) + (i & mu), v_middle = (v << mv) + (i >> mu);
    uint part_block = middle.FIRST + (v_middle << middle.log_u) + u_middle;
    Bound part = start(part_block);
    for (uint j = 0u; j < 1u << (lu + lv); ++j) {
      uint u_lowest = (u_middle << lu) + (j & lu), v_lowest = (v_middle << lv) + (j >> lu);
      uint block = lowest.FIRST + (v_lowest << lowest.log_u) + u_lowest;
      Bound bound;
      if (from_image != 0u) {
        uvec4 range = vertices_of_leaf(lowest, u_lowest, v_lowest);
        bound = bound_leaf(lowest, block, range, swept);
        if (KEEPS_LOWEST) store(block, bound);
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
  if (task.z != (task.w & 0x7FFFFFFFu)) store(whole_block, finish(whole, whole_block));
}
)";

}  // namespace

std::string bound_boxes() {
  return std::string("#version 450 core\n") + levels + vertices + tasks + boxes +
         "const uint coordinate_limit = " +
         std::to_string(std::bit_cast<std::uint32_t>(bsi::Pyramid::coordinate_limit)) + "u;\n" +
         box_bounds + bounds_main;
}

std::string bound_spheres(bool rounds_like_the_cpu) {
  // The relative error of GLSL's roots is at most 2^-20 (4.5 units in the last place). The relative
  // error of the CPU's roots is at most 2^-24.
  const float round_up = rounds_like_the_cpu ? bsi::round_up : 1 + 0x1p-19F;
  return std::string("#version 450 core\n") + levels + vertices + tasks + boxes +
         "const float round_up = " + exactly(round_up) +
         ";\nconst float box_rounding = " + exactly(bsi::box_rounding) +
         ";\nconst float radius_floor = " + exactly(bsi::radius_floor) + ";\n" + sphere_bounds +
         bounds_main;
}

std::string bound_groups() {
  return std::string("#version 450 core\n") + levels + boxes + groups_main;
}

std::string bound_tangents() {
  return std::string("#version 450 core\n") + levels + vertices + tasks + tangents +
         tangent_bounds + bounds_main;
}

}  // namespace weft::gpu::shaders
