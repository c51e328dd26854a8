#include "bridge/transport/depth_packer.h"

#include <algorithm>
#include <cstring>
#include <utility>
#include <vector>

#include "gl/resources/state_guard.h"
#include "model/failure.h"

namespace sideray::bridge {
namespace {

constexpr uint32_t group_size = 16;  // both sides of the shader's work groups
constexpr uint32_t depth_unit = 0, stencil_unit = 1, unit_count = 2, storage_points = 1;

uint32_t groups_over(uint32_t pixels) {
  return (pixels + group_size - 1) / group_size;
}

// Returns depths spread evenly from 0 to 1, with every stencil value.
std::vector<uint32_t> probes(uint32_t side) {
  std::vector<uint32_t> words(size_t{side} * side);
  for (uint32_t i = 0; i < words.size(); ++i) words[i] = (i << 8 | i >> 8) << 8 | (i & 255);
  return words;
}

void show(const gl::Functions& gl, uint32_t texture, GLint part) {
  gl.BindTexture(GL_TEXTURE_2D, texture);
  gl.TexParameteri(GL_TEXTURE_2D, GL_DEPTH_STENCIL_TEXTURE_MODE, part);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
}

}  // namespace

DepthPacker::DepthPacker(const gl::Functions& gl)
    : gl_(gl),
      program_(gl, "pack depth and stencil", {{"pack_depth_stencil.comp.glsl"}, {}, "430 core"}) {}

// Binds the copy for drawing. It only grows, since views of several sizes take turns.
void DepthPacker::require_copy(uint32_t width, uint32_t height) {
  if (!copy_ || width > width_ || height > height_) {
    width = std::max(width, width_), height = std::max(height, height_);
    width_ = height_ = 0;
    depth_ = gl::Texture(gl_), stencil_ = gl::Texture(gl_), copy_ = gl::Framebuffer(gl_);
    gl_.BindTexture(GL_TEXTURE_2D, depth_.id());
    gl_.TexStorage2D(GL_TEXTURE_2D, 1, GL_DEPTH24_STENCIL8, static_cast<GLsizei>(width), static_cast<GLsizei>(height));
    gl_.TextureView(stencil_.id(), GL_TEXTURE_2D, depth_.id(), GL_DEPTH24_STENCIL8, 0, 1, 0, 1);
    show(gl_, depth_.id(), GL_DEPTH_COMPONENT);
    show(gl_, stencil_.id(), GL_STENCIL_INDEX);
    gl_.BindFramebuffer(GL_DRAW_FRAMEBUFFER, copy_.id());
    gl_.FramebufferTexture2D(GL_DRAW_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_TEXTURE_2D, depth_.id(), 0);
    gl_.DrawBuffer(GL_NONE);
    if (gl_.CheckFramebufferStatus(GL_DRAW_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE || gl_.GetError() != GL_NO_ERROR)
      fail(SIDERAY_OUT_OF_MEMORY, "depth readback: the driver makes no copy of {}x{} pixels; lower the resolution",
           width, height);
    width_ = width, height_ = height;
  }
  gl_.BindFramebuffer(GL_DRAW_FRAMEBUFFER, copy_.id());
}

bool DepthPacker::is_exact() {
  constexpr uint32_t side = 256;
  const std::vector<uint32_t> words = probes(side);
  const size_t bytes = words.size() * sizeof(words[0]);
  const gl::TextureGuard textures(gl_, 0, unit_count);
  const gl::ProgramGuard program(gl_);
  const gl::StorageGuard storage(gl_, storage_points);
  gl_.ActiveTexture(GL_TEXTURE0);
  require_copy(side, side);
  gl_.BindTexture(GL_TEXTURE_2D, depth_.id());
  gl_.TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, side, side, GL_DEPTH_STENCIL, GL_UNSIGNED_INT_24_8, words.data());
  const gl::Buffer buffer(gl_);
  gl_.BindBuffer(GL_SHADER_STORAGE_BUFFER, buffer.id());
  gl_.BufferData(GL_SHADER_STORAGE_BUFFER, static_cast<GLsizeiptr>(bytes), nullptr, GL_STREAM_READ);
  dispatch(side, side, buffer.id());
  const void* const packed = gl::map_to_read(gl_, GL_SHADER_STORAGE_BUFFER, bytes);
  const bool same = packed && std::memcmp(packed, words.data(), bytes) == 0;
  if (packed) gl_.UnmapBuffer(GL_SHADER_STORAGE_BUFFER);
  return same;
}

void DepthPacker::pack(Rectangle where, uint32_t buffer) {
  const gl::TextureGuard textures(gl_, 0, unit_count);
  const gl::StorageGuard storage(gl_, storage_points);
  const gl::DrawGuard plain(gl_);  // guards the program, and sets initial state for the blit: see ReadTarget
  gl_.ActiveTexture(GL_TEXTURE0);
  require_copy(where.width, where.height);
  const auto x = static_cast<GLint>(where.x), y = static_cast<GLint>(where.y);
  const auto width = static_cast<GLint>(where.width), height = static_cast<GLint>(where.height);
  gl_.BlitFramebuffer(x, y, x + width, y + height, 0, 0, width, height, GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT,
                      GL_NEAREST);
  dispatch(where.width, where.height, buffer);
}

// Runs the shader; whoever maps the buffer afterwards sees its complete result, once the GPU is done.
void DepthPacker::dispatch(uint32_t width, uint32_t height, uint32_t buffer) {
  const std::pair<uint32_t, uint32_t> bindings[] = {{stencil_unit, stencil_.id()}, {depth_unit, depth_.id()}};
  for (const auto& [unit, texture] : bindings) {
    gl_.ActiveTexture(GL_TEXTURE0 + unit);
    gl_.BindTexture(GL_TEXTURE_2D, texture);
    gl_.BindSampler(unit, 0);
  }
  gl_.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, buffer);
  program_.use();
  program_.set("size", glm::uvec2(width, height));
  gl_.DispatchCompute(groups_over(width), groups_over(height), 1);
  gl_.MemoryBarrier(GL_CLIENT_MAPPED_BUFFER_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
}

void DepthPacker::abandon() {
  program_.abandon();
  depth_.abandon(), stencil_.abandon(), copy_.abandon();
  width_ = height_ = 0;
}

}  // namespace sideray::bridge
