// The results of the hierarchy benchmark, as JSON and as tables.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace weft::bench {

enum class MethodKind {
  weft,     // Weft as users get it
  variant,  // Weft with other options, for comparison
  peer,
  oracle,  // brute force
};

// Medians of one method on one scene, ms; empty if the method has no such operation.
struct Row {
  std::string scene;
  int n = 0;
  std::string method;
  MethodKind kind = MethodKind::peer;
  int threads = 1;
  std::optional<double> rebuild_ms{}, refit_ms{}, query_ms{};
  std::optional<double> narrow_ms{};       // its own exact test, or that of bench/triangle_test.h
  std::optional<double> weft_narrow_ms{};  // Weft's narrow phase on its candidates
  std::optional<long> candidates{}, hits{};
};

struct Results {
  std::vector<Row> rows;
  int floor_n = 0;      // size that the two values below are for
  double floor_ms = 0;  // a copy: the image's bytes read, the hierarchy's written
  std::size_t hierarchy_bytes = 0;
};

std::string to_json(const Results& results);
// Returns the rows, with the factor by which Weft is faster than the best of its peers.
std::string to_table(const Results& results);

}  // namespace weft::bench
