// Draws text into pictures.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "gpu/renderer.h"

namespace weft::gpu {

// Size of a character in pixels at scale 1, including the gaps to its neighbours.
inline constexpr int character_width = 6, character_height = 13;

// Red, green and blue of a pixel, sRGB.
using PixelColour = std::array<std::uint8_t, 3>;

// Writes a line of text whose upper left corner is at the pixel (left, top). Each pixel of the font
// becomes scale x scale pixels. Pixels outside the picture are skipped. A character that is not
// printable ASCII appears as '?'. Precondition: scale >= 1.
void draw_text(Picture& picture, int left, int top, int scale, const PixelColour& colour,
               std::string_view text);

}  // namespace weft::gpu
