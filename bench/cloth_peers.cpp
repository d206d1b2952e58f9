#include "bench/cloth_peers.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "sim/case/case_text.h"
#include "sim/forces/springs.h"

namespace weft::bench {

namespace {

using namespace sim;

std::optional<std::string> beyond_peers(const MaterialCase& material) {
  if (material.membrane != MembraneModel::springs) return "its membrane is not made of springs";
  if (material.bending_stiffness != 0) return "it has bending stiffness";
  if (!material.mass_damping.is_zero() || !material.membrane_damping_time().is_zero() ||
      !material.bending_damping_time().is_zero())
    return "it has damping";
  if (!material.normal_drag.is_zero() || !material.tangential_drag.is_zero()) return "it has drag";
  return std::nullopt;
}

std::array<double, 3> array_of(const Vec3& v) { return {v[0], v[1], v[2]}; }

// A temporary file, removed with the object.
class TemporaryFile {
 public:
  TemporaryFile() {
    const int descriptor = mkstemp(path_.data());
    if (descriptor < 0) throw std::runtime_error(path_ + " cannot be written");
    close(descriptor);
  }
  ~TemporaryFile() { std::remove(path_.c_str()); }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  const std::string& path() const { return path_; }

 private:
  std::string path_ = (std::filesystem::temp_directory_path() / "weft-cloth-XXXXXX").string();
};

// Returns the output of the program for the file as input. Neither path may contain an apostrophe.
std::string output_of(const std::string& program, const std::string& input_path) {
  FILE* pipe = popen(("'" + program + "' < '" + input_path + "'").c_str(), "r");
  if (pipe == nullptr) return {};
  std::string text;
  std::array<char, 4096> part;
  while (const std::size_t count = fread(part.data(), 1, part.size(), pipe))
    text.append(part.data(), count);
  pclose(pipe);
  return text;
}

}  // namespace

std::span<const ClothMethod> cloth_methods() {
  // Variants worth trying. More than four iterations of the soft body only cost more. Bullet's five
  // Newton iterations, with conjugate gradients down to rounding, cost more than ten times as much
  // as one with 1e-4 at steps of 4 ms, for the same error. Line searches help if the step is so
  // long that springs buckle within it.
  static const std::vector<ClothMethod> methods{
      {"bullet-soft-body", "bullet", "soft-body", {{"1 iteration", 1}, {"4 iterations", 4}}},
      {"bullet-deformable",
       "bullet",
       "deformable",
       {{"newton 1, cg 1e-4", 1, 1e-4},
        {"newton 1, cg 1e-7", 1, 1e-7},
        {"search 1, cg 1e-4", 1, 1e-4, true},
        {"search 5, cg 1e-7", 5, 1e-7, true}}},
      {"bullet-explicit", "bullet", "deformable-explicit", {{""}}}};
  return methods;
}

std::optional<std::string> cloth_program(const ClothMethod& method) {
  std::error_code failure;
  const auto folder = std::filesystem::read_symlink("/proc/self/exe", failure).parent_path();
  const std::string name = std::string("weft-bench-") + method.library;
  for (const auto& place : {folder / name, folder / "peers" / name}) {
    if (access(place.c_str(), X_OK) == 0) return place.string();
  }
  return std::nullopt;
}

std::optional<std::string> beyond_peers(const Scene& scene) {
  if (scene.source.contact.enabled) return "contact is on";
  if (scene.source.world.gravity.varies()) return "gravity varies";
  for (int b = 0; b < scene.dynamic_bodies; ++b) {
    if (auto reason = beyond_peers(*scene.bodies[b].material))
      return "body " + in_quotes(scene.bodies[b].name) + ": " + *reason;
  }
  for (const PrescribedMotion& motion : scene.prescribed) {
    if (motion.moves && std::any_of(motion.particles.begin(), motion.particles.end(),
                                    [&](int p) { return p < scene.dynamic_particles; }))
      return "its pins move";
  }
  return std::nullopt;
}

ClothProblem cloth_problem(const Scene& scene) {
  ClothProblem problem;
  problem.gravity = array_of(scene.source.world.gravity.constant());
  for (int i = 0; i < scene.dynamic_particles; ++i) {
    const bool held = scene.pinned[i] != 0;
    problem.position.push_back(array_of(scene.initial_position[i]));
    problem.velocity.push_back(array_of(held ? Vec3(Vec3::Zero()) : scene.initial_velocity(i)));
    problem.mass.push_back(held ? 0 : scene.mass[i]);
  }
  const SpringNetwork network = springs_of(scene);
  for (std::size_t i = 0; i < network.ends.size(); ++i) {
    problem.springs.push_back(
        {network.ends[i], network.springs[i].rest_length, network.springs[i].stiffness});
  }
  return problem;
}

ClothOutcome run_cloth(const std::string& program, const ClothProblem& problem,
                       const ClothSettings& settings) {
  const TemporaryFile input;
  std::ofstream(input.path()) << settings << problem;
  std::istringstream text(output_of(program, input.path()));
  ClothOutcome outcome;
  if (!(text >> outcome)) outcome.failure = program + " has crashed";
  return outcome;
}

}  // namespace weft::bench
