// An OpenGL 4.5 core context without a window. It runs on a graphics processor (EGL), or the CPU
// emulates it (OSMesa; EGL if OSMesa is missing, as from Mesa 25.1 on).
#pragma once

#include <memory>
#include <string>
#include <string_view>

namespace weft::gpu {

struct GlFunctions;
class GlPlatform;

enum class GlBackend {
  hardware,      // a graphics processor, through EGL
  egl_software,  // Mesa's llvmpipe, through EGL
  osmesa,        // Mesa's llvmpipe, through OSMesa
};

std::string_view name(GlBackend backend);

// Returns osmesa, or egl_software if only EGL is installed or the process already uses EGL.
GlBackend software_backend();

// Returns true if /dev shows a device that may be a graphics processor. Loads no library.
bool may_have_graphics_processor();

// An OpenGL context. Its libraries are loaded by software_backend() or when the first context is
// made, so a run without OpenGL neither pays for them nor fails if they are missing. A process that
// uses both EGL and OSMesa aborts at exit (Mesa 22.3). The process therefore keeps the library that
// it uses first. Making a context of the other library throws std::runtime_error.
class GlContext {
 public:
  // Makes the context current on the calling thread. Throws std::runtime_error with the reason if
  // the library, the device or the OpenGL 4.5 core profile is missing. The first context takes
  // about 20 ms with OSMesa and about 0.2 s with EGL.
  explicit GlContext(GlBackend backend);
  ~GlContext();
  GlContext(const GlContext&) = delete;
  GlContext& operator=(const GlContext&) = delete;

  // Makes the context current on the calling thread. A context may be current on one thread at a
  // time. Throws std::runtime_error.
  void make_current();
  // Returns the OpenGL functions, valid for as long as the context lives.
  const GlFunctions& functions() const;
  GlBackend backend() const { return backend_; }
  // Names for logs: device() is the renderer's name from OpenGL, description() adds the version.
  // Precondition: the context is current.
  std::string device() const;
  std::string description() const;

 private:
  GlBackend backend_;
  std::unique_ptr<GlFunctions> functions_;
  std::unique_ptr<GlPlatform> platform_;
};

// Returns the number of GlContext objects made so far in this process. Failed constructions do not
// count.
int context_count();

}  // namespace weft::gpu
