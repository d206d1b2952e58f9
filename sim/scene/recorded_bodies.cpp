#include "sim/scene/recorded_bodies.h"

#include <algorithm>
#include <cassert>
#include <limits>

#include "sim/case/case_error.h"
#include "sim/case/case_text.h"
#include "sim/scene/index_range.h"

namespace weft::sim {

namespace {

// The rows or the columns of a part, as indices in the body's patches.
struct PartAxis {
  std::vector<int> indices;
  bool wraps = false;
};

PartAxis make_axis(const std::vector<int>& range, int count, bool wraps, const char* one,
                   const char* axis, const OutputPartCase& part) {
  const auto [first, last] = resolve_range(range, count, "output.part", axis, part.location);
  PartAxis result;
  result.wraps = wraps && first == 0 && last == count - 1;
  for (int i = first; i <= last; i += part.every) result.indices.push_back(i);
  if (!result.wraps && result.indices.back() != last) result.indices.push_back(last);
  const std::size_t least = result.wraps ? 3 : 2;
  if (result.indices.size() >= least) return result;
  throw CaseError(part.location, "a part of " + counted(std::ssize(result.indices), one, axis),
                  "expected at least " + std::to_string(least) +
                      (result.wraps ? " where the shape is closed" : ", as a surface needs"));
}

}  // namespace

ImagePart make_part(const bsi::Atlas& whole, const OutputPartCase& part) {
  const std::vector<bsi::Patch>& patches = whole.patches();
  PartAxis rows = make_axis(part.rows, patches.front().rows,
                            std::ranges::all_of(patches, &bsi::Patch::wrap_v), "row", "rows", part);
  PartAxis cols =
      make_axis(part.cols, patches.front().cols, std::ranges::all_of(patches, &bsi::Patch::wrap_u),
                "column", "cols", part);
  ImagePart result;
  const bsi::Patch size{.rows = static_cast<int>(rows.indices.size()),
                        .cols = static_cast<int>(cols.indices.size()),
                        .wrap_u = cols.wraps,
                        .wrap_v = rows.wraps};
  std::vector<int> number(static_cast<std::size_t>(whole.particle_count()), -1);
  std::vector<int> particle_of_texel;
  for (int p = 0; p < static_cast<int>(patches.size()); ++p) {
    for (const int row : rows.indices) {
      for (const int col : cols.indices) {
        const int particle = whole.particle(p, row, col);
        if (number[particle] < 0) {
          number[particle] = static_cast<int>(result.particles.size());
          result.particles.push_back(particle);
        }
        particle_of_texel.push_back(number[particle]);
      }
    }
  }
  if (result.particles.size() == particle_of_texel.size()) particle_of_texel.clear();
  result.atlas = bsi::Atlas(std::vector(patches.size(), size), std::move(particle_of_texel));
  result.rows = std::move(rows.indices);
  result.cols = std::move(cols.indices);
  return result;
}

std::vector<RecordedBody> recorded_bodies(const Scene& scene) {
  const OutputCase& output = scene.source.output;
  std::vector<RecordedBody> result;
  for (std::size_t i = 0; i < scene.case_order.size(); ++i) {
    const SceneBody& body = scene.bodies[scene.case_order[i]];
    const bool is_listed =
        output.bodies.empty() || std::ranges::find(output.bodies, body.name) != output.bodies.end();
    if (!is_listed) continue;
    RecordedBody& recorded = result.emplace_back();
    recorded.body = scene.case_order[i];
    recorded.order = static_cast<int>(i);
    const auto part = std::ranges::find(output.part, body.name, &OutputPartCase::body);
    if (part != output.part.end()) recorded.part = make_part(body.atlas, *part);
  }
  assert(!result.empty());
  return result;
}

std::string rounding_notice(const Scene& scene) {
  if (scene.source.output.precision == Precision::float64) return {};
  for (const RecordedBody& recorded : recorded_bodies(scene)) {
    const SceneBody& body = scene.bodies[recorded.body];
    if (body.spheres != nullptr) continue;
    double distance = 0;
    for (int i = 0; i < body.particle_count(); ++i)
      distance = std::max(distance, scene.initial_position[body.first_particle + i].norm());
    const double rounding = distance * (std::numeric_limits<float>::epsilon() / 2);
    // Gaps are hardly smaller than a twentieth of the range.
    if (2 * rounding <= std::max(body.thickness, 0.05 * scene.source.contact.range)) continue;
    return "body " + in_quotes(body.name) + " is " + rounded_text(distance) +
           " m from the origin: float32 rounds its positions by up to " + rounded_text(rounding) +
           " m, more than half of what keeps surfaces apart, and surfaces may cross in frames; "
           "output.precision = \"float64\" shows them as they are";
  }
  return {};
}

}  // namespace weft::sim
