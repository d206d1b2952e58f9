// The data that a ComputePyramid keeps on the device. Private to gpu/.
#pragma once

#include "gpu/compute_pyramid.h"
#include "gpu/compute_shaders.h"
#include "gpu/gl_context.h"
#include "gpu/gl_objects.h"

namespace weft::gpu {

// A block in the layout of the shaders.
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
    std::size_t first_vertex = 0;  // of all particles
    std::size_t block_count = 0;
    std::vector<std::vector<bsi::BlockLevel>> patches;  // by patch: its levels
    std::vector<std::uint32_t> patch_top;               // into the table of levels
    float magnitude = 0;
    bool swept = false;
    bool tangents = false;
    bool spheres = false;
  };
  // A dispatch over all patches that have levels left.
  struct Stage {
    std::uint32_t first_task = 0, task_count = 0, groups = 0;
  };

  GlContext& context;
  const GlFunctions& gl = context.functions();
  // Mesa's software rasterisers round like the CPU; GLSL promises less.
  bool rounds_like_the_cpu = context.backend() != GlBackend::hardware;
  std::vector<Body> bodies;
  std::size_t blocks = 0, tangent_blocks = 0, vertices = 0;
  GlBuffer levels{gl}, map{gl}, tasks{gl};
  // The vertices at the starts of all paths, followed by those at their ends, which only swept
  // bodies use.
  GlBuffer coordinates{gl};
  GlBuffer bounds{gl}, tangents{gl}, unbounded{gl};
  ComputeProgram bound_boxes{gl, shaders::bound_boxes()};
  ComputeProgram bound_tangents{gl, shaders::bound_tangents()};
  ComputeProgram bound_spheres{gl, shaders::bound_spheres(rounds_like_the_cpu)};
  // The stages of the last rebuild: for all bodies, for those with tangents, for those with
  // spheres.
  std::vector<Stage> stages, tangent_stages, sphere_stages;
  std::vector<float> staging;  // a body's positions during the upload

  explicit Device(GlContext& gl_context) : context(gl_context) {}
  void upload(const BodyImage& image);
  void plan(std::span<const BodyImage> images);
  static std::vector<Stage> plan_stages(const std::vector<const Body*>& bounded,
                                        std::vector<shaders::Task>& tasks);
  std::vector<BlockTexels> read_blocks(const Body& body) const;
  void dispatch(ComputeProgram& program, const std::vector<Stage>& stages);
};

}  // namespace weft::gpu
