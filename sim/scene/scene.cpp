#include "sim/scene/scene.h"

#include <omp.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <stdexcept>

#include "sim/case/case_error.h"
#include "sim/case/memory_estimate.h"
#include "sim/scene/held_bodies.h"
#include "sim/scene/impact_speed.h"
#include "sim/scene/load_points.h"
#include "sim/scene/pins.h"
#include "sim/scene/recorded_bodies.h"
#include "sim/scene/shape_builder.h"
#include "sim/scene/shell_body.h"
#include "sim/scene/sliding_supports.h"
#include "sim/scene/sphere_groups.h"
#include "sim/scene/start_shape.h"
#include "sim/scene/start_states.h"
#include "sim/scene/surface_points.h"
#include "sim/scene/timed_pins.h"

namespace weft::sim {

namespace {

constexpr double default_thickness = 1e-3;  // m, thickness of cloth in contact

void refuse_flat_triangles(const SceneBody& body, const SourceLocation& where) {
  for (std::size_t t = 0; t < body.mesh.triangles.size(); ++t) {
    const auto& [a, b, c] = body.mesh.triangles[t];
    const Vec3 u = body.rest[b] - body.rest[a], v = body.rest[c] - body.rest[a];
    // A triangle with a smaller relative area is refused, because its stiffness would exceed that
    // of all other triangles by far.
    if (u.cross(v).norm() > 1e-10 * (u.squaredNorm() + v.squaredNorm())) continue;
    const bsi::TexelAddress at = body.atlas.quad_address(static_cast<int>(t / 2));
    throw CaseError(where,
                    "the rest shape of \"" + body.name +
                        "\" has a triangle without area at patch " + std::to_string(at.patch) +
                        ", row " + std::to_string(at.row) + ", column " + std::to_string(at.col),
                    "expected vertices that do not coincide or lie on one line");
  }
}

Vec3 mean_of(std::span<const Vec3> points) {
  Vec3 sum = Vec3::Zero();
  for (const Vec3& p : points) sum += p;
  return sum / static_cast<double>(std::max<std::size_t>(1, points.size()));
}

// Precondition: masses (kg) are positive.
Vec3 centre_of_mass(std::span<const Vec3> points, std::span<const double> masses) {
  Vec3 sum = Vec3::Zero();
  double mass = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    sum += masses[i] * points[i];
    mass += masses[i];
  }
  return sum / mass;
}

// Checks the memory that the case needs after a shape file has been read, because the count of its
// vertices is known only then. Bodies and obstacles built before count with their actual numbers of
// vertices.
void refuse_beyond_memory(const Scene& scene, const ShapeCase& shape, int vertices) {
  if (shape.type != ShapeType::file) return;
  SceneSize size = size_of_case(scene.source);
  const auto entry = [&](std::size_t index) -> double& {
    if (index < size.body.size()) return size.body[index];
    index -= size.body.size();
    return index < size.particles.size() ? size.particles[index]
                                         : size.obstacle[index - size.particles.size()];
  };
  std::size_t built = 0;
  for (const SceneBody& body : scene.bodies)
    if (!body.are_spins) entry(built++) = body.particle_count();
  entry(built) = vertices;
  const std::string reason = reason_of_memory(scene.source, size);
  if (!reason.empty()) throw CaseError(shape.location, reason, memory_hint);
}

SceneBody make_body(const std::string& name, const ShapeCase& shape, const Scene& scene) {
  const Case& source = scene.source;
  bsi::Surface surface = build_shape(shape, source);
  refuse_beyond_memory(scene, shape, surface.atlas.particle_count());
  SceneBody body;
  body.name = name;
  try {
    body.mesh = bsi::build_mesh(surface.atlas);
  } catch (const std::invalid_argument& error) {
    throw CaseError(shape.location, error.what());
  }
  // Without contact, only the triangles are kept, because edges and owners take several times as
  // much memory.
  if (!source.contact.enabled) {
    bsi::Mesh triangles;
    triangles.triangles.swap(body.mesh.triangles);
    body.mesh = std::move(triangles);
  }
  body.atlas = std::move(surface.atlas);
  body.rest = std::move(surface.positions);
  return body;
}

void append_positions(Scene& scene, const std::vector<Vec3>& shape, const Vec3& stretch,
                      const Vec3& position, const Vec3& rotation_deg) {
  const Eigen::Matrix3d placing = rotation_from_degrees(rotation_deg) * stretch.asDiagonal();
  for (const Vec3& p : shape) scene.initial_position.push_back(placing * p + position);
}

const MaterialCase* find_material(const Case& source, const std::string& name) {
  const auto found = std::find_if(source.material.begin(), source.material.end(),
                                  [&](const MaterialCase& m) { return m.name == name; });
  return found == source.material.end() ? nullptr : &*found;
}

std::vector<double> particle_masses(const SceneBody& body) {
  if (body.spline) return shell_masses(body);
  std::vector<double> mass = areas_around(body.mesh, body.rest);
  for (double& each : mass) each *= body.material->density;
  return mass;
}

// Appends the positions of a body in the state of another run, and sets its velocities.
void start_from_states(Scene& scene, const BodyCase& from, SceneBody& body) {
  const RestartCase& restart = *scene.source.restart;
  const BodyState* state = restart.states ? restart.states->find(from.name) : nullptr;
  if (state == nullptr) {
    throw CaseError(restart.location, "the state of \"" + from.name + "\" has not been read",
                    "expected a case after read_restart()");
  }
  const bool is_alike = std::ranges::equal(
      state->atlas.patches(), body.atlas.patches(), [](const auto& one, const auto& other) {
        return one.wrap_u == other.wrap_u && one.wrap_v == other.wrap_v;
      });
  if (!is_alike) {
    throw CaseError(restart.location,
                    "the image of \"" + from.name + "\" has other patches, or is closed otherwise",
                    "expected a shape of the same kind, of any resolution");
  }
  const auto taken = [&](const std::vector<Vec3>& values) {
    if (!body.spline) return resampled(values, state->atlas, body.atlas);
    return body.spline->interpolate(body.atlas,
                                    resampled(values, state->atlas, body.atlas, *body.spline));
  };
  const std::vector<Vec3> position = taken(state->position);
  body.start_velocity = taken(state->velocity);
  std::ranges::copy(position, std::back_inserter(scene.initial_position));
}

// Refuses a start whose last `count` points are so far away that squares of coordinates are no
// finite numbers.
void refuse_boundless_start(const Scene& scene, int count, const std::string& name,
                            const SourceLocation& location) {
  for (const Vec3& point : std::span<const Vec3>(scene.initial_position).last(count)) {
    if (std::isfinite(point.squaredNorm())) continue;
    throw CaseError(location, "the start of \"" + name + "\" is beyond the range of numbers",
                    "expected a place within 1e150 m of the origin");
  }
}

void add_dynamic_body(Scene& scene, const BodyCase& from) {
  SceneBody body = make_body(from.name, from.shape, scene);
  body.first_particle = scene.particle_count;
  body.self_contact = from.self_contact && scene.source.contact.enabled;
  body.material = find_material(scene.source, from.material);
  if (body.material == nullptr)
    throw CaseError(from.location, "unknown material \"" + from.material + "\"");
  body.thickness = from.thickness.value_or(
      body.material->is_shell() ? body.material->shell_thickness : default_thickness);
  body.warp_angle = from.warp_angle_deg * (std::acos(-1.0) / 180);
  refuse_flat_triangles(body, from.shape.location);
  if (body.material->is_shell()) make_spline(body, from);
  if (scene.source.restart) {
    start_from_states(scene, from, body);
  } else {
    const std::vector<Vec3> start = start_shape(from, body, scene.source);
    append_positions(scene, body.spline ? control_points_of(body, from, start) : start,
                     from.stretch, from.position, from.rotation_deg);
  }
  if (body.spline) {
    body.rest = control_points_of(body, from, body.rest);
    require_regular_rest(body, from);
    if (scene.source.contact.enabled) sample_shell(body);
  }
  const int count = body.particle_count();
  refuse_boundless_start(scene, count, from.name, from.location);
  body.velocity = from.velocity;
  body.spin = from.angular_velocity_deg * (std::acos(-1.0) / 180);
  const std::vector<double> masses = particle_masses(body);
  body.centre = centre_of_mass(std::span<const Vec3>(scene.initial_position).last(count), masses);
  std::ranges::copy(masses, std::back_inserter(scene.mass));
  scene.pinned.resize(scene.mass.size(), 0);
  scene.particle_count += count;
  scene.bodies.push_back(std::move(body));
}

void add_obstacle(Scene& scene, const ObstacleCase& from) {
  SceneBody body = make_body(from.name, from.shape, scene);
  body.first_particle = scene.particle_count;
  body.thickness = from.thickness;
  body.is_obstacle = true;
  body.dynamic = false;
  body.moves = from.motion.has_value();
  refuse_flat_triangles(body, from.shape.location);
  append_positions(scene, body.rest, Vec3::Ones(), from.position, from.rotation_deg);
  refuse_boundless_start(scene, body.particle_count(), from.name, from.location);
  const int count = body.particle_count();
  scene.particle_count += count;
  if (body.moves) {
    PrescribedMotion moved;
    for (int i = 0; i < count; ++i) moved.particles.push_back(body.first_particle + i);
    moved.start.assign(scene.initial_position.end() - count, scene.initial_position.end());
    moved.motion = RigidMotion(*from.motion, mean_of(moved.start));
    moved.radius = moved.motion.radius_of(moved.start);
    scene.prescribed.push_back(std::move(moved));
  }
  scene.bodies.push_back(std::move(body));
}

void add_pins(Scene& scene, const BodyCase& from, SceneBody& body,
              std::vector<PrescribedMotion>& pins) {
  const auto sliding = std::make_shared<SlidingSupports>();
  for (const PinCase& pin : from.pin) {
    const auto positions = std::span<const Vec3>(scene.initial_position)
                               .subspan(body.first_particle, body.particle_count());
    PrescribedMotion held;
    held.pin = static_cast<int>(&pin - from.pin.data());
    std::vector<int> named = select_pinned(pin, body, positions);
    if (pin.slides()) {
      add_sliding_supports(body, pin, held.pin, named, positions, *sliding);
      continue;
    }
    const std::vector<int> points = named;
    if (pin.clamp && body.spline) named = with_clamped_rows(body, pin, std::move(named));
    std::vector<int> held_points;  // local indices, those that the case names if there are any
    for (const int local : named) {
      const int particle = body.first_particle + local;
      // The first pin that selects a vertex holds it. Pins that slide do not count.
      if (scene.pinned[particle] != 0) continue;
      scene.pinned[particle] = 1;
      held.particles.push_back(particle);
      held.start.push_back(scene.initial_position[particle]);
      if (std::ranges::binary_search(points, local)) held_points.push_back(local);
    }
    if (held_points.empty()) {
      for (const int particle : held.particles)
        held_points.push_back(particle - body.first_particle);
    }
    held.moves = pin.motion.has_value();
    if (held.moves) {
      held.motion = RigidMotion(*pin.motion, mean_of_image_points(body, positions, held_points));
      held.radius = held.motion.radius_of(held.start);
    }
    if (pin.clamp && !body.spline)
      held.clamped = find_clamped_edges(body, held.particles, scene.initial_position, {});
    if (!body.spline) require_clamped_edges(pin, held.clamped);
    pins.push_back(std::move(held));
  }
  if (!sliding->all.empty()) body.supports = sliding;
}

void add_loads(Scene& scene) {
  for (std::size_t i = 0; i < scene.source.load.size(); ++i) {
    const LoadCase& load = scene.source.load[i];
    const auto body = std::ranges::find(scene.bodies, load.body, &SceneBody::name);
    const auto positions = std::span<const Vec3>(scene.initial_position)
                               .subspan(body->first_particle, body->particle_count());
    body->loads.push_back({static_cast<int>(i), std::make_shared<const std::vector<LoadPoint>>(
                                                    find_load_points(*body, load, positions))});
  }
}

// Returns the default number of threads: at most those of OMP_NUM_THREADS. With fewer particles per
// thread, threads would lose more time waiting for each other than they save (docs/decisions/0025).
int threads_that_pay(int particles) {
  constexpr int particles_per_thread = 1024;
  const int most = std::min(omp_get_num_procs(), omp_get_max_threads());
  return std::clamp(particles / particles_per_thread, 1, most);
}

// Moves the particles of prescribed motions to their places at t = 0.
void apply_initial_motions(Scene& scene) {
  for (const PrescribedMotion& held : scene.prescribed) {
    std::vector<Vec3> position(held.start), velocity(held.start.size(), Vec3::Zero());
    if (held.moves) held.motion.apply(0.0, held.start, position, velocity);
    for (std::size_t i = 0; i < held.particles.size(); ++i) {
      scene.initial_position[held.particles[i]] = position[i];
    }
  }
  for (const SceneBody& body : scene.bodies) {
    if (!body.supports || !body.supports->any_moves()) continue;
    match_positions(
        *body.supports, 0.0,
        std::span(scene.initial_position).subspan(body.first_particle, body.particle_count()));
  }
}

// Returns the index of the body to which a particle or point belongs. `first` is the member with
// the body's first particle or point.
int body_index_of(const std::vector<SceneBody>& bodies, int SceneBody::*first, int number) {
  const auto after = std::ranges::upper_bound(bodies, number, {}, first);
  return static_cast<int>(after - bodies.begin()) - 1;
}

std::string place_in(const SceneBody& body, const bsi::Atlas& atlas, int local) {
  if (body.spheres != nullptr)
    return "particles \"" + body.name + "\", number " + std::to_string(local);
  const bsi::TexelAddress at = atlas.particle_address(local);
  std::string text = (body.is_obstacle ? "obstacle \"" : "body \"") + body.name + "\", ";
  if (atlas.patches().size() > 1) text += "patch " + std::to_string(at.patch) + ", ";
  return text + "row " + std::to_string(at.row) + ", column " + std::to_string(at.col);
}

std::vector<Vec3> points_of(const SurfaceMap& map, std::span<const Vec3> particles, int count) {
  std::vector<Vec3> room;
  const std::span<const Vec3> points = map.points_of(particles, count, room);
  return {points.begin(), points.end()};
}

}  // namespace

