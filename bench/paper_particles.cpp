// The paper's particles: 1k to 100k of them against a torus that is rebuilt every pass.
#include <cstdio>
#include <sstream>

#include "bench/experiments.h"
#include "bench/paper_measurement.h"
#include "bench/plot.h"

namespace weft::bench {

int run_paper_particles(const PaperOptions& options) {
  const int n = options.torus_size;
  std::ostringstream csv;
  csv << "# particles in a box about a torus of " << n << " x " << n << " vertices, margin "
      << 1e3 * scene_margin << " mm; medians of " << options.passes
      << " passes, ms of one thread; brute force where a pass takes seconds at most\n"
      << "particles,rebuild_ms,query_ms,narrow_ms,total_ms,candidates,hits,brute_ms,"
         "brute_passes\n";
  Series bsi{"BSI: all", {}, {}}, rebuild{"BSI: rebuild", {}, {}}, query{"BSI: query", {}, {}},
      brute{"brute force", {}, {}};
  bool right = true;
  for (const int count : options.particles) {
    CollisionScene scene{"particles", n, scene_margin, {}};
    scene.bodies.push_back(make_particles(count));
    scene.bodies.push_back(make_paper_torus(n));
    const PaperTimes times = measure_passes(scene, options.passes);
    right = right && times.same_hits;
    csv << count << ',' << times.rebuild_ms << ',' << times.query_ms << ',' << times.narrow_ms
        << ',' << times.total_ms() << ',' << times.candidates << ',' << times.hits << ',';
    if (times.brute_ms) csv << *times.brute_ms;
    csv << ',' << times.brute_passes << '\n';
    const auto add = [&](Series& series, double value) {
      series.x.push_back(count);
      series.y.push_back(value);
    };
    add(bsi, times.total_ms());
    add(rebuild, times.rebuild_ms);
    add(query, times.query_ms);
    if (times.brute_ms) add(brute, *times.brute_ms);
  }
  Plot plot{"Particles against a torus",
            "torus of " + std::to_string(n) + "² vertices, rebuilt every pass; one thread",
            {"particles"},
            {"time of a pass, ms"},
            {bsi, rebuild, query}};
  if (!brute.x.empty()) plot.series.push_back(brute);
  write_text(csv.str(), options.directory / "paper_particles.csv");
  write_svg(plot, options.directory / "paper_particles.svg");
  std::fputs(csv.str().c_str(), stdout);
  if (!right) std::fputs("paper-particles: brute force finds other hits\n", stderr);
  return right ? 0 : 1;
}

}  // namespace weft::bench
