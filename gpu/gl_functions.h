// The OpenGL 4.5 entry points that gpu/ uses, resolved at run time. The ready-made loaders (epoxy,
// GLEW) find no entry points on an OSMesa context.
#pragma once

#include <GL/glcorearb.h>

namespace weft::gpu {

// One line per entry point: the type of its pointer, and its name without "gl".
#define WEFT_GL_FUNCTIONS(X)                                   \
  X(PFNGLATTACHSHADERPROC, AttachShader)                       \
  X(PFNGLBINDBUFFERPROC, BindBuffer)                           \
  X(PFNGLBINDBUFFERBASEPROC, BindBufferBase)                   \
  X(PFNGLCOMPILESHADERPROC, CompileShader)                     \
  X(PFNGLCOPYNAMEDBUFFERSUBDATAPROC, CopyNamedBufferSubData)   \
  X(PFNGLCREATEBUFFERSPROC, CreateBuffers)                     \
  X(PFNGLCREATEPROGRAMPROC, CreateProgram)                     \
  X(PFNGLCREATESHADERPROC, CreateShader)                       \
  X(PFNGLDELETEBUFFERSPROC, DeleteBuffers)                     \
  X(PFNGLDELETEPROGRAMPROC, DeleteProgram)                     \
  X(PFNGLDELETESHADERPROC, DeleteShader)                       \
  X(PFNGLDISPATCHCOMPUTEPROC, DispatchCompute)                 \
  X(PFNGLDISPATCHCOMPUTEINDIRECTPROC, DispatchComputeIndirect) \
  X(PFNGLFINISHPROC, Finish)                                   \
  X(PFNGLGETERRORPROC, GetError)                               \
  X(PFNGLGETINTEGER64VPROC, GetInteger64v)                     \
  X(PFNGLGETINTEGERI_VPROC, GetIntegeri_v)                     \
  X(PFNGLGETNAMEDBUFFERSUBDATAPROC, GetNamedBufferSubData)     \
  X(PFNGLGETPROGRAMINFOLOGPROC, GetProgramInfoLog)             \
  X(PFNGLGETPROGRAMIVPROC, GetProgramiv)                       \
  X(PFNGLGETSHADERINFOLOGPROC, GetShaderInfoLog)               \
  X(PFNGLGETSHADERIVPROC, GetShaderiv)                         \
  X(PFNGLGETSTRINGPROC, GetString)                             \
  X(PFNGLGETUNIFORMLOCATIONPROC, GetUniformLocation)           \
  X(PFNGLLINKPROGRAMPROC, LinkProgram)                         \
  X(PFNGLMAPNAMEDBUFFERRANGEPROC, MapNamedBufferRange)         \
  X(PFNGLMEMORYBARRIERPROC, MemoryBarrier)                     \
  X(PFNGLNAMEDBUFFERDATAPROC, NamedBufferData)                 \
  X(PFNGLNAMEDBUFFERSTORAGEPROC, NamedBufferStorage)           \
  X(PFNGLNAMEDBUFFERSUBDATAPROC, NamedBufferSubData)           \
  X(PFNGLSHADERSOURCEPROC, ShaderSource)                       \
  X(PFNGLUNIFORM1UIPROC, Uniform1ui)                           \
  X(PFNGLUSEPROGRAMPROC, UseProgram)

// The entry points as members with OpenGL's own names: gl.UseProgram(program) calls glUseProgram.
struct GlFunctions {
#define WEFT_GL_MEMBER(type, name) type name = nullptr;
  WEFT_GL_FUNCTIONS(WEFT_GL_MEMBER)
#undef WEFT_GL_MEMBER
};

}  // namespace weft::gpu
