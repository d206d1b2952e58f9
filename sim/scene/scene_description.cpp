// The text of `weft check`: what a scene needs, what it skips, and why.
#include <cstdio>
#include <sstream>

#include "sim/case/case_checks.h"
#include "sim/case/case_text.h"
#include "sim/case/memory_estimate.h"
#include "sim/contact/compute_choice.h"
#include "sim/forces/force.h"
#include "sim/scene/scene.h"

namespace weft::sim {

namespace {

std::string size_of(const bsi::Atlas& atlas) {
  const bsi::Patch& patch = atlas.patches().front();
  std::string text = std::to_string(patch.rows) + " x " + std::to_string(patch.cols) + " vertices";
  if (atlas.patches().size() > 1)
    text = std::to_string(atlas.patches().size()) + " patches of " + text;
  if (patch.wrap_u) text += ", columns closed";
  if (patch.wrap_v) text += ", rows closed";
  return text;
}

void describe_bodies(const Scene& scene, std::ostream& out) {
  for (const SceneBody& body : scene.bodies) {
    out << (body.dynamic ? "body      " : "obstacle  ") << body.name << ": " << size_of(body.atlas)
        << ", " << body.mesh.triangles.size() << " triangles, thickness " << 1e3 * body.thickness
        << " mm\n";
    if (!body.dynamic) continue;
    double mass = 0;
    int pinned = 0;
    for (int i = 0; i < body.particle_count(); ++i) {
      mass += scene.mass[body.first_particle + i];
      pinned += scene.pinned[body.first_particle + i];
    }
    out << "            material " << body.material->name << ", mass " << mass << " kg, " << pinned
        << " pinned vertices\n";
  }
}

void describe_forces(const Scene& scene, std::ostream& out) {
  out << "forces    gravity";
  for (const auto& force : make_forces(scene)) out << ", " << force->name();
  out << '\n';
  bool bending = false, drag = false, damping = false;
  for (const BodyCase& body : scene.source.body) {
    for (const MaterialCase& material : scene.source.material) {
      if (material.name != body.material) continue;
      bending |= material.bending_stiffness > 0;
      drag |= material.normal_drag > 0 || material.tangential_drag > 0;
      damping |= material.mass_damping > 0 || material.stiffness_damping > 0 ||
                 material.bending_damping > 0;
    }
  }
  if (!bending) out << "  skipped bending: every bending_stiffness is 0\n";
  if (!drag) out << "  skipped drag and wind: every drag coefficient is 0\n";
  if (!damping) out << "  skipped material damping: every damping is 0\n";
}

void describe_contact(const Scene& scene, std::ostream& out) {
  const ContactCase& contact = scene.source.contact;
  if (!contact.enabled) {
    out << "contact   skipped, with pyramids, candidate search and collision checks: "
           "contact.enabled is false\n";
    return;
  }
  int self = 0;
  for (const SceneBody& body : scene.bodies) self += body.self_contact ? 1 : 0;
  const int dynamic = scene.dynamic_bodies;
  const int obstacles = static_cast<int>(scene.bodies.size()) - dynamic;
  const int pairs = dynamic * (dynamic - 1) / 2;
  out << "contact   range " << 1e3 * contact.range << " mm; " << pairs
      << (pairs == 1 ? " pair of bodies, " : " pairs of bodies, ") << dynamic * obstacles
      << " of body and obstacle, " << self
      << (self == 1 ? " body with itself\n" : " bodies with themselves\n");
  for (const SceneBody& body : scene.bodies) {
    if (body.dynamic && !body.self_contact)
      out << "  skipped self-traversal of " << body.name << ": self_contact is false\n";
    if (!body.dynamic && !body.moves)
      out << "  pyramid of " << body.name << " built once at the most: it does not move\n";
  }
  if (obstacles > 1) out << "  skipped pairs of obstacles: nothing is simulated between them\n";
  if (scene.source.time.method == TimeMethod::static_loads) {
    out << "  skipped friction and contact damping: in an equilibrium nothing moves\n";
  } else if (contact.friction == 0) {
    out << "  skipped friction: contact.friction is 0\n";
  }
  out << "  skipped pyramids of bodies whose bounding spheres stay out of each other's reach\n";
}

void describe_time(const TimeCase& time, std::ostream& out) {
  out << "time      " << time.duration << " s, " << time.frames_per_second << " frames/s; ";
  switch (time.method) {
    case TimeMethod::cvode:
      out << "CVODE, BDF of order 1 to " << time.maximum_order;
      break;
    case TimeMethod::arkode:
      out << "ARKODE, Runge-Kutta";
      break;
    case TimeMethod::euler:
      out << "backward Euler";
      break;
    case TimeMethod::static_loads:
      out << "equilibria under growing loads";
      break;
    case TimeMethod::implicit_midpoint:
      out << "implicit midpoint";
      break;
    case TimeMethod::verlet:
      out << "Verlet";
  }
  if (time.step) out << ", steps of " << *time.step << " s";
  out << ", position tolerance " << time.position_tolerance << " m a step\n";
  const std::string long_step = long_step_notice(time);
  if (!long_step.empty()) out << "  " << long_step << '\n';
}

ComputeBackend describe_compute(const Scene& scene, std::ostream& out) {
  const ComputeChoice choice = choose_search(scene).choice;
  out << "search    " << choice.text() << '\n';
  return choice.backend;
}

void describe_memory(const Scene& scene, std::ostream& out) {
  SceneSize size;
  for (const SceneBody& body : scene.bodies) {
    (body.dynamic ? size.body : size.obstacle).push_back(body.particle_count());
  }
  out << "memory    about " << memory_text(estimate_memory(scene.source, size)) << " of at most "
      << memory_text(memory_limit(scene.source)) << '\n';
}

}  // namespace

std::string describe_scene(const Scene& scene) {
  std::ostringstream out;
  const TimeCase& time = scene.source.time;
  out << printable(scene.source.title.empty() ? scene.source.path : scene.source.title) << '\n';
  describe_bodies(scene, out);
  describe_forces(scene, out);
  describe_contact(scene, out);
  const auto backend =
      scene.source.contact.enabled ? describe_compute(scene, out) : ComputeBackend::cpu;
  describe_time(time, out);
  if (!scene.source.accuracy_choice.empty()) {
    out << "accuracy  " << scene.source.accuracy_choice << "; a run corrects it by a pilot\n";
  }
  if (backend == ComputeBackend::cpu) {
    out << "  skipped GL context: pictures are made by `weft render`\n";
  }
  describe_memory(scene, out);
  if (!scene.source.output.velocity)
    out << "  skipped velocities in the trajectory: output.velocity is false\n";
  return out.str();
}

}  // namespace weft::sim
