// OpenGL contexts by EGL or by OSMesa. Both libraries are loaded at run time. Private to gpu/.
#pragma once

#include <memory>
#include <string>
#include <type_traits>

namespace weft::gpu {

// An OpenGL context. The destructor releases it from the calling thread if it is current there.
class GlPlatform {
 public:
  virtual ~GlPlatform() = default;
  GlPlatform() = default;
  GlPlatform(const GlPlatform&) = delete;
  GlPlatform& operator=(const GlPlatform&) = delete;
  // Makes the context current on the calling thread. Throws std::runtime_error on failure.
  virtual void make_current() = 0;
  // Returns the address of an OpenGL function. The result for an unknown name is null or, with
  // Mesa, an address that must not be called.
  virtual void* function_address(const char* name) const = 0;
};

// Make a context. Throw std::runtime_error with the reason if the library, the OpenGL 4.5 core
// profile or, for EGL, a device of the requested kind is missing.
std::unique_ptr<GlPlatform> make_osmesa_platform();
std::unique_ptr<GlPlatform> make_egl_platform(bool hardware);

// A library loaded at run time. It is never unloaded, because threads of the rasterisers outlive
// the contexts.
class LoadedLibrary {
 public:
  // Loads the first library in `names` that can be loaded. If no library can be loaded, throws
  // std::runtime_error with `subject` and `package` in its message.
  LoadedLibrary(std::string subject, std::initializer_list<const char*> names, const char* package);

  template <typename Function>
  void resolve(const char* function_name, Function& function) const {
    function = reinterpret_cast<Function>(symbol(function_name));
  }

 private:
  void* symbol(const char* function_name) const;

  std::string subject_;
  void* handle_ = nullptr;
};

}  // namespace weft::gpu
