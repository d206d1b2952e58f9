// The compiled case: the data of a simulation that stay constant during the run.
#pragma once

#include <algorithm>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bsi/geometry_image.h"
#include "bsi/shapes.h"
#include "sim/case/case.h"
#include "sim/scene/clamps.h"
#include "sim/scene/motion.h"
#include "sim/scene/seams.h"
#include "sim/scene/sewn_points.h"
#include "sim/scene/surface_map.h"
#include "sim/scene/ties.h"

namespace weft::sim {

class SplineSurface;
struct LoadPoint;
struct SlidingSupports;

// The surface of a body on which contact acts, for bodies whose surface points are not their
// particles. Each point is a weighted sum of the body's particles.
struct SampledSurface {
  // `particles_to_points` has one point per point of `image`, with local indices of the body's
  // particles. `rest` has the undeformed positions of the body's particles, m. Throws as
  // bsi::build_mesh().
  SampledSurface(bsi::Atlas image, SurfaceMap particles_to_points, std::span<const Vec3> rest);

  bsi::Atlas atlas;  // of points
  bsi::Mesh mesh;
  SurfaceMap map;
  std::vector<Vec3> rest;  // points of the undeformed shape, m
};

// A load of the case that acts on a body.
struct SurfaceLoad {
  int number = 0;  // index into Case::load
  std::shared_ptr<const std::vector<LoadPoint>> points;
};

// A body of the scene. Its particles are numbered from first_particle to first_particle +
// atlas.particle_count() - 1, its surface points from first_point on.
struct SceneBody {
  std::string name;
  bsi::Atlas atlas;
  bsi::Mesh mesh;          // indices local to the body; without contact, only triangles
  std::vector<Vec3> rest;  // the undeformed shape, in its own frame, m
  Vec3 velocity{0, 0, 0}, spin{0, 0, 0};            // at t = 0: m/s, rad/s about `centre`
  Vec3 centre{0, 0, 0};                             // m, mean of its particles at t = 0
  std::optional<SampledSurface> sampled;            // empty: surface points are particles
  std::shared_ptr<const SplineSurface> spline;      // null unless a shell
  std::shared_ptr<const SlidingSupports> supports;  // null: none
  std::vector<SurfaceLoad> loads;
  int first_particle = 0, first_point = 0;
  bool is_obstacle = false;  // the case lists it as an obstacle
  bool dynamic = true;       // false: an obstacle, or held as a whole
  bool moves = true;         // false: not dynamic and at rest
  bool sleeps = false;       // not dynamic until a body comes within reach (awake_scene.h)
  bool self_contact = false;
  double thickness = 0;   // m
  double warp_angle = 0;  // rad, of the warp to the rows of the image
  const MaterialCase* material =
      nullptr;  // points into Scene::source; null for obstacles of the case

