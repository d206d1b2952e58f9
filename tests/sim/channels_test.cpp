// Forces, reactions, energies and places that a run records, against weights
// and momenta.
#include <gtest/gtest.h>

#include <cmath>

#include "sim/case/memory_estimate.h"
#include "sim/run/recorded_run.h"
#include "sim/trajectory/trajectory.h"
#include "sim/view/output_description.h"
#include "sim/view/scene_description.h"
#include "tests/sim/bad_case.h"
#include "tests/sim/channel_run.h"
#include "tests/temporary_folder.h"

namespace weft::sim::channels_test {
namespace {

const std::string sheet_in_air = R"(
[time]
duration = 0.5
frames_per_second = 50
position_tolerance = 1e-8
[output]
channels = ["reactions"]
[contact]
enabled = false
[material.cloth]
bending_stiffness = 1e-4
[[body]]
name = "sheet"
position = [0.3, 0.2, 1]
shape = { type = "rectangle", size = [1, 0.8], resolution = [9, 9] }
[[body.pin]]
corners = ["last_first"]
[[body.pin]]
corners = ["last_last"]
)";

// The forces and moments of the pins balance the weight.
TEST(Reactions, HangingSheetRestsOnItsPins) {
  ChannelRun run(sheet_in_air, {"time.method=\"static\"", "time.duration=1"});
  run.advance_to(1);
  const Vec3 weight = run.weight();
  EXPECT_NEAR(weight.z(), -0.2 * 0.8 * 9.81, 1e-12);
  EXPECT_LT((run.sum_of_reactions("force") + weight).norm(), 1e-6 * weight.norm());
  EXPECT_LT((run.sum_of_reactions("moment") + run.weight_moment()).norm(), 1e-6 * weight.norm());
  // Each pin carries half, and they pull the sheet apart.
  const Vec3 one = run.vector("reactions/sheet/pin_1/force");
  const Vec3 other = run.vector("reactions/sheet/pin_2/force");
  EXPECT_NEAR(one.z(), -0.5 * weight.z(), 0.01 * weight.norm());
  EXPECT_LT(one.x(), 0);
  EXPECT_GT(other.x(), 0);
}

// Over a swing, the impulses of the pins, of the weight and of mass damping
// (1/s) are the change of momentum, and their moments that of the angular
// momentum. Trapezoids over 0.5 ms leave less than a thousandth where nothing
// meets.
void expect_balance(ChannelRun& run, double from, double to, double tolerance,
                    double interval = 5e-4, double mass_damping = 0) {
  const auto force_now = [&]() -> Vec3 {
    return run.sum_of_reactions("force") + run.weight() - mass_damping * run.momentum();
  };
  const auto moment_now = [&]() -> Vec3 {
    return run.sum_of_reactions("moment") + run.weight_moment() -
           mass_damping * run.angular_momentum();
  };
  run.advance_to(from);
  const Vec3 momentum = run.momentum(), angular = run.angular_momentum();
  Vec3 impulse = Vec3::Zero(), twist = Vec3::Zero();
  Vec3 force = force_now(), moment = moment_now();
  const int count = static_cast<int>(std::round((to - from) / interval));
  double size = 0, twist_size = 0;
  for (int i = 1; i <= count; ++i) {
    run.advance_to(from + i * interval);
    const Vec3 next = force_now(), next_moment = moment_now();
    impulse += 0.5 * interval * (force + next);
    twist += 0.5 * interval * (moment + next_moment);
    size += interval * next.norm();
    twist_size += interval * next_moment.norm();
    force = next;
    moment = next_moment;
  }
  EXPECT_GT(size, 0.02);
  EXPECT_LT((impulse - (run.momentum() - momentum)).norm(), tolerance * size);
  EXPECT_LT((twist - (run.angular_momentum() - angular)).norm(), tolerance * twist_size);
}

TEST(Reactions, SwingingSheetGainsTheirImpulse) {
  ChannelRun run(sheet_in_air);
  expect_balance(run, 0, 0.4, 1e-3);
}

// Pins that a motion shakes carry the inertia of their own vertices and what
// slows these, too.
TEST(Reactions, ShakenPinsCarryTheInertiaOfTheirVertices) {
  ChannelRun run(
      sheet_in_air,
      {R"(body.sheet.pin=[{ edges = ["last_row"], motion = { keyframes = [{ time = 0 }, )"
       R"({ time = 0.15, translation = [0.2, 0, 0.1], rotation_deg = [0, 0, 30] }, )"
       R"({ time = 0.3 }] } }])",
       "material.cloth.mass_damping=5"});
  // Half way out: over the whole motion, inertia and damping would sum to nothing.
  expect_balance(run, 0, 0.08, 1e-3, 2e-4, 5);
}

// A timed pin has a force while it holds, and none before and after.
TEST(Reactions, TimedPinsCarryOnlyWhileTheyHold) {
  ChannelRun run(sheet_in_air,
                 {"body.sheet.pin.0.release_time=0.2", "body.sheet.pin.1.hold_time=0.1"});
  const auto force = [&](int pin) {
    return run.vector("reactions/sheet/pin_" + std::to_string(pin) + "/force").norm();
  };
  run.advance_to(0.05);
  EXPECT_GT(force(1), 0.01);
  EXPECT_EQ(force(2), 0);
  run.advance_to(0.15);
  EXPECT_GT(force(1), 0.01);
  EXPECT_GT(force(2), 0.01);
  expect_balance(run, 0.16, 0.19, 1e-3);
  run.advance_to(0.25);
  EXPECT_EQ(force(1), 0);
  EXPECT_GT(force(2), 0.01);
}

const std::string sheet_on_a_ball = R"(
[time]
duration = 1
frames_per_second = 10
method = "static"
[output]
channels = ["reactions", "contact_force", "friction_force"]
[contact]
range = 4e-3
friction = 0.3
[material.cloth]
bending_stiffness = 1e-4
[[body]]
name = "sheet"
position = [0.02, 0.01, 0.303]
shape = { type = "rectangle", size = [0.4, 0.4], resolution = [17, 17] }
[[obstacle]]
name = "ball"
shape = { type = "sphere", radius = 0.3, resolution = [13] }
)";

