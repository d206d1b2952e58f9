#include "sim/case/memory_estimate.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <initializer_list>

#include "sim/case/case_shape_checks.h"
#include "sim/case/channels.h"
#include "sim/case/time_methods.h"

namespace weft::sim {

namespace {

constexpr double mebibyte = 1 << 20;

// Memory of a process without a scene (bytes): libraries, tables and buffers of a trajectory.
constexpr double process_memory = 16 * mebibyte;

// Memory per vertex (bytes), from the resident size of runs with 129 x 129 and 257 x 257 vertices;
// of shells, with 33 x 33 to 129 x 65 control points.
constexpr double geometry_and_state = 1200;
constexpr double implicit_matrix = 1700;   // matrix, multigrid levels, vectors of the solver
constexpr double bending_stencils = 1500;  // stencils and their matrix entries
constexpr double shell_elements = 11000;   // points of integration with their control points
constexpr double shell_factors = 26000;    // factors of the tangent, for equilibria of shells
constexpr double contact_search = 2000;    // edges, pyramid, candidates, pairs in reach
constexpr double surface_tensors = 500;    // triangles of SurfaceTensors, for some channels
constexpr double surface_hinges = 250;     // hinges of SurfaceTensors, for bending and body_energy
constexpr double force_parts = 100;        // forces by origin, for channels about forces
constexpr double channel_values = 80;      // values of one channel, including the written frame
constexpr double obstacle_geometry = 300;
constexpr double obstacle_contact = 900;
constexpr double rigid_particle = 2500;  // state, candidate pairs and contacts

// True if the material of the body has the property.
bool is_of(const Case& source, const BodyCase& body, bool (MaterialCase::*property)() const) {
  return std::ranges::any_of(source.material, [&](const MaterialCase& material) {
    return material.name == body.material && (material.*property)();
  });
}

// Returns the memory per vertex that the channels of a case need (bytes).
double channel_bytes(const OutputCase& output) {
  const auto any_of = [&](std::initializer_list<ChannelId> channels) {
    return std::ranges::any_of(channels, [&](ChannelId id) { return records(output, id); });
  };
  double bytes = channel_values * static_cast<double>(recorded_channels(output).size());
  using enum ChannelId;
  const bool bends = any_of({bending_curvature, bending_moment, crease_curvature, body_energy});
  if (bends || any_of({membrane_strain, membrane_stress})) bytes += surface_tensors;
  if (bends) bytes += surface_hinges;
  if (any_of({contact_force, friction_force, reactions})) bytes += force_parts;
  return bytes;
}

double bytes_per_vertex(const Case& source, const BodyCase& body) {
  double bytes = geometry_and_state + channel_bytes(source.output);
  if (!traits_of(source.time.method).is_explicit) {
    const bool bends = is_of(source, body, &MaterialCase::resists_bending);
    bytes += implicit_matrix + (bends ? bending_stencils : 0);
  }
  if (is_of(source, body, &MaterialCase::is_shell)) {
    bytes += shell_elements;
    if (traits_of(source.time.method).finds_equilibria()) bytes += shell_factors;
  }
  return bytes + (source.contact.enabled ? contact_search : 0);
}

double bytes_per_obstacle_vertex(const Case& source) {
  return obstacle_geometry + (source.contact.enabled ? obstacle_contact : 0);
}

std::vector<double> memory_by_shape(const Case& source, const SceneSize& size) {
  std::vector<double> bytes;
  for (std::size_t i = 0; i < size.body.size(); ++i) {
    bytes.push_back(size.body[i] * bytes_per_vertex(source, source.body[i]));
  }
  for (const double vertices : size.obstacle) {
    bytes.push_back(vertices * bytes_per_obstacle_vertex(source));
  }
  for (const double number : size.particles) bytes.push_back(number * rigid_particle);
  return bytes;
}

}  // namespace

SceneSize size_of_case(const Case& source) {
  SceneSize size;
  for (const BodyCase& body : source.body) {
    size.body.push_back(vertices_of(body.shape).value_or(0));
  }
  for (const ObstacleCase& obstacle : source.obstacle) {
    size.obstacle.push_back(vertices_of(obstacle.shape).value_or(0));
  }
  for (const ParticlesCase& particles : source.particles) {
    const PositionsCase& places = particles.positions;
    double number = places.number;
    if (places.type == PositionsType::grid) {
      number = 1;
      for (const int along : places.count) number *= along;
    }
    size.particles.push_back(number);
  }
  return size;
}

double estimate_memory(const Case& source, const SceneSize& size) {
  double sum = process_memory;
  for (const double bytes : memory_by_shape(source, size)) sum += bytes;
  return sum;
}

std::size_t largest_shape(const Case& source, const SceneSize& size) {
  const std::vector<double> bytes = memory_by_shape(source, size);
  return static_cast<std::size_t>(std::ranges::max_element(bytes) - bytes.begin());
}

double default_memory_limit() {
  double bytes =
      static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
  // A control group without a limit says "max", which does not parse as a number.
  for (const char* path :
       {"/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"}) {
    double group = 0;
    if (std::ifstream(path) >> group && group > 0) bytes = std::min(bytes, group);
  }
  return 0.9 * bytes;
}

double memory_limit(const Case& source) {
  const auto& limit = source.compute.memory_limit;
  return limit ? *limit * mebibyte : default_memory_limit();
}

std::string reason_of_memory(const Case& source, const SceneSize& size) {
  const double needed = estimate_memory(source, size);
  const double limit = memory_limit(source);
  if (needed <= limit) return "";
  return "the scene needs about " + memory_text(needed) + " of memory, more than the limit of " +
         memory_text(limit);
}

std::string memory_text(double bytes) {
  const double mebibytes = bytes / mebibyte;
  char text[64];
  if (mebibytes < 10240) {
    std::snprintf(text, sizeof text, "%.4g MiB", mebibytes);
  } else {
    const bool long_number = mebibytes >= 102400;
    std::snprintf(text, sizeof text, long_number ? "%.0f GiB" : "%.3g GiB", mebibytes / 1024);
  }
  return text;
}

}  // namespace weft::sim
