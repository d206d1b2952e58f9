// Particles and pairs that must be refused.
#include "bad_case.h"
#include "sim/run/initial_state.h"
#include "sim/scene/scene.h"

namespace weft::sim::bad_particles_test {
namespace {

const std::string head = "[time]\nmethod = \"impulses\"\n";
// Lines 3 to 6 of the cases.
const std::string balls =
    "[[particles]]\nname = \"balls\"\nradius = 0.1\n"
    "positions = { type = \"grid\", count = [2, 2, 1] }\n";
const std::string floor_below =
    "[[obstacle]]\nname = \"floor\"\nposition = [0, 0, -0.2]\n"
    "shape = { type = \"plane\", size = [9, 9] }\n";

std::vector<BadCase> bad_particles() {
  return {
      {"nothing_to_simulate", head, R"(case.toml:1:1: the case has no "body"
  expected tables [[body]] or [[particles]])"},
      {"no_radius",
       head +
           "[[particles]]\nname = \"balls\"\npositions = { type = \"grid\", count = [1, 1, 1] }\n",
       R"(case.toml:3:1: [[particles]] has no "radius"
  expected "radius", a number > 0 (m))"},
      {"radius_of_zero",
       head + "[[particles]]\nname = \"balls\"\nradius = 0\n"
              "positions = { type = \"grid\", count = [1, 1, 1] }\n",
       R"(case.toml:5:10: "radius" is 0
  expected a number > 0 (m))"},
      {"negative_radius",
       head + "[[particles]]\nname = \"balls\"\nradius = -0.1\n"
              "positions = { type = \"grid\", count = [1, 1, 1] }\n",
       R"(case.toml:5:10: "radius" is -0.1
  expected a number > 0 (m))"},
      {"number_beyond_integers",
       head + "[[particles]]\nname = \"balls\"\nradius = 0.1\n"
              "positions = { type = \"random\", number = 3000000000, region_min = [0, 0, 0], "
              "region_max = [1, 1, 1] }\n",
       R"(case.toml:6:41: "number" is 3000000000
  expected a whole number from -2147483648 to 2147483647)"},
      {"null_character_in_a_path",
       head + "[[particles]]\nname = \"balls\"\nradius = 0.1\n"
              "positions = { type = \"file\", path = \"ok.h5\\u0000junk\", dataset = \"p\" }\n",
       R"(case.toml:6:37: "path" has a null character
  expected a string)"},
      {"restitution_above_one", head + balls + "restitution = 1.5\n",
       R"(case.toml:7:15: "restitution" is 1.5
  expected a number >= 0 and <= 1)"},
      {"negative_restitution", head + balls + "restitution = -0.1\n",
       R"(case.toml:7:15: "restitution" is -0.1
  expected a number >= 0 and <= 1)"},
      {"negative_friction", head + balls + "friction = -1\n",
       R"(case.toml:7:12: "friction" is -1
  expected a number >= 0)"},
      {"unknown_key", head + balls + "restitutoin = 0.5\n",
       R"(case.toml:7:1: unknown key "restitutoin" in [[particles]]
  did you mean "restitution"?)"},
      {"load_of_particles",
       "[contact]\nfriction = 0\n" + balls +
           "[[load]]\nbody = \"balls\"\nforce = [0, 0, 1]\ncorners = [\"all\"]\n",
       R"(case.toml:8:8: no body "balls"
  there is none that could be named here)"},
      {"unknown_places",
       head + "[[particles]]\nname = \"balls\"\nradius = 0.1\npositions = { type = \"gird\" }\n",
       R"(case.toml:6:22: "type" is "gird"
  did you mean "grid"?)"},
      {"overlapping_grid",
       head + "[[particles]]\nname = \"balls\"\nradius = 0.1\n"
              "positions = { type = \"grid\", count = [2, 1, 1], spacing = 0.19 }\n",
       R"(case.toml:6:59: a spacing of 0.19 m makes particles overlap
  expected at least twice the radius, 0.2 m)"},
      {"upside_down_region",
       head + "[[particles]]\nname = \"balls\"\nradius = 0.1\npositions = { type = \"random\", "
              "number = 2, region_min = [0, 0, 1], region_max = [1, 1, 0] }\n",
       R"(case.toml:6:81: region_max is below region_min
  expected a box whose upper corner is at least as high along x, y and z)"},
      {"another_method", "[time]\nmethod = \"verlet\"\n" + balls,
       R"(case.toml:4:8: particles "balls" with time.method = "verlet"
  expected time.method = "cvode", "arkode" or "euler", or, without bodies, "impulses")"},
      {"body_with_impulses", head + balls + sheet,
       R"(case.toml:8:8: body "sheet" with time.method = "impulses"
  expected [[particles]] and [[obstacle]] only, or time.method = "cvode", which simulates bodies and particles together)"},
      {"turning_without_spin", balls + "spin = false\nangular_velocity_deg = [0, 0, 1]\n",
       R"(case.toml:6:24: an angular velocity of particles "balls" with spin = false
  expected none, or spin = true)"},
      {"touching_grid_with_cvode",
       "[[particles]]\nname = \"balls\"\nradius = 0.1\n"
       "positions = { type = \"grid\", count = [2, 1, 1], spacing = 0.2 }\n",
       R"(case.toml:4:59: a spacing of 0.2 m makes particles touch
  expected at least 0.2002 m with time.method = "cvode", which needs gaps)"},
      {"accuracy_of_particles", "[time]\naccuracy = 1e-3\n" + balls,
       R"(case.toml:2:12: a case with particles has no calibrated accuracy
  expected time.position_tolerance and time.relative_tolerance, or time.step)"},
      {"restitution_of_cloth",
       balls + sheet + "[[contact.pair]]\nbetween = [\"balls\", \"sheet\"]\nrestitution = 0.3\n",
       R"(case.toml:10:15: a restitution in the pair of "balls" and "sheet"
  expected "friction" only: cloth has no restitution of its own; how it rebounds follows from its stiffness, its damping and contact.damping_time)"},
      {"name_twice", head + balls + balls, R"(case.toml:8:8: a second "balls"
  expected a name that no other body, obstacle or particles have; the first is in [[particles]])"},
      {"name_of_an_obstacle",
       head + floor_below +
           "[[particles]]\nname = \"floor\"\nradius = 0.1\n"
           "positions = { type = \"grid\", count = [1, 1, 1] }\n",
       R"(case.toml:8:8: a second "floor"
  expected a name that no other body, obstacle or particles have; the first is in [[obstacle]])"},
      {"pair_of_an_unknown_name",
       head + balls + floor_below + "[[contact.pair]]\nbetween = [\"balls\", \"flor\"]\n",
       R"(case.toml:12:21: no particles or obstacle "flor"
  did you mean "floor"?)"},
      {"pair_of_a_material",
       head + balls + floor_below +
           "[[contact.pair]]\nbetween = [\"balls\", \"ice\"]\n[material.ice]\n",
       R"(case.toml:12:21: no particles or obstacle "ice"
  expected particles or an obstacle, not a material: particles have none)"},
      {"pair_of_obstacles",
       head + balls + floor_below + "[[contact.pair]]\nbetween = [\"floor\", \"floor\"]\n",
       R"(case.toml:12:11: a pair of two obstacles
  expected particles as one of the two: obstacles do not collide with each other)"},
      {"pair_without_numbers",
       head + balls + floor_below + "[[contact.pair]]\nbetween = [\"balls\", \"floor\"]\n",
       R"(case.toml:12:11: the pair of "balls" and "floor" has no "restitution" and no "friction"
  expected at least one of them)"},
      {"pair_twice",
       head + balls + floor_below +
           "[[contact.pair]]\nbetween = [\"floor\", \"balls\"]\nfriction = 0\n" +
           "[[contact.pair]]\nbetween = [\"balls\", \"floor\"]\n",
       R"(case.toml:15:11: a second pair of "balls" and "floor"
  expected each pair once)"},
      {"pair_with_too_large_a_restitution",
       head + balls + floor_below +
           "[[contact.pair]]\nbetween = [\"floor\", \"balls\"]\nrestitution = 1.01\n",
       R"(case.toml:13:15: "restitution" is 1.01
  expected a number >= 0 and <= 1)"},
      {"part_of_particles", head + balls + "[[output.part]]\nbody = \"balls\"\nrows = [0, 1]\n",
       R"(case.toml:8:8: a part of particles "balls"
  expected a body or an obstacle, whose images have rows and columns)"},
      {"channel_of_surfaces", head + balls + "[output]\nchannels = [\"body_energy\"]\n",
       R"(case.toml:8:13: the channel "body_energy" is not recorded with time.method = "impulses"
  expected channels among "velocity" and "angular_velocity")"},
      {"channel_without_bodies", balls + "[output]\nchannels = [\"contact_force\"]\n",
       R"(case.toml:6:13: the channel "contact_force" would be missing: particles do not have it
  expected a [[body]], or no "contact_force")"},
      {"stretch_without_bodies", balls + "[output]\nchannels = [\"largest_stretch_place\"]\n",
       R"(case.toml:6:13: the channel "largest_stretch_place" would be missing: particles do not have it
  expected a [[body]], or no "largest_stretch_place")"},
      {"nothing_turns", head + balls + "[output]\nchannels = [\"angular_velocity\"]\n",
       R"(case.toml:8:13: the channel "angular_velocity" would be zero: no particles turn
  expected particles with spin = true, and with friction or an angular velocity, or no "angular_velocity")"},
  };
}

class BadParticles : public testing::TestWithParam<BadCase> {};

TEST_P(BadParticles, AreRefused) { expect_refused(GetParam()); }

INSTANTIATE_TEST_SUITE_P(Cases, BadParticles, testing::ValuesIn(bad_particles()), bad_case_name);

std::vector<BadCase> bad_starts() {
  const std::string group = "[[particles]]\nname = \"others\"\nradius = 0.1\n";
  return {
      {"too_far_for_their_size",
       head + "[[particles]]\nname = \"balls\"\nradius = 0.1\n"
              "positions = { type = \"grid\", count = [1, 1, 1], centre = [0, -1e300, 0] }\n",
       R"(case.toml:6:13: particles "balls" are 1e+300 m from the origin
  expected at most 1e+11 m: rounding moves farther ones by a part of their radius)"},
      {"too_far",
       head + "[[particles]]\nname = \"balls\"\nradius = 1e4\n"
              "positions = { type = \"grid\", count = [1, 1, 1], centre = [0, -2e15, 0] }\n",
       R"(case.toml:6:13: particles "balls" are 2e+15 m from the origin
  expected at most 1e+15 m)"},
      {"too_heavy",
       head + "[[particles]]\nname = \"balls\"\nradius = 1e40\n"
              "positions = { type = \"grid\", count = [1, 1, 1] }\n",
       R"(case.toml:3:1: particles "balls" have a mass of 4.18879e+123 kg each
  expected a radius and a density of masses from 1e-100 to 1e+100 kg)"},
      {"too_light",
       head + "[[particles]]\nname = \"balls\"\nradius = 0.1\ndensity = 1e-100\n"
              "positions = { type = \"grid\", count = [1, 1, 1] }\n",
       R"(case.toml:3:1: particles "balls" have a mass of 4.18879e-103 kg each
  expected a radius and a density of masses from 1e-100 to 1e+100 kg)"},
      {"region_too_far",
       head + "[[particles]]\nname = \"balls\"\nradius = 0.1\n"
              "positions = { type = \"random\", number = 2, region_min = [-1e308, 0, 0], "
              "region_max = [1e308, 1, 1] }\n",
       R"(case.toml:6:13: particles "balls" are 1e+308 m from the origin
  expected at most 1e+11 m: rounding moves farther ones by a part of their radius)"},
      {"overlap_of_two_groups",
       head + balls + group +
           "positions = { type = \"grid\", count = [1, 1, 1], centre = [0.2, 0.11, 0.15] }\n",
       R"(case.toml:10:13: particles "balls", number 3 overlaps particles "others", number 0 by 0.0250714 m at the start
  expected particles that do not overlap anything)"},
      {"overlap_of_a_floor",
       head + balls +
           "[[obstacle]]\nname = \"floor\"\nposition = [0, 0, -0.09]\n"
           "shape = { type = \"plane\", size = [9, 9] }\n",
       R"(case.toml:6:13: particles "balls", number 0 overlaps obstacle "floor" by 0.0105 m at the start, the first of 4 overlapping pairs
  expected particles that do not overlap anything)"},
      {"overlap_of_a_sheet",
       balls + "[[body]]\nname = \"sheet\"\nposition = [0, 0, -0.09]\n"
               "shape = { type = \"rectangle\", size = [2, 2], resolution = [2, 2] }\n",
       R"(case.toml:4:13: particles "balls", number 0 overlaps body "sheet", row 1, column 0 by 0.0105 m at the start
  expected particles with a gap around them)"},
      {"overlap_of_two_groups_with_cvode",
       balls + group +
           "positions = { type = \"grid\", count = [1, 1, 1], centre = [0.2, 0.11, 0.15] }\n",
       R"(case.toml:8:13: particles "balls", number 3 overlaps particles "others", number 0 by 0.0250714 m at the start
  expected particles with a gap around them)"},
      {"overlap_by_jitter",
       head +
           "[[particles]]\nname = \"balls\"\nradius = 0.1\n"
           "positions = { type = \"grid\", count = [2, 1, 1], spacing = 0.2, jitter = 0.01, seed "
           "= 3 }\n",
       R"(case.toml:6:13: particles "balls", number 0 overlaps particles "balls", number 1 by 0.00405909 m at the start
  expected particles that do not overlap anything)"},
      {"no_room",
       head + "[[particles]]\nname = \"balls\"\nradius = 0.1\npositions = { type = \"random\", "
              "number = 9, region_min = [0, 0, 0], region_max = [0.1, 0.1, 0.1] }\n",
       R"(case.toml:6:13: found room for 1 of 9 particles "balls"
  expected a larger region, or fewer or smaller particles)"},
      {"missing_file",
       head + "[[particles]]\nname = \"balls\"\nradius = 0.1\npositions = { type = \"file\", "
              "path = \"none.h5\", dataset = \"x\" }\n",
       R"(case.toml:6:13: none.h5: no such file)"},
  };
}

class BadStarts : public testing::TestWithParam<BadCase> {};

TEST_P(BadStarts, AreRefused) {
  const BadCase& bad = GetParam();
  try {
    check_initial_state(*build_scene(parse_case(bad.text, "case.toml")));
    FAIL() << "accepted:\n" << bad.text;
  } catch (const CaseError& error) {
    EXPECT_EQ(error.what(), bad.what);
  }
}

INSTANTIATE_TEST_SUITE_P(Cases, BadStarts, testing::ValuesIn(bad_starts()), bad_case_name);

TEST(ParticlePlaces, MayTouch) {
  const std::string text = head +
                           "[[particles]]\nname = \"balls\"\nradius = 0.1\npositions = { type = "
                           "\"grid\", count = [5, 5, 5], spacing = 0.2 }\n[[obstacle]]\n"
                           "name = \"floor\"\nposition = [0, 0, -0.5]\nthickness = 0\n"
                           "shape = { type = \"plane\", size = [9, 9] }\n";
  EXPECT_NO_THROW(check_initial_state(*build_scene(parse_case(text, "case.toml"))));
}

}  // namespace
}  // namespace weft::sim::bad_particles_test
