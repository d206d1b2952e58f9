#include <istream>
#include <limits>
#include <ostream>

#include "bench/peers/cloth_peer.h"

namespace weft::bench {

namespace {

using Points = std::vector<std::array<double, 3>>;

std::ostream& exact(std::ostream& stream) {
  stream.precision(std::numeric_limits<double>::max_digits10);
  return stream;
}

void write(std::ostream& stream, const Points& points) {
  for (const auto& p : points) stream << p[0] << ' ' << p[1] << ' ' << p[2] << '\n';
}

void read(std::istream& stream, std::size_t count, Points& points) {
  for (std::array<double, 3> p; points.size() < count && stream >> p[0] >> p[1] >> p[2];)
    points.push_back(p);
}

}  // namespace

std::ostream& operator<<(std::ostream& stream, const ClothSettings& settings) {
  return exact(stream) << settings.method << ' ' << settings.step << ' ' << settings.steps << ' '
                       << settings.iterations << ' ' << settings.tolerance << ' '
                       << settings.line_search << ' ' << settings.budget << '\n';
}

std::istream& operator>>(std::istream& stream, ClothSettings& settings) {
  return stream >> settings.method >> settings.step >> settings.steps >> settings.iterations >>
         settings.tolerance >> settings.line_search >> settings.budget;
}

std::ostream& operator<<(std::ostream& stream, const ClothProblem& problem) {
  exact(stream) << problem.mass.size() << ' ' << problem.springs.size() << '\n';
  write(stream, {problem.gravity});
  write(stream, problem.position);
  write(stream, problem.velocity);
  for (const double mass : problem.mass) stream << mass << '\n';
  for (const ClothSpring& spring : problem.springs) {
    stream << spring.ends[0] << ' ' << spring.ends[1] << ' ' << spring.rest_length << ' '
           << spring.stiffness << '\n';
  }
  const ClothBall& ball = problem.ball;
  write(stream, {ball.centre});
  return stream << ball.radius << ' ' << ball.gap << ' ' << ball.friction << '\n';
}

std::istream& operator>>(std::istream& stream, ClothProblem& problem) {
  std::size_t masses = 0, springs = 0;
  auto& g = problem.gravity;
  stream >> masses >> springs >> g[0] >> g[1] >> g[2];
  read(stream, masses, problem.position);
  read(stream, masses, problem.velocity);
  for (double mass = 0; problem.mass.size() < masses && stream >> mass;)
    problem.mass.push_back(mass);
  for (ClothSpring spring;
       problem.springs.size() < springs &&
       stream >> spring.ends[0] >> spring.ends[1] >> spring.rest_length >> spring.stiffness;) {
    problem.springs.push_back(spring);
  }
  auto& [centre, radius, gap, friction] = problem.ball;
  stream >> centre[0] >> centre[1] >> centre[2] >> radius >> gap >> friction;
  return stream;
}

// Writes a line with the failure, which may be empty, and then the values.
std::ostream& operator<<(std::ostream& stream, const ClothOutcome& outcome) {
  exact(stream) << outcome.failure << '\n' << outcome.cpu << ' ' << outcome.position.size() << '\n';
  write(stream, outcome.position);
  return stream;
}

std::istream& operator>>(std::istream& stream, ClothOutcome& outcome) {
  std::size_t count = 0;
  std::getline(stream, outcome.failure);
  stream >> outcome.cpu >> count;
  read(stream, count, outcome.position);
  return stream;
}

}  // namespace weft::bench
