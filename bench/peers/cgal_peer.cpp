// CGAL: AABB_tree, queried box by box, and box_intersection_d, which builds its tree during the
// query.
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/box_intersection_d.h>
#include <CGAL/property_map.h>

#include <algorithm>
#include <numeric>

#include "bench/peers/primitive_boxes.h"

namespace weft::bench {

namespace {

using Kernel = CGAL::Simple_cartesian<double>;

CGAL::Bbox_3 bounds(const Box& box) {
  return {box.low[0], box.low[1], box.low[2], box.high[0], box.high[1], box.high[2]};
}

// A box in a tree; its place in the array is the number of its primitive.
struct BoxPrimitive {
  using Id = const Box*;
  using Point = Kernel::Point_3;
  using Point_reference = Point;
  using Datum = Kernel::Iso_cuboid_3;
  using Datum_reference = Datum;

  BoxPrimitive() = default;
  explicit BoxPrimitive(Id id) : id_(id) {}
  Id id() const { return id_; }
  Datum datum() const { return Datum(bounds(*id_)); }
  Point reference_point() const {
    const Float4 sum = id_->low + id_->high;
    return {sum[0], sum[1], sum[2]};
  }

 private:
  Id id_ = nullptr;
};

struct BoundsOfBox {
  using key_type = const Box*;
  using value_type = CGAL::Bbox_3;
  using reference = value_type;
  using category = boost::readable_property_map_tag;
  friend value_type get(const BoundsOfBox&, key_type box) { return bounds(*box); }
};

using TreeTraits = CGAL::AABB_traits<Kernel, BoxPrimitive, BoundsOfBox>;
using Tree = CGAL::AABB_tree<TreeTraits>;

class BoxTree final : public Peer {
 public:
  explicit BoxTree(const PeerScene& scene) : boxes_(scene) {}

  void rebuild() override {
    boxes_.update();
    tree_.clear();
    for (const Box& box : boxes_.second().boxes()) tree_.insert(BoxPrimitive(&box));
    tree_.build();
  }
  void query(std::vector<LeafPair>& pairs) override {
    Collector collector{&boxes_, &pairs, 0};
    for (std::size_t i = 0; i < boxes_.first().size(); ++i) {
      collector.first = static_cast<int>(i);
      // The boxes of the tree are not widened, so this one is widened by twice as much and a
      // rounding.
      const Box once = boxes_.widened(boxes_.first(), i);
      const Float4 more = lanes(boxes_.half_margin() * (1 + 0x1p-10F));
      tree_.traversal(bounds({once.low - more, once.high + more}), collector);
    }
  }

 private:
  struct Collector {
    bool go_further() const { return true; }
    bool do_intersect(const CGAL::Bbox_3& box, const CGAL::AABB_node<TreeTraits>& node) const {
      return CGAL::do_overlap(box, node.bbox());
    }
    void intersection(const CGAL::Bbox_3&, const BoxPrimitive& primitive) const {
      const int second = static_cast<int>(primitive.id() - boxes->second().boxes().data());
      if (boxes->is_self() && first >= second) return;
      if (boxes->is_candidate(first, second)) pairs->push_back({first, second});
    }
    const SceneBoxes* boxes;
    std::vector<LeafPair>* pairs;
    int first;
  };

  SceneBoxes boxes_;
  Tree tree_;
};

struct NumberedBox {
  std::array<float, 3> low, high;
  int number;
};

struct NumberedBoxTraits {
  using NT = float;
  using ID = int;
  using Box_parameter = const NumberedBox&;
  static int dimension() { return 3; }
  static ID id(Box_parameter box) { return box.number; }
  static NT min_coord(Box_parameter box, int axis) { return box.low[axis]; }
  static NT max_coord(Box_parameter box, int axis) { return box.high[axis]; }
};

// Does all its work in the query: no hierarchy outlives it.
class BoxIntersection final : public Peer {
 public:
  explicit BoxIntersection(const PeerScene& scene)
      : boxes_(scene), numbered_(static_cast<std::size_t>(boxes_.body_count())) {
    for (int body = 0; body < boxes_.body_count(); ++body) {
      numbered_[body].resize(boxes_.body(body).size());
    }
  }

  bool rebuilds() const override { return false; }
  void rebuild() override {}
  void query(std::vector<LeafPair>& pairs) override {
    boxes_.update();
    for (int body = 0; body < boxes_.body_count(); ++body) fill(body);
    const auto collect = [&](const NumberedBox& a, const NumberedBox& b) {
      boxes_.append_unordered(a.number, b.number, pairs);
    };
    // This cutoff is about the fastest of 10, 40, 160, ... 2560 on every scene.
    constexpr std::ptrdiff_t cutoff = 1280;
    if (boxes_.is_self()) {
      CGAL::box_self_intersection_d(numbered_[0].begin(), numbered_[0].end(), collect,
                                    NumberedBoxTraits(), cutoff);
    } else {
      CGAL::box_intersection_d(numbered_[0].begin(), numbered_[0].end(), numbered_[1].begin(),
                               numbered_[1].end(), collect, NumberedBoxTraits(), cutoff);
    }
  }

 private:
  void fill(int body) {
    for (std::size_t i = 0; i < numbered_[body].size(); ++i) {
      const Box box = boxes_.widened(boxes_.body(body), i);
      numbered_[body][i] = {{box.low[0], box.low[1], box.low[2]},
                            {box.high[0], box.high[1], box.high[2]},
                            static_cast<int>(i)};
    }
  }

  SceneBoxes boxes_;
  std::vector<std::vector<NumberedBox>> numbered_;
};

template <class Method>
std::unique_ptr<Peer> make(const PeerScene& scene) {
  return std::make_unique<Method>(scene);
}

}  // namespace

void add_cgal(std::vector<PeerMaker>& makers) {
  makers.push_back({"cgal-tree", make<BoxTree>});
  makers.push_back({"cgal-box-intersection", make<BoxIntersection>});
}

}  // namespace weft::bench
