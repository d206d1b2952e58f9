#include <algorithm>
#include <array>
#include <cstdint>
#include <stdexcept>
#include <vector>

#include "gpu/gl_functions.h"
#include "gpu/gl_platform.h"

namespace weft::gpu {
namespace {

// The types and constants of EGL 1.5 that this file uses, copied from the Khronos registry
// (egl.xml). The copy makes EGL's headers unnecessary.
namespace egl {
using Boolean = unsigned;
using Enum = unsigned;
using Integer = std::int32_t;
using Handle = void*;  // any EGL object: display, context, device, surface or configuration

constexpr Integer context_major_version = 0x3098;
constexpr Integer context_minor_version = 0x30FB;
constexpr Integer context_profile_mask = 0x30FD;
constexpr Integer context_core_profile = 0x1;
constexpr Integer none = 0x3038;
constexpr Enum opengl_api = 0x30A2;
constexpr Enum platform_device = 0x313F;
constexpr Enum platform_surfaceless = 0x31DD;
}  // namespace egl

struct Egl {
  void* (*function_address)(const char*) = nullptr;
  egl::Boolean (*initialize)(egl::Handle, egl::Integer*, egl::Integer*) = nullptr;
  egl::Boolean (*bind_api)(egl::Enum) = nullptr;
  egl::Handle (*create_context)(egl::Handle, egl::Handle, egl::Handle,
                                const egl::Integer*) = nullptr;
  egl::Boolean (*destroy_context)(egl::Handle, egl::Handle) = nullptr;
  egl::Boolean (*make_current)(egl::Handle, egl::Handle, egl::Handle, egl::Handle) = nullptr;
  egl::Handle (*current_context)() = nullptr;
  // Functions of EGL extensions. `query_devices` is null if its extension is missing.
  egl::Handle (*platform_display)(egl::Enum, void*, const egl::Integer*) = nullptr;
  egl::Boolean (*query_devices)(egl::Integer, egl::Handle*, egl::Integer*) = nullptr;

  Egl() {
    const LoadedLibrary library("EGL", {"libEGL.so.1", "libEGL.so"}, "libegl1");
    library.resolve("eglGetProcAddress", function_address);
    library.resolve("eglInitialize", initialize);
    library.resolve("eglBindAPI", bind_api);
    library.resolve("eglCreateContext", create_context);
    library.resolve("eglDestroyContext", destroy_context);
    library.resolve("eglMakeCurrent", make_current);
    library.resolve("eglGetCurrentContext", current_context);
    platform_display =
        reinterpret_cast<decltype(platform_display)>(function_address("eglGetPlatformDisplayEXT"));
    query_devices =
        reinterpret_cast<decltype(query_devices)>(function_address("eglQueryDevicesEXT"));
    if (platform_display == nullptr) {
      throw std::runtime_error("no OpenGL: this EGL knows no displays without a window system");
    }
  }

  // Opens a display on each device (32 at most), then one on Mesa's surfaceless platform. Displays
  // that cannot be opened are skipped.
  std::vector<egl::Handle> open_displays() const {
    std::vector<egl::Handle> opened;
    const auto open = [&](egl::Enum platform, egl::Handle device) {
      const egl::Handle display = platform_display(platform, device, nullptr);
      if (display != nullptr && initialize(display, nullptr, nullptr) != 0) {
        opened.push_back(display);
      }
    };
    std::array<egl::Handle, 32> devices{};
    egl::Integer count = 0;
    if (query_devices != nullptr) {
      query_devices(static_cast<egl::Integer>(devices.size()), devices.data(), &count);
    }
    for (egl::Integer i = 0; i < count; ++i) open(egl::platform_device, devices[i]);
    open(egl::platform_surfaceless, nullptr);
    return opened;
  }
};

// Loads the library on first use; after a failure the next call tries again.
const Egl& library() {
  static const Egl loaded;
  return loaded;
}

// Returns the open displays, which the first call opens. Displays belong to the process and outlive
// their contexts.
const std::vector<egl::Handle>& displays() {
  static const std::vector<egl::Handle> opened = library().open_displays();
  return opened;
}

class EglPlatform : public GlPlatform {
 public:
  explicit EglPlatform(egl::Handle display) : display_(display) {
    constexpr std::array<egl::Integer, 7> attributes{egl::context_major_version,
                                                     4,
                                                     egl::context_minor_version,
                                                     5,
                                                     egl::context_profile_mask,
                                                     egl::context_core_profile,
                                                     egl::none};
    library().bind_api(egl::opengl_api);
    context_ = library().create_context(display_, nullptr, nullptr, attributes.data());
  }
  ~EglPlatform() override {
    if (context_ == nullptr) return;
    if (library().current_context() == context_) {
      library().make_current(display_, nullptr, nullptr, nullptr);
    }
    library().destroy_context(display_, context_);
  }

  bool is_made() const { return context_ != nullptr; }
  void make_current() override {
    library().bind_api(egl::opengl_api);  // binds OpenGL for the calling thread only
    if (library().current_context() == context_) return;
    if (library().make_current(display_, nullptr, nullptr, context_) == 0) {
      throw std::runtime_error("EGL cannot make its context current without a surface");
    }
  }
  void* function_address(const char* name) const override {
    return library().function_address(name);
  }
  // Returns the renderer's name from OpenGL. Precondition: the context is current.
  std::string renderer() const {
    const auto get_string = reinterpret_cast<PFNGLGETSTRINGPROC>(function_address("glGetString"));
    return reinterpret_cast<const char*>(get_string(GL_RENDERER));
  }

 private:
  egl::Handle display_;
  egl::Handle context_ = nullptr;
};

bool is_software(const std::string& renderer) {
  return std::ranges::any_of(
      std::array{"llvmpipe", "softpipe", "swrast", "SWR", "Software Rasterizer"},
      [&](const char* known) { return renderer.find(known) != std::string::npos; });
}

}  // namespace

std::unique_ptr<GlPlatform> make_egl_platform(bool hardware) {
  std::string seen;
  for (const egl::Handle display : displays()) {
    auto platform = std::make_unique<EglPlatform>(display);
    if (!platform->is_made()) continue;
    platform->make_current();
    const std::string renderer = platform->renderer();
    if (is_software(renderer) != hardware) return platform;
    if (seen.find(renderer) == std::string::npos) seen += (seen.empty() ? "" : "; ") + renderer;
  }
  throw std::runtime_error(
      std::string("no OpenGL 4.5 by EGL on ") + (hardware ? "a graphics processor" : "the CPU") +
      (seen.empty() ? ": EGL has no device with it" : ": EGL has only " + seen));
}

}  // namespace weft::gpu
