// A case file as data: one struct per table. case_schema.cpp and the other *_schema.cpp describe
// the fields of each struct once (key, unit, limits, meaning). The parser, the JSON schema and the
// reference page all read these descriptions.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bsi/leaf_pair.h"
#include "sim/base/vectors.h"
#include "sim/case/varying.h"

namespace weft::sim {

// The place of a value in a case file, for messages. Line 0 marks a value from outside the file (a
// default or --set).
struct SourceLocation {
  std::string file;
  int line = 0;
  int column = 0;
};

// Methods of time integration; time_methods.cpp lists their properties.
enum class TimeMethod { cvode, arkode, euler, static_loads, implicit_midpoint, verlet };
enum class PreconditionerChoice { automatic, block_jacobi, multigrid };

struct TimeCase {
  TimeMethod method = TimeMethod::cvode;
  double duration = 1.0;             // s, > 0
  double frames_per_second = 60.0;   // 1/s, > 0
  std::optional<double> accuracy;    // m, error to aim for; chooses the method and tolerances
  double position_tolerance = 1e-5;  // m, local error per step
  std::optional<double> velocity_tolerance;  // m/s; default 100 /s * position_tolerance
  double relative_tolerance = 1e-4;          // velocity error per step, as a fraction of the speed
  std::optional<double> step;                // s, length of fixed steps
  int newton = 0;                            // Newton iterations per step; 0: to convergence
  int maximum_order = 2;                     // BDF order, 1..5
  double minimum_step = 1e-7;                // s
  std::optional<double> maximum_step;        // s
  PreconditionerChoice preconditioner = PreconditionerChoice::automatic;  // of the linear solver
  bool sleep = true;  // bodies that have come to rest are not simulated until they are touched
};

// The course of the loads of equilibria, and the action at the end of a stable path.
enum class Loading { proportional, in_time, arc_length };
enum class AtLimitPoint { stop, jump };

struct StaticCase {  // of [static]; for time.method = "static"
  Loading loading = Loading::proportional;
  AtLimitPoint at_limit_point = AtLimitPoint::stop;
  bool scale_gravity = false;                  // multiplies gravity by the load factor
  double first_load_factor = 0.1;              // of the first point of the path
  std::optional<double> largest_step;          // m, RMS of the displacements between two points
  std::optional<double> largest_load_factor;   // > 0; the path ends there
  std::optional<double> largest_displacement;  // m, of any vertex; the path ends there
};

struct WorldCase {
  Varying<Vec3> gravity = Vec3(0, 0, -9.81);  // m/s^2
  Varying<Vec3> wind = Vec3(0, 0, 0);         // m/s
  Varying<double> air_density = 1.2;          // kg/m^3
};

struct ContactCase {
  bool enabled = true;
  double range = 2e-3;                 // d-hat, m: gap at which the barrier starts
  double stiffness = 1e6;              // kappa per area, N/m^3
  double damping_time = 1e-3;          // beta, s
  Varying<double> friction = 0.0;      // Coulomb coefficient
  double friction_speed = 1e-2;        // m/s, regularisation
  std::optional<double> search_slack;  // m; default a quarter of the mean edge
  bsi::Bound bound = bsi::Bound::box;  // of the hierarchy
};

enum class MaterialModel { cloth, shell };
enum class MembraneModel { triangles, springs };

// Force per width against strain: linear between the points of the table, straight beyond them.
struct StretchCurveCase {
  std::vector<double> strains;   // increasing, with 0
  std::vector<double> tensions;  // N/m, one per strain; not falling, 0 at strain 0
};

// Stiffness along warp, along weft and in shear: for each a constant or a curve.
struct OrthotropicMembraneCase {
  std::optional<double> warp_stiffness, weft_stiffness;  // Young's moduli times thickness, N/m
  std::optional<double> shear_modulus;                   // times thickness, N/m
  double poisson_ratio = 0;  // contraction along the weft under a pull along the warp
  std::optional<StretchCurveCase> warp_curve, weft_curve, shear_curve;

