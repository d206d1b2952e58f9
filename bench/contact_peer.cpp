#include "bench/cloth_peers.h"
#include "bench/cloth_runs.h"
#include "bench/contact.h"
#include "bench/dropped_shells.h"

namespace weft::bench {

namespace {

using namespace sim;

// Returns the drape as other libraries can express it: with springs of the same stiffness as the
// membrane, without bending and damping, and with the ball beside it.
ClothProblem problem_of(Case source, const Scene& with_ball) {
  source.contact.enabled = false;
  for (MaterialCase& material : source.material) {
    material.membrane = MembraneModel::springs;
    material.bending_stiffness = 0;
    material.stiffness_damping = material.bending_damping = 0.0;
  }
  const auto scene = build_scene(source);
  ClothProblem problem = cloth_problem(*scene);
  const ObstacleCase& ball = source.obstacle.at(0);
  problem.ball.radius = ball.shape.radius.value();
  for (int axis = 0; axis < 3; ++axis) problem.ball.centre[axis] = ball.position[axis];
  problem.ball.gap = 0.5 * (with_ball.bodies[0].thickness + ball.thickness);
  problem.ball.friction = source.contact.friction.constant_or_zero();
  return problem;
}

// Returns the positions of all particles of the scene at the end of the outcome.
std::vector<Vec3> end_of(const Scene& scene, const ClothOutcome& outcome) {
  std::vector<Vec3> position = scene.initial_position;
  for (std::size_t i = 0; i < outcome.position.size(); ++i)
    position[i] = {outcome.position[i][0], outcome.position[i][1], outcome.position[i][2]};
  return position;
}

}  // namespace

std::optional<std::string> ball_program() { return cloth_program(cloth_methods()[0]); }

ContactRun measure_soft_body(const std::string& program, const Case& source, int steps_per_second,
                             int iterations) {
  ContactRun run;
  const auto scene = build_scene(source);
  run.vertices = scene->dynamic_particles;
  ClothSettings settings{.method = cloth_methods()[0].method};
  settings.step = 1.0 / steps_per_second;
  settings.steps = static_cast<long>(source.time.duration * steps_per_second + 0.5);
  settings.iterations = iterations;
  settings.budget = 600;
  const ClothOutcome outcome = run_cloth(program, problem_of(source, *scene), settings);
  run.failure = outcome.failure;
  run.simulated = settings.step * static_cast<double>(settings.steps);
  run.cpu = run.wall = outcome.cpu;
  run.steps = static_cast<double>(settings.steps);
  if (!run.failure.empty()) return run;
  const std::vector<Vec3> position = end_of(*scene, outcome);
  run.crossings = surface_crossings(*scene, position);
  run.largest_strain = largest_strain(*scene, position);
  return run;
}

}  // namespace weft::bench
