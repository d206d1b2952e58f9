// The suite `moving`: sixty scenes with prescribed motion, ten seeds of each. No surface passes
// through another in any checked state. Of the scenes with strong contact and a path without
// collision, 95 % finish.
//
// CTest runs a tenth: one seed of each scene. The environment selects others: WEFT_MOVING=whole
// runs all; WEFT_MOVING=NUMBER or NUMBER:SEED runs one scene and prints its case. WEFT_MOVING_JOBS
// is the number of runs at a time (two).
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <string>

#include "tests/moving/moving_run.h"
#include "tests/moving/moving_scenes.h"
#include "tests/temporary_folder.h"

namespace weft::moving::moving_suite_test {
namespace {

constexpr double share_to_reach = 0.95;

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}
int jobs() {
  const std::string text = environment("WEFT_MOVING_JOBS");
  return text.empty() ? 2 : std::max(1, std::stoi(text));
}

struct Tally {
  int runs = 0, done = 0, failed = 0, crossed = 0;
  void add(const MovingOutcome& outcome) {
    ++runs;
    ++(outcome.crossings > 0 ? crossed : outcome.failure.empty() ? done : failed);
  }
  double share() const { return runs == 0 ? 1 : static_cast<double>(done) / runs; }
};

void print_tally(const std::string& name, const Tally& tally) {
  std::printf("%-36s %5d runs %5d done %5d failed %5d crossed  %5.1f %% done\n", name.c_str(),
              tally.runs, tally.done, tally.failed, tally.crossed, 100 * tally.share());
}

const char* expectation(const MovingScene& scene) {
  if (!scene.has_path()) return "no path";
  return scene.is_strong() ? "must be done" : "weak";
}

void print_run(const MovingScene& scene, const MovingOutcome& outcome) {
  const char* end = outcome.crossings > 0 ? "CROSSED" : outcome.failure.empty() ? "done" : "failed";
  std::printf("%2d:%d %-58s %-12s %-12s %-7s %7.2f s CPU %7ld steps %6ld states", scene.number,
              scene.seed, scene.name.c_str(), scene.method.c_str(), expectation(scene), end,
              outcome.cpu_time, outcome.steps, outcome.states);
  if (outcome.crossings > 0) {
    std::printf("  %d crossings at %.9g s", outcome.crossings, outcome.crossing_time);
  }
  if (!outcome.failure.empty()) std::printf("  %s", outcome.failure.c_str());
  std::printf("\n");
}

// Runs the scenes, prints all and a summary, and checks the requirements of the suite.
void run_and_judge(const std::vector<MovingScene>& scenes) {
  const std::vector<MovingOutcome> outcomes = run_scenes(scenes, jobs());
  std::map<std::string, Tally> by_method;
  Tally all, owed, without_path, weak;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const MovingScene& scene = scenes[i];
    const MovingOutcome& outcome = outcomes[i];
    print_run(scene, outcome);
    all.add(outcome);
    by_method[scene.method].add(outcome);
    if (scene.must_be_done()) owed.add(outcome);
    if (!scene.has_path()) without_path.add(outcome);
    if (scene.has_path() && !scene.is_strong()) weak.add(outcome);
    EXPECT_EQ(outcome.crossings, 0) << scene.name << ", scene " << scene.number << ", seed "
                                    << scene.seed << ", " << outcome.crossing_time << " s\n"
                                    << scene.text;
    // No run is cut short silently: either all states were checked, or it reports why not.
    EXPECT_FALSE(outcome.failure.starts_with("not simulated")) << outcome.failure << scene.text;
    EXPECT_FALSE(outcome.failure.starts_with("crashed")) << scene.text;
  }
  for (const auto& [method, tally] : by_method) print_tally(method, tally);
  print_tally("a path, and strong contact", owed);
  print_tally("no path", without_path);
  print_tally("a path, but weak contact", weak);
  print_tally("all", all);
  EXPECT_GE(owed.share(), share_to_reach);
}

std::vector<MovingScene> some_scenes(int seeds, int every, const std::string& folder) {
  std::vector<MovingScene> scenes;
  for (int number = 0; number < scene_count; number += every) {
    for (int seed = 0; seed < seeds; ++seed) scenes.push_back(make_scene(number, seed, folder));
  }
  return scenes;
}

TEST(Moving, SaysBeforehandWhatCanBeDone) {
  const TemporaryFolder folder;
  int owed = 0, without_path = 0, weak = 0;
  for (const MovingScene& scene : some_scenes(seed_count, 1, folder.path().string())) {
    owed += scene.must_be_done() ? 1 : 0;
    without_path += scene.has_path() ? 0 : 1;
    weak += scene.is_strong() ? 0 : 1;
  }
  EXPECT_GE(owed, 540);
  EXPECT_GE(without_path, 20);
  EXPECT_GE(weak, 10);
}

TEST(Moving, ATenth) {
  const TemporaryFolder folder;
#ifdef WEFT_SANITIZED
  run_and_judge(some_scenes(1, 12, folder.path().string()));
#else
  run_and_judge(some_scenes(1, 1, folder.path().string()));
#endif
}

TEST(Moving, AsTheEnvironmentSays) {
  const std::string choice = environment("WEFT_MOVING");
  if (choice.empty()) GTEST_SKIP() << "WEFT_MOVING=whole runs all 600";
  const TemporaryFolder folder;
  if (choice == "whole") return run_and_judge(some_scenes(seed_count, 1, folder.path().string()));
  std::vector<MovingScene> scenes;
  const std::size_t colon = choice.find(':');
  const int number = std::stoi(choice);
  ASSERT_TRUE(number >= 0 && number < scene_count) << choice;
  for (int seed = 0; seed < seed_count; ++seed) {
    if (colon != std::string::npos && std::stoi(choice.substr(colon + 1)) != seed) continue;
    scenes.push_back(make_scene(number, seed, folder.path().string()));
    std::printf("%s\n", scenes.back().text.c_str());
  }
  run_and_judge(scenes);
}

}  // namespace
}  // namespace weft::moving::moving_suite_test
