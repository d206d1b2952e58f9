#include <sys/resource.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "bench/child_runs.h"
#include "bench/experiments.h"
#include "bench/medians.h"
#include "bench/skipping_scenes.h"
#include "bench/temporary_folder.h"
#include "sim/case/case_reader.h"
#include "sim/run/recorded_run.h"
#include "sim/scene/scene.h"
#include "sim/trajectory/trajectory.h"

namespace weft::bench {

namespace {

constexpr double longest_run = 600;  // s of CPU time

// User CPU time of this process, s.
double user_time() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_utime.tv_sec) +
         1e-6 * static_cast<double>(usage.ru_utime.tv_usec);
}

struct Timed {
  double set_up = 0, run = 0;  // s, user
  std::size_t trajectory = 0;  // a hash of the first body's last frame
};

// Makes a whole run with its file, like the command. The time until the end of the first step
// counts as set-up.
Timed run_case(const std::string& text) {
  using namespace sim;
  const TemporaryFolder folder;
  const double start = user_time();
  double first_step = 0;
  const auto scene = build_scene(parse_case(text, "skipping.toml"));
  RunOptions options;
  options.trajectory = folder.path("run.h5");
  options.progress = [&](double) {
    if (first_step == 0) first_step = user_time();
  };
  const RunReport report = run_simulation(*scene, options);
  if (report.status != RunReport::Status::done) throw std::runtime_error(report.reason);
  Timed timed{first_step - start, user_time() - first_step, 0};
  const TrajectoryReader reader(folder.path("run.h5"));
  const std::vector<Vec3> positions = reader.positions(0, reader.frames() - 1);
  const std::string_view bytes(reinterpret_cast<const char*>(positions.data()),
                               positions.size() * sizeof(Vec3));
  timed.trajectory = std::hash<std::string_view>()(bytes);
  return timed;
}

struct Ratios {
  std::vector<double> run, set_up_without, set_up_with, without, with;
  bool same = true;
};

// Measures a pair of scenes. Each run has its own process, so neither reuses the other's memory.
Ratios measure(const SkippingPair& pair, int repeats) {
  std::vector<Timed> runs(2 * repeats);
  run_children(
      runs.size(), 1, [](std::size_t) { return longest_run; },
      [&](std::size_t i) {
        const Timed timed = run_case(i % 2 == 0 ? pair.without : pair.with);
        return std::string(reinterpret_cast<const char*>(&timed), sizeof timed);
      },
      [&](std::size_t i, const ChildEnd& end) {
        if (!end.is_well || end.result.size() != sizeof(Timed))
          throw std::runtime_error(pair.name + ": a run has failed");
        std::memcpy(&runs[i], end.result.data(), sizeof(Timed));
      });
  Ratios ratios;
  for (std::size_t i = 0; i < runs.size(); i += 2) {
    ratios.run.push_back(runs[i + 1].run / runs[i].run);
    ratios.without.push_back(runs[i].run);
    ratios.with.push_back(runs[i + 1].run);
    ratios.set_up_without.push_back(runs[i].set_up);
    ratios.set_up_with.push_back(runs[i + 1].set_up);
    ratios.same = ratios.same && runs[i].trajectory == runs[i + 1].trajectory;
  }
  return ratios;
}

nlohmann::ordered_json row_of(const SkippingPair& pair, const Ratios& ratios) {
  nlohmann::ordered_json row{{"pair", pair.name},
                             {"meaning", pair.meaning},
                             {"ratio", median(ratios.run)},
                             {"bar", pair.bar},
                             {"without_s", median(ratios.without)},
                             {"with_s", median(ratios.with)},
                             {"set_up_without_s", median(ratios.set_up_without)},
                             {"set_up_with_s", median(ratios.set_up_with)}};
  row["same_trajectory"] = ratios.same;
  return row;
}

void print(const SkippingPair& pair, const Ratios& ratios) {
  const double ratio = median(ratios.run);
  char bar[32] = "    -";
  if (pair.bar > 0)
    std::snprintf(bar, sizeof bar, "%5.2f %s", pair.bar, ratio <= pair.bar ? "met" : "MISSED");
  std::printf("%-11s %6.3f  %-12s %8.3f %8.3f %9.3f %8.3f  %-4s %s\n", pair.name.c_str(), ratio,
              bar, median(ratios.without), median(ratios.with), median(ratios.set_up_without),
              median(ratios.set_up_with), ratios.same ? "yes" : "no", pair.meaning.c_str());
  std::fflush(stdout);
}

}  // namespace

std::vector<std::string> skipping_pair_names() {
  std::vector<std::string> names;
  for (const SkippingPair& pair : skipping_pairs()) names.push_back(pair.name);
  return names;
}

int run_skipping(const SkippingOptions& options) {
  if (!options.json) {
    std::printf("user CPU time (s), medians of %d pairs of runs in turn\n", options.repeats);
    std::printf("pair         ratio  bar           without     with  set-up: o     with  same\n");
  }
  nlohmann::ordered_json json;
  json["rows"] = nlohmann::json::array();
  bool is_right = true;
  for (const SkippingPair& pair : skipping_pairs()) {
    if (!options.pairs.empty() &&
        std::ranges::find(options.pairs, pair.name) == options.pairs.end())
      continue;
    const Ratios ratios = measure(pair, options.repeats);
    if (options.json) {
      json["rows"].push_back(row_of(pair, ratios));
    } else {
      print(pair, ratios);
    }
    if (!pair.same_trajectory || ratios.same) continue;
    is_right = false;
    std::fprintf(stderr, "%s: the trajectories differ\n", pair.name.c_str());
  }
  if (options.json) std::printf("%s\n", json.dump(2).c_str());
  return is_right ? 0 : 1;
}

}  // namespace weft::bench
