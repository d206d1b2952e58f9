// Continuous collision against an oracle without rounding: no contact is missed.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <iostream>
#include <random>
#include <vector>

#include "bsi/continuous_collision.h"
#include "bsi/detail/feature_batches.h"
#include "tests/bsi/ccd_benchmark.h"
#include "tests/bsi/exact_contact.h"

namespace weft::bsi::collision_oracle_test {
namespace {

struct Query {
  FourPoints start, end;
};

double safe_fraction(FeatureKind kind, const Query& query) {
  return kind == FeatureKind::vertex_triangle
             ? safe_fraction_vertex_triangle(query.start, query.end, 0)
             : safe_fraction_edge_edge(query.start, query.end, 0);
}

bool meet(FeatureKind kind, const Query& query, double until = 1) {
  return features_meet(kind, query.start, query.end, until);
}

// Random and degenerate queries of either kind.
class Queries {
 public:
  explicit Queries(unsigned seed) : random_(seed) {}

  Query next() {
    static constexpr std::array<Query (Queries::*)(), 8> kinds{
        &Queries::anywhere,    &Queries::on_a_lattice, &Queries::in_a_plane,
        &Queries::degenerate,  &Queries::near_miss,    &Queries::thin,
        &Queries::at_a_corner, &Queries::common_motion};
    Query query = (this->*kinds[count_++ % kinds.size()])();
    // A factor of two changes nothing but the exponents.
    const double unit = std::ldexp(1.0, whole(-40, 40));
    for (FourPoints* points : {&query.start, &query.end})
      for (Vec3& point : *points) point *= unit;
    return query;
  }

 private:
  double real() { return std::uniform_real_distribution<double>(-1, 1)(random_); }
  int whole(int low, int high) { return std::uniform_int_distribution<int>(low, high)(random_); }
  double small(int least_exponent) {
    return std::copysign(std::pow(10.0, least_exponent * std::abs(real())), real());
  }
  Vec3 point() { return {real(), real(), real()}; }
  Vec3 node(int size) { return Vec3(whole(-size, size), whole(-size, size), whole(-size, size)); }
  FourPoints points() { return {point(), point(), point(), point()}; }
  FourPoints moved(const FourPoints& from, double length) {
    FourPoints to = from;
    for (Vec3& x : to) x += length * point();
    return to;
  }

  Query anywhere() {
    const FourPoints start = points();
    return {start, moved(start, std::ldexp(1.0, whole(-6, 2)))};
  }
  // Small integers: contacts at corners, parallel edges, planes that all points share.
  Query on_a_lattice() {
    Query query;
    const int size = whole(1, 4);
    for (int i = 0; i < 4; ++i) {
      query.start[i] = node(size);
      query.end[i] = query.start[i] + node(whole(0, 3));
    }
    return query;
  }
  // All points stay in one plane, which is exact in two dimensions of the lattice.
  Query in_a_plane() {
    Query query = whole(0, 1) == 0 ? on_a_lattice() : anywhere();
    const double height = whole(-1, 1);
    for (FourPoints* x : {&query.start, &query.end})
      for (Vec3& each : *x) each = Vec3(each.x(), each.y(), height + each.x() + 2 * each.y());
    return query;
  }
  // Features without area or length, points that rest, points that coincide.
  Query degenerate() {
    Query query = whole(0, 1) == 0 ? on_a_lattice() : anywhere();
    const int i = whole(0, 3), j = whole(0, 3), k = whole(0, 3);
    query.start[i] = query.start[j];
    if (whole(0, 1) == 0) query.end[i] = query.end[j];
    if (whole(0, 1) == 0) query.end[k] = query.start[k];
    if (whole(0, 3) == 0) query.end = query.start;
    if (whole(0, 3) == 0) {
      query.start[3] = 2 * query.start[2] - query.start[1];
      query.end[3] = 2 * query.end[2] - query.end[1];
    }
    return query;
  }
  // The features touch within 1e-17 to 1 of their size at some time between.
  Query near_miss() {
    FourPoints middle = points();
    if (whole(0, 1) == 0) {
      const double u = std::abs(real()), v = (1 - u) * std::abs(real());
      middle[0] = middle[1] + u * (middle[2] - middle[1]) + v * (middle[3] - middle[1]);
    } else {
      const double u = std::abs(real());
      middle[1] = middle[2] + u * (middle[3] - middle[2]) + 0.3 * (middle[1] - middle[0]);
      middle[0] += middle[1] - middle[2] - u * (middle[3] - middle[2]);
    }
    middle[0] += small(-17) * point();
    const double time = std::abs(real()), length = std::ldexp(1.0, whole(-10, 1));
    Query query{middle, middle};
    for (int i = 0; i < 4; ++i) {
      const Vec3 step = length * point();
      query.start[i] -= time * step;
      query.end[i] += (1 - time) * step;
    }
    return query;
  }
  // A thin triangle or nearly parallel edges, passed at a small distance.
  Query thin() {
    Query query = near_miss();
    const double width = small(-14);
    for (FourPoints* x : {&query.start, &query.end}) {
      const Vec3 along = (*x)[2] - (*x)[1];
      (*x)[3] = (*x)[1] + 0.5 * along + width * ((*x)[3] - (*x)[1]);
      if (whole(0, 1) == 0) (*x)[0] = (*x)[1] + width * ((*x)[0] - (*x)[1]);
    }
    return query;
  }
  // Contact at an end of an edge, on an edge, or at a corner of the triangle, exactly or nearly.
  Query at_a_corner() {
    FourPoints middle;
    for (Vec3& x : middle) x = node(8);
    const int other = whole(1, 3);
    middle[0] = whole(0, 1) == 0 ? middle[other] : 0.5 * (middle[other] + middle[other % 3 + 1]);
    Query query{middle, middle};
    for (int i = 0; i < 4; ++i) {
      const Vec3 step = node(4) / 4;
      query.start[i] -= step;
      query.end[i] += step;
    }
    if (whole(0, 1) == 0) query.end[whole(0, 3)] += small(-17) * point();
    return query;
  }
  // A small motion beside a large common one, far from the origin.
  Query common_motion() {
    Query query = whole(0, 1) == 0 ? near_miss() : at_a_corner();
    const Vec3 origin = 1024 * node(4), common = 64 * node(8);
    for (Vec3& x : query.start) x += origin;
    for (Vec3& x : query.end) x += origin + common;
    return query;
  }

