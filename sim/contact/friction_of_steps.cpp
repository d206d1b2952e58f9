// Friction of linearised steps: Coulomb's law at their ends.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "sim/contact/contact.h"

namespace weft::sim {

namespace {

// Returns the number of pairs from the first one on that are terms of the same sample, or 1.
std::size_t terms_of_sample(std::span<const ContactPair> pairs) {
  if (pairs[0].surface < 0) return 1;
  const auto is_other = [&](const ContactPair& pair) {
    return pair.surface != pairs[0].surface || pair.nodes[0] != pairs[0].nodes[0];
  };
  return std::ranges::find_if(pairs, is_other) - pairs.begin();
}

// Returns w of a lever that is w times a projection on a plane.
double weight_of(const Mat3& lever) { return lever.norm() / std::numbers::sqrt2; }

}  // namespace

// Returns the limit of the friction of a sample's terms at the end of a step, as a part of that at
// its start. Linearised pushes of terms may be negative, but that of all of them may not. Returns
// nothing if the terms do not push at the start.
std::optional<double> Contact::limit_at_end(const LinearStep& step,
                                            std::span<const ContactPair> terms) const {
  double start = 0, end = 0;
  StencilRoom room;
  for (const ContactPair& pair : terms) {
    if (pair.sliding < 0) continue;
    const Sliding::Limit& limit = surface_.sliding(pair.sliding).limit;
    start += limit.now;
    end += limit.expected;
    const Stencil of = stencil(pair, room);
    for (std::size_t i = 0; i < of.particles.size(); ++i) {
      const int particle = of.particles[i];
      if (!is_dynamic(particle)) continue;
      end -= of.weights[i] * pair.normal.dot(limit.per_gap * step.displacement[particle] +
                                             limit.per_rate * step.change[particle]);
    }
  }
  if (!(start > 0)) return std::nullopt;
  return std::max(end, 0.0) / start;
}

// Adds the limit (N) of a pair's friction on each particle to `on_particle`.
void Contact::add_friction_limit(const ContactPair& pair, double limit,
                                 std::span<double> on_particle) const {
  StencilRoom room;
  const Stencil of = stencil(pair, room);
  for (std::size_t i = 0; i < of.particles.size(); ++i) {
    if (is_dynamic(of.particles[i]))
      on_particle[of.particles[i]] += weight_of(of.levers[i]) * limit;
  }
}

// Corrects the friction of one pair, whose limit is `part` of that at the start of the step.
// Without `part`, its sliding may end. Returns about by how much (m/s) its sliding velocity at the
// end of the step changes.
double Contact::follow_step(const LinearStep& step, const ContactPair& pair,
                            std::optional<double> part, std::span<const double> limit_on_particle,
                            std::span<Vec3> force) {
  Sliding& sliding = surface_.sliding(pair.sliding);
  const Vec3 before = sliding.force;
  SlidingEnd end{sliding.velocity, part.value_or(1) * sliding.limit.now, 0};
  double mobility = 0;
  StencilRoom room;
  const Stencil of = stencil(pair, room);
  for (std::size_t i = 0; i < of.particles.size(); ++i) {
    const int particle = of.particles[i];
    if (!is_dynamic(particle)) continue;
    end.velocity +=
        of.levers[i] * (step.change[particle] + sliding.hold_rate * step.displacement[particle]);
    if (scene_.pinned[particle] != 0) continue;
    const double weight = weight_of(of.levers[i]), rate = step.gamma / scene_.mass[particle];
    mobility += weight * weight * rate;
    end.slowing += weight * rate * std::max(limit_on_particle[particle], 0.0);
  }
  if (!part) end.slowing = std::numeric_limits<double>::infinity();
  end.velocity -= pair.normal.dot(end.velocity) * pair.normal;
  const double change =
      sim::follow_step(end, pair.normal, pair.coefficient < 0, surface_.friction_speed(), sliding);
  for (std::size_t i = 0; i < of.particles.size(); ++i) {
    if (is_dynamic(of.particles[i]))
      force[of.particles[i]] += of.levers[i].transpose() * (sliding.force - before);
  }
  const Vec3 along = end.velocity.normalized();
  const double slope = along.dot(sliding.slope * along);
  return mobility * change / (1 + mobility * slope);
}

double Contact::correct_friction(const LinearStep& step, std::span<Vec3> force) {
  std::vector<std::optional<double>> parts;  // by pair
  std::vector<double> limit_on_particle(force.size(), 0);
  for (auto rest = surface_.pairs(); !rest.empty();) {
    const auto terms = rest.first(terms_of_sample(rest));
    rest = rest.subspan(terms.size());
    const std::optional<double> part = limit_at_end(step, terms);
    for (const ContactPair& pair : terms) {
      parts.push_back(part);
      if (pair.sliding < 0) continue;
      const double limit = part.value_or(1) * surface_.sliding(pair.sliding).limit.now;
      add_friction_limit(pair, limit, limit_on_particle);
    }
  }
  double largest = 0;
  const std::span<const ContactPair> pairs = surface_.pairs();
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (pairs[i].sliding < 0) continue;
    largest = std::max(largest, follow_step(step, pairs[i], parts[i], limit_on_particle, force));
  }
  return largest;
}

}  // namespace weft::sim
