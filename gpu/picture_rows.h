// Draws the rows of a picture: the lit surfaces seen in each pixel, over the background.
#pragma once

#include <span>

#include "gpu/background.h"
#include "gpu/screen_geometry.h"
#include "gpu/shading.h"

namespace weft::gpu {

// References to the parts of a scene to draw. The parts must outlive this struct.
struct LitScene {
  std::span<const DrawnSurface> surfaces;
  const TriangleBatch& batch;
  const ScreenGeometry& geometry;
  const Lights& lights;
  const DepthMap& key_shadow;
  const SrgbTable& srgb;
};

// Draws a picture band by band, so that the samples stay in the processor's cache.
Picture draw_rows(const LitScene& scene, const Background& background, int width, int height);

}  // namespace weft::gpu
