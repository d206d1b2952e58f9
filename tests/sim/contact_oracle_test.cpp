// The contact search and the path check against every pair of features, at rest and in motion: for
// a sheet folded on itself, a crumpled one, two bodies and three.
#include "tests/sim/contact_oracle.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <set>

#include "bsi/proximity.h"
#include "materials/contact.h"
#include "sim/case/case_reader.h"
#include "sim/contact/contact.h"

namespace weft::sim::contact_oracle_test {
namespace {

using Positions = std::vector<Vec3>;

constexpr double thickness = 0.004, range = 0.03, slack = 0.02;  // m, of all scenes
constexpr double reach = thickness + range;

const std::string one_sheet = R"(
[time]
duration = 1
[contact]
range = 0.03
search_slack = 0.02
[[body]]
name = "sheet"
thickness = 0.004
shape = { type = "rectangle", size = [1, 1], resolution = [9, 9] }
)";

// A sheet whose edges are shorter than thickness + range: most triangles in reach are neighbours.
const std::string fine_sheet = R"(
[time]
duration = 1
[contact]
range = 0.03
search_slack = 0.02
[[body]]
name = "sheet"
thickness = 0.004
shape = { type = "rectangle", size = [0.25, 0.25], resolution = [11, 11] }
)";

// Two strips in line; the gap between their bounding spheres is that of the strips within 2 mm.
const std::string two_strips = R"(
[time]
duration = 1
[contact]
range = 0.03
search_slack = 0.02
[[body]]
name = "left"
thickness = 0.004
shape = { type = "rectangle", size = [1, 0.06], resolution = [2, 17] }
[[body]]
name = "right"
thickness = 0.004
shape = { type = "rectangle", size = [1, 0.06], resolution = [2, 17] }
)";

const std::string three_plates = R"(
[time]
duration = 1
[contact]
range = 0.03
search_slack = 0.02
[[body]]
name = "upper"
thickness = 0.004
shape = { type = "rectangle", size = [0.5, 0.5], resolution = [4, 4] }
[[body]]
name = "middle"
thickness = 0.004
shape = { type = "rectangle", size = [0.5, 0.5], resolution = [4, 4] }
[[body]]
name = "lower"
thickness = 0.004
shape = { type = "rectangle", size = [0.5, 0.5], resolution = [4, 4] }
)";

std::unique_ptr<const Scene> scene_of(const std::string& text) {
  return build_scene(parse_case(text, "test.toml"));
}

Positions shifted(Positions positions, double amplitude, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> shift(-amplitude, amplitude);
  for (Vec3& x : positions) {
    const double along_x = shift(random), along_y = shift(random), along_z = shift(random);
    x += Vec3(along_x, along_y, along_z);
  }
  return positions;
}

// Folds the sheet along its middle column into two layers `gap` apart, with the middle of the body
// in place.
Positions folded(const Scene& scene, double gap) {
  Positions positions = scene.initial_position;
  for (Vec3& x : positions) {
    const double side = std::abs(x.x()) < 1e-9 ? 0 : x.x() < 0 ? -1 : 1;
    x = Vec3(-std::abs(x.x()) + 0.01 * side, x.y() + 0.015 * side, 0.5 * gap * side);
  }
  return positions;
}

// Folds the sheet into narrow pleats and squeezes it along them until opposite edges of one quad
// are in reach.
Positions crumpled(const Scene& scene, unsigned seed) {
  Positions positions = scene.initial_position;
  for (Vec3& x : positions) {
    const bool odd = std::lround(8 * (x.x() + 0.5)) % 2 == 1;
    x = Vec3(0.12 * x.x(), 0.2 * x.y(), odd ? 0.12 : 0);
  }
  return shifted(positions, 0.003, seed);
}

Positions strips(const Scene& scene, const Vec3& between) {
  Positions positions = scene.initial_position;
  const int count = scene.bodies[0].particle_count();
  for (int i = 0; i < scene.particle_count; ++i)
    positions[i] += i < count ? Vec3(-0.5, 0, 0) : Vec3(Vec3(0.5, 0, 0) + between);
  return positions;
}

// Puts the middle plate at the origin, the upper one above it, the lower one below its edge.
Positions plates(const Scene& scene, double upper, double lower) {
  Positions positions = scene.initial_position;
  const Vec3 places[] = {{0, 0, upper}, {0, 0, 0}, {0.45, 0, -lower}};
  for (int b = 0; b < 3; ++b) {
    const SceneBody& body = scene.bodies[b];
    for (int i = 0; i < body.particle_count(); ++i) positions[body.first_particle + i] += places[b];
  }
  return positions;
}

