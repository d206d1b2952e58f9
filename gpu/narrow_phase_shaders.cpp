// The compute shader that decides which features are in reach. Operations are those of
// bsi/proximity.cpp and bsi/detail/surface_terms.cpp, in their order. `precise` forbids fused
// operations.
#include "gpu/narrow_phase_shaders.h"

#include <limits>

#include "gpu/shader_parts.h"

namespace weft::gpu::shaders {

namespace {

const char* const candidates = R"(
layout(local_size_x = 64) in;
struct Group {
  double thickness, reach, range, damping_time, friction, friction_speed, spin_x, spin_y, spin_z;
  float limit;
  uint flags;
};
struct Row {
  uint first, group;
  double stiffness, parallel_threshold;
};
struct Candidate {
  uint points[4];
  uint own_features;
  float distance;
};
layout(std430, binding = 0) readonly buffer Candidates { Candidate candidates[]; };
layout(std430, binding = 1) readonly buffer Rows { Row rows[]; };
layout(std430, binding = 2) readonly buffer Groups { Group groups[]; };
// Positions of all points, then their velocities.
layout(std430, binding = 3) readonly buffer Points { double coordinates[]; };
// As the lists of the traversal: w is the number of items appended, also beyond the capacity. The
// lists are contributions and terms. The third w is the first candidate that touches.
layout(std430, binding = 4) buffer Lists { uvec4 lists[3]; };
// candidate, source + 8 coefficient, row, flags
layout(std430, binding = 5) buffer Terms { uvec4 terms[]; };
uniform uint term_capacity;

bool has(Group group, uint flag) { return (group.flags & flag) != 0u; }
dvec3 vector_at(uint point) {
  uint i = 3u * point;
  return dvec3(coordinates[i], coordinates[i + 1u], coordinates[i + 2u]);
}
)";

// Divisions and square roots as the CPU rounds them. Graphics processors may take the root of a
// float64 in float32 and divide within some units in the last place: one step of Newton's
// iteration, with a fused multiply-add, leaves a rounding or, of a root, a unit in the last place.
const char* const exact_operations = R"(
double quotient(double a, double b) { return a / b; }
double root_of(double x) { return sqrt(x); }
)";
const char* const refined_operations = R"(
double quotient(double a, double b) {
  precise double guess = a / b;
  precise double rest = fma(-guess, b, a);
  precise double better = fma(rest, 1.0lf / b, guess);
  return better - better == 0.0lf ? better : guess;
}
double root_of(double x) {
  precise double guess = sqrt(x);
  if (!(guess > 0.0lf)) return guess;
  for (int k = 0; k < 2; ++k) {
    precise double rest = fma(-guess, guess, x);
    guess += quotient(rest, 2.0lf * guess);
  }
  return guess;
}
)";

const char* const closest_points = R"(
// Arrays of float64 have constant indices: NVIDIA's compiler (driver 580) keeps those that are indexed
// otherwise in float32.
dvec3 pick(uint k, dvec3 first, dvec3 second, dvec3 third) {
  return k == 0u ? first : k == 1u ? second : third;
}
dvec3 scaled(double factor, dvec3 v) {
  precise dvec3 product = dvec3(factor * v.x, factor * v.y, factor * v.z);
  return product;
}
dvec4 scaled(double factor, dvec4 v) {
  precise dvec4 product = dvec4(factor * v.x, factor * v.y, factor * v.z, factor * v.w);
  return product;
}
double dot_of(dvec3 a, dvec3 b) {
  precise double sum = a.x * b.x + a.y * b.y + a.z * b.z;
  return sum;
}
dvec3 cross_of(dvec3 a, dvec3 b) {
  precise dvec3 product = a.yzx * b.zxy - a.zxy * b.yzx;
  return product;
}

struct Closest {
  double squared_distance;
  dvec3 separation;
  dvec4 weight;
  int free_directions;
};
const Closest nothing_yet = Closest(far, dvec3(0.0lf), dvec4(0.0lf), 0);
bool is_inside(double parameter) { return parameter > 0.0lf && parameter < 1.0lf; }

