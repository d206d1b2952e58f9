// The pyramids of all bodies of a scene on the device, rebuilt in one batch of dispatches.
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

// Positions (metres) of the particles of a body. With `end` empty the body is bounded as it is at
// `start`. Otherwise it is bounded at both ends of its path, and so all along a straight one.
struct BodyImage {
  int body = 0;
  std::span<const Vec3> start;
  std::span<const Vec3> end = {};
  // Bound the steps between vertices too, for self traversals with the tangent certificate.
  bool tangents = false;
  // Make spheres too, for traversals whose bound is not `box`.
  bool spheres = false;
};

struct UnboundedTexel {
  int body = 0;
  bsi::TexelAddress texel;
};

// The box of the float32 vertices in a block, m.
struct BlockBox {
  std::array<float, 3> low{}, high{};
  bool operator==(const BlockBox&) const = default;
};

// Level l of a patch splits its quads into up to 2^l x 2^l nested blocks, each axis stopping at
// blocks of one or two quads; block boundaries are bsi::block_boundary(k, quads, log). The last
// level holds the leaf blocks. No block is empty. These are the blocks of bsi::Pyramid.
//
// Every block has a box, bit-equal to minima and maxima of its float32 vertices on any device. When
// spheres are asked for, every block has that of bsi::Pyramid. On the four top levels spheres are
// larger here, and a little larger on a device whose roots round differently.
//
// Memory on the device: 24 bytes per particle (both ends of its path) and 32 per block, of which
// there are about a third of the quads (up to 4/3, where an axis has one more quad than a power of
// two); 48 per block that is no leaf (a quarter of them) for the tangent bounds.
//
// All functions make the context current on the calling thread, and throw std::runtime_error with
// the reason when OpenGL fails (memory, a buffer beyond what the device allows).
class ComputePyramid {
 public:
  // The most quads along an axis of a patch: block boundaries are computed in 32 bits.
  static constexpr int quad_limit = 1 << 15;
  // The most levels of all patches of all bodies together.
  static constexpr int level_limit = 0xFFFF;

  // Numbers the bodies in their order. Throws std::runtime_error too where one of the limits is
  // exceeded. The context must outlive this.
  ComputePyramid(GlContext& context, std::span<const bsi::Atlas* const> bodies);
  ~ComputePyramid();
  ComputePyramid(const ComputePyramid&) = delete;
  ComputePyramid& operator=(const ComputePyramid&) = delete;

  // Uploads these bodies and bounds them; the others stay as they are. Makes one dispatch for every
  // two levels, whatever the number of bodies. Returns without waiting for the device.
  void rebuild(std::span<const BodyImage> images);
  // Bounds the same bodies again from the positions already on the device: this is what a rebuild
  // costs the device.
  void rebuild_there();
  // Returns the first texel, of the first body that has one, that is not finite or not below
  // bsi::Pyramid::coordinate_limit. No result with that body may be used until its next rebuild.
  // Waits for the device.
  std::optional<UnboundedTexel> first_unbounded() const;

  int body_count() const;
  const bsi::Atlas& atlas(int body) const;
  int levels(int body, int patch) const;
  // Its blocks are numbered through the body, as read_boxes() has them.
  const bsi::BlockLevel& level(int body, int patch, int level) const;
  // The largest |coordinate| of the float32 vertices at the last rebuild, m.
  float magnitude(int body) const;
  bool is_swept(int body) const;
  bool has_tangents(int body) const;
  bool has_spheres(int body) const;
  // Return the values by block, for tests. They wait for the device.
  std::vector<BlockBox> read_boxes(int body) const;
  std::vector<bsi::Sphere> read_spheres(int body) const;

  // The buffers, for gpu/ alone.
  struct Device;
  Device& device() { return *device_; }

 private:
  std::unique_ptr<Device> device_;
};

}  // namespace weft::gpu
