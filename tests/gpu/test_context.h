// The context of the tests of compute shaders: OSMesa, or the backend named by the environment
// variable WEFT_TEST_GL ("egl_software", "hardware"); one process can use only one of them.
#pragma once

#include <cstdlib>
#include <memory>
#include <stdexcept>
#include <string>

#include "gpu/gl_context.h"

namespace weft::gpu {

struct TestContext {
  std::unique_ptr<GlContext> context;  // null: there is none; `reason` says why
  std::string reason;
};

inline GlBackend test_backend() {
  const char* const chosen = std::getenv("WEFT_TEST_GL");
  const std::string backend = chosen == nullptr ? "osmesa" : chosen;
  if (backend == "egl_software") return GlBackend::egl_software;
  if (backend == "hardware") return GlBackend::hardware;
  return GlBackend::osmesa;
}

inline TestContext& test_context() {
  static TestContext made = [] {
    TestContext result;
    try {
      result.context = std::make_unique<GlContext>(test_backend());
    } catch (const std::runtime_error& error) {
      result.reason = error.what();
    }
    return result;
  }();
  return made;
}

// Requires a context. OSMesa is a dependency of Weft: if it is missing, the test fails instead of
// being skipped.
#define WEFT_NEEDS_CONTEXT()                                                  \
  if (test_context().context == nullptr) {                                    \
    if (test_backend() == GlBackend::osmesa) FAIL() << test_context().reason; \
    GTEST_SKIP() << test_context().reason;                                    \
  }                                                                           \
  GlContext& context = *test_context().context

}  // namespace weft::gpu
