#include "sim/view/scene_description.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdio>
#include <sstream>
#include <vector>

#include "sim/case/case_checks.h"
#include "sim/case/case_text.h"
#include "sim/case/memory_estimate.h"
#include "sim/case/time_methods.h"
#include "sim/contact/compute_choice.h"
#include "sim/contact/contact.h"
#include "sim/contact/contact_search.h"
#include "sim/contact/pair_friction.h"
#include "sim/forces/force.h"
#include "sim/particles/enclosing_obstacles.h"
#include "sim/scene/recorded_bodies.h"
#include "sim/scene/scene_curves.h"
#include "sim/view/output_description.h"

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

// Largest number of bodies that are described one by one. If there are more bodies, describe_each()
// prints one line for all of them, and describe_bodies() one line for the bodies after the first
// most_lines.
constexpr std::size_t most_lines = 8;

// Prints a line "  BEFORE NAME: ONE" per body, with the texts `before` and `one`. If there are more
// than most_lines bodies, prints a single line with the text `many` instead of `one`.
void describe_each(const std::vector<const SceneBody*>& bodies, const std::string& before,
                   const std::string& one, const std::string& many, std::ostream& out) {
  if (bodies.size() > most_lines) {
    out << "  " << before << ' ' << bodies.size() << " surfaces, " << bodies.front()->name << " to "
        << bodies.back()->name << ": " << many << '\n';
    return;
  }
  for (const SceneBody* body : bodies)
    out << "  " << before << ' ' << body->name << ": " << one << '\n';
}

// Returns the bodies for which `condition` is true, in the order of the case.
template <class Condition>
std::vector<const SceneBody*> bodies_that(const Scene& scene, const Condition& condition) {
  std::vector<const SceneBody*> bodies;
  for (const int b : scene.case_order) {
    if (condition(scene.bodies[b])) bodies.push_back(&scene.bodies[b]);
  }
  return bodies;
}

// Prints which dynamic bodies lack `what`. lacks(material) tells whether a body does. The printed
// reason is `every` if all dynamic bodies lack it. Otherwise it is `its` in the line of one body,
// or `their` in a line about more bodies.
template <class Condition>
void describe_lack(const Scene& scene, const Condition& lacks, const std::string& what,
                   const std::string& every, const std::string& its, const std::string& their,
                   std::ostream& out) {
  const auto is_surface = [](const SceneBody& body) {
    return body.dynamic && body.spheres == nullptr;
  };
  const auto bodies = bodies_that(
      scene, [&](const SceneBody& body) { return is_surface(body) && lacks(*body.material); });
  if (bodies.empty()) return;
  if (bodies.size() == bodies_that(scene, is_surface).size()) {
    out << "  skipped " << what << ": " << every << '\n';
  } else {
    describe_each(bodies, "skipped " + what + " of", its, their, out);
  }
}

bool is_of(const TimedPin& pin, const SceneBody& body, const Scene& scene) {
  return &scene.bodies[pin.body] == &body;
}

void describe_timed_pin(const TimedPin& pin, std::ostream& out) {
  out << "            pin of " << counted(pin.particles.size(), "vertex", "vertices");
  if (pin.source->hold_time > 0) out << " from " << pin.source->hold_time << " s";
  if (pin.source->release_time) out << " until " << *pin.source->release_time << " s";
  out << '\n';
}

void describe_spheres(const SceneBody& body, const Scene& scene, std::ostream& out) {
  const ParticlesCase& from = *body.spheres;
  out << "particles " << body.name << ": " << body.particle_count() << " of radius " << from.radius
      << " m and mass " << scene.mass[body.first_particle] << " kg, restitution "
      << from.restitution;
  if (from.friction) out << ", friction " << *from.friction;
  out << '\n';
}

