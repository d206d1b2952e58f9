#include "gpu/gl_objects.h"

#include <algorithm>
#include <stdexcept>

namespace weft::gpu {
namespace {

GLuint compile_shader(const GlFunctions& gl, GLenum stage, const std::string& source) {
  const GLuint shader = gl.CreateShader(stage);
  const char* const text = source.c_str();
  gl.ShaderSource(shader, 1, &text, nullptr);
  gl.CompileShader(shader);
  GLint compiled = GL_FALSE;
  gl.GetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
  if (compiled == GL_TRUE) return shader;
  std::string log(4096, '\0');
  GLsizei length = 0;
  gl.GetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), &length, log.data());
  gl.DeleteShader(shader);
  throw std::runtime_error("OpenGL refuses a shader: " + log.substr(0, length));
}

}  // namespace

GLuint link_program(const GlFunctions& gl,
                    std::span<const std::pair<GLenum, std::string>> stages_and_sources) {
  const GLuint program = gl.CreateProgram();
  for (const auto& [stage, source] : stages_and_sources) {
    const GLuint shader = compile_shader(gl, stage, source);
    gl.AttachShader(program, shader);
    gl.DeleteShader(shader);
  }
  gl.LinkProgram(program);
  GLint linked = GL_FALSE;
  gl.GetProgramiv(program, GL_LINK_STATUS, &linked);
  if (linked == GL_TRUE) return program;
  std::string log(4096, '\0');
  GLsizei length = 0;
  gl.GetProgramInfoLog(program, static_cast<GLsizei>(log.size()), &length, log.data());
  gl.DeleteProgram(program);
  throw std::runtime_error("OpenGL cannot link a program: " + log.substr(0, length));
}

void check_gl(const GlFunctions& gl, const char* task) {
  const GLenum error = gl.GetError();
  if (error == GL_NO_ERROR) return;
  throw std::runtime_error(
      "OpenGL cannot " + std::string(task) + ": " +
      (error == GL_OUT_OF_MEMORY ? "out of memory" : "error " + std::to_string(error)));
}

std::size_t buffer_limit(const GlFunctions& gl) {
  GLint64 limit = 0;
  gl.GetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &limit);
  return static_cast<std::size_t>(limit);
}

std::size_t grown_capacity(const GlFunctions& gl, std::size_t capacity, std::size_t needed,
                           std::size_t item) {
  if (needed <= capacity) return capacity;
  return std::max(needed, std::min(needed + needed / 2, buffer_limit(gl) / item));
}

void GlBuffer::reserve(std::size_t bytes, const char* content) {
  bytes = std::max<std::size_t>(bytes, 16);
  if (bytes <= bytes_) return;
  const std::size_t limit = buffer_limit(*gl_);
  if (bytes > limit) {
    throw std::runtime_error(std::string("OpenGL: ") + content + " take " +
                             std::to_string(bytes >> 20) + " MiB, and this device allows " +
                             std::to_string(limit >> 20) + " MiB a buffer");
  }
  gl_->NamedBufferData(name_, static_cast<GLsizeiptr>(bytes), nullptr, GL_DYNAMIC_COPY);
  check_gl(*gl_, (std::string("hold ") + content).c_str());
  bytes_ = bytes;
}

const void* GlReadback::copy_bytes(const GlBuffer& from, std::size_t bytes, const char* content) {
  if (bytes > bytes_) {
    gl_->DeleteBuffers(1, &name_);  // also ends its mapping
    name_ = 0;
    bytes_ = 0;
    gl_->CreateBuffers(1, &name_);
    const std::size_t room = bytes + bytes / 2;
    constexpr GLbitfield access = GL_MAP_READ_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
    gl_->NamedBufferStorage(name_, static_cast<GLsizeiptr>(room), nullptr,
                            access | GL_CLIENT_STORAGE_BIT);
    memory_ = gl_->MapNamedBufferRange(name_, 0, static_cast<GLsizeiptr>(room), access);
    check_gl(*gl_, (std::string("copy ") + content).c_str());
    bytes_ = room;
  }
  if (bytes > 0) {
    gl_->CopyNamedBufferSubData(from.name(), name_, 0, 0, static_cast<GLsizeiptr>(bytes));
  }
  return memory_;
}

void ComputeProgram::use() {
  if (program_ == 0) {
    const std::pair<GLenum, std::string> stage(GL_COMPUTE_SHADER, source_);
    program_ = link_program(*gl_, std::span(&stage, 1));
  }
  gl_->UseProgram(program_);
}

}  // namespace weft::gpu
