// Makers of OpenGL contexts: one implementation per library, each loaded at run time. Private to
// gpu/.
#pragma once

#include <memory>
#include <string>
#include <type_traits>

namespace weft::gpu {

// One context. The destructor releases it from the calling thread if it is current there.
class GlPlatform {
 public:
  virtual ~GlPlatform() = default;
  GlPlatform() = default;
  GlPlatform(const GlPlatform&) = delete;
  GlPlatform& operator=(const GlPlatform&) = delete;
  // Makes the context current on the calling thread. Throws std::runtime_error on failure.
  virtual void make_current() = 0;
  // Returns the address of an OpenGL function; null if there is none.
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
  // Loads the first of the names that exists, or throws std::runtime_error. `subject` and `package`
  // appear in the message.
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
