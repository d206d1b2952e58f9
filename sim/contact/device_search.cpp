#include "sim/contact/device_search.h"

#include <stdexcept>

#include "gpu/compute_traversal.h"
#include "gpu/gl_context.h"

namespace weft::sim {

namespace {

std::unique_ptr<gpu::GlContext> make_context(ComputeBackend backend) {
  if (backend == ComputeBackend::gpu) {
    return std::make_unique<gpu::GlContext>(gpu::GlBackend::hardware);
  }
  return std::make_unique<gpu::GlContext>(gpu::software_backend());
}

std::vector<const bsi::Atlas*> atlases_of(const Scene& scene) {
  std::vector<const bsi::Atlas*> atlases;
  for (const SceneBody& body : scene.bodies) atlases.push_back(&body.surface_atlas());
  return atlases;
}

class OpenGlSearch : public PairSearch {
 public:
  OpenGlSearch(const Scene& scene, ComputeBackend backend)
      : scene_(scene),
        context_(make_context(backend)),
        pyramids_(*context_, atlases_of(scene)),
        traversal_(pyramids_, scene.source.contact.bound) {}

  std::string device() const { return context_->device(); }

  // Obstacles that move are uploaded and rebuilt like all other bodies.
  int rebuild(std::span<const BodyPath> paths) override {
    std::vector<gpu::BodyImage> images;
    for (const BodyPath& path : paths) {
      gpu::BodyImage image{.body = path.body, .start = path.start};
      if (path.is_swept()) image.end = path.end;
      image.tangents = scene_.bodies[path.body].self_contact;
      image.spheres = scene_.source.contact.bound != bsi::Bound::box;
      images.push_back(image);
    }
    if (!images.empty()) pyramids_.rebuild(images);
    return static_cast<int>(images.size());
  }

  // Boxes are not counted on the device.
  void find(std::span<const PairQuery> queries, std::vector<std::vector<bsi::LeafPair>>& found,
            bsi::TraversalCounters&) override {
    std::vector<gpu::PairQuery> asked;
    for (const PairQuery& query : queries) {
      asked.push_back({query.body_a, query.body_b, query.margin, true, true});
    }
    found.resize(queries.size());
    for (auto& pairs : found) pairs.clear();
    for (const auto& [query, a, b] : traversal_.find_pairs(asked, bsi::Leaf::quad)) {
      found[query].push_back({static_cast<int>(a), static_cast<int>(b)});
    }
  }

 private:
  const Scene& scene_;
  std::unique_ptr<gpu::GlContext> context_;
  gpu::ComputePyramid pyramids_;
  gpu::ComputeTraversal traversal_;
};

}  // namespace

DeviceSearch make_device_search(const Scene& scene, ComputeBackend backend) {
  auto search = std::make_unique<OpenGlSearch>(scene, backend);
  std::string device = search->device();
  return {std::move(search), std::move(device)};
}

bool may_have_graphics_processor() { return gpu::may_have_graphics_processor(); }

}  // namespace weft::sim
