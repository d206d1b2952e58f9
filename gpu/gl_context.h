// An OpenGL 4.5 core context without a window. Today there is one backend, OSMesa, whose rasteriser
// runs on the CPU; contexts of graphics processors (EGL) belong here too.
#pragma once

#include <memory>
#include <string>

namespace weft::gpu {

struct GlFunctions;

// Use one backend a process: OSMesa and EGL together abort at exit (Mesa 22.3). The library is
// loaded when the first context is made, so a run that draws nothing neither needs nor pays for it.
class GlContext {
 public:
  // Leaves the context current on the calling thread. Throws std::runtime_error with the reason
  // when there is no library, or it has no OpenGL 4.5 core profile. ~20 ms the first time.
  GlContext();
  ~GlContext();
  GlContext(const GlContext&) = delete;
  GlContext& operator=(const GlContext&) = delete;

  // On the calling thread. A context may be current on one thread at a time. Throws
  // std::runtime_error.
  void make_current();
  // Valid for as long as the context lives.
  const GlFunctions& functions() const;
  // For logs: the renderer and the version, as OpenGL gives them.
  std::string description() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

// The number of contexts made so far in this process; 0 proves that nothing asked for OpenGL.
int context_count();

}  // namespace weft::gpu
