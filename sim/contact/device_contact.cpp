#include "sim/contact/device_contact.h"

#include <algorithm>

#include "gpu/gl_context.h"
#include "sim/base/parallel.h"
#include "sim/contact/device_candidates.h"

namespace weft::sim {

namespace {

Vec3 vector_of(const std::array<double, 3>& numbers) { return Vec3(numbers.data()); }
Mat3 matrix_of(const std::array<double, 9>& numbers) { return Mat3(numbers.data()); }

std::array<int, 4> points_of(const gpu::ContactCandidate& candidate) {
  std::array<int, 4> points;
  std::ranges::copy(candidate.points, points.begin());
  return points;
}

ContactPair pair_of(const gpu::ContactTerm& term, const gpu::ContactPush& push, int sliding,
                    const gpu::ContactCandidate& candidate) {
  return {.nodes = points_of(candidate),
          .weight = push.weight,
          .normal = vector_of(push.normal),
          .coefficient = static_cast<double>(term.coefficient()),
          .gap = push.gap,
          .energy = push.energy,
          .push = push.push,
          .stiffness = push.stiffness,
          .damping = push.damping,
          .sliding = sliding};
}

Sliding sliding_of(const gpu::ContactSliding& found) {
  Sliding sliding;
  std::ranges::transform(found.lever, sliding.lever.begin(), matrix_of);
  sliding.force = vector_of(found.force);
  sliding.slope = matrix_of(found.slope);
  return sliding;
}

MollifierForce mollifier_force_of(const gpu::ContactPush& push,
                                  const gpu::ContactCandidate& candidate) {
  const Vec3 first = vector_of(push.turn_first), second = vector_of(push.turn_second);
  return {points_of(candidate), {-first, first, -second, second}};
}

class OpenGlContact : public DeviceContact {
 public:
  OpenGlContact(const Scene& scene, std::shared_ptr<gpu::GlContext> context)
      : scene_(scene), context_(std::move(context)), device_(*context_) {}

  void set_candidates(std::span<const CandidateList> lists,
                      std::span<const bsi::SurfaceTerms> surfaces,
                      std::span<const Vec3> rest) override {
    list_ = device_candidates(scene_, lists, surfaces, rest);
    device_.set_candidates(list_.rows, list_.candidates);
  }

  std::optional<Touching> evaluate(std::span<const CandidateList> lists,
                                   const PairFriction& friction, const Motion& motion,
                                   Found& found) override {
    const auto groups = device_groups(scene_, lists, friction, motion.spin);
    const gpu::ContactResult result = device_.evaluate(groups, motion.position, motion.velocity);
    if (result.touching) {
      const std::uint32_t candidate = *result.touching;
      const auto next =
          std::ranges::upper_bound(list_.rows, candidate, {}, &gpu::ContactRow::first);
      const gpu::ContactGroup& group = groups[std::prev(next)->group];
      return Touching{points_of(list_.candidates[candidate]), group.edges, group.thickness};
    }
    take(result, found);
    return std::nullopt;
  }

 private:
  // Copies the terms, in their order. The places of friction terms are found first, so that threads
  // can share the copying.
  void take(const gpu::ContactResult& result, Found& found) {
    const std::size_t count = result.order.size();
    place_.resize(count);
    int sliding = 0;
    found.mollified.clear();
    for (std::size_t k = 0; k < count; ++k) {
      const gpu::ContactTerm& term = result.terms[result.order[k]];
      place_[k] = term.slides() ? sliding++ : -1;
      if (!term.is_mollified()) continue;
      found.mollified.push_back(
          mollifier_force_of(result.pushes[result.order[k]], list_.candidates[term.candidate]));
    }
    found.pairs.resize(count);
    found.sliding.resize(sliding);
    parallel_chunks(static_cast<int>(count), scene_.threads, [&](int begin, int end) {
      for (int k = begin; k < end; ++k) {
        const std::uint32_t i = result.order[k];
        const gpu::ContactTerm& term = result.terms[i];
        found.pairs[k] =
            pair_of(term, result.pushes[i], place_[k], list_.candidates[term.candidate]);
        if (place_[k] >= 0) found.sliding[place_[k]] = sliding_of(result.slidings[i]);
      }
    });
  }

  const Scene& scene_;
  std::shared_ptr<gpu::GlContext> context_;
  gpu::ComputeNarrowPhase device_;
  DeviceCandidates list_;
  std::vector<int> place_;  // by term in order: its number among the friction terms, or -1
};

}  // namespace

std::unique_ptr<DeviceContact> make_device_contact(const Scene& scene,
                                                   std::shared_ptr<gpu::GlContext> context) {
  return std::make_unique<OpenGlContact>(scene, std::move(context));
}

}  // namespace weft::sim
