// Builds the spheres of a pyramid from its boxes, leaf blocks first.
#include <omp.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "bsi/detail/sphere_bounds.h"
#include "bsi/detail/team.h"
#include "bsi/pyramid.h"

namespace weft::bsi {

namespace {

// A level with fewer blocks is built by a single thread.
constexpr int least_blocks_per_team = 1 << 12;

// Circumscribes a sphere about the box of each of a block's children. The centre of an absent child
// is set to NaN.
void surround_boxes(const BoxGroup& boxes, SphereGroup& spheres) {
#pragma omp simd
  for (int child = 0; child < 4; ++child) {
    float squared = 0, size = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const float low = boxes.low[axis][child], high = boxes.high[axis][child];
      const float centre = 0.5F * (low + high);
      const float above = high - centre, below = centre - low;
      const float half = above > below ? above : below;
      spheres.centre[axis][child] = low <= high ? centre : std::numeric_limits<float>::quiet_NaN();
      squared += half * half;
      size += std::fabs(centre);
    }
    const float reach = std::sqrt(squared);
    spheres.radius[child] = reach * round_up + (size * box_rounding + radius_floor);
  }
}

// Returns the radius (m) of a sphere around `centre` that contains the spheres of a block's
// children.
float reach_of_children(const SphereGroup& children, const float (&centre)[3]) {
  float reach[4];
#pragma omp simd
  for (int child = 0; child < 4; ++child) {
    const float x = children.centre[0][child] - centre[0];
    const float y = children.centre[1][child] - centre[1];
    const float z = children.centre[2][child] - centre[2];
    reach[child] = std::sqrt(x * x + y * y + z * z) + children.radius[child];
  }
  float largest = 0;
  for (const float of_child : reach) largest = of_child > largest ? of_child : largest;
  return largest * round_up + radius_floor;
}

// The spheres of this level, or of the last level if that comes first, also bound the radii of all
// levels at least two above. Those radii would otherwise be loose, because each level encloses
// spheres that already exceed their boxes.
constexpr int tight_level = 5;

// Returns the radius (m) of a sphere around `centre` that contains the spheres of all descendants
// of block (u, v) on one finer level. `parents` is the level above that finer level.
float reach_of_descendants(const BoxLevel& level, const BoxLevel& parents, int u, int v,
                           const float (&centre)[3]) {
  const int log_u = parents.log_u - level.log_u, log_v = parents.log_v - level.log_v;
  float largest = 0;
  for (int row = v << log_v; row < (v + 1) << log_v; ++row) {
    for (int column = u << log_u; column < (u + 1) << log_u; ++column) {
      const std::size_t parent = (static_cast<std::size_t>(row) << parents.log_u) + column;
      largest = std::max(largest, reach_of_children(parents.spheres[parent], centre));
    }
  }
  return largest;
}

// Computes the spheres of the children of block (u, v) of `level`. The children are on the level
// `below`.
void bound_children(const BoxLevel& level, const BoxLevel& below, int u, int v,
                    SphereGroup& spheres) {
  surround_boxes(level.groups[(static_cast<std::size_t>(v) << level.log_u) + u], spheres);
  if (below.groups == nullptr) return;
  for (int child = 0; child < 4; ++child) {
    const float centre[3] = {spheres.centre[0][child], spheres.centre[1][child],
                             spheres.centre[2][child]};
    if (std::isnan(centre[0])) continue;
    const int child_u = (u << level.split_u) + (child & 1);
    const int child_v = (v << level.split_v) + (child >> 1);
    const float carried = reach_of_children(
        below.spheres[(static_cast<std::size_t>(child_v) << below.log_u) + child_u], centre);
    spheres.radius[child] = std::min(spheres.radius[child], carried);
  }
}

}  // namespace

void Pyramid::rebuild_spheres(int patch, int threads) {
  BoxPatch& whole = patches_[patch];
  const int team = threads > 0 ? threads : omp_get_max_threads();
  for (int at = levels(patch) - 2; at >= 0; --at) {
    const BoxLevel& level = level_of(patch, at);
    const BoxLevel& below = level_of(patch, at + 1);
    SphereGroup* spheres = &spheres_[places_[whole.first_level + at].groups];
    const bool shared = team > 1 && 1 << (level.log_u + level.log_v) >= least_blocks_per_team;
    parallel_for(1 << level.log_v, shared ? team : 1, [&](int v) {
      for (int u = 0; u < 1 << level.log_u; ++u) {
        bound_children(level, below, u, v,
                       spheres[(static_cast<std::size_t>(v) << level.log_u) + u]);
      }
    });
  }
  // The whole patch has no parent. It is bounded like the first child of a block.
  BoxGroup box{};
  for (int axis = 0; axis < 3; ++axis) {
    box.low[axis][0] = whole.low[axis];
    box.high[axis][0] = whole.high[axis];
  }
  SphereGroup sphere;
  surround_boxes(box, sphere);
  for (int axis = 0; axis < 3; ++axis) whole.centre[axis] = sphere.centre[axis][0];
  whole.radius = sphere.radius[0];
  if (levels(patch) > 1)
    whole.radius =
        std::min(whole.radius, reach_of_children(*level_of(patch, 0).spheres, whole.centre));
  tighten_spheres(patch);
}

void Pyramid::tighten_spheres(int patch) {
  const int from = std::min(tight_level, levels(patch) - 1);
  for (int at = from - 2; at >= 0; --at) {
    const BoxLevel& level = level_of(patch, at);
    const BoxLevel& parents = level_of(patch, from - 1);
    for (int v = 0; v < 1 << level.log_v; ++v) {
      for (int u = 0; u < 1 << level.log_u; ++u) {
        const Sphere old = sphere(patch, at, u, v);
        const float centre[3] = {old.x, old.y, old.z};
        float& radius = radius_of(patch, at, u, v);
        radius = std::min(radius, reach_of_descendants(level, parents, u, v, centre));
      }
    }
  }
}

float& Pyramid::radius_of(int patch, int level, int u, int v) {
  if (level == 0) return patches_[patch].radius;
  const auto [parent, child] = child_place(patch, level, u, v);
  return spheres_[places_[patches_[patch].first_level + level - 1].groups + parent].radius[child];
}

Sphere Pyramid::sphere(int patch, int level, int u, int v) const {
  assert(parts_.spheres);
  if (level == 0) {
    const BoxPatch& whole = patches_[patch];
    return {whole.centre[0], whole.centre[1], whole.centre[2], whole.radius};
  }
  const auto [parent, child] = child_place(patch, level, u, v);
  const SphereGroup& group = level_of(patch, level - 1).spheres[parent];
  return {group.centre[0][child], group.centre[1][child], group.centre[2][child],
          group.radius[child]};
}

}  // namespace weft::bsi
