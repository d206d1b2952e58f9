#include "sim/contact/pair_search.h"

#include <cassert>
#include <optional>

namespace weft::sim {

namespace {

class CpuSearch : public PairSearch {
 public:
  explicit CpuSearch(const Scene& scene) : scene_(scene), pyramids_(scene.bodies.size()) {}

  void rebuild(std::span<const BodyPath> paths) override {
    for (const BodyPath& path : paths) {
      std::optional<bsi::Pyramid>& pyramid = pyramids_[path.body];
      const SceneBody& body = scene_.bodies[path.body];
      if (!pyramid)
        pyramid.emplace(body.atlas, bsi::PyramidParts{.tangents = body.self_contact,
                                                      .spheres = bound() != bsi::Bound::box});
      const auto bad = path.is_swept() ? pyramid->rebuild_swept(path.start, path.end, threads())
                                       : pyramid->rebuild(path.end, threads());
      assert(!bad && "positions are finite");
      static_cast<void>(bad);
    }
  }

  void find(std::span<const PairQuery> queries, std::vector<std::vector<bsi::LeafPair>>& found,
            bsi::TraversalCounters& counters) override {
    found.resize(queries.size());
    for (std::size_t i = 0; i < queries.size(); ++i) {
      const PairQuery& query = queries[i];
      const bsi::TraversalOptions options{
          .margin = query.margin, .leaf = bsi::Leaf::quad, .bound = bound(), .threads = threads()};
      const bsi::Pyramid& a = *pyramids_[query.body_a];
      found[i].clear();
      if (query.body_a == query.body_b) {
        bsi::self_traversal(a, options, found[i], counters);
      } else {
        bsi::dual_traversal(a, *pyramids_[query.body_b], options, found[i], counters);
      }
    }
  }

 private:
  bsi::Bound bound() const { return scene_.source.contact.bound; }
  int threads() const { return scene_.threads; }

  const Scene& scene_;
  std::vector<std::optional<bsi::Pyramid>> pyramids_;  // made when first needed
};

}  // namespace

std::unique_ptr<PairSearch> make_cpu_search(const Scene& scene) {
  return std::make_unique<CpuSearch>(scene);
}

}  // namespace weft::sim
