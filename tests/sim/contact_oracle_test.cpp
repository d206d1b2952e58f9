// The contact search and the path check against every pair of features, at rest and in motion: for
// a sheet folded on itself, a crumpled one, two bodies and three.
#include "tests/sim/contact_oracle.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "sim/contact/contact.h"
#include "tests/sim/contact_scenes.h"

namespace weft::sim::contact_oracle_test {
namespace {

using namespace contact_scenes;  // NOLINT: scenes of this test

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

// Contact keeps candidates from one evaluation to the next. One that is new at every state must
// agree with one that follows, by steps much shorter than the slack.
TEST(ContactOracle, PairsOfContactThatFollowsAreThoseOfNewContact) {
  const auto scene = scene_of(one_sheet);
  Statistics statistics;
  Contact followed(*scene, statistics);
  const Positions rest(scene->initial_position.size(), Vec3::Zero());
  const auto pairs = [&](Contact& contact, const Positions& positions) {
    EXPECT_FALSE(contact.evaluate(positions, rest, 1));
    std::vector<std::pair<std::array<int, 4>, double>> found;
    for (const ContactPair& pair : contact.pairs()) found.emplace_back(pair.nodes, pair.gap);
    return found;
  };
  std::size_t fewest = 1000, most = 0;
  for (int k = 0; k < 200; ++k) {
    const Positions now = shifted(folded(*scene, reach + 0.001 - 5e-5 * k), 0.0004, 3);
    Contact anew(*scene, statistics);
    const auto expected = pairs(anew, now);
    EXPECT_EQ(pairs(followed, now), expected) << k;
    fewest = std::min(fewest, expected.size());
    most = std::max(most, expected.size());
  }
  EXPECT_LT(fewest, 10U);
  EXPECT_GT(most, 40U);
}

// Paths keep candidates, too.
TEST(ContactOracle, PathsOfContactThatFollowsAreAnsweredAsByNewContact) {
  const auto scene = scene_of(one_sheet);
  Statistics statistics;
  Contact followed(*scene, statistics);
  const auto state = [&](int k) {
    return shifted(folded(*scene, thickness + 0.006 - 5e-5 * k), 0.0004, 3);
  };
  int refused = 0;
  for (int k = 0; k < 160; ++k) {
    Contact anew(*scene, statistics);
    const bool is_refused = anew.check_path(state(k), state(k + 1)).has_value();
    EXPECT_EQ(followed.check_path(state(k), state(k + 1)).has_value(), is_refused) << k;
    refused += is_refused ? 1 : 0;
  }
  EXPECT_GT(refused, 10);
  EXPECT_LT(refused, 150);
}

}  // namespace
}  // namespace weft::sim::contact_oracle_test
