#include "bench/membrane_measures.h"

#include <cmath>
#include <memory>
#include <numbers>
#include <stdexcept>

#include "materials/spring.h"
#include "sim/case/case_text.h"
#include "sim/forces/force_arrays.h"
#include "sim/forces/springs.h"
#include "sim/run/make_simulation.h"
#include "sim/simulation/simulation.h"

namespace weft::bench {

namespace {

using sim::Case;
using sim::Scene;
using sim::Vec3;

constexpr std::array fabric_stretches{1.005, 1.03, 1.1, 1.25};

double green_strain(double stretch) { return 0.5 * (stretch * stretch - 1); }

// The pulls of the sheet under another stretch and with another direction of its warp.
std::array<double, 2> pulls_of(const Case& sheet, const Vec3& stretch, double warp_angle_deg) {
  Case changed = sheet;
  changed.body.at(0).stretch = stretch;
  changed.body[0].warp_angle_deg = warp_angle_deg;
  const auto scene = sim::build_scene(changed);
  return membrane_pulls(*scene, scene->initial_position);
}

// Returns the place of the least value of a function that falls before it and rises after it, by
// the golden section.
double place_of_least(double from, double to, const auto& value_at) {
  const double share = std::numbers::phi - 1;
  while (to - from > 1e-9) {
    const double first = to - share * (to - from), second = from + share * (to - from);
    if (value_at(first) < value_at(second)) {
      to = second;
    } else {
      from = first;
    }
  }
  return 0.5 * (from + to);
}

}  // namespace

std::array<double, 2> membrane_pulls(const Scene& scene, std::span<const Vec3> position) {
  const std::vector<Vec3> at_rest(position.size(), Vec3::Zero());
  std::vector<Vec3> forces(position.size(), Vec3::Zero());
  make_membrane_force(scene)->add_forces({position, at_rest}, forces, 1);
  const bsi::Atlas& atlas = scene.bodies[0].atlas;
  const bsi::Patch& patch = atlas.patches()[0];
  std::array<double, 2> pulls{};
  for (int row = 0; row < patch.rows; ++row)
    pulls[0] -= forces[atlas.particle(0, row, patch.cols - 1)].x();
  for (int col = 0; col < patch.cols; ++col)
    pulls[1] -= forces[atlas.particle(0, patch.rows - 1, col)].y();
  return pulls;
}

// The published force per rest width is stretch x S.
std::vector<FabricPull> uniaxial_pulls(const Case& sheet, const MeasuredFabric& fabric,
                                       double degrees) {
  const double c = std::cos(degrees * std::numbers::pi / 180),
               s = std::sin(degrees * std::numbers::pi / 180);
  const double width = sheet.body.at(0).shape.size.at(1);
  std::vector<FabricPull> pulls;
  for (const double stretch : fabric_stretches) {
    const double e = green_strain(stretch);
    const auto tension = published_tension(fabric, e * c * c, e * s * s, e * c * s);
    const double along = tension[0] * c * c + tension[1] * s * s + 2 * tension[2] * c * s;
    // The warp lies at -degrees to the pull: the pull lies at degrees to the warp.
    pulls.push_back({sim::number_text(degrees) + " deg, " + sim::number_text(stretch),
                     pulls_of(sheet, {stretch, 1, 1}, -degrees)[0], stretch * along * width});
  }
  return pulls;
}

std::vector<FabricPull> biaxial_pulls(const Case& sheet, const MeasuredFabric& fabric) {
  const std::vector<double>& size = sheet.body.at(0).shape.size;
  std::vector<FabricPull> pulls;
  for (const double stretch : fabric_stretches) {
    const double e = green_strain(stretch);
    const auto tension = published_tension(fabric, e, e, 0);
    const auto both = pulls_of(sheet, {stretch, stretch, 1}, 0);
    pulls.push_back({"both, " + sim::number_text(stretch),
                     both[0] / size.at(1) + both[1] / size.at(0),
                     stretch * (tension[0] + tension[1])});
  }
  return pulls;
}

double published_work(const MeasuredFabric& fabric, double e11, double e22) {
  constexpr int parts = 400;
  double sum = 0;
  for (int i = 0; i <= parts; ++i) {
    const double t = static_cast<double>(i) / parts;
    const auto s = published_tension(fabric, t * e11, t * e22, 0);
    sum += (i == 0 || i == parts ? 1 : i % 2 == 1 ? 4 : 2) * (s[0] * e11 + s[1] * e22);
  }
  return sum / (3 * parts);
}

FabricPull free_pull(const Case& sheet, const MeasuredFabric& fabric, bool along_warp,
                     double stretch) {
  Case pulled = sheet;
  sim::BodyCase& body = pulled.body.at(0);
  const double length = body.shape.size.at(0), width = body.shape.size.at(1);
  body.warp_angle_deg = along_warp ? 0 : 90;
  for (sim::PinCase& pin : body.pin) {
    if (pin.motion) pin.motion->keyframes.back().translation = {length * (stretch - 1), 0, 0};
  }
  sim::Simulation simulation = sim::make_simulation(pulled);
  if (const auto failure = simulation.advance(pulled.time.duration))
    throw std::runtime_error(failure->text);
  const double force = membrane_pulls(simulation.scene(), simulation.position(body.name))[0];

  const auto work = [&](double along, double across) {
    const double pull = green_strain(along), side = green_strain(across);
    return along_warp ? published_work(fabric, pull, side) : published_work(fabric, side, pull);
  };
  const double least = place_of_least(1 - 4 * (stretch - 1), 1 + 4 * (stretch - 1),
                                      [&](double across) { return work(stretch, across); });
  constexpr double step = 1e-4;
  const double slope = (work(stretch + step, least) - work(stretch - step, least)) / (2 * step);
  return {std::string(along_warp ? "warp, " : "weft, ") + sim::number_text(stretch), force,
          slope * width};
}

LatticeModuli lattice_moduli(const Case& lattice, int n) {
  Case sized = lattice;
  sized.body.at(0).shape.resolution = {n + 1, n + 1};
  const auto scene = sim::build_scene(sized);
  const sim::SpringNetwork network = springs_of(*scene);
  const auto energy = [&](double e11, double e22, double shear) {
    const auto moved = [&](int i) -> Vec3 {
      const Vec3& x = scene->initial_position[i];
      return {(1 + e11) * x.x() + shear * x.y(), (1 + e22) * x.y(), 0};
    };
    double sum = 0;
    for (std::size_t s = 0; s < network.springs.size(); ++s)
      sum += materials::spring_energy(network.springs[s], moved(network.ends[s][0]),
                                      moved(network.ends[s][1]));
    return sum;
  };
  constexpr double e = 1e-5;
  const double c11 = 2 * energy(e, 0, 0) / (e * e), c22 = 2 * energy(0, e, 0) / (e * e);
  return {c11, energy(e, e, 0) / (e * e) - 0.5 * (c11 + c22), 2 * energy(0, 0, e) / (e * e)};
}

LatticeModuli refined_moduli(const Case& lattice, int n) {
  const LatticeModuli fine = lattice_moduli(lattice, n), coarse = lattice_moduli(lattice, n / 2);
  return {2 * fine.c11 - coarse.c11, 2 * fine.c12 - coarse.c12, 2 * fine.c66 - coarse.c66};
}

}  // namespace weft::bench
