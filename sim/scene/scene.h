// The compiled case: everything a simulation needs to know and never changes.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bsi/geometry_image.h"
#include "bsi/shapes.h"
#include "sim/case/case.h"
#include "sim/scene/motion.h"

namespace weft::sim {

// A body of the scene. Its particles are first_particle .. first_particle + atlas.particle_count()
// - 1.
struct SceneBody {
  std::string name;
  bsi::Atlas atlas;
  bsi::Mesh mesh;          // indices local to the body; without contact, triangles alone
  std::vector<Vec3> rest;  // the undeformed shape, in its own frame, m
  Vec3 velocity{0, 0, 0}, spin{0, 0, 0};  // at t = 0, dynamic ones: m/s of `centre`, rad/s
  Vec3 centre{0, 0, 0};                   // the mean of its particles then, m
  int first_particle = 0;
  bool is_obstacle = false;  // of the case
  bool dynamic = true;       // false: an obstacle, or a body that is held as a whole
  bool moves = true;         // false: one of these at rest
  bool self_contact = false;
  double thickness = 0;  // m
  const MaterialCase* material =
      nullptr;  // null of obstacles of the case; points into Scene::source

  int particle_count() const { return atlas.particle_count(); }
};

// Particles whose path is prescribed.
struct PrescribedMotion {
  RigidMotion motion;
  bool moves = true;
  std::vector<int> particles;  // global indices
  std::vector<Vec3> start;     // positions at t = 0, m
  double radius = 0;           // of these, about the centre of the motion, m
};

// Particles are numbered through: those of the dynamic bodies first, then those of bodies that are
// held as a whole and of obstacles.
//
// A body is held as a whole if all its vertices are pinned, at rest or by one motion. It is an
// obstacle then: it has no forces, no rows in matrices and no part in vectors and energies. Where
// no other body is left, bodies stay dynamic.
struct Scene {
  Case source;
  std::vector<SceneBody> bodies;  // dynamic ones, held ones, obstacles
  std::vector<int> case_order;    // bodies as the case lists them
  int dynamic_bodies = 0;
  int dynamic_particles = 0;
  int particle_count = 0;
  int threads = 1;  // of a run

  std::vector<Vec3> initial_position;  // m, all particles
  std::vector<double> mass;            // kg, dynamic particles
  std::vector<double>
      contact_area;  // m^2, a third of the triangles around each particle; all; with contact
  std::vector<char> pinned;  // dynamic particles: 1 where prescribed
  std::vector<PrescribedMotion> prescribed;

  // m/s, of a free particle.
  Vec3 initial_velocity(int particle) const;
  int held_bodies() const { return static_cast<int>(source.body.size()) - dynamic_bodies; }
  bool is_free(int particle) const { return particle < dynamic_particles && pinned[particle] == 0; }
  const SceneBody& body_of_particle(int particle) const;
  int body_index_of_particle(int particle) const;
  // "body 'sheet', row 3, column 7" (with the patch where there are several), for messages.
  std::string describe_particle(int particle) const;
};

// Builds shapes, masses, pins and motions. Precondition: time.accuracy is settled
// (sim/accuracy/accuracy_pilot.h). Throws CaseError, with the place in the case, for what
// only shows then: a shape file that cannot be read, a pin that selects nothing, triangles without
// area.
std::unique_ptr<const Scene> build_scene(const Case& source);

}  // namespace weft::sim
