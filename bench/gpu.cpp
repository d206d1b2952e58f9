// Compares the pyramids and traversals of gpu/ with those of the CPU, and finds the size from which
// the device is faster.
#include "bench/experiments.h"

#include <array>
#include <cstdio>
#include <stdexcept>

#include "bench/medians.h"
#include "bench/scenes.h"
#include "bsi/traversal.h"
#include "gpu/compute_traversal.h"
#include "gpu/gl_context.h"
#include "gpu/gl_objects.h"

namespace weft::bench {

namespace {

constexpr double milli = 1e3;

// A lower bound of a rebuild's cost on the device: a copy that reads as many bytes as a rebuild
// (the float32 image) and writes as many (boxes and bounds of steps).
class DeviceCopy {
 public:
  DeviceCopy(gpu::GlContext& context, std::size_t traffic)
      : gl_(context.functions()), from_(gl_), to_(gl_), bytes_(traffic / 2) {
    from_.reserve(bytes_, "a copy");
    to_.reserve(bytes_, "a copy");
  }
  void run() const {
    gl_.CopyNamedBufferSubData(from_.name(), to_.name(), 0, 0, static_cast<GLsizeiptr>(bytes_));
    gl_.Finish();
  }

 private:
  const gpu::GlFunctions& gl_;
  gpu::GlBuffer from_, to_;
  std::size_t bytes_;
};

struct Times {
  std::vector<double> copy, rebuild, upload, query, cpu_rebuild, cpu_query;
};

struct Row {
  int n = 0;
  double copy_ms = 0, rebuild_ms = 0, upload_ms = 0, query_ms = 0;
  double cpu_rebuild_ms = 0, cpu_query_ms = 0;
  std::size_t candidates = 0;
  bool same = false;
  double device() const { return upload_ms + query_ms; }
  double cpu() const { return cpu_rebuild_ms + cpu_query_ms; }
};

std::size_t traffic_of(const gpu::ComputePyramid& pyramid) {
  std::size_t bytes = pyramid.atlas(0).particle_count() * 3 * sizeof(float);
  for (int level = 0; level < pyramid.levels(0, 0); ++level) {
    const std::size_t blocks = pyramid.level(0, 0, level).count();
    bytes += blocks * 8 * sizeof(float);  // box and sphere
    if (level + 1 < pyramid.levels(0, 0)) bytes += blocks * 12 * sizeof(float);
  }
  return bytes;
}

Row measure(gpu::GlContext& context, const std::string& scene_name, int n, bsi::Bound bound,
            int repeats) {
  const CollisionScene scene = make_scene(scene_name, n);
  const Body& sheet = scene.bodies.front();
  const std::array<const bsi::Atlas*, 1> atlas{&sheet.atlas};
  gpu::ComputePyramid pyramid(context, atlas);
  gpu::ComputeTraversal traversal(pyramid, bound);
  const bool spheres = bound != bsi::Bound::box;
  const gpu::BodyImage image{.body = 0, .start = sheet.start, .tangents = true, .spheres = spheres};
  const gpu::PairQuery query{0, 0, scene.margin, true};
  const DeviceCopy copy(context, traffic_of(pyramid));
  bsi::Pyramid on_cpu(sheet.atlas, {.spheres = spheres});
  std::vector<bsi::LeafPair> pairs;
  bsi::TraversalCounters counters;
  Row row;
  row.n = n;
  Times times;
  for (int pass = -1; pass < repeats; ++pass) {  // the first compiles shaders and allocates memory
    const auto take = [&](std::vector<double>& taken, const auto& work) {
      const double time = milli * wall_time_of(work);
      if (pass >= 0) taken.push_back(time);
    };
    take(times.copy, [&] { copy.run(); });
    // first_unbounded() waits for the device.
    take(times.upload, [&] {
      pyramid.rebuild(std::span(&image, 1));
      static_cast<void>(pyramid.first_unbounded());
    });
    take(times.rebuild, [&] {
      pyramid.rebuild_there();
      static_cast<void>(pyramid.first_unbounded());
    });
    take(times.query, [&] {
      row.candidates = traversal.find_pairs(std::span(&query, 1), bsi::Leaf::triangle).size();
    });
    take(times.cpu_rebuild, [&] { static_cast<void>(on_cpu.rebuild(sheet.start, 1)); });
    pairs.clear();
    take(times.cpu_query, [&] {
      bsi::self_traversal(on_cpu, {.margin = scene.margin, .bound = bound, .threads = 1}, pairs,
                          counters);
    });
  }
  row.copy_ms = median(times.copy);
  row.rebuild_ms = median(times.rebuild);
  row.upload_ms = median(times.upload);
  row.query_ms = median(times.query);
  row.cpu_rebuild_ms = median(times.cpu_rebuild);
  row.cpu_query_ms = median(times.cpu_query);
  row.same = row.candidates == pairs.size();
  return row;
}

const char* name_of(bsi::Bound bound) {
  constexpr std::array names{"spheres", "boxes", "spheres, then boxes"};
  return names[static_cast<int>(bound)];
}

std::unique_ptr<gpu::GlContext> make_context(const std::string& backend) {
  if (backend == "osmesa") return std::make_unique<gpu::GlContext>(gpu::software_backend());
  if (backend == "gpu") return std::make_unique<gpu::GlContext>(gpu::GlBackend::hardware);
  return make_context(gpu::may_have_graphics_processor() ? "gpu" : "osmesa");
}

void print_break_even(const std::string& scene, const std::vector<Row>& rows) {
  for (const Row& row : rows) {
    if (row.device() >= row.cpu()) continue;
    std::printf("%s: the device is faster from n = %d on\n\n", scene.c_str(), row.n);
    return;
  }
  std::printf("%s: the CPU is faster at all of these sizes\n\n", scene.c_str());
}

void print(const Row& row) {
  std::printf("%6d %9.3f %9.3f %7.2f %9.3f %9.3f %9.3f %9.3f %10zu%s\n", row.n, row.copy_ms,
              row.rebuild_ms, row.rebuild_ms / row.copy_ms, row.upload_ms, row.query_ms,
              row.cpu_rebuild_ms, row.cpu_query_ms, row.candidates,
              row.same ? "" : "  not those of the CPU");
  std::fflush(stdout);
}

// Measures the sizes that the device can hold.
std::vector<Row> run_scene(gpu::GlContext& context, const std::string& scene, bsi::Bound bound,
                           const GpuOptions& options) {
  std::printf(
      "%s: self query of n x n vertices by %s; milliseconds, medians of %d; CPU: one thread\n",
      scene.c_str(), name_of(bound), options.repeats);
  std::printf("%6s %9s %9s %7s %9s %9s %9s %9s %10s\n", "n", "floor", "rebuild", "/floor",
              "+upload", "query", "cpu reb.", "cpu query", "candidates");
  std::vector<Row> rows;
  for (const int n : options.sizes) {
    try {
      rows.push_back(measure(context, scene, n, bound, options.repeats));
      print(rows.back());
    } catch (const std::runtime_error& error) {
      std::printf("%6d %s\n", n, error.what());
    }
  }
  return rows;
}

}  // namespace

int run_gpu(const GpuOptions& options) {
  const auto context = make_context(options.backend);
  std::printf("device: %s\n\n", context->description().c_str());
  bool wrong = false;
  for (const std::string& scene : options.scenes) {
    for (const bsi::Bound bound :
         {bsi::Bound::sphere, bsi::Bound::box, bsi::Bound::sphere_then_box}) {
      const std::vector<Row> rows = run_scene(*context, scene, bound, options);
      print_break_even(scene, rows);
      // On a graphics processor the certificate rejects a few pairs fewer.
      if (context->backend() == gpu::GlBackend::hardware) continue;
      wrong |= !std::ranges::all_of(rows, &Row::same);
    }
  }
  if (wrong) std::fprintf(stderr, "weft bench: candidates are not those of the CPU\n");
  return wrong ? 1 : 0;
}

}  // namespace weft::bench
