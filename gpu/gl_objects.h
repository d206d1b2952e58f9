// Programs and buffers of OpenGL, and its errors as exceptions. Every object must be constructed,
// used and destroyed while one and the same context is current.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "gpu/gl_functions.h"

namespace weft::gpu {

// Compiles and links a program. Throws std::runtime_error with the compiler's or linker's log.
GLuint link_program(const GlFunctions& gl,
                    std::span<const std::pair<GLenum, std::string>> stages_and_sources);

// Throws std::runtime_error if OpenGL has recorded an error that was not yet reported. The message
// names `task` and the error.
void check_gl(const GlFunctions& gl, const char* task);

// Returns the largest size, in bytes, of a buffer that a shader can access.
std::size_t buffer_limit(const GlFunctions& gl);

// Returns the number of items for which a list should have memory that has it for `capacity` and
// needs it for `needed` items of `item` bytes. A list that outgrows its memory tends to grow again.
// It therefore gets one and a half times the needed size, or as much of this as the device allows.
std::size_t grown_capacity(const GlFunctions& gl, std::size_t capacity, std::size_t needed,
                           std::size_t item);

// A shader storage buffer.
class GlBuffer {
 public:
  explicit GlBuffer(const GlFunctions& gl) : gl_(&gl) { gl.CreateBuffers(1, &name_); }
  ~GlBuffer() { gl_->DeleteBuffers(1, &name_); }
  GlBuffer(const GlBuffer&) = delete;
  GlBuffer& operator=(const GlBuffer&) = delete;

  // Enlarges the buffer to `bytes`, at least 16, unless it is already that large. Its contents are
  // lost when it grows. Throws std::runtime_error, which names `content`, if the device does not
  // allow this size or has no memory for it.
  void reserve(std::size_t bytes, const char* content);
  std::size_t bytes() const { return bytes_; }
  void bind(GLuint binding) const { gl_->BindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, name_); }
  GLuint name() const { return name_; }

  // Waits for the device before and after. Without that, NVIDIA's driver (580) runs shaders on data
  // from before the write.
  template <typename Item>
  void write(std::span<const Item> items, std::size_t first_byte = 0) const {
    if (items.empty()) return;
    gl_->Finish();
    gl_->NamedBufferSubData(name_, static_cast<GLintptr>(first_byte),
                            static_cast<GLsizeiptr>(items.size_bytes()), items.data());
    gl_->Finish();
  }
  // Copies items from the buffer; waits for pending writes. Precondition: if a shader has written
  // to the buffer, MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT) has been called since.
  template <typename Item>
  void read(std::span<Item> items, std::size_t first_byte = 0) const {
    if (items.empty()) return;
    gl_->GetNamedBufferSubData(name_, static_cast<GLintptr>(first_byte),
                               static_cast<GLsizeiptr>(items.size_bytes()), items.data());
  }

 private:
  const GlFunctions* gl_;
  GLuint name_ = 0;
  std::size_t bytes_ = 0;
};

// Memory of the host into which a device copies its buffers. Copies of much data take a fraction of
// the time of GlBuffer::read(), because the device writes into this memory itself.
class GlReadback {
 public:
  explicit GlReadback(const GlFunctions& gl) : gl_(&gl) {}
  ~GlReadback() { gl_->DeleteBuffers(1, &name_); }
  GlReadback(const GlReadback&) = delete;
  GlReadback& operator=(const GlReadback&) = delete;

  // Begins to copy the first `count` items of a buffer. They may be read after GlFunctions::Finish
  // and until the next copy. Throws std::runtime_error, which names `content`, without memory.
  // Precondition: as for GlBuffer::read().
  template <typename Item>
  std::span<const Item> copy(const GlBuffer& from, std::size_t count, const char* content) {
    return {static_cast<const Item*>(copy_bytes(from, count * sizeof(Item), content)), count};
  }

 private:
  const void* copy_bytes(const GlBuffer& from, std::size_t bytes, const char* content);

  const GlFunctions* gl_;
  GLuint name_ = 0;
  std::size_t bytes_ = 0;
  const void* memory_ = nullptr;
};

// A compute shader, compiled on first use (which takes up to seconds on llvmpipe).
class ComputeProgram {
 public:
  ComputeProgram(const GlFunctions& gl, std::string source)
      : gl_(&gl), source_(std::move(source)) {}
  ~ComputeProgram() {
    if (program_ != 0) gl_->DeleteProgram(program_);
  }
  ComputeProgram(const ComputeProgram&) = delete;
  ComputeProgram& operator=(const ComputeProgram&) = delete;

  // Compiles the shader if needed and uses it. Throws std::runtime_error with the compiler's or
  // linker's log.
  void use();
  // Sets a uniform. Precondition: the program is in use.
  void set(const char* uniform, GLuint value) const {
    gl_->Uniform1ui(gl_->GetUniformLocation(program_, uniform), value);
  }

 private:
  const GlFunctions* gl_;
  std::string source_;
  GLuint program_ = 0;
};

}  // namespace weft::gpu