SampledSurface::SampledSurface(bsi::Atlas image, SurfaceMap particles_to_points,
                               std::span<const Vec3> particles)
    : atlas(std::move(image)),
      mesh(bsi::build_mesh(atlas)),
      map(std::move(particles_to_points)),
      rest(points_of(map, particles, atlas.particle_count())) {}

int Scene::case_index(int body) const {
  return static_cast<int>(std::ranges::find(case_order, body) - case_order.begin());
}

int Scene::body_index_of_particle(int particle) const {
  return body_index_of(bodies, &SceneBody::first_particle, particle);
}

int Scene::body_index_of_point(int point) const {
  return body_index_of(bodies, &SceneBody::first_point, point);
}

int Scene::main_particle(int point) const {
  if (surface_map.is_identity()) return point;
  return std::ranges::max(surface_map.shares(point), {}, &SurfaceMap::Share::weight).particle;
}

Vec3 Scene::initial_velocity(int particle) const {
  const SceneBody& body = body_of_particle(particle);
  if (!body.start_velocity.empty()) return body.start_velocity[particle - body.first_particle];
  return body.velocity + body.spin.cross(initial_position[particle] - body.centre);
}

const SceneBody& Scene::body_of_particle(int particle) const {
  return bodies[body_index_of_particle(particle)];
}

