#include <array>
#include <stdexcept>
#include <vector>

#include "gpu/gl_functions.h"
#include "gpu/gl_platform.h"
// osmesa.h must follow glcorearb.h, which gl_functions.h includes. The opposite order fails.
#include <GL/osmesa.h>

#ifdef __SANITIZE_ADDRESS__
// Makes the leak sanitizer ignore about 150 bytes that OSMesa 22.3 leaks per destroyed context.
extern "C" const char* __lsan_default_suppressions();  // NOLINT(bugprone-reserved-identifier)
extern "C" const char* __lsan_default_suppressions() { return "leak:libOSMesa"; }
#endif

namespace weft::gpu {
namespace {

// The functions of the library OSMesa, which is loaded at run time. Linking to it would pull in
// LLVM, delay the start of every `weft` command by 15 ms and fail where OSMesa is not installed.
struct OsMesa {
  decltype(&OSMesaCreateContextAttribs) create_context = nullptr;
  decltype(&OSMesaDestroyContext) destroy_context = nullptr;
  decltype(&OSMesaMakeCurrent) make_current = nullptr;
  decltype(&OSMesaGetCurrentContext) current_context = nullptr;
  decltype(&OSMesaGetProcAddress) function_address = nullptr;

  OsMesa() {
    const LoadedLibrary library("OSMesa", {"libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"},
                                "libosmesa6");
    library.resolve("OSMesaCreateContextAttribs", create_context);
    library.resolve("OSMesaDestroyContext", destroy_context);
    library.resolve("OSMesaMakeCurrent", make_current);
    library.resolve("OSMesaGetCurrentContext", current_context);
    library.resolve("OSMesaGetProcAddress", function_address);
  }
};

// Loads the library on first use; after a failure the next call tries again.
const OsMesa& osmesa() {
  static const OsMesa loaded;
  return loaded;
}

class OsMesaPlatform : public GlPlatform {
 public:
  OsMesaPlatform() {
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
    context_ = osmesa().create_context(attributes.data(), nullptr);
    if (context_ == nullptr) {
      throw std::runtime_error("no OpenGL: OSMesa has no OpenGL 4.5 core profile");
    }
  }
  ~OsMesaPlatform() override {
    if (osmesa().current_context() == context_) osmesa().make_current(nullptr, nullptr, 0, 0, 0);
    osmesa().destroy_context(context_);
  }

  void make_current() override {
    if (osmesa().current_context() == context_) return;
    if (osmesa().make_current(context_, buffer_.data(), GL_UNSIGNED_BYTE, buffer_size,
                              buffer_size) == GL_FALSE) {
      throw std::runtime_error("OSMesa cannot make its context current");
    }
  }
  void* function_address(const char* name) const override {
    return reinterpret_cast<void*>(osmesa().function_address(name));
  }

 private:
  // OSMesa requires a buffer to draw into. Nothing draws into it: contexts only run compute
  // shaders.
  static constexpr int buffer_size = 16;
  std::vector<unsigned char> buffer_ =
      std::vector<unsigned char>(std::size_t{4} * buffer_size * buffer_size);
  OSMesaContext context_ = nullptr;
};

}  // namespace

std::unique_ptr<GlPlatform> make_osmesa_platform() { return std::make_unique<OsMesaPlatform>(); }

}  // namespace weft::gpu