TEST(Reactions, BallCarriesTheWeightOfADrapedSheet) {
  ChannelRun run(sheet_on_a_ball,
                 {"time.method=\"cvode\"", "time.position_tolerance=1e-6", "time.duration=3",
                  "material.cloth.mass_damping=8", "material.cloth.stiffness_damping=0.01",
                  "contact.friction_speed=1e-3"});
  run.advance_to(3);
  const Vec3 weight = run.weight();
  EXPECT_LT((run.vector("reactions/ball/force") + weight).norm(), 1e-3 * weight.norm());
  EXPECT_LT((run.vector("reactions/ball/moment") + run.weight_moment()).norm(),
            1e-3 * weight.norm() * 0.3);
  // The action on the sheet is the reaction of the ball.
  const Vec3 action = sum_of(run.vectors("sheet", "contact_force")) +
                      sum_of(run.vectors("sheet", "friction_force"));
  EXPECT_LT((action - run.vector("reactions/ball/force")).norm(), 1e-12 * weight.norm());
}

// While the sheet falls on the ball and slides, forces of contact and friction
// on both sides are opposite, and their impulse is the sheet's.
TEST(Reactions, BallGivesAFallingSheetItsMomentum) {
  ChannelRun run(sheet_on_a_ball, {"time.method=\"cvode\"", "time.position_tolerance=1e-8",
                                   "body.sheet.velocity=[0.5, 0, -0.3]"});
  expect_balance(run, 0, 0.1, 2e-3, 1e-4);
  EXPECT_GT(sum_of(run.vectors("sheet", "friction_force")).norm(), 0);
}

// A sheet bends over the edge of a plate, where edges are parallel: the forces and moments on its
// vertices, mollified ones included, are those that the plate gives.
TEST(Reactions, PlateGivesWhatASheetOverItsEdgeFeels) {
  ChannelRun run(R"(
[time]
duration = 1
[output]
channels = ["contact_force", "friction_force", "reactions"]
[contact]
friction = 0.3
stiffness = 1e3
[material.cloth]
membrane_stiffness = 200
[[body]]
name = "sheet"
position = [0.15, 0.01, 0.004]
rotation_deg = [0, 0, 1]
velocity = [0, 0, -2]
shape = { type = "rectangle", size = [0.3, 0.3], resolution = [11, 11] }
[[obstacle]]
name = "plate"
shape = { type = "rectangle", size = [0.3, 0.4], resolution = [9, 7] }
)");
  double largest = 0;
  for (int i = 1; i <= 40; ++i) {
    run.advance_to(0.0005 * i);
    const std::vector<Vec3> push = run.vectors("sheet", "contact_force");
    const std::vector<Vec3> rub = run.vectors("sheet", "friction_force");
    Wrench action;
    for (std::size_t k = 0; k < push.size(); ++k) action.add(run.position()[k], push[k] + rub[k]);
    largest = std::max(largest, action.force.norm());
    EXPECT_LT((action.force - run.vector("reactions/plate/force")).norm(), 1e-12);
    EXPECT_LT((action.moment - run.vector("reactions/plate/moment")).norm(), 1e-12);
  }
  EXPECT_GT(largest, 0.05);
}