// Returns the parameter of the closest point of an edge. The vector from_start leads from the start
// of the edge to the given point.
double on_edge(dvec3 from_start, dvec3 edge, out dvec3 separation) {
  double along = dot_of(from_start, edge), squared_length = dot_of(edge, edge);
  precise double parameter = along <= 0.0lf ? 0.0lf
                             : along >= squared_length ? 1.0lf
                                                         : quotient(along, squared_length);
  precise dvec3 rounded = from_start - scaled(parameter, edge);
  precise dvec3 inner = rounded - scaled(quotient(dot_of(rounded, edge), squared_length), edge);
  separation = along <= 0.0lf ? from_start : along >= squared_length ? from_start - edge : inner;
  return parameter;
}

// Offers the closest point of an edge of the triangle. `start` and `end` are 1 at the weights of
// its ends.
void offer_border(inout Closest best, dvec3 from_start, dvec3 edge, dvec4 start, dvec4 end) {
  dvec3 separation;
  double parameter = on_edge(from_start, edge, separation);
  double squared = dot_of(separation, separation);
  if (squared >= best.squared_distance) return;
  best = Closest(squared, separation,
                 dvec4(1.0lf, 0.0lf, 0.0lf, 0.0lf) + scaled(parameter - 1.0lf, start) -
                     scaled(parameter, end),
                 is_inside(parameter) ? 1 : 0);
}
const dvec4 weight_1 = dvec4(0.0lf, 1.0lf, 0.0lf, 0.0lf);
const dvec4 weight_2 = dvec4(0.0lf, 0.0lf, 1.0lf, 0.0lf);
const dvec4 weight_3 = dvec4(0.0lf, 0.0lf, 0.0lf, 1.0lf);

Closest closest_in_face(dvec3 separation, double weight2, double weight3) {
  return Closest(dot_of(separation, separation), separation,
                 dvec4(1.0lf, weight2 + weight3 - 1.0lf, -weight2, -weight3), 2);
}
Closest closest_vertex_triangle(dvec3 x0, dvec3 x1, dvec3 x2, dvec3 x3) {
  dvec3 edge2 = x2 - x1, edge3 = x3 - x1, from1 = x0 - x1;
  dvec3 normal = cross_of(edge2, edge3);
  double scale = dot_of(normal, normal);
  precise double squared_lengths = dot_of(edge2, edge2) * dot_of(edge3, edge3);
  double area2 = dot_of(cross_of(from1, edge3), normal);
  double area3 = dot_of(cross_of(edge2, from1), normal);
  precise double area1 = scale - area2 - area3;
  precise double thin_scale = thin_squared_sine * squared_lengths;
  precise double parallel_scale = parallel_squared_sine * squared_lengths;
  precise double weight2 = quotient(area2, scale), weight3 = quotient(area3, scale);
  bool interior = area1 > 0.0lf && area2 > 0.0lf && area3 > 0.0lf;
  bool thin = !(scale > thin_scale);
  if (interior && !thin) {
    dvec3 separation = scaled(quotient(dot_of(from1, normal), scale), normal);
    return closest_in_face(separation, weight2, weight3);
  }
  Closest best = nothing_yet;
  if (thin || area3 <= 0.0lf) offer_border(best, from1, edge2, weight_1, weight_2);
  if (thin || area2 <= 0.0lf) offer_border(best, from1, edge3, weight_1, weight_3);
  if (thin || area1 <= 0.0lf) offer_border(best, x0 - x2, x3 - x2, weight_2, weight_3);
  if (thin && interior && scale > parallel_scale) {
    precise dvec3 separation = from1 - scaled(weight2, edge2) - scaled(weight3, edge3);
    if (dot_of(separation, separation) < best.squared_distance)
      return closest_in_face(separation, weight2, weight3);
  }
  return best;
}

