#include "sim/channels/recorded_channels.h"

#include <algorithm>

#include "sim/integrator/integrator.h"
#include "sim/scene/time_curve.h"

namespace weft::sim {

namespace {

template <class List>
auto part_of(const List& all, const SceneBody& body) {
  return std::span(all).subspan(body.first_particle, body.particle_count());
}

void append(const Vec3& vector, std::vector<double>& values) {
  values.insert(values.end(), vector.begin(), vector.end());
}

}  // namespace

RecordedChannels::RecordedChannels(const Simulation& simulation)
    : simulation_(simulation), scene_(simulation.scene()) {
  for (const Channel& channel : all_channels())
    records_channel_.push_back(static_cast<char>(sim::records(scene_.source.output, channel.id)));
  bends_ = has(ChannelId::bending_curvature) || has(ChannelId::bending_moment) ||
           has(ChannelId::crease_curvature);
  const bool energy = has(ChannelId::body_energy);
  if (bends_ || energy || has(ChannelId::membrane_strain) || has(ChannelId::membrane_stress))
    surfaces_.resize(scene_.dynamic_bodies);
  if (energy) springs_ = springs_of(scene_);
  list_supports();
  list_records();
  field_values_.resize(scene_.case_order.size());
}

void RecordedChannels::list_supports() {
  if (!has(ChannelId::reactions)) return;
  for (std::size_t i = 0; i < scene_.case_order.size(); ++i) {
    const int b = scene_.case_order[i];
    if (!scene_.bodies[b].dynamic) {
      supports_.push_back({.body = b, .wrench = {}});
      continue;
    }
    if (scene_.bodies[b].spheres != nullptr) continue;
    for (std::size_t pin = 0; pin < scene_.source.body[i].pin.size(); ++pin)
      supports_.push_back({.body = b, .pin = static_cast<int>(pin), .wrench = {}});
  }
  for (const Tie& tie : scene_.ties) supports_.push_back({.tie = tie.number, .wrench = {}});
}

// Returns the path of a support's records, relative to the group of their channel. Every support
// has a different path.
std::string RecordedChannels::home_of(const Support& support) const {
  if (support.tie >= 0) return "tie/" + std::to_string(support.tie + 1);
  const std::string& body = scene_.bodies[support.body].name;
  return support.pin < 0 ? body : body + "/pin_" + std::to_string(support.pin + 1);
}

void RecordedChannels::list_records() {
  for (const Channel* channel : recorded_channels(scene_.source.output)) {
    const std::string home = channel->name;
    switch (channel->home) {
      case Channel::Home::texels:
        break;
      case Channel::Home::supports:
        for (const Support& support : supports_)
          add_record(*channel, home + "/" + home_of(support));
        break;
      case Channel::Home::bodies:
        for (const int b : scene_.case_order) {
          if (scene_.bodies[b].dynamic) add_record(*channel, home + "/" + scene_.bodies[b].name);
        }
        break;
      case Channel::Home::run:
        add_record(*channel, home);
    }
  }
}

void RecordedChannels::add_record(const Channel& channel, const std::string& path) {
  for (const ChannelDataset& dataset : channel.datasets)
    records_.push_back({&channel, &dataset, path + "/" + dataset.name});
}

std::vector<ChannelPlace> channel_fields(const SceneBody& body, const OutputCase& output) {
  std::vector<ChannelPlace> fields;
  if (!body.moves) return fields;
  for (const Channel* channel : recorded_channels(output)) {
    if (channel->home != Channel::Home::texels) continue;
    if (channel->id != ChannelId::velocity) {
      const bool is_of_spheres = channel->id == ChannelId::angular_velocity;
      if (!body.dynamic || (body.spheres != nullptr) != is_of_spheres) continue;
    }
    for (const ChannelDataset& dataset : channel->datasets)
      fields.push_back({channel, &dataset, {}});
  }
  return fields;
}

void RecordedChannels::compute(double time, std::span<const double> y,
                               std::span<const Vec3> position, std::span<const Vec3> velocity) {
  if (has(ChannelId::contact_force) || has(ChannelId::friction_force) ||
      has(ChannelId::reactions)) {
    simulation_.dynamics_with_pins().find_force_parts(time, y, forces_);
  }
  find_surfaces(time, y, position, velocity);
  if (has(ChannelId::angular_velocity)) find_turning(time, velocity);
  for (std::size_t i = 0; i < scene_.case_order.size(); ++i) {
    const int b = scene_.case_order[i];
    field_values_[i].clear();
    for (const ChannelPlace& place : fields(scene_.bodies[b]))
      field_values_[i].push_back(values_of(b, place, velocity));
  }
  record_values_.clear();
  if (has(ChannelId::reactions)) find_supports(position);
  for (const Support& support : supports_) {
    append(support.wrench.force, record_values_);
    append(support.wrench.moment, record_values_);
  }
  if (has(ChannelId::body_energy)) add_energies(time, position, velocity);
  if (has(ChannelId::largest_stretch_place)) add_largest_stretch(position);
}

// Sets the positions and velocities of a body's tensors. First makes the tensors if they do not
// exist, and makes them anew if the clamped edges of the body have changed.
void RecordedChannels::place_surface(int b, double time, std::span<const double> y,
                                     std::span<const Vec3> position,
                                     std::span<const Vec3> velocity) {
  Dynamics& dynamics = simulation_.dynamics_with_pins();
  const Instant now = dynamics.instant(time);
  const SceneBody& body = scene_.bodies[b];
  const MaterialCase& material = *body.material;
  Surface& surface = surfaces_[b];
  std::vector<ClampedBy> clamped = clamped_edges_of(dynamics.scene(), b);
  const auto is_same = [](const ClampedBy& one, const ClampedBy& other) {
    return one.held == other.held && one.edge == other.edge;
  };
  if (!surface.tensors || !std::ranges::equal(clamped, surface.clamped, is_same)) {
    std::vector<ClampedEdge> edges;
    edges.reserve(clamped.size());
    for (const ClampedBy& each : clamped) edges.push_back(*each.edge);
    std::vector<char> held = triangles_at_clamps(dynamics.scene(), b);
    for (const ClampedEdge& edge : edges) held[edge.triangle] = 0;
    const bool has_energy = has(ChannelId::body_energy) && material.resists_bending();
    surface.tensors.emplace(body, bends_ || has_energy, scene_.threads, edges, held);
    surface.clamped = std::move(clamped);
  }
  std::vector<Vec3> places(part_of(position, body).begin(), part_of(position, body).end());
  std::vector<Vec3> rates(part_of(velocity, body).begin(), part_of(velocity, body).end());
  for (const ClampedBy& each : surface.clamped) {
    Vec3 place = each.edge->ghost, rate = Vec3::Zero();
    if (each.held->moves) each.held->motion.pose(time).place(each.edge->ghost, place, rate);
    places.push_back(place);
    rates.push_back(rate);
  }
  surface.tensors->place(
      places, rates,
      {TimeCurve(material.membrane_damping_time()).at(now),
       TimeCurve(material.bending_damping_time()).at(now)},
      material.yields() ? dynamics.creases_of(time, y, b) : CreaseHistory::Creases());
}

void RecordedChannels::find_surfaces(double time, std::span<const double> y,
                                     std::span<const Vec3> position,
                                     std::span<const Vec3> velocity) {
  for (std::size_t b = 0; b < surfaces_.size(); ++b) {
    if (scene_.bodies[b].spheres != nullptr) continue;
    place_surface(static_cast<int>(b), time, y, position, velocity);
    Surface& surface = surfaces_[b];
    if (has(ChannelId::membrane_strain)) surface.tensors->find_strain(surface.strain);
    if (has(ChannelId::membrane_stress)) surface.tensors->find_stress(surface.stress);
    if (has(ChannelId::bending_curvature)) surface.tensors->find_curvature(surface.curvature);
    if (has(ChannelId::bending_moment)) surface.tensors->find_moment(surface.moment);
    if (has(ChannelId::crease_curvature)) surface.tensors->find_crease(surface.crease);
  }
}

void RecordedChannels::find_turning(double time, std::span<const Vec3> velocity) {
  turning_ = simulation_.integrator().spins_at(time);
  turning_.resize(scene_.dynamic_particles, Vec3::Zero());
  for (const SceneBody& spins : scene_.bodies) {
    if (!spins.are_spins) continue;
    const auto spheres = std::ranges::find(scene_.bodies, spins.spheres, &SceneBody::spheres);
    for (int i = 0; i < spins.particle_count(); ++i)
      turning_[spheres->first_particle + i] =
          velocity[spins.first_particle + i] / spins.spheres->radius;
  }
}

std::span<const double> RecordedChannels::values_of(int b, const ChannelPlace& place,
                                                    std::span<const Vec3> velocity) const {
  const SceneBody& body = scene_.bodies[b];
  const auto of_tensor = [&](PrincipalValues Surface::*values) -> std::span<const double> {
    const PrincipalValues& principal = surfaces_[b].*values;
    const auto part = place.dataset - place.channel->datasets.data();
    return part == 0 ? principal.major : part == 1 ? principal.minor : principal.direction;
  };
  switch (place.channel->id) {
    case ChannelId::velocity:
      return numbers_of(part_of(velocity, body));
    case ChannelId::angular_velocity:
      return numbers_of(part_of(turning_, body));
    case ChannelId::membrane_strain:
      return of_tensor(&Surface::strain);
    case ChannelId::membrane_stress:
      return of_tensor(&Surface::stress);
    case ChannelId::bending_curvature:
      return of_tensor(&Surface::curvature);
    case ChannelId::bending_moment:
      return of_tensor(&Surface::moment);
    case ChannelId::crease_curvature:
      return of_tensor(&Surface::crease);
    case ChannelId::contact_force:
      return numbers_of(part_of(forces_.contact, body));
    case ChannelId::friction_force:
      return numbers_of(part_of(forces_.friction, body));
    default:
      return {};
  }
}

// Computes the wrench of each support. An obstacle or a body held as a whole has the wrench of its
// contact forces. A pin has the sum of the forces on its particles. Outer forces are added to the
// pin, tie or body to which they belong.
void RecordedChannels::find_supports(std::span<const Vec3> position) {
  for (Support& support : supports_)
    support.wrench =
        support.pin < 0 && support.tie < 0 ? forces_.obstacles[support.body] : Wrench{};
  for (const PrescribedMotion& held : simulation_.dynamics_with_pins().scene().prescribed) {
    if (held.particles.empty() || held.particles[0] >= scene_.dynamic_particles) continue;
    const int body = scene_.body_index_of_particle(held.particles[0]);
    const auto found = std::ranges::find_if(supports_, [&](const Support& support) {
      return support.body == body && support.pin == held.pin;
    });
    for (const int particle : held.particles)
      found->wrench.add(position[particle], forces_.support[particle]);
  }
  for (const OuterForce& outer : forces_.outer) {
    for (Support& support : supports_) {
      if (support.body == outer.body && support.pin == outer.pin && support.tie == outer.tie)
        support.wrench.add(outer.place, outer.force);
    }
  }
}

void RecordedChannels::add_energies(double time, std::span<const Vec3> position,
                                    std::span<const Vec3> velocity) {
  const Dynamics& dynamics = simulation_.dynamics_with_pins();
  const Vec3 gravity = dynamics.load() * dynamics.gravity(time);
  std::vector<double> elastic(scene_.dynamic_bodies, 0.0);
  for (std::size_t b = 0; b < surfaces_.size(); ++b) {
    if (surfaces_[b].tensors) elastic[b] = surfaces_[b].tensors->elastic_energy();
  }
  for (std::size_t s = 0; s < springs_.springs.size(); ++s) {
    const auto [a, b] = springs_.ends[s];
    elastic[scene_.body_index_of_particle(a)] +=
        materials::spring_energy(springs_.springs[s], position[a], position[b]);
  }
  const auto kinetic_of = [&](const SceneBody& body) {
    double sum = 0;
    for (int i = body.first_particle; i < body.first_particle + body.particle_count(); ++i)
      sum += 0.5 * scene_.mass[i] * velocity[i].squaredNorm();
    return sum;
  };
  for (const int b : scene_.case_order) {
    const SceneBody& body = scene_.bodies[b];
    if (!body.dynamic) continue;
    double kinetic = kinetic_of(body), gravitational = 0;
    for (const SceneBody& other : scene_.bodies)
      if (other.are_spins && other.spheres == body.spheres) kinetic += kinetic_of(other);
    for (int i = body.first_particle; i < body.first_particle + body.particle_count(); ++i)
      gravitational -= scene_.mass[i] * gravity.dot(position[i]);
    record_values_.insert(record_values_.end(), {kinetic, gravitational, elastic[b]});
  }
}

void RecordedChannels::add_largest_stretch(std::span<const Vec3> position) {
  const int particle = simulation_.dynamics().find_largest_stretch(position).particle;
  const int b = scene_.body_index_of_particle(particle);
  const SceneBody& body = scene_.bodies[b];
  const bsi::TexelAddress at = body.atlas.particle_address(particle - body.first_particle);
  const auto place = std::ranges::find(scene_.case_order, b) - scene_.case_order.begin();
  for (const auto number : {static_cast<int>(place), at.patch, at.row, at.col})
    record_values_.push_back(number);
}

}  // namespace weft::sim
