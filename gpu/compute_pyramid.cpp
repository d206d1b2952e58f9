#include "gpu/compute_pyramid.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "gpu/compute_device.h"

namespace weft::gpu {
namespace {

using Vertex = std::array<float, 3>;
constexpr std::uint32_t all_bounded = 0xFFFFFFFF;

// Returns the levels of a patch from its top down. Numbers the blocks of the patch from `blocks`
// on, and advances `blocks` past them.
std::vector<bsi::BlockLevel> block_levels(const bsi::Patch& image, std::size_t& blocks) {
  const int depth_u = std::max(0, bsi::ceil_log2(image.quad_cols()) - 1);
  const int depth_v = std::max(0, bsi::ceil_log2(image.quad_rows()) - 1);
  std::vector<bsi::BlockLevel> levels;
  for (int level = 0; level <= std::max(depth_u, depth_v); ++level) {
    levels.push_back({blocks, std::min(level, depth_u), std::min(level, depth_v)});
    blocks += levels.back().count();
  }
  return levels;
}

// Appends the levels of all patches of a body to the table.
void append_levels(ComputePyramid::Device::Body& body, std::uint32_t number, std::size_t first_map,
                   std::size_t& tangent_blocks, std::vector<shaders::Level>& table) {
  const bsi::Atlas& atlas = body.atlas;
  for (std::size_t patch = 0; patch < atlas.patches().size(); ++patch) {
    const bsi::Patch& image = atlas.patches()[patch];
    if (std::max(image.quad_rows(), image.quad_cols()) > ComputePyramid::quad_limit) {
      throw std::runtime_error("patches on the device have at most " +
                               std::to_string(ComputePyramid::quad_limit) + " quads along an axis");
    }
    body.patch_top.push_back(static_cast<std::uint32_t>(table.size()));
    body.patches.push_back(block_levels(image, body.block_count));
    for (const bsi::BlockLevel& place : body.patches.back()) {
      shaders::Level level;
      level.first = static_cast<std::uint32_t>(body.first_block + place.first);
      level.log_u = place.log_u;
      level.log_v = place.log_v;
      level.leaf = &place == &body.patches.back().back() ? 1 : 0;
      level.quad_rows = image.quad_rows();
      level.quad_cols = image.quad_cols();
      level.rows = image.rows;
      level.cols = image.cols;
      level.first_texel = atlas.first_texel(static_cast<int>(patch));
      level.first_quad = atlas.first_quad(static_cast<int>(patch));
      level.first_vertex = static_cast<std::uint32_t>(body.first_vertex);
      level.first_map = shaders::no_map;
      if (atlas.is_identity()) {
        level.first_vertex += level.first_texel;
      } else {
        level.first_map = static_cast<std::uint32_t>(first_map) + level.first_texel;
      }
      level.body = number;
      level.first_tangent = static_cast<std::uint32_t>(tangent_blocks);
      tangent_blocks += level.leaf != 0 ? 0 : place.count();
      table.push_back(level);
    }
  }
}

// Appends the groups of a body to the table. write_groups() sets their children later.
void append_groups(ComputePyramid::Device::Body& body, std::uint32_t number,
                   std::vector<shaders::Level>& table) {
  const int patches = static_cast<int>(body.patches.size());
  body.group_levels = bsi::group_levels_above(patches);
  body.first_group = static_cast<std::uint32_t>(table.size());
  body.first_group_block = body.block_count;
  body.patch_order.resize(patches);
  std::iota(body.patch_order.begin(), body.patch_order.end(), 0);
  body.block_count += body.group(body.group_levels, 0);
  for (std::size_t i = body.first_group_block; i < body.block_count; ++i) {
    shaders::Level group;
    group.first = static_cast<std::uint32_t>(body.first_block + i);
    group.body = number;
    table.push_back(group);
  }
}

}  // namespace

ComputePyramid::ComputePyramid(GlContext& context, std::span<const bsi::Atlas* const> bodies) {
  context.make_current();
  device_ = std::make_unique<Device>(context);
  Device& own = *device_;
  std::vector<std::uint32_t> map;
  for (const bsi::Atlas* atlas : bodies) {
    Device::Body body;
    body.atlas = *atlas;
    body.first_block = own.blocks;
    body.first_vertex = own.vertices;
    const auto number = static_cast<std::uint32_t>(own.bodies.size());
    append_levels(body, number, map.size(), own.tangent_blocks, own.table);
    append_groups(body, number, own.table);
    if (!atlas->is_identity()) {
      for (int t = 0; t < atlas->texel_count(); ++t) map.push_back(atlas->particle_of_texel(t));
    }
    own.blocks += body.block_count;
    own.vertices += atlas->particle_count();
    own.bodies.push_back(std::move(body));
  }
  if (own.table.size() > level_limit) {
    throw std::runtime_error("the patches of the bodies have more than " +
                             std::to_string(level_limit) + " levels and groups together");
  }
  own.levels.reserve(own.table.size() * sizeof(shaders::Level), "levels of patches");
  own.levels.write(std::span<const shaders::Level>(own.table));
  for (Device::Body& body : own.bodies) own.write_groups(body);
  own.map.reserve(map.size() * sizeof(std::uint32_t), "particles of texels");
  own.map.write(std::span<const std::uint32_t>(map));
  own.coordinates.reserve(own.vertices * 2 * sizeof(Vertex), "vertices");
  own.bounds.reserve(own.blocks * sizeof(BlockTexels), "boxes and spheres");
  own.tangents.reserve(0, "bounds of steps");  // plan() enlarges the buffer when it is needed
  const std::vector<std::uint32_t> bounded(own.bodies.size(), all_bounded);
  own.unbounded.reserve(bounded.size() * sizeof(std::uint32_t), "marks of bodies");
  own.unbounded.write(std::span<const std::uint32_t>(bounded));
  check_gl(own.gl, "hold the pyramids");
}

ComputePyramid::~ComputePyramid() { device_->context.make_current(); }

void ComputePyramid::Device::upload(const BodyImage& image) {
  Body& body = bodies[image.body];
  body.swept = !image.end.empty();
  body.tangents = image.tangents;
  body.spheres = image.spheres;
  body.magnitude = 0;
  std::size_t first = body.first_vertex;
  for (const std::span<const Vec3> positions : {image.start, image.end}) {
    if (positions.empty()) continue;
    assert(static_cast<int>(positions.size()) == body.atlas.particle_count());
    staging.resize(3 * positions.size());
    float largest = 0;
    for (std::size_t i = 0; i < positions.size(); ++i) {
      for (int axis = 0; axis < 3; ++axis) {
        const auto rounded = static_cast<float>(positions[i][axis]);
        staging[3 * i + axis] = rounded;
        largest = std::fabs(rounded) > largest ? std::fabs(rounded) : largest;
      }
    }
    body.magnitude = std::max(body.magnitude, largest);
    coordinates.write(std::span<const float>(staging), first * sizeof(Vertex));
    first += vertices;
  }
}

// Plans the dispatches from the last levels up. Each dispatch computes up to two levels of a patch;
// the first dispatch also computes the leaf blocks.
std::vector<ComputePyramid::Device::Stage> ComputePyramid::Device::plan_stages(
    const std::vector<const Body*>& bounded, std::vector<shaders::Task>& tasks) {
  std::vector<Stage> stages;
  for (int up = 0;; up += 2) {
    Stage stage;
    stage.first_task = static_cast<std::uint32_t>(tasks.size());
    for (const Body* body : bounded) {
      for (std::size_t patch = 0; patch < body->patches.size(); ++patch) {
        const int lowest = static_cast<int>(body->patches[patch].size()) - 1 - up;
        if (lowest < (up > 0 ? 1 : 0)) continue;
        const int top = std::max(lowest - 2, 0);
        const std::uint32_t first = body->patch_top[patch];
        tasks.push_back({stage.groups, first + lowest, first + std::max(lowest - 1, 0),
                         (first + top) | (body->swept ? 0x80000000U : 0U)});
        stage.groups += static_cast<std::uint32_t>(
            (body->patches[patch][top].count() + shaders::group_size - 1) / shaders::group_size);
      }
    }
    stage.task_count = static_cast<std::uint32_t>(tasks.size()) - stage.first_task;
    if (stage.task_count == 0) return stages;
    stages.push_back(stage);
  }
}

void ComputePyramid::Device::plan(std::span<const BodyImage> images) {
  std::vector<const Body*> all, with_tangents, with_spheres;
  for (const BodyImage& image : images) {
    const Body* body = &bodies[image.body];
    all.push_back(body);
    if (body->tangents) with_tangents.push_back(body);
    if (body->spheres) with_spheres.push_back(body);
  }
  std::vector<shaders::Task> planned;
  stages = plan_stages(all, planned);
  tangent_stages = plan_stages(with_tangents, planned);
  sphere_stages = plan_stages(with_spheres, planned);
  tasks.reserve(planned.size() * sizeof(shaders::Task), "tasks");
  tasks.write(std::span<const shaders::Task>(planned));
  plan_groups(all);
  if (!with_tangents.empty()) {
    tangents.reserve(tangent_blocks * sizeof(shaders::Tangent), "bounds of steps");
  }
}

void ComputePyramid::Device::dispatch(ComputeProgram& program, const std::vector<Stage>& planned) {
  program.use();
  levels.bind(0);
  coordinates.bind(1);
  map.bind(2);
  tasks.bind(3);
  bounds.bind(4);
  tangents.bind(6);
  program.set("vertex_count", static_cast<GLuint>(vertices));
  for (std::size_t i = 0; i < planned.size(); ++i) {
    program.set("first_task", planned[i].first_task);
    program.set("task_count", planned[i].task_count);
    program.set("from_image", i == 0 ? 1 : 0);
    gl.DispatchCompute(planned[i].groups, 1, 1);
    gl.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
  }
  gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
}

void ComputePyramid::rebuild(std::span<const BodyImage> images) {
  Device& own = *device_;
  own.context.make_current();
  for (const BodyImage& image : images) {
    own.upload(image);
    own.order_patches(image);
    own.unbounded.write(std::span(&all_bounded, 1), image.body * sizeof(std::uint32_t));
  }
  own.plan(images);
  rebuild_there();
}

void ComputePyramid::rebuild_there() {
  Device& own = *device_;
  own.context.make_current();
  own.unbounded.bind(5);
  own.dispatch(own.bound_boxes, own.stages);
  own.dispatch_groups();
  if (!own.tangent_stages.empty()) own.dispatch(own.bound_tangents, own.tangent_stages);
  if (!own.sphere_stages.empty()) own.dispatch(own.bound_spheres, own.sphere_stages);
  check_gl(own.gl, "bound bodies");
}

std::optional<UnboundedTexel> ComputePyramid::first_unbounded() const {
  device_->context.make_current();
  std::vector<std::uint32_t> texels(device_->bodies.size());
  device_->unbounded.read(std::span(texels));
  for (std::size_t b = 0; b < texels.size(); ++b) {
    if (texels[b] == all_bounded) continue;
    return UnboundedTexel{static_cast<int>(b),
                          device_->bodies[b].atlas.texel_address(static_cast<int>(texels[b]))};
  }
  return std::nullopt;
}

int ComputePyramid::body_count() const { return static_cast<int>(device_->bodies.size()); }
const bsi::Atlas& ComputePyramid::atlas(int body) const { return device_->bodies[body].atlas; }
int ComputePyramid::levels(int body, int patch) const {
  return static_cast<int>(device_->bodies[body].patches[patch].size());
}
const bsi::BlockLevel& ComputePyramid::level(int body, int patch, int level) const {
  return device_->bodies[body].patches[patch][level];
}
int ComputePyramid::group_levels(int body) const { return device_->bodies[body].group_levels; }
std::span<const std::int32_t> ComputePyramid::patches_of_group(int body, int level, int u) const {
  const Device::Body& own = device_->bodies[body];
  return own.patches_of_group(level, u);
}
std::size_t ComputePyramid::group_block(int body, int level, int u) const {
  const Device::Body& own = device_->bodies[body];
  return own.first_group_block + own.group(level, u);
}
float ComputePyramid::magnitude(int body) const { return device_->bodies[body].magnitude; }
bool ComputePyramid::is_swept(int body) const { return device_->bodies[body].swept; }
bool ComputePyramid::has_tangents(int body) const { return device_->bodies[body].tangents; }
bool ComputePyramid::has_spheres(int body) const { return device_->bodies[body].spheres; }

std::vector<BlockTexels> ComputePyramid::Device::read_blocks(const Body& body) const {
  std::vector<BlockTexels> texels(body.block_count);
  bounds.read(std::span(texels), body.first_block * sizeof(BlockTexels));
  return texels;
}

std::vector<BlockBox> ComputePyramid::read_boxes(int body) const {
  device_->context.make_current();
  std::vector<BlockBox> boxes;
  for (const BlockTexels& block : device_->read_blocks(device_->bodies[body])) {
    boxes.push_back({block.low, block.high});
  }
  return boxes;
}

std::vector<bsi::Sphere> ComputePyramid::read_spheres(int body) const {
  device_->context.make_current();
  std::vector<bsi::Sphere> spheres;
  for (const BlockTexels& block : device_->read_blocks(device_->bodies[body])) {
    const auto middle = [&](int axis) { return 0.5F * (block.low[axis] + block.high[axis]); };
    spheres.push_back({middle(0), middle(1), middle(2), block.radius});
  }
  return spheres;
}

}  // namespace weft::gpu
