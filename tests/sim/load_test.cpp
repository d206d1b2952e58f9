// Loads of cases: their resultants, their slopes, and what they do to cloth and shells.
#include <cmath>
#include <numbers>
#include <random>

#include "joint_cases.h"
#include "sim/scene/load_points.h"

namespace weft::sim::load_test {
namespace {

// A body of 1.2 m x 0.8 m in the plane of x and y, of cloth or a shell, without gravity.
std::string loaded_sheet(const std::string& material, const std::string& load) {
  return R"(
[world]
gravity = [0, 0, 0]
[contact]
enabled = false
[material.sheet]
)" + material +
         R"(
[[body]]
name = "sheet"
material = "sheet"
shape = { type = "rectangle", size = [1.2, 0.8], resolution = [7, 9] }
[[load]]
body = "sheet"
)" + load;
}
const std::string cloth = "density = 0.2";
std::string shell(int degree) {
  return "model = \"shell\"\nyoungs_modulus = 1e6\npoisson_ratio = 0.3\nshell_thickness = 1e-2\n"
         "volume_density = 100\nspline_degree = " +
         std::to_string(degree);
}

// The forces of the loads on a scene at its start, moved by `place`.
class LoadedScene {
 public:
  explicit LoadedScene(const std::string& text)
      : scene_(build_scene(parse_case(text, "test.toml"))),
        dynamics_(*scene_, statistics_),
        y_(dynamics_.initial_state()) {}

  const Scene& scene() const { return *scene_; }
  Dynamics& dynamics() { return dynamics_; }
  const std::vector<double>& start() const { return y_; }
  Vec3 place(const std::vector<double>& y, std::size_t i) const {
    return StateView::of(y).position[i];
  }
  template <class Place>
  void place_all(const Place& place) {
    for (std::size_t i = 0; i < y_.size() / 6; ++i) {
      const Vec3 to = place(this->place(y_, i));
      for (int axis = 0; axis < 3; ++axis) y_[3 * i + axis] = to[axis];
    }
  }
  std::vector<Vec3> loads(const std::vector<double>& y, double time = 0) {
    std::vector<Vec3> force(scene_->mass.size());
    dynamics_.applied_loads(time, y, false, force);
    return force;
  }
  Vec3 sum() {
    Vec3 total = Vec3::Zero();
    for (const Vec3& each : loads(y_)) total += each;
    return total;
  }
  Vec3 moment_about(const Vec3& centre) {
    Vec3 total = Vec3::Zero();
    const std::vector<Vec3> force = loads(y_);
    for (std::size_t i = 0; i < force.size(); ++i) total += (place(y_, i) - centre).cross(force[i]);
    return total;
  }

 private:
  std::unique_ptr<const Scene> scene_;
  Statistics statistics_;
  Dynamics dynamics_;
  std::vector<double> y_;
};

class LoadsOfMaterial : public testing::TestWithParam<std::string> {
 protected:
  static LoadedScene scene(const std::string& load) {
    return LoadedScene(loaded_sheet(GetParam(), load));
  }
};
INSTANTIATE_TEST_SUITE_P(All, LoadsOfMaterial, testing::Values(cloth, shell(2), shell(3)));

TEST_P(LoadsOfMaterial, PointLoadActsAtEachVertex) {
  LoadedScene loaded = scene("corners = [\"first_first\", \"last_last\"]\nforce = [1, -2, 3]\n");
  EXPECT_LT((loaded.sum() - 2 * Vec3(1, -2, 3)).norm(), 1e-12);
  EXPECT_LT(loaded.moment_about(Vec3::Zero()).norm(), 1e-12);
  LoadedScene one = scene("corners = [\"last_first\"]\nforce = [0, 0, 3]\n");
  const Vec3 expected = Vec3(-0.6, 0.4, 0).cross(Vec3(0, 0, 3));
  EXPECT_LT((one.moment_about(Vec3::Zero()) - expected).norm(), 1e-12);
}

