// Tests every pair of boxes: the oracle of all candidate sets.
#include "bench/peers/primitive_boxes.h"

namespace weft::bench {

namespace {

class BruteForce final : public Peer {
 public:
  explicit BruteForce(const PeerScene& scene) : boxes_(scene) {}

  bool rebuilds() const override { return false; }
  void rebuild() override {}
  void query(std::vector<LeafPair>& pairs) override {
    boxes_.update();
    const int first = static_cast<int>(boxes_.first().size());
    const int second = static_cast<int>(boxes_.second().size());
    for (int a = 0; a < first; ++a) {
      for (int b = boxes_.is_self() ? a + 1 : 0; b < second; ++b) {
        if (boxes_.is_candidate(a, b)) pairs.push_back({a, b});
      }
    }
  }

 private:
  SceneBoxes boxes_;
};

// Largest number of tests; 1e9 take two or three seconds.
constexpr double affordable_tests = 1.1e9;

std::unique_ptr<Peer> make(const PeerScene& scene) {
  const double first = static_cast<double>(scene.bodies.front().primitive_count());
  const double second = static_cast<double>(scene.bodies.back().primitive_count());
  if (first * second * (scene.is_self() ? 0.5 : 1) > affordable_tests) return nullptr;
  return std::make_unique<BruteForce>(scene);
}

}  // namespace

void add_brute_force(std::vector<PeerMaker>& makers) { makers.push_back({"brute-force", make}); }

}  // namespace weft::bench
