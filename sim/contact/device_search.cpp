#include "sim/contact/device_search.h"

#include <algorithm>
#include <stdexcept>

#include "gpu/compute_traversal.h"
#include "gpu/gl_context.h"
#include "sim/contact/device_contact.h"

namespace weft::sim {

namespace {

std::shared_ptr<gpu::GlContext> make_context(ComputeBackend backend) {
  if (backend == ComputeBackend::gpu) {
    return std::make_shared<gpu::GlContext>(gpu::GlBackend::hardware);
  }
  return std::make_shared<gpu::GlContext>(gpu::software_backend());
}

// Returns the images on the device: those of all bodies, for queries of two bodies, and then those
// for queries of bodies with themselves, whose indices are own_images[body].
std::vector<const bsi::Atlas*> atlases_of(const Scene& scene, std::vector<int>& own_images) {
  std::vector<const bsi::Atlas*> atlases;
  for (const SceneBody& body : scene.bodies) atlases.push_back(&body.surface_atlas());
  own_images.assign(scene.bodies.size(), -1);
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    if (!scene.bodies[b].self_contact) continue;
    own_images[b] = static_cast<int>(atlases.size());
    atlases.push_back(atlases[b]);
  }
  return atlases;
}

class OpenGlSearch : public PairSearch {
 public:
  OpenGlSearch(const Scene& scene, ComputeBackend backend)
      : scene_(scene),
        context_(make_context(backend)),
        pyramids_(*context_, atlases_of(scene, own_images_)),
        traversal_(pyramids_, scene.source.contact.bound),
        is_rigid_(scene.bodies.size(), 0) {
    const auto moves = [](const SceneBody& body) { return !body.dynamic && body.moves; };
    if (std::ranges::any_of(scene.bodies, moves)) beside_rigid_ = make_cpu_search(scene);
  }

  std::string device() const { return context_->device(); }
  bool takes_frames() const override { return true; }
  std::unique_ptr<DeviceContact> make_device_contact() const override {
    if (context_->backend() != gpu::GlBackend::hardware) return nullptr;
    return sim::make_device_contact(scene_, context_);
  }

  // Rebuilds pyramids on the device and, for pairs with moving rigid obstacles, on the CPU. A body
  // with a pyramid on both processors counts once in the result.
  int rebuild(std::span<const BodyPath> paths) override {
    std::vector<gpu::BodyImage> images;
    std::vector<BodyPath> rigid, others;
    for (const BodyPath& path : paths) {
      if (!path.own) is_rigid_[path.body] = static_cast<char>(path.obstacle != nullptr);
      (path.obstacle != nullptr ? rigid : others).push_back(path);
      if (path.obstacle == nullptr) images.push_back(image_of(path));
    }
    if (!images.empty()) pyramids_.rebuild(images);
    int built = static_cast<int>(images.size());
    if (!beside_rigid_) return built;
    std::erase_if(others, [&](const BodyPath& path) {
      return path.own || !scene_.bodies[path.body].dynamic;
    });
    beside_rigid_->rebuild(others);
    return built + beside_rigid_->rebuild(rigid);
  }

  // Finds quad pairs. Boxes that the device compares are not counted.
  void find(std::span<const PairQuery> queries, std::vector<std::vector<bsi::LeafPair>>& found,
            bsi::TraversalCounters& counters) override {
    std::vector<gpu::PairQuery> asked;
    std::vector<PairQuery> rigid;
    // The indices in `queries` of the entries of `asked` and of `rigid`.
    std::vector<std::size_t> asked_place, rigid_place;
    for (std::size_t i = 0; i < queries.size(); ++i) {
      const PairQuery& query = queries[i];
      if (is_rigid_[query.body_b] != 0) {
        rigid.push_back(query);
        rigid_place.push_back(i);
      } else {
        const bool own = query.body_a == query.body_b;
        asked.push_back(
            {image_of(query.body_a, own), image_of(query.body_b, own), query.margin, true, true});
        asked_place.push_back(i);
      }
    }
    found.resize(queries.size());
    for (auto& pairs : found) pairs.clear();
    if (!asked.empty()) {
      for (const auto& [query, a, b] : traversal_.find_pairs(asked, bsi::Leaf::quad))
        found[asked_place[query]].push_back({static_cast<int>(a), static_cast<int>(b)});
    }
    if (rigid.empty()) return;
    beside_rigid_->find(rigid, found_beside_rigid_, counters);
    for (std::size_t i = 0; i < rigid.size(); ++i)
      found[rigid_place[i]].swap(found_beside_rigid_[i]);
  }

 private:
  int image_of(int body, bool own) const { return own ? own_images_[body] : body; }

  gpu::BodyImage image_of(const BodyPath& path) const {
    gpu::BodyImage image{.body = image_of(path.body, path.own), .start = path.start};
    if (path.is_swept()) image.end = path.end;
    image.tangents = path.own;
    image.spheres = scene_.source.contact.bound != bsi::Bound::box;
    return image;
  }

  const Scene& scene_;
  std::vector<int> own_images_;  // by body: its image for queries with itself; -1 without
  std::shared_ptr<gpu::GlContext> context_;  // shared with the results of make_device_contact()
  gpu::ComputePyramid pyramids_;
  gpu::ComputeTraversal traversal_;
  std::vector<char> is_rigid_;  // by body: nonzero if its last path was that of a rigid obstacle
  // The search on the CPU, for pairs with a moving rigid obstacle. Null if no obstacle moves. On
  // the CPU, the pyramid of such an obstacle stays valid in its own frame. The device would need
  // all vertices of the obstacle at every rebuild.
  std::unique_ptr<PairSearch> beside_rigid_;
  std::vector<std::vector<bsi::LeafPair>> found_beside_rigid_;
};

}  // namespace

DeviceSearch make_device_search(const Scene& scene, ComputeBackend backend) {
  auto search = std::make_unique<OpenGlSearch>(scene, backend);
  std::string device = search->device();
  return {std::move(search), std::move(device)};
}

bool may_have_graphics_processor() { return gpu::may_have_graphics_processor(); }

}  // namespace weft::sim
