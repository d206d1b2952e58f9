// Compares the narrow phase of contact on the device with that of the CPU, from the candidates to
// barriers and friction, and finds the size from which the device is faster.
#include <array>
#include <cmath>
#include <cstdio>
#include <random>
#include <stdexcept>
#include <thread>

#include "bench/experiments.h"
#include "bench/medians.h"
#include "gpu/compute_narrow_phase.h"
#include "gpu/gl_context.h"
#include "sim/case/case_reader.h"
#include "sim/case/case_text.h"
#include "sim/contact/device_candidates.h"
#include "sim/contact/surface_contact.h"

namespace weft::bench {

namespace {

constexpr double spacing = 0.01;      // m, between vertices of a sheet at rest
constexpr double sheet_gap = 0.0025;  // m, between the surfaces that lie on each other

std::string sheet_text(const std::string& name, int n, double height) {
  const std::string side = sim::number_text(spacing * (n - 1)), count = std::to_string(n);
  return "[[body]]\nname = \"" + name + "\"\nposition = [0, 0, " + sim::number_text(height) +
         "]\nshape = { type = \"rectangle\", size = [" + side + ", " + side + "], resolution = [" +
         count + ", " + count + "] }\n";
}

double ball_radius(int n) { return spacing * (n - 1) / M_PI; }

// A scene of the experiment.
struct Setting {
  std::string name;
  int n = 0;
  double friction = 0;
};

std::unique_ptr<const sim::Scene> scene_of(const Setting& setting, int threads) {
  const int n = setting.n;
  std::string text =
      "[time]\nduration = 1\n[compute]\nbackend = \"cpu\"\nthreads = " + std::to_string(threads) +
      "\n[contact]\nrange = 0.004\nfriction = " + sim::number_text(setting.friction) + "\n" +
      sheet_text("sheet", n, 0);
  if (setting.name == "layers") {
    text += sheet_text("upper", n, 0.001 + sheet_gap);
  } else {
    text += "[[obstacle]]\nname = \"ball\"\nshape = { type = \"sphere\", radius = " +
            sim::number_text(ball_radius(n)) + ", resolution = [" +
            std::to_string(std::max(5, n / 4)) + "] }\n";
  }
  return sim::build_scene(sim::parse_case(text, setting.name + ".toml"));
}

// Lays the sheet over the upper half of the ball. Along each line through its centre the sheet
// keeps its length. Beyond the equator it hangs down.
void wrap(std::span<sim::Vec3> sheet, double radius) {
  for (sim::Vec3& p : sheet) {
    const double along = std::hypot(p.x(), p.y()), angle = std::min(along / radius, M_PI / 2);
    const double out = radius + 0.001 + sheet_gap, wide = along > 0 ? std::sin(angle) / along : 0;
    const double hanging = std::max(0.0, along - radius * M_PI / 2);
    p = {out * wide * p.x(), out * wide * p.y(), out * std::cos(angle) - hanging};
  }
}

// The positions and velocities of a scene in contact. Random displacements keep edges from being
// parallel.
struct Pose {
  std::vector<sim::Vec3> x, v;
  Pose(const sim::Scene& scene, const Setting& setting) : x(scene.initial_position) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> shift(-2e-4, 2e-4), speed(-0.1, 0.1);
    if (setting.name == "ball")
      wrap(std::span(x).first(scene.dynamic_points), ball_radius(setting.n));
    v.assign(x.size(), sim::Vec3::Zero());
    for (int i = 0; i < scene.dynamic_points; ++i) {
      x[i] += sim::Vec3(shift(random), shift(random), shift(random));
      v[i] = sim::Vec3(speed(random), speed(random), speed(random));
    }
  }
};

// The narrow phase of the CPU.
class OnCpu {
 public:
  OnCpu(const Setting& setting, int threads)
      : scene_(scene_of(setting, threads)),
        pose_(*scene_, setting),
        contact_(*scene_, statistics_, sim::choose_search(*scene_)),
        threads_(threads) {}

  // Returns the wall time of an evaluation without the search, ms.
  double run() {
    const double before = statistics_.phases.narrow_phase;
    if (contact_.evaluate(sim::PlacedPoints(pose_.x), pose_.v, threads_))
      throw std::runtime_error("the surfaces touch");
    return 1e3 * (statistics_.phases.narrow_phase - before);
  }
  const sim::Scene& scene() const { return *scene_; }
  const Pose& pose() const { return pose_; }
  const sim::SurfaceContact& contact() const { return contact_; }

 private:
  std::unique_ptr<const sim::Scene> scene_;
  Pose pose_;
  sim::Statistics statistics_;
  sim::SurfaceContact contact_;
  int threads_;
};

// The narrow phase of a device, on the candidates that the CPU's search finds.
class OnDevice {
 public:
  OnDevice(gpu::GlContext& context, const OnCpu& cpu)
      : scene_(cpu.scene()),
        pose_(cpu.pose()),
        search_(scene_, statistics_, sim::choose_search(scene_)),
        friction_(scene_),
        spins_(scene_.bodies.size(), sim::Vec3::Zero()),
        device_(context) {
    static_cast<void>(search_.update(pose_.x));
    for (const sim::SceneBody& body : scene_.bodies) {
      surfaces_.emplace_back(body.surface_mesh(), body.point_count(),
                             search_.neighbourhoods(static_cast<int>(surfaces_.size())));
      const std::vector<sim::Vec3>& rest = body.surface_rest();
      rest_.insert(rest_.end(), rest.begin(), rest.end());
    }
  }

