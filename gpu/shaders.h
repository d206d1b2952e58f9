// The renderer's shaders (GLSL 4.50). Positions are relative to the camera's target.
#pragma once

namespace weft::gpu::shaders {

// Directions the light comes from: layer 0 of the shadow texture is the key light, the others
// sample the sky.
inline constexpr int sky_light_count = 16;

extern const char* const depth_vertex;
extern const char* const depth_fragment;
extern const char* const background_vertex;
extern const char* const background_fragment;
extern const char* const surface_vertex;
extern const char* const surface_fragment;
extern const char* const line_vertex;
extern const char* const line_fragment;

}  // namespace weft::gpu::shaders
