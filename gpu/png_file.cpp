#include <png.h>

#include <cassert>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <stdexcept>

#include "gpu/renderer.h"

namespace weft::gpu {
namespace {

// What libpng reports, kept until it is safe to throw: libpng is C and leaves by longjmp.
struct PngFailure {
  std::string reason;
};

void keep_error(png_structp png, png_const_charp reason) {
  static_cast<PngFailure*>(png_get_error_ptr(png))->reason = reason;
  png_longjmp(png, 1);
}

void ignore_warning(png_structp, png_const_charp) {}

// False on an error. Nothing with a destructor lives in here, because of the longjmp.
bool write_rows(png_structp png, png_infop info, std::FILE* file, const Picture& picture) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_init_io(png, file);
  // Three times as fast as the default level, for files a tenth larger.
  png_set_compression_level(png, 3);
  png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_SUB | PNG_FILTER_UP);
  png_set_IHDR(png, info, static_cast<png_uint_32>(picture.width),
               static_cast<png_uint_32>(picture.height), 8, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
  png_write_info(png, info);
  for (int row = 0; row < picture.height; ++row) {
    png_write_row(png, picture.rgb.data() + std::size_t{3} * picture.width * row);
  }
  png_write_end(png, info);
  return true;
}

}  // namespace

void write_png(const std::string& path, const Picture& picture) {
  assert(picture.width > 0 && picture.height > 0);
  assert(picture.rgb.size() == std::size_t{3} * picture.width * picture.height);
  const auto fail = [&path](const std::string& reason) {
    throw std::runtime_error("cannot write the picture '" + path + "': " + reason);
  };
  std::FILE* const file = std::fopen(path.c_str(), "wb");
  if (file == nullptr) fail(std::strerror(errno));
  PngFailure failure;
  png_structp png =
      png_create_write_struct(PNG_LIBPNG_VER_STRING, &failure, keep_error, ignore_warning);
  png_infop info = png == nullptr ? nullptr : png_create_info_struct(png);
  const bool written = info != nullptr && write_rows(png, info, file, picture);
  png_destroy_write_struct(&png, &info);
  // A full disk often shows only when the last buffer is flushed.
  const bool closed = std::fclose(file) == 0;
  const int close_error = errno;
  if (!written) fail(failure.reason.empty() ? "libpng has no memory" : failure.reason);
  if (!closed) fail(std::strerror(close_error));
}

}  // namespace weft::gpu
