#include "bench/paper_measurement.h"

#include "bench/medians.h"
#include "bench/weft_method.h"

namespace weft::bench {

namespace {

void measure_brute_force(const CollisionScene& scene, int passes, PaperTimes& times) {
  std::vector<PeerMaker> makers;
  add_brute_force(makers);
  const std::unique_ptr<Peer> brute_force = makers.front().make(mesh_view(scene));
  if (!brute_force) return;
  std::vector<double> taken;
  double spent = 0;
  for (int pass = 0; pass < passes && (pass == 0 || spent < 1); ++pass) {
    std::vector<LeafPair> pairs;
    long hits = 0;
    const double time = thread_time_of([&] {
      brute_force->query(pairs);
      hits = weft_hits(scene, pairs, 1);
    });
    taken.push_back(1e3 * time);
    spent += time;
    times.same_hits = times.same_hits && hits == times.hits &&
                      static_cast<long>(pairs.size()) == times.candidates;
  }
  times.brute_ms = median(taken);
  times.brute_passes = static_cast<int>(taken.size());
}

}  // namespace

PaperTimes measure_passes(const CollisionScene& scene, int passes) {
  WeftMethod weft(scene, true, 1);
  std::vector<double> rebuild, query, narrow;
  std::vector<LeafPair> pairs;
  PaperTimes times;
  for (int pass = 0; pass < passes; ++pass) {
    pairs.clear();
    rebuild.push_back(1e3 * thread_time_of([&] { weft.rebuild(); }));
    query.push_back(1e3 * thread_time_of([&] { weft.query(pairs); }));
    narrow.push_back(1e3 * thread_time_of([&] { times.hits = weft_hits(scene, pairs, 1); }));
  }
  times.candidates = static_cast<long>(pairs.size());
  times.rebuild_ms = median(rebuild);
  times.query_ms = median(query);
  times.narrow_ms = median(narrow);
  measure_brute_force(scene, passes, times);
  return times;
}

}  // namespace weft::bench
