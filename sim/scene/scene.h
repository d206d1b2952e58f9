// The scene of a case: the data of a simulation that stay constant during the run.
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

// The surface on which contact acts, for a body whose surface points are not its particles. Each
// point is a weighted sum of particles of the body.
struct SampledSurface {
  // `particles_to_points` maps the body's particles (local indices) to the points of `image`.
  // `rest` has the undeformed positions of the body's particles, m. Throws as bsi::build_mesh().
  SampledSurface(bsi::Atlas image, SurfaceMap particles_to_points, std::span<const Vec3> rest);

  bsi::Atlas atlas;  // image of the points
  bsi::Mesh mesh;
  SurfaceMap map;
  std::vector<Vec3> rest;  // undeformed positions of the points, m
};

// A load of the case that acts on a body.
struct SurfaceLoad {
  int number = 0;  // index into Case::load
  std::shared_ptr<const std::vector<LoadPoint>> points;
};

// A body or obstacle of the scene. Its particles have the indices first_particle .. first_particle
// + particle_count() - 1. Its surface points have the indices first_point .. first_point +
// point_count() - 1.
struct SceneBody {
  std::string name;
  bsi::Atlas atlas;
  bsi::Mesh mesh;          // local indices; without contact, the mesh has no edges
  std::vector<Vec3> rest;  // undeformed positions of the particles, in the frame of the shape, m
  Vec3 velocity{0, 0, 0}, spin{0, 0, 0};  // at t = 0: m/s, and rad/s about `centre`
  Vec3 centre{0, 0, 0};                   // m, centre of mass of the particles at t = 0
  // Velocities (m/s) of the particles at t = 0, in place of `velocity` and `spin`; empty without a
  // restart.
  std::vector<Vec3> start_velocity;
  std::optional<SampledSurface> sampled;            // empty if the surface points are the particles
  std::shared_ptr<const SplineSurface> spline;      // null if the body is not a shell
  std::shared_ptr<const SlidingSupports> supports;  // null if no support holds the body
  std::vector<SurfaceLoad> loads;
  int first_particle = 0, first_point = 0;
  bool is_obstacle = false;  // true if the case lists the body as an obstacle
  bool dynamic = true;       // false for obstacles and for bodies held as a whole
  bool moves = true;         // false if the body is not dynamic and rests
  bool sleeps = false;       // true if the body sleeps and is therefore not dynamic (awake_scene.h)
  bool self_contact = false;
  double thickness = 0;   // m
  double warp_angle = 0;  // rad, angle from the rows of the image to the warp
  // Points into the source of the scene that build_scene() returned. Null for obstacles of the
  // case. Particles have a material without any stiffness or damping.
  const MaterialCase* material = nullptr;
  // Points likewise. Null unless the body is a group of particles, whose atlas has no quads.
  const ParticlesCase* spheres = nullptr;
  // True if the particles of the body are the spins of a group of spheres (sphere_groups.h).
  bool are_spins = false;

  int particle_count() const { return atlas.particle_count(); }
  const bsi::Atlas& surface_atlas() const { return sampled ? sampled->atlas : atlas; }
  const bsi::Mesh& surface_mesh() const { return sampled ? sampled->mesh : mesh; }
  const std::vector<Vec3>& surface_rest() const { return sampled ? sampled->rest : rest; }
  int point_count() const { return surface_atlas().particle_count(); }
};

// Particles of a body or obstacle that have a common prescribed motion.
struct PrescribedMotion {
  RigidMotion motion;
  bool moves = true;                 // false if the particles rest
  std::vector<int> particles;        // global indices
  std::vector<Vec3> start;           // positions at t = 0, m
  double radius = 0;                 // m, largest distance of `start` from the centre of the motion
  std::vector<ClampedEdge> clamped;  // edges that the pin clamps; empty for shells
  int pin = -1;                      // index of the pin in the list of its body; -1 for obstacles
};

// A pin of a body of which at least one pin takes hold or lets go during the run (timed_pins.h).
struct TimedPin {
  const PinCase* source;       // points into the source of the built scene
  int number;                  // index of the pin in the list of its body
  int body;                    // index into Scene::bodies
  std::vector<int> particles;  // global indices of all particles that the pin may hold
  std::vector<int> points;     // of these, the image points that the case names; local indices
};

