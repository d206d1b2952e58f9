#include "bsi/detail/feature_batches.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <random>

#include "bsi/continuous_collision.h"
#include "bsi/detail/instruction_set.h"
#include "bsi/proximity.h"

namespace weft::bsi::feature_batches_test {
namespace {

constexpr FeatureKind both_kinds[] = {FeatureKind::vertex_triangle, FeatureKind::edge_edge};

// Pairs of features that share no particles, at the start and at the end of a step.
struct Pairs {
  std::vector<Vec3> start, end;
  std::vector<FourParticles> particles;

  void add(const FourPoints& from, const FourPoints& to) {
    const int first = static_cast<int>(start.size());
    particles.push_back({first, first + 1, first + 2, first + 3});
    start.insert(start.end(), from.begin(), from.end());
    end.insert(end.end(), to.begin(), to.end());
  }
  FourPoints points(const std::vector<Vec3>& x, std::size_t pair) const {
    const auto& [a, b, c, d] = particles[pair];
    return {x[a], x[b], x[c], x[d]};
  }
};

// Returns the largest distance of a corner from the first.
double size(const FourPoints& x) {
  return std::max({(x[1] - x[0]).norm(), (x[2] - x[0]).norm(), (x[3] - x[0]).norm()});
}

double squared_distance(FeatureKind kind, const FourPoints& x) {
  return (kind == FeatureKind::vertex_triangle ? closest_vertex_triangle(x[0], x[1], x[2], x[3])
                                               : closest_edge_edge(x[0], x[1], x[2], x[3]))
      .squared_distance;
}

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double uniform() { return uniform_(engine_); }
  Vec3 point() { return {uniform(), uniform(), uniform()}; }
  Vec3 lattice(int n) { return {below(n), below(n), below(n)}; }
  double below(int n) { return std::uniform_int_distribution(0, n - 1)(engine_); }

