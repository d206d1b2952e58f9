// The narrow phase on a device, here OSMesa, against that of the CPU: contacts of whole scenes.
#include "sim/contact/device_contact.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>

#include "gpu/gl_context.h"
#include "sim/case/case_reader.h"
#include "sim/contact/surface_contact.h"

namespace weft::sim::device_contact_test {
namespace {

// A search on the CPU beside a narrow phase on a device.
class SearchBesideDevice : public PairSearch {
 public:
  using Make = std::function<std::unique_ptr<DeviceContact>()>;
  SearchBesideDevice(const Scene& scene, Make make)
      : search_(make_cpu_search(scene)), make_(std::move(make)) {}
  bool takes_frames() const override { return true; }
  int rebuild(std::span<const BodyPath> paths) override { return search_->rebuild(paths); }
  void find(std::span<const PairQuery> queries, std::vector<std::vector<bsi::LeafPair>>& found,
            bsi::TraversalCounters& counters) override {
    search_->find(queries, found, counters);
  }
  std::unique_ptr<DeviceContact> make_device_contact() const override { return make_(); }

 private:
  std::unique_ptr<PairSearch> search_;
  Make make_;
};

// A scene with contact on the CPU and on the device, at positions that move on.
struct Both {
  std::unique_ptr<const Scene> scene;
  Statistics cpu_statistics, device_statistics;
  SurfaceContact cpu, device;
  std::vector<Vec3> x, v;
  std::mt19937 random{7};

  explicit Both(const std::string& bodies, const SearchBesideDevice::Make& make = {})
      : scene(build_scene(parse_case(
            "[contact]\nrange = 0.01\nfriction = 0.3\n[compute]\nbackend = \"gpu\"\n" + bodies,
            "scene.toml"))),
        cpu(*scene, cpu_statistics, {make_cpu_search(*scene), {}}),
        device(*scene, device_statistics,
               {std::make_unique<SearchBesideDevice>(
                    *scene, make ? make : [this] { return on_osmesa(); }),
                {ComputeBackend::gpu, "OSMesa", "a test"}}),
        x(scene->initial_position),
        v(x.size(), Vec3::Zero()) {}

  std::unique_ptr<DeviceContact> on_osmesa() const {
    return make_device_contact(*scene, std::make_shared<gpu::GlContext>(gpu::software_backend()));
  }
  void move(double by) {
    std::uniform_real_distribution<double> unit(-1, 1);
    for (int i = 0; i < scene->dynamic_points; ++i) {
      x[i] += by * Vec3(unit(random), unit(random), unit(random));
      v[i] = Vec3(unit(random), unit(random), unit(random));
    }
  }
};

// The largest difference between forces and derivatives of the same pairs, relative to the largest.
class Difference {
 public:
  template <class Values>
  void add(const Values& found, const Values& expected) {
    largest_ = std::max(largest_, expected.cwiseAbs().maxCoeff());
    difference_ = std::max(difference_, (found - expected).cwiseAbs().maxCoeff());
  }
  double relative() const { return difference_ / largest_; }

