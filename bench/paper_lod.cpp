// The paper's experiment on level of detail: the cost of a picture of a body of 48 patches, by its
// level of detail.
#include <Eigen/Geometry>
#include <array>
#include <cstdio>
#include <numeric>

#include "bench/experiments.h"
#include "bench/medians.h"
#include "bsi/level_of_detail.h"
#include "bsi/shapes.h"
#include "gpu/renderer.h"
#include "gpu/triangle_batch.h"
#include "sim/view/plot.h"

namespace weft::bench {

namespace {

constexpr int width = 960, height = 720;  // of the picture, pixels

// One way to draw the body.
struct Setting {
  enum class Kind { level, pixels, full } kind = Kind::full;
  double value = 0;  // the level, or the tolerance in pixels

  std::size_t triangles = 0;
  double deviation = 0;  // m
  std::vector<double> build_ms = {}, frame_ms = {};

  const char* name() const {
    return kind == Kind::level ? "level" : kind == Kind::pixels ? "pixels" : "full";
  }
};

std::vector<Setting> settings(int levels) {
  std::vector<Setting> all;
  // The last level is the original surface again.
  for (int level = 0; level + 1 < levels; ++level) {
    all.push_back({.kind = Setting::Kind::level, .value = static_cast<double>(level)});
  }
  for (const double pixels : {8.0, 4.0, 2.0, 1.0, 0.5, 0.25}) {
    all.push_back({.kind = Setting::Kind::pixels, .value = pixels});
  }
  all.push_back({});
  return all;
}

// Rotates the body between pictures, as if it moved in a simulation. The time to build counts
// everything that depends on its positions and is made anew.
class Experiment {
 public:
  explicit Experiment(int n)
      : body_(bsi::make_blob(1, n)),
        triangles_(bsi::build_mesh(body_.atlas).triangles),
        pyramid_(body_.atlas, {.tangents = false, .spheres = true}),
        renderer_(width, height),
        camera_(gpu::camera_for_box({-1.3, -1.3, -1.3}, {1.3, 1.3, 1.3},
                                    static_cast<double>(width) / height)) {}

  int levels() const { return pyramid_.levels(0); }
  std::size_t full_triangles() const { return triangles_.size(); }

  void turn() {
    const Eigen::AngleAxisd rotation(0.1, bsi::Vec3::UnitZ());
    for (bsi::Vec3& position : body_.positions) position = rotation * position;
  }

  void measure(Setting& setting) {
    bsi::DetailSurface detail;
    std::vector<bsi::Vec3> normals;
    const gpu::DrawnSurface original{body_.positions, triangles_, colours_.front, colours_.back};
    setting.build_ms.push_back(1e3 * wall_time_of([&] {
                                 if (setting.kind == Setting::Kind::full) {
                                   normals = gpu::vertex_normals(original);
                                   return;
                                 }
                                 detail = reduced(setting);
                                 normals = gpu::detail_normals(detail, original);
                               }));
    gpu::DrawnSurface drawn = original;
    if (setting.kind != Setting::Kind::full) {
      drawn.positions = detail.positions;
      drawn.triangles = detail.triangles;
    }
    drawn.normals = normals;
    setting.frame_ms.push_back(1e3 *
                               wall_time_of([&] { renderer_.draw(std::array{drawn}, camera_); }));
    setting.triangles = drawn.triangles.size();
    setting.deviation = detail.deviation;
    if (setting.kind == Setting::Kind::level) {
      setting.deviation = bsi::deviation_at_levels(pyramid_, body_.positions, levels_);
    }
  }

 private:
  bsi::DetailSurface reduced(const Setting& setting) {
    if (pyramid_.rebuild(body_.positions)) return {};  // cannot happen for a body of 1 m
    if (setting.kind == Setting::Kind::level) {
      levels_.assign(pyramid_.patch_count(), static_cast<int>(setting.value));
      return bsi::detail_at_levels(pyramid_, body_.positions, levels_);
    }
    return bsi::detail_within(pyramid_, body_.positions,
                              gpu::pixel_tolerance(camera_, width, height, setting.value));
  }

  bsi::Surface body_;
  std::vector<std::array<int, 3>> triangles_;
  bsi::Pyramid pyramid_;
  gpu::Renderer renderer_;
  gpu::Camera camera_;
  gpu::SurfaceColours colours_ = gpu::palette(0);
  std::vector<int> levels_;
};

std::string csv(const std::vector<Setting>& all) {
  std::string text = "detail,value,triangles,build_ms,frame_ms,deviation_m\n";
  for (const Setting& setting : all) {
    std::array<char, 160> line{};
    std::snprintf(line.data(), line.size(), "%s,%g,%zu,%.3f,%.3f,%.4g\n", setting.name(),
                  setting.value, setting.triangles, median(setting.build_ms),
                  median(setting.frame_ms), setting.deviation);
    text += line.data();
  }
  return text;
}

sim::Plot chart(const std::vector<Setting>& all, std::size_t full_triangles) {
  sim::PlotSeries levels{"levels: picture", {}, {}};
  sim::PlotSeries levels_build{"levels: build", {}, {}};
  sim::PlotSeries pixels{"pixels: picture", {}, {}};
  sim::PlotSeries pixels_build{"pixels: build", {}, {}};
  for (const Setting& setting : all) {
    for (sim::PlotSeries* series : {&levels, &levels_build, &pixels, &pixels_build}) {
      const bool of_levels = series == &levels || series == &levels_build;
      const bool of_build = series == &levels_build || series == &pixels_build;
      if (setting.kind == (of_levels ? Setting::Kind::pixels : Setting::Kind::level)) continue;
      series->x.push_back(static_cast<double>(setting.triangles));
      series->y.push_back(median(of_build ? setting.build_ms : setting.frame_ms));
    }
  }
  return {"Level of detail: a body of 48 patches",
          std::to_string(full_triangles) + " triangles at full detail, " + std::to_string(width) +
              " x " + std::to_string(height) + " pixels, drawn by the processor",
          {"triangles drawn"},
          {"time (ms)"},
          {levels, levels_build, pixels, pixels_build}};
}

}  // namespace

int run_paper_lod(const PaperOptions& options) {
  Experiment experiment(options.lod_size);
  std::vector<Setting> all = settings(experiment.levels());
  // A first round is not timed; it touches memory.
  std::vector<Setting> warm_up = all;
  for (Setting& setting : warm_up) experiment.measure(setting);
  for (int frame = 0; frame < options.lod_frames; ++frame) {
    experiment.turn();
    for (Setting& setting : all) experiment.measure(setting);
  }
  const std::string table = csv(all);
  std::fputs(table.c_str(), stdout);
  sim::write_text(table, options.directory / "paper_lod.csv");
  sim::write_svg(chart(all, experiment.full_triangles()), options.directory / "paper_lod.svg");
  return 0;
}

}  // namespace weft::bench
