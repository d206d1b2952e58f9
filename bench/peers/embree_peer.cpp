// Embree 3: rtcCollide on user geometry, one primitive per triangle, one thread.
#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "bench/peers/primitive_boxes.h"

namespace weft::bench {

namespace {

enum class Build { morton, sah, refit };

void stop_on_error(void*, RTCError, const char* message) {
  std::fprintf(stderr, "Embree: %s\n", message);
  std::exit(1);
}

RTCDevice one_threaded_device() {
  static const RTCDevice device = [] {
    const RTCDevice made = rtcNewDevice("threads=1,set_affinity=0");
    rtcSetDeviceErrorFunction(made, stop_on_error, nullptr);
    return made;
  }();
  return device;
}

// One body as an Embree scene of one user geometry.
class Tree {
 public:
  Tree(const SceneBoxes& boxes, int body, Build build)
      : boxes_(&boxes),
        body_(&boxes.body(body)),
        scene_(rtcNewScene(one_threaded_device())),
        geometry_(rtcNewGeometry(one_threaded_device(), RTC_GEOMETRY_TYPE_USER)) {
    // A scene of low quality leaves the choice to the geometry. Its trees are faster here, both to
    // build and to query, than those of medium quality. Compact ones (4 children) are faster to
    // query unless made by Morton codes.
    rtcSetSceneFlags(scene_, build == Build::morton
                                 ? RTC_SCENE_FLAG_DYNAMIC
                                 : RTC_SCENE_FLAG_DYNAMIC | RTC_SCENE_FLAG_COMPACT);
    rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_LOW);
    rtcSetGeometryBuildQuality(geometry_, build == Build::morton ? RTC_BUILD_QUALITY_LOW
                                          : build == Build::sah  ? RTC_BUILD_QUALITY_MEDIUM
                                                                 : RTC_BUILD_QUALITY_REFIT);
    rtcSetGeometryUserPrimitiveCount(geometry_, static_cast<unsigned>(body_->size()));
    rtcSetGeometryUserData(geometry_, this);
    rtcSetGeometryBoundsFunction(geometry_, bounds, nullptr);
    rtcAttachGeometry(scene_, geometry_);
  }
  ~Tree() {
    rtcReleaseGeometry(geometry_);
    rtcReleaseScene(scene_);
  }
  Tree(const Tree&) = delete;
  Tree& operator=(const Tree&) = delete;

  void commit() {
    rtcCommitGeometry(geometry_);
    rtcCommitScene(scene_);
  }
  RTCScene scene() const { return scene_; }

 private:
  static void bounds(const RTCBoundsFunctionArguments* arguments) {
    const auto* tree = static_cast<const Tree*>(arguments->geometryUserPtr);
    const Box box = tree->boxes_->widened(*tree->body_, arguments->primID);
    RTCBounds& out = *arguments->bounds_o;
    out.lower_x = box.low[0], out.lower_y = box.low[1], out.lower_z = box.low[2];
    out.upper_x = box.high[0], out.upper_y = box.high[1], out.upper_z = box.high[2];
  }

  const SceneBoxes* boxes_;
  const PrimitiveBoxes* body_;
  RTCScene scene_;
  RTCGeometry geometry_;
};

class Embree final : public Peer {
 public:
  Embree(const PeerScene& scene, Build build) : boxes_(scene), build_(build) {
    for (int i = 0; i < boxes_.body_count(); ++i) {
      trees_.push_back(std::make_unique<Tree>(boxes_, i, build));
    }
  }

  bool rebuilds() const override { return build_ != Build::refit; }
  void rebuild() override {
    boxes_.update();
    for (const auto& tree : trees_) tree->commit();
  }
  bool refits() const override { return build_ == Build::refit; }
  void refit() override { rebuild(); }
  void query(std::vector<LeafPair>& pairs) override {
    pairs_ = &pairs;
    rtcCollide(trees_.front()->scene(), trees_.back()->scene(),
               boxes_.is_self() ? self_pairs : dual_pairs, this);
  }

