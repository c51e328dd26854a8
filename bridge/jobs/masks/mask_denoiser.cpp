#include "bridge/jobs/masks/mask_denoiser.h"

#include "model/failure.h"
#include "rt/masks/mask_request.h"

namespace sideray::bridge {
namespace {

constexpr TexelFormat byte1{GL_R8, GL_RED, GL_UNSIGNED_BYTE, 1, 1};
constexpr TexelFormat single2{GL_RG32F, GL_RG, GL_FLOAT, 8, 8};
constexpr uint32_t sky = 0xffffffffu, combined = 0xfffffffeu, unhidden = 0xfffffffdu;
constexpr uint32_t units = 8;

gl::Texture make_texture(const gl::Functions& gl, const TexelFormat& format, uint32_t width, uint32_t height) {
  gl::Texture texture(gl);
  gl.BindTexture(GL_TEXTURE_2D, texture.id());
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
  gl.TexImage2D(GL_TEXTURE_2D, 0, static_cast<GLint>(format.internal), static_cast<GLsizei>(width),
                static_cast<GLsizei>(height), 0, format.format, format.type, nullptr);
  return texture;
}

}  // namespace

void MaskDenoiser::allocate(const gl::Functions& gl, uint32_t width, uint32_t height) {
  if (width == width_ && height == height_) return;
  width_ = height_ = 0;
  gl.BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
  visibility_ = make_texture(gl, byte1, width, height);
  hit_distance_ = make_texture(gl, single, width, height);
  depth_ = make_texture(gl, single, width, height);
  motion_ = make_texture(gl, single2, width, height);
  if (!from_) from_ = gl::Framebuffer(gl);
  if (!to_) to_ = gl::Framebuffer(gl);
  if (gl.GetError() != GL_NO_ERROR)
    fail(SIDERAY_OUT_OF_MEMORY, "filters of masks of {}x{}: the driver has no room; filter on the CPU", width, height);
  width_ = width, height_ = height;
}

gl::ShadowFilterPass& MaskDenoiser::pass_of(const gl::Functions& gl, uint32_t light) {
  auto& pass = filters_[light].pass;
  if (!pass) pass = std::make_unique<gl::ShadowFilterPass>(gl);
  return *pass;
}

void MaskDenoiser::prepare(const gl::Functions& gl, const Input& in) {
  if (!in.filters.frame()) return;
  allocate(gl, in.masks.width, in.masks.height);
  for (const uint32_t light : rt::lights_of(in.lights))
    if (rt::is_filtered(in.snapshot.lights[light], in.random) && !in.masks.filter_distance.empty())
      pass_of(gl, light).fit(width_, height_);
  if (in.combined_lights && !in.masks.filter_distance.empty()) pass_of(gl, combined).fit(width_, height_);
  if (in.masks.open_distance.empty()) return;
  pass_of(gl, sky).fit(width_, height_);
  if (in.unhidden) pass_of(gl, unhidden).fit(width_, height_);
}

uint64_t MaskDenoiser::upload_frame(const gl::Functions& gl, const Input& in, const UploadWay& way) {
  const rt::FilterFrame& frame = *in.filters.frame();
  const Rectangle all{0, 0, width_, height_};
  std::vector<TexturePiece> pieces{
      {GL_TEXTURE_2D, depth_.id(), 0, single, all, reinterpret_cast<const std::byte*>(frame.depth.data()), width_}};
  if (in.motion == 0 && !frame.motion.empty())
    pieces.push_back({GL_TEXTURE_2D, motion_.id(), 0, single2, all,
                      reinterpret_cast<const std::byte*>(frame.motion.data()), width_});
  return upload_.send(gl, pieces, way);
}

uint64_t MaskDenoiser::filter_one(const gl::Functions& gl, const Input& in, Filter& filter,
                                  const shading::SfLight& light, const uint8_t* mask, const float* hit_distance,
                                  const UploadWay& way) {
  const Rectangle all{0, 0, width_, height_};
  gl.ActiveTexture(GL_TEXTURE0);
  const TexturePiece pieces[] = {
      {GL_TEXTURE_2D, visibility_.id(), 0, byte1, all, reinterpret_cast<const std::byte*>(mask), width_},
      {GL_TEXTURE_2D, hit_distance_.id(), 0, single, all, reinterpret_cast<const std::byte*>(hit_distance), width_}};
  const uint64_t bytes = upload_.send(gl, pieces, way);
  const rt::FilterFrame& frame = *in.filters.frame();
  const uint32_t motion = in.motion ? in.motion : frame.motion.empty() ? 0 : motion_.id();
  const gl::ShadowFilterTextures textures{width_,      height_, visibility_.id(), hit_distance_.id(),
                                          depth_.id(), motion,  frame.view,       light};
  const bool follows = in.filters.follows(filter.last_frame, in.sequence);
  if (!follows) filter.pass->reset();
  if (follows && in.sequence == rt::SequenceStep::next) filter.pass->follow(filter.light);
  filter.pass->spatial(textures);
  filter.light = light;
  if (in.filters.follows()) filter.pass->temporal(textures, in.sequence == rt::SequenceStep::again);
  result_ = in.filters.follows() ? filter.pass->accumulated() : filter.pass->filtered();
  return bytes;
}

// Takes over what the filter made last: it holds for this frame, too.
void MaskDenoiser::keep(const Input& in, Filter& filter) {
  in.filters.follows(filter.last_frame, in.sequence);
}

void MaskDenoiser::copy(const gl::Functions& gl, uint32_t from, uint32_t target, uint32_t to, uint32_t layer) {
  gl.BindFramebuffer(GL_READ_FRAMEBUFFER, from_.id());
  gl.FramebufferTexture2D(GL_READ_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, from, 0);
  gl.ReadBuffer(GL_COLOR_ATTACHMENT0);
  gl.BindFramebuffer(GL_DRAW_FRAMEBUFFER, to_.id());
  if (target == GL_TEXTURE_2D_ARRAY)
    gl.FramebufferTextureLayer(GL_DRAW_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, to, 0, static_cast<GLint>(layer));
  else
    gl.FramebufferTexture2D(GL_DRAW_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, to, 0);
  const auto width = static_cast<GLint>(width_), height = static_cast<GLint>(height_);
  gl.BlitFramebuffer(0, 0, width, height, 0, 0, width, height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
}

uint64_t MaskDenoiser::denoise(const gl::Functions& gl, const Input& in, const MaskTextures& textures,
                               const UploadWay& way) {
  if (!in.filters.frame() || in.kept.keeps_all()) return 0;
  for (uint32_t unit = 0; unit < units; ++unit) gl.BindSampler(unit, 0);
  gl.ActiveTexture(GL_TEXTURE0);
  prepare(gl, in);
  uint64_t bytes = upload_frame(gl, in, way);
  const size_t pixels = size_t{width_} * height_;
  const std::vector<uint32_t> lights = rt::lights_of(in.lights);
  for (uint32_t layer = 0; layer < lights.size(); ++layer) {
    const model::Light& light = in.snapshot.lights[lights[layer]];
    if (!rt::is_filtered(light, in.random) || in.masks.filter_distance.empty()) continue;
    if (in.kept.keeps(layer)) {
      keep(in, filters_[lights[layer]]);
      continue;
    }
    bytes += filter_one(gl, in, filters_[lights[layer]], rt::filter_light(light, in.filters.camera()),
                        &in.masks.lit[layer * pixels], &in.masks.filter_distance[layer * pixels], way);
    copy(gl, result_, GL_TEXTURE_2D_ARRAY, textures.shadow(), layer);
  }
  if (in.combined_lights && !in.masks.filter_distance.empty()) {
    const auto layer = static_cast<uint32_t>(lights.size());
    if (in.kept.keeps(layer)) {
      keep(in, filters_[combined]);
    } else {
      bytes += filter_one(gl, in, filters_[combined], rt::filter_sky(), &in.masks.lit[layer * pixels],
                          &in.masks.filter_distance[layer * pixels], way);
      copy(gl, result_, GL_TEXTURE_2D_ARRAY, textures.shadow(), layer);
    }
  }
  if (in.masks.open_distance.empty()) return bytes;
  const uint32_t last = in.masks.layers - 1;
  if (in.unhidden && in.kept.keeps(last)) {
    keep(in, filters_[unhidden]);
  } else if (in.unhidden) {
    bytes += filter_one(gl, in, filters_[unhidden], rt::filter_sky(), &in.masks.lit[last * pixels],
                        &in.masks.filter_distance[last * pixels], way);
    copy(gl, result_, GL_TEXTURE_2D_ARRAY, textures.shadow(), last);
  }
  if (in.kept.keeps(in.masks.layers)) {
    keep(in, filters_[sky]);
    return bytes;
  }
  bytes += filter_one(gl, in, filters_[sky], rt::filter_sky(), in.masks.open.data(), in.masks.open_distance.data(),
                      way);
  copy(gl, result_, GL_TEXTURE_2D, textures.ambient(), 0);
  return bytes;
}

void MaskDenoiser::abandon() {
  for (auto& [light, filter] : filters_)
    if (filter.pass) filter.pass->abandon();
  filters_.clear();
  for (gl::Texture* texture : {&visibility_, &hit_distance_, &depth_, &motion_}) texture->abandon();
  from_.abandon(), to_.abandon();
  upload_.abandon();
  width_ = height_ = 0;
}

}  // namespace sideray::bridge
