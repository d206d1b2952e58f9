// Every pair of features of a scene, checked one by one: the oracle of the contact search and of
// the path check. O(n^2) in the features; for scenes of some hundred vertices.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/contact/contact_search.h"
#include "sim/scene/scene.h"

namespace weft::sim {

// A vertex and a triangle, or two edges, that may touch.
struct OraclePair {
  std::size_t list = 0;  // index into searched_pairs()
  int kind = 0;      // 0: vertex of body a, triangle of b; 1: vertex of b, triangle of a; 2: edges
  int a = 0, b = 0;  // the features, as in FeaturePair
  std::array<int, 4> nodes{};  // global particles
  double thickness = 0;        // m; 0 for neighbours
  bool neighbours = false;     // at rest, and therefore never in contact

  bool edges() const { return kind == 2; }
  double distance(std::span<const Vec3> position) const;
};

// Distances of a pair's features on straight paths, m. The path is sampled at equal parts. No
// distance between samples is less than that at the nearest sample by more than `uncertainty`.
struct PathDistances {
  double start = 0, end = 0;
  double least = 0;        // at the samples
  double uncertainty = 0;  // half the largest approach of two of its particles within one part
};

class ContactOracle {
 public:
  explicit ContactOracle(const Scene& scene);

  // All pairs without a common vertex, with at least one free particle, of bodies that may touch.
  const std::vector<OraclePair>& pairs() const { return pairs_; }

  // The pairs that can be in contact and are closer than thickness + their range at `position`. The
  // range of pairs without a sample is short (short_range).
  std::vector<OraclePair> in_reach(std::span<const Vec3> position) const;
  // Returns, in words, the first pair in reach at `position` that `lists` lack, or whose bound in
  // them exceeds its distance, or a list that is not sorted. Empty if the lists are complete.
  std::string missing(std::span<const CandidateList> lists, std::span<const Vec3> position) const;
  // The smallest distance minus thickness of pairs that can be in contact, m.
  double smallest_gap(std::span<const Vec3> position) const;

  // Returns the answer that the path check must give. `refused`: a pair ends without a gap, or is
  // closer than half its thickness at a sample. `accepted`: every pair ends with a gap, and its
  // distance minus half the thickness never falls below a quarter of that at the start. Empty in
  // between, where the check may be as careful as it likes.
  enum class Verdict { refused, accepted };
  std::optional<Verdict> verdict(std::span<const Vec3> start, std::span<const Vec3> end) const;

 private:
  static PathDistances distances(const OraclePair& pair, std::span<const Vec3> start,
                                 std::span<const Vec3> end);
  void add_vertices(std::size_t list, int kind, const SceneBody& vertices,
                    const SceneBody& triangles);
  void add_edges(std::size_t list, const SceneBody& first, const SceneBody& second);
  void add(const OraclePair& pair);
  double range_of(const OraclePair& pair) const;
  void find_neighbourhoods(const SceneBody& body, double radius);
  bool are_neighbours(const SceneBody& body, const OraclePair& pair) const;

  const Scene& scene_;
  double range_;
  std::vector<CandidateList> searched_;
  std::vector<OraclePair> pairs_;
  // By vertex of the body whose pairs are being listed, then by triangle: 1 for neighbours.
  std::vector<std::vector<char>> neighbourhood_;
};

}  // namespace weft::sim
