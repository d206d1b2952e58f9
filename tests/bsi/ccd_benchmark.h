// The sample queries of Wang et al. 2021, "A Large-Scale Benchmark and an Inclusion-Based Algorithm
// for Continuous Collision Detection", with their exact truth.
#pragma once

#include <string>
#include <vector>

#include "bsi/detail/feature_batches.h"
#include "bsi/proximity.h"

namespace weft::bsi {

struct BenchmarkQuery {
  FeatureKind kind = FeatureKind::vertex_triangle;
  FourPoints start, end;
  bool collides = false;
  std::string place;  // file and number of the query in it
};

// Reads all queries below a folder, in the order of their paths. A file has 8 rows per query, each
// x, y, z as numerator and denominator, then the truth. The rationals are exact doubles, which the
// function tests by expectations.
std::vector<BenchmarkQuery> read_ccd_benchmark(const std::string& folder);

}  // namespace weft::bsi