// Two sheets that meet: contact forces and frictions of one are opposite to
// those of the other.
TEST(ContactForce, OfTwoBodiesSumToNothing) {
  ChannelRun run(R"(
[time]
duration = 1
[world]
gravity = [0, 0, 0]
[output]
channels = ["contact_force", "friction_force"]
[contact]
friction = 0.4
[material.cloth]
[[body]]
name = "one"
velocity = [0.4, 0.1, -0.5]
position = [0.02, 0, 0.004]
shape = { type = "rectangle", size = [0.3, 0.3], resolution = [7, 7] }
[[body]]
name = "other"
shape = { type = "rectangle", size = [0.3, 0.3], resolution = [9, 9] }
)");
  run.advance_to(0.003);
  for (const char* name : {"contact_force", "friction_force"}) {
    const Vec3 one = sum_of(run.vectors("one", name)), other = sum_of(run.vectors("other", name));
    EXPECT_GT(one.norm(), 1e-4) << name;
    EXPECT_LT((one + other).norm(), 1e-12) << name;
  }
  EXPECT_GT(sum_of(run.vectors("one", "contact_force")).z(), 0);
  EXPECT_LT(sum_of(run.vectors("one", "friction_force")).x(), 0);
}

// A stiff sheet rests on a plate that is inclined: the contact forces are its
// weight across the plate, the friction its weight along it.
TEST(ContactForce, CarriesASheetOnAnInclinedPlate) {
  for (const double degrees : {0.0, 15.0}) {
    const std::string rotation = "[0, " + std::to_string(degrees) + ", 0]";
    ChannelRun run(
        R"(
[time]
duration = 1.5
position_tolerance = 1e-7
[output]
channels = ["contact_force", "friction_force", "reactions"]
[contact]
friction = 0.6
[material.cloth]
stiffness_damping = 0.01
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [0.3, 0.2], resolution = [5, 7] }
[[obstacle]]
name = "plate"
shape = { type = "plane", size = [2, 2] }
)",
        {"body.sheet.rotation_deg=" + rotation, "obstacle.plate.rotation_deg=" + rotation,
         "body.sheet.position=[" +
             std::to_string(0.0028 * std::sin(degrees * std::acos(-1.0) / 180)) + ", 0, " +
             std::to_string(0.0028 * std::cos(degrees * std::acos(-1.0) / 180)) + "]"});
    run.advance_to(1.5);
    const double angle = degrees * std::acos(-1.0) / 180, weight = run.weight().norm();
    const Vec3 normal(std::sin(angle), 0, std::cos(angle));
    const Vec3 uphill(-std::cos(angle), 0, std::sin(angle));
    const Vec3 push = sum_of(run.vectors("sheet", "contact_force"));
    const Vec3 rub = sum_of(run.vectors("sheet", "friction_force"));
    EXPECT_LT((push - weight * std::cos(angle) * normal).norm(), 1e-3 * weight) << degrees;
    EXPECT_LT((rub - weight * std::sin(angle) * uphill).norm(), 1e-3 * weight) << degrees;
    EXPECT_LT((run.vector("reactions/plate/force") + run.weight()).norm(), 1e-3 * weight);
  }
}

