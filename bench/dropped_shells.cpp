#include "bench/dropped_shells.h"

#include <stdexcept>
#include <string>
#include <vector>

#include "bench/medians.h"
#include "sim/motion/dynamics.h"
#include "sim/run/make_simulation.h"
#include "sim/scene/spline_surface.h"
#include "sim/simulation/simulation.h"
#include "sim/view/crossings.h"

namespace weft::bench {

namespace {

using namespace sim;

// The surface of a body in triangles.
struct FineSurface {
  FineSurface(const SceneBody& body, std::span<const Vec3> particles)
      : points(particles.begin(), particles.end()), triangles(body.mesh.triangles) {
    if (!body.spline) return;
    constexpr int samples = 6;
    const auto& [u, v] = body.spline->patches()[0];
    const bsi::Patch& patch = body.atlas.patches()[0];
    const int cols = samples * u.elements() + (patch.wrap_u ? 0 : 1);
    const int rows = samples * v.elements() + (patch.wrap_v ? 0 : 1);
    std::vector<SplineSurface::Place> places;
    for (int i = 0; i < rows * cols; ++i)
      places.push_back({0, 1.0 * (i % cols) / samples, 1.0 * (i / cols) / samples});
    std::vector<Vec3> room;
    const SurfaceMap map = body.spline->map_to(body.atlas, places);
    map.points_of(particles, rows * cols, room);
    points = room;
    const bsi::Patch fine{
        .rows = rows, .cols = cols, .wrap_u = patch.wrap_u, .wrap_v = patch.wrap_v};
    triangles = bsi::build_mesh(bsi::Atlas({fine})).triangles;
  }
  std::vector<Vec3> points;
  std::vector<std::array<int, 3>> triangles;
};

int crossings_of(const Simulation& simulation) {
  std::vector<Vec3> position, velocity;
  simulation.dynamics().expand_all(simulation.time(), simulation.state(), position, velocity);
  return surface_crossings(simulation.scene(), position);
}

}  // namespace

int surface_crossings(const Scene& scene, std::span<const Vec3> position) {
  std::vector<FineSurface> surfaces;
  for (const SceneBody& body : scene.bodies)
    surfaces.emplace_back(body, position.subspan(body.first_particle, body.particle_count()));
  std::vector<CrossingSurface> views;
  for (std::size_t b = 0; b < surfaces.size(); ++b)
    views.push_back({surfaces[b].points, surfaces[b].triangles, scene.bodies[b].dynamic});
  return static_cast<int>(find_crossings(views).size());
}

ShellDrop drop_shell(const Case& source) {
  constexpr int frames = 10;
  Simulation simulation = make_simulation(source);
  ShellDrop drop{.crossings = crossings_of(simulation)};
  for (int frame = 1; frame <= frames; ++frame) {
    const double seconds = frame * source.time.duration / frames - simulation.time();
    drop.cpu_s += cpu_time_of([&] {
      if (const auto failure = simulation.advance(seconds)) throw std::runtime_error(failure->text);
    });
    drop.touched |= simulation.contact_pairs() > 0;
    drop.crossings += crossings_of(simulation);
  }
  return drop;
}

}  // namespace weft::bench
