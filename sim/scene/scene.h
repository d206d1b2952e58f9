// The compiled case: everything that a simulation needs to know and never changes.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bsi/geometry_image.h"
#include "bsi/shapes.h"
#include "sim/case/case.h"
#include "sim/scene/motion.h"

namespace weft::sim {

// A body of the scene. Its particles are numbered from first_particle to first_particle +
// atlas.particle_count() - 1.
struct SceneBody {
  std::string name;
  bsi::Atlas atlas;
  bsi::Mesh mesh;          // indices local to the body; without contact, only triangles
  std::vector<Vec3> rest;  // the undeformed shape, in its own frame, m
  Vec3 velocity{0, 0, 0}, spin{0, 0, 0};  // at t = 0: m/s, rad/s about `centre`
  Vec3 centre{0, 0, 0};                   // m, mean of its particles at t = 0
  int first_particle = 0;
  bool is_obstacle = false;  // the case lists it as an obstacle
  bool dynamic = true;       // false: an obstacle, or a body that is held as a whole
  bool moves = true;         // false: not dynamic, and at rest
  bool sleeps = false;       // not dynamic until something comes in reach (awake_scene.h)
  bool self_contact = false;
  double thickness = 0;  // m
  const MaterialCase* material =
      nullptr;  // points into Scene::source; null for obstacles of the case

  int particle_count() const { return atlas.particle_count(); }
};

// Particles whose motion is prescribed.
struct PrescribedMotion {
  RigidMotion motion;
  bool moves = true;
  std::vector<int> particles;  // global indices
  std::vector<Vec3> start;     // positions at t = 0, m
  double radius = 0;           // m, largest distance of `start` from the centre
};

// Bodies and obstacles with their particles. Particles are numbered through: first those of dynamic
// bodies, then those of bodies that are held as a whole, then those of obstacles.
//
// A body is held as a whole if all its vertices are pinned, either at rest or by one motion. It
// then counts as an obstacle: it has no forces, no rows in matrices and no part in state vectors
// and energies. If all bodies are held as a whole, all stay dynamic.
struct Scene {
  Case source;
  std::vector<SceneBody> bodies;  // dynamic ones, then held ones, then obstacles
  std::vector<int> case_order;    // indices into `bodies`, in the order of the case
  int dynamic_bodies = 0;
  int dynamic_particles = 0;
  int particle_count = 0;
  int threads = 1;  // of a run

  std::vector<Vec3> initial_position;  // m, all particles
  std::vector<double> mass;            // kg, dynamic particles
  std::vector<double> contact_area;    // m^2, a third of the triangles around a particle; all
                                       // particles; empty without contact
  std::vector<char> pinned;            // dynamic particles: 1 where prescribed
  std::vector<PrescribedMotion> prescribed;

  // Velocity (m/s) at t = 0 of a free particle.
  Vec3 initial_velocity(int particle) const;
  int held_bodies() const { return static_cast<int>(source.body.size()) - dynamic_bodies; }
  bool is_free(int particle) const { return particle < dynamic_particles && pinned[particle] == 0; }
  const SceneBody& body_of_particle(int particle) const;
  int body_index_of_particle(int particle) const;
  // `body "sheet", row 3, column 7`, with the patch if there are several, for messages.
  std::string describe_particle(int particle) const;
};

// Builds shapes, masses, pins and motions. Precondition: time.accuracy is settled
// (sim/accuracy/accuracy_pilot.h). Throws CaseError, at its place in the case, for a shape file
// that cannot be read, a pin that selects nothing, triangles without area, or a scene that shapes
// from files make too large.
std::unique_ptr<const Scene> build_scene(const Case& source);

}  // namespace weft::sim
