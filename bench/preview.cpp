// Linearly implicit steps as a preview: run time, crossings, stretch and energy by the step.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/experiments.h"
#include "sim/base/process_time.h"
#include "sim/case/case_reader.h"
#include "sim/case/case_text.h"
#include "sim/motion/external_work.h"
#include "sim/simulation/simulation.h"
#include "sim/view/crossings.h"

namespace weft::bench {

namespace {

using namespace sim;

struct PreviewRow {
  std::string scene;
  double step = 0;       // s
  double cpu = 0;        // s of CPU time per simulated second
  int crossings = 0;     // pairs of triangles that pass through each other, summed over all steps
  double stretch = 0;    // largest
  double gained = 0;     // largest energy beyond what was put in, by the largest kinetic energy
  std::int64_t cut = 0;  // steps cut to keep surfaces apart
  std::int64_t steps = 0;
  std::string failure;
};

// Energies and surfaces of a run, measured by dynamics of their own.
class Watch {
 public:
  Watch(const Scene& scene, std::span<const double> state)
      : scene_(scene), dynamics_(scene, statistics_), work_(dynamics_, state) {
    start_ = energy(dynamics_.energies(0, state));
  }

  void look(double time, std::span<const double> state, PreviewRow& row) {
    work_.add_step(time, state);
    const Energies now = dynamics_.energies(time, state);
    const double put_in = start_ + work_.work() + work_.doubt() + work_.held_kinetic_energy() +
                          work_.held_gravitational_energy();
    gained_ = std::max(gained_, energy(now) - put_in);
    kinetic_ = std::max(kinetic_, now.kinetic);
    row.gained = kinetic_ > 0 ? gained_ / kinetic_ : 0;
    dynamics_.expand_all(time, state, position_, velocity_);
    row.stretch = std::max(row.stretch, dynamics_.largest_stretch(position_));
    std::vector<CrossingSurface> surfaces;
    for (const SceneBody& body : scene_.bodies) {
      surfaces.push_back({std::span(position_).subspan(body.first_particle, body.particle_count()),
                          body.mesh.triangles, body.dynamic});
    }
    row.crossings += static_cast<int>(find_crossings(surfaces).size());
  }

 private:
  // The energy of contact counts once it has become motion (energy_watch.h).
  static double energy(const Energies& now) { return now.total() - now.contact; }

  const Scene& scene_;
  Statistics statistics_;
  Dynamics dynamics_;
  ExternalWork work_;
  double start_ = 0, gained_ = 0, kinetic_ = 0;  // J
  std::vector<Vec3> position_, velocity_;
};

PreviewRow preview(const Case& source, const std::string& name, double step) {
  Case timed = source;
  timed.time.method = TimeMethod::euler;
  timed.time.newton = 1;
  timed.time.step = step;
  timed.compute.threads = 1;
  const std::unique_ptr<const Scene> scene = build_scene(timed);
  Simulation simulation(*scene);
  Watch watch(*scene, simulation.state());
  PreviewRow row;
  row.scene = name;
  row.step = step;
  while (simulation.time() < timed.time.duration) {
    const double before = process_cpu_time();
    const auto failure = simulation.step();
    row.cpu += process_cpu_time() - before;
    if (failure) {
      row.failure = failure->text;
      break;
    }
    watch.look(simulation.time(), simulation.state(), row);
  }
  row.cpu /= std::max(simulation.time(), step);
  row.cut = simulation.counts().vetoed_steps;
  row.steps = simulation.counts().steps;
  return row;
}

void print(const PreviewRow& row) {
  std::printf("%-24s 1/%-5.0f %12.3f %7lld %5lld %10d %8.1f %% %9.2f %%  %s\n", row.scene.c_str(),
              1 / row.step, row.cpu, static_cast<long long>(row.steps),
              static_cast<long long>(row.cut), row.crossings, 100 * row.stretch, 100 * row.gained,
              row.failure.c_str());
}

nlohmann::ordered_json json_of(const PreviewRow& row) {
  return {{"scene", row.scene},
          {"step_s", row.step},
          {"cpu_s_per_s", row.cpu},
          {"steps", row.steps},
          {"cut_steps", row.cut},
          {"crossings", row.crossings},
          {"stretch", row.stretch},
          {"gained", row.gained},
          {"failure",
           row.failure.empty() ? nlohmann::ordered_json() : nlohmann::ordered_json(row.failure)}};
}

}  // namespace

int run_preview(const PreviewOptions& options) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  bool is_right = true;
  if (!options.json)
    std::printf("%-24s %-7s %12s %7s %5s %10s %10s %11s\n", "scene", "step s", "CPU s per s",
                "steps", "cut", "crossings", "stretch", "gained");
  for (const std::string& path : options.cases) {
    const Case source = read_case(path, options.overrides);
    for (const int rate : options.rates) {
      const PreviewRow row =
          preview(source, std::filesystem::path(path).stem().string(), 1.0 / rate);
      is_right = is_right && row.crossings == 0 && row.failure.empty();
      if (options.json)
        rows.push_back(json_of(row));
      else
        print(row);
    }
  }
  if (options.json)
    std::printf("%s\n", nlohmann::ordered_json{{"rows", std::move(rows)}}.dump(2).c_str());
  return is_right ? 0 : 1;
}

}  // namespace weft::bench
