// The narrow phase on the device against the functions of the CPU, candidate by candidate.
#include "gpu/compute_narrow_phase.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <sstream>

#include "bsi/detail/surface_terms.h"
#include "bsi/shapes.h"
#include "gpu/compute_shaders.h"
#include "gpu/gl_objects.h"
#include "gpu/narrow_phase_shaders.h"
#include "gpu/shader_parts.h"
#include "materials/contact.h"
#include "sim/contact/contact_pair.h"
#include "tests/gpu/test_context.h"

namespace weft::gpu::compute_narrow_phase_test {
namespace {

using bsi::Closest;
using sim::Mat3;

// A surface whose triangles are candidates. Its vertices begin at point `first`.
struct MeshedSurface {
  bsi::Mesh mesh;
  bsi::SurfaceTerms terms;
  int first, count;
  MeshedSurface(const bsi::Surface& surface, int first_point)
      : mesh(bsi::build_mesh(surface.atlas)),
        terms(mesh, static_cast<int>(surface.positions.size())),
        first(first_point),
        count(static_cast<int>(surface.positions.size())) {}
};

// The input of an evaluation. Rows of samples also know their surface, and whether it is the
// sample's own.
struct Input {
  std::vector<Vec3> x, v;
  std::vector<ContactGroup> groups;
  std::vector<ContactRow> rows;
  std::vector<ContactCandidate> candidates;
  std::vector<std::unique_ptr<MeshedSurface>> surfaces;
  std::vector<int> surface_of_group;
  std::vector<int> triangles;  // by candidate

