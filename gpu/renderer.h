// Pictures of surfaces, drawn by the CPU alone: no display, no OpenGL, nothing to set up.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "bsi/level_of_detail.h"

namespace weft::gpu {

using bsi::Vec3;

struct Picture {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;  // 3 bytes per pixel, top row first
};

// Red, green and blue, linear (not sRGB), 0..1.
using Colour = std::array<float, 3>;

class ColourMap;

// A surface to draw. Preconditions: all positions are finite, and all indices are valid in
// `positions`.
struct DrawnSurface {
  std::span<const Vec3> positions;                // m, by particle
  std::span<const std::array<int, 3>> triangles;  // indices of three particles each
  Colour front_colour{};  // colour of the side from which triangles are counter-clockwise
  Colour back_colour{};
  // Thin dark lines on the surface. Each joins two particles, for example along a row of the image.
  std::span<const std::array<int, 2>> lines = {};
  // Unit normals by position. If empty, vertex_normals() (gpu/triangle_batch.h) computes them.
  std::span<const Vec3> normals = {};
  // If `colour_map` is given, both sides get its colours. `places` holds one number per position,
  // which the map (gpu/colour_map.h) converts to a colour. The numbers are interpolated over
  // triangles. A triangle with NaN at a corner has no_value_colour().
  std::span<const float> places = {};
  const ColourMap* colour_map = nullptr;
};

// The colours of the two sides of a surface.
struct SurfaceColours {
  Colour front{};
  Colour back{};
};
// Returns pair `index` (>= 0) of eight pairs of colours. Higher indices repeat the pairs. The back
// is paler than the front.
SurfaceColours palette(int index);
// The grey of obstacles.
SurfaceColours obstacle_colours();
// The red of spheres that touch each other.
Colour touching_colour();

struct Camera {
  Vec3 eye{3, -3, 2};
  Vec3 target{0, 0, 0};
  Vec3 up{0, 0, 1};
  // True: the scene is lit from below, as if the picture from above had been turned over. Only the
  // background keeps its place.
  bool lit_from_below = false;
  double field_of_view_deg = 35;  // vertical angle of view, degrees
};

// Returns a camera that sees all points from a three-quarter view, a little above. The points are
// in the middle of the picture. The camera is as near as a margin of about a twentieth of the
// picture on each side allows. `aspect` is width / height. Points no farther apart than a
// millionth of their coordinates are treated as a box, of 1 mm or twice that millionth. O(points).
// Preconditions: at least one point, all finite.
Camera camera_for_points(std::span<const Vec3> points, double aspect);
// Returns the camera of camera_for_points() for the corners of a box. Precondition: lowest <=
// highest.
Camera camera_for_box(const Vec3& lowest, const Vec3& highest, double aspect);

// Returns the tolerance that keeps a surface of reduced detail within `pixels` (>= 0) of the
// original in a picture of width x height pixels. The bound neglects terms of second order in the
// angle that a deviation spans as seen from the eye.
bsi::DetailTolerance pixel_tolerance(const Camera& camera, int width, int height, double pixels);

// Returns lines for DrawnSurface: the borders of each patch, and rows and columns that split it
// into cells. Cells are as square as whole numbers of quads allow, measured in metres at
// `positions` (by particle, finite). The last cell of an axis may be narrower. There are at most 12
// cells along the longest axis of all patches. O(particles).
std::vector<std::array<int, 2>> grid_lines(const bsi::Atlas& atlas,
                                           std::span<const Vec3> positions);

// Draws pictures of one size. It keeps its memory from picture to picture.
class Renderer {
 public:
  // Sizes are in pixels, 1..8192 each. Throws std::runtime_error for other sizes.
  Renderer(int width, int height);
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;
  // Draws surfaces with smooth normals (area-weighted), two-sided and anti-aliased, on a light
  // background. A key light with soft shadows shines from the upper left. The sky (in the direction
  // `camera.up`) gives most of the other light and is shadowed, too, so that folds and contacts
  // darken. Shadows reach twice as far from `camera.target` as the picture does. Surfaces are cut
  // off where their distance from the eye, measured along the camera's axis, is less than a
  // thousandth of the distance from the eye to the target. The same input gives the same bytes.
  // Drawing runs on one thread and takes about 0.5 us per triangle and 0.04 us per pixel that shows
  // a triangle. Throws std::invalid_argument for a camera whose eye is its target, whose `up` is
  // zero, or whose field of view is not between 0 and 180 degrees. Throws std::runtime_error if a
  // position is not finite or farther than 1e18 m from the target, or the eye nearer than 1e-18 m.
  Picture draw(std::span<const DrawnSurface> surfaces, const Camera& camera);

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

// Writes a PNG file of 8-bit sRGB. Throws std::runtime_error, which names the file, if writing
// fails.
void write_png(const std::string& path, const Picture& picture);
// Returns true if the PNG file at `path` has the text chunk with which write_png() signs its files,
// Software = "Weft". Reads no further than the first pixels. Returns false if the file cannot be
// read.
bool is_own_png(const std::string& path);

}  // namespace weft::gpu
