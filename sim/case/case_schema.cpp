#include "sim/case/case_schema.h"
#include "sim/case/channels.h"
#include "sim/case/field_makers.h"
#include "sim/case/material_presets.h"
#include "sim/case/time_methods.h"

namespace weft::sim {

namespace {

std::vector<NamedValue<TimeMethod>> named_methods() {
  std::vector<NamedValue<TimeMethod>> values;
  for (const TimeMethodTraits& each : time_methods()) values.push_back({each.method, each.name});
  return values;
}

}  // namespace

// Every describe() below unpacks its struct by a structured binding. A new member of such a struct
// therefore does not compile until the binding names it.

Table describe(TimeCase& target) {
  auto& [method, duration, frames, scale, accuracy, position_tolerance, velocity_tolerance,
         relative_tolerance, step, newton, order, minimum_step, maximum_step, preconditioner,
         sleep] = target;
  return {{
      field("method", choice(&method, named_methods()),
            "Integrator; docs/guide.md says when to use which. cvode: BDF of variable order and "
            "step. arkode: Runge-Kutta of variable step, implicit or explicit as the motion "
            "demands. euler: backward Euler. static: one equilibrium per frame, under gravity that "
            "grows from zero and motions that proceed. implicit_midpoint: fixed steps, for "
            "comparison. verlet: explicit steps, for motion without damping or contact. impulses: "
            "many rigid particles that collide by impulses, without bodies."),
      field("duration", &duration, "s", positive, "Time to simulate."),
      field("frames_per_second", &frames, "1/s", positive, "Frames recorded per second."),
      field(
          "scale", &scale, "", positive,
          "Time scale of movies: simulated seconds per second of the movie. 0.25 shows the motion "
          "four times slower. The simulation does not depend on it."),
      field("accuracy", &accuracy, "m", positive,
            "Error to aim for. The error of a body in a frame is the root mean square, over its "
            "vertices, of the distance from the exact integration in time of the same mesh; the "
            "largest one counts. A calibration chooses the method, unless that is given, and its "
            "tolerances or step. Unless the motion is chaotic, the error is mostly within a factor "
            "3 of this.")
          .with_default("none: tolerances as given"),
      field("position_tolerance", &position_tolerance, "m", positive,
            "Position error allowed per step. With fixed steps of an implicit method: position "
            "error allowed in the solution of each step's equations. With contact at most 0.005 of "
            "contact.range.")
          .not_with("accuracy"),
      field("velocity_tolerance", &velocity_tolerance, "m/s", positive,
            "Velocity error allowed per step; with contact at most 0.5 /s times contact.range.")
          .with_default("100 /s times position_tolerance")
          .not_with("accuracy"),
      field("relative_tolerance", &relative_tolerance, "", {0, 1, true, true},
            "Velocity error allowed per step in addition, as a fraction of the speed.")
          .not_with("accuracy"),
      field("step", &step, "s", positive,
            "Length of fixed steps: longer than minimum_step, at most the duration. "
            "implicit_midpoint needs one. Without one, verlet takes a share of the longest stable "
            "step at the time; the share grows as the square root of relative_tolerance. Without "
            "one, impulses takes a tenth of the time in which a particle falls by half its radius, "
            "or the time between frames if that is shorter. "
            "It cuts steps in which a particle would move by more than 3/4 of the smallest radius.")
          .with_default("chosen by the method")
          .only_for("method", {"euler", "implicit_midpoint", "verlet", "impulses"})
          .not_with("accuracy"),
      field("newton", &newton, "", at_least(0),
            "Newton iterations per step. 1: linearly implicit steps. 0: iterations until they "
            "converge to the tolerances. With contact, iterations are solved again while surfaces "
            "would meet, and steps that stretch edges by 0.03 or gain energy are halved. With a "
            "moving pin or obstacle too, up to two further iterations follow while a particle's "
            "velocity is wrong by more than a tenth of the fastest.")
          .only_for("method", {"euler", "implicit_midpoint"})
          .not_with("accuracy"),
      field("maximum_order", &order, "", {1, 5},
            "Highest order of the BDF method; 3 to 5 need damping in every material and a "
            "position_tolerance of at most 1e-6.")
          .only_for("method", {"cvode"})
          .not_with("accuracy"),
      field("minimum_step", &minimum_step, "s", positive,
            "Shortest step; less than the time between frames. A run that needs more than a few "
            "shorter ones, down to a thousandth of it, stops."),
      field("maximum_step", &maximum_step, "s", positive, "Longest step.")
          .with_default("no limit")
          .only_for("method", {"cvode", "arkode", "euler"}),
      field("preconditioner",
            choice(&preconditioner, {{PreconditionerChoice::automatic, "automatic"},
                                     {PreconditionerChoice::block_jacobi, "block_jacobi"},
                                     {PreconditionerChoice::multigrid, "multigrid"}}),
            "Advanced: preconditioner of the linear systems. The choice changes the run time."),
      field("sleep", &sleep,
            "Lets bodies that have come to rest beside others sleep: they cost next to nothing "
            "until something touches them."),
  }};
}

Table describe(WorldCase& target) {
  auto& [gravity, wind, air_density] = target;
  return {{
      field("gravity", &gravity, "m/s^2", any, "Acceleration of every body."),
      field("wind", &wind, "m/s", any, "Velocity of the air, for drag.").may_be_gust(),
      field("air_density", &air_density, "kg/m^3", not_negative, "Density of the air, for drag."),
  }};
}

Table describe(ContactCase& target) {
  auto& [enabled, range, stiffness, damping_time, friction, friction_speed, sticking_distance,
         search_slack, bound, pair] = target;
  return {{
      field("enabled", &enabled,
            "Enables contact of bodies with each other, themselves and obstacles."),
      field("range", &range, "m", positive, "Gap below which the contact force acts."),
      field("stiffness", &stiffness, "N/m^3", positive,
            "Strength of the barrier per area, independent of the meshes."),
      field("damping_time", &damping_time, "s", not_negative,
            "Contact damping as a time times the contact stiffness. Runs without it are slow."),
      field("friction", &friction, "", not_negative,
            "Coulomb coefficient of all pairs without one of their own."),
      field("friction_speed", &friction_speed, "m/s", positive,
            "Sliding speed from which friction has its full force."),
      field("sticking_distance", &sticking_distance, "m", positive,
            "Contacts that stick are anchored: springs hold them, which give way by at most this "
            "distance before the contact slides.")
          .with_default("contacts that stick creep"),
      field("search_slack", &search_slack, "m", positive,
            "Distance that the contact search adds to the range, so that its result serves many "
            "steps.")
          .with_default("a sixth of the mean edge"),
      field("bound",
            choice(&bound, {{bsi::Bound::sphere, "sphere"},
                            {bsi::Bound::box, "box"},
                            {bsi::Bound::sphere_then_box, "sphere_then_box"}}),
            "Bounding volumes that the search compares above the leaves of the hierarchy. The "
            "result does not depend on it."),
      field("pair", tables(&pair),
            "Friction, and of particles restitution, between two named partners. A pair of bodies "
            "or obstacles precedes a pair of their materials."),
  }};
}

Table describe(OutputCase& target) {
  auto& [velocity, step_energies, channels, frame_times, bodies, part, precision, compression,
         compression_error, checkpoint_every] = target;
  return {{
      field("velocity", &velocity, "Record velocities, as the channel \"velocity\" does."),
      field("step_energies", &step_energies,
            "Record the energies after every step of the integrator, not only those of frames."),
      field("channels", &channels,
            "More to record in every frame, as docs/trajectory.md defines it. Each costs time and "
            "disk space only where it is listed.")
          .entries(0, 0)
          .out_of(channel_names()),
      field("frame_times", &frame_times, "s", not_negative,
            "Times of the frames, increasing, in place of those by time.frames_per_second. Neither "
            "the start nor the end has a frame unless it is listed.")
          .with_default("by time.frames_per_second"),
      field("bodies", &bodies, "Names of the bodies, obstacles and particles that are recorded.")
          .with_default("all"),
      field("part", tables(&part), "Bodies of which only a part of the images is recorded."),
      field("precision",
            choice(&precision, {{Precision::float32, "float32"}, {Precision::float64, "float64"}}),
            "Numbers that positions are recorded as. Fields are float32, series float64."),
      field(
          "compression",
          choice(&compression, {{Compression::none, "none"},
                                {Compression::lossless, "lossless"},
                                {Compression::bounded, "bounded"}}),
          "Compression of positions and fields. lossless: every bit is kept. bounded: coordinates "
          "are rounded within compression_error, fields keep every bit."),
      field("compression_error", &compression_error, "m", positive,
            "Largest change of a coordinate by compression.")
          .only_for("compression", {"bounded"}),
      field("checkpoint_every", &checkpoint_every, "s", positive,
            "Simulated time between two checkpoints, from which weft run --resume goes on. cvode "
            "restarts at each: seldom enough costs less than 2 %.")
          .with_default("500 steps; 5000 of verlet, 10 of static"),
  }};
}

Table describe(OutputPartCase& target) {
  auto& [body, rows, cols, every, location] = target;
  Table result{{
      field("body", &body, "Name of a body or an obstacle that is recorded.")
          .needed()
          .named_with_letters(),
      field("rows", &rows, "", any, "First and last row, counted from 0, negative from the end.")
          .entries(2, 2)
          .with_default("all rows"),
      field("cols", &cols, "", any, "First and last column, counted from 0, negative from the end.")
          .entries(2, 2)
          .with_default("all columns"),
      field("every", &every, "", at_least(1),
            "Records every so many rows and columns, from the first on, and the last ones."),
  }};
  result.location = &location;
  return result;
}

Table describe(ComputeCase& target) {
  auto& [threads, backend, cpu_limit, memory_limit] = target;
  return {{
      field("threads", &threads, "", {1, 1024},
            "Threads of a run; the result does not depend on it. auto: one per 1024 vertices of "
            "simulated bodies, at least one, and at most one per processor and OMP_NUM_THREADS."),
      field(
          "backend",
          choice(&backend, {{ComputeBackend::automatic, "auto"},
                            {ComputeBackend::gpu, "gpu"},
                            {ComputeBackend::osmesa, "osmesa"},
                            {ComputeBackend::cpu, "cpu"}}),
          "Device that finds the candidate pairs of contact. gpu: a graphics processor. osmesa: "
          "OpenGL on the CPU, a slow check of the shaders. cpu: the CPU. auto: graphics processor "
          "or CPU, whichever is measured to be faster. The result does not depend on it, except "
          "that gpu also computes the forces of many contacts, which differ by rounding."),
      field("cpu_limit", &cpu_limit, "s", positive,
            "CPU time that the run may take, all threads together, without that of its set-up "
            "and of --estimate-error. A run that exceeds it ends with its last state, reports how "
            "far it "
            "came, and counts as failed.")
          .with_default("no limit"),
      field("memory_limit", &memory_limit, "MiB", positive,
            "Memory that the scene may need by its estimate, which weft check prints. A case that "
            "needs more is refused before any memory is taken.")
          .with_default("nine tenths of the machine's"),
  }};
}

Table describe(RestartCase& target) {
  auto& [path, time, states, location] = target;
  Table result{{
      field("path", &path, "Trajectory of that run, relative to the case file.").needed(),
      field("time", &time, "s", not_negative,
            "Time of a frame with velocities, or of the last checkpoint.")
          .needed(),
  }};
  result.location = &location;
  return result;
}

Table describe(IncludeCase& target) {
  auto& [path] = target;
  return {{
      field("path", &path, "TOML file, relative to the file that includes it.").needed(),
  }};
}

Table describe(MaterialCase& target) {
  auto& [name, preset, model, density, membrane, membrane_stiffness, poisson_ratio, structural,
         shear, bend, bending_stiffness, youngs_modulus, shell_thickness, volume_density,
         spline_degree, mass_damping, stiffness_damping, bending_damping, loss_factor,
         loss_frequency, strain_limit, yield_curvature, hardening, normal_drag, tangential_drag,
         orthotropic_membrane, measured_membrane, orthotropic_bending] = target;
  Table result{{
      field("preset", &preset,
            "Published material whose values hold for all keys that the case does not give; weft "
            "info --materials lists them.")
          .out_of(preset_names()),
      field("model",
            choice(&model, {{MaterialModel::cloth, "cloth"}, {MaterialModel::shell, "shell"}}),
            "cloth: a membrane with bending of its own, on the triangles of the image. shell: a "
            "Kirchhoff-Love shell, on a smooth spline surface through the image."),
      field("density", &density, "kg/m^2", positive, "Mass per area.").only_for("model", {"cloth"}),
      field("membrane",
            choice(&membrane,
                   {{MembraneModel::triangles, "triangles"}, {MembraneModel::springs, "springs"}}),
            "Stretching: triangles, isotropic or woven, or springs along rows, columns and "
            "diagonals.")
          .only_for("model", {"cloth"}),
      field("membrane_stiffness", &membrane_stiffness, "N/m", not_negative,
            "Young's modulus times thickness.")
          .only_for("model", {"cloth"})
          .not_with("orthotropic_membrane")
          .not_with("measured_membrane"),
      field("poisson_ratio", &poisson_ratio, "", {-1, 1, true, true},
            "Poisson's ratio. Of cloth: in the plane, of isotropic triangles and of bending. Of a "
            "shell: of the solid, at most 0.5."),
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
      field("bending_stiffness", &bending_stiffness, "N m", not_negative,
            "Bending stiffness of the plate.")
          .only_for("model", {"cloth"})
          .not_with("orthotropic_bending"),
      field("youngs_modulus", &youngs_modulus, "Pa", positive, "Young's modulus of the solid.")
          .needed()
          .only_for("model", {"shell"}),
      field("shell_thickness", &shell_thickness, "m", positive, "Thickness of the shell.")
          .needed()
          .only_for("model", {"shell"}),
      field("volume_density", &volume_density, "kg/m^3", positive, "Mass per volume.")
          .needed()
          .only_for("model", {"shell"}),
      field("spline_degree", &spline_degree, "", {2, 3, false, false},
            "Degree of the splines; 2 is cheaper per control point, with larger errors.")
          .only_for("model", {"shell"}),
      field("mass_damping", &mass_damping, "1/s", not_negative,
            "Damping force per mass and velocity."),
      field("stiffness_damping", &stiffness_damping, "s", not_negative,
            "Damping of the membrane, or its springs, as a time times its stiffness.")
          .not_with("loss_factor"),
      field("bending_damping", &bending_damping, "s", not_negative,
            "Damping of bending as a time times its stiffness.")
          .not_with("loss_factor"),
      field("loss_factor", &loss_factor, "", positive,
            "Measured loss factor of membrane and bending at loss_frequency, in place of the "
            "damping times: the energy lost in a radian of vibration over the largest elastic "
            "energy. At other frequencies it is proportional to the frequency.")
          .with_default("none: damping times as given"),
      field("loss_frequency", &loss_frequency, "Hz", positive,
            "Frequency at which the loss_factor holds; needed with it.")
          .with_default("none"),
      field("strain_limit", &strain_limit, "", positive,
            "Largest principal strain of the membrane, as a fraction of the length. From half of "
            "it on the membrane stiffens without bound: no accepted step exceeds it.")
          .with_default("no limit")
          .only_for("model", {"cloth"}),
      field("yield_curvature", &yield_curvature, "1/m", positive,
            "Elastic curvature at which bending yields and leaves a crease.")
          .with_default("never: bending is elastic")
          .only_for("model", {"cloth"}),
      field("hardening", &hardening, "", {0, 1, false, true},
            "Stiffness of bending that yields, as a fraction of bending_stiffness.")
          .with_default("0 where bending yields")
          .only_for("model", {"cloth"}),
      field("normal_drag", &normal_drag, "", not_negative,
            "Drag coefficient of air that moves across the surface."),
      field("tangential_drag", &tangential_drag, "", not_negative,
            "Drag coefficient of air that moves along the surface."),
      field("orthotropic_membrane", table(&orthotropic_membrane),
            "Stretching of woven triangles, whose stiffness differs along warp, weft and in shear. "
            "body.warp_angle_deg is the direction of the warp.")
          .only_for("membrane", {"triangles"}),
      field("measured_membrane", table(&measured_membrane),
            "Stretching of triangles with measured coefficients, which depend on the stretch and "
            "its angle to the warp. Each has six values: without stretch, and stretched by a sixth "
            "at 0, 22.5, 45, 67.5 and 90 degrees. docs/theory.md has the law.")
          .only_for("membrane", {"triangles"})
          .not_with("orthotropic_membrane"),
      field("orthotropic_bending", table(&orthotropic_bending),
            "Bending whose stiffness differs along the warp, at 45 degrees to it and along the "
            "weft, and may depend on the curvature.")
          .only_for("model", {"cloth"}),
  }};
  result.name = &name;
  return result;
}

Table describe(ShapeCase& target) {
  auto& [type, size, resolution, patches, radius, top_radius, length, inner_radius, outer_radius,
         major_radius, minor_radius, latitude, angle, path, dataset, wrap_u, wrap_v, location] =
      target;
  Table result{{
      field("type",
            choice(&type, {{ShapeType::rectangle, "rectangle"},
                           {ShapeType::plane, "plane"},
                           {ShapeType::disc, "disc"},
                           {ShapeType::annulus, "annulus"},
                           {ShapeType::box, "box"},
                           {ShapeType::cylinder, "cylinder"},
                           {ShapeType::capsule, "capsule"},
                           {ShapeType::cone, "cone"},
                           {ShapeType::torus, "torus"},
                           {ShapeType::sphere, "sphere"},
                           {ShapeType::sphere_sector, "sphere_sector"},
                           {ShapeType::blob, "blob"},
                           {ShapeType::file, "file"}}),
            "In the x-y plane: a rectangle; a plane, which is a large rectangle of few vertices, "
            "for floors; a disc; an annulus. Around the z axis: a cylinder, open at both ends; a "
            "capsule, which is a cylinder between two hemispheres; a cone, open at its base; a "
            "torus; a sphere_sector, which is the part of a sphere between two latitudes. A box "
            "with sharp edges; a sphere; a blob, which is a sphere with dents; positions from an "
            "HDF5 file. All but those from a file are centred on the origin. Normals point "
            "outwards, or along +z.")
          .needed(),
      field("size", &size, "m", positive, "Lengths along x, y and, of a box, z.")
          .needed()
          .entries(2, 3)
          .only_for("type", {"rectangle", "plane", "box"}),
      field("resolution", &resolution, "", at_least(2),
            "Vertices. rectangle: [rows, cols], rows along y. annulus, cylinder, sphere_sector, "
            "and cone with a top_radius: [rows, cols], at least 3 columns around in a full turn; "
            "rows from the outer radius inwards, or upwards along z. torus: [rows, cols], at least "
            "3 rows around the axis and 3 columns around the tube. box: [x, y, z] along the axes; "
            "a body is cheaper where these numbers less 1 have a large common divisor, which makes "
            "large patches. capsule: [rows, n], rows of its straight part and n along an eighth of "
            "the way around; rows - 1 is best a multiple of n - 1. sphere: [n] along an "
            "edge of each of its six patches. disc, and cone with an apex: [n] along an edge of "
            "each of their 12 patches. blob: [n] columns and 2 n - 1 rows of each of its 48 "
            "patches.")
          .needed()
          .entries(1, 3)
          .only_for("type", {"rectangle", "disc", "annulus", "box", "cylinder", "capsule", "cone",
                             "torus", "sphere", "sphere_sector", "blob"}),
      field("patches", &patches, "", at_least(1),
            "[rows, cols] of patches into which the image is cut: patches of one size, sewn where "
            "they meet and numbered row by row. The image's quads along each axis must divide "
            "evenly.")
          .entries(2, 2)
          .with_default("one")
          .only_for("type", {"rectangle", "annulus", "cylinder", "torus", "sphere_sector"}),
      field("radius", &radius, "m", positive, "Radius; of a cone: at its base, at the bottom.")
          .needed()
          .only_for("type",
                    {"disc", "cylinder", "capsule", "cone", "sphere", "sphere_sector", "blob"}),
      field("top_radius", &top_radius, "m", not_negative,
            "Radius of a cone at the top, where a frustum is open; 0 is an apex.")
          .only_for("type", {"cone"}),
      field("length", &length, "m", positive,
            "Length along z; of a capsule: of its straight part, between the hemispheres.")
          .needed()
          .only_for("type", {"cylinder", "capsule", "cone"}),
      field("inner_radius", &inner_radius, "m", positive, "Radius of the hole.")
          .needed()
          .only_for("type", {"annulus"}),
      field("outer_radius", &outer_radius, "m", positive,
            "Radius of the rim; more than the inner radius.")
          .needed()
          .only_for("type", {"annulus"}),
      field("major_radius", &major_radius, "m", positive,
            "Distance from the axis to the tube's centre.")
          .needed()
          .only_for("type", {"torus"}),
      field("minor_radius", &minor_radius, "m", positive,
            "Radius of the tube; less than the major radius.")
          .needed()
          .only_for("type", {"torus"}),
      field("latitude_deg", &latitude, "degrees", {-85, 85},
            "Latitudes [south, north] between which the sector lies; the equator is in the x-y "
            "plane. Cells would shrink to nothing at the poles.")
          .needed()
          .entries(2, 2)
          .only_for("type", {"sphere_sector"}),
      field("angle_deg", &angle, "degrees", {0, 360, true, false},
            "Angle around the z axis, from the x axis, counter-clockwise seen from +z. 360: a full "
            "turn, closed; less: a sector.")
          .only_for("type", {"annulus", "cylinder", "sphere_sector"}),
      field("path", &path, "HDF5 file, relative to the file that names it.")
          .needed()
          .only_for("type", {"file"}),
      field("dataset", &dataset,
            "Name of the dataset of positions, in m: [rows, cols, 3] or [patches, rows, cols, 3].")
          .needed()
          .only_for("type", {"file"}),
      field("wrap_u", &wrap_u, "Join the last column to the first.").only_for("type", {"file"}),
      field("wrap_v", &wrap_v, "Join the last row to the first.").only_for("type", {"file"}),
  }};
  result.location = &location;
  return result;
}

Table describe(StartCase& target) {
  auto& [shape, bend_radius, bend_direction, location] = target;
  Table result{{
      field("shape", table(&shape),
            "Shape in which the body starts: its image must be like that of the rest shape, with "
            "as many rows, columns and patches, and closed and sewn alike.")
          .not_with("bend_radius"),
      field("bend_radius", &bend_radius, "m", any,
            "Radius of the cylinder onto which the rest shape is bent; lengths in the plane z = 0 "
            "do not change. Positive: its borders move towards +z; negative: towards -z. Not 0."),
      field("bend_direction_deg", &bend_direction, "degrees", any,
            "Direction in which the bent surface curves, from the x towards the y axis.")
          .with_default("0: towards x"),
  }};
  result.location = &location;
  return result;
}

Table describe(BodyCase& target) {
  auto& [name, shape, material, start, stretch, position, rotation, velocity, angular_velocity,
         thickness, warp_angle, control_net, self_contact, pin, location] = target;
  Table result{{
      field("name", &name, "Name, unique among bodies, obstacles and particles.")
          .needed()
          .named_with_letters(),
      field("shape", table(&shape),
            "Shape without strain; the body starts in it unless it has a start or is stretched.")
          .needed(),
      field("material", &material, "Name of a [material.NAME].")
          .with_default("the only material")
          .named_with_letters(),
      field("start", table(&start), "Shape in which the body starts; stretch and rotation follow.")
          .with_default("the rest shape"),
      field("stretch", &stretch, "", positive,
            "Factors by which the body starts stretched along the axes of the shape, before the "
            "rotation."),
      field("position", &position, "m", any, "Translation, after the rotation."),
      field("rotation_deg", &rotation, "degrees", any,
            "Rotation about the origin: axis times angle."),
      field("velocity", &velocity, "m/s", any, "Velocity at the start."),
      field("angular_velocity_deg", &angular_velocity, "degrees/s", any,
            "Angular velocity at the start, about the body's centre of mass: axis times rate."),
      field(
          "thickness", &thickness, "m", not_negative,
          "Thickness in contact: two surfaces stay farther apart than the mean of theirs. In "
          "meshes finer than thickness + contact.range, parts of one body closer than pi/2 "
          "thickness + contact.range along its surface at rest are not in contact, but never "
          "cross. That of a shell, given or not, grows by twice the farthest distance of its rest "
          "surface from the triangles of contact.")
          .with_default("1e-3; of a shell its shell_thickness"),
      field("warp_angle_deg", &warp_angle, "degrees", any,
            "Of woven cloth: angle of the warp to the rows of the image, towards its columns. The "
            "weft is a quarter turn further."),
      field("control_net", &control_net,
            "Of a shell: takes the points of the image as the control points of its surface, "
            "instead of points on it."),
      field("self_contact", &self_contact, "Enables contact of the body with itself."),
      field("pin", tables(&pin), "Vertices held in place or moved: all that any selector names."),
  }};
  result.location = &location;
  return result;
}

Table describe(ObstacleCase& target) {
  auto& [name, shape, position, rotation, thickness, material, motion, location] = target;
  Table result{{
      field("name", &name, "Name, unique among bodies, obstacles and particles.")
          .needed()
          .named_with_letters(),
      field("shape", table(&shape), "Shape of the obstacle.").needed(),
      field("position", &position, "m", any, "Translation, after the rotation."),
      field("rotation_deg", &rotation, "degrees", any,
            "Rotation about the origin: axis times angle."),
      field("thickness", &thickness, "m", not_negative,
            "Thickness in contact: two surfaces stay farther apart than the mean of theirs."),
      field("material", &material,
            "Name of a [material.NAME], by which pairs of contact find the obstacle. Only its name "
            "matters.")
          .named_with_letters(),
      field("motion", table(&motion), "Motion of the obstacle; without it it stays at rest."),
  }};
  result.location = &location;
  return result;
}

Table describe(Case& target) {
  auto& [title, time, equilibria, world, contact, output, compute, restart, include, material, body,
         obstacle, particles, tie, load, seam, outputs, path, included, resolved, method_given,
         method_location, accuracy_location, choice] = target;
  return {{
      field("title", &title, "Short description of the case."),
      field("time", table(&time), "Integration in time: duration, frames, method and tolerances."),
      field("static",
            TableMember{[&of = time] { return traits_of(of.method).finds_equilibria(); },
                        [&of = equilibria] { return describe(of); }},
            "Equilibria: the course of their loads. Only with time.method = \"static\"."),
      field("world", table(&world), "Gravity and air."),
      field("contact", table(&contact), "Contact between surfaces."),
      field("output", table(&output), "Quantities that are recorded beside the positions."),
      field("compute", table(&compute), "Resources of the run."),
      field("restart", table(&restart),
            "State of another run in which the bodies start, by their names. It replaces their "
            "start, stretch, position, rotation and velocities; images of other resolutions are "
            "resampled."),
      field("include", tables(&include),
            "Files that hold [material.NAME], [[obstacle]] and further [[include]] of the case; "
            "docs/guide.md says how they join."),
      field("material", tables(&material, true),
            "Materials of bodies. A case without any has one of defaults, named \"default\"."),
      field("body", tables(&body),
            "Surfaces that are simulated; a case has at least one [[body]] or [[particles]]."),
      field("obstacle", tables(&obstacle),
            "Surfaces that stay at rest or follow a prescribed motion."),
      field("particles", tables(&particles),
            "Groups of spheres that move as rigid bodies. time.method = \"impulses\" simulates "
            "many of them with obstacles; cvode, arkode and euler simulate them with bodies, too."),
      field("tie", tables(&tie),
            "Springs between vertices of a body and another body or an obstacle."),
      field("load", tables(&load), "Forces that act on bodies from outside."),
      field("seam", tables(&seam), "Borders of bodies that are sewn together."),
      field("outputs", &outputs,
            "Numbers that the run reports at its end: expressions over what it records, such as "
            "\"max(largest_stretch)\", by name. docs/guide.md lists what they may use."),
  }};
}

}  // namespace weft::sim
