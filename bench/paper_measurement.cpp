#include "bench/paper_measurement.h"

#include <cstdio>
#include <optional>

#include "bench/medians.h"
#include "bench/weft_method.h"

namespace weft::bench {

namespace {

struct PaperTimes {
  double rebuild_ms = 0, query_ms = 0, narrow_ms = 0;
  long candidates = 0, hits = 0;
  std::optional<double> brute_ms;
  int brute_passes = 0;
  bool same_hits = true;  // as brute force

  double total_ms() const { return rebuild_ms + query_ms + narrow_ms; }
};

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

PaperTimes measure_passes(const CollisionScene& scene, int passes) {
  WeftMethod weft(scene, {});
  std::vector<double> rebuild, query, narrow;
  std::vector<LeafPair> pairs;
  PaperTimes times;
  for (int pass = 0; pass < passes; ++pass) {
    pairs.clear();
    rebuild.push_back(1e3 * thread_time_of([&] { weft.rebuild(); }));
    query.push_back(1e3 * thread_time_of([&] { weft.query(pairs); }));
    narrow.push_back(1e3 * thread_time_of([&] { times.hits = weft.hits(pairs, scene.margin); }));
  }
  if (pairs.empty()) weft.list(pairs);
  times.candidates = static_cast<long>(pairs.size());
  times.rebuild_ms = median(rebuild);
  times.query_ms = median(query);
  times.narrow_ms = median(narrow);
  measure_brute_force(scene, passes, times);
  return times;
}

}  // namespace

PaperFigure::PaperFigure(const std::string& scenes, const std::string& columns, int passes)
    : passes_(passes) {
  csv_ << "# " << scenes << ", margin " << 1e3 * scene_margin << " mm; medians of " << passes
       << " passes, ms of one thread; brute force where a pass takes seconds at most\n"
       << columns
       << ",rebuild_ms,query_ms,narrow_ms,total_ms,candidates,hits,brute_ms,brute_passes\n";
}

void PaperFigure::add(const CollisionScene& scene, const std::string& columns, double x) {
  const PaperTimes times = measure_passes(scene, passes_);
  right_ = right_ && times.same_hits;
  csv_ << columns << ',' << times.rebuild_ms << ',' << times.query_ms << ',' << times.narrow_ms
       << ',' << times.total_ms() << ',' << times.candidates << ',' << times.hits << ',';
  if (times.brute_ms) csv_ << *times.brute_ms;
  csv_ << ',' << times.brute_passes << '\n';
  const auto add_point = [&](Series& series, double value) {
    series.x.push_back(x);
    series.y.push_back(value);
  };
  add_point(bsi_, times.total_ms());
  add_point(rebuild_, times.rebuild_ms);
  add_point(query_, times.query_ms);
  if (times.brute_ms) add_point(brute_, *times.brute_ms);
}

bool PaperFigure::write(const std::filesystem::path& directory, const std::string& name,
                        const std::string& title, const std::string& note,
                        const std::string& x_title) const {
  Plot plot{title, note, {x_title}, {"time of a pass, ms"}, {bsi_, rebuild_, query_}};
  if (!brute_.x.empty()) plot.series.push_back(brute_);
  write_text(csv_.str(), directory / (name + ".csv"));
  write_svg(plot, directory / (name + ".svg"));
  std::fputs(csv_.str().c_str(), stdout);
  if (!right_) std::fprintf(stderr, "%s: brute force finds other hits\n", name.c_str());
  return right_;
}

}  // namespace weft::bench
