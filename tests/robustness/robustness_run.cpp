#include "tests/robustness/robustness_run.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <vector>

#include "sim/base/process_time.h"
#include "sim/case/case_error.h"
#include "sim/motion/dynamics.h"
#include "sim/run/make_simulation.h"
#include "sim/scene/scene.h"
#include "sim/view/crossings.h"

namespace weft::robustness {

namespace {

using sim::Vec3;

// True if neither motion, loads, wind nor varying gravity can do work on the bodies.
bool is_unfed(const sim::Scene& scene) {
  const bool moves =
      std::ranges::any_of(scene.prescribed, [](const auto& held) { return held.moves; });
  return !moves && scene.timed_pins.empty() && scene.source.load.empty() &&
         scene.source.seam.empty() && scene.source.tie.empty() &&
         scene.source.world.wind.is_zero() && !scene.source.world.gravity.varies();
}

// Judges a simulation after each of its steps.
class Judge {
 public:
  Judge(const sim::Case& source, double end) : sim_(sim::make_simulation(source)), end_(end) {}

  Judgement run() {
    const double cpu_start = sim::process_cpu_time();
    start_watching(sim_.dynamics().energies(0, sim_.state()));
    look_at_state();
    while (result_.fault.empty() && sim_.time() < end_ && !sim_.has_ended()) {
      if (const auto failure = sim_.step()) {
        fault("failed: " + failure->text);
        break;
      }
      look_at_state();
      look_at_energy(sim_.energies());
      if (sim::process_cpu_time() - cpu_start > run_limit) fault("stalled");
    }
    const sim::IntegratorCounts counts = sim_.counts();
    result_.time = sim_.time();
    result_.steps = static_cast<long>(counts.steps);
    result_.vetoed = static_cast<long>(counts.vetoed_steps);
    result_.cpu_time = sim::process_cpu_time() - cpu_start;
    return result_;
  }

 private:
  void fault(const std::string& text) {
    if (result_.fault.empty()) result_.fault = text + " at t = " + std::to_string(sim_.time());
  }

  void look_at_state() {
    const auto is_finite = [](double x) { return std::isfinite(x); };
    if (!std::ranges::all_of(sim_.state(), is_finite)) return fault("not finite");
    if (!sim_.scene().source.contact.enabled) return;
    std::vector<Vec3> position, velocity, room;
    sim_.dynamics().expand_all(sim_.time(), sim_.state(), position, velocity);
    const auto crossings = crossings_of(sim_.scene(), position, room);
    if (crossings > 0) fault(std::to_string(crossings) + " pairs of triangles cross");
  }

  // Returns the number of crossing pairs of triangles between surfaces that contact keeps apart.
  static std::ptrdiff_t crossings_of(const sim::Scene& scene, const std::vector<Vec3>& position,
                                     std::vector<Vec3>& room) {
    const std::span<const Vec3> points =
        scene.surface_map.points_of(position, scene.point_count, room);
    std::vector<sim::CrossingSurface> surfaces;
    for (const sim::SceneBody& body : scene.bodies) {
      surfaces.push_back({points.subspan(body.first_point, body.point_count()),
                          body.surface_mesh().triangles, body.self_contact});
    }
    return std::ranges::count_if(sim::find_crossings(surfaces), [&](const sim::Crossing& c) {
      return scene.bodies[c.surface_a].dynamic || scene.bodies[c.surface_b].dynamic;
    });
  }

  static double in_motion(const sim::Energies& energies) {
    double sum = energies.kinetic + energies.contact;
    for (const auto& [name, energy] : energies.elastic) sum += energy;
    return sum;
  }

  void start_watching(const sim::Energies& energies) {
    watches_ = is_unfed(sim_.scene());
    least_ = energies.total();
    most_in_motion_ = in_motion(energies);
  }

  void look_at_energy(const sim::Energies& energies) {
    if (!watches_) return;
    most_in_motion_ = std::max(most_in_motion_, in_motion(energies));
    const double gained = energies.total() - least_;
    if (most_in_motion_ > 0)
      result_.gained_share = std::max(result_.gained_share, gained / most_in_motion_);
    if (gained > energy_slack * most_in_motion_) fault("gained " + std::to_string(gained) + " J");
    least_ = std::min(least_, energies.total());
  }

  sim::Simulation sim_;
  double end_;
  bool watches_ = false;
  double least_ = 0, most_in_motion_ = 0;  // J
  Judgement result_;
};

}  // namespace

Judgement judge(const sim::Case& source, double end) {
  try {
    return Judge(source, end).run();
  } catch (const std::exception& error) {
    Judgement refused;
    refused.fault = std::string("not simulated: ") + error.what();
    return refused;
  }
}

std::string to_text(const Judgement& judgement) {
  std::ostringstream out;
  out.precision(17);
  out << judgement.time << ' ' << judgement.steps << ' ' << judgement.vetoed << ' '
      << judgement.cpu_time << ' ' << judgement.gained_share << '\n'
      << judgement.fault;
  return out.str();
}

Judgement from_text(const std::string& text) {
  Judgement judgement;
  std::istringstream in(text);
  in >> judgement.time >> judgement.steps >> judgement.vetoed >> judgement.cpu_time >>
      judgement.gained_share;
  in.get();
  std::getline(in, judgement.fault, '\0');
  return judgement;
}

}  // namespace weft::robustness
