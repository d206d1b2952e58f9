// A case file as data: one struct per table. The files *_schema.cpp describe each member that has a
// key once: key, unit, limits and meaning. The parser, the JSON schema and the reference page use
// these descriptions.
#pragma once

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bsi/leaf_pair.h"
#include "sim/base/vectors.h"
#include "sim/case/varying.h"

namespace weft::sim {

// A place in a case file, for messages. Line 0 marks a place without a line, such as a whole file,
// an override (--set) or a preset.
struct SourceLocation {
  std::string file;
  int line = 0;
  int column = 0;
};

// The text of a string in a case or sweep file, with the places of its bytes for messages
// (sim/case/located_text.h).
struct LocatedText {
  struct Place {
    int line = 0, column = 0;
  };
  std::string text;
  SourceLocation location;  // place of the string: of its opening quote, or of an override
  // Places of all bytes of the text, and of its end. Empty if only `location` is known.
  std::vector<Place> places = {};

  // Returns the place of a byte, or `location` if the places of bytes are unknown. Precondition:
  // byte <= text.size().
  SourceLocation at(std::size_t byte) const {
    if (places.empty()) return location;
    return {location.file, places[byte].line, places[byte].column};
  }
};

// The time integration methods. time_methods.cpp lists their properties.
enum class TimeMethod { cvode, arkode, euler, static_loads, implicit_midpoint, verlet, impulses };
enum class PreconditionerChoice { automatic, block_jacobi, multigrid };

struct TimeCase {
  TimeMethod method = TimeMethod::cvode;
  double duration = 1.0;            // s, > 0
  double frames_per_second = 60.0;  // 1/s, > 0
  double scale = 1;                 // simulated seconds per second of a movie, > 0
  std::optional<double> accuracy;   // m; error to aim for, from which tolerance or step follow
  // m; position error allowed per step or, with fixed steps of an implicit method, in the solution
  // of the equations of a step.
  double position_tolerance = 1e-5;
  std::optional<double> velocity_tolerance;  // m/s; default 100 /s * position_tolerance
  double relative_tolerance = 1e-4;  // further error of the velocity per step, divided by the speed
  std::optional<double> step;        // s; length of fixed steps
  // Newton iterations per step; 0: until they converge. Contact may add iterations if a pin or an
  // obstacle moves.
  int newton = 0;
  int maximum_order = 2;               // highest order of the BDF method, 1..5
  double minimum_step = 1e-7;          // s; shortest step
  std::optional<double> maximum_step;  // s; longest step
  PreconditionerChoice preconditioner = PreconditionerChoice::automatic;
  bool sleep = true;  // lets bodies that have come to rest sleep until something touches them
};

// The course of the loads from one equilibrium to the next (static.loading).
enum class Loading { proportional, in_time, arc_length };
// The action where no equilibrium follows near the last one (static.at_limit_point).
enum class AtLimitPoint { stop, jump };

// The table [static], which is used with time.method = "static".
struct StaticCase {
  Loading loading = Loading::proportional;
  AtLimitPoint at_limit_point = AtLimitPoint::stop;
  bool scale_gravity = false;          // multiplies gravity by the load factor
  double first_load_factor = 0.1;      // load factor predicted for the first point of the path
  std::optional<double> largest_step;  // m; RMS displacement from one point to the next
  std::optional<double> largest_load_factor;   // > 0; load factor at which the path ends
  std::optional<double> largest_displacement;  // m; a vertex displaced this far ends the path
};

struct WorldCase {
  Varying<Vec3> gravity = Vec3(0, 0, -9.81);  // m/s^2
  Varying<Vec3> wind = Vec3(0, 0, 0);         // m/s
  Varying<double> air_density = 1.2;          // kg/m^3
};

// Numbers of contact between two named partners ([[contact.pair]]). Either both are bodies,
// obstacles or groups of particles, or both are materials. The names may be equal.
struct ContactPairCase {
  std::vector<std::string> between;   // two names
  std::optional<double> restitution;  // particles only; default: that of the particles
  std::optional<double> friction;     // default for particles: their own; needed otherwise
  SourceLocation location;
};

struct ContactCase {
  bool enabled = true;
  double range = 2e-3;             // d-hat (m): gap below which the barrier acts
  double stiffness = 1e6;          // kappa (N/m^3): barrier stiffness per area
  double damping_time = 1e-3;      // beta (s): contact damping divided by contact stiffness
  Varying<double> friction = 0.0;  // Coulomb coefficient of pairs that `pair` does not name
  double friction_speed = 1e-2;    // m/s; sliding speed from which friction has its full force
  // m; displacement from which anchored contacts slide; empty: contacts that stick creep
  std::optional<double> sticking_distance;
  std::optional<double> search_slack;  // m; default: a sixth of the mean edge
  bsi::Bound bound = bsi::Bound::box;  // bounding volumes above the leaves of the search hierarchy
  std::vector<ContactPairCase> pair;   // [[contact.pair]]
};

enum class MaterialModel { cloth, shell };
enum class MembraneModel { triangles, springs };

// A table of force per width against strain. The curve is linear between the points of the table,
// and continues straight beyond the first and the last point. A curve of shear begins at strain 0;
// at negative strains it is the mirror image.
struct StretchCurveCase {
  std::vector<double> strains;   // increasing; one of them is 0
  std::vector<double> tensions;  // N/m, one per strain; never falling, 0 at strain 0
};

// The membrane of woven cloth. Warp, weft and shear each have either a constant stiffness or a
// curve.
struct OrthotropicMembraneCase {
  std::optional<double> warp_stiffness, weft_stiffness;  // Young's moduli times thickness (N/m)
  std::optional<double> shear_modulus;                   // shear modulus times thickness (N/m)
  double poisson_ratio = 0;  // weft contraction per warp stretch, under a pull along the warp
  std::optional<StretchCurveCase> warp_curve, weft_curve, shear_curve;

