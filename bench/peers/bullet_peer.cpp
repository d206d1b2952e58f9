// Bullet: its trees for triangle meshes (btOptimizedBvh, plain and quantised) and for moving boxes
// (btDbvt).
#include <BulletCollision/BroadphaseCollision/btDbvt.h>
#include <BulletCollision/CollisionShapes/btOptimizedBvh.h>
#include <BulletCollision/CollisionShapes/btTriangleIndexVertexArray.h>

#include "bench/peers/primitive_boxes.h"

namespace weft::bench {

namespace {

btVector3 point(Float4 p) { return {p[0], p[1], p[2]}; }

Box bounds_of(const PrimitiveBoxes& boxes) {
  Box all = boxes[0];
  for (const Box& box : boxes.boxes()) {
    all.low = all.low < box.low ? all.low : box.low;
    all.high = all.high > box.high ? all.high : box.high;
  }
  return all;
}

// btOptimizedBvh: Bullet takes primitive i as the triangle (low, high, high) of box i. It has no
// query of tree against tree, so there is one query per primitive.
template <bool quantized>
class MeshTree final : public Peer {
 public:
  explicit MeshTree(const PeerScene& scene) : boxes_(scene) {
    for (std::size_t i = 0; i < boxes_.second().size(); ++i) {
      const int low = static_cast<int>(2 * i);
      corners_.push_back({low, low + 1, low + 1});
    }
    btIndexedMesh mesh;
    mesh.m_numTriangles = static_cast<int>(corners_.size());
    mesh.m_triangleIndexBase = reinterpret_cast<const unsigned char*>(corners_.data());
    mesh.m_triangleIndexStride = sizeof corners_[0];
    mesh.m_numVertices = 2 * mesh.m_numTriangles;
    mesh.m_vertexBase = reinterpret_cast<const unsigned char*>(boxes_.second().boxes().data());
    mesh.m_vertexStride = sizeof(Float4);
    mesh_.addIndexedMesh(mesh);
  }

  void rebuild() override {
    boxes_.update();
    const auto [low, high] = outer_box();
    tree_ = std::make_unique<btOptimizedBvh>();
    tree_->build(&mesh_, quantized, low, high);
  }
  bool refits() const override { return quantized; }  // Bullet does not refit the other kind
  void refit() override {
    boxes_.update();
    const auto [low, high] = outer_box();
    tree_->refit(&mesh_, low, high);
  }
  void query(std::vector<LeafPair>& pairs) override {
    Collector collector(boxes_, pairs);
    for (std::size_t i = 0; i < boxes_.first().size(); ++i) {
      collector.first = static_cast<int>(i);
      // The boxes of the tree are not widened, so this one is widened by twice as much and a
      // rounding.
      const Box once = boxes_.widened(boxes_.first(), i);
      const Float4 more = lanes(boxes_.half_margin() * (1 + 0x1p-10F));
      const Box box{once.low - more, once.high + more};
      tree_->reportAabbOverlappingNodex(&collector, point(box.low), point(box.high));
    }
  }

 private:
  struct Collector final : btNodeOverlapCallback {
    Collector(const SceneBoxes& b, std::vector<LeafPair>& p) : boxes(&b), pairs(&p) {}
    void processNode(int, int second) override {
      if (boxes->is_self() && first >= second) return;
      if (boxes->is_candidate(first, second)) pairs->push_back({first, second});
    }
    const SceneBoxes* boxes;
    std::vector<LeafPair>* pairs;
    int first = 0;
  };

  // Returns the box to which queries are clamped; it holds the whole body.
  std::array<btVector3, 2> outer_box() const {
    const Box box = bounds_of(boxes_.second());
    const float more = 4 * boxes_.half_margin();
    const btVector3 margin(more, more, more);
    return {point(box.low) - margin, point(box.high) + margin};
  }

  SceneBoxes boxes_;
  std::vector<std::array<int, 3>> corners_;
  btTriangleIndexVertexArray mesh_;
  std::unique_ptr<btOptimizedBvh> tree_;
};

// btDbvt, as Bullet's soft bodies use it: built from the top down, refitted from the bottom up,
// queried tree against tree.
class DynamicTree final : public Peer {
 public:
  explicit DynamicTree(const PeerScene& scene)
      : boxes_(scene),
        trees_(static_cast<std::size_t>(boxes_.body_count())),
        leaves_(static_cast<std::size_t>(boxes_.body_count())) {}

  // Makes the leaves one by one at first. Later rebuilds keep the leaves and rebuild the tree above
  // them, which is a hundred times faster.
  void rebuild() override {
    boxes_.update();
    for (int body = 0; body < boxes_.body_count(); ++body) {
      btDbvt& tree = trees_[body];
      if (tree.empty()) insert_leaves(body);
      for (btDbvtNode* leaf : leaves_[body]) leaf->volume = volume(body, leaf->dataAsInt);
      tree.optimizeTopDown();
    }
  }
  bool refits() const override { return true; }
  void refit() override {
    boxes_.update();
    for (int body = 0; body < boxes_.body_count(); ++body) refit(body, trees_[body].m_root);
  }
  void query(std::vector<LeafPair>& pairs) override {
    Collector collector(boxes_, pairs);
    if (boxes_.is_self()) {
      trees_[0].selfCollideTT(trees_[0].m_root, collector);
    } else {
      trees_[0].collideTT(trees_[0].m_root, trees_[1].m_root, collector);
    }
  }

 private:
  struct Collector final : btDbvt::ICollide {
    Collector(const SceneBoxes& b, std::vector<LeafPair>& p) : boxes(&b), pairs(&p) {}
    void Process(const btDbvtNode* a, const btDbvtNode* b) override {
      boxes->append_unordered(a->dataAsInt, b->dataAsInt, *pairs);
    }
    const SceneBoxes* boxes;
    std::vector<LeafPair>* pairs;
  };

  void insert_leaves(int body) {
    for (int i = 0; i < static_cast<int>(boxes_.body(body).size()); ++i) {
      btDbvtNode* leaf = trees_[body].insert(volume(body, i), nullptr);
      leaf->dataAsInt = i;
      leaves_[body].push_back(leaf);
    }
  }
  btDbvtVolume volume(int body, int primitive) const {
    const Box box = boxes_.widened(boxes_.body(body), static_cast<std::size_t>(primitive));
    return btDbvtVolume::FromMM(point(box.low), point(box.high));
  }
  void refit(int body, btDbvtNode* node) const {
    if (node->isleaf()) {
      node->volume = volume(body, node->dataAsInt);
      return;
    }
    refit(body, node->childs[0]);
    refit(body, node->childs[1]);
    Merge(node->childs[0]->volume, node->childs[1]->volume, node->volume);
  }

  SceneBoxes boxes_;
  std::vector<btDbvt> trees_;
  std::vector<std::vector<btDbvtNode*>> leaves_;
};

template <class Tree>
std::unique_ptr<Peer> make(const PeerScene& scene) {
  return std::make_unique<Tree>(scene);
}

}  // namespace

void add_bullet(std::vector<PeerMaker>& makers) {
  makers.push_back({"bullet-bvh", make<MeshTree<false>>});
  makers.push_back({"bullet-bvh-quantized", make<MeshTree<true>>});
  makers.push_back({"bullet-dbvt", make<DynamicTree>});
}

}  // namespace weft::bench
