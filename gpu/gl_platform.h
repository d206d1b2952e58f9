// Makers of OpenGL contexts: one implementation per library, each loaded at run time. Private to
// gl_context.cpp.
#pragma once

#include <memory>
#include <string>
#include <type_traits>

namespace weft::gpu {

// One context. If it is current on the calling thread, the destructor makes it not current.
class GlPlatform {
 public:
  virtual ~GlPlatform() = default;
  GlPlatform() = default;
  GlPlatform(const GlPlatform&) = delete;
  GlPlatform& operator=(const GlPlatform&) = delete;
  // Throws std::runtime_error.
  virtual void make_current() = 0;
  // Returns the address of an OpenGL function; null if there is none.
  virtual void* function_address(const char* name) const = 0;
};

// Throw std::runtime_error with the reason if there is no library, no OpenGL 4.5 core profile or,
// for EGL, no device of the requested kind.
std::unique_ptr<GlPlatform> make_osmesa_platform();
std::unique_ptr<GlPlatform> make_egl_platform(bool hardware);

// A library loaded at run time. It is never unloaded: threads of the rasterisers outlive the
// contexts.
class LoadedLibrary {
 public:
  // Loads the first of the names that exists. `subject` and `package` are for the message of the
  // std::runtime_error.
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
