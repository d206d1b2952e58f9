#include "gpu/gl_context.h"

#include <dlfcn.h>

#include <atomic>
#include <filesystem>
#include <mutex>
#include <optional>
#include <stdexcept>

#include "gpu/gl_functions.h"
#include "gpu/gl_platform.h"

namespace weft::gpu {
namespace {

std::atomic<int> contexts_made{0};

// The backend that this process used last, if any. If the first use is a search by EGL that fails,
// it counts as a use of egl_software. The process may only use backends of the same library (EGL or
// OSMesa).
std::mutex process_mutex;
std::optional<GlBackend> process_backend;

std::unique_ptr<GlPlatform> make_platform(GlBackend backend) {
  const std::scoped_lock lock(process_mutex);
  const bool wants_osmesa = backend == GlBackend::osmesa;
  if (process_backend && (*process_backend == GlBackend::osmesa) != wants_osmesa) {
    throw std::runtime_error("no OpenGL by " + std::string(name(backend)) + ": this process uses " +
                             std::string(name(*process_backend)) +
                             " already, and Mesa allows only one of them");
  }
  if (wants_osmesa) {
    auto platform = make_osmesa_platform();
    process_backend = backend;
    return platform;
  }
  // A search by EGL loads its drivers, even if it finds no device.
  if (!process_backend) process_backend = GlBackend::egl_software;
  auto platform = make_egl_platform(backend == GlBackend::hardware);
  process_backend = backend;
  return platform;
}

}  // namespace

LoadedLibrary::LoadedLibrary(std::string subject, std::initializer_list<const char*> names,
                             const char* package)
    : subject_(std::move(subject)) {
  std::string reasons;
  for (const char* name : names) {
    handle_ = dlopen(name, RTLD_LAZY | RTLD_LOCAL);
    if (handle_ != nullptr) return;
    reasons += std::string(reasons.empty() ? "" : "; ") + dlerror();
  }
  throw std::runtime_error("no OpenGL: " + subject_ + " cannot be loaded (Debian: " + package +
                           "): " + reasons);
}

void* LoadedLibrary::symbol(const char* function_name) const {
  void* const address = dlsym(handle_, function_name);
  if (address != nullptr) return address;
  throw std::runtime_error("no OpenGL: this " + subject_ + " has no " + function_name);
}

std::string_view name(GlBackend backend) {
  switch (backend) {
    case GlBackend::hardware:
      return "EGL hardware";
    case GlBackend::egl_software:
      return "EGL software";
    case GlBackend::osmesa:
      return "OSMesa";
  }
  return "";
}

GlBackend software_backend() {
  {
    const std::scoped_lock lock(process_mutex);
    if (process_backend) {
      return *process_backend == GlBackend::osmesa ? GlBackend::osmesa : GlBackend::egl_software;
    }
  }
  // The process may load both libraries, as long as it makes contexts of only one.
  for (const char* library : {"libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"}) {
    if (dlopen(library, RTLD_LAZY | RTLD_LOCAL) != nullptr) return GlBackend::osmesa;
  }
  return dlopen("libEGL.so.1", RTLD_LAZY | RTLD_LOCAL) != nullptr ? GlBackend::egl_software
                                                                  : GlBackend::osmesa;
}

bool may_have_graphics_processor() {
  std::error_code error;
  for (const char* device : {"/dev/nvidiactl", "/dev/dxg"}) {
    if (std::filesystem::exists(device, error)) return true;
  }
  for (const auto& entry : std::filesystem::directory_iterator("/dev/dri", error)) {
    if (entry.path().filename().string().starts_with("renderD")) return true;
  }
  return false;
}

GlContext::GlContext(GlBackend backend)
    : backend_(backend),
      functions_(std::make_unique<GlFunctions>()),
      platform_(make_platform(backend)) {
  make_current();
  // A test for null cannot find a missing function in Mesa, which returns an address for any name.
  // That is harmless: every OpenGL 4.5 core context has all of these functions.
#define WEFT_GL_RESOLVE(type, function)                                                       \
  functions_->function = reinterpret_cast<type>(platform_->function_address("gl" #function)); \
  if (functions_->function == nullptr) throw std::runtime_error("OpenGL has no gl" #function);
  WEFT_GL_FUNCTIONS(WEFT_GL_RESOLVE)
#undef WEFT_GL_RESOLVE
  ++contexts_made;
}

GlContext::~GlContext() = default;

void GlContext::make_current() { platform_->make_current(); }

const GlFunctions& GlContext::functions() const { return *functions_; }

std::string GlContext::device() const {
  return reinterpret_cast<const char*>(functions_->GetString(GL_RENDERER));
}

std::string GlContext::description() const {
  return device() + ", OpenGL " + reinterpret_cast<const char*>(functions_->GetString(GL_VERSION));
}

int context_count() { return contexts_made; }

}  // namespace weft::gpu
