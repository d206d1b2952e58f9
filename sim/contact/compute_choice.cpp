#include "sim/contact/compute_choice.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <stdexcept>

#include "sim/case/case_error.h"
#include "sim/contact/contact_search.h"
#include "sim/contact/device_search.h"

namespace weft::sim {

namespace {

// Returns the median time (s) of five searches. A search rebuilds the pyramids of all moving bodies
// and queries all pairs of neighbouring bodies.
double measure(PairSearch& search, const Scene& scene) {
  std::vector<Vec3> room;
  const std::span<const Vec3> all =
      scene.surface_map.points_of(scene.initial_position, scene.point_count, room);
  std::vector<BodyPath> every, moving;
  for (int b = 0; b < static_cast<int>(scene.bodies.size()); ++b) {
    const SceneBody& body = scene.bodies[b];
    const auto position = all.subspan(body.first_point, body.point_count());
    every.push_back({b, position, position});
    if (body.moves) moving.push_back(every.back());
  }
  const double slack = search_slack(scene);
  std::vector<PairQuery> queries;
  for (const CandidateList& list : neighbours_at_start(scene)) {
    const double reach = list.thickness + scene.source.contact.range + slack;
    queries.push_back({list.body_a, list.body_b, reach});
  }
  std::vector<std::vector<bsi::LeafPair>> found;
  bsi::TraversalCounters counters;
  // The first search is not measured, because it may compile shaders and allocate memory.
  search.rebuild(every);
  search.find(queries, found, counters);
  std::array<double, 5> seconds{};
  for (double& one : seconds) {
    const auto start = std::chrono::steady_clock::now();
    search.rebuild(moving);
    search.find(queries, found, counters);
    one = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }
  std::ranges::nth_element(seconds, seconds.begin() + 2);
  return seconds[2];
}

std::string milliseconds(double seconds) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3g ms", 1e3 * seconds);
  return text.data();
}

ChosenSearch on_cpu(const Scene& scene, std::string reason) {
  return {make_cpu_search(scene), {ComputeBackend::cpu, "", std::move(reason)}};
}

ChosenSearch choose_by_speed(const Scene& scene) {
  if (!may_have_graphics_processor()) return on_cpu(scene, "there is no graphics processor");
  try {
    DeviceSearch device = make_device_search(scene, ComputeBackend::gpu);
    const double device_time = measure(*device.search, scene);
    ChosenSearch cpu = on_cpu(scene, "");
    const double cpu_time = measure(*cpu.search, scene);
    const std::string times = "a search takes " + milliseconds(cpu_time) + " on the CPU and " +
                              milliseconds(device_time) + " on " + device.device;
    if (device_time < cpu_time) {
      return {std::move(device.search), {ComputeBackend::gpu, device.device, times}};
    }
    cpu.choice.reason = times;
    return cpu;
  } catch (const std::runtime_error& error) {
    return on_cpu(scene, error.what());
  }
}

}  // namespace

std::string ComputeChoice::text() const {
  const std::string name = backend == ComputeBackend::cpu   ? "CPU"
                           : backend == ComputeBackend::gpu ? "GPU"
                                                            : "OSMesa";
  return name + (device.empty() ? "" : " (" + device + ")") + ": " + reason;
}

ChosenSearch choose_search(const Scene& scene) {
  const ComputeCase& compute = scene.source.compute;
  if (!scene.source.particles.empty()) return on_cpu(scene, "particles are searched there");
  switch (compute.backend) {
    case ComputeBackend::automatic:
      return choose_by_speed(scene);
    case ComputeBackend::cpu:
      return on_cpu(scene, "compute.backend asks for it");
    case ComputeBackend::gpu:
    case ComputeBackend::osmesa:
      break;
  }
  try {
    DeviceSearch device = make_device_search(scene, compute.backend);
    return {std::move(device.search),
            {compute.backend, device.device, "compute.backend asks for it"}};
  } catch (const std::runtime_error& error) {
    const bool wants_gpu = compute.backend == ComputeBackend::gpu;
    throw CaseError({scene.source.path, 0, 0},
                    std::string("compute.backend is \"") + (wants_gpu ? "gpu" : "osmesa") +
                        "\": " + error.what(),
                    wants_gpu ? R"(use "auto", "osmesa" or "cpu")" : R"(use "auto" or "cpu")");
  }
}

}  // namespace weft::sim
