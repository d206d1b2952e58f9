#include "sim/contact/pair_search.h"

#include <cassert>
#include <optional>

#include "sim/contact/device_contact.h"

namespace weft::sim {

namespace {

// Returns the image of a body's pyramid. Each sphere of a group of particles is a patch of one
// quad, whose corners are its centre.
bsi::Atlas searched_atlas(const SceneBody& body) {
  if (body.spheres == nullptr) return body.surface_atlas();
  std::vector<int> centre_of_texel;
  for (int i = 0; i < body.particle_count(); ++i)
    centre_of_texel.insert(centre_of_texel.end(), 4, i);
  return bsi::Atlas(std::vector<bsi::Patch>(body.particle_count(), {.rows = 2, .cols = 2}),
                    std::move(centre_of_texel));
}

class CpuSearch : public PairSearch {
 public:
  explicit CpuSearch(const Scene& scene) : scene_(scene), bodies_(scene.bodies.size()) {}

  bool takes_frames() const override { return true; }

  int rebuild(std::span<const BodyPath> paths) override {
    int built = 0;
    for (const BodyPath& path : paths) {
      if (path.obstacle != nullptr) {
        built += place(path);
      } else {
        rebuild(path);
        ++built;
      }
    }
    return built;
  }

  void find(std::span<const PairQuery> queries, std::vector<std::vector<bsi::LeafPair>>& found,
            bsi::TraversalCounters& counters) override {
    found.resize(queries.size());
    for (std::size_t i = 0; i < queries.size(); ++i) {
      const PairQuery& query = queries[i];
      const bsi::TraversalOptions options{
          .margin = query.margin, .leaf = bsi::Leaf::quad, .bound = bound(), .threads = threads()};
      found[i].clear();
      if (query.body_a == query.body_b) {
        bsi::self_traversal(*bodies_[query.body_a].own_pyramid, options, found[i], counters);
        continue;
      }
      const bsi::Pyramid& a = *bodies_[query.body_a].pyramid;
      const Searched& b = bodies_[query.body_b];
      if (!b.frames.empty()) {
        bsi::dual_traversal(a, *b.rigid, b.frames, options, found[i], counters);
      } else {
        bsi::dual_traversal(a, *b.pyramid, options, found[i], counters);
      }
    }
  }

 private:
  // The pyramids of a body. Each is built when it is first needed.
  struct Searched {
    std::optional<bsi::Pyramid> pyramid, own_pyramid;
    std::optional<bsi::RigidPyramid> rigid;
    // Frames of the obstacle at the end of its path, or at both ends.
    std::vector<bsi::RigidFrame> frames;
  };

  void rebuild(const BodyPath& path) {
    const SceneBody& body = scene_.bodies[path.body];
    Searched& searched = bodies_[path.body];
    if (!path.own) searched.frames.clear();
    std::optional<bsi::Pyramid>& pyramid = path.own ? searched.own_pyramid : searched.pyramid;
    if (!pyramid)
      pyramid.emplace(searched_atlas(body),
                      bsi::PyramidParts{.tangents = path.own && body.spheres == nullptr,
                                        .spheres = bound() != bsi::Bound::box});
    const auto bad = path.is_swept() ? pyramid->rebuild_swept(path.start, path.end, threads())
                                     : pyramid->rebuild(path.end, threads());
    assert(!bad && "positions are finite");
    static_cast<void>(bad);
  }

  // Stores the frames of a rigid obstacle. Returns 1 if its pyramid had to be built, else 0.
  int place(const BodyPath& path) {
    Searched& searched = bodies_[path.body];
    const std::size_t ends = path.is_swept() ? 2 : 1;
    searched.frames.assign(path.frames.end() - ends, path.frames.end());
    if (searched.rigid) return 0;
    searched.rigid.emplace(scene_.bodies[path.body].surface_atlas(), path.obstacle->own_positions(),
                           bound() != bsi::Bound::box, threads());
    return 1;
  }

  bsi::Bound bound() const { return scene_.source.contact.bound; }
  int threads() const { return scene_.threads; }

  const Scene& scene_;
  std::vector<Searched> bodies_;
};

}  // namespace

std::unique_ptr<DeviceContact> PairSearch::make_device_contact() const { return nullptr; }

std::unique_ptr<PairSearch> make_cpu_search(const Scene& scene) {
  return std::make_unique<CpuSearch>(scene);
}

}  // namespace weft::sim
