#include "gpu/gl_context.h"

#include <gtest/gtest.h>

#include <regex>
#include <stdexcept>

#include "tests/gpu/test_context.h"

namespace weft::gpu::gl_context_test {
namespace {

TEST(GlContext, SaysWhatItIs) {
  WEFT_NEEDS_CONTEXT();
  EXPECT_EQ(context.backend(), test_backend());
  EXPECT_EQ(context.description().find(context.device()), 0U);
  EXPECT_EQ(context.device().find("llvmpipe") != std::string::npos,
            test_backend() != GlBackend::hardware);
}

TEST(GlContext, OneLibraryAProcess) {
  WEFT_NEEDS_CONTEXT();
  const bool osmesa = context.backend() == GlBackend::osmesa;
  try {
    const GlContext other(osmesa ? GlBackend::egl_software : GlBackend::osmesa);
    FAIL() << "both in one process";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("this process uses"), std::string::npos)
        << error.what();
  }
  EXPECT_EQ(software_backend() == GlBackend::osmesa, osmesa);
}

// Drivers may give a later version than 4.5.
TEST(GlContext, IsOpenGl45) {
  WEFT_NEEDS_CONTEXT();
  EXPECT_TRUE(std::regex_search(context.description(), std::regex(R"(\b4\.[5-9])")))
      << context.description();
}

// Uses EGL with any devices: without a graphics processor they are all software.
TEST(GlContext, HardwareIsRefusedWhereThereIsNone) {
  if (test_backend() == GlBackend::osmesa) GTEST_SKIP() << "needs EGL";
  WEFT_NEEDS_CONTEXT();
  if (may_have_graphics_processor()) GTEST_SKIP() << "there may be a graphics processor";
  EXPECT_EQ(context.backend(), GlBackend::egl_software);
  try {
    const GlContext none(GlBackend::hardware);
    FAIL() << none.description();
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("graphics processor: EGL has only llvmpipe"),
              std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace weft::gpu::gl_context_test