class Searched {
 public:
  explicit Searched(const std::string& text)
      : scene(scene_of(text)),
        oracle(*scene),
        search(*scene, statistics, {make_cpu_search(*scene), {}}) {}

  // Returns the number of pairs in reach at `positions`; checks that the lists contain all of them.
  std::size_t update(const Positions& positions) {
    EXPECT_FALSE(search.update(positions));
    EXPECT_EQ(oracle.missing(search.lists(), positions), "");
    return oracle.in_reach(positions).size();
  }
  // Checks the lists at every point of a path.
  std::size_t update_path(const Positions& start, const Positions& end) {
    EXPECT_FALSE(search.update_path(start, end));
    std::size_t in_reach = 0;
    for (const double t : {0.0, 0.3, 0.5, 0.8, 1.0}) {
      Positions between = start;
      for (std::size_t i = 0; i < start.size(); ++i) between[i] += t * (end[i] - start[i]);
      EXPECT_EQ(oracle.missing(search.lists(), between), "") << t;
      in_reach += oracle.in_reach(between).size();
    }
    return in_reach;
  }
  // Checks all states of a motion in order. Then checks the paths from each state to the next, each
  // after another path that is tried and dropped.
  void follow(int states, const std::function<Positions(int)>& state) {
    std::size_t in_reach = 0;
    for (int k = 0; k < states; ++k) in_reach += update(state(k));
    EXPECT_GT(in_reach, 0U);
    // Some states reuse the lists.
    EXPECT_LT(statistics.counters.rebuilds, states * static_cast<int>(scene->bodies.size()));
    for (int k = 0; k + 1 < states; ++k) {
      const Positions start = state(k), end = state(k + 1);
      update_path(start, shifted(end, 0.3 * slack, 100 + k));
      in_reach += update_path(start, end);
    }
    EXPECT_GT(in_reach, 0U);
  }

  std::unique_ptr<const Scene> scene;
  ContactOracle oracle;
  Statistics statistics;
  ContactSearch search;
};

// Both layers move equally towards each other: a distance changes by twice as much as each moves.
TEST(ContactOracle, ListsOfAFoldedSheetAreComplete) {
  Searched folding(one_sheet);
  folding.follow(24, [&](int k) {
    const double gap = reach + slack * (1.3 - 0.2 * (k < 12 ? k : 24 - k));
    return shifted(folded(*folding.scene, gap), 0.0005, 7 + k);
  });
}

TEST(ContactOracle, ListsOfACrumpledSheetAreComplete) {
  Searched crumpling(one_sheet);
  // Two opposite edges at the border belong to one quad.
  const bsi::Mesh& mesh = crumpling.scene->bodies[0].mesh;
  std::vector<int> quad_of_edge(mesh.edges.size(), -1);
  for (std::size_t q = 0; q + 1 < mesh.owned_edge_start.size(); ++q)
    for (const int e : mesh.edges_of_quad(static_cast<int>(q)))
      quad_of_edge[e] = static_cast<int>(q);
  const auto is_of_one_quad = [&](const OraclePair& pair) {
    return pair.edges() && quad_of_edge[pair.a] == quad_of_edge[pair.b];
  };
  // Squeezed, those edges come within the short range of edges.
  const auto squeezed = [&](unsigned seed) {
    Positions positions = crumpled(*crumpling.scene, seed);
    for (Vec3& x : positions) x.y() *= 0.4;
    return positions;
  };
  const Positions start = squeezed(1), end = squeezed(2);
  ASSERT_TRUE(std::ranges::any_of(crumpling.oracle.in_reach(start), is_of_one_quad));
  crumpling.follow(12, [&](int k) {
    Positions between = start;
    for (std::size_t i = 0; i < start.size(); ++i)
      between[i] += 0.3 * k * (end[i] - start[i]) + Vec3(0, 0, 0.01 * k);
    return between;
  });
}

// The bodies move from beyond the slack into reach and back, so slowly that pairs are known for
// long to be out of reach.
TEST(ContactOracle, ListsOfTwoBodiesAreComplete) {
  Searched approaching(two_strips);
  approaching.follow(40, [&](int k) {
    const double gap = 0.008 + 0.004 * std::abs(k - 20);
    return strips(*approaching.scene, {gap, 0.003 * k - 0.05, 0.0005 * k});
  });
}

