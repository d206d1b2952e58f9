// The compute shader of the contact law. Operations are those of materials/contact.h and
// sim/contact/contact_pair.cpp.
#include "gpu/narrow_phase_shaders.h"

namespace weft::gpu::shaders {

// log x = e log 2 + log(1 + f) with x = 2^e (1 + f) and 1 + f within [sqrt(1/2), sqrt(2)). With
// s = f / (2 + f), log(1 + f) = 2 artanh(s) = f - (f^2/2 - s (f^2/2 + r)), where r is the series
// from 2/3 s^2 on. The leading terms are exact or small, as in fdlibm's e_log.c.
const char* const logarithm = R"(
// The logarithm of 2 in two parts. The first has 32 bits, so that its product with an exponent is
// exact.
const double log_2_high = packDouble2x32(uvec2(0xFEE00000u, 0x3FE62E42u));
const double log_2_low = packDouble2x32(uvec2(0x35793C76u, 0x3DEA39EFu));
double log_of(double x) {
  uvec2 bits = unpackDouble2x32(x);
  int exponent = int(bits.y >> 20) - 1023;
  double mantissa = packDouble2x32(uvec2(bits.x, (bits.y & 0xFFFFFu) | 0x3FF00000u));
  if (mantissa > 1.4142135623730951lf) {
    mantissa *= 0.5lf;
    ++exponent;
  }
  precise double f = mantissa - 1.0lf;
  precise double s = f / (2.0lf + f);
  precise double z = s * s;
  precise double series = 2.0lf / 21.0lf;
  for (int k = 19; k >= 3; k -= 2) series = series * z + 2.0lf / double(k);
  precise double r = series * z;
  precise double half_square = 0.5lf * f * f;
  double e = double(exponent);
  precise double result =
      e * log_2_high - ((half_square - (s * (half_square + r) + e * log_2_low)) - f);
  return result;
}
)";

