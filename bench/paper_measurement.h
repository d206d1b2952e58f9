// What the two timed experiments of the paper have in common.
#pragma once

#include <optional>

#include "bench/scenes.h"

namespace weft::bench {

// Medians over the passes, ms of one thread.
struct PaperTimes {
  double rebuild_ms = 0;  // of the hierarchies of all bodies but particles
  double query_ms = 0;    // candidates
  double narrow_ms = 0;   // hits among them
  long candidates = 0, hits = 0;
  // Brute force: every pair of boxes tested, then the same exact test. None where it would take too
  // long (some seconds a pass).
  std::optional<double> brute_ms;
  int brute_passes = 0;
  bool same_hits = true;  // as brute force

  double total_ms() const { return rebuild_ms + query_ms + narrow_ms; }
};

// Rebuild, query and exact test, `passes` times over; brute force as often as that goes within a
// second, but once.
PaperTimes measure_passes(const CollisionScene& scene, int passes);

}  // namespace weft::bench