void describe_body(const Scene& scene, const SceneBody& body, std::ostream& out) {
  if (body.spheres != nullptr) return describe_spheres(body, scene, out);
  out << (body.is_obstacle ? "obstacle  " : "body      ") << body.name << ": "
      << size_of(body.atlas) << ", " << body.mesh.triangles.size() << " triangles, thickness "
      << 1e3 * body.thickness << " mm\n";
  if (body.is_obstacle) return;
  out << "            material " << body.material->name;
  if (!body.dynamic) {
    out << ", all " << body.particle_count() << " vertices pinned\n";
    return;
  }
  double mass = 0;
  int pinned = 0;
  for (int i = 0; i < body.particle_count(); ++i) {
    mass += scene.mass[body.first_particle + i];
    pinned += scene.pinned[body.first_particle + i];
  }
  out << ", mass " << mass << " kg";
  if (std::ranges::none_of(scene.timed_pins,
                           [&](const TimedPin& pin) { return is_of(pin, body, scene); }))
    out << ", " << counted(pinned, "pinned vertex", "pinned vertices");
  out << '\n';
  std::size_t clamped = 0;
  for (const PrescribedMotion& held : scene.prescribed) {
    if (!held.clamped.empty() && &scene.body_of_particle(held.particles.front()) == &body)
      clamped += held.clamped.size();
  }
  if (clamped > 0) out << "            " << counted(clamped, "edge", "edges") << " clamped\n";
  for (const TimedPin& pin : scene.timed_pins) {
    if (is_of(pin, body, scene)) describe_timed_pin(pin, out);
  }
}

// Prints the energies of internal forces in the initial state, if the case gives a body a start
// shape or a stretch.
void describe_start(const Scene& scene, std::ostream& out) {
  const bool is_strained = std::ranges::any_of(
      scene.source.body, [](const BodyCase& body) { return body.start || !body.stretch.isOnes(); });
  if (!is_strained) return;
  const auto count = static_cast<std::size_t>(scene.dynamic_particles);
  const std::vector<Vec3> at_rest(count, Vec3::Zero());
  const Kinematics start{std::span(scene.initial_position).first(count), at_rest};
  out << "start     strained:";
  const char* separator = " ";
  for (const auto& force : make_forces(scene)) {
    if (force->is_external()) continue;
    out << separator << force->name() << ' ' << force->energy(start, 1) << " J";
    separator = ", ";
  }
  out << '\n';
}

void describe_ties(const Scene& scene, std::ostream& out) {
  for (const Tie& tie : scene.ties) {
    const auto longest = std::ranges::max_element(tie.springs, {}, &TieSpring::length);
    out << "tie       " << counted(tie.springs.size(), "vertex", "vertices") << " of "
        << tie.source->body << " to " << tie.source->to << ", " << tie.source->stiffness
        << " N/m, the longest spring " << 1e3 * longest->length << " mm";
    if (tie.source->break_force) out << ", breaks at " << *tie.source->break_force << " N";
    out << '\n';
  }
}

void describe_seams(const Scene& scene, std::ostream& out) {
  for (const Seam& seam : scene.seams) {
    const SeamCase& source = *seam.source;
    out << "seam      " << source.body << " to " << source.to << ": "
        << counted(seam.stitches.size(), "stitch", "stitches") << ", " << seam.stiffness
        << " N/m^2";
    if (source.closing_time > 0)
      out << ", closes by " << 1e3 * seam.largest_gap << " mm in " << source.closing_time << " s";
    out << '\n';
    if (seam.folds.empty() && source.bending == SeamBending::continuous)
      out << "  skipped bending across the seam: a side has no bending_stiffness\n";
  }
}

void describe_bodies(const Scene& scene, std::ostream& out) {
  for (const bool obstacles : {false, true}) {
    const auto bodies =
        bodies_that(scene, [&](const SceneBody& body) { return body.is_obstacle == obstacles; });
    const std::size_t shown = std::min(bodies.size(), most_lines);
    for (std::size_t i = 0; i < shown; ++i) describe_body(scene, *bodies[i], out);
    if (shown == bodies.size()) continue;
    std::size_t triangles = 0;
    for (std::size_t i = shown; i < bodies.size(); ++i)
      triangles += bodies[i]->mesh.triangles.size();
    out << (obstacles ? "obstacles " : "bodies    ") << bodies.size() - shown << " more, "
        << bodies[shown]->name;
    if (bodies.size() > shown + 1) out << " to " << bodies.back()->name;
    out << ": " << triangles << " triangles\n";
  }
}

