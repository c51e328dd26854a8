// Lists the OpenGL entry points. Function pointers, exported functions, and what glXGetProcAddress and dlsym return are
// generated from these tables.
#pragma once

#define GL_GLEXT_PROTOTYPES 1
#define GLX_GLXEXT_PROTOTYPES 1
#include <GL/gl.h>
#include <GL/glext.h>
#include <GL/glx.h>

// X(NAME): functions that the library calls and programs reach directly.
#define SIDERAY_RUN_CALLED(X)                                                                                            \
  X(GetIntegerv) X(GetFloatv) X(GetDoublev) X(GetBooleanv) X(IsEnabled) X(GetString) X(GetError) X(GetLightfv)             \
  X(GetMaterialfv) X(GetTexEnviv) X(GetTexEnvfv) X(GetTexGeniv) X(GetTexGenfv) X(GetTexLevelParameteriv) X(GetTexImage)    \
  X(GetTexParameteriv) X(GetClipPlane) X(GetPointerv) X(PushAttrib) X(PopAttrib) X(PushClientAttrib) X(PopClientAttrib)    \
  X(AlphaFunc) X(BlendFunc) X(BlendFuncSeparate) X(BlendEquation) X(DepthFunc) X(DepthMask) X(DepthRange) X(CullFace)      \
  X(FrontFace) X(ShadeModel) X(PolygonMode) X(PolygonOffset) X(ColorMask) X(Fogf) X(Fogi) X(Fogfv) X(LineWidth)            \
  X(PointSize) X(LightModeli) X(LightModelfv) X(Lightf) X(Lightfv) X(ColorMaterial) X(Viewport) X(Scissor) X(TexEnvi)      \
  X(TexEnvf) X(TexEnvfv) X(TexGeni) X(TexGenfv) X(ClipPlane) X(StencilFunc) X(StencilOp) X(StencilMask) X(LogicOp)         \
  X(PixelStorei) X(TexParameteri) X(ReadBuffer) X(EnableClientState) X(DisableClientState) X(VertexPointer)                \
  X(NormalPointer) X(ColorPointer) X(TexCoordPointer) X(ActiveTexture) X(ClientActiveTexture) X(BindBuffer)                \
  X(GetBufferParameteriv) X(GetBufferSubData) X(GenTextures) X(GenFramebuffers) X(DeleteFramebuffers)                      \
  X(FramebufferTexture2D) X(CheckFramebufferStatus) X(ClearColor) X(ClearDepth) X(CreateShader) X(ShaderSource)        \
  X(CompileShader)                                                                                                     \
  X(GetShaderiv) X(GetShaderInfoLog) X(DeleteShader) X(CreateProgram) X(AttachShader) X(LinkProgram) X(GetProgramiv)       \
  X(GetProgramInfoLog) X(DeleteProgram) X(GetUniformLocation) X(Finish) X(Uniform1f) X(Uniform1i) X(Uniform2f) X(Uniform3f) X(UniformMatrix4fv) X(GenQueries) X(DeleteQueries)                   \
  X(BeginQuery) X(EndQuery) X(GetQueryObjectuiv) X(WindowPos2i) X(PixelZoom)

