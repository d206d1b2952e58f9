// Pictures of surfaces, drawn off screen by OSMesa (no display, no GPU needed).
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "bsi/geometry_image.h"

namespace weft::gpu {

using bsi::Vec3;

struct Picture {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;  // 3 bytes a pixel, top row first
};

struct DrawnSurface {
  std::span<const Vec3> positions;                // m, by particle
  std::span<const std::array<int, 3>> triangles;  // particle indices
  std::array<float, 3>
      front_colour{};  // linear 0..1; side the triangles are counter-clockwise from
  std::array<float, 3> back_colour{};
};

struct Camera {
  Vec3 eye{3, -3, 2};
  Vec3 target{0, 0, 0};
  Vec3 up{0, 0, 1};
  double field_of_view_deg = 35;  // vertical
};

// A camera that sees the whole box from a three-quarter view, a little above.
Camera camera_for_box(const Vec3& lowest, const Vec3& highest, double aspect);

// Owns an OSMesa context with an OpenGL 4.5 core profile. One backend a process. Throws
// std::runtime_error with the reason when no context can be had.
class Renderer {
 public:
  Renderer(int width, int height);
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;
  // Shaded with smooth normals, two-sided, anti-aliased, on a light background with a soft ground
  // shade.
  Picture draw(std::span<const DrawnSurface> surfaces, const Camera& camera);

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

// Throws std::runtime_error when the file cannot be written.
void write_png(const std::string& path, const Picture& picture);

}  // namespace weft::gpu