  bool has_curves() const { return warp_curve || weft_curve || shear_curve; }
};

// A membrane whose stiffness depends on the stretch and on its angle to the warp
// (materials/measured_stretch.h). Each list has six stiffnesses (N/m). The first one holds without
// stretch, the others at a stretch of 1/6 at 0, 22.5, 45, 67.5 and 90 degrees to the warp.
struct MeasuredMembraneCase {
  std::vector<double> warp, coupling, weft, shear;
  double factor = 1;  // multiplies all entries
};

// Bending stiffness along the warp, at 45 degrees and along the weft.
struct OrthotropicBendingCase {
  // Bending stiffness (N m), with one entry per curvature; one entry if `curvatures` is empty.
  std::vector<double> warp, bias, weft;
  std::vector<double> curvatures;  // 1/m, increasing from 0; empty: the stiffness is constant
  double factor = 1;               // multiplies all stiffnesses
};

struct MaterialCase {
  std::string name;    // NAME in [material.NAME]
  std::string preset;  // name of a preset (material_presets.h); empty: none
  MaterialModel model = MaterialModel::cloth;
  double density = 0.2;  // kg/m^2, > 0; cloth only
  MembraneModel membrane = MembraneModel::triangles;
  double membrane_stiffness = 1000.0;  // Young's modulus times thickness (N/m); cloth only
  double poisson_ratio = 0.3;          // used by isotropic triangles, all bending and shells
  std::optional<double> structural_stiffness;  // N/m; springs only; default: 3/4 membrane_stiffness
  std::optional<double> shear_stiffness;    // N/m; springs only; default: half the structural one
  std::optional<double> bend_stiffness;     // N/m; springs only; default: 0
  double bending_stiffness = 0.0;           // N m; cloth only
  double youngs_modulus = 0;                // Pa; shells only
  double shell_thickness = 0;               // m; shells only
  double volume_density = 0;                // kg/m^3; shells only
  int spline_degree = 3;                    // 2 or 3; shells only
  Varying<double> mass_damping = 0.0;       // 1/s
  Varying<double> stiffness_damping = 0.0;  // s; damping of the membrane divided by its stiffness
  Varying<double> bending_damping = 0.0;    // s; damping of bending divided by its stiffness
  std::optional<double> loss_factor;        // of membrane and bending, at loss_frequency
  std::optional<double> loss_frequency;     // Hz
  std::optional<double> strain_limit;       // largest principal strain, > 0; cloth only
  std::optional<double> yield_curvature;    // 1/m, > 0; cloth only
  std::optional<double> hardening;          // stiffness after yielding over that before it, < 1
  Varying<double> normal_drag = 0.0;        // drag coefficient of air that moves across the surface
  Varying<double> tangential_drag = 0.0;    // drag coefficient of air that moves along the surface

