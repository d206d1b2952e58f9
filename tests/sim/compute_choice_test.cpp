#include "sim/contact/compute_choice.h"
#include "sim/accuracy/accuracy_choice.h"

#include <stdexcept>

#include "gpu/gl_context.h"
#include "sim/contact/contact_search.h"
#include "sim/view/scene_description.h"
#include "simulated_case.h"

namespace weft::sim::compute_choice_test {
namespace {

std::unique_ptr<const Scene> drape(const std::string& backend, const std::string& bound = "box") {
  return build_scene(
      read_case(std::string(WEFT_CASES_DIR) + "/drape_torus.toml",
                {"body.sheet.shape.resolution=[25, 25]", "body.sheet.position=[0,0,0.28]",
                 "obstacle.torus.shape.resolution=[32, 16]", "compute.backend=" + backend,
                 "contact.bound=" + bound}));
}

// This test is the first of the process, so nothing before it asked for OpenGL.
TEST(ComputeChoice, MakesNoContextUnlessADeviceIsUsed) {
  EXPECT_EQ(choose_search(*drape("cpu")).choice.backend, ComputeBackend::cpu);
  EXPECT_EQ(gpu::context_count(), 0);
  const auto scene = drape("auto");
  if (gpu::may_have_graphics_processor()) GTEST_SKIP() << "there may be a graphics processor";
  const ComputeChoice choice = choose_search(*scene).choice;
  EXPECT_EQ(choice.backend, ComputeBackend::cpu);
  EXPECT_EQ(choice.text(), "CPU: there is no graphics processor");
  EXPECT_NE(describe_scene(*scene).find("search    CPU: there is no graphics processor"),
            std::string::npos);
  EXPECT_EQ(gpu::context_count(), 0);
}

TEST(ComputeChoice, MakesNoContextWithoutContact) {
  const auto scene = build_scene(read_case(std::string(WEFT_CASES_DIR) + "/drape_torus.toml",
                                           {"contact.enabled=false", "compute.backend=osmesa"}));
  const int before = gpu::context_count();
  Statistics statistics;
  const Dynamics dynamics(*scene, statistics);
  EXPECT_EQ(describe_scene(*scene).find("OSMesa"), std::string::npos);
  EXPECT_EQ(gpu::context_count(), before);
}

TEST(ComputeChoice, RefusesADeviceThatIsNotThere) {
  if (gpu::may_have_graphics_processor()) GTEST_SKIP() << "there may be a graphics processor";
  const auto scene = drape("gpu");
  try {
    choose_search(*scene);
    FAIL() << "not refused";
  } catch (const CaseError& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("drape_torus.toml: compute.backend is \"gpu\": no OpenGL"),
              std::string::npos)
        << text;
    EXPECT_NE(text.find(R"(use "auto", "osmesa" or "cpu")"), std::string::npos) << text;
  }
}

// The result of a run, which every backend must match to the last bit: contacts and trajectory.
struct Drape {
  std::vector<double> state;
  Counters counters;
};

Drape drape_until_they_meet(const std::string& backend, const std::string& bound) {
  const auto scene = drape(backend, bound);
  Statistics statistics;
  Dynamics dynamics(*scene, statistics);
  EXPECT_EQ(dynamics.contact()->compute().backend,
            backend == "cpu" ? ComputeBackend::cpu : ComputeBackend::osmesa);
  const auto integrator = make_integrator(*scene, dynamics);
  while (integrator->time() < 0.15) {
    if (const auto failure = integrator->step()) {
      ADD_FAILURE() << failure->text;
      break;
    }
  }
  EXPECT_TRUE(dynamics.contact()->smallest_gap());
  return {{integrator->state().begin(), integrator->state().end()}, statistics.counters};
}

TEST(ComputeChoice, OsMesaFindsTheTrajectoryOfTheCpuByEveryBound) {
  const Drape expected = drape_until_they_meet("cpu", "box");
  EXPECT_GT(expected.counters.candidate_pairs, 0);
  for (const char* backend : {"cpu", "osmesa"}) {
    for (const char* bound : {"sphere", "box", "sphere_then_box"}) {
      SCOPED_TRACE(std::string(backend) + " by " + bound);
      const Drape found = drape_until_they_meet(backend, bound);
      EXPECT_EQ(found.state, expected.state);
      EXPECT_EQ(found.counters.candidate_pairs, expected.counters.candidate_pairs);
      // The device leaves out pairs of quads that cannot be in reach.
      if (backend == std::string("cpu")) {
        EXPECT_EQ(found.counters.narrow_phase_calls, expected.counters.narrow_phase_calls);
      } else {
        EXPECT_LT(found.counters.narrow_phase_calls, expected.counters.narrow_phase_calls);
      }
      EXPECT_EQ(found.counters.rebuilds, expected.counters.rebuilds);
    }
  }
}

TEST(ComputeChoice, ShippedCasesTakeTheSameStepsByEveryBound) {
  int with_candidates = 0;
  for (const auto& file : std::filesystem::directory_iterator(WEFT_CASES_DIR)) {
    if (file.path().extension() != ".toml") continue;
    SCOPED_TRACE(file.path().filename());
    std::vector<double> expected;
    for (const char* bound : {"box", "sphere", "sphere_then_box"}) {
      Case source = read_case(file.path().string(),
                              {"compute.backend=cpu", std::string("contact.bound=") + bound});
      choose_accuracy(source);
      const auto scene = build_scene(source);
      Statistics statistics;
      Dynamics dynamics(*scene, statistics);
      const auto integrator = make_integrator(*scene, dynamics);
      for (int step = 0; step < 40; ++step) ASSERT_FALSE(integrator->step());
      const std::vector<double> state(integrator->state().begin(), integrator->state().end());
      if (expected.empty()) expected = state;
      EXPECT_EQ(state, expected) << bound;
      with_candidates += statistics.counters.candidate_pairs > 0 ? 1 : 0;
    }
  }
  EXPECT_GT(with_candidates, 6);
}

// A device that fails at its third search.
class BreakingSearch : public PairSearch {
 public:
  explicit BreakingSearch(const Scene& scene) : sound_(make_cpu_search(scene)) {}
  int rebuild(std::span<const BodyPath> paths) override { return sound_->rebuild(paths); }
  void find(std::span<const PairQuery> queries, std::vector<std::vector<bsi::LeafPair>>& found,
            bsi::TraversalCounters& counters) override {
    if (++calls_ == 3) throw std::runtime_error("out of memory");
    sound_->find(queries, found, counters);
  }