// Offers the points at the parameters s and t of two edges.
void offer_points(inout Closest best, dvec3 separation, double s, double t) {
  double squared = dot_of(separation, separation);
  if (squared >= best.squared_distance) return;
  best = Closest(squared, separation, dvec4(1.0lf - s, s, t - 1.0lf, -t),
                 (is_inside(s) ? 1 : 0) + (is_inside(t) ? 1 : 0));
}
void offer_end(inout Closest best, dvec3 from_start, dvec3 edge, bool end_of_first, double end) {
  dvec3 separation;
  double parameter = on_edge(from_start, edge, separation);
  if (end_of_first) offer_points(best, separation, end, parameter);
  else offer_points(best, -separation, parameter, end);
}
Closest closest_edge_edge(dvec3 x0, dvec3 x1, dvec3 x2, dvec3 x3) {
  dvec3 first = x1 - x0, second = x3 - x2, from2 = x0 - x2;
  dvec3 normal = cross_of(first, second);
  double scale = dot_of(normal, normal);
  precise double squared_lengths = dot_of(first, first) * dot_of(second, second);
  double scaled_s = dot_of(cross_of(second, from2), normal);
  double scaled_t = dot_of(cross_of(first, from2), normal);
  precise double thin_scale = thin_squared_sine * squared_lengths;
  precise double parallel_scale = parallel_squared_sine * squared_lengths;
  precise double s = quotient(scaled_s, scale), t = quotient(scaled_t, scale);
  bool interior = scaled_s > 0.0lf && scaled_s < scale && scaled_t > 0.0lf && scaled_t < scale;
  bool thin = !(scale > thin_scale);
  Closest best = nothing_yet;
  if (interior && !thin) {
    dvec3 separation = scaled(quotient(dot_of(from2, normal), scale), normal);
    offer_points(best, separation, s, t);
    return best;
  }
  if (thin || scaled_s <= 0.0lf) offer_end(best, from2, second, true, 0.0lf);
  if (thin || scaled_s >= scale) offer_end(best, x1 - x2, second, true, 1.0lf);
  if (thin || scaled_t <= 0.0lf) offer_end(best, -from2, first, false, 0.0lf);
  if (thin || scaled_t >= scale) offer_end(best, x3 - x0, first, false, 1.0lf);
  if (thin && interior && scale > parallel_scale) {
    dvec3 separation;
    precise dvec3 from_s = from2 + scaled(s, first);
    double parameter = on_edge(from_s, second, separation);
    if (is_inside(parameter)) offer_points(best, separation, s, parameter);
  }
  return best;
}

// Returns the weights of a corner of a triangle.
dvec4 corner_weight(uint corner) {
  return corner == 0u ? weight_1 : corner == 1u ? weight_2 : weight_3;
}
// Sources of terms: 0 is the pair itself, 1 .. 3 the edge opposite corner source - 1 of a triangle,
// 4 .. 6 its corner source - 4.
Closest closest_on_border(dvec3 point, dvec3 x1, dvec3 x2, dvec3 x3, uint source) {
  if (source >= 4u) {
    dvec3 separation = point - pick(source - 4u, x1, x2, x3);
    return Closest(dot_of(separation, separation), separation,
                   dvec4(1.0lf, 0.0lf, 0.0lf, 0.0lf) - corner_weight(source - 4u), 0);
  }
  uint from = source % 3u, to = (source + 1u) % 3u;
  Closest closest = nothing_yet;
  dvec3 start = pick(from, x1, x2, x3);
  offer_border(closest, point - start, pick(to, x1, x2, x3) - start, corner_weight(from),
               corner_weight(to));
  return closest;
}
)";

const char* const find_main = R"(
struct Contribution {
  uvec2 feature;
  uint candidate, source_and_coefficient;
};
layout(std430, binding = 6) buffer Contributions { Contribution contributions[]; };
uniform uint row_count, contribution_capacity;

Closest closest_of(uint i, bool edges) {
  uint points[4] = candidates[i].points;
  dvec3 x0 = vector_at(points[0]), x1 = vector_at(points[1]);
  dvec3 x2 = vector_at(points[2]), x3 = vector_at(points[3]);
  if (edges) return closest_edge_edge(x0, x1, x2, x3);
  return closest_vertex_triangle(x0, x1, x2, x3);
}
// Notes candidate i if no gap is left.
void judge_gap(uint i, Closest closest, Group group) {
  if (!(root_of(closest.squared_distance) - group.thickness > 0.0lf)) atomicMin(lists[2].w, i);
}
void store_term(uint place, uint candidate, uint source_and_coefficient, uint row) {
  if (place < term_capacity) terms[place] = uvec4(candidate, source_and_coefficient, row, 0u);
}