void describe_forces(const Scene& scene, std::ostream& out) {
  if (scene.source.time.method == TimeMethod::impulses) {
    const bool has_drag = std::ranges::any_of(
        scene.source.particles, [](const ParticlesCase& of) { return of.drag_coefficient > 0; });
    out << "forces    gravity" << (has_drag ? ", drag" : "") << '\n';
    if (!has_drag) out << "  skipped drag and wind: every drag_coefficient is 0\n";
    return;
  }
  out << "forces    gravity";
  for (const auto& force : make_forces(scene)) out << ", " << force->name();
  out << '\n';
  describe_each(
      bodies_that(scene, [](const SceneBody& body) { return !body.dynamic && !body.is_obstacle; }),
      "skipped forces, matrix and state of", "all of it is pinned", "all of them is pinned", out);
  describe_lack(
      scene, [](const MaterialCase& m) { return !m.resists_bending(); }, "bending",
      "every bending_stiffness is 0", "its bending_stiffness is 0", "their bending_stiffness is 0",
      out);
  describe_lack(
      scene,
      [](const MaterialCase& m) { return m.normal_drag.is_zero() && m.tangential_drag.is_zero(); },
      "drag and wind", "every drag coefficient is 0", "its drag coefficients are 0",
      "their drag coefficients are 0", out);
  describe_lack(
      scene,
      [](const MaterialCase& m) {
        return m.mass_damping.is_zero() && m.membrane_damping_time().is_zero() &&
               m.bending_damping_time().is_zero();
      },
      "material damping", "every damping is 0", "its damping is 0", "their damping is 0", out);
}

// Prints which self-traversals the contact search skips, which pyramids it builds only once, and
// which pyramids it skips at the start, with reasons.
void describe_search(const Scene& scene, const std::vector<CandidateList>& neighbours,
                     std::ostream& out) {
  std::vector<char> has_neighbour(scene.bodies.size(), 0);
  for (const CandidateList& list : neighbours)
    has_neighbour[list.body_a] = has_neighbour[list.body_b] = 1;
  const auto is_near = [&](const SceneBody& body) {
    return has_neighbour[&body - scene.bodies.data()] != 0;
  };
  describe_each(
      bodies_that(scene, [](const SceneBody& body) { return body.dynamic && !body.self_contact; }),
      "skipped self-traversal of", "self_contact is false", "self_contact is false", out);
  describe_each(
      bodies_that(scene, [&](const SceneBody& body) { return !body.moves && is_near(body); }),
      "pyramid built once of", "it does not move", "they do not move", out);
  describe_each(bodies_that(scene, [&](const SceneBody& body) { return !is_near(body); }),
                "skipped pyramid of", "at the start, nothing that it may touch is near",
                "at the start, nothing that they may touch is near", out);
}

// Prints the friction and the restitution of each [[contact.pair]], and which friction is skipped.
void describe_friction(const Scene& scene, std::ostream& out) {
  const ContactCase& contact = scene.source.contact;
  const std::vector<int> uses = PairFriction(scene).uses();
  for (std::size_t i = 0; i < contact.pair.size(); ++i) {
    const ContactPairCase& pair = contact.pair[i];
    const std::string names = in_quotes(pair.between[0]) + " and " + in_quotes(pair.between[1]);
    if (uses[i] == 0) {
      out << "  skipped friction of " << names << ": no bodies that may touch have this pair\n";
    } else if (!pair.friction) {
      out << "  friction of " << names << " is that of the particles\n";
    } else if (*pair.friction == 0) {
      out << "  skipped friction of " << names << ": it is 0\n";
    } else {
      out << "  friction " << *pair.friction << " of " << names << ", "
          << counted(uses[i], "pair of bodies", "pairs of bodies") << '\n';
    }
    if (uses[i] > 0 && pair.restitution) {
      out << "  restitution " << *pair.restitution << " of " << names << ", "
          << counted(uses[i], "pair of bodies", "pairs of bodies") << '\n';
    }
  }
  const bool particles_have_own = std::ranges::any_of(
      scene.source.particles, [](const ParticlesCase& group) { return group.friction > 0.0; });
  if (!contact.friction.is_zero() || particles_have_own) return;
  out << (contact.pair.empty() ? "  skipped friction" : "  skipped friction of other pairs")
      << ": contact.friction is 0\n";
}

void describe_enclosed_spheres(const Scene& scene, std::ostream& out) {
  for (const EnclosedSpheres& each : enclosed_spheres(scene)) {
    const SceneBody& group = scene.bodies[each.group];
    out << "  " << each.count << " of " << counted(group.particle_count(), "particle", "particles")
        << " of " << group.name << " start inside " << scene.bodies[each.obstacle].name
        << ", whose surface is closed: they stay there\n";
  }
}

// Returns the kinetic energy of the start, plus the energy of a fall from there by the diagonal of
// the box around the dynamic bodies (J).
double energy_of_motion(const Scene& scene) {
  Eigen::AlignedBox3d box;
  double mass = 0, kinetic = 0;
  for (int i = 0; i < scene.dynamic_particles; ++i) {
    box.extend(scene.initial_position[i]);
    mass += scene.mass[i];
    if (scene.is_free(i)) kinetic += 0.5 * scene.mass[i] * scene.initial_velocity(i).squaredNorm();
  }
  const double gravity = scene.source.world.gravity.constant_or_zero().norm();
  return kinetic + mass * gravity * box.diagonal().norm();
}

