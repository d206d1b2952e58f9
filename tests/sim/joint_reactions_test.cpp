// Reactions of clamps and ties.
#include "tests/sim/channel_run.h"

namespace weft::sim::joint_reactions_test {
namespace {

// A stiff strip of 0.3 m and 5.88 mN that a clamp holds out by its first column.
constexpr const char* cantilever = R"(
[time]
method = "static"
duration = 1
frames_per_second = 1
position_tolerance = 1e-9
[contact]
enabled = false
[output]
channels = ["reactions"]
[material.strip]
density = 0.2
membrane_stiffness = 2000
bending_stiffness = 0.05
[[body]]
name = "strip"
position = [0.4, 0.2, 0.1]
shape = { type = "rectangle", size = [0.3, 0.1], resolution = [4, 13] }
[[body.pin]]
edges = ["first_col"]
clamp = true
)";

// A sheet hangs from a plate by its upper row, and another one from it.
constexpr const char* chain = R"(
[time]
method = "static"
duration = 1
frames_per_second = 1
position_tolerance = 1e-9
[contact]
enabled = false
[output]
channels = ["reactions"]
[material.cloth]
density = 0.2
membrane_stiffness = 500
bending_stiffness = 1e-5
[[body]]
name = "upper"
rotation_deg = [90, 0, 0]
shape = { type = "rectangle", size = [0.3, 0.2], resolution = [5, 7] }
[[body]]
name = "lower"
position = [0.02, 0, -0.21]
rotation_deg = [90, 0, 0]
shape = { type = "rectangle", size = [0.2, 0.2], resolution = [5, 5] }
[[obstacle]]
name = "plate"
position = [0, 0, 0.1]
shape = { type = "rectangle", size = [1, 1], resolution = [2, 2] }
[[tie]]
body = "upper"
to = "plate"
edges = ["last_row"]
[[tie]]
body = "lower"
to = "upper"
edges = ["last_row"]
)";

double weight_of(const ChannelRun& run, const std::string& name) {
  const auto body = std::ranges::find(run.scene().bodies, name, &SceneBody::name);
  double weight = 0;
  for (int i = 0; i < body->particle_count(); ++i)
    weight += 9.81 * run.scene().mass[body->first_particle + i];
  return weight;
}

}  // namespace

// The clamp carries the weight and its moment, which no pin of a single column could.
TEST(JointReactions, ClampCarriesWeightAndMoment) {
  ChannelRun run(cantilever);
  run.advance_to(1);
  const double weight = run.weight().norm();
  const Vec3 force = run.vector("reactions/strip/pin_1/force");
  const Vec3 moment = run.vector("reactions/strip/pin_1/moment");
  EXPECT_LT((force + run.weight()).norm(), 1e-6 * weight);
  EXPECT_LT((moment + run.weight_moment()).norm(), 1e-6 * weight);
  // The couple about the held edge, at x = 0.25 m, is a little less than weight x 0.15 m.
  const Vec3 edge(0.25, 0.2, 0.1);
  const double couple = (moment - edge.cross(force)).norm();
  EXPECT_GT(couple, 0.13 * weight);
  EXPECT_LT(couple, 0.15 * weight);
}

// The bending moment per width is w (L - x)^2 / 2 at the distance x from the clamp; the triangles
// around the held vertices have that of half a cell. The energy of the body is that of the forces,
// the clamp's included.
TEST(JointReactions, ClampBendsTheSurfaceAtItsEdge) {
  ChannelRun run(cantilever, {"output.channels=[\"bending_moment\",\"body_energy\"]",
                              "material.strip.poisson_ratio=0"});
  run.advance_to(1);
  const std::vector<double> moments = run.field("strip", "bending_moment_minor");
  const double expected = 0.5 * 0.2 * 9.81 * 0.2875 * 0.2875;
  double mean = 0;
  for (int row = 0; row < 4; ++row) mean += moments[13 * row] / 4;
  EXPECT_NEAR(mean, -expected, 0.04 * expected);
  const Energies energies = run.simulation().energies();
  double elastic = 0;
  for (const auto& [name, value] : energies.elastic) elastic += value;
  EXPECT_NEAR(run.record("body_energy/strip/elastic")[0], elastic, 1e-6 * elastic);
}

TEST(JointReactions, TiesCarryWhatHangsFromThem) {
  ChannelRun run(chain);
  run.advance_to(1);
  const double upper = weight_of(run, "upper"), lower = weight_of(run, "lower");
  const Vec3 first = run.vector("reactions/tie/1/force"),
             second = run.vector("reactions/tie/2/force");
  EXPECT_LT((first - Vec3(0, 0, upper + lower)).norm(), 1e-6 * upper);
  EXPECT_LT((second - Vec3(0, 0, lower)).norm(), 1e-6 * upper);
  EXPECT_LT((run.vector("reactions/plate/force") - first).norm(), 1e-9 * upper);
  const Vec3 moment = run.vector("reactions/plate/moment");
  EXPECT_LT((moment + run.weight_moment()).norm(), 1e-6 * upper);
  EXPECT_LT((run.vector("reactions/tie/1/moment") - moment).norm(), 1e-6 * upper);
}

TEST(JointReactions, ABrokenTieCarriesNothing) {
  ChannelRun run(chain, method("cvode", {"tie.1.break_force=0.01"}));
  run.advance_to(0.3);
  EXPECT_EQ(run.vector("reactions/tie/2/force"), Vec3::Zero().eval());
  EXPECT_GT(run.vector("reactions/tie/1/force").z(), 0);
}

}  // namespace weft::sim::joint_reactions_test
