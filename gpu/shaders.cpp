#include "gpu/shaders.h"

namespace weft::gpu::shaders {

const char* const depth_vertex = R"(#version 450 core
layout(location = 0) in vec3 position;
uniform mat4 to_clip;
invariant gl_Position;
void main() { gl_Position = to_clip * vec4(position, 1.0); }
)";

const char* const depth_fragment = R"(#version 450 core
void main() {}
)";

// One triangle over the whole picture.
const char* const background_vertex = R"(#version 450 core
uniform vec3 ray_centre, ray_right, ray_up;
out vec3 ray;
void main() {
  vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  ray = ray_centre + corner.x * ray_right + corner.y * ray_up;
  gl_Position = vec4(corner, 0.0, 1.0);
}
)";

const char* const background_fragment = R"(#version 450 core
uniform vec3 up;
in vec3 ray;
out vec4 colour;
vec3 to_srgb(vec3 c) {
  return mix(1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, 12.92 * c, lessThan(c, vec3(0.0031308)));
}
void main() {
  const vec3 ground = vec3(0.60, 0.60, 0.61), horizon = vec3(0.90, 0.91, 0.92);
  const vec3 zenith = vec3(0.66, 0.74, 0.84);
  float elevation = dot(normalize(ray), up);
  vec3 light = elevation < 0.0 ? mix(horizon, ground, smoothstep(0.0, 0.9, -elevation))
                               : mix(horizon, zenith, smoothstep(0.0, 0.9, elevation));
  colour = vec4(to_srgb(light), 1.0);
}
)";

const char* const surface_vertex = R"(#version 450 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
uniform mat4 camera_matrix;
centroid out vec3 surface_position, surface_normal;
invariant gl_Position;
void main() {
  surface_position = position;
  surface_normal = normal;
  gl_Position = camera_matrix * vec4(position, 1.0);
}
)";

// Draws a line a little nearer to the eye, along the ray of sight, so that its picture stays where
// it is.
const char* const line_vertex = R"(#version 450 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
uniform mat4 camera_matrix;
uniform vec3 eye;
uniform float pull;  // share of the way to the eye
centroid out vec3 surface_position, surface_normal;
void main() {
  surface_position = position;
  surface_normal = normal;
  gl_Position = camera_matrix * vec4(mix(position, eye, pull), 1.0);
}
)";

// Lambert's law under a key light and a sky of many lights, each with its shadow; light from the
// ground, without; a faint sheen.
const char* const surface_fragment = R"(#version 450 core
const int sky_lights = 16;
uniform mat4 key_matrix;               // to the shadow texture, 0..1
uniform mat4 sky_matrix[sky_lights];
uniform vec3 key_direction;
uniform vec3 sky_direction[sky_lights];
uniform vec3 up, eye;
uniform float key_texel, sky_texel;    // size of a shadow texel, m
uniform vec3 front_colour, back_colour;
layout(binding = 0) uniform sampler2DArrayShadow key_shadow;
layout(binding = 1) uniform sampler2DArrayShadow sky_shadow;
centroid in vec3 surface_position, surface_normal;
out vec4 colour;

vec3 to_srgb(vec3 c) {
  return mix(1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, 12.92 * c, lessThan(c, vec3(0.0031308)));
}

// The share of a square of 3 x 3 texels that is lit: the rim of the key light's shadow is soft.
// Four gathers of 2 x 2 texels cost a quarter of what as many filtered look-ups do.
float key_visibility(vec3 position) {
  vec3 place = (key_matrix * vec4(position, 1.0)).xyz;
  float depth = min(place.z, 1.0);
  vec2 size = vec2(textureSize(key_shadow, 0).xy);
  vec2 texel = place.xy * size - 0.5;
  vec2 low = floor(texel), weight = texel - low;
  float sum = 0.0;
  for (int i = 0; i < 4; ++i) {
    vec2 block = vec2(i & 1, i >> 1);
    vec4 lit = textureGather(key_shadow, vec3((low + 2.0 * block) / size, 0.0), depth);
    // The outer two of the four texels along an axis count by how far the square reaches in.
    vec2 first = mix(1.0 - weight, vec2(1.0), block), second = mix(vec2(1.0), weight, block);
    sum += dot(lit, vec4(first.x * second.y, second.x * second.y, second.x * first.y,
                         first.x * first.y));
  }
  return sum / 9.0;
}

// Light of the sky on a surface with this normal, as a share of what a free level one receives.
float sky_light(vec3 position, vec3 normal) {
  float sum = 0.0, full = 0.0;
  for (int i = 0; i < sky_lights; ++i) {
    full += dot(up, sky_direction[i]);
    float cosine = dot(normal, sky_direction[i]);
    if (cosine <= 0.0) continue;
    vec3 place = (sky_matrix[i] * vec4(position, 1.0)).xyz;
    sum += cosine * texture(sky_shadow, vec4(place.xy, float(i), min(place.z, 1.0)));
  }
  return sum / full;
}

void main() {
  vec3 view = normalize(eye - surface_position);
  vec3 normal = normalize(surface_normal);
  if (!gl_FrontFacing) normal = -normal;
  vec3 albedo = gl_FrontFacing ? front_colour : back_colour;

  // Shadows are looked up a little off the surface, so that it does not shade itself.
  float cosine = max(dot(normal, key_direction), 0.0);
  float key = cosine * key_visibility(surface_position + (2.5 * key_texel) * normal);
  float sky = sky_light(surface_position + (1.5 * sky_texel) * normal, normal);
  float ground = 0.5 - 0.5 * dot(normal, up);
  float fill = max(dot(normal, view), 0.0);

  vec3 light = key * vec3(0.93, 0.88, 0.80) + sky * vec3(0.42, 0.46, 0.52) +
               ground * vec3(0.22, 0.21, 0.20) + fill * vec3(0.10);
  float sheen = pow(max(dot(normal, normalize(view + key_direction)), 0.0), 24.0) * key;
  float rim = pow(1.0 - fill, 4.0) * (0.25 + 0.75 * sky);
  vec3 result = albedo * (light + vec3(0.15) * rim) + vec3(0.05) * sheen;
  colour = vec4(to_srgb(min(result, vec3(1.0))), 1.0);
}
)";

// Fades out where the surface turns away: there lines crowd, and the far side's would shine
// through.
const char* const line_fragment = R"(#version 450 core
uniform vec3 eye;
centroid in vec3 surface_position, surface_normal;
out vec4 colour;
void main() {
  float facing = abs(dot(normalize(eye - surface_position), normalize(surface_normal)));
  colour = vec4(0.0, 0.0, 0.0, 0.22 * smoothstep(0.05, 0.35, facing));
}
)";

}  // namespace weft::gpu::shaders
