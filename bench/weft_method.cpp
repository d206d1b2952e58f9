#include "bench/weft_method.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "bench/triangle_test.h"
#include "bsi/narrow_phase.h"
#include "bsi/traversal.h"

namespace weft::bench {

namespace {

// As BoxPyramid::magnitude.
float magnitude_of(const Body& body) {
  float largest = 0;
  for (const auto* positions : {&body.start, &body.end}) {
    for (const bsi::Vec3& p : *positions)
      largest = std::max(largest, p.cast<float>().cwiseAbs().maxCoeff());
  }
  return largest;
}

float rounded_up(double value) {
  const auto rounded = static_cast<float>(value);
  return static_cast<double>(rounded) >= value ? rounded : std::nextafter(rounded, HUGE_VALF);
}

}  // namespace

PeerScene mesh_view(const CollisionScene& scene) {
  PeerScene view;
  for (const Body& body : scene.bodies) {
    view.bodies.push_back({body.triangles, body.start.size(), body.start.front().data(),
                           body.is_swept() ? body.end.front().data() : nullptr});
  }
  const Body &first = scene.bodies.front(), &second = scene.bodies.back();
  if (!first.is_particles()) {
    view.half_margin = bsi::half_margin(scene.margin, magnitude_of(first), magnitude_of(second));
    return view;
  }
  for (const bsi::Vec3& particle : first.start) {
    view.particle_half_margins.push_back(bsi::half_margin(
        scene.margin, magnitude_of(second), rounded_up(particle.cwiseAbs().maxCoeff())));
  }
  view.half_margin =
      *std::max_element(view.particle_half_margins.begin(), view.particle_half_margins.end());
  return view;
}

struct WeftMethod::Pyramids {
  std::vector<bsi::BoxPyramid> of_body;  // none for particles
};

WeftMethod::WeftMethod(const CollisionScene& scene, bool certificate, int threads)
    : scene_(scene),
      certificate_(certificate),
      threads_(threads),
      pyramids_(std::make_unique<Pyramids>()) {
  for (const Body& body : scene.bodies) {
    if (!body.is_particles()) pyramids_->of_body.emplace_back(body.atlas, scene_.is_self());
  }
}

WeftMethod::~WeftMethod() = default;

void WeftMethod::rebuild() {
  std::size_t next = 0;
  for (const Body& body : scene_.bodies) {
    if (body.is_particles()) continue;
    bsi::BoxPyramid& pyramid = pyramids_->of_body[next++];
    if (body.is_swept() ? pyramid.rebuild_swept(body.start, body.end, threads_)
                        : pyramid.rebuild(body.start, threads_)) {
      std::fprintf(stderr, "%s: a position is not finite\n", scene_.name.c_str());
      std::exit(1);
    }
  }
}

void WeftMethod::query(std::vector<LeafPair>& pairs) {
  const bsi::TraversalOptions options{.margin = scene_.margin,
                                      .leaf = bsi::Leaf::triangle,
                                      .certificate = certificate_,
                                      .threads = threads_};
  bsi::TraversalCounters counters;
  const std::vector<bsi::BoxPyramid>& of_body = pyramids_->of_body;
  if (scene_.is_self()) {
    bsi::self_traversal(of_body.front(), options, pairs, counters);
  } else if (scene_.bodies.front().is_particles()) {
    bsi::single_traversal(of_body.front(), scene_.bodies.front().start, 0, options, pairs,
                          counters);
  } else {
    bsi::dual_traversal(of_body.front(), of_body.back(), options, pairs, counters);
  }
}

std::size_t WeftMethod::bytes() const {
  std::size_t sum = 0;
  for (const bsi::BoxPyramid& pyramid : pyramids_->of_body) sum += pyramid.bytes();
  return sum;
}

long weft_hits(const CollisionScene& scene, std::span<const LeafPair> pairs, int threads) {
  const Body &first = scene.bodies.front(), &second = scene.bodies.back();
  if (first.is_particles()) {
    return count_hits({first.start, {}}, {second.start, second.triangles}, pairs, scene.margin);
  }
  bsi::TriangleHits hits;
  bsi::NarrowPhaseCounters counters;
  bsi::find_triangle_hits({first.start, first.triangles}, {second.start, second.triangles}, pairs,
                          {.margin = scene.margin, .distances = false, .threads = threads}, hits,
                          counters);
  return static_cast<long>(hits.pairs.size());
}

}  // namespace weft::bench
