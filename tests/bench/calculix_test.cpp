// The input that is written for CalculiX, and the commands that are timed.
#include "bench/calculix.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <sstream>

#include "bench/temporary_folder.h"
#include "bench/timed_command.h"
#include "sim/case/case_reader.h"

namespace weft::bench::calculix_test {
namespace {

using sim::Vec3;

// The contents of a deck, by its keywords.
struct Deck {
  std::map<int, Vec3> node;
  std::vector<std::vector<int>> element;  // its nodes
  std::vector<std::array<int, 2>> held;   // node and direction
  std::map<int, Vec3> load;
};

std::vector<double> numbers_of(std::string line) {
  for (char& each : line) each = each == ',' ? ' ' : each;
  std::istringstream words(line);
  std::vector<double> numbers;
  for (double number = 0; words >> number;) numbers.push_back(number);
  return numbers;
}

Deck read_deck(const std::string& text) {
  Deck deck;
  std::istringstream lines(text);
  std::string keyword;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with('*')) {
      keyword = line.substr(0, line.find(','));
      continue;
    }
    const std::vector<double> numbers = numbers_of(line);
    const int first = numbers.empty() ? 0 : static_cast<int>(numbers[0]);
    if (keyword == "*NODE") {
      deck.node[first] = Vec3(numbers.at(1), numbers.at(2), numbers.at(3));
    } else if (keyword == "*ELEMENT") {
      const bool goes_on = !deck.element.empty() && deck.element.back().size() < 20;
      if (!goes_on) deck.element.emplace_back();
      deck.element.back().insert(deck.element.back().end(), numbers.begin() + (goes_on ? 0 : 1),
                                 numbers.end());
    } else if (keyword == "*BOUNDARY") {
      deck.held.push_back({first, static_cast<int>(numbers.at(1))});
    } else if (keyword == "*CLOAD") {
      deck.load.try_emplace(first, Vec3::Zero());
      deck.load[first][static_cast<int>(numbers.at(1)) - 1] = numbers.at(2);
    }
  }
  return deck;
}

sim::Case benchmark(const std::string& name) {
  return sim::read_case(WEFT_CASES_DIR "/benchmarks/" + name + ".toml", {});
}

// The volume of an element whose faces are flat.
double volume_of(const Deck& deck, const std::vector<int>& nodes) {
  const auto at = [&](int i) { return deck.node.at(nodes[i]); };
  const auto tetrahedron = [&](int a, int b, int c, int d) {
    return (at(b) - at(a)).cross(at(c) - at(a)).dot(at(d) - at(a)) / 6;
  };
  return tetrahedron(0, 1, 3, 4) + tetrahedron(1, 2, 3, 6) + tetrahedron(1, 4, 5, 6) +
         tetrahedron(3, 4, 6, 7) + tetrahedron(1, 3, 4, 6);
}

TEST(CalculixDeck, HasTheShapeOfTheCase) {
  constexpr int n = 16;
  const Deck deck = read_deck(calculix_deck(benchmark("hemisphere_full_load"), n, false).text);
  // Two faces of serendipity elements, and the corners between them.
  EXPECT_EQ(deck.node.size(), 2 * ((2 * n + 1) * (2 * n + 1) - n * n) + (n + 1) * (n + 1));
  ASSERT_EQ(deck.element.size(), n * n);
  double volume = 0;
  for (const std::vector<int>& nodes : deck.element) {
    ASSERT_EQ(nodes.size(), 20);
    EXPECT_GT(volume_of(deck, nodes), 0);
    volume += volume_of(deck, nodes);
    // Midside nodes follow the corners, edge by edge.
    for (int i = 0; i < 12; ++i) {
      const int from = i < 8 ? i : i - 8, to = i < 4   ? (i + 1) % 4
                                               : i < 8 ? 4 + (i + 1) % 4
                                                       : i - 4;
      const Vec3 middle = 0.5 * (deck.node.at(nodes[from]) + deck.node.at(nodes[to]));
      EXPECT_LT((deck.node.at(nodes[8 + i]) - middle).norm(), 0.02) << i;
    }
  }
  const double area = 0.25 * 2 * std::numbers::pi * 100 * std::sin(0.4 * std::numbers::pi);
  EXPECT_NEAR(volume, area * 0.04, 0.01 * area * 0.04);
}

TEST(CalculixDeck, HasTheSupportsAndLoadsOfTheCase) {
  constexpr int n = 4;
  const CalculixDeck written = calculix_deck(benchmark("hemisphere_full_load"), n, false);
  const Deck deck = read_deck(written.text);
  // Each symmetry plane holds all nodes of an edge: 3 at a corner and 2 at a midside.
  EXPECT_EQ(deck.held.size(), 2 * (3 * (n + 1) + 2 * n) + 1);
  for (const auto& [node, direction] : deck.held) {
    if (direction < 3) {
      EXPECT_NEAR(deck.node.at(node)[direction - 1], 0, 1e-12);
    }
  }
  EXPECT_EQ(deck.held.back()[1], 3);
  ASSERT_EQ(written.loaded.size(), 2);
  EXPECT_LT((deck.node.at(written.loaded[0]) - Vec3(10, 0, 0)).norm(), 1e-9);
  EXPECT_LT((deck.node.at(written.loaded[1]) - Vec3(0, 10, 0)).norm(), 1e-9);
  EXPECT_EQ(deck.load.at(written.loaded[0]), Vec3(200, 0, 0));
  EXPECT_EQ(deck.load.at(written.loaded[1]), Vec3(0, -200, 0));
  EXPECT_NE(written.text.find("NLGEOM"), std::string::npos);
  EXPECT_EQ(calculix_deck(benchmark("pinched_cylinder"), n, true).text.find("NLGEOM"),
            std::string::npos);
}

TEST(TimedCommand, TellsTimeOutputAndEnd) {
  const TemporaryFolder folder;
  const TimedCommand busy = run_command(
      {"sh", "-c", "i=0; while [ $i -lt 100000 ]; do i=$((i + 1)); done; echo $OMP_NUM_THREADS"},
      folder.path());
  EXPECT_TRUE(busy.is_well);
  EXPECT_EQ(busy.output, "1\n");
  EXPECT_GT(busy.cpu_s, 0.005);
  const TimedCommand idle = run_command({"sleep", "0.2"}, folder.path());
  EXPECT_LT(idle.cpu_s, 0.1);
  EXPECT_FALSE(run_command({"sh", "-c", "exit 3"}, folder.path()).is_well);
  EXPECT_FALSE(run_command({"no-such-program"}, folder.path()).is_well);
  EXPECT_TRUE(is_installed("sh"));
  EXPECT_FALSE(is_installed("no-such-program"));
}

}  // namespace
}  // namespace weft::bench::calculix_test