TEST_P(LoadsOfMaterial, LineLoadIsSpreadOverItsEdges) {
  LoadedScene row = scene("type = \"line\"\nedges = [\"last_row\"]\nforce = [0, 5, 2]\n");
  EXPECT_LT((row.sum() - 1.2 * Vec3(0, 5, 2)).norm(), 1e-12);
  const Vec3 expected = Vec3(0, 0.4, 0).cross(Vec3(1.2 * Vec3(0, 5, 2)));
  EXPECT_LT((row.moment_about(Vec3::Zero()) - expected).norm(), 1e-12);
  LoadedScene both =
      scene("type = \"line\"\nedges = [\"first_row\", \"first_col\"]\nforce = [0, 0, 1]\n");
  EXPECT_NEAR(both.sum().z(), 1.2 + 0.8, 1e-12);
}

TEST_P(LoadsOfMaterial, AreaLoadIsPerAreaAtRest) {
  LoadedScene loaded = scene("type = \"area\"\nforce = [1, 2, 3]\n");
  loaded.place_all([](const Vec3& x) { return Vec3(2 * x); });
  EXPECT_LT((loaded.sum() - 1.2 * 0.8 * Vec3(1, 2, 3)).norm(), 1e-12);
}

// A box that ends between Gauss points takes whole points.
TEST_P(LoadsOfMaterial, BoxSelectsAPartOfTheSurface) {
  LoadedScene loaded = scene(
      "type = \"area\"\nforce = [0, 0, 1]\nregion_min = [-1, -1, -1]\nregion_max = [0, 1, 1]\n");
  EXPECT_NEAR(loaded.sum().z(), 0.5 * 1.2 * 0.8, 1e-12);
}

// The sheet stands in the face x = 0 of the box, to within rounding.
TEST_P(LoadsOfMaterial, BoxHoldsASurfaceInItsFace) {
  LoadedScene loaded = scene(
      "type = \"area\"\nforce = [0, 0, 1]\nregion_min = [0, -2, -2]\nregion_max = [1, 2, 2]\n"
      "[[body]]\nname = \"other\"\nmaterial = \"sheet\"\nrotation_deg = [0, 90, 0]\n"
      "shape = { type = \"rectangle\", size = [1.2, 0.8], resolution = [7, 9] }\n"
      "[[load]]\nbody = \"other\"\ntype = \"area\"\nforce = [0, 1, 0]\nregion_min = [0, -2, -2]\n"
      "region_max = [1, 2, 2]\n");
  EXPECT_NEAR(loaded.sum().y(), 1.2 * 0.8, 1e-12);
}

TEST_P(LoadsOfMaterial, PressureFollowsTheDeformedSurface) {
  LoadedScene loaded = scene("type = \"pressure\"\npressure = 7\n");
  EXPECT_LT((loaded.sum() - Vec3(0, 0, 7 * 1.2 * 0.8)).norm(), 1e-12);
  const Mat3 turn = Eigen::AngleAxisd(0.7, Vec3(1, 2, -1).normalized()).toRotationMatrix();
  loaded.place_all([&](const Vec3& x) { return Vec3(turn * Vec3(1.5 * x.x(), x.y(), 0)); });
  EXPECT_LT((loaded.sum() - turn * Vec3(0, 0, 7 * 1.8 * 0.8)).norm(), 1e-12);
}

TEST_P(LoadsOfMaterial, FollowersTurnWithTheSurface) {
  const Mat3 turn = Eigen::AngleAxisd(0.7, Vec3(1, 2, -1).normalized()).toRotationMatrix();
  for (const char* load : {"type = \"area\"\n", "corners = [\"last_last\"]\n"}) {
    LoadedScene dead = scene(std::string(load) + "force = [1, 2, 3]\n");
    LoadedScene loaded = scene(std::string(load) + "force = [1, 2, 3]\nfollower = true\n");
    EXPECT_LT((loaded.sum() - dead.sum()).norm(), 1e-12) << load;
    loaded.place_all([&](const Vec3& x) { return Vec3(turn * x); });
    EXPECT_LT((loaded.sum() - turn * dead.sum()).norm(), 1e-12) << load;
  }
}

