// Loops in chunks: every index once, even shares, and sums with the same bits on any number of
// threads.
#include "sim/base/parallel.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>

namespace weft::sim::parallel_test {
namespace {

TEST(Chunks, HoldEveryIndexOnceInOrder) {
  for (const int count : {0, 1, 7, 8, 9, 191, 192, 193, 1089, 4225, 12288, 12289, 100000}) {
    const Chunks chunks(count);
    int next = 0;
    for (int c = 0; c < chunks.size(); ++c) {
      EXPECT_EQ(chunks.first(c), next) << count;
      EXPECT_GT(chunks.last(c), next) << count;
      next = chunks.last(c);
    }
    EXPECT_EQ(next, count);
  }
}

TEST(Chunks, ReachTheLargestCounts) {
  const int count = std::numeric_limits<int>::max() - 20000;
  const Chunks chunks(count);
  EXPECT_EQ(chunks.last(chunks.size() - 1), count);
  EXPECT_GT(chunks.first(chunks.size() - 1), count - 1000);
}

// A thread gets consecutive chunks, ceil(size / threads) at most.
TEST(Chunks, AreSharedEvenly) {
  for (const int count : {1089, 4225, 16641, 66049}) {
    const Chunks chunks(count);
    for (const int threads : {2, 3, 4, 6, 8, 12}) {
      const int most = (chunks.size() + threads - 1) / threads;
      const int largest = chunks.last(most - 1) - chunks.first(0);
      EXPECT_LT(largest, 1.02 * count / threads + 2) << count << " " << threads;
    }
  }
}

TEST(ParallelSum, HasTheSameBitsOnAnyNumberOfThreads) {
  std::vector<double> values(5000);
  for (int i = 0; i < 5000; ++i) values[i] = std::sin(1.0 + i) * std::exp(i % 40);
  const auto sum = [&](int threads) {
    return parallel_sum(static_cast<int>(values.size()), threads, [&](int first, int last) {
      return std::accumulate(values.begin() + first, values.begin() + last, 0.0);
    });
  };
  const double one = sum(1);
  EXPECT_NEAR(one, std::accumulate(values.begin(), values.end(), 0.0), 1e-12 * std::exp(40));
  for (const int threads : {2, 3, 5, 8}) EXPECT_EQ(sum(threads), one);
}

TEST(ParallelParts, AreInTheOrderOfTheChunks) {
  const auto parts =
      parallel_parts<std::vector<int>>(1000, 3, [](int first, int last, std::vector<int>& part) {
        for (int i = first; i < last; ++i) part.push_back(i);
      });
  std::vector<int> joined;
  for (const auto& part : parts) joined.insert(joined.end(), part.begin(), part.end());
  std::vector<int> expected(1000);
  std::iota(expected.begin(), expected.end(), 0);
  EXPECT_EQ(joined, expected);
}

TEST(ParallelVectors, AreCopiedAndSetWhole) {
  std::vector<Vec3> from(777), to(777, Vec3::Constant(-1));
  for (int i = 0; i < 777; ++i) from[i] = Vec3(i, 2, 3);
  parallel_copy(from, to, 2);
  EXPECT_EQ(from, to);
  parallel_set_zero(to, 2);
  EXPECT_EQ(to, std::vector<Vec3>(777, Vec3::Zero()));
}

}  // namespace
}  // namespace weft::sim::parallel_test
