// Compares the tree of bodies' boxes with every pair of boxes.
#include "sim/contact/body_tree.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

namespace weft::sim::body_tree_test {
namespace {

using Box = BodyTree::Box;
using Vec3 = Eigen::Vector3d;

class Boxes {
 public:
  Box next() {
    const Vec3 centre(place_(random_), place_(random_), place_(random_));
    const Vec3 half(size_(random_), size_(random_), size_(random_));
    return {centre - half, centre + half};
  }
  int body(int count) { return std::uniform_int_distribution<int>(0, count - 1)(random_); }

 private:
  std::mt19937 random_{1};
  std::uniform_real_distribution<double> place_{-1, 1}, size_{0.01, 0.2};
};

std::set<int> neighbours(const BodyTree& tree, int body) {
  std::set<int> found;
  tree.visit_neighbours(body, [&](int other) { EXPECT_TRUE(found.insert(other).second); });
  return found;
}

void expect_all_found(const BodyTree& tree, int count) {
  for (int a = 0; a < count; ++a) {
    std::set<int> expected;
    for (int b = 0; b < count; ++b) {
      if (a != b && tree.box(a).intersects(tree.box(b))) expected.insert(b);
    }
    ASSERT_EQ(neighbours(tree, a), expected) << "body " << a << " of " << count;
  }
}

TEST(BodyTree, FindsEveryNeighbourOfBodiesThatMove) {
  Boxes random;
  for (const int count : {1, 2, 3, 50}) {
    std::vector<Box> boxes;
    for (int i = 0; i < count; ++i) boxes.push_back(random.next());
    BodyTree tree;
    tree.build(boxes);
    expect_all_found(tree, count);
    for (int round = 0; round < 40; ++round) {
      const std::vector<int> moved{random.body(count)};
      const std::vector<Box> places{random.next()};
      tree.move(moved, places);
      expect_all_found(tree, count);
    }
  }
}

TEST(BodyTree, ABodyWithAnEmptyBoxHasNoNeighbours) {
  const Box unit(Vec3::Zero(), Vec3::Ones());
  BodyTree tree;
  tree.build({unit, Box(), unit, Box()});
  EXPECT_EQ(neighbours(tree, 0), std::set<int>{2});
  EXPECT_TRUE(neighbours(tree, 1).empty());
}

// A square grid of boxes that do not meet.
TEST(BodyTree, LooksAtAFewBoxesOfMany) {
  constexpr int side = 64;
  std::vector<Box> boxes;
  for (int i = 0; i < side * side; ++i) {
    const Vec3 low(i % side, i / side, 0);
    boxes.emplace_back(low, low + Vec3(0.5, 0.5, 0.1));
  }
  BodyTree tree;
  tree.build(boxes);
  int compared = 0;
  for (int i = 0; i < side * side; ++i) compared += tree.visit_neighbours(i, [](int) { FAIL(); });
  EXPECT_LT(compared, side * side * 4 * 12);  // 12 levels
}

}  // namespace
}  // namespace weft::sim::body_tree_test