namespace {

const char* const law_main = R"(
layout(std430, binding = 6) writeonly buffer Pushes { double pushes[]; };
layout(std430, binding = 7) writeonly buffer Slidings { double slidings[]; };
uniform uint point_count;

struct Barrier { double value, first, second, third; };
Barrier barrier_of(double gap, double range, double stiffness) {
  if (gap >= range) return Barrier(0.0lf, 0.0lf, 0.0lf, 0.0lf);
  precise double inverse = 1.0lf / gap;
  precise double depth = gap - range;
  precise double relative = depth * inverse, ratio = range * inverse;
  double logarithm = log_of(gap / range);
  precise double value = -stiffness * depth * depth * logarithm;
  precise double first = -stiffness * depth * (2.0lf * logarithm + relative);
  precise double second = -stiffness * (2.0lf * logarithm + (4.0lf - relative) * relative);
  precise double third = -2.0lf * stiffness * inverse * (1.0lf + ratio * (1.0lf + ratio));
  return Barrier(value, first, second, third);
}

dmat3 diagonal(double value) {
  return dmat3(value, 0.0lf, 0.0lf, 0.0lf, value, 0.0lf, 0.0lf, 0.0lf, value);
}
dmat3 outer(dvec3 a, dvec3 b) { return dmat3(scaled(b.x, a), scaled(b.y, a), scaled(b.z, a)); }
dmat3 scaled(double factor, dmat3 m) {
  return dmat3(scaled(factor, m[0]), scaled(factor, m[1]), scaled(factor, m[2]));
}
dvec3 product_of(dmat3 m, dvec3 v) {
  precise dvec3 sum = scaled(v.x, m[0]) + scaled(v.y, m[1]) + scaled(v.z, m[2]);
  return sum;
}
dmat3 product_of(dmat3 a, dmat3 b) {
  return dmat3(product_of(a, b[0]), product_of(a, b[1]), product_of(a, b[2]));
}
dvec3 divided(dvec3 v, double divisor) {
  precise dvec3 result = dvec3(v.x / divisor, v.y / divisor, v.z / divisor);
  return result;
}

struct Push { double force, stiffness, damping; };
Push damped_push(Barrier barrier, double gap, Group group, double gap_rate) {
  const double onset = 0.01lf;
  double push = -barrier.first;
  if (!(push > 0.0lf)) return Push(0.0lf, 0.0lf, 0.0lf);
  precise double depth = 1.0lf - gap / group.range;
  precise double share = depth / (depth + onset);
  precise double share_slope = -onset / ((depth + onset) * (depth + onset) * group.range);
  precise double damping = group.damping_time * barrier.second * share;
  precise double damping_slope =
      group.damping_time * (barrier.third * share + barrier.second * share_slope);
  precise double z = damping * gap_rate / push;
  if (z <= 0.0lf) {
    precise double force = push - damping * gap_rate;
    precise double stiffness = barrier.second + damping_slope * gap_rate;
    return Push(force, stiffness, damping);
  }
  if (z >= 1.0lf) return Push(0.0lf, 0.0lf, 0.0lf);
  precise double psi = (1.0lf - z) * (1.0lf - z) * (1.0lf + z);
  precise double slope = (3.0lf * z + 1.0lf) * (z - 1.0lf);
  precise double force = push * psi;
  precise double stiffness =
      barrier.second * (psi - z * slope) - slope * damping_slope * gap_rate;
  return Push(force, stiffness, -damping * slope);
}

void store_vector(uint buffer_place, dvec3 vector) {
  pushes[buffer_place] = vector.x;
  pushes[buffer_place + 1u] = vector.y;
  pushes[buffer_place + 2u] = vector.z;
}
// Stores the forces from the slope of the mollifier of two edges, and returns its value.
double mollify(uint term, dvec3 a, dvec3 b, double threshold, Barrier barrier, inout uint flags) {
  dvec3 product = cross_of(a, b);
  double c = dot_of(product, product);
  if (c >= threshold) return 1.0lf;
  precise double inverse = 1.0lf / threshold;
  precise double ratio = c * inverse;
  precise double factor = -barrier.value * (2.0lf * (1.0lf - ratio) * inverse) * 2.0lf;
  double along = dot_of(a, b);
  precise dvec3 on_a = scaled(dot_of(b, b), a) - scaled(along, b);
  precise dvec3 on_b = scaled(dot_of(a, a), b) - scaled(along, a);
  store_vector(18u * term + 12u, scaled(factor, on_a));
  store_vector(18u * term + 15u, scaled(factor, on_b));
  flags |= 2u;
  precise double value = ratio * (2.0lf - ratio);
  return value;
}

// Finds the matrices that give the angular velocity of the surface spanned by e1 and e2 from their
// rates. Returns false if e1 and e2 are nearly parallel.
bool find_turning(dvec3 e1, dvec3 e2, out dmat3 turn1, out dmat3 turn2) {
  dvec3 across = cross_of(e1, e2);
  double squared_area = dot_of(across, across);
  turn1 = turn2 = diagonal(0.0lf);
  if (!(squared_area > thin_squared_sine * dot_of(e1, e1) * dot_of(e2, e2))) return false;
  precise double area = root_of(squared_area);
  dvec3 m = divided(across, area), q1 = divided(e2, area), q2 = divided(-e1, area);
  turn1 = outer(scaled(0.5lf, m), q1) - outer(q1, m);
  turn2 = outer(scaled(0.5lf, m), q2) - outer(q2, m);
  return true;
}
void store_column(uint place, dvec3 column) {
  slidings[place] = column.x;
  slidings[place + 1u] = column.y;
  slidings[place + 2u] = column.z;
}
void store_matrix(uint place, dmat3 matrix) {
  store_column(place, matrix[0]);
  store_column(place + 3u, matrix[1]);
  store_column(place + 6u, matrix[2]);
}
struct Levers { dmat3 of0, of1, of2, of3; };
struct FourPoints { dvec3 x0, x1, x2, x3; };
// Adds to the levers what comes from the rotation of the second feature.
bool turn_levers(bool edges, FourPoints x, dvec3 separation, inout Levers lever) {
  dmat3 turn1, turn2;
  dvec3 e1 = edges ? x.x1 - x.x0 : x.x2 - x.x1, e2 = edges ? x.x3 - x.x2 : x.x3 - x.x1;
  if (!find_turning(e1, e2, turn1, turn2)) return false;
  dmat3 arm = dmat3(0.0lf, separation.z, -separation.y, -separation.z, 0.0lf, separation.x,
                    separation.y, -separation.x, 0.0lf);
  dmat3 first = product_of(arm, turn1), second = product_of(arm, turn2);
  if (edges) {
    lever.of0 -= first;
    lever.of1 += first;
    lever.of2 -= second;
  } else {
    lever.of1 -= first + second;
    lever.of2 += first;
  }
  lever.of3 += second;
  return true;
}
// Stores a lever, projected on the surface, and returns what it contributes to the sliding velocity.
dvec3 use_lever(uint place, dmat3 across, dmat3 lever, dvec3 velocity) {
  dmat3 projected = product_of(across, lever);
  store_matrix(place, projected);
  return product_of(projected, velocity);
}
// Stores the friction of a term. Returns false if it has none.
bool slide(uint term, Group group, double limit, Closest closest, dvec3 normal, FourPoints x,
           FourPoints v) {
  if (limit == 0.0lf) return false;
  dmat3 across = diagonal(1.0lf) - outer(normal, normal);
  dvec4 weight = closest.weight;
  Levers lever = Levers(diagonal(weight.x), diagonal(weight.y), diagonal(weight.z),
                        diagonal(weight.w));
  dvec3 u = dvec3(0.0lf);
  if (has(group, 4u)) {
    u = -product_of(across, cross_of(dvec3(group.spin_x, group.spin_y, group.spin_z),
                                     closest.separation));
  } else if (!turn_levers(has(group, 1u), x, closest.separation, lever)) {
    return false;
  }
  uint place = 48u * term;
  u += use_lever(place, across, lever.of0, v.x0);
  u += use_lever(place + 9u, across, lever.of1, v.x1);
  u += use_lever(place + 18u, across, lever.of2, v.x2);
  u += use_lever(place + 27u, across, lever.of3, v.x3);
  precise double speed = root_of(dot_of(u, u));
  precise double inverse = 1.0lf / group.friction_speed, inverse_speed = 1.0lf / speed;
  precise double ratio = speed * inverse;
  bool full = speed >= group.friction_speed;
  precise double over_speed = full ? inverse_speed : (2.0lf - ratio) * inverse;
  precise double slope = full ? 0.0lf : 2.0lf * (1.0lf - ratio) * inverse;
  precise double factor = limit * over_speed;
  store_column(place + 36u, scaled(-factor, u));
  dmat3 slopes = scaled(factor, across);
  dvec3 along = divided(u, speed);
  if (speed > 0.0lf) slopes += scaled(limit * (slope - over_speed), outer(along, along));
  store_matrix(place + 39u, slopes);
  return true;
}

FourPoints points_of(uint i, uint first) {
  return FourPoints(vector_at(first + candidates[i].points[0]), vector_at(first + candidates[i].points[1]),
                vector_at(first + candidates[i].points[2]), vector_at(first + candidates[i].points[3]));
}
void apply_law(uint term) {
  uint i = terms[term].x, source = terms[term].y & 7u;
  double coefficient = double(int(terms[term].y) >> 3);
  Row row = rows[terms[term].z];
  Group group = groups[row.group];
  bool edges = has(group, 1u);
  FourPoints x = points_of(i, 0u), v = points_of(i, point_count);
  Closest closest;
  if (edges) closest = closest_edge_edge(x.x0, x.x1, x.x2, x.x3);
  else if (source == 0u) closest = closest_vertex_triangle(x.x0, x.x1, x.x2, x.x3);
  else closest = closest_on_border(x.x0, x.x1, x.x2, x.x3, source);
  dvec4 weight = closest.weight;
  precise double distance = root_of(closest.squared_distance);
  precise double gap = distance - group.thickness;
  if (!(gap > 0.0lf)) return;  // find_terms has noted it
  dvec3 normal = divided(closest.separation, distance);
  uint flags = 0u;
  double stiffness = row.stiffness;
  Barrier barrier = barrier_of(gap, group.range, stiffness);
  if (row.parallel_threshold > 0.0lf) {
    stiffness *= mollify(term, x.x1 - x.x0, x.x3 - x.x2, row.parallel_threshold, barrier, flags);
    barrier = barrier_of(gap, group.range, stiffness);
  }
  precise dvec3 relative = scaled(weight.x, v.x0) + scaled(weight.y, v.x1) +
                           scaled(weight.z, v.x2) + scaled(weight.w, v.x3);
  Push push = damped_push(barrier, gap, group, dot_of(normal, relative));
  pushes[18u * term] = weight.x;
  pushes[18u * term + 1u] = weight.y;
  pushes[18u * term + 2u] = weight.z;
  pushes[18u * term + 3u] = weight.w;
  store_vector(18u * term + 4u, normal);
  pushes[18u * term + 7u] = gap;
  store_vector(18u * term + 8u,
               scaled(coefficient, dvec3(barrier.value, push.force, push.stiffness)));
  pushes[18u * term + 11u] = coefficient * push.damping;
  double limit = group.friction * (-coefficient * barrier.first);
  if (slide(term, group, limit, closest, normal, x, v)) flags |= 1u;
  terms[term].w = flags;
}

void main() {
  uint count = min(lists[1].w, term_capacity);
  for (uint i = gl_GlobalInvocationID.x; i < count; i += gl_NumWorkGroups.x * 64u) apply_law(i);
}
)";

}  // namespace

std::string apply_law(bool rounds_like_the_cpu) {
  return candidates_and_closest_points(rounds_like_the_cpu) + logarithm + law_main;
}

}  // namespace weft::gpu::shaders