  // Makes and uploads the list of candidates, once for many evaluations.
  void upload() {
    const sim::DeviceCandidates list =
        sim::device_candidates(scene_, search_.lists(), surfaces_, rest_);
    candidates_ = list.candidates;
    device_.set_candidates(list.rows, list.candidates);
  }
  void run() {
    result_ = device_.evaluate(sim::device_groups(scene_, search_.lists(), friction_, spins_),
                               pose_.x, pose_.v);
  }
  std::size_t candidate_count() const { return candidates_.size(); }
  std::size_t term_count() const { return result_.terms.size(); }

  // Returns true if the terms are the CPU's pairs, in their order.
  bool has_pairs_of(const sim::SurfaceContact& contact) const {
    const auto pairs = contact.pairs();
    bool same = pairs.size() == result_.order.size();
    for (std::size_t k = 0; same && k < pairs.size(); ++k) {
      const gpu::ContactTerm& term = result_.terms[result_.order[k]];
      const auto& points = candidates_[term.candidate].points;
      same = std::ranges::equal(points, pairs[k].nodes, {}, [](auto p) { return int(p); }) &&
             term.coefficient() == pairs[k].coefficient && term.slides() == (pairs[k].sliding >= 0);
    }
    return same;
  }
  // Returns the largest difference of a force of barrier, damping or friction from the CPU's,
  // relative to the largest force. Precondition: has_pairs_of(contact).
  double force_difference(const sim::SurfaceContact& contact) const {
    double largest = 0, difference = 0;
    for (std::size_t k = 0; k < contact.pairs().size(); ++k) {
      const sim::ContactPair& pair = contact.pairs()[k];
      const std::uint32_t i = result_.order[k];
      largest = std::max(largest, std::abs(pair.push));
      difference = std::max(difference, std::abs(pair.push - result_.pushes[i].push));
      if (pair.sliding < 0) continue;
      const sim::Vec3 found(result_.slidings[i].force.data());
      difference = std::max(difference, (contact.sliding(pair.sliding).force - found).norm());
    }
    return largest > 0 ? difference / largest : 0;
  }

 private:
  const sim::Scene& scene_;
  const Pose& pose_;
  sim::Statistics statistics_;
  sim::ContactSearch search_;
  sim::PairFriction friction_;
  std::vector<sim::Vec3> spins_, rest_;
  std::vector<bsi::SurfaceTerms> surfaces_;
  gpu::ComputeNarrowPhase device_;
  std::vector<gpu::ContactCandidate> candidates_;
  gpu::ContactResult result_;
};

std::unique_ptr<gpu::GlContext> context_of(const std::string& backend) {
  if (backend == "osmesa") return std::make_unique<gpu::GlContext>(gpu::software_backend());
  if (backend == "gpu") return std::make_unique<gpu::GlContext>(gpu::GlBackend::hardware);
  return context_of(gpu::may_have_graphics_processor() ? "gpu" : "osmesa");
}

// Prints the row of a scene. Returns true if the device finds the contacts of the CPU.
bool measure(gpu::GlContext& context, const Setting& setting, int threads, int repeats) {
  OnCpu one(setting, 1), all(setting, threads);
  OnDevice device(context, one);
  const double list = 1e3 * wall_time_of([&] { device.upload(); });
  std::array<std::vector<double>, 3> times;
  for (int pass = -1; pass < repeats; ++pass) {  // the first compiles shaders and allocates memory
    const std::array taken{1e3 * wall_time_of([&] { device.run(); }), one.run(), all.run()};
    for (int i = 0; pass >= 0 && i < 3; ++i) times[i].push_back(taken[i]);
  }
  const double on_device = median(times[0]), on_one = median(times[1]), on_all = median(times[2]);
  std::printf("%6d %11zu %9zu %9.2f %9.2f %9.2f %9.2f %7.2f %7.2f", setting.n,
              device.candidate_count(), device.term_count(), list, on_device, on_one, on_all,
              on_one / on_device, on_all / on_device);
  const bool same = device.has_pairs_of(one.contact()) && device.has_pairs_of(all.contact());
  if (same)
    std::printf("  %.1e\n", device.force_difference(one.contact()));
  else
    std::printf("  not those of the CPU\n");
  std::fflush(stdout);
  return same;
}

bool run_scene(gpu::GlContext& context, const std::string& name, double friction, int threads,
               const GpuNarrowPhaseOptions& options) {
  std::printf("%s, friction %g\n%6s %11s %9s %9s %9s %9s %9s %7s %7s  %s\n", name.c_str(), friction,
              "n", "candidates", "terms", "list", "device", "CPU", "CPU all", "x", "x all",
              "error");
  bool same = true;
  for (const int n : options.sizes) {
    try {
      same = measure(context, {name, n, friction}, threads, options.repeats) && same;
    } catch (const std::runtime_error& error) {
      std::printf("%6d %s\n", n, error.what());
    }
  }
  std::printf("\n");
  return same;
}

}  // namespace

int run_gpu_narrow_phase(const GpuNarrowPhaseOptions& options) {
  const auto context = context_of(options.backend);
  const int threads = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  std::printf(
      "device: %s\n\nsheets of n x n vertices in contact; milliseconds, medians of %d\n"
      "list: once for many evaluations; device: with uploads and downloads; CPU: one thread and "
      "%d\n"
      "x: CPU / device; error: of the forces, relative to the largest, where contacts are the "
      "same\n\n",
      context->description().c_str(), options.repeats, threads);
  bool same = true;
  for (const std::string& scene : options.scenes) {
    for (const double friction : options.frictions)
      same = run_scene(*context, scene, friction, threads, options) && same;
  }
  if (!same) std::fprintf(stderr, "weft bench: contacts are not those of the CPU\n");
  return same ? 0 : 1;
}

}  // namespace weft::bench
