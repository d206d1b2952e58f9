#include "sim/case/channels.h"

#include <algorithm>
#include <array>

#include "sim/case/case.h"
#include "sim/case/case_schema.h"
#include "sim/case/case_text.h"
#include "sim/case/time_methods.h"

namespace weft::sim {

namespace {

using Home = Channel::Home;

constexpr ChannelDataset velocity[] = {{"velocity", "m/s", 3}};
constexpr ChannelDataset turning[] = {{"angular_velocity", "rad/s", 3}};
constexpr ChannelDataset strain[] = {{"membrane_strain_major", "1"},
                                     {"membrane_strain_minor", "1"},
                                     {"membrane_strain_direction", "1", 3}};
constexpr ChannelDataset stress[] = {{"membrane_stress_major", "N/m"},
                                     {"membrane_stress_minor", "N/m"},
                                     {"membrane_stress_direction", "1", 3}};
constexpr ChannelDataset curvature[] = {{"bending_curvature_major", "1/m"},
                                        {"bending_curvature_minor", "1/m"},
                                        {"bending_curvature_direction", "1", 3}};
constexpr ChannelDataset moment[] = {{"bending_moment_major", "N m/m"},
                                     {"bending_moment_minor", "N m/m"},
                                     {"bending_moment_direction", "1", 3}};
constexpr ChannelDataset crease[] = {{"crease_curvature_major", "1/m"},
                                     {"crease_curvature_minor", "1/m"},
                                     {"crease_curvature_direction", "1", 3}};
constexpr ChannelDataset contact[] = {{"contact_force", "N", 3}};
constexpr ChannelDataset friction[] = {{"friction_force", "N", 3}};
constexpr ChannelDataset reactions[] = {{"force", "N", 3}, {"moment", "N m", 3}};
constexpr ChannelDataset energies[] = {{"kinetic", "J"}, {"gravitational", "J"}, {"elastic", "J"}};
constexpr ChannelDataset place[] = {{"body", "1"}, {"patch", "1"}, {"row", "1"}, {"column", "1"}};

constexpr Channel table[] = {
    {"velocity", ChannelId::velocity, Home::texels, velocity},
    {"angular_velocity", ChannelId::angular_velocity, Home::texels, turning},
    {"membrane_strain", ChannelId::membrane_strain, Home::texels, strain},
    {"membrane_stress", ChannelId::membrane_stress, Home::texels, stress},
    {"bending_curvature", ChannelId::bending_curvature, Home::texels, curvature},
    {"bending_moment", ChannelId::bending_moment, Home::texels, moment},
    {"crease_curvature", ChannelId::crease_curvature, Home::texels, crease},
    {"contact_force", ChannelId::contact_force, Home::texels, contact},
    {"friction_force", ChannelId::friction_force, Home::texels, friction},
    {"reactions", ChannelId::reactions, Home::supports, reactions},
    {"body_energy", ChannelId::body_energy, Home::bodies, energies},
    {"largest_stretch_place", ChannelId::largest_stretch_place, Home::run, place},
};

const MaterialCase* material_of(const BodyCase& body, const Case& source) {
  const auto found = std::ranges::find(source.material, body.material, &MaterialCase::name);
  return found == source.material.end() ? nullptr : &*found;
}

template <class Condition>
const BodyCase* first_body(const Case& source, const Condition& condition) {
  const auto found = std::ranges::find_if(source.body, [&](const BodyCase& body) {
    const MaterialCase* material = material_of(body, source);
    return material != nullptr && condition(*material);
  });
  return found == source.body.end() ? nullptr : &*found;
}

// True if the channel is computed from the triangles of cloth, so that shells do not have it.
bool is_of_triangles(ChannelId id) {
  return id == ChannelId::membrane_strain || id == ChannelId::membrane_stress ||
         id == ChannelId::bending_curvature || id == ChannelId::bending_moment ||
         id == ChannelId::crease_curvature || id == ChannelId::body_energy;
}

// True if any two bodies have friction.
bool has_friction(const Case& source) {
  const auto is_rough = [](const auto& each) { return each.friction.value_or(0) > 0; };
  return !source.contact.friction.is_zero() || std::ranges::any_of(source.contact.pair, is_rough) ||
         std::ranges::any_of(source.particles, is_rough);
}

// True if a body, a group of particles or an obstacle is recorded that has values of the channel.
bool is_recorded_anywhere(const Channel& channel, const Case& source) {
  const std::vector<std::string>& listed = source.output.bodies;
  const auto is_listed = [&](const auto& each) {
    return listed.empty() || std::ranges::find(listed, each.name) != listed.end();
  };
  const auto turns = [&](const ParticlesCase& each) {
    return is_listed(each) && source.can_turn(each);
  };
  const auto moves = [&](const ObstacleCase& each) {
    return is_listed(each) && each.motion.has_value();
  };
  if (channel.home != Home::texels) return true;
  if (channel.id == ChannelId::angular_velocity)
    return std::ranges::any_of(source.particles, turns);
  if (std::ranges::any_of(source.body, is_listed)) return true;
  return channel.id == ChannelId::velocity && (std::ranges::any_of(source.particles, is_listed) ||
                                               std::ranges::any_of(source.obstacle, moves));
}

}  // namespace

std::span<const Channel> all_channels() { return table; }

std::vector<std::string> channel_names() {
  std::vector<std::string> names;
  for (const Channel& channel : table) names.emplace_back(channel.name);
  return names;
}

bool records(const OutputCase& output, ChannelId id) {
  if (id == ChannelId::velocity && output.velocity) return true;
  return std::ranges::any_of(table, [&](const Channel& channel) {
    return channel.id == id &&
           std::ranges::find(output.channels, channel.name) != output.channels.end();
  });
}

std::vector<const Channel*> recorded_channels(const OutputCase& output) {
  std::vector<const Channel*> channels;
  for (const Channel& channel : table) {
    if (records(output, channel.id)) channels.push_back(&channel);
  }
  return channels;
}

std::string reason_against(const Channel& channel, const Case& source, std::string& hint) {
  const std::string name = "the channel " + in_quotes(channel.name);
  const bool is_of_particles =
      channel.id == ChannelId::velocity || channel.id == ChannelId::angular_velocity;
  if (source.time.method == TimeMethod::impulses && !is_of_particles) {
    hint = "expected channels among \"velocity\" and \"angular_velocity\"";
    return name + " is not recorded with time.method = \"impulses\"";
  }
  const bool is_of_surfaces = channel.id == ChannelId::largest_stretch_place ||
                              (channel.home == Home::texels && !is_of_particles);
  if (is_of_surfaces && source.body.empty()) {
    hint = "expected a [[body]], or no " + in_quotes(channel.name);
    return name + " would be missing: particles do not have it";
  }
  const BodyCase* shell =
      first_body(source, [](const MaterialCase& material) { return material.is_shell(); });
  if (shell != nullptr && is_of_triangles(channel.id)) {
    hint = "expected model = \"cloth\" in " + heading(join_path("material", shell->material)) +
           ", or no " + in_quotes(channel.name);
    return name + " is that of cloth, and body " + in_quotes(shell->name) + " is a shell";
  }
  if (!source.output.bodies.empty() && !is_recorded_anywhere(channel, source)) {
    hint = "expected output.bodies to list what has it, or no " + in_quotes(channel.name);
    return name + " would be missing: nothing that output.bodies lists has it";
  }
  switch (channel.id) {
    case ChannelId::angular_velocity:
      if (std::ranges::any_of(source.particles,
                              [&](const auto& it) { return source.can_turn(it); }))
        return "";
      hint =
          "expected particles with spin = true, and with friction or an angular velocity, or no " +
          in_quotes(channel.name);
      return name + " would be zero: no particles turn";
    case ChannelId::membrane_stress: {
      const BodyCase* body = first_body(source, [](const MaterialCase& material) {
        return material.membrane == MembraneModel::springs;
      });
      if (body == nullptr) return "";
      hint = "expected membrane = \"triangles\" in " +
             heading(join_path("material", body->material)) + ", or no " + in_quotes(channel.name);
      return name + " needs a membrane of triangles, and that of body " + in_quotes(body->name) +
             " is made of springs";
    }
    case ChannelId::bending_moment:
      if (first_body(source, [](const MaterialCase& m) { return m.resists_bending(); })) return "";
      hint = "expected a material with bending_stiffness > 0 or orthotropic_bending, or no " +
             in_quotes(channel.name);
      return name + " would be zero: no body resists bending";
    case ChannelId::crease_curvature:
      if (first_body(source, [](const MaterialCase& m) { return m.yields(); })) return "";
      hint = "expected a material with yield_curvature, or no " + in_quotes(channel.name);
      return name + " would be zero: no body yields";
    case ChannelId::contact_force:
    case ChannelId::friction_force:
      if (!source.contact.enabled) {
        hint = "expected contact.enabled = true, or no " + in_quotes(channel.name);
        return name + " would be zero: contact is off";
      }
      if (channel.id == ChannelId::contact_force) return "";
      if (traits_of(source.time.method).finds_equilibria()) {
        hint = "expected another time.method, or no " + in_quotes(channel.name);
        return name + " would be zero: in an equilibrium nothing slides";
      }
      if (has_friction(source)) return "";
      hint =
          "expected contact.friction > 0, particles or a [[contact.pair]] with friction, or no " +
          in_quotes(channel.name);
      return name + " would be zero: there is no friction";
    case ChannelId::reactions:
      if (!source.obstacle.empty() || !source.tie.empty() ||
          std::ranges::any_of(source.body, [](const BodyCase& body) { return !body.pin.empty(); }))
        return "";
      hint = "expected a pin, a tie or an obstacle, or no " + in_quotes(channel.name);
      return name + " would be empty: nothing holds the bodies";
    default:
      return "";
  }
}

}  // namespace weft::sim
