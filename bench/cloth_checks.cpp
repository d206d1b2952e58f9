#include "bench/cloth_checks.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "sim/motion/dynamics.h"
#include "sim/scene/scene.h"

namespace weft::bench {

namespace {

// The tip's distance from the elastica's is the error; it is a share of the length.
std::vector<Measured> measure_cantilever(const FramedBody& strip, int frame) {
  if (frame == 0) return {};
  constexpr double length = 0.27;
  sim::Vec3 tip(0, 0, 0);
  for (int row = 0; row < strip.rows(); ++row)
    tip += (strip.now(row, -1) - strip.now(row, 0)) / (length * strip.rows());
  const ReferenceFigure drop = reference_figure("heavy_elastica_drop_over_length");
  const ReferenceFigure reach = reference_figure("heavy_elastica_reach_over_length");
  const double distance = std::hypot(-tip.z() - drop.value, tip.x() - reach.value);
  return {{"tip's distance", distance, {0, "tip of the elastica: " + drop.source}, 1}};
}

// The strain energy of the first body at the start, J.
double start_energy(const sim::Case& source) {
  const auto scene = sim::build_scene(source);
  sim::Statistics statistics;
  sim::Dynamics dynamics(*scene, statistics);
  const sim::Energies energies = dynamics.energies(0, dynamics.initial_state());
  return std::accumulate(energies.elastic.begin(), energies.elastic.end(), 0.0,
                         [](double sum, const auto& of_force) { return sum + of_force.second; });
}

// The whole strain energy of the plate over that of a cylinder, from 0 to 135 degrees.
std::vector<Measured> measure_rolled(const sim::Case& source) {
  constexpr double stiffness = 1e-2;  // N m
  const sim::BodyCase& plate = source.body.at(0);
  const double curvature = 1 / *plate.start->bend_radius;
  const double area = plate.shape.size.at(0) * plate.shape.size.at(1);
  const double exact = 0.5 * stiffness * curvature * curvature * area;
  std::vector<Measured> all;
  for (int degrees = 0; degrees <= 135; degrees += 15) {
    sim::Case turned = source;
    turned.body[0].start->bend_direction_deg = degrees;
    all.push_back(relative("energy at " + std::to_string(degrees) + " deg", start_energy(turned),
                           {exact, "D A / (2 R^2)"}));
  }
  return all;
}

CaseCheck rolled(const std::string& name, const std::string& material,
                 std::vector<CheckedImage> images, std::vector<std::string> overrides = {}) {
  overrides.push_back("body.0.material=\"" + material + '"');
  return {.name = "rolled plate, " + name,
          .case_name = "rolled_plate",
          .overrides = std::move(overrides),
          .images = std::move(images),
          .measure_case = measure_rolled};
}

}  // namespace

std::vector<CaseCheck> cloth_checks() {
  // Cloth does not bend at its free borders: the error is that of half a cell along them.
  const std::vector<CheckedImage> of_cloth{{{33, 49}}, {{65, 97}}, {{129, 193}, 1e-2}};
  const std::vector<CheckedImage> of_shells{{{9, 13}}, {{17, 25}}, {{33, 49}, 1e-2}};
  return {
      {.name = "cloth cantilever",
       .case_name = "cloth_cantilever",
       .images = {{{4, 14}}, {{4, 27}, 5e-3}, {{4, 53}}},
       .measure = measure_cantilever},
      rolled("cloth", "cloth", of_cloth),
      rolled("woven cloth", "woven", of_cloth),
      rolled("measured cloth", "measured", of_cloth),
      rolled("cubic shell", "shell", of_shells),
      rolled("quadratic shell", "shell", of_shells, {"material.shell.spline_degree=2"}),
  };
}

}  // namespace weft::bench
