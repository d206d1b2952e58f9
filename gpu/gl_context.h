// An OpenGL 4.5 core context without a window: on a graphics processor (EGL) or emulated by the CPU
// (OSMesa; EGL if OSMesa is missing, as from Mesa 25.1 on).
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

// Returns OSMesa, or EGL software if OSMesa is missing or the process already uses EGL.
GlBackend software_backend();

// Returns true if the machine shows a device that may be a graphics processor (in /dev). Loads
// nothing.
bool may_have_graphics_processor();

// An OpenGL context. Its libraries are loaded when the first context is made, so a run that needs
// none neither pays for them nor fails if they are missing. EGL and OSMesa in one process abort at
// exit (Mesa 22.3): the process keeps the one it loads first, and asking for the other throws.
class GlContext {
 public:
  // Leaves the context current on the calling thread. Throws std::runtime_error with the reason if
  // there is no library, no such device, or no OpenGL 4.5 core profile. Costs ~20 ms the first time
  // (EGL ~0.2 s).
  explicit GlContext(GlBackend backend);
  ~GlContext();
  GlContext(const GlContext&) = delete;
  GlContext& operator=(const GlContext&) = delete;

  // Makes the context current on the calling thread. A context may be current on one thread at a
  // time. Throws std::runtime_error.
  void make_current();
  // Valid for as long as the context lives.
  const GlFunctions& functions() const;
  GlBackend backend() const { return backend_; }
  // For logs: device() is the renderer's name from OpenGL; description() adds the version.
  std::string device() const;
  std::string description() const;

 private:
  GlBackend backend_;
  std::unique_ptr<GlFunctions> functions_;
  std::unique_ptr<GlPlatform> platform_;
};

// Returns the number of contexts made so far in this process; 0 proves that nothing asked for
// OpenGL.
int context_count();

}  // namespace weft::gpu