  std::array<int, 4> points(std::size_t candidate) const {
    const auto& p = candidates[candidate].points;
    return {static_cast<int>(p[0]), static_cast<int>(p[1]), static_cast<int>(p[2]),
            static_cast<int>(p[3])};
  }
  Closest closest(std::size_t candidate, bool edges) const {
    const auto [a, b, c, d] = points(candidate);
    return edges ? bsi::closest_edge_edge(x[a], x[b], x[c], x[d])
                 : bsi::closest_vertex_triangle(x[a], x[b], x[c], x[d]);
  }
  void add_group(const ContactGroup& group, int surface = -1) {
    groups.push_back(group);
    surface_of_group.push_back(surface);
  }
  void add_row(double stiffness, double threshold = 0) {
    rows.push_back({static_cast<std::uint32_t>(candidates.size()),
                    static_cast<std::uint32_t>(groups.size() - 1), stiffness, threshold});
  }
  void add_candidate(const std::array<int, 4>& p, unsigned own = 0, int triangle = -1) {
    candidates.push_back({{static_cast<std::uint32_t>(p[0]), static_cast<std::uint32_t>(p[1]),
                           static_cast<std::uint32_t>(p[2]), static_cast<std::uint32_t>(p[3])},
                          own});
    triangles.push_back(triangle);
  }
  int add_surface(const bsi::Surface& surface) {
    surfaces.push_back(std::make_unique<MeshedSurface>(surface, static_cast<int>(x.size())));
    x.insert(x.end(), surface.positions.begin(), surface.positions.end());
    return static_cast<int>(surfaces.size()) - 1;
  }
  // Makes every vertex of one surface a sample, with all triangles of another one (or of its own)
  // that do not have it for a corner.
  void add_samples(int from, int to, ContactGroup group) {
    group.samples = true;
    add_group(group, to);
    const MeshedSurface &vertices = *surfaces[from], &surface = *surfaces[to];
    for (int v = 0; v < vertices.count; ++v) {
      add_row(3.0 + v);
      for (int t = 0; t < static_cast<int>(surface.mesh.triangles.size()); ++t) {
        const auto& corner = surface.mesh.triangles[t];
        const int own = from == to ? v : -1;
        if (std::ranges::find(corner, own) != corner.end()) continue;
        add_candidate({vertices.first + v, surface.first + corner[0], surface.first + corner[1],
                       surface.first + corner[2]},
                      surface.terms.own_features(t, own), t);
      }
    }
  }
  void move_randomly(std::mt19937& random) {
    std::uniform_real_distribution<double> speed(-0.5, 0.5);
    for (std::size_t i = 0; i < x.size(); ++i)
      v.emplace_back(speed(random), speed(random), speed(random));
  }
};

// The terms and forces of a row, by the functions of the CPU.
struct Expected {
  std::vector<std::uint32_t> candidates, rows;
  std::vector<sim::ContactPair> pairs;
  std::vector<std::optional<sim::Sliding>> slidings;
  std::vector<std::optional<std::array<Vec3, 2>>> turning;  // forces from the mollifier
  std::optional<std::uint32_t> touching;
};

void add_expected(const Input& input, std::uint32_t row, std::uint32_t candidate,
                  const Closest& closest, int coefficient, Expected& expected) {
  const ContactRow& entry = input.rows[row];
  const ContactGroup& group = input.groups[entry.group];
  if (!(std::sqrt(closest.squared_distance) - group.thickness > 0)) return;
  const auto nodes = input.points(candidate);
  const bsi::FourPoints x{input.x[nodes[0]], input.x[nodes[1]], input.x[nodes[2]],
                          input.x[nodes[3]]};
  const sim::ContactLaw law{group.range, entry.stiffness, group.damping_time, group.friction,
                            group.friction_speed};
  double mollifier = 1;
  std::optional<std::array<Vec3, 2>> turning;
  if (entry.parallel_threshold > 0) {
    const Vec3 a = x[1] - x[0], b = x[3] - x[2];
    const auto m =
        materials::edge_edge_mollifier(a.cross(b).squaredNorm(), entry.parallel_threshold);
    mollifier = m.value;
    const double gap = std::sqrt(closest.squared_distance) - group.thickness;
    const double factor = -2 * m.first * materials::barrier(gap, law.range, law.stiffness).value;
    if (m.first != 0) {
      turning = {factor * (b.squaredNorm() * a - a.dot(b) * b),
                 factor * (a.squaredNorm() * b - a.dot(b) * a)};
    }
  }
  sim::ContactPair pair;
  pair.nodes = nodes;
  pair.coefficient = coefficient;
  const double push = sim::apply_push(law, group.thickness, mollifier, closest, input.v, pair);
  std::optional<Vec3> spin;
  if (group.obstacle) spin = group.spin;
  const auto kind = group.edges ? bsi::FeatureKind::edge_edge : bsi::FeatureKind::vertex_triangle;
  expected.slidings.push_back(
      sim::friction_of(law, push, {kind, closest, x, input.v, spin, {}, nullptr}, pair));
  expected.pairs.push_back(pair);
  expected.candidates.push_back(candidate);
  expected.rows.push_back(row);
  expected.turning.push_back(turning);
}

Expected expected_of(const Input& input) {
  Expected expected;
  std::vector<bsi::SurfaceTerm> terms;
  for (std::uint32_t row = 0; row < input.rows.size(); ++row) {
    const ContactGroup& group = input.groups[input.rows[row].group];
    const std::uint32_t first = input.rows[row].first;
    const std::uint32_t last = row + 1 < input.rows.size()
                                   ? input.rows[row + 1].first
                                   : static_cast<std::uint32_t>(input.candidates.size());
    const double reach = group.thickness + group.range;
    std::vector<int> near;
    for (std::uint32_t i = first; i < last; ++i) {
      const Closest closest = input.closest(i, group.edges);
      if (!(closest.squared_distance < reach * reach)) continue;
      if (!(std::sqrt(closest.squared_distance) - group.thickness > 0) && !expected.touching)
        expected.touching = i;
      if (group.samples)
        near.push_back(input.triangles[i]);
      else
        add_expected(input, row, i, closest, 1, expected);
    }
    if (near.empty()) continue;
    const MeshedSurface& surface = *input.surfaces[input.surface_of_group[input.rows[row].group]];
    const int vertex = input.points(first)[0], own = vertex - surface.first;
    surface.terms.find(input.x[vertex], own >= 0 && own < surface.count ? own : -1, near,
                       std::span(input.x).subspan(surface.first, surface.count), reach, terms);
    for (const bsi::SurfaceTerm& term : terms) {
      const auto place =
          std::find(input.triangles.begin() + first, input.triangles.begin() + last, term.triangle);
      add_expected(input, row, static_cast<std::uint32_t>(place - input.triangles.begin()),
                   term.closest, term.coefficient, expected);
    }
  }
  return expected;
}

// Compares a number with the expected one, relative to the size of what it is made of.
void expect_close(double found, double expected, double size, const char* name) {
  ASSERT_LE(std::abs(found - expected), 4e-13 * size) << name << ' ' << found << ' ' << expected;
}
template <class Found, class Wanted>
void expect_close(const Found& found, const Wanted& expected, double size, const char* name) {
  for (int i = 0; i < expected.size(); ++i) expect_close(found[i], expected.data()[i], size, name);
}

// Compares the values of a term. A relative error of the distance is amplified in those of the law:
// relative to the values at half the range, by (distance / gap) range / gap for each derivative.
void expect_same(const ContactResult& result, std::uint32_t i, const Expected& expected,
                 std::size_t k, const Input& input) {
  const ContactPush& found = result.pushes[i];
  const sim::ContactPair& pair = expected.pairs[k];
  const ContactRow& row = input.rows[result.terms[i].row];
  const ContactGroup& group = input.groups[row.group];
  for (int n = 0; n < 4; ++n) expect_close(found.weight[n], pair.weight[n], 1, "weight");
  expect_close(found.normal, pair.normal, 1, "normal");
  expect_close(found.gap, pair.gap, pair.gap + group.thickness, "gap");
  const double steep = 1 + group.range / pair.gap, distance = pair.gap + group.thickness;
  const double stiffness = row.stiffness * (1 + distance / pair.gap) * steep;
  const double push = stiffness * group.range;
  expect_close(found.energy, pair.energy, push * group.range, "energy");
  expect_close(found.push, pair.push, push, "push");
  expect_close(found.stiffness, pair.stiffness, stiffness * steep, "stiffness");
  expect_close(found.damping, pair.damping, stiffness * group.damping_time * steep, "damping");
  if (expected.turning[k]) {
    expect_close(found.turn_first, (*expected.turning[k])[0], 1e3 * push, "turning");
    expect_close(found.turn_second, (*expected.turning[k])[1], 1e3 * push, "turning");
  }
  if (!expected.slidings[k] || !result.terms[i].slides()) return;
  const ContactSliding& sliding = result.slidings[i];
  double lever = 1;  // grows with the aspect ratio of a triangle, which amplifies rounding
  for (const Mat3& matrix : expected.slidings[k]->lever)
    lever = std::max(lever, matrix.cwiseAbs().maxCoeff());
  for (int n = 0; n < 4; ++n)
    expect_close(sliding.lever[n], expected.slidings[k]->lever[n], lever * lever, "lever");
  expect_close(sliding.force, expected.slidings[k]->force, lever * push, "friction");
  expect_close(sliding.slope, expected.slidings[k]->slope, lever * push / group.friction_speed,
               "slope of friction");
}

// Returns the terms of the first row whose number of terms is not the expected one, as text.
std::string first_difference(const ContactResult& result, const Expected& expected,
                             const Input& input) {
  for (std::uint32_t row = 0; row < input.rows.size(); ++row) {
    std::ostringstream text;
    std::size_t found = 0, wanted = 0;
    text.precision(17);
    text << "row " << row << ", found:";
    for (const std::uint32_t i : result.order) {
      const ContactTerm& term = result.terms[i];
      if (term.row != row) continue;
      ++found;
      text << "  candidate " << term.candidate << " coefficient " << term.coefficient()
           << " weight";
      for (const double weight : result.pushes[i].weight) text << ' ' << weight;
    }
    text << "\nexpected:";
    for (std::size_t k = 0; k < expected.pairs.size(); ++k) {
      if (expected.rows[k] != row) continue;
      ++wanted;
      text << "  candidate " << expected.candidates[k] << " coefficient "
           << expected.pairs[k].coefficient << " weight";
      for (const double weight : expected.pairs[k].weight) text << ' ' << weight;
    }
    if (found != wanted) return text.str();
  }
  return "none";
}

// Evaluates on the device and compares with the CPU. Returns the number of terms.
std::size_t compare(ComputeNarrowPhase& device, const Input& input) {
  const Expected expected = expected_of(input);
  device.set_candidates(input.rows, input.candidates);
  const ContactResult result = device.evaluate(input.groups, input.x, input.v);
  EXPECT_EQ(result.touching, expected.touching);
  EXPECT_EQ(result.order.size(), expected.pairs.size())
      << first_difference(result, expected, input);
  if (testing::Test::HasFailure()) return 0;
  for (std::size_t k = 0; k < result.order.size(); ++k) {
    const std::uint32_t i = result.order[k];
    const ContactTerm& term = result.terms[i];
    EXPECT_EQ(term.candidate, expected.candidates[k]);
    EXPECT_EQ(term.row, expected.rows[k]);
    EXPECT_EQ(term.coefficient(), expected.pairs[k].coefficient);
    // At the very end of the range the push is a rounding error, or zero.
    if (term.slides() != expected.slidings[k].has_value()) {
      const double size = input.rows[term.row].stiffness * input.groups.front().range;
      EXPECT_LT(std::abs(expected.pairs[k].push), 1e-14 * size);
    }
    EXPECT_EQ(term.is_mollified(), expected.turning[k].has_value());
    expect_same(result, i, expected, k, input);
    if (testing::Test::HasFailure()) {
      ADD_FAILURE() << "term " << k << " of " << result.order.size();
      return 0;
    }
  }
  return result.order.size();
}

const ContactGroup usual_law{.thickness = 0.125,
                             .range = 0.375,
                             .damping_time = 1e-3,
                             .friction = 0.3,
                             .friction_speed = 0.1};

// Four points of a lattice, or near it. Points, edges and faces coincide, edges are parallel or
// points, triangles have no area, and distances are exactly the reach.
std::array<Vec3, 4> random_points(std::mt19937& random) {
  constexpr std::array shifts{0.0, 0.0, 1e-16, 1e-9, 3e-7, 1e-4, 0.1};
  const double shift = shifts[random() % shifts.size()];
  std::uniform_real_distribution<double> moved(-shift, shift);
  std::array<Vec3, 4> x;
  for (Vec3& point : x) {
    for (int axis = 0; axis < 3; ++axis)
      point[axis] = 0.25 * static_cast<double>(random() % 4) + moved(random);
  }
  return x;
}

// Random pairs, each with four points of its own. Those that touch are left out.
Input random_pairs(int count, bool edges, bool obstacle, std::mt19937& random) {
  Input input;
  ContactGroup group = usual_law;
  group.edges = edges;
  group.obstacle = obstacle;
  group.spin = {0.3, -0.2, 0.5};
  input.add_group(group);
  for (int k = 0; k < count; ++k) {
    const auto points = random_points(random);
    const auto first = static_cast<int>(input.x.size());
    input.x.insert(input.x.end(), points.begin(), points.end());
    input.add_row(2.0, edges && k % 2 == 0 ? 1e-3 : 0);
    input.add_candidate({first, first + 1, first + 2, first + 3});
    const Closest closest = input.closest(input.candidates.size() - 1, edges);
    if (std::sqrt(closest.squared_distance) - group.thickness > 0) continue;
    input.candidates.pop_back();
    input.triangles.pop_back();
    input.rows.pop_back();
  }
  input.move_randomly(random);
  return input;
}

class ComputeNarrowPhases : public testing::TestWithParam<std::tuple<bool, bool>> {};

TEST_P(ComputeNarrowPhases, FindWhatTheCpuFindsOfRandomAndDegeneratePairs) {
  WEFT_NEEDS_CONTEXT();
  const auto [edges, obstacle] = GetParam();
  std::mt19937 random(41);
  ComputeNarrowPhase device(context);
  const Input input = random_pairs(20000, edges, obstacle, random);
  const std::size_t found = compare(device, input);
  EXPECT_GT(found, 2000);
  EXPECT_LT(found, input.rows.size());
  EXPECT_GT(device.reruns(), 0);  // the first lists are shorter
  const int reruns = device.reruns();
  device.evaluate(input.groups, input.x, input.v);
  EXPECT_EQ(device.reruns(), reruns);  // the room is kept
}

std::string name_of(const testing::TestParamInfo<std::tuple<bool, bool>>& tested) {
  const auto [edges, obstacle] = tested.param;
  return std::string(edges ? "Edges" : "Triangles") + (obstacle ? "OfObstacles" : "");
}

INSTANTIATE_TEST_SUITE_P(Pairs, ComputeNarrowPhases,
                         testing::Combine(testing::Bool(), testing::Bool()), name_of);

bsi::Surface placed(bsi::Surface surface, const Vec3& at, double noise, std::mt19937& random) {
  std::uniform_real_distribution<double> shift(-noise, noise);
  for (Vec3& p : surface.positions) p += at + Vec3(shift(random), shift(random), shift(random));
  return surface;
}

// Sheets over a sheet, a torus and a sphere, and a rolled sheet. Without noise, samples
// lie exactly over vertices, edges and faces.
Input sheets(double noise, std::mt19937& random) {
  Input input;
  ContactGroup law = usual_law;
  law.thickness = 0.01;
  law.range = 0.24;
  law.friction_speed = 1;
  const int sheet =
      input.add_surface(placed(bsi::make_rectangle(2, 2, 17, 17), {0, 0, 0}, noise, random));
  const int other =
      input.add_surface(placed(bsi::make_rectangle(2, 2, 9, 9), {0.0, 0, 0.125}, noise, random));
  const int torus =
      input.add_surface(placed(bsi::make_torus(0.7, 0.3, 19, 12), {0, 0, -0.43}, noise, random));
  const int sphere =
      input.add_surface(placed(bsi::make_sphere(0.4, 6), {0.5, 0, 0.55}, noise, random));
  bsi::Surface roll = bsi::make_rectangle(1, 1, 6, 21);
  for (Vec3& p : roll.positions) {
    const double turn = 8 * (p.x() + 0.5), radius = 0.2 + 0.02 * turn;
    p = {radius * std::cos(turn) - 3, p.y(), radius * std::sin(turn)};
  }
  const int rolled = input.add_surface(placed(roll, {0, 0, 0}, noise, random));
  for (const auto& [from, to] : {std::pair(sheet, other), std::pair(other, sheet),
                                 std::pair(other, sphere), std::pair(rolled, rolled)})
    input.add_samples(from, to, law);
  law.obstacle = true;
  law.spin = {1, -2, 0.5};
  input.add_samples(sheet, torus, law);
  input.move_randomly(random);
  return input;
}

TEST(ComputeNarrowPhase, FindsTheTermsThatTheCpuFindsAroundSamples) {
  WEFT_NEEDS_CONTEXT();
  std::mt19937 random(42);
  ComputeNarrowPhase device(context);
  for (const double noise : {0.0, 1e-12, 0.01}) {
    const Input input = sheets(noise, random);
    EXPECT_GT(compare(device, input), 300) << noise;
    const ContactResult result = device.evaluate(input.groups, input.x, input.v);
    const auto subtracted = std::ranges::count_if(
        result.terms, [](const ContactTerm& term) { return term.coefficient() < 0; });
    EXPECT_GT(subtracted, 20) << noise;
  }
}

TEST(ComputeNarrowPhase, GivesTheSameBitsEachTime) {
  WEFT_NEEDS_CONTEXT();
  std::mt19937 random(43);
  const Input input = sheets(0.01, random);
  ComputeNarrowPhase device(context);
  device.set_candidates(input.rows, input.candidates);
  std::vector<double> first;
  for (int run = 0; run < 3; ++run) {
    const ContactResult result = device.evaluate(input.groups, input.x, input.v);
    std::vector<double> values;
    for (const std::uint32_t i : result.order) {
      const ContactPush& push = result.pushes[i];
      values.insert(values.end(), {push.energy, push.push, push.damping, push.normal[0]});
      if (!result.terms[i].slides()) continue;
      const auto& force = result.slidings[i].force;
      values.insert(values.end(), force.begin(), force.end());
    }
    if (run == 0) first = values;
    EXPECT_EQ(values, first);
  }
  EXPECT_GT(first.size(), 1000);
}

TEST(ComputeNarrowPhase, NamesTheFirstCandidateThatTouches) {
  WEFT_NEEDS_CONTEXT();
  ComputeNarrowPhase device(context);
  for (const bool samples : {false, true}) {
    Input input;
    ContactGroup group = usual_law;
    input.add_group(group);
    const std::vector<Vec3> triangle{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    input.x = triangle;
    for (const double height : {0.6, 0.3, 0.2, 0.125, 0.1, 0.3, -0.01}) {
      input.x.emplace_back(0.25, 0.25, height);
      input.add_row(1);
      input.add_candidate({static_cast<int>(input.x.size()) - 1, 0, 1, 2});
    }
    input.groups[0].samples = samples;
    input.v.assign(input.x.size(), Vec3::Zero());
    device.set_candidates(input.rows, input.candidates);
    EXPECT_EQ(device.evaluate(input.groups, input.x, input.v).touching, 3U);
    for (std::size_t i = 3; i < input.x.size(); ++i) input.x[i].z() += 0.2;
    EXPECT_EQ(device.evaluate(input.groups, input.x, input.v).touching, std::nullopt);
  }
}

TEST(ComputeNarrowPhase, LeavesOutCandidatesBeyondTheLimitOfTheirGroup) {
  WEFT_NEEDS_CONTEXT();
  std::mt19937 random(44);
  Input input = random_pairs(300, false, false, random);
  for (std::size_t i = 0; i < input.candidates.size(); ++i)
    input.candidates[i].distance = static_cast<float>(i % 3);
  ComputeNarrowPhase device(context);
  device.set_candidates(input.rows, input.candidates);
  const std::size_t all = device.evaluate(input.groups, input.x, input.v).terms.size();
  input.groups[0].limit = 1;
  const ContactResult result = device.evaluate(input.groups, input.x, input.v);
  EXPECT_LT(result.terms.size(), all);
  EXPECT_GT(result.terms.size(), 0);
  for (const ContactTerm& term : result.terms) EXPECT_NE(term.candidate % 3, 2);
}

TEST(ComputeNarrowPhase, FindsNothingWithoutCandidates) {
  WEFT_NEEDS_CONTEXT();
  ComputeNarrowPhase device(context);
  EXPECT_TRUE(device.evaluate({}, {}, {}).terms.empty());
  device.set_candidates({}, {});
  const std::vector<Vec3> x(3, Vec3::Zero());
  const ContactResult result = device.evaluate(std::span(&usual_law, 1), x, x);
  EXPECT_TRUE(result.terms.empty());
  EXPECT_EQ(result.touching, std::nullopt);
}

// One pair, in contact with friction, repeated until its results exceed the largest buffer. After
// the error, the device works with fewer pairs.
TEST(ComputeNarrowPhase, SaysWhichListTheDeviceCannotHold) {
  WEFT_NEEDS_CONTEXT();
  const std::size_t limit = buffer_limit(context.functions());
  if (limit > std::size_t{1} << 28)
    GTEST_SKIP() << "the device has buffers of " << limit << " bytes";
  Input input;
  input.add_group(usual_law);
  input.x = {{0.25, 0.25, 0.3}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  input.v.assign(4, Vec3(0.1, 0.2, 0.3));
  for (std::size_t i = 0; i <= limit / sizeof(ContactSliding); ++i) {
    input.add_row(1);
    input.add_candidate({0, 1, 2, 3});
  }
  ComputeNarrowPhase device(context);
  device.set_candidates(input.rows, input.candidates);
  try {
    device.evaluate(input.groups, input.x, input.v);
    FAIL() << "no error";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("friction of contact take"), std::string::npos)
        << error.what();
  }
  input.rows.resize(100);
  input.candidates.resize(100);
  device.set_candidates(input.rows, input.candidates);
  EXPECT_EQ(device.evaluate(input.groups, input.x, input.v).terms.size(), 100);
}

// Logarithms of numbers near 1, near powers of 2, and of all magnitudes.
TEST(ComputeNarrowPhase, ItsLogarithmIsThatOfTheLibrary) {
  WEFT_NEEDS_CONTEXT();
  std::mt19937_64 random(45);
  std::uniform_real_distribution<double> exponent(-300, 300), mantissa(0.5, 2);
  std::vector<double> x{1, 0.5, 2, std::sqrt(0.5), std::sqrt(2), 1 - 0x1p-53, 1 + 0x1p-52};
  for (int i = 0; i < 30000; ++i) {
    x.push_back(std::pow(10.0, exponent(random)));
    x.push_back(mantissa(random));
    x.push_back(1 + (mantissa(random) - 1) * std::pow(2.0, -static_cast<double>(random() % 50)));
  }
  const GlFunctions& gl = context.functions();
  GlBuffer buffer(gl);
  buffer.reserve(x.size() * sizeof(double), "numbers");
  buffer.write(std::span<const double>(x));
  buffer.bind(0);
  ComputeProgram program(gl, std::string("#version 450 core\nlayout(local_size_x = 64) in;\n") +
                                 "layout(std430, binding = 0) buffer X { double x[]; };\n" +
                                 shaders::logarithm +
                                 "void main() { uint i = gl_GlobalInvocationID.x; "
                                 "if (i < x.length()) x[i] = log_of(x[i]); }");
  program.use();
  gl.DispatchCompute(static_cast<GLuint>(x.size() / 64 + 1), 1, 1);
  gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  std::vector<double> found(x.size());
  buffer.read(std::span(found));
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double expected = std::log(x[i]);
    ASSERT_LE(std::abs(found[i] - expected), 0x1p-51 * std::abs(expected)) << x[i];
  }
}

}  // namespace
}  // namespace weft::gpu::compute_narrow_phase_test
