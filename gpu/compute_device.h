// The private part of ComputePyramid: its buffers and shader programs on the device, and the tables
// on the host that describe them. Private to gpu/.
#pragma once

#include "gpu/compute_pyramid.h"
#include "gpu/compute_shaders.h"
#include "gpu/gl_context.h"
#include "gpu/gl_objects.h"

namespace weft::gpu {

// The bounds of a block in the memory layout of the shaders: its box, and the radius of its sphere
// (m; -1 without a sphere).
struct BlockTexels {
  std::array<float, 3> low{};
  float radius = 0;
  std::array<float, 3> high{};
  float unused = 0;
};

struct ComputePyramid::Device {
  struct Body {
    bsi::Atlas atlas;
    std::size_t first_block = 0;
    std::size_t first_vertex = 0;
    std::size_t block_count = 0;
    std::vector<std::vector<bsi::BlockLevel>> patches;  // levels of each patch, from the top
    std::vector<std::uint32_t> patch_top;  // by patch: index of its top level in `table`
    // Number of levels of groups. Level k has 2^k groups of patches. Group u of level k has the
    // index 2^k - 1 + u among the groups of the body.
    int group_levels = 0;
    std::uint32_t first_group = 0;          // index of the first group in `table`
    std::size_t first_group_block = 0;      // index of the first group's block in the body
    std::vector<std::int32_t> patch_order;  // indices of patches; each group is a range of these
    bool is_ordered = false;
    float magnitude = 0;
    bool swept = false;
    bool tangents = false;
    bool spheres = false;

    std::uint32_t group(int level, int u) const {
      return (std::uint32_t{1} << level) - 1 + static_cast<std::uint32_t>(u);
    }
    std::span<const std::int32_t> patches_of_group(int level, int u) const {
      const auto [begin, end] = bsi::group_range(static_cast<int>(patches.size()), level, u);
      return std::span(patch_order).subspan(begin, end - begin);
    }
    // Returns the index of the body's top in `table`. The top is the group of all patches. Without
    // groups, it is the top level of the only patch.
    std::uint32_t top() const { return group_levels > 0 ? first_group : patch_top[0]; }
    std::size_t top_block() const {
      return first_block + (group_levels > 0 ? first_group_block : patches[0][0].first);
    }
  };
  // One dispatch: a range of the buffer `groups`, which lists groups of a single level.
  struct GroupStage {
    std::uint32_t first = 0, count = 0;
  };
  // One dispatch: a range of the buffer `tasks`, and the number of work groups for it.
  struct Stage {
    std::uint32_t first_task = 0, task_count = 0, groups = 0;
  };

  GlContext& context;
  const GlFunctions& gl = context.functions();
  // Mesa's software rasterisers round like the CPU. GLSL allows other devices to be less exact.
  bool rounds_like_the_cpu = context.backend() != GlBackend::hardware;
  std::vector<Body> bodies;
  std::size_t blocks = 0, tangent_blocks = 0, vertices = 0;
  std::vector<shaders::Level> table;  // copy of the buffer `levels` on the host
  GlBuffer levels{gl}, map{gl}, tasks{gl}, groups{gl};
  // The vertices of all bodies at the starts of their paths, then the vertices at the ends. Only
  // swept bodies use the second half.
  GlBuffer coordinates{gl};
  GlBuffer bounds{gl}, tangents{gl}, unbounded{gl};
  ComputeProgram bound_boxes{gl, shaders::bound_boxes()};
  ComputeProgram bound_groups{gl, shaders::bound_groups()};
  ComputeProgram bound_tangents{gl, shaders::bound_tangents()};
  ComputeProgram bound_spheres{gl, shaders::bound_spheres(rounds_like_the_cpu)};
  // The dispatches of the last rebuild. They compute boxes, bounds of steps, and spheres, in this
  // order.
  std::vector<Stage> stages, tangent_stages, sphere_stages;
  std::vector<GroupStage> group_stages;
  std::vector<float> staging;  // vertices of one body while they are uploaded

  explicit Device(GlContext& gl_context) : context(gl_context) {}
  void upload(const BodyImage& image);
  // Orders the patches of a body by their positions, as bsi::Pyramid does. Does nothing if they are
  // already ordered, or if a position is not finite or reaches bsi::Pyramid::coordinate_limit.
  void order_patches(const BodyImage& image);
  void write_groups(Body& body);
  void plan_groups(const std::vector<const Body*>& bounded);
  void dispatch_groups();
  void plan(std::span<const BodyImage> images);
  static std::vector<Stage> plan_stages(const std::vector<const Body*>& bounded,
                                        std::vector<shaders::Task>& tasks);
  std::vector<BlockTexels> read_blocks(const Body& body) const;
  void dispatch(ComputeProgram& program, const std::vector<Stage>& stages);
};

}  // namespace weft::gpu
