#include "gpu/gl_context.h"

#include <dlfcn.h>

#include <array>
#include <atomic>
#include <stdexcept>
#include <vector>

#include "gpu/gl_functions.h"
// After glcorearb.h, which both headers can share a file with in this order.
#include <GL/osmesa.h>

#ifdef __SANITIZE_ADDRESS__
// OSMesa 22.3 keeps about 150 bytes of each context it destroys. Read by the leak sanitizer.
extern "C" const char* __lsan_default_suppressions();  // NOLINT(bugprone-reserved-identifier)
extern "C" const char* __lsan_default_suppressions() { return "leak:libOSMesa"; }
#endif

namespace weft::gpu {
namespace {

std::atomic<int> contexts_made{0};

// The few functions of OSMesa itself, from the shared library.
struct OsMesa {
  decltype(&OSMesaCreateContextAttribs) create_context = nullptr;
  decltype(&OSMesaDestroyContext) destroy_context = nullptr;
  decltype(&OSMesaMakeCurrent) make_current = nullptr;
  decltype(&OSMesaGetCurrentContext) current_context = nullptr;
  decltype(&OSMesaGetProcAddress) function_address = nullptr;
};

// Loaded, not linked: linking would make every `weft` command start 15 ms later (it pulls in LLVM)
// and fail where OSMesa is not installed.
OsMesa load_osmesa() {
  void* library = nullptr;
  std::string reasons;
  for (const char* name : {"libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"}) {
    library = dlopen(name, RTLD_LAZY | RTLD_LOCAL);
    if (library != nullptr) break;
    reasons += std::string(reasons.empty() ? "" : "; ") + dlerror();
  }
  if (library == nullptr) {
    throw std::runtime_error("no OpenGL: OSMesa cannot be loaded (Debian: libosmesa6): " + reasons);
  }
  const auto resolve = [library](const char* name, auto& function) {
    void* const address = dlsym(library, name);
    if (address == nullptr) {
      throw std::runtime_error(std::string("no OpenGL: this OSMesa has no ") + name);
    }
    function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(address);
  };
  OsMesa osmesa;
  resolve("OSMesaCreateContextAttribs", osmesa.create_context);
  resolve("OSMesaDestroyContext", osmesa.destroy_context);
  resolve("OSMesaMakeCurrent", osmesa.make_current);
  resolve("OSMesaGetCurrentContext", osmesa.current_context);
  resolve("OSMesaGetProcAddress", osmesa.function_address);
  return osmesa;
}

// Never unloaded: threads of the rasteriser outlive the contexts. A failure is tried anew.
const OsMesa& osmesa() {
  static const OsMesa loaded = load_osmesa();
  return loaded;
}

OSMesaContext create_osmesa_context() {
  constexpr std::array<int, 15> attributes{OSMESA_FORMAT,
                                           OSMESA_RGBA,
                                           OSMESA_DEPTH_BITS,
                                           0,
                                           OSMESA_STENCIL_BITS,
                                           0,
                                           OSMESA_ACCUM_BITS,
                                           0,
                                           OSMESA_PROFILE,
                                           OSMESA_CORE_PROFILE,
                                           OSMESA_CONTEXT_MAJOR_VERSION,
                                           4,
                                           OSMESA_CONTEXT_MINOR_VERSION,
                                           5,
                                           0};
  const OSMesaContext context = osmesa().create_context(attributes.data(), nullptr);
  if (context == nullptr) {
    throw std::runtime_error("no OpenGL: OSMesa has no OpenGL 4.5 core profile");
  }
  return context;
}

}  // namespace

struct GlContext::Implementation {
  // OSMesa insists on a buffer to draw into; ours is never looked at (all drawing is to framebuffer
  // objects).
  static constexpr int buffer_size = 16;
  std::vector<unsigned char> buffer =
      std::vector<unsigned char>(std::size_t{4} * buffer_size * buffer_size);
  OSMesaContext context = create_osmesa_context();
  GlFunctions functions;

  ~Implementation() {
    if (osmesa().current_context() == context) {
      osmesa().make_current(nullptr, nullptr, 0, 0, 0);
    }
    osmesa().destroy_context(context);
  }
};

GlContext::GlContext() : implementation_(std::make_unique<Implementation>()) {
  make_current();
  GlFunctions& gl = implementation_->functions;
  // A null test is not enough (Mesa hands out addresses for unknown names too), but the profile
  // asked for has them all.
#define WEFT_GL_RESOLVE(type, name)                                        \
  gl.name = reinterpret_cast<type>(osmesa().function_address("gl" #name)); \
  if (gl.name == nullptr) throw std::runtime_error("OpenGL has no gl" #name);
  WEFT_GL_FUNCTIONS(WEFT_GL_RESOLVE)
#undef WEFT_GL_RESOLVE
  ++contexts_made;
}

GlContext::~GlContext() = default;

void GlContext::make_current() {
  Implementation& own = *implementation_;
  if (osmesa().current_context() == own.context) return;
  if (osmesa().make_current(own.context, own.buffer.data(), GL_UNSIGNED_BYTE, own.buffer_size,
                            own.buffer_size) == GL_FALSE) {
    throw std::runtime_error("OSMesa cannot make its context current");
  }
}

const GlFunctions& GlContext::functions() const { return implementation_->functions; }

std::string GlContext::description() const {
  const GlFunctions& gl = functions();
  const auto text = [&gl](GLenum name) {
    return std::string(reinterpret_cast<const char*>(gl.GetString(name)));
  };
  return text(GL_RENDERER) + ", OpenGL " + text(GL_VERSION);
}

int context_count() { return contexts_made; }

}  // namespace weft::gpu