// A folded sheet with a bulge that wanders over its lower layer, and dents the upper one where it
// comes near. Most points rest, so that few of the pairs are looked for again.
class Bulging : public Searched {
 public:
  explicit Bulging(double gap) : Searched(one_sheet), still_(folded(*scene, gap)) {}

  Positions state(int k, double height) const {
    Positions positions = still_;
    const Vec3 centre(0.25 * std::cos(0.2 * k), 0.3 * std::sin(0.13 * k), 0);
    for (Vec3& x : positions) {
      const double off = Vec3(x.x() - centre.x(), x.y() - centre.y(), 0).squaredNorm() / 0.006;
      x.z() += (x.z() < 0 ? 1.6 : 0.4) * height * std::exp(-off);
    }
    return positions;
  }
  // Notes the work of the first search.
  void note_first() {
    looked_at_ = statistics.counters.narrow_phase_calls;
    built_ = statistics.counters.self_traversals;
  }
  // Checks that later searches have looked at fewer pairs each. The folds of the bulge add pairs
  // that the first search leaves out; with all points recorded anew, the later ones look at more.
  void expect_little_work() const {
    const auto built = statistics.counters.self_traversals - built_;
    EXPECT_GT(built, 10);
    EXPECT_LT(statistics.counters.narrow_phase_calls - looked_at_, built * looked_at_);
  }

 private:
  Positions still_;
  std::int64_t looked_at_ = 0, built_ = 0;
};

TEST(ContactOracle, ListsAreCompleteWherePartsOfABodyMove) {
  Bulging bulging(reach + 0.8 * slack);
  const auto state = [&](int k) { return bulging.state(k, slack); };
  std::size_t in_reach = bulging.update(state(0));
  bulging.note_first();
  for (int k = 1; k < 80; ++k) in_reach += bulging.update(state(k));
  bulging.expect_little_work();
  // Short paths, and long ones, for which the whole body is recorded.
  for (int k = 1; k < 80; ++k)
    in_reach +=
        bulging.update_path(state(k), shifted(state(k % 8 == 0 ? k + 3 : k), 0.001, 11 + k));
  EXPECT_GT(in_reach, 100U);
}

// Both ends of long paths change in a part of the body, as where a step is solved again.
TEST(ContactOracle, ListsAreCompleteWherePartsOfPathsChange) {
  Bulging bulging(reach + 0.8 * slack);
  const auto path = [&](int k) {
    return bulging.update_path(bulging.state(k, slack), bulging.state(k + 1, -slack));
  };
  std::size_t in_reach = path(0);
  bulging.note_first();
  for (int k = 1; k < 80; ++k) in_reach += path(k);
  bulging.expect_little_work();
  EXPECT_GT(in_reach, 20U);
}

// Paths of two bodies that share some ends. Any other end may bring the bodies into reach.
class SharedEnds : public Searched {
 public:
  SharedEnds() : Searched(two_strips) {}

  // The left and the right body are `left` and `right` slacks from places whose gap is 0.3 slacks
  // out of reach.
  Positions at(double left, double right) const {
    Positions positions = strips(*scene, {reach + (0.3 + right) * slack, 0.002, 0.001});
    for (int i = 0; i < scene->bodies[0].particle_count(); ++i) positions[i].x() += left * slack;
    return positions;
  }
};

TEST(ContactOracle, ListsAreCompleteAlongPathsThatShareSomeEnds) {
  SharedEnds walking;
  std::mt19937 random(5);
  const auto up_to = [&](int count) { return static_cast<int>(random() % count); };
  double starts[2] = {0, 0}, ends[2] = {0, 0};  // slacks, by body
  std::size_t in_reach = 0;
  for (int k = 0; k < 400; ++k) {
    for (double* const each : {&starts[0], &starts[1], &ends[0], &ends[1]})
      if (up_to(2) == 0) *each = 0.2 * (up_to(3) - 1);
    const Positions start = walking.at(starts[0], starts[1]), end = walking.at(ends[0], ends[1]);
    in_reach += up_to(4) == 0 ? walking.update(end) : walking.update_path(start, end);
  }
  EXPECT_GT(in_reach, 500U);
  EXPECT_LT(walking.statistics.counters.pair_traversals, 100);
}

