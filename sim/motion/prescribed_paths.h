// Pins against obstacles, and against other pins: whether their prescribed paths cross.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <optional>
#include <vector>

#include "sim/contact/body_tree.h"
#include "sim/contact/contact.h"
#include "sim/contact/rigid_obstacles.h"
#include "sim/scene/scene.h"

namespace weft::sim {

// Contact leaves out features all of whose vertices follow prescribed paths, since no force could
// part them. Where such paths cross there is no state without a crossing, so that the run must end.
class PrescribedPaths {
 public:
  // O(mesh). The scene must outlive it and have contact.
  explicit PrescribedPaths(const Scene& scene);

  // Two features that are not certain to keep from passing through each other within the interval,
  // if any; the shorter the interval, the better the bounds. No distance is demanded. Costs a pass
  // over the particles of bodies that move, and a look at every pair of their prescribed features
  // and of those near them whose boxes meet.
  [[nodiscard]] std::optional<ContactFault> find_crossing(double from, double to);

 private:
  // Prescribed features of a body, by global particles.
  struct Features {
    std::vector<int> vertices;
    std::vector<std::array<int, 2>> edges;
    std::vector<std::array<int, 3>> triangles;
    std::vector<int> motions;  // that hold them: numbers of `motions_`
  };
  bool moves(int body, double from, double to) const;
  bool may_cross(const BodyPair& pair) const;
  std::vector<BodyPair> pairs_that_move(double from, double to);
  void place(int body);
  Eigen::AlignedBox3d box_of_paths(int body);
  std::optional<ContactFault> check(const BodyPair& pair);
  template <class First, class Second>
  std::optional<ContactFault> check_kind(bool edges, const std::vector<First>& first,
                                         const std::vector<Second>& second) const;
  template <class Particles>
  double largest_stray(const Particles& particles) const;
  template <class Particles>
  Eigen::AlignedBox3d swept_box(const Particles& particles) const;
  bool is_rigid(const std::array<int, 4>& nodes) const;

  const Scene& scene_;
  std::vector<int> motion_of_;      // by particle; -1: free, 0: at rest
  std::vector<Features> features_;  // by body
  RigidObstacles obstacles_;
  std::vector<int> moving_;          // bodies that have features with a motion and may cross others
  std::vector<char> is_placed_;      // by body, within the interval in hand
  double from_ = 0, to_ = 0;         // s, that interval
  BodyTree tree_;                    // of the boxes of the features' paths
  std::vector<double> stray_;        // m, by motion, within the interval in hand
  std::vector<Vec3> start_, end_;    // m, by particle
  std::vector<Vec3> moved_, rates_;  // scratch
};

}  // namespace weft::sim
