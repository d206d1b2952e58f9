#include "bench/cloth_runs.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "sim/integrator/integrator.h"
#include "sim/motion/dynamics.h"
#include "sim/run/make_simulation.h"

namespace weft::bench {

namespace {

using namespace sim;

double strain_of(const Simulation& simulation, std::span<const double> y, double time) {
  std::vector<Vec3> position, velocity;
  simulation.dynamics().expand_all(time, y, position, velocity);
  return largest_strain(simulation.scene(), position);
}

void take_step(Simulation& simulation) {
  if (const auto failure = simulation.step()) throw std::runtime_error(failure->text);
}

}  // namespace

double largest_strain(const Scene& scene, std::span<const Vec3> position) {
  double largest = -1;
  for (const SceneBody& body : scene.bodies) {
    if (!body.dynamic) continue;
    for (const auto& [a, b, c] : body.mesh.triangles) {
      const auto sides_of = [&](const auto& x, int first) {
        Eigen::Matrix<double, 3, 2> sides;
        sides << x[first + b] - x[first + a], x[first + c] - x[first + a];
        return sides;
      };
      const Eigen::Matrix<double, 3, 2> rest = sides_of(body.rest, 0);
      const Vec3 along = rest.col(0).normalized();
      const Vec3 normal = along.cross(Vec3(rest.col(1))).normalized();
      Eigen::Matrix<double, 3, 2> frame;
      frame << along, normal.cross(along);
      const Eigen::Matrix2d in_plane = frame.transpose() * rest;
      const Eigen::Matrix<double, 3, 2> deformation =
          sides_of(position, body.first_particle) * in_plane.inverse();
      const Eigen::Matrix2d squares = deformation.transpose() * deformation;
      const double middle = 0.5 * squares.trace(),
                   radius = std::hypot(0.5 * (squares(0, 0) - squares(1, 1)), squares(0, 1));
      largest = std::max(largest, std::sqrt(middle + radius) - 1);
    }
  }
  return largest;
}

RunStrain largest_strains(const Case& source) {
  Simulation simulation = make_simulation(source);
  std::vector<double> y(simulation.state().size());
  RunStrain largest;
  while (simulation.time() < source.time.duration) {
    take_step(simulation);
    largest.at_ends =
        std::max(largest.at_ends, strain_of(simulation, simulation.state(), simulation.time()));
    const double middle = simulation.time() - 0.5 * simulation.integrator().last_step();
    if (const auto failure = simulation.state_at(middle, y))
      throw std::runtime_error(failure->text);
    largest.within = std::max(largest.within, strain_of(simulation, y, middle));
  }
  return largest;
}

Decay decay_of(std::span<const double> samples, double step) {
  std::vector<double> times, extremes;
  for (std::size_t i = 1; i + 1 < samples.size(); ++i) {
    const double before = samples[i - 1], here = samples[i], after = samples[i + 1];
    if ((here > before) != (here >= after)) continue;
    const double bend = before - 2 * here + after, shift = 0.5 * (before - after) / bend;
    times.push_back(step * (static_cast<double>(i) + shift));
    extremes.push_back(here - 0.25 * (before - after) * shift);
  }
  constexpr std::size_t skipped = 4;
  if (times.size() < skipped + 8) throw std::runtime_error("it does not vibrate for six periods");
  const auto distance = [&](std::size_t i) { return std::abs(extremes[i + 1] - extremes[i]); };
  const std::size_t last = times.size() - 2;
  const double periods = 0.5 * static_cast<double>(last - skipped);
  const double delta = std::log(distance(skipped) / distance(last)) / periods;
  const double ratio = delta / std::numbers::pi;
  return {periods / (times[last] - times[skipped]), ratio / std::sqrt(1 + ratio * ratio / 4)};
}

Decay ring_down(const Case& source, int axis) {
  Simulation simulation = make_simulation(source);
  const double step = source.time.step.value();
  const std::string& body = source.body.at(0).name;
  std::vector<double> samples{simulation.position(body).back()[axis]};
  while (simulation.time() < source.time.duration - 0.5 * step) {
    take_step(simulation);
    samples.push_back(simulation.position(body).back()[axis]);
  }
  return decay_of(samples, step);
}

double turning_angle(const Scene& scene, std::span<const Vec3> position) {
  const bsi::Patch& image = scene.bodies.at(0).atlas.patches()[0];
  const int row = image.rows / 2;
  const auto at = [&](int col) { return position[row * image.cols + col]; };
  double sum = 0;
  for (int c = 1; c + 1 < image.cols; ++c) {
    const Vec3 before = at(c) - at(c - 1), after = at(c + 1) - at(c);
    sum += std::atan2(before.cross(after).y(), before.dot(after));
  }
  // The angle of a segment is that between the middles of its ends.
  return std::abs(sum) * (image.cols - 1) / (image.cols - 2);
}

}  // namespace weft::bench