// The left body keeps its path, the right one rests at the end of its own.
TEST(ContactOracle, ListsAreCompleteWhereOneBodyWaitsForTheOther) {
  SharedEnds waiting;
  EXPECT_EQ(waiting.update_path(waiting.at(0.2, 0), waiting.at(0, -0.2)), 0U);
  EXPECT_GT(waiting.update_path(waiting.at(0.2, -0.2), waiting.at(0, -0.2)), 0U);
  EXPECT_EQ(waiting.statistics.counters.pair_traversals, 1);
}

// Both layers of a folded sheet leap towards each other, which gives them a list without pairs
// between them. A part of one layer moves on, and gives them a list with the whole slack. It must
// serve where both come into reach within that.
TEST(ContactOracle, ListsAreCompleteAgainAfterALeap) {
  Searched leaping(one_sheet);
  const auto state = [&](double slacks, double bulge) {
    Positions positions = folded(*leaping.scene, reach + slacks * slack);
    for (Vec3& x : positions)
      if (x.x() < -0.3 && x.z() > 0) x.z() += bulge * slack;
    return positions;
  };
  leaping.update(state(6, 0));
  leaping.update(state(0.15, 0));
  const std::size_t near_the_fold = leaping.update(state(0.15, 0.4));
  EXPECT_GT(leaping.update(state(-0.03, 0.4)), near_the_fold + 10);
}

// The upper plate approaches until it may have met the middle one, but not yet the lower one, and
// then returns. The lists of the middle plate are rebuilt while the lower plate is nearly its whole
// slack away from where its own lists were built.
TEST(ContactOracle, ListsOfThreeBodiesAreCompleteWhenOneOfThemComes) {
  Searched coming(three_plates);
  const double near = reach + 0.15 * slack;
  coming.update(plates(*coming.scene, 2, near));
  coming.update(plates(*coming.scene, 2, near + 0.9 * slack));
  coming.update(plates(*coming.scene, 0.7, near + 0.9 * slack));
  EXPECT_GT(coming.update(plates(*coming.scene, 0.7, near - 0.3 * slack)), 0U);
}

// All three plates move together, farther than the slack, which costs no list anything. The upper
// one then comes nearer, and its list with the middle one is built again. The lower one, which has
// moved as far and stays in reach of the middle one, must be recorded with it.
TEST(ContactOracle, ListsOfThreeBodiesAreCompleteWhereTheyMoveTogether) {
  Searched moving(three_plates);
  const auto at = [&](double way, double upper) {
    Positions positions = plates(*moving.scene, upper, reach - 0.1 * slack);
    for (Vec3& x : positions) x.z() += way;
    return positions;
  };
  moving.update(at(0, reach - 0.1 * slack));
  const auto before = moving.statistics.counters.pair_traversals;
  moving.update(at(0.5, reach - 0.1 * slack));
  EXPECT_EQ(moving.statistics.counters.pair_traversals, before);
  EXPECT_GT(moving.update(at(0.5, reach - 1.3 * slack)), 0U);
  EXPECT_GT(moving.statistics.counters.pair_traversals, before);
}

TEST(ContactOracle, TheSmallestGapIsThatOfAllPairs) {
  const auto scene = scene_of(one_sheet);
  const ContactOracle oracle(*scene);
  Statistics statistics;
  Contact contact(*scene, statistics);
  for (unsigned seed = 0; seed < 5; ++seed) {
    for (const Positions& positions :
         {crumpled(*scene, seed), shifted(folded(*scene, 0.02), 0.004, seed)}) {
      double gap = 0;
      EXPECT_FALSE(contact.check_state(positions, &gap));
      EXPECT_NEAR(gap, oracle.smallest_gap(positions), 1e-12);
    }
  }
}

// Numbers of paths that had to be refused, and to be accepted.
struct Answers {
  int refused = 0, accepted = 0;
};

Answers answers_to_paths(const Scene& scene, const std::function<Positions(unsigned)>& start_of,
                         const std::function<Positions(const Positions&, unsigned)>& end_of) {
  const ContactOracle oracle(scene);
  Statistics statistics;
  Contact contact(scene, statistics);
  Answers answers;
  for (unsigned seed = 0; seed < 24; ++seed) {
    const Positions start = start_of(seed), end = end_of(start, seed);
    EXPECT_GT(oracle.smallest_gap(start), 0);
    const auto verdict = oracle.verdict(start, end);
    const bool refused = contact.check_path(start, end).has_value();
    if (!verdict) continue;
    EXPECT_EQ(refused, *verdict == ContactOracle::Verdict::refused) << seed;
    ++(refused ? answers.refused : answers.accepted);
  }
  return answers;
}

