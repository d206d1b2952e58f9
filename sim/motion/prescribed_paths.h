// Checks whether prescribed paths of pins cross those of obstacles or of other pins.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <optional>
#include <vector>

#include "sim/contact/body_tree.h"
#include "sim/contact/rigid_obstacles.h"
#include "sim/contact/surface_contact.h"
#include "sim/scene/scene.h"

namespace weft::sim {

// Finds crossings that contact does not check. Contact ignores pairs of features whose vertices all
// follow prescribed paths, because no force can keep them apart. No choice of steps avoids a
// crossing of such paths.
class PrescribedPaths {
 public:
  // The scene must have contact and outlive the object. Cost: O(mesh).
  explicit PrescribedPaths(const Scene& scene);

  // Returns two features that may cross between the times `from` and `to` (s), or nothing if
  // provably none cross. Features that do not cross may come arbitrarily close. A shorter interval
  // has tighter bounds, and so fewer false alarms. Cost: a pass over the particles of moving
  // bodies, and for n prescribed features of bodies whose boxes overlap O(n log n) and one check
  // per pair of features whose boxes overlap.
  [[nodiscard]] std::optional<ContactFault> find_crossing(double from, double to);

 private:
  // The vertices, edges and triangles of a body that consist of prescribed points only. Each is
  // given by its surface points.
  struct Features {
    std::vector<int> vertices;
    std::vector<std::array<int, 2>> edges;
    std::vector<std::array<int, 3>> triangles;
    std::vector<int> motions;  // motions of these features, numbered as in motion_of_; sorted
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
  template <class First, class Second>
  std::optional<ContactFault> check_pair(bool edges, const First& one, const Second& other) const;
  int motion_of_point(int point, std::vector<int>& motions) const;
  double stray_of(int point) const;
  template <class Points>
  double largest_stray(const Points& points) const;
  template <class Points>
  Eigen::AlignedBox3d swept_box(const Points& points) const;
  bool is_rigid(const std::array<int, 4>& nodes) const;

  const Scene& scene_;
  // Motion of each particle. -1: free. 0: held at rest. m + 1: Scene::prescribed[m].
  std::vector<int> motion_of_particle_;
  // Motion of each surface point, numbered as in motion_of_particle_. -1 if at least one of its
  // particles is free, `several_motions_` if its particles follow different motions.
  std::vector<int> motion_of_;
  int several_motions_;
  std::vector<Features> features_;  // prescribed features of each body
  RigidObstacles obstacles_;
  std::vector<int> moving_;        // bodies with moving features that may cross others
  std::vector<char> is_placed_;    // for each body: 1 if its points are placed for the interval
  double from_ = 0, to_ = 0;       // ends of the current interval (s)
  BodyTree tree_;                  // boxes around the paths of the features of each body
  std::vector<double> stray_;      // MotionBounds::stray (m) of each motion in the current interval
  std::vector<Vec3> start_, end_;  // positions (m) of surface points at from_ and to_
  // Positions (m) of particles at from_ and to_; empty if surface points are particles.
  std::vector<Vec3> particle_start_, particle_end_;
  std::vector<Vec3> moved_, rates_;  // scratch
};

}  // namespace weft::sim