  std::mt19937_64 random_;
  std::size_t count_ = 0;
};

int query_count() {
  const char* text = std::getenv("WEFT_CCD_QUERIES");
  return text == nullptr ? 10000 : std::max(1, std::atoi(text));
}

struct Tally {
  int colliding = 0, cut_short = 0, missed = 0, unsafe = 0, missed_in_batches = 0;
};

void count_batch(FeatureKind kind, const std::vector<Query>& queries,
                 const std::vector<char>& collides, Tally& tally) {
  std::vector<Vec3> start, end;
  std::vector<FourParticles> pairs;
  for (const Query& query : queries) {
    const int first = static_cast<int>(start.size());
    start.insert(start.end(), query.start.begin(), query.start.end());
    end.insert(end.end(), query.end.begin(), query.end.end());
    pairs.push_back({first, first + 1, first + 2, first + 3});
  }
  std::vector<double> fraction(pairs.size());
  safe_fractions(kind, start, end, pairs, 0, fraction);
  for (std::size_t i = 0; i < pairs.size(); ++i)
    tally.missed_in_batches += collides[i] != 0 && fraction[i] >= 1;
}

void compare_with_oracle(FeatureKind kind) {
  const int count = query_count();
  Queries source(kind == FeatureKind::vertex_triangle ? 101 : 102);
  std::vector<Query> queries;
  std::vector<char> collides;
  Tally tally;
  for (int i = 0; i < count; ++i) {
    const Query query = source.next();
    const double fraction = safe_fraction(kind, query);
    ASSERT_TRUE(fraction >= 0 && fraction <= 1) << "query " << i;
    const bool hit = meet(kind, query);
    tally.colliding += hit;
    tally.missed += hit && fraction == 1;
    tally.cut_short += !hit && fraction < 1;
    if (fraction > 0 && fraction < 1 && hit && meet(kind, query, fraction)) {
      ++tally.unsafe;
      EXPECT_EQ(fraction, 0) << "query " << i << " meets before";
    }
    queries.push_back(query);
    collides.push_back(hit);
  }
  count_batch(kind, queries, collides, tally);
  std::cout << count << " queries, " << tally.colliding << " collide; missed " << tally.missed
            << ", in batches " << tally.missed_in_batches << ", contact before the cut "
            << tally.unsafe << ", false alarms " << tally.cut_short << "\n";
  EXPECT_EQ(tally.missed, 0);
  EXPECT_EQ(tally.missed_in_batches, 0);
  EXPECT_EQ(tally.unsafe, 0);
  EXPECT_GT(tally.colliding, count / 5);
  EXPECT_GT(count - tally.colliding - tally.cut_short, count / 10);
}

// WEFT_CCD_QUERIES sets the number of queries of each kind.
TEST(CollisionOracle, VertexAndTriangleAreNeverMissed) {
  compare_with_oracle(FeatureKind::vertex_triangle);
}
TEST(CollisionOracle, EdgesAreNeverMissed) { compare_with_oracle(FeatureKind::edge_edge); }

// Lengths whose squares overflow or underflow.
TEST(CollisionOracle, ExtremeLengthsAreNeverMissed) {
  for (const FeatureKind kind : {FeatureKind::vertex_triangle, FeatureKind::edge_edge}) {
    Queries source(103);
    int colliding = 0;
    for (int i = 0; i < 800; ++i) {
      Query query = source.next();
      const double unit = std::ldexp(1.0, (i % 2 == 0 ? 1 : -1) * (100 + i));
      for (FourPoints* points : {&query.start, &query.end})
        for (Vec3& point : *points) point *= unit;
      const double fraction = safe_fraction(kind, query);
      const bool hit = meet(kind, query);
      colliding += hit;
      ASSERT_FALSE(hit && fraction == 1) << "query " << i;
    }
    EXPECT_GT(colliding, 100);
  }
}

// Contacts that are known: the oracle itself is right.
TEST(CollisionOracle, KnowsContactsAndTheirTimes) {
  const FeatureKind vertex = FeatureKind::vertex_triangle, edges = FeatureKind::edge_edge;
  const Vec3 a(0, 0, 0), b(1, 0, 0), c(0, 1, 0);
  const auto falls = [&](double x, double y, double end_height, double until) {
    return meet(vertex, {{Vec3(x, y, 1), a, b, c}, {Vec3(x, y, end_height), a, b, c}}, until);
  };
  EXPECT_TRUE(falls(0.25, 0.25, -1, 0.5));
  EXPECT_FALSE(falls(0.25, 0.25, -1, std::nextafter(0.5, 0)));
  EXPECT_TRUE(falls(0.5, 0.5, 0, 1));                       // ends on an edge
  EXPECT_FALSE(falls(0.5, std::nextafter(0.5, 1), -1, 1));  // passes beside it
  EXPECT_TRUE(falls(1, 0, -3, 0.25));                       // at a corner
  EXPECT_FALSE(falls(0.25, 0.25, 1e-300, 1));
  // A triangle without area is its longest edge.
  EXPECT_TRUE(meet(vertex, {{Vec3(0.5, 1, 0), a, b, b}, {Vec3(0.5, -1, 0), a, b, b}}, 0.5));
  EXPECT_FALSE(meet(vertex, {{Vec3(1.5, 1, 0), a, b, b}, {Vec3(1.5, -1, 0), a, b, b}}, 1));
  // In the plane of the triangle: through an edge, and past a corner.
  EXPECT_TRUE(meet(vertex, {{Vec3(-1, 0.5, 0), a, b, c}, {Vec3(2, 0.5, 0), a, b, c}}));
  EXPECT_FALSE(meet(vertex, {{Vec3(-1, 1.5, 0), a, b, c}, {Vec3(2, 1.5, 0), a, b, c}}));
  // Edges that cross, that end on each other, and that slide along one line.
  const Vec3 up(0, 0, 1);
  EXPECT_TRUE(
      meet(edges,
           {{a, b, Vec3(0.5, -1, 1), Vec3(0.5, 1, 1)}, {a, b, Vec3(0.5, -1, -1), Vec3(0.5, 1, -1)}},
           0.5));
  EXPECT_FALSE(
      meet(edges,
           {{a, b, Vec3(0.5, -1, 1), Vec3(0.5, 1, 1)}, {a, b, Vec3(0.5, -1, -1), Vec3(0.5, 1, -1)}},
           0.499));
  EXPECT_TRUE(meet(edges, {{a, b, b + up, b + 2 * up}, {a, b, b, b + up}}));
  EXPECT_TRUE(meet(edges, {{a, b, 3 * b, 4 * b}, {a, b, b, 2 * b}}, 1));
  EXPECT_FALSE(meet(edges, {{a, b, 3 * b, 4 * b}, {a, b, b, 2 * b}}, 0.99));
}

TEST(CollisionOracle, AgreesWithTheExactTruthOfTheBenchmark) {
  const char* folder = std::getenv("WEFT_CCD_DATA");
  if (folder == nullptr)
    GTEST_SKIP() << "set WEFT_CCD_DATA to the folder of the CCD benchmark's sample queries";
  for (const BenchmarkQuery& query : read_ccd_benchmark(folder))
    ASSERT_EQ(features_meet(query.kind, query.start, query.end), query.collides) << query.place;
}

}  // namespace
}  // namespace weft::bsi::collision_oracle_test