// A body that sleeps on a plate, beside one that swings, still weighs on it;
// the sheet on which it lies, held as a whole, is an obstacle.
TEST(Reactions, SleepingBodiesStillWeigh) {
  ChannelRun run(R"(
[time]
duration = 4
[output]
channels = ["reactions", "contact_force", "membrane_strain"]
[contact]
range = 0.004
friction = 0.5
[material.cloth]
membrane_stiffness = 200
stiffness_damping = 1e-3
mass_damping = 6
[material.free]
[[body]]
name = "resting"
material = "cloth"
position = [0, 0, 0.0038]
shape = { type = "rectangle", size = [0.3, 0.3], resolution = [5, 5] }
[[body]]
name = "held"
material = "cloth"
shape = { type = "rectangle", size = [0.5, 0.5], resolution = [5, 5] }
[[body.pin]]
rows = [0, -1]
[[body]]
name = "swinging"
material = "free"
position = [3, 0, 1]
shape = { type = "rectangle", size = [0.3, 0.3], resolution = [4, 4] }
[[body.pin]]
edges = ["first_row"]
)");
  for (double time = 0.5; run.simulation()
                                  .summary_of(run.simulation().time(), run.simulation().state())
                                  .sleeping_bodies == 0 &&
                          time <= 4;
       time += 0.5)
    run.advance_to(time);
  const auto summary =
      run.simulation().summary_of(run.simulation().time(), run.simulation().state());
  ASSERT_EQ(summary.sleeping_bodies, 1);
  run.compute();
  const double weight = 0.2 * 0.3 * 0.3 * 9.81;
  EXPECT_NEAR(run.vector("reactions/held/force").z(), weight, 1e-2 * weight);
  EXPECT_NEAR(sum_of(run.vectors("resting", "contact_force")).z(), weight, 1e-2 * weight);
  EXPECT_GT(run.vector("reactions/swinging/pin_1/force").norm(), 0.1 * weight);
  EXPECT_EQ(run.field("resting", "membrane_strain_major").size(), 25);
}

// A body that its pins hold as a whole carries its load to them, also beside a body that moves.
TEST(Reactions, PinsOfAHeldBodyCarryItsLoad) {
  const std::string text = R"(
[time]
method = "static"
duration = 1
frames_per_second = 1
[world]
gravity = [0, 0, 0]
[output]
channels = ["reactions"]
[contact]
enabled = false
[material.cloth]
[[body]]
name = "held"
shape = { type = "rectangle", size = [1, 0.5], resolution = [5, 6] }
pin = [{ rows = [0, -1] }]
[[body]]
name = "moving"
position = [5, 0, 0]
shape = { type = "rectangle", size = [1, 0.5], resolution = [5, 6] }
pin = [{ edges = ["first_col", "last_col"] }]
[[load]]
body = "held"
type = "pressure"
pressure = 4
)";
  ChannelRun run(text);
  run.advance_to(1);
  EXPECT_NEAR(run.vector("reactions/held/pin_1/force").z(), -2, 1e-9);
}

// The edge between columns 3 and 4 of row 2 of the second body is stretched the
// most.
TEST(LargestStretch, IsWhereTheEdgeIs) {
  ChannelRun run(R"(
[time]
duration = 1
[output]
channels = ["largest_stretch_place"]
[contact]
enabled = false
[material.cloth]
[[body]]
name = "one"
shape = { type = "rectangle", size = [1, 1], resolution = [4, 4] }
[[body]]
name = "two"
shape = { type = "rectangle", size = [1, 1], resolution = [4, 6] }
)");
  std::vector<double> y(run.simulation().state().begin(), run.simulation().state().end());
  std::vector<Vec3> position = run.position();
  const int moved = 16 + 2 * 6 + 5;  // the end of the row: only edges to the left of it
  position[moved].x() += 0.5;
  RecordedChannels channels(run.simulation());
  channels.compute(0, y, position, run.velocity());
  const auto values = channels.record_values();
  ASSERT_EQ(values.size(), 4);
  EXPECT_EQ(values[0], 1);
  EXPECT_EQ(values[1], 0);
  EXPECT_EQ(values[2], 2);
  EXPECT_TRUE(values[3] == 4 || values[3] == 5) << values[3];
}

const std::string everything =
    R"(channels = ["velocity", "membrane_strain", "membrane_stress",
  "bending_curvature", "bending_moment", "contact_force", "friction_force", "reactions",
  "body_energy", "largest_stretch_place"]
)";

std::string with_everything(const std::string& text) {
  const auto start = text.find("channels = "), end = text.find('\n', start);
  return text.substr(0, start) + everything + text.substr(end);
}

RunReport record(const std::string& text, const std::string& file, const Overrides& overrides) {
  RunOptions options;
  options.trajectory = file;
  return run_simulation(parse_case(text, "test.toml", overrides), options);
}

