// Finds the contacts of spheres with each other and with obstacles.
#pragma once

#include <span>
#include <vector>

#include "bsi/sphere_hierarchy.h"
#include "sim/base/statistics.h"
#include "sim/particles/sphere_contact.h"
#include "sim/particles/sphere_laws.h"
#include "sim/particles/sphere_surfaces.h"

namespace weft::sim {

// The places of spheres and obstacles at the start of a step.
struct SphereStart {
  std::span<const Vec3> position;    // m, by sphere
  std::span<const RigidPose> poses;  // by surface, at the start of the step
  std::span<const RigidPose> ends;   // by surface, at its end
  double length = 0;                 // s, length of the step
};

// Finds contacts among candidates, which are pairs of spheres and pairs of a sphere and a triangle.
// Candidates are found by a hierarchy over the spheres and by the pyramids of the obstacles, for
// spheres that are enlarged by an allowance: fast spheres by more than slow ones. They stay valid
// until a sphere has used up its allowance. Which contacts are found, and in which order, depends
// on the positions and the reaches alone.
class SphereSearch {
 public:
  // The scene, the surfaces and the laws must outlive the search.
  SphereSearch(const Scene& scene, const SphereSurfaces& surfaces, const SphereLaws& laws,
               Statistics& statistics);

  // Makes the candidates complete for contacts whose gaps are at most the sum of the reaches of two
  // spheres, or twice the reach of a sphere at a triangle. `reach` (m) has one entry per sphere.
  // Returns true if it has found the candidates anew.
  bool prepare(const SphereStart& start, std::span<const double> reach);
  // Returns all contacts whose gaps are at most the sum of the reaches of both sides (m), sorted by
  // key. `reach` has one entry per sphere, and obstacles reach as far as they move. Of the
  // triangles, those are left out whose closest point lies on an edge or vertex of another triangle
  // that is closer: the distance to the surface has no minimum there. Precondition: prepare() for
  // these reaches. An empty `reach` finds no contacts, but prepares find_overlaps().
  std::vector<SphereContact> find_contacts(const SphereStart& start, std::span<const double> reach);
  // Returns the contacts, sorted by key, of spheres that overlap another sphere or a triangle once
  // they have moved to `end` (m). Gaps and normals are those at the start. Preconditions: prepare()
  // for reaches that are no less than the displacements, and find_contacts() at this start.
  std::vector<SphereContact> find_overlaps(const SphereStart& start, std::span<const Vec3> end);

  std::span<const double> radii() const { return radii_; }

 private:
  struct Touch {
    int surface = 0, sphere = 0, triangle = 0;
    auto operator<=>(const Touch&) const = default;  // NOLINT(modernize-use-nullptr)
  };
  struct Closest {
    Vec3 normal{0, 0, 0};
    Vec3 point{0, 0, 0};  // m, on the triangle, in the frame of the surface at t = 0
    double gap = 0;
    std::array<double, 3> weight{};  // barycentric coordinates of the point
  };
  bool covers(const SphereStart& start, std::span<const double> reach) const;
  void rebuild(const SphereStart& start, std::span<const double> reach);
  void find_surface_candidates(int surface, std::span<const Vec3> local);
  Closest closest(const Touch& touch, const Vec3& local) const;
  SphereContact sphere_contact(const bsi::LeafPair& pair, std::span<const Vec3> position) const;
  SphereContact surface_contact(const Touch& touch, const Closest& closest,
                                const SphereStart& start) const;
  void find_closest(const SphereStart& start);
  void add_surface_contacts(const SphereStart& start, std::span<const double> reach,
                            std::vector<SphereContact>& contacts) const;
  bool is_minimum(std::size_t candidate, std::size_t first, std::size_t end) const;

  const SphereSurfaces& surfaces_;
  const SphereLaws& laws_;
  Statistics& statistics_;
  int threads_;
  std::vector<double> radii_;
  std::vector<int> group_;  // index into Scene::bodies, by sphere
  bsi::SphereHierarchy hierarchy_;
  std::vector<bsi::LeafPair> pairs_;
  std::vector<Touch> touches_;
  std::vector<Closest> closest_;                // by touch, at the start of the step
  std::vector<Vec3> built_at_;                  // positions of the spheres at the last rebuild
  std::vector<std::vector<Vec3>> built_local_;  // likewise in the frame of each surface
  std::vector<double> allowance_;               // m, by sphere, at the last rebuild
};

}  // namespace weft::sim
