// Particles that pour onto a torus on a floor: CPU time per simulated second, and overlaps.
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <sstream>

#include "bench/experiments.h"
#include "bench/medians.h"
#include "bsi/sphere_hierarchy.h"
#include "sim/base/stopwatch.h"
#include "sim/case/case_reader.h"
#include "sim/motion/dynamics.h"
#include "sim/scene/scene.h"
#include "sim/scene/sphere_groups.h"
#include "sim/simulation/simulation.h"

namespace weft::bench {

namespace {

using namespace weft::sim;

constexpr double ball_radius = 0.02, tube_radius = 0.08, ring_radius = 0.25;  // m

// A lattice of 5 x 8 x 25 cells over a torus, as in cases/particles_torus.toml. More particles make
// everything larger alike, but for the particles.
struct PouredScene {
  explicit PouredScene(int count) : scale(std::cbrt(count / 1000.0)) {
    along[0] = std::max(1, static_cast<int>(std::lround(5 * scale)));
    along[1] = std::max(1, static_cast<int>(std::lround(8 * scale)));
    along[2] = std::max(1, (count + along[0] * along[1] - 1) / (along[0] * along[1]));
  }
  double scale;
  int along[3];

  std::string text(double seconds) const {
    std::ostringstream text;
    text << "[time]\nmethod = \"impulses\"\nduration = " << seconds
         << "\n[compute]\nthreads = 1\n[[particles]]\nname = \"balls\"\nradius = " << ball_radius
         << "\nrestitution = 0.3\nfriction = 0.4\npositions = { type = \"grid\", count = ["
         << along[0] << ", " << along[1] << ", " << along[2]
         << "], jitter = 0.0015, centre = [0, 0, " << 0.9 * scale
         << "] }\n[[obstacle]]\nname = \"torus\"\nposition = [0, 0, " << tube_radius * scale + 5e-4
         << "]\nshape = { type = \"torus\", major_radius = " << ring_radius * scale
         << ", minor_radius = " << tube_radius * scale
         << ", resolution = [96, 48] }\n[[obstacle]]\nname = \"floor\"\nshape = { type = "
            "\"plane\", size = ["
         << 20 * scale << ", " << 20 * scale << "] }\n";
    return text.str();
  }
  // True if the centre of a ball is inside the torus or below the floor.
  bool holds(const Vec3& x) const {
    const double from_ring = std::hypot(x.x(), x.y()) - ring_radius * scale;
    const double height = x.z() - tube_radius * scale - 5e-4;
    return std::hypot(from_ring, height) < tube_radius * scale || x.z() < 0;
  }
};

struct ParticlesRow {
  int particles = 0;
  double simulated = 0, cpu = 0;  // s
  double cpu_settled = 0;         // s per simulated second, in the last quarter
  std::int64_t steps = 0;
  double contacts = 0;                    // per particle, at the end
  std::int64_t overlaps = 0, inside = 0;  // in all judged states
  double peak_ratio = 0;                  // largest energy over that at the start
  std::string failure;
};

// Counts pairs of spheres that overlap, and spheres inside obstacles.
void judge(const Simulation& simulation, const PouredScene& scene, std::span<const double> radii,
           ParticlesRow& row) {
  const std::span<const Vec3> position = StateView::of(simulation.state()).position;
  bsi::SphereHierarchy hierarchy;
  hierarchy.rebuild(position, radii);
  std::int64_t tests = 0;
  for (const auto& [a, b] : hierarchy.near_pairs(0, tests))
    row.overlaps += (position[a] - position[b]).norm() < radii[a] + radii[b] ? 1 : 0;
  for (const Vec3& x : position) row.inside += scene.holds(x) ? 1 : 0;
}

ParticlesRow measure_particles(int count, double seconds) {
  const PouredScene scene(count);
  Simulation simulation(build_scene(parse_case(scene.text(seconds), "particles.toml")));
  const std::vector<double> radii = sphere_radii(simulation.scene());
  ParticlesRow row;
  row.particles = static_cast<int>(radii.size());
  const double start = simulation.energies().total();
  constexpr int judged_states = 40;
  double settled = 0;
  for (int part = 0; part < judged_states && row.failure.empty(); ++part) {
    const double cpu = cpu_time_of([&] {
      if (const auto failure = simulation.advance(seconds / judged_states))
        row.failure = failure->text;
    });
    row.cpu += cpu;
    if (part >= judged_states * 3 / 4) settled += cpu;
    row.peak_ratio = std::max(row.peak_ratio, simulation.energies().total() / start);
    judge(simulation, scene, radii, row);
  }
  row.simulated = simulation.time();
  row.cpu_settled = settled / (seconds / 4);
  row.steps = simulation.counts().steps;
  row.contacts = static_cast<double>(simulation.contact_pairs()) / row.particles;
  return row;
}

nlohmann::json json_of(const ParticlesRow& row) {
  return {{"particles", row.particles},
          {"simulated_s", row.simulated},
          {"cpu_s_per_s", row.cpu / row.simulated},
          {"cpu_s_per_s_settled", row.cpu_settled},
          {"steps", row.steps},
          {"contacts_per_particle", row.contacts},
          {"overlaps", row.overlaps},
          {"inside", row.inside},
          {"largest_energy_over_start", row.peak_ratio},
          {"failure", row.failure}};
}

}  // namespace

int run_particles(const ParticlesOptions& options) {
  nlohmann::json rows = nlohmann::json::array();
  bool holds = true;
  if (!options.json)
    std::printf(
        "particles  simulated s  CPU s per s  settled   steps  contacts each  overlaps  "
        "inside  energy/start\n");
  for (const int count : options.counts) {
    const ParticlesRow row = measure_particles(count, options.seconds);
    holds &= row.overlaps == 0 && row.inside == 0 && row.failure.empty();
    rows.push_back(json_of(row));
    if (options.json) continue;
    std::printf("%9d  %11.3g  %11.3g  %7.3g  %6lld  %13.2f  %8lld  %6lld  %12.6f%s\n",
                row.particles, row.simulated, row.cpu / row.simulated, row.cpu_settled,
                static_cast<long long>(row.steps), row.contacts,
                static_cast<long long>(row.overlaps), static_cast<long long>(row.inside),
                row.peak_ratio, row.failure.empty() ? "" : ("  " + row.failure).c_str());
    std::fflush(stdout);
  }
  if (options.json) std::printf("%s\n", nlohmann::json{{"rows", rows}}.dump(2).c_str());
  return holds ? 0 : 1;
}

}  // namespace weft::bench
