// Friction of linearised steps: Coulomb's law at their ends.
#include <algorithm>
#include <cmath>
#include <limits>

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

}  // namespace

// Linearised pushes of terms may be negative, but the limit of all of them may not.
Contact::EndLimit Contact::limit_at_end(const LinearStep& step,
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
  if (!(start > 0)) return {std::numeric_limits<double>::infinity(), 1};
  end = std::max(end, 0.0);
  return {end, end / start};
}

// Corrects the friction of one pair. Returns about by how much (m/s) its sliding velocity at the
// end of the step changes.
double Contact::follow_step(const LinearStep& step, const ContactPair& pair, const EndLimit& limit,
                            std::span<Vec3> force) {
  Sliding& sliding = surface_.sliding(pair.sliding);
  const Vec3 before = sliding.force;
  Vec3 velocity = sliding.velocity;
  double mobility = 0;
  StencilRoom room;
  const Stencil of = stencil(pair, room);
  for (std::size_t i = 0; i < of.particles.size(); ++i) {
    const int particle = of.particles[i];
    if (!is_dynamic(particle)) continue;
    velocity +=
        of.levers[i] * (step.change[particle] + sliding.hold_rate * step.displacement[particle]);
    // The lever of a weight w is w times a projection on a plane.
    if (scene_.pinned[particle] == 0)
      mobility += of.levers[i].squaredNorm() / (2 * scene_.mass[particle]);
  }
  velocity -= pair.normal.dot(velocity) * pair.normal;
  const SlidingEnd end{velocity, limit.ratio * sliding.limit.now,
                       step.gamma * mobility * limit.sum};
  const double change =
      sim::follow_step(end, pair.normal, pair.coefficient < 0, surface_.friction_speed(), sliding);
  for (std::size_t i = 0; i < of.particles.size(); ++i) {
    if (is_dynamic(of.particles[i]))
      force[of.particles[i]] += of.levers[i].transpose() * (sliding.force - before);
  }
  const Vec3 along = velocity.normalized();
  const double slope = along.dot(sliding.slope * along);
  return step.gamma * mobility * change / (1 + step.gamma * mobility * slope);
}

double Contact::correct_friction(const LinearStep& step, std::span<Vec3> force) {
  double largest = 0;
  for (auto rest = surface_.pairs(); !rest.empty();) {
    const auto terms = rest.first(terms_of_sample(rest));
    rest = rest.subspan(terms.size());
    const EndLimit limit = limit_at_end(step, terms);
    for (const ContactPair& pair : terms) {
      if (pair.sliding >= 0) largest = std::max(largest, follow_step(step, pair, limit, force));
    }
  }
  return largest;
}

}  // namespace weft::sim