// Rolls the sheet up about y by this angle, and lays its ends over each other if the angle exceeds
// a turn: the radius grows by `rise` from one end to the other.
Positions rolled(const Scene& scene, double angle, double rise) {
  Positions positions = scene.initial_position;
  for (Vec3& x : positions) {
    const double part = x.x() / 0.25 + 0.5, turned = angle * part;
    const double radius = 0.25 / angle + rise * (part - 0.5);
    x = Vec3(radius * std::sin(turned), x.y(), -radius * std::cos(turned));
  }
  return positions;
}

// Moves particles at random, by almost nothing up to more than the width of a pleat.
Positions shaken(const Positions& start, unsigned seed) {
  return shifted(start, 2e-4 * std::pow(1.25, seed), 50 + seed);
}

TEST(ContactOracle, PathsOfAFoldedSheetAreAnsweredRightly) {
  const auto scene = scene_of(one_sheet);
  const Answers answers = answers_to_paths(
      *scene, [&](unsigned seed) { return shifted(folded(*scene, 0.02), 0.002, seed); }, shaken);
  EXPECT_GT(answers.refused, 3);
  EXPECT_GT(answers.accepted, 3);
}

TEST(ContactOracle, PathsOfACrumpledSheetAreAnsweredRightly) {
  const auto scene = scene_of(one_sheet);
  const Answers answers = answers_to_paths(
      *scene, [&](unsigned seed) { return crumpled(*scene, seed); }, shaken);
  EXPECT_GT(answers.refused, 3);
  EXPECT_GT(answers.accepted, 3);
}

TEST(ContactOracle, ListsOfAFineSheetAreComplete) {
  Searched rolling(fine_sheet);
  const auto is_near = [](const OraclePair& pair) { return pair.neighbours; };
  ASSERT_GT(std::ranges::count_if(rolling.oracle.pairs(), is_near), 1000);
  rolling.follow(12, [&](int k) {
    return shifted(rolled(*rolling.scene, 6.6 + 0.1 * k, 0.05 - 0.002 * k), 0.001, 3 + k);
  });
}

// Neighbours come as close as they like, but do not pass through each other.
TEST(ContactOracle, PathsOfAFineSheetAreAnsweredRightly) {
  const auto scene = scene_of(fine_sheet);
  const Answers answers = answers_to_paths(
      *scene, [&](unsigned seed) { return shifted(rolled(*scene, 7.2, 0.045), 0.001, seed); },
      [](const Positions& start, unsigned seed) {
        return shifted(start, 5e-4 * std::pow(1.25, seed), 50 + seed);
      });
  EXPECT_GT(answers.refused, 3);
  EXPECT_GT(answers.accepted, 3);
}

// One strip passes the end of the other from above to below, half a millimetre away and more. With
// less than half the thickness between them, the path counts as cutting through.
TEST(ContactOracle, PathsBesideABodyKeepHalfOfTheThickness) {
  const auto scene = scene_of(two_strips);
  const auto by = [&](double gap, double height) { return strips(*scene, {gap, 0, height}); };
  const Answers answers = answers_to_paths(
      *scene, [&](unsigned seed) { return by(0.0005 + 0.00025 * seed, 0.013); },
      [&](const Positions&, unsigned seed) { return by(0.0005 + 0.00025 * seed, -0.017); });
  EXPECT_GT(answers.refused, 3);
  EXPECT_GT(answers.accepted, 3);
  Statistics statistics;
  Contact contact(*scene, statistics);
  EXPECT_TRUE(contact.check_path(by(0.25 * thickness, 0.013), by(0.25 * thickness, -0.017)));
  EXPECT_FALSE(contact.check_path(by(0.9 * thickness, 0.004), by(0.9 * thickness, -0.004)));
}

// The end of a path must keep the whole thickness.
TEST(ContactOracle, PathsThatEndWithoutAGapAreRefused) {
  const auto scene = scene_of(two_strips);
  Statistics statistics;
  Contact contact(*scene, statistics);
  const Positions start = strips(*scene, {2 * thickness, 0, 0});
  const auto fault = contact.check_path(start, strips(*scene, {0.75 * thickness, 0, 0}));
  ASSERT_TRUE(fault);
  EXPECT_EQ(fault->kind, ContactFault::Kind::touching);
  EXPECT_FALSE(contact.check_path(start, strips(*scene, {1.25 * thickness, 0, 0})));
}

