// The paper's particles: 1k to 100k of them against a torus that is rebuilt in every pass.
#include "bench/experiments.h"
#include "bench/paper_measurement.h"

namespace weft::bench {

int run_paper_particles(const PaperOptions& options) {
  const int n = options.torus_size;
  const std::string size = std::to_string(n);
  PaperFigure figure("particles in a box about a torus of " + size + " x " + size + " vertices",
                     "particles", options.passes);
  for (const int count : options.particles) {
    CollisionScene scene{"particles", n, scene_margin, {}};
    scene.bodies.push_back(make_particles(count));
    scene.bodies.push_back(make_paper_torus(n));
    figure.add(scene, std::to_string(count), count);
  }
  const std::string note = "torus of " + size + "² vertices, rebuilt every pass; one thread";
  return figure.write(options.directory, "paper_particles", "Particles against a torus", note,
                      "particles")
             ? 0
             : 1;
}

}  // namespace weft::bench
