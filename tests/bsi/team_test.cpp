// Loops of one thread or of a team: each number once and in order, and no parallel region for one
// thread.
#include "bsi/detail/team.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace weft::bsi::team_test {
namespace {

TEST(Team, EachNumberRunsOnceOnAnyNumberOfThreads) {
  for (const int count : {0, 1, 2, 7, 100}) {
    for (const int threads : {-1, 0, 1, 2, 3, 8}) {
      std::vector<int> runs(count, 0);
      parallel_for(count, threads, [&](int i) { ++runs[i]; });
      EXPECT_EQ(std::ranges::count(runs, 1), count) << count << " numbers, " << threads;
    }
  }
}

TEST(Team, EachThreadRunsNeighboursInOrder) {
  constexpr int count = 50;
  std::vector<int> thread_of(count, -1), turn_of(count, -1);
  std::vector<int> turns(3, 0);
  parallel_for(count, 3, [&](int i) {
    thread_of[i] = omp_get_thread_num();
    turn_of[i] = turns[thread_of[i]]++;
  });
  EXPECT_TRUE(std::ranges::is_sorted(thread_of));
  for (int i = 1; i < count; ++i)
    EXPECT_EQ(turn_of[i], thread_of[i] == thread_of[i - 1] ? turn_of[i - 1] + 1 : 0) << i;
}

TEST(Team, OneThreadOpensNoParallelRegion) {
  int level = -1, team_level = -1;
  parallel_for(5, 1, [&](int) { level = omp_get_level(); });
  run_team(1, [&] { team_level = omp_get_level(); });
  EXPECT_EQ(level, 0);
  EXPECT_EQ(team_level, 0);
}

TEST(Team, ASharedCountHandsOutEachNumberOnce) {
  for (const int threads : {0, 1, 2, 5}) {
    SharedCount next(1000);
    std::vector<int> taken(1000, 0);
    std::atomic<int> works = 0;
    run_team(threads, [&] {
      ++works;
      for (int i = 0; next.take(i);) ++taken[i];
    });
    EXPECT_EQ(std::ranges::count(taken, 1), 1000) << threads;
    EXPECT_EQ(works, std::max(1, threads));
  }
}

}  // namespace
}  // namespace weft::bsi::team_test
