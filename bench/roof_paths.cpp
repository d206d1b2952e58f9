#include "bench/roof_paths.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "sim/channels/recorded_channels.h"
#include "sim/integrator/integrator.h"
#include "sim/run/make_simulation.h"

namespace weft::bench {

namespace {

using namespace sim;

// The corner "last_first" of the quarter.
std::size_t centre_of(const Case& source) {
  const std::vector<int>& resolution = source.body.at(0).shape.resolution;
  return static_cast<std::size_t>((resolution.at(0) - 1) * resolution.at(1));
}

// The x component of the force that the pin at the centre exerts, N.
double reaction_at_centre(const Simulation& simulation) {
  RecordedChannels channels(simulation);
  std::vector<Vec3> position, velocity;
  simulation.dynamics().expand_all(simulation.time(), simulation.state(), position, velocity);
  channels.compute(simulation.time(), simulation.state(), position, velocity);
  std::size_t first = 0;
  for (const ChannelPlace& place : channels.records()) {
    if (place.path == "reactions/roof/pin_4/force") return channels.record_values()[first];
    first += static_cast<std::size_t>(place.dataset->components);
  }
  throw std::runtime_error("the roof has no reaction at its centre");
}

}  // namespace

double RoofPath::first_limit() const {
  for (std::size_t i = 1; i < factor.size(); ++i) {
    if (factor[i] < factor[i - 1]) return factor[i - 1];
  }
  return 0;
}

double RoofPath::distance(double at_deflection, double at_factor) const {
  const auto range = [](const std::vector<double>& values) {
    const auto [least, most] = std::ranges::minmax(values);
    return most - least;
  };
  const Eigen::Array2d ranges(range(deflection), range(factor));
  const auto scaled = [&](double by_deflection, double by_factor) {
    return Eigen::Vector2d(Eigen::Array2d(by_deflection, by_factor) / ranges);
  };
  const Eigen::Vector2d point = scaled(at_deflection, at_factor);
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < factor.size(); ++i) {
    const Eigen::Vector2d a = scaled(deflection[i - 1], factor[i - 1]);
    const Eigen::Vector2d b = scaled(deflection[i], factor[i]);
    const double s = std::clamp((point - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
    nearest = std::min(nearest, (a + s * (b - a) - point).norm());
  }
  return nearest;
}

RoofPath follow_by_arc_length(const Case& source) {
  const std::size_t centre = centre_of(source);
  Simulation roof = make_simulation(source);
  const double start = roof.position("roof")[centre].x();
  RoofPath path{{0}, {0}};
  while (!roof.has_ended()) {
    if (const auto failure = roof.step()) throw std::runtime_error(failure->text);
    path.deflection.push_back(start - roof.position("roof")[centre].x());
    path.factor.push_back(roof.integrator().path_point()->load_factor);
  }
  return path;
}

RoofPath follow_by_displacement(const Case& source) {
  constexpr double quarter_of_load = 750;  // N
  const std::size_t centre = centre_of(source);
  Simulation roof = make_simulation(source);
  const double start = roof.position("roof")[centre].x();
  const double per_second = source.time.frames_per_second;
  RoofPath path;
  for (int frame = 1; frame <= std::lround(source.time.duration * per_second); ++frame) {
    if (const auto failure = roof.advance(frame / per_second - roof.time()))
      throw std::runtime_error(failure->text);
    path.deflection.push_back(start - roof.position("roof")[centre].x());
    path.factor.push_back(reaction_at_centre(roof) / -quarter_of_load);
  }
  return path;
}

double largest_distance(const RoofPath& points, const RoofPath& path) {
  double largest = 0;
  for (std::size_t i = 0; i < points.factor.size(); ++i)
    largest = std::max(largest, path.distance(points.deflection[i], points.factor[i]));
  return largest;
}

}  // namespace weft::bench