 private:
  double largest_ = 1e-300, difference_ = 0;
};

void compare(const SurfaceContact& device, const SurfaceContact& cpu) {
  ASSERT_EQ(device.pairs().size(), cpu.pairs().size());
  Difference forces, slopes, friction, friction_slopes, levers, gaps;
  for (std::size_t k = 0; k < cpu.pairs().size(); ++k) {
    const ContactPair &found = device.pairs()[k], &expected = cpu.pairs()[k];
    ASSERT_EQ(found.nodes, expected.nodes);
    ASSERT_EQ(found.coefficient, expected.coefficient);
    ASSERT_EQ(found.sliding, expected.sliding);
    forces.add(Vec3(found.push * found.normal), Vec3(expected.push * expected.normal));
    slopes.add(Eigen::Vector2d(found.stiffness, found.damping),
               Eigen::Vector2d(expected.stiffness, expected.damping));
    gaps.add(Eigen::Vector2d(found.gap, found.energy),
             Eigen::Vector2d(expected.gap, expected.energy));
    if (found.sliding < 0) continue;
    const Sliding &slides = device.sliding(found.sliding), &slid = cpu.sliding(found.sliding);
    friction.add(slides.force, slid.force);
    friction_slopes.add(slides.slope, slid.slope);
    for (int i = 0; i < 4; ++i) levers.add(slides.lever[i], slid.lever[i]);
  }
  for (const Difference& one : {forces, slopes, friction, friction_slopes, levers, gaps})
    EXPECT_LE(one.relative(), 1e-12);
  ASSERT_EQ(device.mollified().size(), cpu.mollified().size());
  Difference turning;
  for (std::size_t k = 0; k < cpu.mollified().size(); ++k) {
    ASSERT_EQ(device.mollified()[k].nodes, cpu.mollified()[k].nodes);
    for (int i = 0; i < 4; ++i)
      turning.add(device.mollified()[k].force[i], cpu.mollified()[k].force[i]);
  }
  EXPECT_LE(turning.relative(), 1e-12);
}

// Two sheets on a ball. The sheets' edges are nearly parallel.
constexpr const char* sheets_on_ball = R"(
[[body]]
name = "lower"
position = [0, 0, 2.0035]
shape = { type = "rectangle", size = [0.3, 0.3], resolution = [64, 64] }
[[body]]
name = "upper"
position = [0.001, 0.002, 2.0062]
shape = { type = "rectangle", size = [0.3, 0.3], resolution = [64, 64] }
[[obstacle]]
name = "ball"
shape = { type = "sphere", radius = 2, resolution = [65] }
)";

TEST(DeviceContact, FindsTheContactsOfTheCpuWhileBodiesMove) {
  Both both(sheets_on_ball);
  for (int step = 0; step < 4; ++step) {
    both.move(1e-4);
    if (step == 2) {
      both.cpu.keep_matrix_definite();
      both.device.keep_matrix_definite();
    }
    ASSERT_FALSE(both.cpu.evaluate(PlacedPoints(both.x), both.v, 1));
    ASSERT_FALSE(both.device.evaluate(PlacedPoints(both.x), both.v, 1));
    EXPECT_GT(both.cpu.pairs().size(), 5000);
    EXPECT_GT(both.cpu.mollified().size(), 50);
    compare(both.device, both.cpu);
  }
  // The device counts all candidates, the CPU those that have drifted within reach.
  EXPECT_GT(both.device_statistics.counters.narrow_phase_calls,
            both.cpu_statistics.counters.narrow_phase_calls);
  EXPECT_EQ(both.device_statistics.counters.friction_terms,
            both.cpu_statistics.counters.friction_terms);
}

// A fine sheet, rolled up so far that its ends overlap.
TEST(DeviceContact, FindsTheContactsOfASheetWithItself) {
  Both both(R"(
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [0.08, 0.08], resolution = [40, 60] }
)");
  for (Vec3& p : both.x) {
    const double turn = 100 * (p.x() + 0.04), radius = 0.008 + 0.0012 * turn;
    p = {radius * std::cos(turn), p.y(), radius * std::sin(turn)};
  }
  both.move(1e-4);
  ASSERT_FALSE(both.cpu.evaluate(PlacedPoints(both.x), both.v, 1));
  ASSERT_FALSE(both.device.evaluate(PlacedPoints(both.x), both.v, 1));
  EXPECT_GT(both.cpu.pairs().size(), 500);
  compare(both.device, both.cpu);
}

TEST(DeviceContact, NamesTheFaultOfTheCpu) {
  Both both(sheets_on_ball);
  for (const int point : {4096 + 3000, 4096 + 1111}) both.x[point].z() -= 0.0022;
  const auto expected = both.cpu.evaluate(PlacedPoints(both.x), both.v, 1);
  const auto found = both.device.evaluate(PlacedPoints(both.x), both.v, 1);
  ASSERT_TRUE(expected && found);
  EXPECT_EQ(found->kind, ContactFault::Kind::touching);
  EXPECT_EQ(found->nodes, expected->nodes);
  EXPECT_NEAR(found->gap, expected->gap, 1e-12);
  EXPECT_TRUE(both.device.pairs().empty());
  EXPECT_EQ(both.device.has_sliding(), false);
}

class BreakingContact : public DeviceContact {
 public:
  void set_candidates(std::span<const CandidateList>, std::span<const bsi::SurfaceTerms>,
                      std::span<const Vec3>) override {}
  std::optional<Touching> evaluate(std::span<const CandidateList>, const PairFriction&,
                                   const Motion&, Found&) override {
    throw std::runtime_error("out of memory");
  }
};

TEST(DeviceContact, TheCpuGoesOnWhereTheDeviceFails) {
  Both both(sheets_on_ball, [] { return std::make_unique<BreakingContact>(); });
  both.move(1e-4);
  for (int step = 0; step < 2; ++step) {
    ASSERT_FALSE(both.cpu.evaluate(PlacedPoints(both.x), both.v, 1));
    ASSERT_FALSE(both.device.evaluate(PlacedPoints(both.x), both.v, 1));
    compare(both.device, both.cpu);
  }
  EXPECT_NE(both.device.compute().text().find("a test; its narrow phase failed: out of memory"),
            std::string::npos)
      << both.device.compute().text();
}

}  // namespace
}  // namespace weft::sim::device_contact_test
