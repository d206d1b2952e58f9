#include "sim/case/case_schema.h"
#include "sim/case/time_methods.h"

namespace weft::sim {

namespace {

constexpr Limits any{};
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr Limits positive{0, infinity, true, false};
constexpr Limits not_negative{0, infinity, false, false};
constexpr Limits at_least(double minimum) { return {minimum, infinity, false, false}; }

Field field(std::string key, Member member, std::string unit, Limits limits, std::string meaning) {
  Field result;
  result.key = std::move(key);
  result.member = std::move(member);
  result.unit = std::move(unit);
  result.limits = limits;
  result.meaning = std::move(meaning);
  return result;
}

// A field without a number: a name, a switch, a table.
Field field(std::string key, Member member, std::string meaning) {
  return field(std::move(key), std::move(member), "", any, std::move(meaning));
}

Table describe(TimeCase& target);
Table describe(WorldCase& target);
Table describe(ContactCase& target);
Table describe(OutputCase& target);
Table describe(ComputeCase& target);
Table describe(MaterialCase& target);
Table describe(ShapeCase& target);
Table describe(KeyframeCase& target);
Table describe(MotionCase& target);
Table describe(PinCase& target);
Table describe(BodyCase& target);
Table describe(ObstacleCase& target);

template <class Enum>
struct NamedValue {
  Enum value;
  std::string name;
};

template <class Enum>
Choice choice(Enum* target, std::type_identity_t<std::vector<NamedValue<Enum>>> values) {
  std::vector<std::string> names;
  for (const NamedValue<Enum>& each : values) names.push_back(each.name);
  return {std::move(names),
          [target, values] {
            const auto found = std::ranges::find(values, *target, &NamedValue<Enum>::value);
            return static_cast<std::size_t>(found - values.begin());
          },
          [target, values](std::size_t index) { *target = values[index].value; }};
}

std::vector<NamedValue<TimeMethod>> named_methods() {
  std::vector<NamedValue<TimeMethod>> values;
  for (const TimeMethodTraits& each : time_methods()) values.push_back({each.method, each.name});
  return values;
}

template <class Struct>
TableMember table(Struct* target) {
  return {[] { return true; }, [target] { return describe(*target); }};
}

template <class Struct>
TableMember table(std::optional<Struct>* target) {
  return {[target] { return target->has_value(); },
          [target] {
            if (!*target) target->emplace();
            return describe(**target);
          }};
}

template <class Struct>
TableList tables(std::vector<Struct>* target, bool named = false) {
  return {named, [target] { return target->size(); },
          [target](std::size_t index) { return describe((*target)[index]); },
          [target] { return describe(target->emplace_back()); }};
}

// Every describe() below takes its struct apart by a structured binding: a member that is added to
// case.h and not described here does not compile.

Table describe(TimeCase& target) {
  auto& [method, duration, frames, accuracy, position_tolerance, velocity_tolerance,
         relative_tolerance, step, newton, order, minimum_step, maximum_step, preconditioner] =
      target;
  return {{
      field("method", choice(&method, named_methods()),
            "Which integrator; docs/guide.md says which is for what. cvode: BDF of variable order "
            "and step; arkode: Runge-Kutta of variable step, implicit or explicit as the motion "
            "asks; euler: backward Euler; static: equilibria under gravity that grows from nothing "
            "and motions that proceed, one a frame; implicit_midpoint: fixed steps, to compare; "
            "verlet: explicit steps, for motion without damping or contact."),
      field("duration", &duration, "s", positive, "Time to simulate."),
      field("frames_per_second", &frames, "1/s", positive, "Frames recorded per second."),
      field("accuracy", &accuracy, "m", positive,
            "The error wanted: the largest, over frames and bodies, of the root mean square over "
            "a body's vertices of their distance from where exact integration in time of the same "
            "mesh would have them. Chooses the method, unless that is given, and its tolerances or "
            "step, by a calibration: short of chaos, mostly within a factor 3.")
          .with_default("none: tolerances as given"),
      field("position_tolerance", &position_tolerance, "m", positive,
            "Error of a position allowed per step, or left in the solution of an implicit one of "
            "fixed length; "
            "with contact at most 0.005 of contact.range.")
          .not_with("accuracy"),
      field("velocity_tolerance", &velocity_tolerance, "m/s", positive,
            "Error of a velocity allowed per step; with contact at most 0.5 /s of contact.range.")
          .with_default("100 /s of position_tolerance")
          .not_with("accuracy"),
      field("relative_tolerance", &relative_tolerance, "", {0, 1, true, true},
            "Error allowed per step as a fraction of the speed.")
          .not_with("accuracy"),
      field("step", &step, "s", positive,
            "Fixed step; longer than minimum_step, at most the duration; implicit_midpoint needs "
            "one. verlet chooses a share of the longest stable one, which it follows, as the root "
            "of relative_tolerance.")
          .with_default("chosen by the tolerances")
          .only_for("method", {"euler", "implicit_midpoint", "verlet"})
          .not_with("accuracy"),
      field("newton", &newton, "", at_least(0),
            "Newton iterations of a step: 1 is the linearly implicit step; 0: until they converge "
            "to the tolerances. With contact and a pin or obstacle that moves, more where these "
            "leave a particle's velocity wrong by over a tenth of the fastest.")
          .only_for("method", {"euler", "implicit_midpoint"})
          .not_with("accuracy"),
      field("maximum_order", &order, "", {1, 5},
            "Highest order of the BDF method; 3 to 5 need damping in every material and a "
            "position_tolerance of at most 1e-6.")
          .only_for("method", {"cvode"})
          .not_with("accuracy"),
      field("minimum_step", &minimum_step, "s", positive,
            "A step that must be shorter than this stops the run; less than a frame."),
      field("maximum_step", &maximum_step, "s", positive, "Longest step.")
          .with_default("no limit")
          .only_for("method", {"cvode", "arkode", "euler"}),
      field("preconditioner",
            choice(&preconditioner, {{PreconditionerChoice::automatic, "automatic"},
                                     {PreconditionerChoice::block_jacobi, "block_jacobi"},
                                     {PreconditionerChoice::multigrid, "multigrid"}}),
            "Advanced: how linear systems are preconditioned. The choice changes the run time."),
  }};
}

Table describe(WorldCase& target) {
  auto& [gravity, wind, air_density] = target;
  return {{
      field("gravity", &gravity, "m/s^2", any, "Acceleration of every body."),
      field("wind", &wind, "m/s", any, "Velocity of the air, for drag."),
      field("air_density", &air_density, "kg/m^3", not_negative, "Density of the air, for drag."),
  }};
}

Table describe(ContactCase& target) {
  auto& [enabled, range, stiffness, damping_time, friction, friction_speed, search_slack, bound] =
      target;
  return {{
      field("enabled", &enabled, "Whether bodies feel each other, themselves and obstacles."),
      field("range", &range, "m", positive, "Gap at which the contact force starts."),
      field("stiffness", &stiffness, "N/m^3", positive,
            "Strength of the barrier per area, whatever the meshes."),
      field("damping_time", &damping_time, "s", not_negative,
            "Contact damping as a fraction of the contact stiffness; without it runs are slow."),
      field("friction", &friction, "", not_negative, "Coulomb coefficient."),
      field("friction_speed", &friction_speed, "m/s", positive,
            "Sliding speed from which friction has its full force."),
      field("search_slack", &search_slack, "m", positive,
            "Extra distance of the contact search, so that its result lasts for many steps.")
          .with_default("a quarter of the mean edge"),
      field(
          "bound",
          choice(&bound, {{bsi::Bound::sphere, "sphere"},
                          {bsi::Bound::box, "box"},
                          {bsi::Bound::sphere_then_box, "sphere_then_box"}}),
          "What the search compares above the leaves of the hierarchy. The result does not depend "
          "on it."),
  }};
}

Table describe(OutputCase& target) {
  auto& [velocity, step_energies] = target;
  return {{
      field("velocity", &velocity, "Record velocities too."),
      field("step_energies", &step_energies,
            "Record the energies after every step of the integrator, not only those of frames."),
  }};
}

Table describe(ComputeCase& target) {
  auto& [threads, backend, cpu_limit, memory_limit] = target;
  return {{
      field(
          "threads", &threads, "", {1, 1024},
          "Threads of one run; the result does not depend on it. auto: one for each 4096 vertices "
          "of bodies that are simulated, at least one and at most the processor's."),
      field(
          "backend",
          choice(&backend, {{ComputeBackend::automatic, "auto"},
                            {ComputeBackend::gpu, "gpu"},
                            {ComputeBackend::osmesa, "osmesa"},
                            {ComputeBackend::cpu, "cpu"}}),
          "What finds the candidates of contact: a graphics processor, OpenGL on the CPU (a check "
          "of the shaders, slow), the CPU, or whichever of graphics processor and CPU is measured "
          "to be faster. The result does not depend on it."),
      field("cpu_limit", &cpu_limit, "s", positive,
            "CPU time that the run may take, all threads together, but for what --estimate-error "
            "takes: "
            "beyond it, the run ends with its last state, says how far it came, and counts as "
            "failed.")
          .with_default("no limit"),
      field("memory_limit", &memory_limit, "MiB", positive,
            "Memory that the scene may need by its estimate, which weft check prints; a case that "
            "needs more is refused before any of it is taken.")
          .with_default("nine tenths of the machine's"),
  }};
}

Table describe(MaterialCase& target) {
  auto& [name, density, membrane, membrane_stiffness, poisson_ratio, structural, shear, bend,
         bending_stiffness, mass_damping, stiffness_damping, bending_damping, normal_drag,
         tangential_drag] = target;
  Table result{{
      field("density", &density, "kg/m^2", positive, "Mass per area."),
      field("membrane",
            choice(&membrane,
                   {{MembraneModel::triangles, "triangles"}, {MembraneModel::springs, "springs"}}),
            "Stretching: isotropic triangles, or springs along rows, columns and diagonals."),
      field("membrane_stiffness", &membrane_stiffness, "N/m", not_negative,
            "Young's modulus times thickness."),
      field("poisson_ratio", &poisson_ratio, "", {-1, 1, true, true},
            "Poisson's ratio in the plane, of triangles and of bending."),
      field("structural_stiffness", &structural, "N/m", not_negative,
            "Springs along rows and columns.")
          .with_default("3/4 of membrane_stiffness")
          .only_for("membrane", {"springs"}),
      field("shear_stiffness", &shear, "N/m", not_negative, "Springs along both diagonals.")
          .with_default("half of structural_stiffness")
          .only_for("membrane", {"springs"}),
      field("bend_stiffness", &bend, "N/m", not_negative, "Springs that skip one vertex.")
          .with_default("0")
          .only_for("membrane", {"springs"}),
      field("bending_stiffness", &bending_stiffness, "N m", not_negative, "Of the plate."),
      field("mass_damping", &mass_damping, "1/s", not_negative,
            "Damping force per mass and velocity."),
      field("stiffness_damping", &stiffness_damping, "s", not_negative,
            "Damping of the membrane, or its springs, as a time times its stiffness."),
      field("bending_damping", &bending_damping, "s", not_negative,
            "Damping of bending as a time times its stiffness."),
      field("normal_drag", &normal_drag, "", not_negative,
            "Drag coefficient of air across the surface."),
      field("tangential_drag", &tangential_drag, "", not_negative,
            "Drag coefficient of air along the surface."),
  }};
  result.name = &name;
  return result;
}

Table describe(ShapeCase& target) {
  auto& [type, size, resolution, radius, length, major_radius, minor_radius, path, dataset, wrap_u,
         wrap_v, location] = target;
  Table result{{
      field(
          "type",
          choice(&type, {{ShapeType::rectangle, "rectangle"},
                         {ShapeType::cylinder, "cylinder"},
                         {ShapeType::torus, "torus"},
                         {ShapeType::sphere, "sphere"},
                         {ShapeType::blob, "blob"},
                         {ShapeType::file, "file"}}),
          "A rectangle in the x-y plane; a cylinder or a torus around the z axis; a sphere of "
          "six sewn patches; a blob, a sphere with dents, of 48; positions from an HDF5 file. All "
          "are centred on the origin.")
          .needed(),
      field("size", &size, "m", positive, "Lengths along x (columns) and y (rows).")
          .needed()
          .entries(2, 2)
          .only_for("type", {"rectangle"}),
      field("resolution", &resolution, "", at_least(2),
            "Vertices [rows, cols], at least 2, or 3 along a closed axis (cols of a cylinder, both "
            "of a torus); sphere: [n] along an edge of each of its six patches; blob: [n] "
            "columns and 2 n - 1 rows of each of its 48.")
          .needed()
          .entries(1, 2)
          .only_for("type", {"rectangle", "cylinder", "torus", "sphere", "blob"}),
      field("radius", &radius, "m", positive, "Radius.")
          .needed()
          .only_for("type", {"cylinder", "sphere", "blob"}),
      field("length", &length, "m", positive, "Length along z.")
          .needed()
          .only_for("type", {"cylinder"}),
      field("major_radius", &major_radius, "m", positive, "From the axis to the tube's centre.")
          .needed()
          .only_for("type", {"torus"}),
      field("minor_radius", &minor_radius, "m", positive,
            "Of the tube; less than the major radius.")
          .needed()
          .only_for("type", {"torus"}),
      field("path", &path, "HDF5 file, relative to the case file.")
          .needed()
          .only_for("type", {"file"}),
      field("dataset", &dataset,
            "Name of the positions in it, in m: [rows, cols, 3] or [patches, rows, cols, 3].")
          .needed()
          .only_for("type", {"file"}),
      field("wrap_u", &wrap_u, "Join the last column to the first.").only_for("type", {"file"}),
      field("wrap_v", &wrap_v, "Join the last row to the first.").only_for("type", {"file"}),
  }};
  result.location = &location;
  return result;
}

Table describe(KeyframeCase& target) {
  auto& [time, translation, rotation] = target;
  return {{
      field("time", &time, "s", not_negative, "When; later than the keyframe before.").needed(),
      field("translation", &translation, "m", any, "Displacement from the start."),
      field("rotation_deg", &rotation, "degrees", any,
            "Rotation from the start about the centre: axis times angle."),
  }};
}

Table describe(MotionCase& target) {
  auto& [velocity, angular_velocity, centre, start, stop, keyframes, location] = target;
  Table result{{
      field("velocity", &velocity, "m/s", any, "Constant velocity.").not_with("keyframes"),
      field("angular_velocity_deg", &angular_velocity, "degrees/s", any,
            "Constant rotation about the centre: axis times rate.")
          .not_with("keyframes"),
      field("centre", &centre, "m", any, "Centre of the rotation.")
          .with_default("the mean of the moved points at the start"),
      field("start_time", &start, "s", not_negative, "At rest before.").not_with("keyframes"),
      field("stop_time", &stop, "s", positive, "At rest after; later than start_time.")
          .with_default("never")
          .not_with("keyframes"),
      field("keyframes", tables(&keyframes),
            "Places to pass through, instead of constant velocities."),
  }};
  result.location = &location;
  return result;
}

Table describe(PinCase& target) {
  auto& [corners, edges, rows, cols, patch, region_min, region_max, motion, location] = target;
  Table result{{
      field("corners", &corners, "Corners of the image, row before column, or all four.")
          .entries(1, 4)
          .out_of({"first_first", "first_last", "last_first", "last_last", "all"}),
      field("edges", &edges, "Borders of the image.")
          .entries(1, 4)
          .out_of({"first_row", "last_row", "first_col", "last_col"}),
      field("rows", &rows, "", any,
            "First and last row of a block, from 0, or from -1 backwards; alone: whole rows.")
          .entries(2, 2),
      field("cols", &cols, "", any,
            "First and last column of a block, from 0, or from -1 backwards; alone: whole columns.")
          .entries(2, 2),
      field("patch", &patch, "", at_least(0),
            "Which patch corners, edges, rows and cols are counted in."),
      field("region_min", &region_min, "m", any,
            "Least corner of a box in space; holds what is in it at the start."),
      field("region_max", &region_max, "m", any, "Greatest corner of the box."),
      field("motion", table(&motion), "How the held vertices move; without it they stay."),
  }};
  result.location = &location;
  return result;
}

Table describe(BodyCase& target) {
  auto& [name, shape, material, stretch, position, rotation, velocity, angular_velocity, thickness,
         self_contact, pin, location] = target;
  Table result{{
      field("name", &name, "Unique among bodies and obstacles.").needed().named_with_letters(),
      field("shape", table(&shape), "Its shape at rest, and at the start but for stretch.")
          .needed(),
      field("material", &material, "Name of a [material.NAME].")
          .with_default("the only material")
          .named_with_letters(),
      field("stretch", &stretch, "", positive,
            "Factors along the axes of the shape, before the rotation: the body starts stretched."),
      field("position", &position, "m", any, "Added to the shape after the rotation."),
      field("rotation_deg", &rotation, "degrees", any, "About the origin: axis times angle."),
      field("velocity", &velocity, "m/s", any, "At the start."),
      field("angular_velocity_deg", &angular_velocity, "degrees/s", any,
            "At the start, about the body's centre: axis times rate."),
      field("thickness", &thickness, "m", not_negative, "Distance kept between its two sides."),
      field("self_contact", &self_contact, "Whether it feels itself."),
      field("pin", tables(&pin), "Vertices held in place or moved; all that any selector names."),
  }};
  result.location = &location;
  return result;
}

Table describe(ObstacleCase& target) {
  auto& [name, shape, position, rotation, thickness, motion, location] = target;
  Table result{{
      field("name", &name, "Unique among bodies and obstacles.").needed().named_with_letters(),
      field("shape", table(&shape), "Its shape.").needed(),
      field("position", &position, "m", any, "Added to the shape after the rotation."),
      field("rotation_deg", &rotation, "degrees", any, "About the origin: axis times angle."),
      field("thickness", &thickness, "m", not_negative, "Distance kept between its two sides."),
      field("motion", table(&motion), "How it moves; without it it stays."),
  }};
  result.location = &location;
  return result;
}

}  // namespace

Table describe(Case& target) {
  auto& [title, time, world, contact, output, compute, material, body, obstacle, path, resolved,
         method_given, method_location, accuracy_location, choice] = target;
  return {{
      field("title", &title, "What the case shows."),
      field("time", table(&time), "How long, how often recorded, how exactly."),
      field("world", table(&world), "What surrounds the bodies."),
      field("contact", table(&contact), "How surfaces keep apart."),
      field("output", table(&output), "What is recorded."),
      field("compute", table(&compute), "What the run may use."),
      field("material", tables(&material, true),
            "What bodies are made of. Without any there is one of defaults, named \"default\"."),
      field("body", tables(&body), "What moves. At least one.").needed(),
      field("obstacle", tables(&obstacle), "What stays, or moves as it is told."),
  }};
}

}  // namespace weft::sim
