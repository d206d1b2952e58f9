#include <png.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <stdexcept>

#include "gpu/renderer.h"

namespace weft::gpu {
namespace {

// The error that libpng reports. It is stored, and thrown later: libpng is a C library and reports
// errors by longjmp, past which no exception may be thrown.
struct PngFailure {
  std::string reason;
};

void keep_error(png_structp png, png_const_charp reason) {
  static_cast<PngFailure*>(png_get_error_ptr(png))->reason = reason;
  png_longjmp(png, 1);
}

void ignore_warning(png_structp, png_const_charp) {}

// Key and value of the text chunk by which write_png() signs its files.
constexpr char signature_key[] = "Software";
constexpr char signature[] = "Weft";

void sign(png_structp png, png_infop info) {
  std::array<char, sizeof signature_key> key{};
  std::array<char, sizeof signature> value{};
  std::copy(std::begin(signature_key), std::end(signature_key), key.begin());
  std::copy(std::begin(signature), std::end(signature), value.begin());
  png_text text{};
  text.compression = PNG_TEXT_COMPRESSION_NONE;
  text.key = key.data();
  text.text = value.data();
  text.text_length = sizeof signature - 1;
  png_set_text(png, info, &text, 1);
}

// Writes the file. Returns false on an error. No object here has a destructor, because libpng exits
// by longjmp.
bool write_rows(png_structp png, png_infop info, std::FILE* file, const Picture& picture) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_init_io(png, file);
  // Smooth pictures compress well as runs of equal differences between neighbours. A search for
  // repetitions takes twice the time, and the files are no smaller.
  png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_SUB);
  png_set_compression_strategy(png, Z_RLE);
  png_set_IHDR(png, info, static_cast<png_uint_32>(picture.width),
               static_cast<png_uint_32>(picture.height), 8, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
  sign(png, info);
  png_write_info(png, info);
  for (int row = 0; row < picture.height; ++row) {
    png_write_row(png, picture.rgb.data() + std::size_t{3} * picture.width * row);
  }
  png_write_end(png, info);
  return true;
}

// Writes the picture to the file at `path`. Returns the reason of a failure, or an empty text.
std::string write_file(const std::string& path, const Picture& picture) {
  std::FILE* const file = std::fopen(path.c_str(), "wb");
  if (file == nullptr) return std::strerror(errno);
  PngFailure failure;
  png_structp png =
      png_create_write_struct(PNG_LIBPNG_VER_STRING, &failure, keep_error, ignore_warning);
  png_infop info = png == nullptr ? nullptr : png_create_info_struct(png);
  const bool written = info != nullptr && write_rows(png, info, file, picture);
  png_destroy_write_struct(&png, &info);
  // A full disk often shows only when the last buffer is flushed.
  const bool closed = std::fclose(file) == 0;
  const int close_error = errno;
  if (!written) return failure.reason.empty() ? "libpng has no memory" : failure.reason;
  return closed ? "" : std::strerror(close_error);
}

}  // namespace

void write_png(const std::string& path, const Picture& picture) {
  assert(picture.width > 0 && picture.height > 0);
  assert(picture.rgb.size() == std::size_t{3} * picture.width * picture.height);
  std::error_code unknown;
  const auto status = std::filesystem::status(path, unknown);
  const bool is_device = std::filesystem::exists(status) && !is_regular_file(status);
  // A file cut off by an error or a kill could lack the signature, without which no later drawing
  // replaces it. Devices have no other name.
  const std::string unfinished = is_device ? path : path + "." + std::to_string(getpid()) + ".tmp";
  std::string error = write_file(unfinished, picture);
  if (!is_device && error.empty() && std::rename(unfinished.c_str(), path.c_str()) != 0)
    error = std::strerror(errno);
  if (error.empty()) return;
  if (!is_device) std::remove(unfinished.c_str());
  throw std::runtime_error("cannot write the picture '" + path + "': " + error);
}

bool is_own_png(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return false;
  std::ifstream file(path, std::ios::binary);
  const std::string chunk = std::string(signature_key) + '\0' + signature;
  std::string start(8, '\0');
  if (!file.read(start.data(), 8) || start != "\x89PNG\r\n\x1a\n") return false;
  // A chunk consists of length, type, data and checksum.
  for (std::array<unsigned char, 8> head{}; file.read(reinterpret_cast<char*>(head.data()), 8);) {
    const std::uint32_t length = std::uint32_t{head[0]} << 24 | std::uint32_t{head[1]} << 16 |
                                 std::uint32_t{head[2]} << 8 | std::uint32_t{head[3]};
    const std::string type(head.begin() + 4, head.end());
    if (type == "IDAT" || type == "IEND") return false;
    if (type == "tEXt" && length == chunk.size()) {
      std::string data(length, '\0');
      if (file.read(data.data(), length) && data == chunk) return true;
      file.seekg(4, std::ios::cur);
    } else {
      file.seekg(std::streamoff{length} + 4, std::ios::cur);
    }
  }
  return false;
}

}  // namespace weft::gpu