// Any number of threads records the same bits.
TEST(RecordedChannels, DoNotDependOnThreads) {
  const TemporaryFolder folder;
  const std::string text = with_everything(sheet_on_a_ball);
  const Overrides common{"time.method=\"cvode\"", "time.duration=0.1", "contact.range=2e-3",
                         "body.sheet.shape.resolution=[65, 65]", "time.frames_per_second=20"};
  std::vector<std::unique_ptr<TrajectoryReader>> readers;
  for (const char* threads : {"1", "4"}) {
    Overrides overrides = common;
    overrides.push_back(std::string("compute.threads=") + threads);
    const std::string file = folder.path(std::string("run") + threads + ".h5");
    ASSERT_EQ(record(text, file, overrides).status, RunReport::Status::done);
    readers.push_back(std::make_unique<TrajectoryReader>(file));
  }
  const TrajectoryReader &one = *readers[0], &four = *readers[1];
  ASSERT_EQ(one.bodies()[0].fields.size(), 3 * 4 + 3);
  for (const TrajectoryField& field : one.bodies()[0].fields) {
    for (int f = 0; f < one.frames(); ++f)
      EXPECT_EQ(one.field_values(0, field.name, f), four.field_values(0, field.name, f))
          << field.name;
  }
  ASSERT_EQ(one.records().size(), 2 + 3 + 4);
  for (const TrajectoryRecord& record : one.records())
    EXPECT_EQ(one.record_values(record.path), four.record_values(record.path)) << record.path;
}

// Channels do not change the motion, and a case that lists none has none.
TEST(RecordedChannels, ChangeNothingElse) {
  const TemporaryFolder folder;
  const Overrides overrides{"time.method=\"cvode\"", "time.duration=0.1"};
  ASSERT_EQ(record(with_everything(sheet_on_a_ball), folder.path("with.h5"), overrides).status,
            RunReport::Status::done);
  Overrides without = overrides;
  without.emplace_back("output.channels=[]");
  ASSERT_EQ(record(sheet_on_a_ball, folder.path("without.h5"), without).status,
            RunReport::Status::done);
  const TrajectoryReader with(folder.path("with.h5")), none(folder.path("without.h5"));
  EXPECT_TRUE(none.records().empty());
  EXPECT_TRUE(none.bodies()[0].fields.empty());
  EXPECT_TRUE(none.velocities(0, 0).empty());
  ASSERT_EQ(with.frames(), none.frames());
  for (int f = 0; f < none.frames(); ++f) EXPECT_EQ(with.positions(0, f), none.positions(0, f));
  EXPECT_EQ(with.series_values("energy_total"), none.series_values("energy_total"));
}

// output.velocity is the channel "velocity".
TEST(RecordedChannels, VelocityIsOneOfThem) {
  const TemporaryFolder folder;
  const Overrides more{"time.method=\"cvode\"", "time.duration=0.1"};
  for (const char* key : {"output.velocity=true", "output.channels=[\"velocity\"]"}) {
    Overrides overrides = more;
    overrides.emplace_back("output.channels=[]");
    overrides.emplace_back(key);
    const std::string file = folder.path(std::string(key).substr(7, 3) + ".h5");
    record(sheet_on_a_ball, file, overrides);
    const TrajectoryReader reader(file);
    EXPECT_EQ(reader.bodies()[0].fields,
              (std::vector<TrajectoryField>{{"velocity", "m/s", "velocity", 3}}));
    EXPECT_FALSE(reader.velocities(0, reader.frames() - 1).empty());
  }
}

// The estimates of memory and of the file count what channels take.
TEST(RecordedChannels, AreCountedByTheCheck) {
  const auto parsed = [](const std::string& text) {
    return parse_case(text, "test.toml", {"time.method=\"cvode\"", "time.duration=2"});
  };
  const Case with = parsed(with_everything(sheet_on_a_ball));
  Case without = with;
  without.output.channels.clear();
  const double more = (estimate_memory(with, size_of_case(with)) -
                       estimate_memory(without, size_of_case(without))) /
                      (17 * 17);
  EXPECT_GT(more, 800);
  EXPECT_LT(more, 2500);
  const std::string text = describe_scene(*build_scene(with));
  // 21 frames of 4 x 289 x (3 + 3 + 4 x 5 + 3 + 3) bytes and a kilobyte for each of 16 views; 13
  // KiB for the ball, once
  EXPECT_NE(text.find("file      images of about 1.082 MiB: 21 frames\n"), std::string::npos)
      << text;
  EXPECT_NE(text.find("\"reactions\", \"body_energy\", \"largest_stretch_place\"\n"),
            std::string::npos);
  EXPECT_NE(describe_scene(*build_scene(without)).find("output.channels lists none"),
            std::string::npos);
}