// X(NAME): functions that programs call through the library. hooks/ defines each.
#define SIDERAY_RUN_HOOKED(X)                                                                                            \
  X(Begin) X(End) X(NewList) X(EndList) X(CallList) X(CallLists) X(DeleteLists)                                            \
  X(DrawArrays) X(DrawElements) X(DrawRangeElements) X(MultiDrawArrays) X(MultiDrawElements) X(ArrayElement)               \
  X(DrawPixels) X(Bitmap) X(CopyPixels) X(ReadPixels) X(CopyTexImage2D) X(CopyTexSubImage2D) X(Accum) X(Clear)             \
  X(EvalMesh1) X(EvalMesh2) X(Rectf) X(Recti) X(Rectd) X(Rects) X(Rectfv) X(Rectiv) X(Rectdv) X(Rectsv)                    \
  X(TexImage2D) X(TexSubImage2D) X(CompressedTexImage2D) X(DeleteTextures) X(BindTexture) X(GenerateMipmap)                \
  X(MatrixMode) X(PushMatrix) X(PopMatrix) X(LoadIdentity) X(LoadMatrixf) X(LoadMatrixd) X(MultMatrixf) X(MultMatrixd)     \
  X(Translatef) X(Translated) X(Rotatef) X(Rotated) X(Scalef) X(Scaled) X(Enable) X(Disable) X(Materialfv) X(Materialf)    \
  X(BufferData) X(BufferSubData) X(MapBuffer) X(MapBufferRange) X(DeleteBuffers)                                           \
  X(UseProgram) X(BindProgramPipeline) X(BindFramebuffer) X(BlitFramebuffer) X(DrawArraysInstanced)                        \
  X(DrawElementsInstanced) X(DrawElementsBaseVertex)

// X(ALIAS, NAME): older names of these functions.
#define SIDERAY_RUN_ALIASES(X)                                                                                           \
  X(DrawRangeElementsEXT, DrawRangeElements) X(MultiDrawArraysEXT, MultiDrawArrays)                                        \
  X(DrawArraysEXT, DrawArrays) X(BindTextureEXT, BindTexture) X(CompressedTexImage2DARB, CompressedTexImage2D)             \
  X(GenerateMipmapEXT, GenerateMipmap) X(BufferDataARB, BufferData) X(BufferSubDataARB, BufferSubData)                     \
  X(MapBufferARB, MapBuffer) X(DeleteBuffersARB, DeleteBuffers) X(BindFramebufferEXT, BindFramebuffer)                     \
  X(BlitFramebufferEXT, BlitFramebuffer)

// X(NAME, COUNT, SUFFIX, TYPE): vertex attributes, each with COUNT scalars of TYPE, and as a vector (SUFFIX ## v).
#define SIDERAY_RUN_TYPES(X, name, count)                                                                                \
  X(name, count, s, GLshort) X(name, count, i, GLint) X(name, count, f, GLfloat) X(name, count, d, GLdouble)
#define SIDERAY_RUN_COLOR_TYPES(X, count)                                                                                \
  SIDERAY_RUN_TYPES(X, Color, count)                                                                                     \
  X(Color, count, b, GLbyte) X(Color, count, ub, GLubyte) X(Color, count, us, GLushort) X(Color, count, ui, GLuint)
#define SIDERAY_RUN_ATTRIBUTES(X)                                                                                        \
  SIDERAY_RUN_TYPES(X, Vertex, 2) SIDERAY_RUN_TYPES(X, Vertex, 3) SIDERAY_RUN_TYPES(X, Vertex, 4)                          \
  SIDERAY_RUN_TYPES(X, Normal, 3) X(Normal, 3, b, GLbyte)                                                                \
  SIDERAY_RUN_COLOR_TYPES(X, 3) SIDERAY_RUN_COLOR_TYPES(X, 4)                                                              \
  SIDERAY_RUN_TYPES(X, TexCoord, 1) SIDERAY_RUN_TYPES(X, TexCoord, 2) SIDERAY_RUN_TYPES(X, TexCoord, 3)                    \
  SIDERAY_RUN_TYPES(X, TexCoord, 4)
// X(NAME, COUNT, SUFFIX, TYPE): attributes of a texture unit, each with and without ARB behind its name.
#define SIDERAY_RUN_UNIT_ATTRIBUTES(X)                                                                                   \
  SIDERAY_RUN_TYPES(X, MultiTexCoord, 1) SIDERAY_RUN_TYPES(X, MultiTexCoord, 2)                                            \
  SIDERAY_RUN_TYPES(X, MultiTexCoord, 3) SIDERAY_RUN_TYPES(X, MultiTexCoord, 4)
