// Finds the contacts of spheres with each other and with obstacles.
#pragma once

#include <span>
#include <vector>

#include "sim/base/statistics.h"
#include "sim/particles/sphere_contact.h"
#include "sim/particles/sphere_grid.h"
#include "sim/particles/sphere_laws.h"
#include "sim/particles/sphere_surfaces.h"
#include "sim/particles/surface_candidates.h"

namespace weft::sim {

// The places of spheres and obstacles at the start of a step. Lists are by sphere or by surface.
struct SphereStart {
  std::span<const Vec3> position;  // m
  std::span<const Vec3> velocity,
      acceleration;                  // m/s and m/s^2; acceleration is that in free motion
  std::span<const RigidPose> poses;  // at the start of the step
  std::span<const RigidPose> ends;   // at its end, with the velocities during the step
  double length = 0;                 // s, length of the step
};

// Finds contacts among candidates, which are pairs of spheres and pairs of a sphere and a triangle.
// Candidates are found for spheres that are enlarged by an allowance, fast spheres by more than
// slow ones, and serve several steps: pairs of spheres until a sphere has used up its allowance,
// the triangles near a sphere until it has done so itself. Which contacts are found, and in which
// order, depends on the arguments alone and not on the age of the candidates.
class SphereSearch {
 public:
  // The scene, the surfaces and the laws must outlive the search.
  SphereSearch(const Scene& scene, const SphereSurfaces& surfaces, const SphereLaws& laws,
               Statistics& statistics);

  // Sets `contacts` to all contacts, sorted by key, that may close during the step. `reach` (m, by
  // sphere) bounds the free motion of a sphere and of obstacles. Two spheres are in contact if
  // their gap is at most `padding` (m) more than their relative free motion, a sphere and a
  // triangle if their gap is at most twice the reach of the sphere. Of the triangles, those are
  // left out whose closest point lies on an edge or vertex of another triangle that is closer: the
  // distance to the surface has no minimum there.
  void find_contacts(const SphereStart& start, std::span<const double> reach, double padding,
                     std::vector<SphereContact>& contacts);
  // Sets `overlaps` to the contacts, sorted by key, of spheres that overlap another sphere on their
  // straight paths to `end` (m), or a triangle once they are there. Gaps and normals are those at
  // the start. If `changed` is not empty, only contacts of spheres for which it is not 0 are
  // compared.
  void find_overlaps(const SphereStart& start, std::span<const Vec3> end,
                     std::span<const char> changed, std::vector<SphereContact>& overlaps);

  std::span<const double> radii() const { return radii_; }

 private:
  struct Closest {
    int triangle = 0;
    Vec3 normal{0, 0, 0};
    Vec3 point{0, 0, 0};  // m, on the triangle, in the frame of the surface at t = 0
    double gap = 0;
    std::array<double, 3> weight{};  // barycentric coordinates of the point
  };
  void cover_pairs(std::span<const Vec3> place, std::span<const double> reach);
  void cover_paths(std::span<const Vec3> start, std::span<const Vec3> end);
  bool pairs_hold(std::span<const Vec3> place, std::span<const double> reach) const;
  void cover_surface(int surface, int sphere, const Vec3& local, double need);
  Vec3 local(int surface, const RigidPose& pose, const Vec3& place) const;
  Closest closest(const ObstacleSurface& surface, int sphere, int triangle,
                  const Vec3& local) const;
  SphereContact sphere_contact(int a, int b, std::span<const Vec3> position) const;
  SphereContact surface_contact(int surface, int sphere, const Closest& closest,
                                const SphereStart& start) const;
  void add_surface_contacts(int surface, int sphere, const SphereStart& start, double reach,
                            std::vector<SphereContact>& contacts);
  void look_ahead(const SphereStart& start, std::span<SphereContact> contacts) const;
  void add_surface_overlaps(int surface, int sphere, const SphereStart& start, const Vec3& end,
                            std::vector<SphereContact>& overlaps);
  bool is_minimum(const ObstacleSurface& surface, int sphere, std::size_t candidate) const;

  const SphereSurfaces& surfaces_;
  const SphereLaws& laws_;
  Statistics& statistics_;
  std::vector<double> radii_;
  std::vector<int> group_;  // index into Scene::bodies, by sphere
  SphereGrid grid_;
  SpherePairs pairs_;
  std::vector<SurfaceCandidates> candidates_;  // by surface
  std::vector<Vec3> built_at_;     // m, places of the spheres where the pairs were found
  std::vector<double> allowance_;  // m, by sphere, when the pairs were found
  std::vector<double> reach_;      // m, by sphere, of the last call of find_contacts()
  std::vector<double> enlarged_;   // m, radii for the grid
  std::vector<double> way_;        // m, by sphere, from the start to the end of a path
  std::vector<Closest> near_;      // triangles near one sphere
};

}  // namespace weft::sim