 private:
  std::unique_ptr<PairSearch> sound_;
  int calls_ = 0;
};

TEST(ComputeChoice, ADeviceThatFailsHandsOverToTheCpu) {
  const auto scene = drape("cpu");
  Statistics statistics;
  ContactSearch sound(*scene, statistics, choose_search(*scene));
  ContactSearch breaking(*scene, statistics,
                         {std::make_unique<BreakingSearch>(*scene),
                          {ComputeBackend::gpu, "a device", "a test asks for it"}});
  std::vector<Vec3> position = scene->initial_position;
  for (int step = 0; step < 5; ++step) {
    for (int i = 0; i < scene->dynamic_particles; ++i) {
      position[i] += Vec3(0, 0.002 * std::sin(7 * position[i].x()), -0.03);
    }
    ASSERT_FALSE(sound.update(position));
    ASSERT_FALSE(breaking.update(position));
    ASSERT_EQ(breaking.compute().backend, step < 2 ? ComputeBackend::gpu : ComputeBackend::cpu);
    std::size_t pairs = 0;
    for (std::size_t l = 0; l < sound.lists().size(); ++l) {
      for (const auto list : {&CandidateList::vertex_triangle, &CandidateList::triangle_vertex,
                              &CandidateList::edge_edge}) {
        const auto& expected = sound.lists()[l].*list;
        const auto& found = breaking.lists()[l].*list;
        ASSERT_EQ(found.size(), expected.size());
        for (std::size_t i = 0; i < found.size(); ++i) {
          ASSERT_TRUE(found[i].a == expected[i].a && found[i].b == expected[i].b &&
                      found[i].distance == expected[i].distance);
        }
        pairs += found.size();
      }
    }
    EXPECT_GT(pairs, 0);
  }
  EXPECT_EQ(breaking.compute().text(),
            "CPU: GPU (a device): a test asks for it, which failed: out of memory");
}

}  // namespace
}  // namespace weft::sim::compute_choice_test