// Returns the smallest feature that contains the closest point of candidate i.
uvec2 feature_of(uint i, Closest closest) {
  for (uint k = 0u; closest.free_directions < 2 && k < 3u; ++k) {
    double weight = k == 0u ? closest.weight.y : k == 1u ? closest.weight.z : closest.weight.w;
    bool is_zero = weight == 0.0lf;
    if (closest.free_directions == 0 && !is_zero) return uvec2(candidates[i].points[k + 1u]);
    if (closest.free_directions != 1 || !is_zero) continue;
    uint a = candidates[i].points[(k + 1u) % 3u + 1u], b = candidates[i].points[(k + 2u) % 3u + 1u];
    return uvec2(min(a, b), max(a, b));
  }
  return uvec2(0xFFFFFFFFu, i);
}
// Adds a contribution to those from `begin` to `end`.
void collect(uint begin, inout uint end, uint i, uint source, int coefficient, Closest closest) {
  uvec2 feature = feature_of(i, closest);
  for (uint place = begin; place < end; ++place) {
    if (contributions[place].feature != feature) continue;
    contributions[place].source_and_coefficient += uint(8 * coefficient);
    return;
  }
  contributions[end++] = Contribution(feature, i, uint(8 * coefficient + int(source)));
}
uint collect_row(uint begin, uint first, uint last, double squared_reach, float limit) {
  uint end = begin;
  for (uint i = first; i < last; ++i) {
    if (candidates[i].distance > limit) continue;
    Closest closest = closest_of(i, false);
    if (!(closest.squared_distance < squared_reach)) continue;
    collect(begin, end, i, 0u, 1, closest);
    uint own = candidates[i].own_features;
    dvec3 x0 = vector_at(candidates[i].points[0]), x1 = vector_at(candidates[i].points[1]);
    dvec3 x2 = vector_at(candidates[i].points[2]), x3 = vector_at(candidates[i].points[3]);
    for (uint bit = 0u; bit < 6u; ++bit) {
      uint source = 1u + (bit >> 1) + 3u * (bit & 1u);  // edge 0, corner 0, edge 1, ...
      if ((own >> (source - 1u) & 1u) == 0u) continue;
      Closest border = closest_on_border(x0, x1, x2, x3, source);
      if (border.squared_distance < squared_reach)
        collect(begin, end, i, source, source < 4u ? -1 : 1, border);
    }
  }
  return end;
}
void find_sample(uint row, uint first, uint last, Group group) {
  precise double squared_reach = group.reach * group.reach;
  uint room = 0u;
  for (uint i = first; i < last; ++i) {
    if (candidates[i].distance > group.limit) continue;
    Closest closest = closest_of(i, false);
    if (!(closest.squared_distance < squared_reach)) continue;
    room += 1u + uint(bitCount(candidates[i].own_features));
    judge_gap(i, closest, group);
  }
  if (room == 0u) return;
  uint begin = atomicAdd(lists[0].w, room);
  if (begin + room > contribution_capacity) return;
  uint end = collect_row(begin, first, last, squared_reach, group.limit);
  uint count = 0u;
  for (uint i = begin; i < end; ++i) count += uint(contributions[i].source_and_coefficient >= 8u);
  if (count == 0u) return;
  uint place = atomicAdd(lists[1].w, count);
  for (uint i = begin; i < end; ++i) {
    if (contributions[i].source_and_coefficient < 8u) continue;  // the coefficient is 0
    store_term(place++, contributions[i].candidate, contributions[i].source_and_coefficient, row);
  }
}
void find_pair(uint row, uint i, Group group) {
  if (candidates[i].distance > group.limit) return;
  Closest closest = closest_of(i, has(group, 1u));
  precise double squared_reach = group.reach * group.reach;
  if (closest.squared_distance >= squared_reach) return;
  judge_gap(i, closest, group);
  store_term(atomicAdd(lists[1].w, 1u), i, 8u, row);
}

void main() {
  for (uint row = gl_GlobalInvocationID.x; row < row_count; row += gl_NumWorkGroups.x * 64u) {
    Group group = groups[rows[row].group];
    uint first = rows[row].first, last = rows[row + 1u].first;
    if (has(group, 2u)) find_sample(row, first, last, group);
    else find_pair(row, first, group);
  }
}
)";

}  // namespace

std::string candidates_and_closest_points(bool rounds_like_the_cpu) {
  return std::string("#version 450 core\n") +
         "const double far = " + exactly(std::numeric_limits<double>::max()) +
         ";\nconst double thin_squared_sine = " + exactly(1e-12) +
         ";\nconst double parallel_squared_sine = " + exactly(1e-20) + ";\n" + candidates +
         (rounds_like_the_cpu ? exact_operations : refined_operations) + closest_points;
}

std::string find_terms(bool rounds_like_the_cpu) {
  return candidates_and_closest_points(rounds_like_the_cpu) + find_main;
}

}  // namespace weft::gpu::shaders