  std::optional<OrthotropicMembraneCase> orthotropic_membrane;  // replaces membrane_stiffness
  std::optional<MeasuredMembraneCase> measured_membrane;        // replaces membrane_stiffness
  std::optional<OrthotropicBendingCase> orthotropic_bending;    // replaces bending_stiffness

  bool is_shell() const { return model == MaterialModel::shell; }
  // True if the membrane is isotropic or consists of springs.
  bool has_isotropic_membrane() const { return !orthotropic_membrane && !measured_membrane; }
  bool resists_bending() const { return bending_stiffness > 0 || orthotropic_bending; }
  double area_density() const { return is_shell() ? volume_density * shell_thickness : density; }
  bool yields() const { return yield_curvature.has_value() && bending_stiffness > 0; }
  // Damping times (s) of the membrane, or its springs, and of bending. A loss factor of eta at the
  // frequency f is a time of eta / (2 pi f).
  Varying<double> membrane_damping_time() const;
  Varying<double> bending_damping_time() const;
};

enum class ShapeType {
  rectangle,
  plane,
  disc,
  annulus,
  box,
  cylinder,
  capsule,
  cone,
  torus,
  sphere,
  sphere_sector,
  blob,
  file
};

struct ShapeCase {
  ShapeType type = ShapeType::rectangle;
  std::vector<double> size;     // m; rectangle, plane: [x, y]; box: [x, y, z]
  std::vector<int> resolution;  // numbers of vertices; docs/guide.md, Shapes, has their order
  std::vector<int> patches;     // [rows, cols] of patches that cut the image; empty: it is not cut
  // m; disc, cylinder, capsule, cone (at its base), sphere, sphere_sector, blob.
  std::optional<double> radius;
  double top_radius = 0;               // m; cone: radius at its top, 0 for an apex
  std::optional<double> length;        // m; cylinder, capsule (straight part), cone
  std::optional<double> inner_radius;  // m; annulus
  std::optional<double> outer_radius;  // m; annulus
  std::optional<double> major_radius;  // m; torus
  std::optional<double> minor_radius;  // m; torus
  std::vector<double> latitude_deg;    // sphere_sector: [south, north]
  double angle_deg = 360;              // angle around the z axis: annulus, cylinder, sphere_sector
  std::string path;                    // file: path of an HDF5 file, relative to the case file
  std::string dataset;  // file: dataset [rows, cols, 3] or [patches, rows, cols, 3], m
  bool wrap_u = false;  // file: whether the last column joins the first
  bool wrap_v = false;  // file: whether the last row joins the first
  SourceLocation location;
};

// A pose that a prescribed motion passes through: displacement and rotation from the start.
struct KeyframeCase {
  double time = 0;             // s, later than the keyframe before
  Vec3 translation{0, 0, 0};   // m
  Vec3 rotation_deg{0, 0, 0};  // rotation vector (axis times angle), degrees
};
// A rigid motion prescribed for a pin or an obstacle: x(t) = R(t) (x0 - centre) + centre + d(t). R
// is the rotation and d the translation; x0 is the position of a point at t = 0. If a pin takes
// hold later, x0 is chosen such that x(t) begins at the position that the point then has.
struct MotionCase {
  Vec3 velocity{0, 0, 0};              // m/s
  Vec3 angular_velocity_deg{0, 0, 0};  // degrees/s, about `centre`
  // m; default: the mean of the moved points at t = 0 or, if a pin takes hold later, at that time.
  std::optional<Vec3> centre;
  double start_time = 0.0;              // s; the points are at rest before
  std::optional<double> stop_time;      // s; the points are at rest afterwards; default: no end
  std::vector<KeyframeCase> keyframes;  // if not empty, they replace the velocities
  SourceLocation location;
};

// A selection of vertices of a body. A vertex is selected if any of the selectors names it. Rows
// and cols together are one selector, for a block. One of them alone selects whole rows or columns.
struct VertexSelection {
  std::vector<std::string>
      corners;  // "first_first", "first_last", "last_first", "last_last" (row_col), or "all"
  std::vector<std::string> edges;              // "first_row", "last_row", "first_col", "last_col"
  std::vector<int> rows;                       // [first, last]; negative numbers count from the end
  std::vector<int> cols;                       // [first, last]; negative numbers count from the end
  int patch = 0;                               // patch to which corners, edges, rows and cols refer
  std::optional<Vec3> region_min, region_max;  // m; corners of a box in world space at t = 0
};

struct PinCase {
  VertexSelection vertices;
  bool clamp = false;  // also holds the surface's tangent plane at held edges
  // Held directions: "x", "y", "z". Empty: all directions, unless `symmetry` is given.
  std::vector<std::string> axes;
  std::optional<Vec3> symmetry;        // normal of a plane of symmetry through the vertices
  double hold_time = 0;                // s; time from which the vertices are held
  std::optional<double> release_time;  // s; time from which the vertices are free; default: never
  std::optional<MotionCase> motion;
  SourceLocation location;

