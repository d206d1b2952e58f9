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
// bsi::Pyramid, ordered by the positions of the patches at the first rebuild.
//
// Every block has a box. On any device its bits equal the minima and maxima of the block's float32
// vertices. On request, every block of a patch has the sphere of bsi::Pyramid, with two exceptions.
// Spheres may be larger on the four top levels. They are slightly larger on a device that does not
// round like the CPU.
//
// Memory on the device: 24 bytes per particle (both ends of its path) and 32 bytes per block. A
// patch has about one block per three quads. It has up to four blocks per three quads if both axes
// have one more quad than a power of two. A body has fewer than two groups per patch. Tangent
// bounds take 48 bytes per block that is not a leaf block (about a quarter of the blocks).
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

  // Uploads the positions of these bodies and bounds the bodies; others keep their bounds. Makes
  // one dispatch per two levels and one per level of groups, for any number of bodies. Tangents and
  // spheres take one more dispatch each per two levels. Returns without waiting for the device.
  void rebuild(std::span<const BodyImage> images);
  // Bounds the bodies of the last rebuild() again, from the positions already on the device. For
  // benchmarks of the device's part of a rebuild.
  void rebuild_there();
  // Returns the first texel whose position is not finite or reaches bsi::Pyramid::coordinate_limit,
  // in the first body that has such a texel. Until that body is rebuilt, traversals of it give
  // wrong results. Waits for the device.
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
  // Largest |coordinate| of the float32 vertices at the last rebuild, m.
  float magnitude(int body) const;
  bool is_swept(int body) const;
  bool has_tangents(int body) const;
  bool has_spheres(int body) const;
  // For tests: return the box or the sphere of every block of a body. The blocks of groups come
  // last. A block without a sphere, such as a group, has the radius -1. Both wait for the device.
  std::vector<BlockBox> read_boxes(int body) const;
  std::vector<bsi::Sphere> read_spheres(int body) const;

  // The buffers and programs on the device, for use within gpu/ only.
  struct Device;
  Device& device() { return *device_; }

 private:
  std::unique_ptr<Device> device_;
};

}  // namespace weft::gpu