std::string Scene::describe_particle(int particle) const {
  const SceneBody& body = body_of_particle(particle);
  return place_in(body, body.atlas, particle - body.first_particle);
}

std::string Scene::describe_point(int point) const {
  const SceneBody& body = bodies[body_index_of_point(point)];
  return place_in(body, body.surface_atlas(), point - body.first_point) +
         (body.sampled ? " of its surface" : "");
}

std::unique_ptr<const Scene> build_scene(const Case& source) {
  if (source.awaits_accuracy()) {
    throw CaseError(source.accuracy_location, "time.accuracy has not been settled",
                    "expected a case after choose_accuracy() or correct_accuracy()");
  }
  auto scene = std::make_unique<Scene>();
  scene->source = source;
  if (source.time.method == TimeMethod::impulses) {
    scene->spheres_collide = source.contact.enabled;
    scene->source.contact.enabled = false;
  }
  for (const BodyCase& body : source.body) add_dynamic_body(*scene, body);
  add_sphere_groups(*scene);
  std::vector<PrescribedMotion> pins;
  for (std::size_t b = 0; b < source.body.size(); ++b) {
    if (!has_timed_pins(source.body[b])) add_pins(*scene, source.body[b], scene->bodies[b], pins);
  }
  put_held_bodies_last(*scene, pins);
  scene->threads = source.compute.threads.value_or(threads_that_pay(scene->dynamic_particles));
  for (const ObstacleCase& obstacle : source.obstacle) {
    scene->case_order.push_back(static_cast<int>(scene->bodies.size()));
    add_obstacle(*scene, obstacle);
  }
  std::ranges::stable_partition(scene->case_order,
                                [&](int body) { return scene->bodies[body].spheres == nullptr; });
  std::ranges::move(pins, std::back_inserter(scene->prescribed));
  apply_initial_motions(*scene);
  add_timed_pins(*scene);
  if (!source.particles.empty()) scene->impact_speed = expected_impact_speed(*scene);
  add_loads(*scene);
  add_ties(*scene);
  add_seams(*scene);
  number_surface_points(*scene);
  recorded_bodies(*scene);  // throws CaseError for a part that does not fit its body
  return scene;
}

}  // namespace weft::sim