// Prints the smallest gap and the energy of contact at the start, if surfaces are in reach. Tells
// what to do if this energy exceeds energy_of_motion().
void describe_start_of_contact(const Scene& scene, std::ostream& out) {
  Statistics unused;
  Contact contact(scene, unused);
  const std::vector<Vec3> at_rest(scene.initial_position.size(), Vec3::Zero());
  if (contact.evaluate(scene.initial_position, at_rest, scene.threads)) return;
  const auto gap = contact.smallest_gap();
  if (!gap) return;
  out << "  at the start the smallest gap is " << 1e3 * *gap << " mm, and contact has "
      << contact.energy() << " J";
  if (!traits_of(scene.source.time.method).finds_equilibria() &&
      contact.energy() > energy_of_motion(scene))
    out << ",\n  which throws the bodies apart: move them apart, or make contact.range smaller";
  out << '\n';
}

void describe_contact(const Scene& scene, std::ostream& out) {
  const ContactCase& contact = scene.source.contact;
  if (scene.spheres_collide) {
    out << "contact   impulses of particles with each other and with "
        << counted(scene.bodies.size() - scene.dynamic_bodies, "obstacle", "obstacles")
        << "\n  skipped range, stiffness, damping_time, friction_speed and sticking_distance of "
           "[contact], and tolerances: impulses have no barrier, and no error is controlled\n";
    describe_enclosed_spheres(scene, out);
    describe_friction(scene, out);
    return;
  }
  if (!contact.enabled) {
    out << "contact   skipped, with pyramids, candidate search and collision checks: "
           "contact.enabled is false\n";
    return;
  }
  const std::vector<CandidateList> neighbours = neighbours_at_start(scene);
  const auto self = std::ranges::count_if(neighbours, &CandidateList::is_self);
  const std::size_t obstacles = scene.bodies.size() - scene.dynamic_bodies;
  const std::size_t dynamic = scene.case_order.size() - obstacles;
  const std::size_t pairs = dynamic * (dynamic - 1) / 2 + dynamic * obstacles;
  out << "contact   range " << 1e3 * contact.range << " mm; "
      << counted(dynamic * (dynamic - 1) / 2, "pair of bodies, ", "pairs of bodies, ")
      << dynamic * obstacles << " of body and obstacle, "
      << counted(self, "body with itself\n", "bodies with themselves\n");
  describe_enclosed_spheres(scene, out);
  const std::size_t far = pairs - (neighbours.size() - self);
  if (far > 0)
    out << "  skipped " << counted(far, "pair", "pairs") << " of " << pairs
        << ": too far apart at the start; a body that moves looks for new neighbours\n";
  describe_search(scene, neighbours, out);
  if (obstacles > 1) out << "  skipped pairs of obstacles: nothing is simulated between them\n";
  describe_start_of_contact(scene, out);
  if (traits_of(scene.source.time.method).finds_equilibria()) {
    out << "  skipped friction and contact damping: in an equilibrium nothing moves\n";
  } else {
    describe_friction(scene, out);
  }
}

// Returns the times of a curve as text, such as "0, 1.5 and 2 s". For more than six times, the text
// has only their number, the first time and the last time.
std::string times_text(const std::vector<double>& times) {
  constexpr std::size_t most = 6;
  std::string text = number_text(times.front());
  if (times.size() > most)
    return std::to_string(times.size()) + " times, " + text + " to " + number_text(times.back()) +
           " s";
  for (std::size_t i = 1; i < times.size(); ++i)
    text += (i + 1 < times.size() ? ", " : " and ") + number_text(times[i]);
  return text + " s";
}

std::string value_text(double value) { return number_text(value); }
std::string value_text(const Vec3& value) {
  return '[' + number_text(value[0]) + ", " + number_text(value[1]) + ", " + number_text(value[2]) +
         ']';
}