class BadChannel : public testing::TestWithParam<BadCase> {};
TEST_P(BadChannel, IsRefusedWithItsPlaceAndAHint) { expect_refused(GetParam()); }

const std::string names =
    "\"velocity\", \"angular_velocity\", \"membrane_strain\", "
    "\"membrane_stress\", \"bending_curvature\", "
    "\"bending_moment\", \"crease_curvature\", \"contact_force\", "
    "\"friction_force\", \"reactions\", \"body_energy\", "
    "\"largest_stretch_place\"";

BadCase bad(const std::string& name, const std::string& value, const std::string& what,
            const std::string& more = "") {
  return {name, "[output]\nchannels = " + value + "\n" + more + sheet, "case.toml:2:" + what};
}

INSTANTIATE_TEST_SUITE_P(
    OfChannels, BadChannel,
    testing::Values(
        bad("unknown", R"(["velocity", "membrane_stres"])",
            "25: \"channels[1]\" is \"membrane_stres\"\n  did you mean "
            "\"membrane_stress\"?"),
        bad("far_off", R"(["heat"])",
            "13: \"channels[0]\" is \"heat\"\n  expected one of " + names),
        bad("twice", R"(["body_energy", "velocity", "body_energy"])",
            "40: \"body_energy\" is listed twice\n  expected each channel "
            "once"),
        bad("no_list", "\"velocity\"",
            "12: \"channels\" is a string\n  expected an array of names out "
            "of " +
                names),
        bad("number", "[1]",
            "13: \"channels[0]\" is a whole number\n  expected an array of "
            "names out of " +
                names),
        bad("contact_off", R"(["contact_force"])",
            "13: the channel \"contact_force\" would be zero: contact is off\n "
            " expected "
            "contact.enabled = true, or no \"contact_force\"",
            "[contact]\nenabled = false\n"),
        bad("no_friction", R"(["friction_force"])",
            "13: the channel \"friction_force\" would be zero: there is no "
            "friction\n  expected contact.friction > 0, particles or a [[contact.pair]] "
            "with friction, or no \"friction_force\""),
        bad("friction_at_rest", R"(["friction_force"])",
            "13: the channel \"friction_force\" would be zero: in an "
            "equilibrium nothing slides\n  "
            "expected another time.method, or no \"friction_force\"",
            "[time]\nmethod = \"static\"\n[world]\ngravity = [0, 0, "
            "0]\n[contact]\nfriction = "
            "0.3\n"),
        bad("no_bending", R"(["bending_moment"])",
            "13: the channel \"bending_moment\" would be zero: no body resists "
            "bending\n  expected "
            "a "
            "material with bending_stiffness > 0 or orthotropic_bending, or no "
            "\"bending_moment\""),
        bad("springs", R"(["membrane_stress"])",
            "13: the channel \"membrane_stress\" needs a membrane of "
            "triangles, and that of body "
            "\"sheet\" is made of springs\n  expected membrane = \"triangles\" "
            "in [material.net], "
            "or "
            "no \"membrane_stress\"",
            "[material.net]\nmembrane = \"springs\"\n"),
        bad("nothing_holds", R"(["reactions"])",
            "13: the channel \"reactions\" would be empty: nothing holds the "
            "bodies\n  expected a "
            "pin, a tie "
            "or an obstacle, or no \"reactions\""),
        bad("not_recorded", R"(["contact_force"])",
            "13: the channel \"contact_force\" would be missing: nothing that output.bodies "
            "lists has it\n  expected output.bodies to list what has it, or no "
            "\"contact_force\"",
            "bodies = [\"floor\"]\n[[obstacle]]\nname = \"floor\"\nposition = [0, 0, -9]\n"
            "[obstacle.shape]\ntype = \"plane\"\nsize = [1, 1]\n")),
    bad_case_name);

}  // namespace
}  // namespace weft::sim::channels_test
