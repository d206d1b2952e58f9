// The OpenGL 4.5 entry points that gpu/ uses, resolved at run time: the ready-made loaders (epoxy,
// GLEW) find none on an OSMesa context.
#pragma once

#include <GL/glcorearb.h>

namespace weft::gpu {

// One line an entry point: the type of its pointer, and its name without "gl".
#define WEFT_GL_FUNCTIONS(X)                                                           \
  X(PFNGLACTIVETEXTUREPROC, ActiveTexture)                                             \
  X(PFNGLATTACHSHADERPROC, AttachShader)                                               \
  X(PFNGLBINDBUFFERPROC, BindBuffer)                                                   \
  X(PFNGLBINDBUFFERBASEPROC, BindBufferBase)                                           \
  X(PFNGLBINDFRAMEBUFFERPROC, BindFramebuffer)                                         \
  X(PFNGLBINDTEXTUREPROC, BindTexture)                                                 \
  X(PFNGLBINDVERTEXARRAYPROC, BindVertexArray)                                         \
  X(PFNGLBLENDFUNCPROC, BlendFunc)                                                     \
  X(PFNGLBLITNAMEDFRAMEBUFFERPROC, BlitNamedFramebuffer)                               \
  X(PFNGLCHECKNAMEDFRAMEBUFFERSTATUSPROC, CheckNamedFramebufferStatus)                 \
  X(PFNGLCLEARPROC, Clear)                                                             \
  X(PFNGLCLEARNAMEDBUFFERSUBDATAPROC, ClearNamedBufferSubData)                         \
  X(PFNGLCOLORMASKPROC, ColorMask)                                                     \
  X(PFNGLCOMPILESHADERPROC, CompileShader)                                             \
  X(PFNGLCOPYNAMEDBUFFERSUBDATAPROC, CopyNamedBufferSubData)                           \
  X(PFNGLCREATEBUFFERSPROC, CreateBuffers)                                             \
  X(PFNGLCREATEFRAMEBUFFERSPROC, CreateFramebuffers)                                   \
  X(PFNGLCREATEPROGRAMPROC, CreateProgram)                                             \
  X(PFNGLCREATERENDERBUFFERSPROC, CreateRenderbuffers)                                 \
  X(PFNGLCREATESHADERPROC, CreateShader)                                               \
  X(PFNGLCREATETEXTURESPROC, CreateTextures)                                           \
  X(PFNGLCREATEVERTEXARRAYSPROC, CreateVertexArrays)                                   \
  X(PFNGLDELETEBUFFERSPROC, DeleteBuffers)                                             \
  X(PFNGLDELETEFRAMEBUFFERSPROC, DeleteFramebuffers)                                   \
  X(PFNGLDELETEPROGRAMPROC, DeleteProgram)                                             \
  X(PFNGLDELETERENDERBUFFERSPROC, DeleteRenderbuffers)                                 \
  X(PFNGLDELETESHADERPROC, DeleteShader)                                               \
  X(PFNGLDELETETEXTURESPROC, DeleteTextures)                                           \
  X(PFNGLDELETEVERTEXARRAYSPROC, DeleteVertexArrays)                                   \
  X(PFNGLDEPTHFUNCPROC, DepthFunc)                                                     \
  X(PFNGLDEPTHMASKPROC, DepthMask)                                                     \
  X(PFNGLDISABLEPROC, Disable)                                                         \
  X(PFNGLDISPATCHCOMPUTEPROC, DispatchCompute)                                         \
  X(PFNGLDISPATCHCOMPUTEINDIRECTPROC, DispatchComputeIndirect)                         \
  X(PFNGLDRAWARRAYSPROC, DrawArrays)                                                   \
  X(PFNGLDRAWELEMENTSPROC, DrawElements)                                               \
  X(PFNGLENABLEPROC, Enable)                                                           \
  X(PFNGLENABLEVERTEXARRAYATTRIBPROC, EnableVertexArrayAttrib)                         \
  X(PFNGLFINISHPROC, Finish)                                                           \
  X(PFNGLGETERRORPROC, GetError)                                                       \
  X(PFNGLGETINTEGER64VPROC, GetInteger64v)                                             \
  X(PFNGLGETINTEGERI_VPROC, GetIntegeri_v)                                             \
  X(PFNGLGETINTEGERVPROC, GetIntegerv)                                                 \
  X(PFNGLGETNAMEDBUFFERSUBDATAPROC, GetNamedBufferSubData)                             \
  X(PFNGLGETPROGRAMINFOLOGPROC, GetProgramInfoLog)                                     \
  X(PFNGLGETPROGRAMIVPROC, GetProgramiv)                                               \
  X(PFNGLGETSHADERINFOLOGPROC, GetShaderInfoLog)                                       \
  X(PFNGLGETSHADERIVPROC, GetShaderiv)                                                 \
  X(PFNGLGETSTRINGPROC, GetString)                                                     \
  X(PFNGLGETUNIFORMLOCATIONPROC, GetUniformLocation)                                   \
  X(PFNGLLINKPROGRAMPROC, LinkProgram)                                                 \
  X(PFNGLMEMORYBARRIERPROC, MemoryBarrier)                                             \
  X(PFNGLNAMEDBUFFERDATAPROC, NamedBufferData)                                         \
  X(PFNGLNAMEDBUFFERSUBDATAPROC, NamedBufferSubData)                                   \
  X(PFNGLNAMEDFRAMEBUFFERDRAWBUFFERPROC, NamedFramebufferDrawBuffer)                   \
  X(PFNGLNAMEDFRAMEBUFFERRENDERBUFFERPROC, NamedFramebufferRenderbuffer)               \
  X(PFNGLNAMEDFRAMEBUFFERTEXTURELAYERPROC, NamedFramebufferTextureLayer)               \
  X(PFNGLNAMEDRENDERBUFFERSTORAGEPROC, NamedRenderbufferStorage)                       \
  X(PFNGLNAMEDRENDERBUFFERSTORAGEMULTISAMPLEPROC, NamedRenderbufferStorageMultisample) \
  X(PFNGLPIXELSTOREIPROC, PixelStorei)                                                 \
  X(PFNGLPOLYGONOFFSETPROC, PolygonOffset)                                             \
  X(PFNGLREADPIXELSPROC, ReadPixels)                                                   \
  X(PFNGLSHADERSOURCEPROC, ShaderSource)                                               \
  X(PFNGLTEXTUREPARAMETERFVPROC, TextureParameterfv)                                   \
  X(PFNGLTEXTUREPARAMETERIPROC, TextureParameteri)                                     \
  X(PFNGLTEXTURESTORAGE3DPROC, TextureStorage3D)                                       \
  X(PFNGLUNIFORM1FPROC, Uniform1f)                                                     \
  X(PFNGLUNIFORM1IPROC, Uniform1i)                                                     \
  X(PFNGLUNIFORM1UIPROC, Uniform1ui)                                                   \
  X(PFNGLUNIFORM3FVPROC, Uniform3fv)                                                   \
  X(PFNGLUNIFORM4FVPROC, Uniform4fv)                                                   \
  X(PFNGLUNIFORMMATRIX4FVPROC, UniformMatrix4fv)                                       \
  X(PFNGLUSEPROGRAMPROC, UseProgram)                                                   \
  X(PFNGLVERTEXARRAYATTRIBBINDINGPROC, VertexArrayAttribBinding)                       \
  X(PFNGLVERTEXARRAYATTRIBFORMATPROC, VertexArrayAttribFormat)                         \
  X(PFNGLVERTEXARRAYELEMENTBUFFERPROC, VertexArrayElementBuffer)                       \
  X(PFNGLVERTEXARRAYVERTEXBUFFERPROC, VertexArrayVertexBuffer)                         \
  X(PFNGLVIEWPORTPROC, Viewport)

// Call as gl.Clear(...): the names are OpenGL's own.
struct GlFunctions {
#define WEFT_GL_MEMBER(type, name) type name = nullptr;
  WEFT_GL_FUNCTIONS(WEFT_GL_MEMBER)
#undef WEFT_GL_MEMBER
};

}  // namespace weft::gpu
