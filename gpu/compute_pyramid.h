// The pyramids of many bodies on the device. One batch of dispatches rebuilds any number of them.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "bsi/detail/block_levels.h"
#include "bsi/geometry_image.h"
#include "bsi/pyramid.h"

namespace weft::gpu {

using bsi::Vec3;

class GlContext;

// Positions (m) of the particles of a body. If `end` is empty, the body is bounded at `start`.
// Otherwise it is bounded at both ends of its path, and hence on the straight path between them.
struct BodyImage {
  int body = 0;
  std::span<const Vec3> start;
  std::span<const Vec3> end = {};
  // If true, the differences between adjacent vertices (steps) are bounded, too. Self traversals
  // with the tangent certificate need these bounds.
  bool tangents = false;
  // If true, spheres are computed, too. Traversals whose bound is not `box` need them.
  bool spheres = false;
};

struct UnboundedTexel {
  int body = 0;
  bsi::TexelAddress texel;
};

// The box of a block's float32 vertices, m.
struct BlockBox {
  std::array<float, 3> low{}, high{};
  bool operator==(const BlockBox&) const = default;
};

// The pyramids of bodies on the device. Level l of a patch splits its quads into up to 2^l x 2^l
// nested blocks. Along each axis the splitting stops at blocks of one or two quads. Block
// boundaries are bsi::block_boundary(k, quads, log). The last level holds the leaf blocks. No block
// is empty. These are the blocks of bsi::Pyramid. A body of several patches also has the groups of
// bsi::Pyramid. They are ordered by the positions of the patches at the first rebuild in which all
// positions are finite and below bsi::Pyramid::coordinate_limit.
//
// Every block has a box: the exact minima and maxima of the block's float32 vertices. The only
// exception is that a device may flush denormal numbers to zero. On request, every block of a patch
// has the sphere of bsi::Pyramid, with two exceptions. Spheres may be larger on the four top
// levels. They are slightly larger on a device that does not round like the CPU.
//
// Memory on the device: 24 bytes per particle (both ends of its path) and 32 bytes per block. The
// table takes 64 bytes per level of a patch and per group. The map takes 4 bytes per texel of a
// body whose texels are not its particles. A square patch has about one to four blocks per three
// quads: four if both axes have one more quad than a power of two. A strip of quads has up to two
// blocks per quad. A body has fewer than two groups per patch. Tangent bounds take 48 bytes per
// block of a patch that is not a leaf block: a quarter of the blocks of a square patch, half those
// of a strip.
//
// The constructor, the rebuilds and the functions that wait for the device make the context current
// on the calling thread. They throw std::runtime_error with the reason if that fails. The
// constructor and the rebuilds also throw it if OpenGL has no memory or a buffer exceeds the
// device's limit.
class ComputePyramid {
 public:
  // Largest number of quads along an axis of a patch: block boundaries are computed in 32 bits.
  static constexpr int quad_limit = 1 << 15;
  // Largest number of levels and groups of patches, summed over all bodies.
  static constexpr int level_limit = 0xFFFF;

  // Numbers the bodies in the order given. Also throws std::runtime_error if one of these limits is
  // exceeded. The context must outlive the pyramids.
  ComputePyramid(GlContext& context, std::span<const bsi::Atlas* const> bodies);
  ~ComputePyramid();
  ComputePyramid(const ComputePyramid&) = delete;
  ComputePyramid& operator=(const ComputePyramid&) = delete;

  // Uploads the positions of these bodies and bounds the bodies. Other bodies keep their bounds.
  // Makes about one dispatch per two levels of the deepest patch and one per level of groups, for
  // any number of bodies. Tangents and spheres each take another dispatch per two levels. Returns
  // without waiting for the device.
  void rebuild(std::span<const BodyImage> images);
  // Bounds the bodies of the last rebuild() again, from the positions already on the device. For
  // benchmarks of the device's part of a rebuild.
  void rebuild_there();
  // Returns the first texel whose position is not finite or reaches bsi::Pyramid::coordinate_limit,
  // in the first body that has such a texel. Until that body is rebuilt from other positions,
  // traversals of it may give wrong results. Waits for the device.
  std::optional<UnboundedTexel> first_unbounded() const;

  int body_count() const;
  const bsi::Atlas& atlas(int body) const;
  int levels(int body, int patch) const;
  // Returns a level of a patch. The numbers of its blocks are indices into read_boxes().
  const bsi::BlockLevel& level(int body, int patch, int level) const;
  int group_levels(int body) const;
  // Returns the patches of group u of a level of groups.
  std::span<const std::int32_t> patches_of_group(int body, int level, int u) const;
  // Returns the index of a group's box in read_boxes().
  std::size_t group_block(int body, int level, int u) const;
  // Returns the largest |coordinate| (m) of a body's float32 vertices at its last rebuild.
  float magnitude(int body) const;
  bool is_swept(int body) const;
  bool has_tangents(int body) const;
  bool has_spheres(int body) const;
  // For tests: return the box or the sphere of every block of a body. The blocks of groups come
  // last. A block without a sphere, such as a group, has the radius -1. Both functions wait for the
  // device.
  std::vector<BlockBox> read_boxes(int body) const;
  std::vector<bsi::Sphere> read_spheres(int body) const;

  // The buffers and programs on the device, for use within gpu/ only.
  struct Device;
  Device& device() { return *device_; }

 private:
  std::unique_ptr<Device> device_;
};

}  // namespace weft::gpu
