#include "bench/paper_measurement.h"

#include <array>
#include <cstdio>
#include <optional>

#include "bench/medians.h"
#include "bench/weft_method.h"

namespace weft::bench {

namespace {

constexpr std::array bounds{bsi::Bound::sphere, bsi::Bound::box, bsi::Bound::sphere_then_box};
constexpr std::array bound_names{"sphere", "box", "sphere_then_box"};

struct BoundTimes {
  double rebuild_ms = 0, query_ms = 0, narrow_ms = 0;
  long candidates = 0, hits = 0;
  double total_ms() const { return rebuild_ms + query_ms + narrow_ms; }
};

struct PaperTimes {
  std::array<BoundTimes, bounds.size()> by_bound;
  std::optional<double> brute_ms;
  int brute_passes = 0;
  bool same = true;  // candidates and hits, by every bound and brute force
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
    times.same = times.same && hits == times.by_bound.front().hits &&
                 static_cast<long>(pairs.size()) == times.by_bound.front().candidates;
  }
  times.brute_ms = median(taken);
  times.brute_passes = static_cast<int>(taken.size());
}

// Weft with one bound, and its times by pass.
struct BoundMethod {
  std::unique_ptr<WeftMethod> weft;
  std::vector<double> rebuild{}, query{}, narrow{};
  std::vector<LeafPair> pairs{};
  BoundTimes times{};

  void run_pass(double margin) {
    pairs.clear();
    rebuild.push_back(1e3 * thread_time_of([&] { weft->rebuild(); }));
    query.push_back(1e3 * thread_time_of([&] { weft->query(pairs); }));
    narrow.push_back(1e3 * thread_time_of([&] { times.hits = weft->hits(pairs, margin); }));
  }
  BoundTimes result() {
    if (pairs.empty()) weft->list(pairs);
    times.candidates = static_cast<long>(pairs.size());
    times.rebuild_ms = median(rebuild);
    times.query_ms = median(query);
    times.narrow_ms = median(narrow);
    return times;
  }
};

// Measures all bounds alternately, pass after pass.
PaperTimes measure_passes(const CollisionScene& scene, int passes) {
  std::vector<BoundMethod> methods;
  for (const bsi::Bound bound : bounds)
    methods.push_back({std::make_unique<WeftMethod>(scene, WeftVariant{.bound = bound})});
  for (int pass = 0; pass < passes; ++pass) {
    for (BoundMethod& method : methods) method.run_pass(scene.margin);
  }
  PaperTimes times;
  for (std::size_t i = 0; i < bounds.size(); ++i) {
    times.by_bound[i] = methods[i].result();
    times.same = times.same && times.by_bound[i].hits == times.by_bound.front().hits &&
                 times.by_bound[i].candidates == times.by_bound.front().candidates;
  }
  measure_brute_force(scene, passes, times);
  return times;
}

}  // namespace

PaperFigure::PaperFigure(const std::string& scenes, const std::string& columns, int passes)
    : passes_(passes) {
  csv_ << "# " << scenes << ", margin " << 1e3 * scene_margin << " mm; medians of " << passes
       << " passes, ms of one thread; brute force where a pass takes seconds at most\n"
       << columns << ",bound,rebuild_ms,query_ms,narrow_ms,total_ms,candidates,hits,brute_passes\n";
}

void PaperFigure::add(const CollisionScene& scene, const std::string& columns, double x) {
  const PaperTimes times = measure_passes(scene, passes_);
  right_ = right_ && times.same;
  const auto add_point = [&](sim::PlotSeries& series, double value) {
    series.x.push_back(x);
    series.y.push_back(value);
  };
  for (std::size_t i = 0; i < bounds.size(); ++i) {
    const BoundTimes& bound = times.by_bound[i];
    csv_ << columns << ',' << bound_names[i] << ',' << bound.rebuild_ms << ',' << bound.query_ms
         << ',' << bound.narrow_ms << ',' << bound.total_ms() << ',' << bound.candidates << ','
         << bound.hits << ",\n";
    add_point(by_bound_[i], bound.total_ms());
  }
  if (!times.brute_ms) return;
  csv_ << columns << ",brute_force,,,," << *times.brute_ms << ','
       << times.by_bound.front().candidates << ',' << times.by_bound.front().hits << ','
       << times.brute_passes << '\n';
  add_point(brute_, *times.brute_ms);
}

bool PaperFigure::write(const std::filesystem::path& directory, const std::string& name,
                        const std::string& title, const std::string& note,
                        const std::string& x_title) const {
  sim::Plot plot{
      title, note, {x_title}, {"time of a pass, ms"}, {by_bound_.begin(), by_bound_.end()}};
  if (!brute_.x.empty()) plot.series.push_back(brute_);
  sim::write_text(csv_.str(), directory / (name + ".csv"));
  sim::write_svg(plot, directory / (name + ".svg"));
  std::fputs(csv_.str().c_str(), stdout);
  if (!right_)
    std::fprintf(stderr, "%s: not all find the same candidates and hits\n", name.c_str());
  return right_;
}

}  // namespace weft::bench