  bool has_curves() const { return warp_curve || weft_curve || shear_curve; }
};

// Stiffness by strain and by angle to the warp. Each list has six entries in N/m
// (materials/measured_stretch.h): without stretch, then stretched by a sixth at 0, 22.5, 45, 67.5
// and 90 degrees to the warp.
struct MeasuredMembraneCase {
  std::vector<double> warp, coupling, weft, shear;
  double factor = 1;  // multiplies all entries
};

// Bending stiffness along the warp, at 45 degrees and along the weft.
struct OrthotropicBendingCase {
  std::vector<double> warp, bias, weft;  // N m, one entry per curvature
  std::vector<double> curvatures;        // 1/m, increasing from 0; may be empty for one entry
  double factor = 1;                     // multiplies all stiffnesses
};

struct MaterialCase {
  std::string name;    // of [material.NAME]
  std::string preset;  // name of a preset that gives values (material_presets.h); empty: none
  MaterialModel model = MaterialModel::cloth;
  double density = 0.2;  // kg/m^2, > 0; of cloth
  MembraneModel membrane = MembraneModel::triangles;
  double membrane_stiffness = 1000.0;          // E h, N/m; of cloth
  double poisson_ratio = 0.3;                  // of isotropic triangles, of bending, of shells
  std::optional<double> structural_stiffness;  // N/m; springs only; default 3/4 E h
  std::optional<double> shear_stiffness;       // N/m; springs only; default half the structural
  std::optional<double> bend_stiffness;        // N/m; springs only; default 0
  double bending_stiffness = 0.0;              // D, N m; of cloth
  double youngs_modulus = 0;                   // Pa; this and the next three: shell
  double shell_thickness = 0;                  // m
  double volume_density = 0;                   // kg/m^3
  int spline_degree = 3;                       // 2 or 3
  Varying<double> mass_damping = 0.0;          // 1/s
  Varying<double> stiffness_damping = 0.0;     // s, of the membrane and its springs
  Varying<double> bending_damping = 0.0;       // s, of bending
  std::optional<double> loss_factor;           // of membrane and bending, at loss_frequency
  std::optional<double> loss_frequency;        // Hz
  std::optional<double> strain_limit;          // of the principal strains, > 0; cloth
  std::optional<double> yield_curvature;       // 1/m, > 0; cloth
  double hardening = 0.0;                      // stiffness after yielding over that before, < 1
  Varying<double> normal_drag = 0.0;           // coefficient
  Varying<double> tangential_drag = 0.0;       // coefficient

  std::optional<OrthotropicMembraneCase> orthotropic_membrane;  // instead of membrane_stiffness
  std::optional<MeasuredMembraneCase> measured_membrane;        // instead of membrane_stiffness
  std::optional<OrthotropicBendingCase> orthotropic_bending;    // instead of bending_stiffness

  bool is_shell() const { return model == MaterialModel::shell; }
  // Returns true if the membrane is isotropic triangles or springs.
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
  std::vector<double> size;            // rectangle, plane: [x, y]; box: [x, y, z]; m
  std::vector<int> resolution;         // vertices, in the order of docs/guide.md, Shapes
  std::vector<int> patches;            // [rows, cols] into which the image is cut; empty: not cut
  std::optional<double> radius;        // m; not of rectangle, plane, annulus, box, torus, file
  double top_radius = 0;               // cone: m; 0 is an apex
  std::optional<double> length;        // cylinder, capsule, cone: m
  std::optional<double> inner_radius;  // annulus: m
  std::optional<double> outer_radius;  // annulus: m
  std::optional<double> major_radius;  // torus: m
  std::optional<double> minor_radius;  // torus: m
  std::vector<double> latitude_deg;    // sphere_sector: [south, north]
  double angle_deg = 360;              // annulus, cylinder, sphere_sector
  std::string path;                    // file: path of an HDF5 file, relative to the case file
  std::string dataset;  // file: dataset [rows, cols, 3] or [patches, rows, cols, 3], m
  bool wrap_u = false;  // file: joins the last column to the first
  bool wrap_v = false;  // file: joins the last row to the first
  SourceLocation location;
};

// Rigid motion prescribed for pins and obstacles: x(t) = R(t) (x0 - centre) + centre + d(t).
struct KeyframeCase {
  double time = 0;             // s, increasing
  Vec3 translation{0, 0, 0};   // m
  Vec3 rotation_deg{0, 0, 0};  // rotation vector (axis times angle), degrees
};
struct MotionCase {
  Vec3 velocity{0, 0, 0};               // m/s
  Vec3 angular_velocity_deg{0, 0, 0};   // degrees/s about `centre`
  std::optional<Vec3> centre;           // m; default the mean of the moved points at t = 0
  double start_time = 0.0;              // s; at rest before
  std::optional<double> stop_time;      // s; at rest after; default: never
  std::vector<KeyframeCase> keyframes;  // instead of the velocities
  SourceLocation location;
};

// Selects every vertex of a body that any selector names. Rows and cols together select a block;
// one of them alone selects whole rows or columns.
struct VertexSelection {
  std::vector<std::string>
      corners;  // "first_first", "first_last", "last_first", "last_last" (row_col), or "all"
  std::vector<std::string> edges;  // "first_row", "last_row", "first_col", "last_col"
  std::vector<int> rows;           // [first, last]; negative: counted from the end
  std::vector<int> cols;           // [first, last]
  int patch = 0;
  std::optional<Vec3> region_min, region_max;  // m, box in world space at t = 0
};

struct PinCase {
  VertexSelection vertices;
  bool clamp = false;                  // also holds the surface's tangent plane at the held edges
  std::vector<std::string> axes;       // "x", "y", "z": held directions; empty: all
  std::optional<Vec3> symmetry;        // normal of a plane of symmetry through the vertices
  double hold_time = 0;                // s; the vertices are free before
  std::optional<double> release_time;  // s; the vertices are free from then on
  std::optional<MotionCase> motion;
  SourceLocation location;