  // True if the pin holds the vertices in some directions only.
  bool slides() const { return !axes.empty() || symmetry.has_value(); }
};

// The shape in which a body starts instead of its rest shape, before BodyCase::stretch. It is
// either `shape` or the rest shape bent onto a cylinder.
struct StartCase {
  std::optional<ShapeCase> shape;     // same rows, columns, patches and seams as the rest shape
  std::optional<double> bend_radius;  // m; positive: borders move towards +z, negative: towards -z
  // Direction of the curvature, from x towards y; default 0.
  std::optional<double> bend_direction_deg;
  SourceLocation location;
};

struct BodyCase {
  std::string name;
  ShapeCase shape;
  std::string material;                // name of a [material.NAME]
  std::optional<StartCase> start;      // default: the rest shape
  Vec3 stretch{1, 1, 1};               // factors along the axes, applied before the rotation
  Vec3 position{0, 0, 0};              // m; translation after the rotation
  Vec3 rotation_deg{0, 0, 0};          // rotation vector (axis times angle), about the origin
  Vec3 velocity{0, 0, 0};              // m/s
  Vec3 angular_velocity_deg{0, 0, 0};  // degrees/s about the body's centre
  std::optional<double> thickness;     // m; default: 1e-3, or shell_thickness for shells
  double warp_angle_deg = 0;           // angle of the warp to the image's rows, towards columns
  bool control_net = false;            // shells: the image holds control points, not surface points
  bool self_contact = true;
  std::vector<PinCase> pin;
  SourceLocation location;
};

struct ObstacleCase {
  std::string name;
  ShapeCase shape;
  Vec3 position{0, 0, 0};      // m; translation after the rotation
  Vec3 rotation_deg{0, 0, 0};  // rotation vector (axis times angle), about the origin
  double thickness = 1e-3;     // m
  std::string material;        // name of a [material.NAME], for pairs of contact; empty: none
  std::optional<MotionCase> motion;
  SourceLocation location;
};

enum class PositionsType { grid, random, file };

// The places at which particles start ([particles.positions]).
struct PositionsCase {
  PositionsType type = PositionsType::grid;
  std::vector<int> count;         // grid: particles along x, y and z
  std::optional<double> spacing;  // m; grid: distance of neighbours; default: 2.2 radii
  Vec3 centre{0, 0, 0};           // m; grid: its centre
  double jitter = 0;              // m; grid: largest random displacement along each axis
  int number = 0;                 // random: particles
  Vec3 region_min{0, 0, 0}, region_max{0, 0, 0};  // m; random: box that holds the centres
  int seed = 1;                                   // of random places and of jitter
  std::string path, dataset;                      // file: HDF5 file, and its dataset [n, 3] (m)
  SourceLocation location;
};

// A group of spheres that move as rigid bodies ([[particles]]).
struct ParticlesCase {
  std::string name;
  PositionsCase positions;
  double radius = 0;                   // m, > 0
  double density = 1000;               // kg/m^3, > 0
  Vec3 velocity{0, 0, 0};              // m/s, at the start
  Vec3 angular_velocity_deg{0, 0, 0};  // degrees/s, of each particle about its centre
  bool spin = true;                    // whether friction turns the particles
  double restitution = 0.5;            // rebound speed over impact speed, 0 to 1
  std::optional<double> friction;      // Coulomb coefficient; default: contact.friction
  double drag_coefficient = 0;         // of air resistance, on the area of the cross-section
  SourceLocation location;
};

enum class LoadType { point, line, area, pressure, moment };

// A load: forces or moments that act on a body from outside.
struct LoadCase {
  VertexSelection vertices;
  std::string body;
  LoadType type = LoadType::point;
  // Force per vertex of a point load (N), per length of a line load (N/m), or per area of an area
  // load (N/m^2).
  Varying<Vec3> force = Vec3(0, 0, 0);
  Varying<double> pressure = 0.0;  // Pa
  Varying<double> moment = 0.0;    // moment per length of an edge (N m/m)
  bool follower = false;           // if true, the force rotates with the surface
  SourceLocation location;
};

// Springs that tie vertices of a body to another body or to an obstacle.
struct TieCase {
  VertexSelection vertices;
  std::string body;
  std::string to;                     // name of a body or obstacle
  double stiffness = 1e4;             // N/m; sum over all springs of the tie
  std::optional<double> break_force;  // N; sum of the spring forces at which the tie breaks
  SourceLocation location;
};

// The bending of a seam: the surfaces go on across it, or it is a hinge without friction.
enum class SeamBending { continuous, hinged };
enum class ImageEdge { first_row, last_row, first_col, last_col };

// Sews a border of a body to a border of another body, or of the same one. A border is one of the
// edges of an image, or a part of it.
struct SeamCase {
  std::string body;
  ImageEdge edge = ImageEdge::first_row;
  std::vector<int> range;  // vertices along the edge: [first, last], from 0, or from -1 backwards
  int patch = 0;
  std::string to;  // this and the next three: the other side
  ImageEdge to_edge = ImageEdge::first_row;
  std::vector<int> to_range;
  int to_patch = 0;
  std::optional<double> stiffness;  // N/m^2: force per length of the seam and opening
  SeamBending bending = SeamBending::continuous;
  double angle_deg = 0;     // fold of the seam without moment
  double closing_time = 0;  // s, in which edges that start apart are drawn together
  SourceLocation location;
};

struct StartStates;

// The state of another run in which the bodies start ([restart]).
struct RestartCase {
  std::string path;  // trajectory, relative to the case file
  double time = 0;   // s; time of a frame of the trajectory, or of its checkpoint
  std::shared_ptr<const StartStates> states;  // null until read_restart() (sim/run/restart.h)
  SourceLocation location;
};

// A file with materials and obstacles that belong to the case.
struct IncludeCase {
  std::string path;  // TOML file, relative to the file that includes it
};

enum class Precision { float32, float64 };
enum class Compression { none, lossless, bounded };

// A part of a body or obstacle that is recorded instead of the whole.
struct OutputPartCase {
  std::string body;       // name of a body or an obstacle
  std::vector<int> rows;  // [first, last]; negative numbers count from the end; empty: all rows
  std::vector<int> cols;  // [first, last]; negative numbers count from the end; empty: all columns
  int every = 1;  // distance between recorded rows or columns; the last ones are recorded as well
  SourceLocation location;
};

struct OutputCase {
  bool velocity = false;              // records velocities
  bool step_energies = false;         // records energies after every step, not only in frames
  std::vector<std::string> channels;  // names of further recorded quantities (sim/case/channels.h)
  std::vector<double> frame_times;    // s, increasing; empty: time.frames_per_second sets them
  std::vector<std::string> bodies;    // names of recorded bodies and obstacles; empty: all
  std::vector<OutputPartCase> part;   // [[output.part]]
  Precision precision = Precision::float32;     // number format of positions
  Compression compression = Compression::none;  // compression of positions and fields
  double compression_error = 1e-6;  // m; largest change of a coordinate by bounded compression
  // s; simulated time between two checkpoints. Default: CheckpointSchedule counts steps.
  std::optional<double> checkpoint_every;
};

// A named number that a run reports at its end, as an expression over what it records
// (sim/probes/probe.h).
struct OutputExpression {
  std::string name;
  LocatedText text;
};

enum class ComputeBackend { automatic, gpu, osmesa, cpu };

struct ComputeCase {
  std::optional<int> threads;  // default: from the numbers of simulated vertices and of processors
  ComputeBackend backend = ComputeBackend::automatic;  // device of the contact search
  std::optional<double> cpu_limit;                     // s; CPU time of the run
  std::optional<double> memory_limit;  // MiB; default: default_memory_limit() (memory_estimate.h)
};

struct Case {
  std::string title;
  TimeCase time;
  StaticCase equilibria;  // [static]
  WorldCase world;
  ContactCase contact;
  OutputCase output;
  ComputeCase compute;
  std::optional<RestartCase> restart;  // [restart]; default: bodies start as their tables say
  // [[include]]. The reader merges these files into the case, so the list of a read case is empty.
  std::vector<IncludeCase> include;
  std::vector<MaterialCase> material;     // [material.NAME]
  std::vector<BodyCase> body;             // [[body]]
  std::vector<ObstacleCase> obstacle;     // [[obstacle]]
  std::vector<ParticlesCase> particles;   // [[particles]]
  std::vector<TieCase> tie;               // [[tie]]
  std::vector<LoadCase> load;             // [[load]]
  std::vector<SeamCase> seam;             // [[seam]]
  std::vector<OutputExpression> outputs;  // [outputs], in the order of the file