// Returns a one-line description of a curve or a gust.
template <class Value>
std::string course_text(const Varying<Value>& source) {
  if (const GustCase* gust = source.gust()) {
    return "gusts about " + value_text(gust->mean) + " m/s, intensity " +
           number_text(gust->intensity) + ", time scale " + number_text(gust->time_scale) +
           " s, seed " + std::to_string(gust->seed);
  }
  const auto& [times, values, between] = *source.curve();
  const char* course = between == Between::linear   ? "straight"
                       : between == Between::smooth ? "eased"
                                                    : "in steps";
  return "from " + value_text(values.front()) + " to " + value_text(values.back()) + ", " + course +
         " between " + times_text(times);
}

void describe_curves(const Scene& scene, std::ostream& out) {
  for (const SceneCurve& curve : find_curves(scene.source)) {
    const std::string course =
        std::visit([](const auto* source) { return course_text(*source); }, curve.source);
    out << (curve.unused.empty() ? "varies    " : "  skipped ") << curve.key << ": " << course;
    if (!curve.unused.empty()) out << "; " << curve.unused;
    out << '\n';
  }
}

void describe_time(const Case& source, std::ostream& out) {
  const TimeCase& time = source.time;
  out << "time      " << time.duration << " s, ";
  if (source.output.frame_times.empty()) out << time.frames_per_second << " frames/s; ";
  out << traits_of(time.method).title;
  if (time.method == TimeMethod::cvode) out << " of order 1 to " << time.maximum_order;
  if (time.step) out << ", steps of " << *time.step << " s";
  if (time.method != TimeMethod::impulses)
    out << ", position tolerance " << time.position_tolerance << " m a step";
  out << '\n';
  for (const std::string& notice :
       {long_step_notice(time), late_pins_notice(source), idle_device_notice(source)}) {
    if (!notice.empty()) out << "  " << notice << '\n';
  }
}

void describe_sleep(const Scene& scene, std::ostream& out) {
  if (scene.dynamic_bodies < 2 || !scene.source.particles.empty()) return;
  out << "sleep     ";
  if (!scene.source.time.sleep) {
    out << "off: time.sleep is false\n";
  } else if (traits_of(scene.source.time.method).finds_equilibria()) {
    out << "none: equilibria are found for all bodies together\n";
  } else {
    out << "bodies that come to rest are skipped until something touches them\n";
  }
}

ComputeBackend describe_compute(const Scene& scene, std::ostream& out) {
  const ComputeChoice choice = choose_search(scene).choice;
  out << "search    " << choice.text() << '\n';
  return choice.backend;
}

void describe_memory(const Scene& scene, std::ostream& out) {
  SceneSize size;
  for (const int b : scene.case_order) {
    const SceneBody& body = scene.bodies[b];
    auto& sizes = body.spheres != nullptr ? size.particles
                  : body.is_obstacle      ? size.obstacle
                                          : size.body;
    sizes.push_back(body.particle_count());
  }
  out << "memory    about " << memory_text(estimate_memory(scene.source, size)) << " of at most "
      << memory_text(memory_limit(scene.source)) << '\n';
}

// Returns the bodies that the case records and that do not move.
std::vector<const SceneBody*> recorded_at_rest(const Scene& scene) {
  std::vector<const SceneBody*> bodies;
  for (const RecordedBody& recorded : recorded_bodies(scene)) {
    const SceneBody& body = scene.bodies[recorded.body];
    if (!body.moves) bodies.push_back(&body);
  }
  return bodies;
}

}  // namespace

std::string describe_scene(const Scene& scene) {
  std::ostringstream out;
  out << printable(scene.source.title.empty() ? scene.source.path : scene.source.title) << '\n';
  describe_bodies(scene, out);
  describe_ties(scene, out);
  describe_seams(scene, out);
  describe_start(scene, out);
  describe_forces(scene, out);
  describe_contact(scene, out);
  const auto backend =
      scene.source.contact.enabled ? describe_compute(scene, out) : ComputeBackend::cpu;
  describe_curves(scene, out);
  describe_time(scene.source, out);
  describe_sleep(scene, out);
  if (!scene.source.accuracy_choice.empty()) {
    out << "accuracy  " << scene.source.accuracy_choice << "; a run corrects it by a pilot\n";
  }
  if (backend == ComputeBackend::cpu) {
    out << "  skipped GL context: nothing is searched on a device, and pictures need none\n";
  }
  out << "threads   " << scene.threads
      << (scene.source.compute.threads ? ": compute.threads asks for as many\n"
                                       : ": as many as pay\n");
  describe_memory(scene, out);
  describe_output(scene, out);
  describe_each(recorded_at_rest(scene), "skipped frames of",
                "it does not move and is written once", "they do not move and are written once",
                out);
  return out.str();
}

}  // namespace weft::sim
