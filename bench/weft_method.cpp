#include "bench/weft_method.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "bench/triangle_test.h"
#include "bsi/narrow_phase.h"
#include "bsi/traversal.h"

namespace weft::bench {

namespace {

// Returns the magnitude of a body, as in Pyramid::magnitude.
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
  std::vector<bsi::Pyramid> of_body;      // none for particles
  std::vector<bsi::LeafBlockPair> found;  // by the last query
};

WeftMethod::WeftMethod(const CollisionScene& scene, const WeftVariant& variant)
    : scene_(scene), variant_(variant), pyramids_(std::make_unique<Pyramids>()) {
  for (const Body& body : scene.bodies) {
    if (!body.is_particles())
      pyramids_->of_body.emplace_back(
          body.atlas, bsi::PyramidParts{.tangents = scene_.is_self(),
                                        .spheres = variant.bound != bsi::Bound::box});
  }
}

WeftMethod::~WeftMethod() = default;

void WeftMethod::rebuild() {
  std::size_t next = 0;
  for (const Body& body : scene_.bodies) {
    if (body.is_particles()) continue;
    bsi::Pyramid& pyramid = pyramids_->of_body[next++];
    if (body.is_swept() ? pyramid.rebuild_swept(body.start, body.end, variant_.threads)
                        : pyramid.rebuild(body.start, variant_.threads)) {
      std::fprintf(stderr, "%s: a position is not finite\n", scene_.name.c_str());
      std::exit(1);
    }
  }
}

void WeftMethod::query(std::vector<LeafPair>& pairs) {
  const bsi::TraversalOptions options{.margin = scene_.margin,
                                      .leaf = bsi::Leaf::triangle,
                                      .bound = variant_.bound,
                                      .certificate = variant_.certificate,
                                      .threads = variant_.threads};
  bsi::TraversalCounters counters;
  const std::vector<bsi::Pyramid>& of_body = pyramids_->of_body;
  std::vector<bsi::LeafBlockPair>& found = pyramids_->found;
  found.clear();
  if (scene_.is_self()) {
    bsi::self_traversal(of_body.front(), options, found, counters);
  } else if (scene_.bodies.front().is_particles()) {
    bsi::single_traversal(of_body.front(), scene_.bodies.front().start, 0, options, pairs,
                          counters);
  } else {
    bsi::dual_traversal(of_body.front(), of_body.back(), options, found, counters);
  }
  if (variant_.listed) list(pairs);
}

void WeftMethod::list(std::vector<LeafPair>& pairs) {
  const std::vector<bsi::Pyramid>& of_body = pyramids_->of_body;
  const std::vector<bsi::LeafBlockPair>& found = pyramids_->found;
  if (scene_.is_self()) {
    bsi::append_pairs(of_body.front(), bsi::Leaf::triangle, found, variant_.threads, pairs);
  } else {
    bsi::append_pairs(of_body.front(), of_body.back(), bsi::Leaf::triangle, found, variant_.threads,
                      pairs);
  }
}

long WeftMethod::hits(std::span<const LeafPair> pairs, double distance) {
  const Body &first = scene_.bodies.front(), &second = scene_.bodies.back();
  if (first.is_particles() || variant_.listed) return weft_hits(scene_, pairs, variant_.threads);
  bsi::TriangleHits hits;
  bsi::NarrowPhaseCounters counters;
  const bsi::PyramidTriangles a{pyramids_->of_body.front(), {first.start, first.triangles}};
  const bsi::PyramidTriangles b{pyramids_->of_body.back(), {second.start, second.triangles}};
  const bsi::NarrowPhaseOptions options{distance, false, variant_.threads};
  if (scene_.is_self()) {
    bsi::find_triangle_hits(a, pyramids_->found, options, hits, counters);
  } else {
    bsi::find_triangle_hits(a, b, pyramids_->found, options, hits, counters);
  }
  return static_cast<long>(hits.pairs.size());
}

std::size_t WeftMethod::bytes() const {
  std::size_t sum = 0;
  for (const bsi::Pyramid& pyramid : pyramids_->of_body) sum += pyramid.bytes();
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