// Components along the edge, into the surface, and along the normal.
TEST_P(LoadsOfMaterial, LineFollowersTurnWithTheirEdge) {
  const std::vector<std::pair<std::string, Vec3>> edges{{"last_col", 0.8 * Vec3(-2, 1, 3)},
                                                        {"first_col", 0.8 * Vec3(2, -1, 3)},
                                                        {"first_row", 1.2 * Vec3(1, 2, 3)},
                                                        {"last_row", 1.2 * Vec3(-1, -2, 3)}};
  const Mat3 turn = Eigen::AngleAxisd(0.7, Vec3(1, 2, -1).normalized()).toRotationMatrix();
  for (const auto& [edge, force] : edges) {
    LoadedScene loaded =
        scene("type = \"line\"\nedges = [\"" + edge + "\"]\nforce = [1, 2, 3]\nfollower = true\n");
    EXPECT_LT((loaded.sum() - force).norm(), 1e-12) << edge;
    loaded.place_all([&](const Vec3& x) { return Vec3(turn * x); });
    EXPECT_LT((loaded.sum() - turn * force).norm(), 1e-12) << edge;
  }
}

// All edges turn the same side up: what continues the surface beyond its edge rises.
TEST(MomentLoad, TurnsEveryEdgeOutwards) {
  const std::vector<std::pair<std::string, Vec3>> edges{{"last_col", Vec3(0, -0.8, 0)},
                                                        {"first_col", Vec3(0, 0.8, 0)},
                                                        {"last_row", Vec3(1.2, 0, 0)},
                                                        {"first_row", Vec3(-1.2, 0, 0)}};
  for (const auto& [edge, moment] : edges) {
    LoadedScene loaded(
        loaded_sheet(shell(3), "type = \"moment\"\nedges = [\"" + edge + "\"]\nmoment = 2\n"));
    EXPECT_LT(loaded.sum().norm(), 1e-10) << edge;
    EXPECT_LT((loaded.moment_about(Vec3::Zero()) - 2 * moment).norm(), 1e-10) << edge;
  }
}

// The matrices of loads that turn are the symmetric parts of their slopes.
TEST_P(LoadsOfMaterial, MatricesHaveTheSlopesOfFollowers) {
  std::vector<std::string> all{"type = \"pressure\"\npressure = 700\n",
                               "type = \"area\"\nforce = [100, 200, 300]\nfollower = true\n",
                               "type = \"line\"\nedges = [\"first_row\", \"last_col\"]\n"
                               "force = [100, 200, 300]\nfollower = true\n"};
  if (GetParam() != cloth)
    all.push_back("type = \"moment\"\nedges = [\"last_row\", \"first_col\"]\nmoment = 50\n");
  for (const std::string& load : all) {
    LoadedScene loaded = scene(load);
    loaded.place_all([](const Vec3& x) {
      return Vec3(x.x() + 0.1 * x.y(), x.y(), 0.3 * x.x() * x.x() - 0.2 * x.x() * x.y());
    });
    const std::vector<double> y = loaded.start();
    std::mt19937 random(3);
    std::uniform_real_distribution<double> entry(-1, 1);
    std::vector<Vec3> along(loaded.scene().mass.size()), with(along.size()), without(along.size());
    for (Vec3& each : along) each = {entry(random), entry(random), entry(random)};
    const auto product_of_matrix = [&](double factor, std::vector<Vec3>& product) {
      loaded.dynamics().set_load_factor(factor);
      loaded.dynamics().assemble(0, y, Definiteness::exact);
      loaded.dynamics().stiffness().multiply(along, product, 1);
    };
    product_of_matrix(0, without);
    product_of_matrix(1, with);
    double found = 0, expected = 0;
    constexpr double step = 1e-6;
    std::vector<double> more = y, less = y;
    for (std::size_t i = 0; i < along.size(); ++i) {
      for (int axis = 0; axis < 3; ++axis) {
        more[3 * i + axis] += step * along[i][axis];
        less[3 * i + axis] -= step * along[i][axis];
      }
    }
    const std::vector<Vec3> after = loaded.loads(more), before = loaded.loads(less);
    for (std::size_t i = 0; i < along.size(); ++i) {
      found += along[i].dot(with[i] - without[i]);
      expected -= along[i].dot(after[i] - before[i]) / (2 * step);
    }
    EXPECT_GT(std::abs(expected), 1);
    EXPECT_NEAR(found, expected, 1e-6 * std::abs(expected) + 1e-6) << load;
  }
}

