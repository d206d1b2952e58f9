// FCL: BVHModel of axis-aligned boxes, its own traversal, and its own distance of triangles.
#include <fcl/math/bv/AABB.h>
#include <fcl/math/bv/utility.h>  // before BVH_model.h, which needs it
// A line keeps the two in this order.
#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/narrowphase/detail/primitive_shape_algorithm/triangle_distance.h>
#include <fcl/narrowphase/detail/traversal/collision/bvh_collision_traversal_node.h>
#include <fcl/narrowphase/detail/traversal/collision_node.h>

#include <algorithm>

#include "bench/peers/primitive_boxes.h"

namespace weft::bench {

namespace {

using Model = fcl::BVHModel<fcl::AABB<double>>;
using Point = fcl::Vector3<double>;

// Returns the margin for the tree's boxes, which hold positions before these are rounded.
double margin_of_double_boxes(const SceneBoxes& boxes) {
  Float4 largest{};
  for (int body = 0; body < boxes.body_count(); ++body) {
    for (const Box& box : boxes.body(body).boxes()) {
      const Float4 size = -box.low > box.high ? -box.low : box.high;
      largest = size > largest ? size : largest;
    }
  }
  return 2 * boxes.half_margin() * (1 + 0x1p-20) +
         0x1p-21 * std::max({largest[0], largest[1], largest[2]});
}

// FCL's traversal of two trees. Only the test of a pair of nodes is overridden, to add the margin.
class Traversal final : public fcl::detail::BVHCollisionTraversalNode<fcl::AABB<double>> {
 public:
  Traversal(const SceneBoxes& boxes, const Model& first, const Model& second, double margin,
            std::vector<LeafPair>& pairs)
      : boxes_(&boxes), margin_(margin), pairs_(&pairs) {
    model1 = &first;
    model2 = &second;
  }
  bool BVTesting(int b1, int b2) const override {  // true: apart
    const fcl::AABB<double>& a = model1->getBV(b1).bv;
    const fcl::AABB<double>& b = model2->getBV(b2).bv;
    for (int axis = 0; axis < 3; ++axis) {
      if (a.min_[axis] - b.max_[axis] > margin_ || b.min_[axis] - a.max_[axis] > margin_) {
        return true;
      }
    }
    return false;
  }
  void leafTesting(int b1, int b2) const override {
    boxes_->append_unordered(model1->getBV(b1).primitiveId(), model2->getBV(b2).primitiveId(),
                             *pairs_);
  }
  bool canStop() const override { return false; }

 private:
  const SceneBoxes* boxes_;
  double margin_;
  std::vector<LeafPair>* pairs_;
};

class Fcl final : public Peer {
 public:
  explicit Fcl(const PeerScene& scene) : boxes_(scene), bodies_(scene.bodies) {
    for (const PeerBody& body : bodies_) {
      models_.push_back(std::make_unique<Model>());
      points_.emplace_back(body.point_count);
      std::vector<fcl::Triangle> triangles;
      for (const auto& [a, b, c] : body.triangles) {
        triangles.emplace_back(static_cast<std::size_t>(a), static_cast<std::size_t>(b),
                               static_cast<std::size_t>(c));
      }
      // A particle is a triangle of three equal corners.
      for (std::size_t i = 0; body.is_particles() && i < body.point_count; ++i) {
        triangles.emplace_back(i, i, i);
      }
      load(body.start, points_.back());
      Model& model = *models_.back();
      model.beginModel(static_cast<int>(triangles.size()), static_cast<int>(body.point_count));
      model.addSubModel(points_.back(), triangles);
      model.endModel();
    }
  }

  void rebuild() override { take_positions(false); }
  bool refits() const override { return true; }
  void refit() override { take_positions(true); }
  void query(std::vector<LeafPair>& pairs) override {
    Traversal traversal(boxes_, *models_.front(), *models_.back(), margin_, pairs);
    if (boxes_.is_self()) {
      fcl::detail::selfCollide<double>(&traversal);
    } else {
      fcl::detail::collide<double>(&traversal);
    }
  }
  long hits(std::span<const LeafPair> pairs, double distance) override {
    if (bodies_.front().is_particles() || bodies_.front().end != nullptr) return -1;
    long count = 0;
    for (const auto& [a, b] : pairs) {
      std::array<Point, 3> first, second;
      corners(0, a, first);
      corners(static_cast<int>(bodies_.size()) - 1, b, second);
      Point on_first, on_second;
      const double found = fcl::detail::TriangleDistance<double>::triDistance(
          first.data(), second.data(), on_first, on_second);
      if (found <= distance) ++count;
    }
    return count;
  }

 private:
  static void load(const double* from, std::vector<Point>& points) {
    for (std::size_t i = 0; i < points.size(); ++i) {
      points[i] = Point(from[3 * i], from[3 * i + 1], from[3 * i + 2]);
    }
  }
  void corners(int body, int triangle, std::array<Point, 3>& corner) const {
    const auto& indices = bodies_[body].triangles[triangle];
    for (int k = 0; k < 3; ++k) {
      const double* p = bodies_[body].start + 3 * static_cast<std::size_t>(indices[k]);
      corner[k] = Point(p[0], p[1], p[2]);
    }
  }
  void take_positions(bool refit_only) {
    boxes_.update();
    margin_ = margin_of_double_boxes(boxes_);
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      Model& model = *models_[i];
      load(bodies_[i].start, points_[i]);
      if (bodies_[i].end == nullptr) {
        model.beginReplaceModel();
        model.replaceSubModel(points_[i]);
        model.endReplaceModel(refit_only, true);
        continue;
      }
      // The boxes of an updated model also hold its previous positions.
      std::copy(points_[i].begin(), points_[i].end(), model.vertices);
      load(bodies_[i].end, points_[i]);
      model.beginUpdateModel();
      model.updateSubModel(points_[i]);
      model.endUpdateModel(refit_only, true);
    }
  }

  SceneBoxes boxes_;
  std::vector<PeerBody> bodies_;
  std::vector<std::unique_ptr<Model>> models_;
  std::vector<std::vector<Point>> points_;
  double margin_ = 0;
};

std::unique_ptr<Peer> make(const PeerScene& scene) { return std::make_unique<Fcl>(scene); }

}  // namespace

void add_fcl(std::vector<PeerMaker>& makers) { makers.push_back({"fcl", make}); }

}  // namespace weft::bench
