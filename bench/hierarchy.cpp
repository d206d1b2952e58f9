// Compares Weft's hierarchy and traversals with those of its peers, and shows how their cost grows.
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>

#include "bench/experiments.h"
#include "bench/medians.h"
#include "bench/scene_measurement.h"
#include "bench/weft_method.h"

namespace weft::bench {

namespace {

// A copy that reads the image once, in order, and writes as many bytes as the hierarchy has.
class Copy {
 public:
  Copy(const std::vector<bsi::Vec3>& image, std::size_t bytes)
      : image_(image), hierarchy_(std::max(bytes, std::size_t{1}), 1) {}
  void run() {
    const auto* source = reinterpret_cast<const char*>(image_.data());
    const std::size_t size = image_.size() * sizeof(bsi::Vec3), all = hierarchy_.size();
    // It copies in small pieces, so that bytes that are read twice come from the cache.
    constexpr std::size_t piece = 4096;
    const std::size_t pieces = (size + piece - 1) / piece;
    for (std::size_t i = 0; i < pieces; ++i) {
      const std::size_t begin = all * i / pieces, end = all * (i + 1) / pieces;
      const std::size_t from = i * piece, most = std::min(piece, size - from);
      for (std::size_t at = begin; at < end; at += most)
        std::memcpy(hierarchy_.data() + at, source + from, std::min(most, end - at));
    }
  }

 private:
  const std::vector<bsi::Vec3>& image_;
  std::vector<char> hierarchy_;
};

Row growth_row(int n, const char* method, MethodKind kind, int threads,
               const std::vector<double>& rebuild) {
  Row row{"drape-growth", n, method, kind, threads};
  row.rebuild_ms = median(rebuild);
  return row;
}

// Measures alternating rebuilds of all kinds on the drape. The margin is an eighth of a quad's
// size: a fixed margin would soon reach every vertex's neighbours.
void measure_growth(int n, int repeats, Results& results) {
  CollisionScene scene = make_scene("drape", n);
  scene.margin = 0.25 / n;
  const Body& sheet = scene.bodies.front();
  WeftMethod boxes(scene, {}), spheres(scene, {.bound = bsi::Bound::sphere_then_box});
  Copy copy(sheet.start, boxes.bytes());
  std::vector<double> copy_ms, boxes_ms, query_ms, spheres_ms;
  std::vector<LeafPair> pairs;
  for (int pass = -1; pass < repeats; ++pass) {  // the first warms up
    const auto take = [&](std::vector<double>& times, const auto& work) {
      const double time = 1e3 * thread_time_of(work);
      if (pass >= 0) times.push_back(time);
    };
    take(copy_ms, [&] { copy.run(); });
    take(boxes_ms, [&] { boxes.rebuild(); });
    pairs.clear();
    take(query_ms, [&] { boxes.query(pairs); });
    boxes.list(pairs);
    take(spheres_ms, [&] { spheres.rebuild(); });
  }
  results.rows.push_back(growth_row(n, "copy", MethodKind::variant, 1, copy_ms));
  Row weft = growth_row(n, "weft", MethodKind::weft, 1, boxes_ms);
  weft.query_ms = median(query_ms);
  weft.candidates = static_cast<long>(pairs.size());
  results.rows.push_back(weft);
  results.rows.push_back(growth_row(n, "weft-sphere-then-box", MethodKind::variant, 1, spheres_ms));
  // Memory and floor are stated for this size.
  if (results.floor_n == 0 || n == 256) {
    results.floor_n = n;
    results.floor_ms = median(copy_ms);
    results.hierarchy_bytes = boxes.bytes();
  }
}

// Measures the gain of several threads on a scene in contact: wall times of rebuild and query,
// alternating between one thread and `threads`.
void measure_threads(int n, int threads, int repeats, Results& results) {
  const CollisionScene scene = make_scene("crumpled", n);
  std::vector<LeafPair> pairs;
  struct Crew {
    WeftMethod weft;
    int threads;
    std::vector<double> rebuild{}, query{};
  };
  std::array<Crew, 2> crews{Crew{{scene, {}}, 1}, Crew{{scene, {.threads = threads}}, threads}};
  for (int pass = -1; pass < repeats; ++pass) {  // the first warms up
    for (Crew& crew : crews) {
      const double made = 1e3 * wall_time_of([&] { crew.weft.rebuild(); });
      pairs.clear();
      const double found = 1e3 * wall_time_of([&] { crew.weft.query(pairs); });
      if (pass < 0) continue;
      crew.rebuild.push_back(made);
      crew.query.push_back(found);
    }
  }
  for (const Crew& crew : crews) {
    Row row{"crumpled-threads", n, "weft", MethodKind::variant, crew.threads};
    row.rebuild_ms = median(crew.rebuild);
    row.query_ms = median(crew.query);
    row.candidates = static_cast<long>(pairs.size());
    results.rows.push_back(row);
  }
}

// Shows the running scene on one line of a terminal, replacing the previous text; n = 0 clears it.
void say_what_is_running(const std::string& scene, int n) {
  if (isatty(STDERR_FILENO) == 0) return;
  std::fprintf(stderr, "\r\033[K");
  if (n > 0) std::fprintf(stderr, "%s, n = %d", scene.c_str(), n);
}

}  // namespace

int run_hierarchy(const HierarchyOptions& options) {
  Results results;
  bool right = true;
  const SceneMeasurement measurement{options.repeats, options.threads, options.methods};
  const std::vector<std::string> scenes = options.scenes.empty() ? scene_names() : options.scenes;
  for (const int n : options.sizes) {
    for (const std::string& name : scenes) {
      say_what_is_running(name, n);
      right = measure_scene(make_scene(name, n), measurement, results.rows) && right;
    }
  }
  for (const int n : options.growth) {
    say_what_is_running("growth", n);
    measure_growth(n, options.repeats, results);
  }
  const int most = *std::max_element(options.threads.begin(), options.threads.end());
  if (most > 1 && !options.growth.empty()) {
    const auto fits = std::find(options.growth.begin(), options.growth.end(), 1024);
    measure_threads(fits != options.growth.end() ? *fits : options.growth.back(), most,
                    options.repeats, results);
  }
  say_what_is_running("", 0);
  const std::string text = options.json ? to_json(results) : to_table(results);
  std::fwrite(text.data(), 1, text.size(), stdout);
  return right ? 0 : 1;
}

}  // namespace weft::bench