// The energy of contact by its definition (docs/theory.md, section 7): feature by feature, without
// lists, pyramids or cancelled terms.
class EnergyByFeature {
 public:
  explicit EnergyByFeature(const Scene& scene) : scene_(scene) {
    const auto lists = searched_pairs(scene);
    const ContactOracle oracle(scene);
    for (const OraclePair& pair : oracle.pairs()) {
      if (!pair.neighbours) continue;
      auto& found = pair.edges() ? near_edges_ : near_triangles_;
      found.insert({lists[pair.list].body_a, pair.a, pair.b});
    }
  }

  double energy(const Positions& x) const {
    double sum = 0;
    const int bodies = static_cast<int>(scene_.bodies.size());
    for (int a = 0; a < scene_.dynamic_bodies; ++a) {
      for (int b = a; b < bodies; ++b) {
        sum += samples(a, b, x) + edges(a, b, x);
        if (a == b) continue;
        sum += scene_.bodies[b].dynamic ? samples(b, a, x) : obstacle_vertices(a, b, x);
      }
    }
    return sum;
  }

 private:
  static double barrier(double distance, double share) {
    const double gap = distance - thickness, end = share * range;
    return gap < end ? materials::barrier(gap, end, 1).value : 0;
  }
  double stiffness() const { return scene_.source.contact.stiffness; }
  double area(const SceneBody& body, int vertex) const {
    return scene_.contact_area[body.first_particle + vertex];
  }

  // Sums over the vertices of one body against the surface of another, or of itself.
  double samples(int of, int against, const Positions& x) const {
    const SceneBody& from = scene_.bodies[of];
    double sum = 0;
    for (int v = 0; v < from.particle_count(); ++v) {
      sum += (scene_.bodies[against].dynamic ? 0.5 : 1) * stiffness() * area(from, v) *
             surface(against, x[from.first_particle + v], of == against ? v : -1, x);
    }
    return sum;
  }

  double surface(int number, const Vec3& point, int own, const Positions& x) const {
    const SceneBody& body = scene_.bodies[number];
    const Vec3* at = x.data() + body.first_particle;
    const auto holds = [&](int t) {
      const auto& corners = body.mesh.triangles[t];
      return std::find(corners.begin(), corners.end(), own) != corners.end() ||
             (own >= 0 && near_triangles_.contains({number, own, t}));
    };
    std::vector<char> is_inner(body.particle_count(), 1);
    double sum = 0;
    for (int t = 0; t < static_cast<int>(body.mesh.triangles.size()); ++t) {
      const auto& [a, b, c] = body.mesh.triangles[t];
      if (holds(t)) is_inner[a] = is_inner[b] = is_inner[c] = 0;
      if (!holds(t)) sum += barrier(distance(point, at[a], at[b], at[c]), 1);
    }
    for (const bsi::Edge& edge : body.mesh.edges) {
      const auto [a, b] = edge.vertex;
      if (edge.triangle[1] < 0) is_inner[a] = is_inner[b] = 0;
      if (edge.triangle[1] < 0 || holds(edge.triangle[0]) || holds(edge.triangle[1])) continue;
      sum -= barrier(distance(point, at[a], at[b], at[b]), 1);
    }
    for (int v = 0; v < body.particle_count(); ++v) {
      if (is_inner[v] != 0) sum += barrier((point - at[v]).norm(), 1);
    }
    return sum;
  }
  static double distance(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
    return std::sqrt(bsi::closest_vertex_triangle(p, a, b, c).squared_distance);
  }

  double obstacle_vertices(int dynamic, int obstacle, const Positions& x) const {
    const SceneBody &body = scene_.bodies[dynamic], &other = scene_.bodies[obstacle];
    const Vec3* at = x.data() + body.first_particle;
    double sum = 0;
    for (int v = 0; v < other.particle_count(); ++v) {
      for (const auto& [a, b, c] : body.mesh.triangles) {
        const double mean = (area(body, a) + area(body, b) + area(body, c)) / 3;
        sum += 16 * stiffness() * mean *
               barrier(distance(x[other.first_particle + v], at[a], at[b], at[c]), 0.25);
      }
    }
    return sum;
  }