 private:
  // A self query reports both orders of a pair.
  static void self_pairs(void* user, RTCCollision* found, unsigned count) {
    const auto* peer = static_cast<const Embree*>(user);
    for (unsigned i = 0; i < count; ++i) {
      const int a = static_cast<int>(found[i].primID0), b = static_cast<int>(found[i].primID1);
      if (a < b && peer->boxes_.is_candidate(a, b)) peer->pairs_->push_back({a, b});
    }
  }
  static void dual_pairs(void* user, RTCCollision* found, unsigned count) {
    const auto* peer = static_cast<const Embree*>(user);
    for (unsigned i = 0; i < count; ++i) {
      const int a = static_cast<int>(found[i].primID0), b = static_cast<int>(found[i].primID1);
      if (peer->boxes_.is_candidate(a, b)) peer->pairs_->push_back({a, b});
    }
  }

  SceneBoxes boxes_;
  Build build_;
  std::vector<std::unique_ptr<Tree>> trees_;
  std::vector<LeafPair>* pairs_ = nullptr;
};

// Queries the tree of a body by particles, one at a time: rtcPointQuery.
class EmbreePoints final : public Peer {
 public:
  EmbreePoints(const PeerScene& scene, Build build)
      : boxes_(scene), build_(build), tree_(boxes_, 1, build) {}

  bool rebuilds() const override { return build_ != Build::refit; }
  void rebuild() override {
    boxes_.update();
    tree_.commit();
  }
  bool refits() const override { return build_ == Build::refit; }
  void refit() override { rebuild(); }
  void query(std::vector<LeafPair>& pairs) override {
    pairs_ = &pairs;
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    for (std::size_t i = 0; i < boxes_.first().size(); ++i) {
      const Float4 centre = boxes_.first()[i].low;
      particle_ = static_cast<int>(i);
      // Queries a ball that contains the particle's widened box, rounding included.
      const float largest =
          std::max({std::abs(centre[0]), std::abs(centre[1]), std::abs(centre[2])});
      const float radius = 1.7321F * boxes_.half_margin() + 0x1p-21F * largest;
      RTCPointQuery query{centre[0], centre[1], centre[2], 0, radius};
      rtcPointQuery(tree_.scene(), &query, &context, near_particle, this);
    }
  }

 private:
  static bool near_particle(RTCPointQueryFunctionArguments* arguments) {
    const auto* peer = static_cast<const EmbreePoints*>(arguments->userPtr);
    const int triangle = static_cast<int>(arguments->primID);
    if (peer->boxes_.is_candidate(peer->particle_, triangle)) {
      peer->pairs_->push_back({peer->particle_, triangle});
    }
    return false;  // the radius stays
  }

  SceneBoxes boxes_;
  Build build_;
  Tree tree_;
  int particle_ = 0;
  std::vector<LeafPair>* pairs_ = nullptr;
};

template <Build build>
std::unique_ptr<Peer> make(const PeerScene& scene) {
  return std::make_unique<Embree>(scene, build);
}

template <Build build>
std::unique_ptr<Peer> make_points(const PeerScene& scene) {
  const bool fits =
      !scene.is_self() && scene.bodies[0].is_particles() && scene.bodies[0].end == nullptr;
  if (!fits) return nullptr;
  return std::make_unique<EmbreePoints>(scene, build);
}

}  // namespace

void add_embree(std::vector<PeerMaker>& makers) {
  makers.push_back({"embree-morton", make<Build::morton>});
  makers.push_back({"embree-sah", make<Build::sah>});
  makers.push_back({"embree-refit", make<Build::refit>});
  makers.push_back({"embree-sah-points", make_points<Build::sah>});
  makers.push_back({"embree-refit-points", make_points<Build::refit>});
}

}  // namespace weft::bench
