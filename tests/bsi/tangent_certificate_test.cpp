// Pairs that the tangent certificate removes from a self traversal are never nearer than the margin
// (docs/theory.md, "The tangent certificate"). The oracle is the distances of all features in
// float64.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <utility>

#include "bsi/continuous_collision.h"
#include "bsi/traversal.h"
#include "tests/bsi/feature_distances.h"

namespace weft::bsi::tangent_certificate_test {
namespace {

using Random = std::mt19937;

double uniform(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

int chance(Random& random, int count) { return static_cast<int>(random() % count); }

// --- Images --------------------------------------------------------------------------------------

// An image with the positions of its particles, at rest where end == start.
struct Image {
  Atlas atlas;
  Positions start, end;
  bool swept() const { return !end.empty(); }
  // Returns, by pair, the least distance at sampled times of the paths.
  std::vector<double> distances(const std::vector<FeaturePair>& pairs) const {
    std::vector<double> least(pairs.size(), infinity);
    for (const double t : {0.0, 0.21, 0.5, 0.77, 1.0}) {
      const Positions x = swept() ? between(start, end, t) : start;
      for (std::size_t i = 0; i < pairs.size(); ++i) {
        least[i] = std::min(least[i], distance(pairs[i], x));
      }
      if (!swept()) break;
    }
    return least;
  }
};

// Returns one patch of random size, its axes wrapped or not, sometimes sewn to itself at random
// places; or two patches sewn together.
Atlas random_atlas(Random& random) {
  const int kind = chance(random, 14);
  Patch patch{3 + chance(random, 5), 3 + chance(random, 5)};
  if (kind == 0) patch.rows = 2;
  if (kind == 1) patch.cols = 2;
  if (kind == 2) patch.wrap_u = true;
  if (kind == 3) patch.wrap_v = true;
  if (kind == 4) patch.wrap_u = patch.wrap_v = true;
  if (kind > 10) {  // long, for several blocks and windows beside each other
    patch = {3 + chance(random, 2), 9 + 4 * chance(random, 4), chance(random, 2) == 0, kind == 13};
    if (chance(random, 2) == 0) {
      std::swap(patch.rows, patch.cols);
      std::swap(patch.wrap_u, patch.wrap_v);
    }
  }
  if (kind > 6) return Atlas({patch});
  std::vector<Patch> patches{patch};
  if (kind == 5) patches.push_back(patch);
  int texels = 0;
  for (const Patch& p : patches) texels += p.texel_count();
  std::vector<int> particle(texels);
  for (int i = 0; i < texels; ++i) particle[i] = i;
  if (kind == 5) {  // the first row of the second is the last row of the first
    for (int i = 0; i < texels; ++i) particle[i] = i < patch.texel_count() ? i : i - patch.cols;
  }
  if (kind == 6) {  // the last texel is the first
    particle.back() = 0;
  }
  return Atlas(std::move(patches), std::move(particle));
}

// A plane with the grid's directions a and b, which may be nearly parallel or of very different
// lengths, bent, pleated, folded or crumpled.
struct Sheet {
  Vec3 a, b;
  double curvature = 0;  // 1 / radius of a roll, in steps
  int pleat = 0;         // columns between folds back over itself
  double fold_angle = 0;
  double fold_column = 0;
  double noise = 0;

  Sheet(int quad_cols, Random& random) {
    a = Vec3(1, 0, 0);
    b = Vec3(0, 1, 0);
    const int shear = chance(random, 4);
    if (shear == 1) b = Vec3(uniform(random, -2, 2), uniform(random, 0.05, 1.5), 0);
    if (shear == 2) b = Vec3(uniform(random, -1, 1), 0.01, 0) * uniform(random, 0.1, 3);
    if (chance(random, 3) == 0) curvature = uniform(random, 0, 2);
    // Pleats have any width, or a quarter of the sheet, as blocks of quads do.
    if (chance(random, 3) == 0)
      pleat = std::max(2, chance(random, 2) == 0 ? quad_cols / 4 : chance(random, 6));
    if (chance(random, 4) == 0) fold_angle = uniform(random, 0, std::numbers::pi);
    fold_column = uniform(random, 1, 6);
    if (chance(random, 3) > 0) noise = std::pow(10.0, uniform(random, -6, 0));
  }

  Vec3 at(int row, int col, Random& random) const {
    Vec3 x = row * b;
    if (pleat > 0) {
      const int beyond = col % pleat;
      x += (col / pleat % 2 == 0 ? beyond : pleat - beyond) * a + 0.02 * col * Vec3::UnitZ();
    } else {
      x += col * a;
    }
    if (curvature > 0) {
      const double angle = x.x() * curvature;
      x = Vec3(std::sin(angle) / curvature, x.y(), (1 - std::cos(angle)) / curvature);
    }
    if (fold_angle > 0 && x.x() > fold_column) {
      const double beyond = x.x() - fold_column;
      x = Vec3(fold_column + beyond * std::cos(fold_angle), x.y(), beyond * std::sin(fold_angle));
    }
    std::normal_distribution<double> normal(0, noise);
    return noise > 0 ? Vec3(x + Vec3(normal(random), normal(random), normal(random))) : x;
  }
};

Positions sheet_positions(const Atlas& atlas, const Sheet& sheet, Random& random) {
  Positions x(atlas.particle_count());
  for (int texel = atlas.texel_count() - 1; texel >= 0; --texel) {
    const TexelAddress place = atlas.texel_address(texel);
    x[atlas.particle_of_texel(texel)] = sheet.at(place.row + 7 * place.patch, place.col, random);
  }
  return x;
}

// Adds spikes, and vertices that coincide.
void spoil(Positions& x, Random& random) {
  const int count = static_cast<int>(x.size());
  switch (chance(random, 6)) {
    case 0:
      x[chance(random, count)] += 10 * Vec3::Random();
      break;
    case 1:
      x[chance(random, count)] = x[chance(random, count)];
      break;
    case 2:
      std::fill(x.begin(), x.begin() + count / 2, x[0]);
      break;
    default:
      break;
  }
}

// Scales, rotates and moves an image: from steps of 1e-44 m, almost lost in float32, to coordinates
// of 1e17 m, and far from the origin.
void place(Image& image, Random& random) {
  constexpr std::array sizes{1.0, 1.0, 1.0, 1e6, 1e9, 1e11, 1e16, 1e-6, 1e-12, 1e-25, 1e-38, 1e-44};
  constexpr std::array offsets{0.0, 0.0, 1.0, 1e2, 1e4, 1e6};
  const double size = sizes[chance(random, sizes.size())];
  double offset = size * offsets[chance(random, offsets.size())];
  if (offset > 1e17) offset = 1e17;
  const Vec3 origin(offset, -0.6 * offset, 0.3 * offset);
  const Eigen::Matrix3d turn = chance(random, 3) == 0
                                   ? Eigen::Matrix3d::Identity()
                                   : Eigen::Quaterniond::UnitRandom().toRotationMatrix();
  for (Positions* positions : {&image.start, &image.end}) {
    for (Vec3& x : *positions) x = size * (turn * x) + origin;
  }
}

Image random_image(unsigned seed, bool swept) {
  Random random(seed);
  std::srand(seed);  // of Eigen's random turns
  Image image{random_atlas(random), {}, {}};
  const int quad_cols = image.atlas.patches()[0].quad_cols();
  Sheet sheet(quad_cols, random);
  image.start = sheet_positions(image.atlas, sheet, random);
  spoil(image.start, random);
  if (swept) {
    // The sheet moves to one of another kind, or to itself bent in another way or rotated.
    Sheet other = chance(random, 4) == 0 ? Sheet(quad_cols, random) : sheet;
    if (chance(random, 2) == 0) other.curvature = uniform(random, 0, 0.2);
    image.end = sheet_positions(image.atlas, other, random);
    if (chance(random, 3) == 0) {
      const Eigen::AngleAxisd turn(uniform(random, 0, 1), Vec3::UnitZ());
      for (Vec3& x : image.end) x = turn * x;
    }
    if (chance(random, 3) == 0) spoil(image.end, random);
  }
  place(image, random);
  return image;
}

// --- What is found -------------------------------------------------------------------------------

// The pairs of leaves found, by number.
struct Found {
  int count = 0;
  std::vector<bool> pairs;  // count x count
  int pair_count = 0;
  std::int64_t certified = 0;
  bool holds(int a, int b) const { return pairs[std::min(a, b) * count + std::max(a, b)]; }
};

Found find(const Pyramid& pyramid, double margin, Leaf leaf, bool certificate = true) {
  Found found;
  found.count = pyramid.atlas().quad_count() * (leaf == Leaf::triangle ? 2 : 1);
  found.pairs.resize(found.count * found.count);
  TraversalCounters counters;
  std::vector<LeafPair> pairs;
  self_traversal(pyramid, {.margin = margin, .leaf = leaf, .certificate = certificate}, pairs,
                 counters);
  for (const LeafPair& pair : pairs) found.pairs[pair.a * found.count + pair.b] = true;
  found.pair_count = static_cast<int>(pairs.size());
  found.certified = counters.certified;
  return found;
}

Pyramid build(const Image& image) {
  Pyramid pyramid(image.atlas);
  const auto bad =
      image.swept() ? pyramid.rebuild_swept(image.start, image.end) : pyramid.rebuild(image.start);
  EXPECT_FALSE(bad);
  return pyramid;
}

// True if every pair of quads that contain the features, and every pair of triangles without a
// common vertex, is found.
bool is_found(const Atlas& atlas, const FeaturePair& pair, const Found& quads,
              const Found& triangles) {
  for (const int a : pair.a->triangles) {
    for (const int b : pair.b->triangles) {
      if (!quads.holds(a / 2, b / 2)) return false;
      const auto of_a = quad_triangles(atlas.quad_particles(a / 2))[a % 2];
      const auto of_b = quad_triangles(atlas.quad_particles(b / 2))[b % 2];
      if (std::ranges::find_first_of(of_a, of_b) != of_a.end()) continue;
      if (!triangles.holds(a, b)) return false;
    }
  }
  return true;
}

// Returns margins just above occurring distances: the least and some others. The nearest pair would
// be lost first.
std::vector<double> telling_margins(std::vector<double> distances, Random& random) {
  std::erase_if(distances, [](double d) { return d == infinity; });
  std::ranges::sort(distances);
  const auto first = std::ranges::upper_bound(distances, 0.0);
  if (first == distances.end()) return {0.0};
  const auto left = static_cast<int>(distances.end() - first);
  std::vector<double> margins{0.0};
  for (const int number : {0, chance(random, left / 40 + 1), chance(random, left / 8 + 1)}) {
    margins.push_back(first[number] * (1 + 1e-12));
  }
  return margins;
}

struct Tally {
  int images = 0, near = 0, certified = 0, excused = 0, lost = 0;
};

void check(const Image& image, unsigned seed, Tally& tally) {
  Random random(seed);
  const std::vector<Feature> features = features_of(image.atlas);
  const std::vector<FeaturePair> pairs = pairs_of_features(features);
  const std::vector<double> distances = image.distances(pairs);
  const Pyramid pyramid = build(image);
  ++tally.images;
  for (const double margin : telling_margins(distances, random)) {
    const Found quads = find(pyramid, margin, Leaf::quad);
    const Found triangles = find(pyramid, margin, Leaf::triangle);
    tally.certified += triangles.certified > 0 ? 1 : 0;
    tally.excused += find(pyramid, margin, Leaf::quad, false).pair_count - quads.pair_count;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      if (distances[i] > margin) continue;
      ++tally.near;
      if (is_found(image.atlas, pairs[i], quads, triangles)) continue;
      ++tally.lost;
      ADD_FAILURE() << "image " << seed << " loses a pair at " << distances[i] << " within "
                    << margin;
      return;
    }
  }
}

Tally check_images(unsigned count, bool swept) {
  Tally tally;
  for (unsigned seed = 0; seed < count; ++seed) check(random_image(seed, swept), seed, tally);
  EXPECT_EQ(tally.lost, 0);
  return tally;
}

TEST(TangentCertificate, NoImageLosesAPairWithinTheMargin) {
  const Tally tally = check_images(1000, false);
  EXPECT_GT(tally.near, 100000);
  EXPECT_GT(tally.certified, 300);
  EXPECT_GT(tally.excused, 5000);
}

TEST(TangentCertificate, NoSweptImageLosesAPairWithinTheMargin) {
  const Tally tally = check_images(500, true);
  EXPECT_GT(tally.near, 20000);
  EXPECT_GT(tally.certified, 50);
  EXPECT_GT(tally.excused, 500);
}

// A pair that is not found must not touch along its paths: continuous collision, which never calls
// an unsafe path safe, must call it safe. (It may refuse pairs that come nearer than a hundredth of
// their start's distance.)
TEST(TangentCertificate, ContinuousCollisionFindsNoPairThatIsLeftOut) {
  int refused = 0, judged = 0, excused = 0;
  for (unsigned seed = 1000; seed < 1300; ++seed) {
    const Image image = random_image(seed, true);
    const std::vector<Feature> features = features_of(image.atlas);
    const std::vector<FeaturePair> pairs = pairs_of_features(features);
    Random random(seed);
    const Pyramid pyramid = build(image);
    // The margin is below the least distance found, to leave out as many pairs as possible.
    const std::vector<double> margins = telling_margins(image.distances(pairs), random);
    const double margin = margins.size() > 1 ? 0.6 * margins[1] : 0;
    const Found quads = find(pyramid, margin, Leaf::quad);
    excused += find(pyramid, margin, Leaf::quad, false).pair_count - quads.pair_count;
    for (const FeaturePair& pair : pairs) {
      if (pair.a->vertices.size() + pair.b->vertices.size() != 4) continue;
      if (quads.holds(pair.a->triangles[0] / 2, pair.b->triangles[0] / 2)) continue;
      if (distance(pair, image.start) > 90 * margin) continue;
      const auto safe_fraction =
          pair.a->vertices.size() == 1 ? safe_fraction_vertex_triangle : safe_fraction_edge_edge;
      ++judged;
      if (safe_fraction(points_of(pair, image.start), points_of(pair, image.end), 0) < 1) ++refused;
    }
  }
  EXPECT_EQ(refused, 0);
  EXPECT_GT(judged, 100000);
  EXPECT_GT(excused, 1000);
}

}  // namespace
}  // namespace weft::bsi::tangent_certificate_test
