// Describes the tables of particles and of contact between named partners.
#include "sim/case/case_schema.h"
#include "sim/case/field_makers.h"

namespace weft::sim {

Table describe(PositionsCase& target) {
  auto& [type, count, spacing, centre, jitter, number, region_min, region_max, seed, path, dataset,
         location] = target;
  Table result{{
      field("type",
            choice(&type, {{PositionsType::grid, "grid"},
                           {PositionsType::random, "random"},
                           {PositionsType::file, "file"}}),
            "grid: a lattice of equal distances. random: places in a box at which particles do not "
            "overlap. file: centres from an HDF5 file.")
          .needed(),
      field("count", &count, "", at_least(1), "Particles along x, y and z.")
          .needed()
          .entries(3, 3)
          .only_for("type", {"grid"}),
      field("spacing", &spacing, "m", positive, "Distance of neighbours in the lattice.")
          .with_default("2.2 times the radius")
          .only_for("type", {"grid"}),
      field("centre", &centre, "m", any, "Centre of the lattice.").only_for("type", {"grid"}),
      field("jitter", &jitter, "m", not_negative,
            "Largest random displacement from the lattice along each axis.")
          .only_for("type", {"grid"}),
      field("number", &number, "", at_least(1), "Number of particles.")
          .needed()
          .only_for("type", {"random"}),
      field("region_min", &region_min, "m", any, "Lower corner of the box that holds the centres.")
          .needed()
          .only_for("type", {"random"}),
      field("region_max", &region_max, "m", any, "Upper corner of the box that holds the centres.")
          .needed()
          .only_for("type", {"random"}),
      field("seed", &seed, "", at_least(0), "Seed of random places and of jitter.")
          .only_for("type", {"grid", "random"}),
      field("path", &path, "HDF5 file, relative to the case file.")
          .needed()
          .only_for("type", {"file"}),
      field("dataset", &dataset, "Name of the dataset [n, 3] of centres, in m.")
          .needed()
          .only_for("type", {"file"}),
  }};
  result.location = &location;
  return result;
}

Table describe(ParticlesCase& target) {
  auto& [name, positions, radius, density, velocity, angular_velocity, spin, restitution, friction,
         drag_coefficient, location] = target;
  Table result{{
      field("name", &name, "Name, unique among bodies, obstacles and particles.")
          .needed()
          .named_with_letters(),
      field("positions", table(&positions), "Places of the centres at the start.").needed(),
      field("radius", &radius, "m", positive, "Radius of each particle.").needed(),
      field("density", &density, "kg/m^3", positive, "Mass per volume."),
      field("velocity", &velocity, "m/s", any, "Velocity at the start."),
      field("angular_velocity_deg", &angular_velocity, "degrees/s", any,
            "Angular velocity of each particle at the start, about its centre: axis times rate. "
            "Needs spin = true."),
      field("spin", &spin,
            "Lets friction turn the particles, as solid spheres. Without it they only slide."),
      field("restitution", &restitution, "", {0, 1},
            "Speed of parting after an impact, divided by the speed of approach. Between two "
            "groups the larger number holds. Cloth has its own elasticity and damping instead."),
      field("friction", &friction, "", not_negative,
            "Coulomb coefficient. Between two groups the geometric mean holds.")
          .with_default("contact.friction"),
      field("drag_coefficient", &drag_coefficient, "", not_negative,
            "Drag coefficient of air, on the area of the cross-section; 0.47 for a smooth sphere."),
  }};
  result.location = &location;
  return result;
}

Table describe(ContactPairCase& target) {
  auto& [between, restitution, friction, location] = target;
  Table result{{
      field("between", &between,
            "Two names of bodies, obstacles and particles, or of two materials. The same name "
            "twice: a body with itself, or particles of one group among themselves.")
          .needed()
          .entries(2, 2),
      field("restitution", &restitution, "", {0, 1},
            "Of particles: speed of parting after an impact, divided by the speed of approach.")
          .with_default("by the particles"),
      field("friction", &friction, "", not_negative,
            "Coulomb coefficient. Needed without particles.")
          .with_default("by the particles"),
  }};
  result.location = &location;
  return result;
}

}  // namespace weft::sim