  // Returns true if the vertices are held in some directions only.
  bool slides() const { return !axes.empty() || symmetry.has_value(); }
};

// The shape in which a body starts, if that is not its rest shape: `shape`, or the rest shape bent.
struct StartCase {
  std::optional<ShapeCase> shape;     // an image like that of the rest shape
  std::optional<double> bend_radius;  // m: bends upwards if positive, downwards if negative
  double bend_direction_deg = 0;      // direction in which the surface curves, from x towards y
  SourceLocation location;
};

struct BodyCase {
  std::string name;
  ShapeCase shape;
  std::string material;                // name of a [material.NAME]
  std::optional<StartCase> start;      // default: the rest shape
  Vec3 stretch{1, 1, 1};               // factors along the axes of the start shape
  Vec3 position{0, 0, 0};              // m
  Vec3 rotation_deg{0, 0, 0};          // rotation vector, degrees, before the translation
  Vec3 velocity{0, 0, 0};              // m/s
  Vec3 angular_velocity_deg{0, 0, 0};  // degrees/s about the body's centre
  std::optional<double> thickness;     // m; default 1e-3, for shells shell_thickness
  double warp_angle_deg = 0;           // from the rows of the image to the warp, towards columns
  bool control_net = false;            // shells: the image holds control points, not surface points
  bool self_contact = true;
  std::vector<PinCase> pin;
  SourceLocation location;
};

struct ObstacleCase {
  std::string name;
  ShapeCase shape;
  Vec3 position{0, 0, 0};
  Vec3 rotation_deg{0, 0, 0};
  double thickness = 1e-3;
  std::optional<MotionCase> motion;
  SourceLocation location;
};

enum class LoadType { point, line, area, pressure, moment };

// Forces that act on a body from outside.
struct LoadCase {
  VertexSelection vertices;
  std::string body;
  LoadType type = LoadType::point;
  Varying<Vec3> force = Vec3(0, 0, 0);  // N at each vertex, N/m of an edge, or N/m^2
  Varying<double> pressure = 0.0;       // Pa
  Varying<double> moment = 0.0;         // N m/m of an edge
  bool follower = false;                // the force keeps its components in the surface's frame
  SourceLocation location;
};

// Springs that tie vertices of a body to another body or to an obstacle.
struct TieCase {
  VertexSelection vertices;
  std::string body;
  std::string to;                     // name of a body or obstacle
  double stiffness = 1e4;             // N/m, of all springs together
  std::optional<double> break_force;  // N: sum of the spring forces at which the tie breaks
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

// A file with materials and obstacles that belong to the case.
struct IncludeCase {
  std::string path;  // TOML file, relative to the file that includes it
};

enum class Precision { float32, float64 };
enum class Compression { none, lossless, bounded };

// A part of a body or obstacle that is recorded instead of the whole.
struct OutputPartCase {
  std::string body;       // name of a body or an obstacle
  std::vector<int> rows;  // [first, last]; negative: from the end; default: all
  std::vector<int> cols;  // [first, last]
  int every = 1;  // step from one recorded row or column to the next; the last ones are added
  SourceLocation location;
};

struct OutputCase {
  bool velocity = false;              // records velocities
  bool step_energies = false;         // records energies after every step, not only in frames
  std::vector<std::string> channels;  // further quantities in frames, by name (sim/case/channels.h)
  std::vector<double> frame_times;    // s, increasing; empty: by time.frames_per_second
  std::vector<std::string> bodies;    // recorded bodies and obstacles; empty: all
  std::vector<OutputPartCase> part;   // [[output.part]]
  Precision precision = Precision::float32;     // of positions
  Compression compression = Compression::none;  // of positions and fields
  double compression_error = 1e-6;              // m, of bounded compression
};

enum class ComputeBackend { automatic, gpu, osmesa, cpu };

struct ComputeCase {
  std::optional<int> threads;                          // default: by the number of vertices
  ComputeBackend backend = ComputeBackend::automatic;  // of the contact search
  std::optional<double> cpu_limit;                     // s
  std::optional<double> memory_limit;                  // MiB; default nine tenths of the machine's
};

struct Case {
  std::string title;
  TimeCase time;
  StaticCase equilibria;  // [static]
  WorldCase world;
  ContactCase contact;
  OutputCase output;
  ComputeCase compute;
  // [[include]]; empty once a case has been read, which then holds the contents of these files.
  std::vector<IncludeCase> include;
  std::vector<MaterialCase> material;  // [material.NAME]
  std::vector<BodyCase> body;          // [[body]]
  std::vector<ObstacleCase> obstacle;  // [[obstacle]]
  std::vector<TieCase> tie;            // [[tie]]
  std::vector<LoadCase> load;
  std::vector<SeamCase> seam;  // [[seam]]

  std::string path;  // path of the case file; base of relative paths
  // The case as TOML with every default and override, as trajectories store it. The values that
  // time.accuracy chose replace that key.
  std::string resolved_text;
  // Facts about the text, for choose_accuracy() (sim/accuracy/accuracy_choice.h).
  bool method_given = false;
  SourceLocation method_location, accuracy_location;
  // The choice that time.accuracy made, with its reason. Empty without time.accuracy and before the
  // choice.
  std::string accuracy_choice;
  bool awaits_accuracy() const { return time.accuracy && accuracy_choice.empty(); }
};

}  // namespace weft::sim
