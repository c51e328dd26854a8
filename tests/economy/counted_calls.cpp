#include "economy/counted_calls.h"

#include <type_traits>

namespace sideray::tests {
namespace {

CallCounts counts;
thread_local bool driver = false;
GladGLContext real;

// Leaves out polls of fences, whose number depends on time.
bool counts_as_call(const void* entry) {
  return entry != reinterpret_cast<const void*>(real.ClientWaitSync);
}

template <auto Entry, bool Makes>
struct Counted;

template <typename Result, typename... Arguments, Result (*GladGLContext::*Entry)(Arguments...), bool Makes>
struct Counted<Entry, Makes> {
  static Result call(Arguments... arguments) {
    if (counts_as_call(reinterpret_cast<const void*>(real.*Entry))) ++counts.calls;
    if constexpr (Makes) counts.objects += made(arguments...);
    driver = true;
    if constexpr (std::is_void_v<Result>) {
      (real.*Entry)(arguments...);
      driver = false;
    } else {
      const Result result = (real.*Entry)(arguments...);
      driver = false;
      return result;
    }
  }
  // Returns the number of made objects, by the call's arguments: Gen* take it, CreateProgram and CreateShader do not.
  static uint64_t made() { return 1; }
  static uint64_t made(GLenum) { return 1; }
  template <typename Names>
  static uint64_t made(GLsizei count, Names) {
    return static_cast<uint64_t>(count);
  }
};

template <auto Entry, bool Makes = false>
void wrap(GladGLContext& table) {
  if (real.*Entry) table.*Entry = &Counted<Entry, Makes>::call;
}

template <auto... Entries>
void wrap_all(GladGLContext& table) {
  (wrap<Entries>(table), ...);
}

template <auto... Entries>
void wrap_makers(GladGLContext& table) {
  (wrap<Entries, true>(table), ...);
}

using G = GladGLContext;

void wrap_state(G& table) {
  wrap_all<&G::ActiveTexture, &G::BindBuffer, &G::BindBufferBase, &G::BindBufferRange, &G::BindFramebuffer,
           &G::BindRenderbuffer, &G::BindSampler, &G::BindTexture, &G::BindVertexArray, &G::BlendColor,
           &G::BlendEquation, &G::BlendEquationSeparate, &G::BlendEquationSeparatei, &G::BlendFunc,
           &G::BlendFuncSeparate, &G::BlendFuncSeparatei, &G::BlendFunci, &G::ClampColor, &G::ClipControl,
           &G::ColorMask, &G::ColorMaski, &G::CullFace, &G::DebugMessageCallback, &G::DebugMessageControl,
           &G::DepthFunc, &G::DepthMask, &G::Disable, &G::Disablei, &G::DrawBuffer, &G::DrawBuffers, &G::Enable,
           &G::Enablei, &G::FrontFace, &G::PixelStorei, &G::PixelTransferf, &G::PixelTransferi, &G::PolygonMode,
           &G::PolygonOffset, &G::ReadBuffer, &G::SamplerParameteri, &G::Scissor, &G::ScissorIndexedv, &G::StencilFunc,
           &G::StencilFuncSeparate, &G::StencilMask, &G::StencilMaskSeparate, &G::StencilOp, &G::StencilOpSeparate,
           &G::TexParameteri, &G::UseProgram, &G::Viewport, &G::ViewportIndexedfv>(table);
}

void wrap_queries(G& table) {
  wrap_all<&G::CheckFramebufferStatus, &G::ClientWaitSync, &G::GetActiveUniform, &G::GetBooleanv,
           &G::GetBufferSubData, &G::GetError, &G::GetFloatv, &G::GetFramebufferAttachmentParameteriv, &G::GetInteger64v, &G::GetIntegerv,
           &G::GetProgramInfoLog, &G::GetProgramiv, &G::GetQueryObjectuiv, &G::GetRenderbufferParameteriv,
           &G::GetShaderInfoLog, &G::GetShaderiv, &G::GetString, &G::GetStringi, &G::GetTexImage,
           &G::GetTextureLevelParameteriv, &G::GetUniformBlockIndex, &G::GetUniformLocation, &G::IsBuffer, &G::IsEnabled,
           &G::IsEnabledi, &G::IsFramebuffer, &G::IsProgram, &G::IsRenderbuffer, &G::IsSampler, &G::IsTexture,
           &G::IsVertexArray>(table);
}

void wrap_objects(G& table) {
  wrap_all<&G::AttachShader, &G::BufferData, &G::BufferStorage, &G::BufferSubData, &G::CompileShader, &G::DeleteBuffers,
           &G::DeleteFramebuffers, &G::DeleteProgram, &G::DeleteQueries, &G::DeleteRenderbuffers, &G::DeleteSamplers,
           &G::DeleteShader, &G::DeleteSync, &G::DeleteTextures, &G::DeleteVertexArrays, &G::DetachShader,
           &G::EnableVertexAttribArray, &G::FenceSync, &G::FramebufferTexture2D, &G::FramebufferTextureLayer,
           &G::LinkProgram, &G::MapBufferRange, &G::ShaderSource, &G::TexImage2D, &G::TexImage3D, &G::TexSubImage2D,
           &G::TexSubImage3D, &G::UniformBlockBinding, &G::UnmapBuffer, &G::VertexAttribDivisor,
           &G::VertexAttribIPointer, &G::VertexAttribPointer>(table);
  wrap_makers<&G::CreateProgram, &G::CreateShader, &G::GenBuffers, &G::GenFramebuffers, &G::GenQueries,
              &G::GenRenderbuffers, &G::GenSamplers, &G::GenTextures, &G::GenVertexArrays>(table);
}

void wrap_work(G& table) {
  wrap_all<&G::BeginQuery, &G::BlitFramebuffer, &G::ClearBufferData, &G::ClearBufferfi, &G::ClearBufferfv,
           &G::ClearBufferiv, &G::ClearBufferuiv, &G::CopyTexSubImage2D, &G::DrawArrays, &G::DrawArraysInstanced,
           &G::DrawElementsInstanced, &G::DrawElementsInstancedBaseInstance, &G::EndQuery, &G::Finish, &G::Flush, &G::GenerateMipmap,
           &G::MemoryBarrier, &G::MultiDrawElementsIndirect, &G::ReadPixels, &G::Uniform1f,
           &G::Uniform1i, &G::Uniform1iv, &G::Uniform1ui, &G::Uniform2f, &G::Uniform2fv, &G::Uniform2iv, &G::Uniform2uiv, &G::Uniform3fv, &G::Uniform3iv, &G::Uniform4f, &G::Uniform4fv,
           &G::Uniform4iv, &G::UniformMatrix3fv, &G::UniformMatrix4fv>(table);
}

}  // namespace

CallCounts call_counts() {
  return counts;
}

bool in_driver() {
  return driver;
}

void count_calls(gl::Functions& functions) {
  real = functions;
  GladGLContext table{};
  wrap_state(table);
  wrap_queries(table);
  wrap_objects(table);
  wrap_work(table);
  static_cast<GladGLContext&>(functions) = table;
}

}  // namespace sideray::tests