// The particles that a timed pin holds between two changes of pins.
struct TimedHold {
  int pin = 0;  // index into Scene::timed_pins
  std::vector<int> particles;
  // Places (m) at t = 0. The motion of the pin maps them to the present places.
  std::vector<Vec3> start;
  std::vector<ClampedEdge> clamped;
  // Default centre (m) of the motion: the mean of the particles when the pin took hold.
  Vec3 centre{0, 0, 0};
};

// Bodies and obstacles with their particles. Particles are numbered consecutively: first the
// particles of dynamic bodies, then of bodies held as a whole, then of obstacles. A group of
// spheres ([[particles]]) is a dynamic body. Its particles are the centres of its spheres. Spheres
// that turn have their spins in a second body, which the case does not list and nothing can touch.
// These bodies are the last dynamic ones.
//
// A body is held as a whole if all its vertices are pinned, either at rest or by one motion, and no
// load of the case acts on it. It then counts as an obstacle: it has no forces, no rows in matrices
// and no part in state vectors and energies. If all bodies are held as a whole, all stay dynamic.
//
// All pins of a body that has a timed pin are timed. In the scene of build_scene(), the particles
// of timed pins are free. hold_timed_pins() (timed_pins.h) makes the scene between two changes of
// pins, in which timed pins hold their particles.
struct Scene {
  Case source;
  std::vector<SceneBody> bodies;  // first dynamic bodies, then held bodies, then obstacles
  // Indices into `bodies` in the order of the case: bodies, then obstacles, then groups of spheres.
  // Spins are left out.
  std::vector<int> case_order;
  int dynamic_bodies = 0;
  int dynamic_particles = 0;
  // Number of dynamic particles that have weight. Those that follow are spins.
  int heavy_particles = 0;
  int particle_count = 0;
  // Count of the surface points of dynamic bodies. These points have the lowest indices.
  int dynamic_points = 0;
  int point_count = 0;
  int threads = 1;  // number of threads of a run
  // True if spheres collide: TimeMethod::impulses with contact. The method finds its contacts
  // itself, so `source` has contact.enabled = false.
  bool spheres_collide = false;
  double impact_speed = 0;  // m/s: expected_impact_speed(); 0 without spheres

  std::vector<Vec3> initial_position;  // m, by particle
  std::vector<double> mass;          // kg, by dynamic particle; of a spin: the inertia by radius^2
  SurfaceMap surface_map;            // from all particles to all surface points
  std::vector<double> contact_area;  // m^2, by surface point: areas_around(); empty without contact
  std::vector<char> pinned;          // by dynamic particle: 1 if its motion is prescribed
  std::vector<PrescribedMotion> prescribed;
  std::vector<Tie> ties;
  std::vector<Seam> seams;
  SewnPoints sewn;                     // surface points that seams hold together
  std::vector<TimedPin> timed_pins;    // by body, in the order of the case
  std::vector<TimedHold> first_holds;  // holds of the timed pins at t = 0
  // Time (s) of the next change of timed pins. Set by hold_timed_pins() only.
  double pins_change_at = std::numeric_limits<double>::infinity();

  // Returns the velocity (m/s) of a free particle at t = 0.
  Vec3 initial_velocity(int particle) const;
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
  // Returns the place of a particle as text for messages: `body "sheet", row 3, column 7`. The text
  // names the patch if the body has several.
  std::string describe_particle(int particle) const;
  // Returns the place of a surface point as text for messages. On a sampled surface the text is
  // `body "shell", row 3, column 7 of its surface`.
  std::string describe_point(int point) const;
};

// Builds the scene of a case with its shapes, masses, pins, motions, loads and ties. Precondition:
// time.accuracy is settled (sim/accuracy/accuracy_pilot.h). Throws CaseError at the place of an
// error in the case, for example of a shape file that cannot be read, of triangles without area, or
// of a pin that selects nothing. Also throws CaseError if shapes from files need more memory than
// the limit.
std::unique_ptr<const Scene> build_scene(const Case& source);

}  // namespace weft::sim