  double edges(int first, int second, const Positions& x) const {
    const SceneBody &one = scene_.bodies[first], &two = scene_.bodies[second];
    double sum = 0;
    for (std::size_t e = 0; e < one.mesh.edges.size(); ++e) {
      for (std::size_t f = first == second ? e + 1 : 0; f < two.mesh.edges.size(); ++f) {
        const auto [a, b] = one.mesh.edges[e].vertex;
        const auto [c, d] = two.mesh.edges[f].vertex;
        if (first == second && (a == c || a == d || b == c || b == d)) continue;
        const std::array<int, 3> pair{first, static_cast<int>(e), static_cast<int>(f)};
        if (first == second && near_edges_.contains(pair)) continue;
        const double mean_one = (area(one, a) + area(one, b)) / 2;
        const double mean =
            two.dynamic ? (mean_one + (area(two, c) + area(two, d)) / 2) / 2 : mean_one;
        sum += 16 * stiffness() * mean * edge_pair(one, {a, b}, two, {c, d}, x);
      }
    }
    return sum;
  }
  static double edge_pair(const SceneBody& one, const std::array<int, 2>& e, const SceneBody& two,
                          const std::array<int, 2>& f, const Positions& x) {
    const Vec3 *at = x.data() + one.first_particle, *to = x.data() + two.first_particle;
    const double gap =
        std::sqrt(bsi::closest_edge_edge(at[e[0]], at[e[1]], to[f[0]], to[f[1]]).squared_distance);
    const double threshold = 1e-3 * (one.rest[e[1]] - one.rest[e[0]]).squaredNorm() *
                             (two.rest[f[1]] - two.rest[f[0]]).squaredNorm();
    const double sine = (at[e[1]] - at[e[0]]).cross(to[f[1]] - to[f[0]]).squaredNorm() / threshold;
    return (sine < 1 ? sine * (2 - sine) : 1) * barrier(gap, 0.25);
  }

  const Scene& scene_;
  // Body, vertex and triangle, or body and two edges, of neighbours at rest.
  std::set<std::array<int, 3>> near_triangles_, near_edges_;
};

// Checks the energy and, as its slope, the forces on every 13th particle.
void expect_forces_by_feature(const Scene& scene, Positions x) {
  Statistics statistics;
  Contact contact(scene, statistics);
  const EnergyByFeature oracle(scene);
  const Positions rest(x.size(), Vec3::Zero());
  ASSERT_FALSE(contact.evaluate(x, rest, 1));
  const double energy = oracle.energy(x);
  ASSERT_GT(energy, 0);
  EXPECT_NEAR(contact.energy(), energy, 1e-9 * energy);
  Positions force(scene.dynamic_particles, Vec3::Zero());
  contact.add_forces(force);
  double largest = 0;
  for (const Vec3& f : force) largest = std::max(largest, f.norm());
  for (int i = 0; i < scene.dynamic_particles; i += 13) {
    for (int axis = 0; axis < 3; ++axis) {
      const double step = 1e-7, place = x[i][axis];
      x[i][axis] = place + step;
      const double above = oracle.energy(x);
      x[i][axis] = place - step;
      const double below = oracle.energy(x);
      x[i][axis] = place;
      EXPECT_NEAR(force[i][axis], (below - above) / (2 * step), 1e-5 * largest) << i;
    }
  }
}

TEST(ContactOracle, ForcesAreThoseOfTheEnergyByFeature) {
  const auto scene = scene_of(one_sheet);
  expect_forces_by_feature(*scene, shifted(folded(*scene, 0.02), 0.002, 1));
  expect_forces_by_feature(*scene, crumpled(*scene, 3));
  const auto fine = scene_of(fine_sheet);
  expect_forces_by_feature(*fine, shifted(rolled(*fine, 7.2, 0.045), 0.001, 4));
  const auto bodies = scene_of(one_sheet + R"(
[[body]]
name = "upper"
thickness = 0.004
position = [0.03, 0.02, 0.02]
rotation_deg = [0, 0, 40]
shape = { type = "rectangle", size = [0.6, 0.6], resolution = [6, 6] }
[[obstacle]]
name = "ball"
thickness = 0.004
position = [0.1, 0, -0.2075]
shape = { type = "sphere", radius = 0.2, resolution = [9] }
)");
  expect_forces_by_feature(*bodies, shifted(bodies->initial_position, 0.001, 5));
}

}  // namespace
}  // namespace weft::sim::contact_oracle_test