  std::string path;                   // path of the case file; base of relative paths
  std::vector<std::string> included;  // paths of the files merged into it
  // The case as TOML, with all overrides and with the defaults of all keys that apply
  // (case_text()). Trajectories store it. Once time.accuracy has chosen a method and its tolerance
  // or step, the text has these in place of time.accuracy.
  std::string resolved_text;
  // True if the file or an override gives time.method.
  bool method_given = false;
  SourceLocation method_location, accuracy_location;
  // The choice that time.accuracy made, in words. Empty without time.accuracy, and before
  // choose_accuracy() (sim/accuracy/accuracy_choice.h).
  std::string accuracy_choice;
  // True if the spheres of a group turn at t = 0, or friction can turn them.
  bool can_turn(const ParticlesCase& group) const {
    if (!group.spin || !group.angular_velocity_deg.isZero(0)) return group.spin;
    if (!contact.enabled) return false;
    if (group.friction ? *group.friction > 0 : !contact.friction.is_zero()) return true;
    return std::ranges::any_of(contact.pair, [&](const ContactPairCase& pair) {
      return pair.friction.value_or(0) > 0 && std::ranges::count(pair.between, group.name) > 0;
    });
  }
  bool awaits_accuracy() const { return time.accuracy && accuracy_choice.empty(); }
};

}  // namespace weft::sim
