// The groups of patches of a ComputePyramid.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "bsi/detail/patch_order.h"
#include "gpu/compute_device.h"

namespace weft::gpu {
namespace {

using Place = std::array<float, 3>;

// Returns twice the centre of the box of a patch's float32 vertices, as bsi::Pyramid computes it.
// Returns nothing if a vertex is not finite or reaches bsi::Pyramid::coordinate_limit.
std::optional<Place> place_of_patch(const bsi::Atlas& atlas, int patch, const BodyImage& image) {
  constexpr float far = std::numeric_limits<float>::max();
  Place low{far, far, far}, high{-far, -far, -far};
  const int first = atlas.first_texel(patch);
  const int last = first + atlas.patches()[patch].texel_count();
  for (const std::span<const Vec3> positions : {image.start, image.end}) {
    if (positions.empty()) continue;
    for (int texel = first; texel < last; ++texel) {
      const Eigen::Vector3f p = positions[atlas.particle_of_texel(texel)].cast<float>();
      if (!(p.array().abs() < bsi::Pyramid::coordinate_limit).all()) return std::nullopt;
      for (int axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], p[axis]);
        high[axis] = std::max(high[axis], p[axis]);
      }
    }
  }
  return Place{low[0] + high[0], low[1] + high[1], low[2] + high[2]};
}

}  // namespace

void ComputePyramid::Device::order_patches(const BodyImage& image) {
  Body& body = bodies[image.body];
  if (body.is_ordered || body.group_levels == 0) return;
  std::vector<Place> places;
  for (int patch = 0; patch < static_cast<int>(body.patches.size()); ++patch) {
    const std::optional<Place> place = place_of_patch(body.atlas, patch, image);
    if (!place) return;  // the next rebuild tries again
    places.push_back(*place);
  }
  body.patch_order = bsi::order_by_place(places);
  body.is_ordered = true;
  write_groups(body);
}

// Writes the children of a body's groups to the table of levels. These children are groups of the
// next level or, on the last level of groups, the top levels of patches.
void ComputePyramid::Device::write_groups(Body& body) {
  for (int level = 0; level < body.group_levels; ++level) {
    for (int u = 0; u < 1 << level; ++u) {
      shaders::Level& group = table[body.first_group + body.group(level, u)];
      if (level + 1 < body.group_levels) {
        group.first_child = body.first_group + body.group(level + 1, 2 * u);
        group.second_child = group.first_child + 1;
      } else {
        const auto patches = body.patches_of_group(level, u);
        group.first_child = body.patch_top[patches.front()];
        group.second_child = body.patch_top[patches.back()];
      }
    }
  }
  const std::size_t count = body.group(body.group_levels, 0);
  levels.write(std::span<const shaders::Level>(table).subspan(body.first_group, count),
               body.first_group * sizeof(shaders::Level));
}

// Plans one dispatch per level of groups of these bodies, from the last level up.
void ComputePyramid::Device::plan_groups(const std::vector<const Body*>& bounded) {
  group_stages.clear();
  int deepest = 0;
  for (const Body* body : bounded) deepest = std::max(deepest, body->group_levels);
  std::vector<std::uint32_t> numbers;
  for (int level = deepest - 1; level >= 0; --level) {
    GroupStage stage;
    stage.first = static_cast<std::uint32_t>(numbers.size());
    for (const Body* body : bounded) {
      if (level >= body->group_levels) continue;
      for (int u = 0; u < 1 << level; ++u) {
        numbers.push_back(body->first_group + body->group(level, u));
      }
    }
    stage.count = static_cast<std::uint32_t>(numbers.size()) - stage.first;
    group_stages.push_back(stage);
  }
  groups.reserve(numbers.size() * sizeof(std::uint32_t), "groups of patches");
  groups.write(std::span<const std::uint32_t>(numbers));
}

void ComputePyramid::Device::dispatch_groups() {
  if (group_stages.empty()) return;
  bound_groups.use();
  levels.bind(0);
  groups.bind(3);
  bounds.bind(4);
  for (const GroupStage& stage : group_stages) {
    bound_groups.set("first_group", stage.first);
    bound_groups.set("group_count", stage.count);
    gl.DispatchCompute((stage.count + shaders::group_size - 1) / shaders::group_size, 1, 1);
    gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
  }
}

}  // namespace weft::gpu