  int particle_count() const { return atlas.particle_count(); }
  const bsi::Atlas& surface_atlas() const { return sampled ? sampled->atlas : atlas; }
  const bsi::Mesh& surface_mesh() const { return sampled ? sampled->mesh : mesh; }
  const std::vector<Vec3>& surface_rest() const { return sampled ? sampled->rest : rest; }
  int point_count() const { return surface_atlas().particle_count(); }
};

// Particles with one prescribed motion.
struct PrescribedMotion {
  RigidMotion motion;
  bool moves = true;                 // false: at rest
  std::vector<int> particles;        // global indices
  std::vector<Vec3> start;           // positions at t = 0, m
  double radius = 0;                 // m, largest distance of `start` from the centre
  std::vector<ClampedEdge> clamped;  // of the body that the particles belong to
  int pin = -1;                      // index of the pin in the list of its body; -1 for obstacles
};

// A pin of a body with timed pins: a pin that takes hold or lets go during the run, or another pin
// of the same body.
struct TimedPin {
  const PinCase* source;       // points into Scene::source
  int number;                  // index of the pin in the list of its body
  int body;                    // index into Scene::bodies
  std::vector<int> particles;  // global indices; all that the pin may hold
};

// Particles that a timed pin holds for some time.
struct TimedHold {
  int pin = 0;  // index into Scene::timed_pins
  std::vector<int> particles;
  std::vector<Vec3> start;  // m, places at t = 0; the motion carries them to the present ones
  std::vector<ClampedEdge> clamped;
  Vec3 centre{0, 0, 0};  // m, default centre of the motion: their mean when the pin took hold
};

// Bodies and obstacles with their particles. Particles are numbered consecutively: first those of
// dynamic bodies, then those of bodies held as a whole, then those of obstacles.
//
// A body is held as a whole if all its vertices are pinned, either at rest or by one motion. It
// then counts as an obstacle: it has no forces, no rows in matrices and no part in state vectors
// and energies. If all bodies are held as a whole, all stay dynamic.
//
// All pins of a body that has a timed one are timed. In the scene of a case, their particles are
// free. hold_timed_pins() (timed_pins.h) makes another scene for each time between two changes of
// pins; in it the pinned particles are held. Simulation integrates these scenes.
struct Scene {
  Case source;
  std::vector<SceneBody> bodies;  // dynamic ones, then held ones, then obstacles
  std::vector<int> case_order;    // indices into `bodies`, in the order of the case
  int dynamic_bodies = 0;
  int dynamic_particles = 0;
  int particle_count = 0;
  int dynamic_points = 0;  // surface points of dynamic bodies; numbered by body, like particles
  int point_count = 0;
  int threads = 1;  // of a run

  std::vector<Vec3> initial_position;  // m, all particles
  std::vector<double> mass;            // kg, dynamic particles
  SurfaceMap surface_map;              // from all particles to all surface points
  std::vector<double> contact_area;    // m^2 by point: areas_around(); empty without contact
  std::vector<char> pinned;            // dynamic particles: 1 if prescribed
  std::vector<PrescribedMotion> prescribed;
  std::vector<Tie> ties;
  std::vector<Seam> seams;
  SewnPoints sewn;                     // surface points that seams hold together
  std::vector<TimedPin> timed_pins;    // by body, in the order of the case
  std::vector<TimedHold> first_holds;  // of timed pins at t = 0
  double pins_change_at = std::numeric_limits<double>::infinity();  // s: a step ends there

  // Returns the velocity (m/s) of a free particle at t = 0.
  Vec3 initial_velocity(int particle) const;
  int held_bodies() const { return static_cast<int>(source.body.size()) - dynamic_bodies; }
  bool is_free(int particle) const { return particle < dynamic_particles && pinned[particle] == 0; }
  // Returns true if any particle of a surface point is free.
  bool is_free_point(int point) const {
    if (surface_map.is_identity()) return is_free(point);
    return std::ranges::any_of(surface_map.shares(point),
                               [&](const auto& share) { return is_free(share.particle); });
  }
  // The number of a body or obstacle in the order of the case.
  int case_index(int body) const;
  const SceneBody& body_of_particle(int particle) const;
  int body_index_of_particle(int particle) const;
  int body_index_of_point(int point) const;
  // Returns the particle with the largest weight in a surface point.
  int main_particle(int point) const;
  // Returns the place of a particle for messages: `body "sheet", row 3, column 7`, with the patch
  // if there are several.
  std::string describe_particle(int particle) const;
  // Returns the place of a surface point for messages; on a sampled surface it is `body "shell",
  // row 3, column 7 of its surface`.
  std::string describe_point(int point) const;
};

// Compiles a case: builds its shapes, masses, pins and motions. Precondition: time.accuracy is
// settled (sim/accuracy/accuracy_pilot.h). Throws CaseError at its place in the case for a shape
// file that cannot be read, triangles without area, or a pin that selects nothing. Also throws it
// if shapes from files need more memory than the limit.
std::unique_ptr<const Scene> build_scene(const Case& source);

}  // namespace weft::sim