TEST(Loads, VaryInTime) {
  LoadedScene loaded(loaded_sheet(
      cloth, "type = \"area\"\nforce = { times = [0, 2], values = [[0, 0, 0], [0, 0, 4]] }\n"));
  double sum = 0;
  for (const Vec3& each : loaded.loads(loaded.start(), 0.5)) sum += each.z();
  EXPECT_NEAR(sum, 1.2 * 0.8, 1e-12);
}

// The centre of mass of a free sheet under an area load: z = f t^2 / (2 density), by every method.
TEST(Loads, AccelerateAFreeSheet) {
  const std::string text = loaded_sheet(cloth, "type = \"area\"\nforce = [0.02, 0, 0.6]\n");
  for (const char* name : {"cvode", "arkode", "euler", "verlet"}) {
    SimulatedCase sim(text, method(name, {"time.duration=0.2", "time.position_tolerance=1e-6"}));
    const std::vector<Vec3> x = sim.positions_at(0.2);
    Vec3 moment = Vec3::Zero();
    double mass = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      moment += sim.scene().mass[i] * x[i];
      mass += sim.scene().mass[i];
    }
    const double accuracy = std::string(name) == "euler" ? 1e-3 : 1e-5;
    EXPECT_NEAR(moment.x() / mass, 0.1 * 0.02, accuracy) << name;
    EXPECT_NEAR(moment.z() / mass, 3 * 0.02, accuracy) << name;
  }
}

// A closed tube of cloth or of a shell under pressure widens evenly, as a thin ring does: with the
// hoop force p R l per length, St. Venant-Kirchhoff stretches it by E h l (l^2 - 1) / 2 = p R l.
TEST(Loads, PressureWidensATube) {
  const auto widened = [](const std::string& material) {
    const std::string text = R"(
[time]
method = "static"
duration = 1
frames_per_second = 1
position_tolerance = 1e-9
[static]
loading = "in_time"
[world]
gravity = [0, 0, 0]
[contact]
enabled = false
[material.wall]
)" + material + R"(
[[body]]
name = "tube"
material = "wall"
shape = { type = "cylinder", radius = 0.5, length = 1, resolution = [7, 32] }
pin = [{ edges = ["first_row", "last_row"], axes = ["z"] }, { rows = [0, 0], cols = [0, 0], axes = ["x", "y"] }, { rows = [0, 0], cols = [16, 16], axes = ["y"] }]
[[load]]
body = "tube"
type = "pressure"
pressure = { times = [0, 1], values = [0, 200] }
)";
    Simulation simulation = simulation_of(text);
    advance_to(simulation, 1);
    const std::vector<Vec3> x = simulation.position("tube");
    return (x[3 * 32] - x[3 * 32 + 16]).norm() / 2;
  };
  // E h = 1000 N/m, p R = 100 N/m: (l^2 - 1) / 2 = 0.1.
  const double stretch = std::sqrt(1.2);
  // The chords of cloth are shorter than the arcs, and the control points of a shell lie outside
  // it.
  EXPECT_NEAR(widened("density = 0.2\nmembrane_stiffness = 1000\npoisson_ratio = 0"), 0.5 * stretch,
              2e-3);
  EXPECT_NEAR(widened("model = \"shell\"\nyoungs_modulus = 1e6\npoisson_ratio = 0\n"
                      "shell_thickness = 1e-3\nvolume_density = 1000"),
              0.5 * stretch, 4e-3);
}

}  // namespace
}  // namespace weft::sim::load_test