 private:
  std::mt19937 engine_;
  std::uniform_real_distribution<double> uniform_{-1, 1};
};

// Returns difficult pairs: random ones of all scales near and far from the origin, corners on a
// lattice (touching, parallel, coincident, without length or area), needles and near-parallel
// edges.
Pairs adversarial_pairs(int count, unsigned seed) {
  Random random(seed);
  Pairs pairs;
  for (int trial = 0; trial < count; ++trial) {
    FourPoints from, to;
    const double scale = trial % 3 == 0 ? std::pow(10.0, 8 * random.uniform()) : 1;
    const Vec3 origin = trial % 5 == 0 ? Vec3(1e5, -2e5, 3e4) : Vec3(0, 0, 0);
    const double flatness = trial % 7 == 0 ? std::pow(10.0, -12 * std::abs(random.uniform())) : 1;
    const double step = std::pow(10.0, -3 * std::abs(random.uniform()));
    for (int i = 0; i < 4; ++i) {
      Vec3 x = trial % 4 == 0 ? random.lattice(3) : random.point();
      x.y() *= flatness;
      x.z() *= flatness;
      Vec3 move = trial % 4 == 0 ? Vec3(random.lattice(3) - Vec3(1, 1, 1)) : random.point();
      from[i] = origin + scale * x;
      to[i] = origin + scale * (x + step * move);
    }
    pairs.add(from, to);
  }
  return pairs;
}

template <class Check>
void with_every_instruction_set(const Check& check) {
  for (InstructionSet instructions : available_instruction_sets()) {
    use_instruction_set(instructions);
    SCOPED_TRACE(name(instructions));
    check();
  }
}

// Runs find(found) with every instruction set, checks that the results agree to the bit, and
// returns them.
template <class Find>
std::vector<PairInReach> found_by_all(const Find& find) {
  std::optional<std::vector<PairInReach>> first;
  with_every_instruction_set([&] {
    std::vector<PairInReach> found;
    find(found);
    if (!first) first = found;
    ASSERT_EQ(found.size(), first->size());
    for (std::size_t i = 0; i < found.size(); ++i) {
      ASSERT_EQ(found[i].pair, (*first)[i].pair);
      ASSERT_EQ(found[i].distance, (*first)[i].distance);
    }
  });
  return *first;
}

// Returns the distance found for a pair, or nothing if the pair was left out.
std::optional<double> distance_of(std::span<const PairInReach> found, std::size_t pair) {
  const auto at = std::ranges::lower_bound(found, static_cast<int>(pair), {}, &PairInReach::pair);
  if (at == found.end() || at->pair != static_cast<int>(pair)) return std::nullopt;
  return at->distance;
}

TEST(FeatureBatches, KeepsWhatIsInReach) {
  constexpr double reach = 0.4;
  const Pairs pairs = adversarial_pairs(20011, 2);
  for (FeatureKind kind : both_kinds) {
    const auto found = found_by_all([&](std::vector<PairInReach>& in_reach) {
      find_in_reach(kind, pairs.end, pairs.particles, reach, in_reach);
    });
    for (std::size_t k = 0; k < pairs.particles.size(); ++k) {
      const FourPoints x = pairs.points(pairs.end, k);
      const double distance = std::sqrt(squared_distance(kind, x));
      const std::optional<double> kept = distance_of(found, k);
      ASSERT_EQ(kept.has_value(), distance <= reach) << k << " " << distance;
      if (kept) {
        ASSERT_NEAR(*kept, distance, 1e-11 * distance + 1e-14 * size(x)) << k;
      }
    }
    EXPECT_GT(found.size(), pairs.particles.size() / 10);
    EXPECT_LT(found.size(), pairs.particles.size() * 9 / 10);
  }
}

// Distances on the way are those of the oracle at 33 times.
TEST(FeatureBatches, KeepsWhatComesIntoReachOnItsPath) {
  constexpr double reach = 0.2;
  const Pairs pairs = adversarial_pairs(20011, 3);
  for (FeatureKind kind : both_kinds) {
    const auto found = found_by_all([&](std::vector<PairInReach>& in_reach) {
      find_in_reach_on_paths(kind, pairs.start, pairs.end, pairs.particles, reach, in_reach);
    });
    int in_reach = 0, close = 0;
    for (std::size_t k = 0; k < pairs.particles.size(); ++k) {
      // Relative to one point, positions on the way are rounded less.
      FourPoints from = pairs.points(pairs.start, k), to = pairs.points(pairs.end, k);
      const Vec3 origin = from[0];
      for (int i = 0; i < 4; ++i) {
        from[i] -= origin;
        to[i] -= origin;
      }
      double least = std::numeric_limits<double>::infinity();
      for (int time = 0; time <= 32; ++time) {
        FourPoints x;
        for (int i = 0; i < 4; ++i) x[i] = from[i] + time / 32.0 * (to[i] - from[i]);
        least = std::min(least, std::sqrt(squared_distance(kind, x)));
      }
      const std::optional<double> kept = distance_of(found, k);
      if (least <= reach) {
        ASSERT_TRUE(kept) << k;
        ASSERT_LE(*kept, least + 1e-14 * (size(from) + size(to))) << k;
        ++in_reach;
        close += *kept > 0.9 * least ? 1 : 0;
      }
    }
    EXPECT_GT(in_reach, 2000);
    EXPECT_GT(close, in_reach / 3);
    EXPECT_LT(found.size(), 2U * in_reach);
    EXPECT_LT(found.size(), pairs.particles.size() * 3 / 4);
  }
}

TEST(FeatureBatches, SafeFractionsAreThoseOfTheScalarFunctions) {
  const Pairs pairs = adversarial_pairs(20011, 3);
  for (FeatureKind kind : both_kinds) {
    for (double separation : {0.0, 0.05}) {
      with_every_instruction_set([&] {
        std::vector<double> fraction(pairs.particles.size(), -1);
        safe_fractions(kind, pairs.start, pairs.end, pairs.particles, separation, fraction);
        int whole = 0;
        for (std::size_t k = 0; k < fraction.size(); ++k) {
          const FourPoints from = pairs.points(pairs.start, k), to = pairs.points(pairs.end, k);
          const double expected = kind == FeatureKind::vertex_triangle
                                      ? safe_fraction_vertex_triangle(from, to, separation)
                                      : safe_fraction_edge_edge(from, to, separation);
          ASSERT_EQ(fraction[k], expected) << k;
          whole += expected == 1;
        }
        EXPECT_GT(whole, 2000);
        EXPECT_LT(whole, 19500);
        std::vector<int> unproved;
        find_unproved_paths(kind, pairs.start, pairs.end, pairs.particles, separation, separation,
                            unproved);
        const int proved = static_cast<int>(pairs.particles.size() - unproved.size());
        EXPECT_GT(proved, whole * 3 / 4);
      });
    }
  }
}

// A path that is proved safe is safe at every moment, and has the required distance at the end.
TEST(FeatureBatches, ProvedPathsAreSafe) {
  const Pairs pairs = adversarial_pairs(5003, 4);
  constexpr double separation = 0.01, end_separation = 0.1;
  for (FeatureKind kind : both_kinds) {
    std::vector<int> unproved;
    find_unproved_paths(kind, pairs.start, pairs.end, pairs.particles, separation, end_separation,
                        unproved);
    std::vector<bool> proved(pairs.particles.size(), true);
    for (int k : unproved) proved[k] = false;
    EXPECT_GT(std::count(proved.begin(), proved.end(), true), 500);
    for (std::size_t k = 0; k < proved.size(); ++k) {
      if (!proved[k]) continue;
      const FourPoints from = pairs.points(pairs.start, k), to = pairs.points(pairs.end, k);
      for (int sample = 0; sample <= 50; ++sample) {
        FourPoints x;
        for (int i = 0; i < 4; ++i) x[i] = from[i] + (to[i] - from[i]) * (sample / 50.0);
        ASSERT_GT(std::sqrt(squared_distance(kind, x)), separation) << k << " " << sample;
      }
      ASSERT_GT(std::sqrt(squared_distance(kind, to)), end_separation) << k;
    }
  }
}

// Paths touch at one moment, exactly: coordinates are small multiples of a power of two.
TEST(FeatureBatches, TouchingPathsAreNeverProved) {
  Random random(5);
  Pairs pairs;
  for (int trial = 0; trial < 10000; ++trial) {
    FourPoints middle = {random.lattice(9), 4 * random.lattice(9), 4 * random.lattice(9),
                         4 * random.lattice(9)};
    middle[0] = 0.25 * (middle[1] + middle[2] + 2 * middle[3]);
    const double unit = std::ldexp(1.0, static_cast<int>(30 * random.uniform()));
    FourPoints from, to;
    for (int i = 0; i < 4; ++i) {
      const Vec3 step = random.lattice(9) - Vec3(4, 4, 4);
      from[i] = unit * (middle[i] - step);
      to[i] = unit * (middle[i] + step);
    }
    pairs.add(from, to);
  }
  with_every_instruction_set([&] {
    std::vector<int> unproved;
    find_unproved_paths(FeatureKind::vertex_triangle, pairs.start, pairs.end, pairs.particles, 0, 0,
                        unproved);
    EXPECT_EQ(unproved.size(), pairs.particles.size());
  });
}

}  // namespace
}  // namespace weft::bsi::feature_batches_test
