#include "gpu/renderer.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "gpu/gl_context.h"
#include "gpu/gl_objects.h"
#include "gpu/shaders.h"
#include "gpu/triangle_batch.h"

namespace weft::gpu {
namespace {

using Eigen::Matrix4f;
using Eigen::Vector3f;

constexpr int sample_count = 4;  // OpenGL 4.5 guarantees as many
constexpr int key_shadow_size = 1024;
constexpr int sky_shadow_size = 384;
constexpr int sky_lights = shaders::sky_light_count;
// Lines are brought nearer to the eye by so many sizes of a pixel at their distance, so that the
// surface they are on does not hide them. (Pushing the surface back by its slope would let what is
// 2 mm behind a fold, seen edge-on, shine through.)
constexpr double line_pull_in_pixels = 1.5;

GLuint link_stages(const GlFunctions& gl, const char* vertex, const char* fragment) {
  const std::array<std::pair<GLenum, std::string>, 2> stages{
      {{GL_VERTEX_SHADER, vertex}, {GL_FRAGMENT_SHADER, fragment}}};
  return link_program(gl, stages);
}

// Right, up and backward, as the camera sees them, in world coordinates.
struct ViewFrame {
  Vec3 right, up, backward;
};

// `up` may be any direction, even that of the view.
ViewFrame look_along(const Vec3& backward, const Vec3& up) {
  ViewFrame frame;
  frame.backward = backward.normalized();
  Vec3 right = up.cross(frame.backward);
  if (right.norm() < 1e-6 * up.norm()) right = frame.backward.unitOrthogonal();
  frame.right = right.normalized();
  frame.up = frame.backward.cross(frame.right);
  return frame;
}

// Returns an orthographic projection for a light far away along frame.backward: a box of half size
// `reach` around the origin goes to clip space.
Matrix4f light_matrix(const ViewFrame& frame, double reach) {
  Matrix4f matrix = Matrix4f::Identity();
  matrix.row(0).head<3>() = (frame.right / reach).cast<float>();
  matrix.row(1).head<3>() = (frame.up / reach).cast<float>();
  matrix.row(2).head<3>() = (-frame.backward / reach).cast<float>();
  return matrix;
}

// Returns the map from clip space, -1..1, to the coordinates and the depth of a texture, 0..1.
Matrix4f texture_of_clip() {
  Matrix4f matrix = Matrix4f::Identity() * 0.5F;
  matrix.col(3) << 0.5F, 0.5F, 0.5F, 1.0F;
  return matrix;
}

struct Depths {
  double nearest = 0;
  double farthest = 0;
};

// Returns the range of depths that holds everything in front of the eye. A surface nearer to it
// than a thousandth of the farthest is cut off: depth has 32 bits, not infinitely many.
Depths depth_range(std::span<const DrawnSurface> surfaces, const Camera& camera,
                   const ViewFrame& frame) {
  double nearest = INFINITY;
  double farthest = 0;
  for (const DrawnSurface& surface : surfaces) {
    for (const Vec3& position : surface.positions) {
      const double depth = frame.backward.dot(camera.eye - position);
      nearest = std::min(nearest, depth);
      farthest = std::max(farthest, depth);
    }
  }
  if (farthest <= 0) return {1, 2};
  farthest *= 1.01;
  return {std::clamp(0.99 * nearest, 1e-3 * farthest, 0.9 * farthest), farthest};
}

// Returns the perspective projection of positions relative to the target.
Matrix4f camera_matrix(const Camera& camera, const ViewFrame& frame, double slope, double aspect,
                       const Depths& depths) {
  Eigen::Matrix4d view = Eigen::Matrix4d::Identity();
  const Vec3 eye = camera.eye - camera.target;
  view.row(0) << frame.right.transpose(), -frame.right.dot(eye);
  view.row(1) << frame.up.transpose(), -frame.up.dot(eye);
  view.row(2) << frame.backward.transpose(), -frame.backward.dot(eye);
  const double depth = depths.farthest - depths.nearest;
  Eigen::Matrix4d projection = Eigen::Matrix4d::Zero();
  projection(0, 0) = 1 / (slope * aspect);
  projection(1, 1) = 1 / slope;
  projection(2, 2) = -(depths.farthest + depths.nearest) / depth;
  projection(2, 3) = -2 * depths.farthest * depths.nearest / depth;
  projection(3, 2) = -1;
  return (projection * view).cast<float>();
}

// Directions spread evenly over the upper hemisphere (a Fibonacci lattice), none along the horizon.
std::array<Vec3, sky_lights> sky_directions(const Vec3& up) {
  const Vec3 across = up.unitOrthogonal();
  const Vec3 along = up.cross(across);
  const double golden_angle = std::numbers::pi * (3 - std::sqrt(5.0));
  std::array<Vec3, sky_lights> directions;
  for (int i = 0; i < sky_lights; ++i) {
    const double height = 1 - 0.9 * (i + 0.5) / sky_lights;
    const double radius = std::sqrt(1 - height * height);
    directions[i] = height * up + radius * (std::cos(golden_angle * i) * across +
                                            std::sin(golden_angle * i) * along);
  }
  return directions;
}

// Returns the offset in bytes of an index in the buffer of indices, in the form OpenGL asks for.
const void* byte_offset(int index) {
  // NOLINTNEXTLINE(performance-no-int-to-ptr): an offset that OpenGL wants as a pointer
  return reinterpret_cast<const void*>(sizeof(std::uint32_t) * index);
}

// A stack of depth images that compares on look-up; outside, nothing is in the shadow.
GLuint shadow_texture(const GlFunctions& gl, int size, int layers) {
  GLuint texture = 0;
  gl.CreateTextures(GL_TEXTURE_2D_ARRAY, 1, &texture);
  gl.TextureStorage3D(texture, 1, GL_DEPTH_COMPONENT32F, size, size, layers);
  gl.TextureParameteri(texture, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  gl.TextureParameteri(texture, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  gl.TextureParameteri(texture, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_BORDER);
  gl.TextureParameteri(texture, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_BORDER);
  constexpr std::array<float, 4> far_away{1, 1, 1, 1};
  gl.TextureParameterfv(texture, GL_TEXTURE_BORDER_COLOR, far_away.data());
  gl.TextureParameteri(texture, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
  gl.TextureParameteri(texture, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
  return texture;
}

}  // namespace

// The objects of OpenGL live as long as the context, which frees them.
struct Renderer::Implementation {
  int width, height;
  GlContext context;
  const GlFunctions& gl = context.functions();
  GLuint depth_program = 0, background_program = 0, surface_program = 0, line_program = 0;
  GLuint vertex_array = 0, vertex_buffer = 0, index_buffer = 0;
  GLuint key_shadow = 0, sky_shadow = 0, shadow_framebuffer = 0;
  GLuint sampled_framebuffer = 0, resolved_framebuffer = 0;
  TriangleBatch batch;

  Implementation(int picture_width, int picture_height);
  void make_framebuffers();
  void make_vertex_array();
  void set_vector(GLuint program, const char* name, const Vec3& value) const;
  void set_matrix(GLuint program, const char* name, const Matrix4f& value) const;
  Matrix4f draw_shadow(GLuint texture, int layer, int size, const ViewFrame& frame,
                       double reach) const;
  void draw_shadows(const Camera& camera, const ViewFrame& view, double reach) const;
  void draw_background(const ViewFrame& view, const Vec3& up, double slope) const;
  void draw_depths(const Matrix4f& matrix) const;
  void draw_lines() const;
  void draw_surfaces(std::span<const DrawnSurface> surfaces) const;
  Picture read_picture() const;
};

Renderer::Implementation::Implementation(int picture_width, int picture_height)
    : width(picture_width), height(picture_height) {
  depth_program = link_stages(gl, shaders::depth_vertex, shaders::depth_fragment);
  background_program = link_stages(gl, shaders::background_vertex, shaders::background_fragment);
  surface_program = link_stages(gl, shaders::surface_vertex, shaders::surface_fragment);
  line_program = link_stages(gl, shaders::line_vertex, shaders::line_fragment);
  make_framebuffers();
  make_vertex_array();
  key_shadow = shadow_texture(gl, key_shadow_size, 1);
  sky_shadow = shadow_texture(gl, sky_shadow_size, sky_lights);
  check_gl(gl, "set up");
}

void Renderer::Implementation::make_framebuffers() {
  gl.CreateFramebuffers(1, &sampled_framebuffer);
  gl.CreateFramebuffers(1, &resolved_framebuffer);
  gl.CreateFramebuffers(1, &shadow_framebuffer);
  gl.NamedFramebufferDrawBuffer(shadow_framebuffer, GL_NONE);
  std::array<GLuint, 3> buffers{};
  gl.CreateRenderbuffers(3, buffers.data());
  gl.NamedRenderbufferStorageMultisample(buffers[0], sample_count, GL_RGBA8, width, height);
  gl.NamedRenderbufferStorageMultisample(buffers[1], sample_count, GL_DEPTH_COMPONENT32F, width,
                                         height);
  gl.NamedRenderbufferStorage(buffers[2], GL_RGBA8, width, height);
  gl.NamedFramebufferRenderbuffer(sampled_framebuffer, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER,
                                  buffers[0]);
  gl.NamedFramebufferRenderbuffer(sampled_framebuffer, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER,
                                  buffers[1]);
  gl.NamedFramebufferRenderbuffer(resolved_framebuffer, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER,
                                  buffers[2]);
  for (const GLuint framebuffer : {sampled_framebuffer, resolved_framebuffer}) {
    if (gl.CheckNamedFramebufferStatus(framebuffer, GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
      throw std::runtime_error("OpenGL cannot draw pictures of " + std::to_string(width) + " x " +
                               std::to_string(height) + " pixels");
    }
  }
}

void Renderer::Implementation::make_vertex_array() {
  gl.CreateVertexArrays(1, &vertex_array);
  gl.CreateBuffers(1, &vertex_buffer);
  gl.CreateBuffers(1, &index_buffer);
  gl.VertexArrayVertexBuffer(vertex_array, 0, vertex_buffer, 0, sizeof(BatchVertex));
  gl.VertexArrayElementBuffer(vertex_array, index_buffer);
  for (const GLuint attribute : {0U, 1U}) {
    gl.EnableVertexArrayAttrib(vertex_array, attribute);
    gl.VertexArrayAttribFormat(vertex_array, attribute, 3, GL_FLOAT, GL_FALSE,
                               attribute * static_cast<GLuint>(offsetof(BatchVertex, normal)));
    gl.VertexArrayAttribBinding(vertex_array, attribute, 0);
  }
}

void Renderer::Implementation::set_vector(GLuint program, const char* name,
                                          const Vec3& value) const {
  const Vector3f single = value.cast<float>();
  gl.Uniform3fv(gl.GetUniformLocation(program, name), 1, single.data());
}

void Renderer::Implementation::set_matrix(GLuint program, const char* name,
                                          const Matrix4f& value) const {
  gl.UniformMatrix4fv(gl.GetUniformLocation(program, name), 1, GL_FALSE, value.data());
}

// Draws the depths of everything, seen from one light, and returns the matrix that looks them up.
Matrix4f Renderer::Implementation::draw_shadow(GLuint texture, int layer, int size,
                                               const ViewFrame& frame, double reach) const {
  const Matrix4f matrix = light_matrix(frame, reach);
  gl.NamedFramebufferTextureLayer(shadow_framebuffer, GL_DEPTH_ATTACHMENT, texture, 0, layer);
  gl.Viewport(0, 0, size, size);
  gl.Clear(GL_DEPTH_BUFFER_BIT);
  set_matrix(depth_program, "to_clip", matrix);
  gl.DrawElements(GL_TRIANGLES, batch.triangle_index_count(), GL_UNSIGNED_INT, nullptr);
  return texture_of_clip() * matrix;
}

// Draws the shadows and hands them, and the lights, to the surface program.
void Renderer::Implementation::draw_shadows(const Camera& camera, const ViewFrame& view,
                                            double reach) const {
  const Vec3 up = camera.up.normalized();
  const Vec3 horizontal = up.cross(view.right);  // away from the viewer, along the ground
  const Vec3 key = (0.80 * up - 0.52 * view.right - 0.40 * horizontal).normalized();
  const std::array<Vec3, sky_lights> sky = sky_directions(up);

  gl.BindFramebuffer(GL_FRAMEBUFFER, shadow_framebuffer);
  gl.UseProgram(depth_program);
  // A surface between a light and its box throws its shadow from the box's side.
  gl.Enable(GL_DEPTH_CLAMP);
  gl.Enable(GL_POLYGON_OFFSET_FILL);
  gl.PolygonOffset(1.5F, 1.0F);
  const Matrix4f key_matrix =
      draw_shadow(key_shadow, 0, key_shadow_size, look_along(key, up), reach);
  std::array<Matrix4f, sky_lights> sky_matrices;
  std::array<Vector3f, sky_lights> sky_singles;
  for (int i = 0; i < sky_lights; ++i) {
    sky_matrices[i] = draw_shadow(sky_shadow, i, sky_shadow_size, look_along(sky[i], up), reach);
    sky_singles[i] = sky[i].cast<float>();
  }
  gl.Disable(GL_POLYGON_OFFSET_FILL);
  gl.Disable(GL_DEPTH_CLAMP);

  gl.UseProgram(surface_program);
  const auto place = [this](const char* name) {
    return gl.GetUniformLocation(surface_program, name);
  };
  set_matrix(surface_program, "key_matrix", key_matrix);
  set_vector(surface_program, "key_direction", key);
  set_vector(surface_program, "up", up);
  gl.UniformMatrix4fv(place("sky_matrix"), sky_lights, GL_FALSE, sky_matrices[0].data());
  gl.Uniform3fv(place("sky_direction"), sky_lights, sky_singles[0].data());
  gl.Uniform1f(place("key_texel"), static_cast<float>(2 * reach / key_shadow_size));
  gl.Uniform1f(place("sky_texel"), static_cast<float>(2 * reach / sky_shadow_size));
}

void Renderer::Implementation::draw_background(const ViewFrame& view, const Vec3& up,
                                               double slope) const {
  gl.UseProgram(background_program);
  set_vector(background_program, "ray_centre", -view.backward);
  set_vector(background_program, "ray_right", slope * width / height * view.right);
  set_vector(background_program, "ray_up", slope * view.up);
  set_vector(background_program, "up", up.normalized());
  gl.Disable(GL_DEPTH_TEST);
  gl.DrawArrays(GL_TRIANGLES, 0, 3);
  gl.Enable(GL_DEPTH_TEST);
}

// Depths are drawn before the colours, so that only what is seen is shaded: light is what costs.
void Renderer::Implementation::draw_depths(const Matrix4f& matrix) const {
  gl.UseProgram(depth_program);
  set_matrix(depth_program, "to_clip", matrix);
  gl.ColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  gl.DrawElements(GL_TRIANGLES, batch.triangle_index_count(), GL_UNSIGNED_INT, nullptr);
  gl.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
}

// Shades what draw_depths has found to be in front.
void Renderer::Implementation::draw_surfaces(std::span<const DrawnSurface> surfaces) const {
  gl.UseProgram(surface_program);
  const GLint front_colour = gl.GetUniformLocation(surface_program, "front_colour");
  const GLint back_colour = gl.GetUniformLocation(surface_program, "back_colour");
  gl.DepthFunc(GL_LEQUAL);
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    const BatchRange& range = batch.range(i);
    gl.Uniform3fv(front_colour, 1, surfaces[i].front_colour.data());
    gl.Uniform3fv(back_colour, 1, surfaces[i].back_colour.data());
    gl.DrawElements(GL_TRIANGLES, range.triangle_indices, GL_UNSIGNED_INT,
                    byte_offset(range.first_triangle_index));
  }
}

// Lines darken what is under them.
void Renderer::Implementation::draw_lines() const {
  if (batch.line_index_count() == 0) return;
  gl.UseProgram(line_program);
  gl.Enable(GL_BLEND);
  gl.BlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  gl.DrawElements(GL_LINES, batch.line_index_count(), GL_UNSIGNED_INT,
                  byte_offset(batch.triangle_index_count()));
  gl.Disable(GL_BLEND);
}

Picture Renderer::Implementation::read_picture() const {
  gl.BlitNamedFramebuffer(sampled_framebuffer, resolved_framebuffer, 0, 0, width, height, 0, 0,
                          width, height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  gl.BindFramebuffer(GL_FRAMEBUFFER, resolved_framebuffer);
  gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
  const std::size_t row_bytes = std::size_t{3} * width;
  std::vector<std::uint8_t> bottom_up(row_bytes * height);
  gl.ReadPixels(0, 0, width, height, GL_RGB, GL_UNSIGNED_BYTE, bottom_up.data());
  check_gl(gl, "draw");
  Picture picture{width, height, std::vector<std::uint8_t>(bottom_up.size())};
  for (int row = 0; row < height; ++row) {
    std::copy_n(bottom_up.begin() + static_cast<std::ptrdiff_t>(row_bytes * row), row_bytes,
                picture.rgb.begin() + static_cast<std::ptrdiff_t>(row_bytes * (height - 1 - row)));
  }
  return picture;
}

Renderer::Renderer(int width, int height) {
  constexpr int largest_size = 8192;
  if (width < 1 || height < 1 || width > largest_size || height > largest_size) {
    throw std::runtime_error("pictures are 1 to 8192 pixels wide and high, not " +
                             std::to_string(width) + " x " + std::to_string(height));
  }
  implementation_ = std::make_unique<Implementation>(width, height);
}

Renderer::~Renderer() = default;

Picture Renderer::draw(std::span<const DrawnSurface> surfaces, const Camera& camera) {
  Implementation& own = *implementation_;
  const GlFunctions& gl = own.gl;
  own.context.make_current();
  const ViewFrame view = look_along(camera.eye - camera.target, camera.up);
  const double slope = std::tan(camera.field_of_view_deg * std::numbers::pi / 360);
  const double aspect = static_cast<double>(own.width) / own.height;
  const double reach = 2 * slope * std::max(1.0, aspect) * (camera.eye - camera.target).norm();

  own.batch.assemble(surfaces, camera.target);
  gl.BindVertexArray(own.vertex_array);
  gl.NamedBufferData(own.vertex_buffer, own.batch.vertex_bytes(), own.batch.vertices().data(),
                     GL_STREAM_DRAW);
  gl.NamedBufferData(own.index_buffer, own.batch.index_bytes(), own.batch.indices().data(),
                     GL_STREAM_DRAW);
  gl.Enable(GL_DEPTH_TEST);
  own.draw_shadows(camera, view, reach);
  const Matrix4f camera_to_clip =
      camera_matrix(camera, view, slope, aspect, depth_range(surfaces, camera, view));
  for (const GLuint program : {own.surface_program, own.line_program}) {
    gl.UseProgram(program);
    own.set_vector(program, "eye", camera.eye - camera.target);
    own.set_matrix(program, "camera_matrix", camera_to_clip);
  }

  gl.Uniform1f(gl.GetUniformLocation(own.line_program, "pull"),
               static_cast<float>(line_pull_in_pixels * 2 * slope / own.height));

  gl.BindFramebuffer(GL_FRAMEBUFFER, own.sampled_framebuffer);
  gl.Viewport(0, 0, own.width, own.height);
  gl.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  own.draw_background(view, camera.up, slope);
  gl.ActiveTexture(GL_TEXTURE0);
  gl.BindTexture(GL_TEXTURE_2D_ARRAY, own.key_shadow);
  gl.ActiveTexture(GL_TEXTURE1);
  gl.BindTexture(GL_TEXTURE_2D_ARRAY, own.sky_shadow);
  own.draw_depths(camera_to_clip);
  own.draw_surfaces(surfaces);
  own.draw_lines();
  return own.read_picture();
}

}  // namespace weft::gpu
