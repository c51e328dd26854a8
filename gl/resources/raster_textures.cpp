#include "gl/resources/raster_textures.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "gl/resources/raster_programs.h"
#include "model/failure.h"
#include "model/texture.h"

namespace sideray::gl {
namespace {

constexpr int as_int(uint32_t value) {
  return static_cast<int>(value);
}

uint32_t wrap_of(sideray_wrap wrap) {
  if (wrap == SIDERAY_CLAMP) return GL_CLAMP_TO_EDGE;
  return wrap == SIDERAY_MIRROR ? GL_MIRRORED_REPEAT : GL_REPEAT;
}

void set_parameters(const Functions& gl, uint32_t target, uint32_t filter, uint32_t wrap_u, uint32_t wrap_v) {
  gl.TexParameteri(target, GL_TEXTURE_MIN_FILTER, as_int(filter));
  gl.TexParameteri(target, GL_TEXTURE_MAG_FILTER, filter == GL_NEAREST ? GL_NEAREST : GL_LINEAR);
  gl.TexParameteri(target, GL_TEXTURE_WRAP_S, as_int(wrap_u));
  gl.TexParameteri(target, GL_TEXTURE_WRAP_T, as_int(wrap_v));
}

constexpr sideray_texture_slot plain_slot{};

// Returns sRGB texels as linear light in 16 bits.
std::vector<uint16_t> decoded(const std::vector<uint8_t>& rgba) {
  std::vector<uint16_t> linear(rgba.size());
  for (size_t i = 0; i < rgba.size(); ++i) {
    const bool alpha = i % 4 == 3;
    const float share = alpha ? static_cast<float>(rgba[i]) / 255.0f : model::srgb_to_linear_table()[rgba[i]];
    linear[i] = static_cast<uint16_t>(std::lround(share * 65535.0f));
  }
  return linear;
}

}  // namespace

void check_allocation(const Functions& gl, const char* what) {
  const GLenum error = gl.GetError();
  if (error == GL_NO_ERROR) return;
  if (error == GL_OUT_OF_MEMORY)
    fail(SIDERAY_OUT_OF_MEMORY, "{}: the OpenGL driver is out of memory; use a smaller picture or scene", what);
  fail(SIDERAY_GL_FAILED, "{}: OpenGL error {:#x} on {}", what, error, gl.renderer);
}

RasterTextures::RasterTextures(const Functions& gl) : gl_(gl) {
  GLint side = 0;
  gl.GetIntegerv(GL_MAX_TEXTURE_SIZE, &side);
  largest_side_ = static_cast<uint32_t>(side);
  model::Texture white;
  white.levels.push_back({1, 1, {255, 255, 255, 255}});
  white_ = upload(white);

  albedo_terms_ = Texture(gl);
  bind_plain(0, GL_TEXTURE_2D, albedo_terms_.id());
  set_parameters(gl, GL_TEXTURE_2D, GL_LINEAR, GL_CLAMP_TO_EDGE, GL_CLAMP_TO_EDGE);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
  constexpr int size = as_int(model::AlbedoTable::size);
  gl.TexImage2D(GL_TEXTURE_2D, 0, GL_RGB32F, size, size, 0, GL_RGB, GL_FLOAT, model::albedo_table().values.data());

  empty_radiance_ = make_array(GL_RGBA16F, GL_RGBA, GL_FLOAT);
  empty_distance_ = make_array(GL_R32F, GL_RED, GL_FLOAT);
  empty_surface_id_ = make_array(GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT);
  empty_shadow_ = make_array(GL_DEPTH_COMPONENT32F, GL_DEPTH_COMPONENT, GL_FLOAT);
  gl.TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
  check_allocation(gl, "textures");
}

Texture RasterTextures::make_array(uint32_t internal_format, uint32_t format, uint32_t type) const {
  Texture texture(gl_);
  bind_plain(0, GL_TEXTURE_2D_ARRAY, texture.id());
  set_parameters(gl_, GL_TEXTURE_2D_ARRAY, GL_NEAREST, GL_CLAMP_TO_EDGE, GL_CLAMP_TO_EDGE);
  gl_.TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAX_LEVEL, 0);
  const float zeros[4] = {};
  gl_.TexImage3D(GL_TEXTURE_2D_ARRAY, 0, as_int(internal_format), 1, 1, 1, 0, format, type, zeros);
  return texture;
}

void RasterTextures::bind_plain(uint32_t texture_unit, uint32_t target, uint32_t texture) const {
  gl_.ActiveTexture(GL_TEXTURE0 + texture_unit);
  gl_.BindTexture(target, texture);
  gl_.BindSampler(texture_unit, 0);
}

Texture RasterTextures::upload(const model::Texture& source) const {
  Texture texture(gl_);
  bind_plain(0, GL_TEXTURE_2D, texture.id());
  // Levels beyond the driver's limit are left out: the picture is softer, nothing else changes.
  size_t first = 0;
  while (first + 1 < source.levels.size() &&
         std::max(source.levels[first].width, source.levels[first].height) > largest_side_)
    ++first;
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, static_cast<int>(source.levels.size() - 1 - first));
  for (size_t i = first; i < source.levels.size(); ++i)
    upload_level(source.levels[i], static_cast<int>(i - first), source.srgb);
  return texture;
}

void RasterTextures::upload_level(const model::Texture::Level& level, int place, bool srgb) const {
  const auto specify = [&](uint32_t internal_format, uint32_t type, const void* texels) {
    gl_.TexImage2D(GL_TEXTURE_2D, place, as_int(internal_format), as_int(level.width), as_int(level.height), 0, GL_RGBA,
                   type, texels);
  };
  // llvmpipe decodes sRGB by a polynomial that is off by .7 % at code 84 and by 12 % at code 11.
  if (srgb && gl_.software)
    specify(GL_RGBA16, GL_UNSIGNED_SHORT, decoded(level.rgba).data());
  else
    specify(srgb ? GL_SRGB8_ALPHA8 : GL_RGBA8, GL_UNSIGNED_BYTE, level.rgba.data());
}

Texture RasterTextures::upload_environment(std::span<const model::Environment::Image> levels, uint32_t format) const {
  Texture texture(gl_);
  bind_plain(0, GL_TEXTURE_2D, texture.id());
  set_parameters(gl_, GL_TEXTURE_2D, levels.size() > 1 ? GL_LINEAR_MIPMAP_LINEAR : GL_LINEAR, GL_REPEAT,
                 GL_CLAMP_TO_EDGE);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, static_cast<int>(levels.size() - 1));
  for (size_t i = 0; i < levels.size(); ++i)
    gl_.TexImage2D(GL_TEXTURE_2D, static_cast<int>(i), as_int(format), as_int(levels[i].width),
                   as_int(levels[i].height), 0, GL_RGB, GL_FLOAT, levels[i].texels.data());
  return texture;
}

void RasterTextures::set_environment(const std::shared_ptr<const model::Environment>& environment) {
  if (environment == environment_) return;
  environment_specular_ = upload_environment(environment->specular, GL_RGB16F);
  environment_irradiance_ = upload_environment({&environment->irradiance, 1}, GL_RGB32F);
  environment_last_level_ = static_cast<float>(environment->specular.size() - 1);
  environment_ = environment;
}

void RasterTextures::set_scene(const model::Snapshot& snapshot) {
  gl_.BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
  gl_.PixelStorei(GL_UNPACK_ALIGNMENT, 4);
  std::map<const model::Texture*, Image> images;
  for (const std::shared_ptr<const model::Texture>& source : snapshot.textures) {
    if (images.count(source.get())) continue;
    const auto known = images_.find(source.get());
    Image image = known != images_.end() ? std::move(known->second) : Image{source, upload(*source)};
    images.emplace(source.get(), std::move(image));
  }
  images_ = std::move(images);
  set_environment(snapshot.environment);
  check_allocation(gl_, "textures");
}

uint32_t RasterTextures::sampler(const sideray_texture_slot& slot) {
  const uint32_t key = static_cast<uint32_t>(slot.filter) * 16 + static_cast<uint32_t>(slot.wrap_u) * 4 +
                       static_cast<uint32_t>(slot.wrap_v);
  Sampler& sampler = samplers_[key];
  if (sampler) return sampler.id();
  sampler = Sampler(gl_);
  const uint32_t minify = slot.filter == SIDERAY_TRILINEAR  ? GL_LINEAR_MIPMAP_LINEAR
                          : slot.filter == SIDERAY_BILINEAR ? GL_LINEAR
                                                            : GL_NEAREST;
  gl_.SamplerParameteri(sampler.id(), GL_TEXTURE_MIN_FILTER, as_int(minify));
  gl_.SamplerParameteri(sampler.id(), GL_TEXTURE_MAG_FILTER, slot.filter == SIDERAY_NEAREST ? GL_NEAREST : GL_LINEAR);
  gl_.SamplerParameteri(sampler.id(), GL_TEXTURE_WRAP_S, as_int(wrap_of(slot.wrap_u)));
  gl_.SamplerParameteri(sampler.id(), GL_TEXTURE_WRAP_T, as_int(wrap_of(slot.wrap_v)));
  return sampler.id();
}

void RasterTextures::bind(uint32_t texture_unit, const model::Texture* texture, const sideray_texture_slot& slot) {
  gl_.ActiveTexture(GL_TEXTURE0 + texture_unit);
  gl_.BindTexture(GL_TEXTURE_2D, texture ? images_.at(texture).texture.id() : white_.id());
  gl_.BindSampler(texture_unit, sampler(texture ? slot : plain_slot));
}

void RasterTextures::bind_environment() const {
  bind_plain(unit::environment_specular, GL_TEXTURE_2D, environment_specular_.id());
  bind_plain(unit::environment_irradiance, GL_TEXTURE_2D, environment_irradiance_.id());
  bind_plain(unit::albedo_terms, GL_TEXTURE_2D, albedo_terms_.id());
}

void RasterTextures::bind_empty_cache() const {
  bind_plain(unit::layer_cache, GL_TEXTURE_2D_ARRAY, empty_radiance_.id());
  bind_plain(unit::layer_cache + 1, GL_TEXTURE_2D_ARRAY, empty_distance_.id());
  bind_plain(unit::layer_cache + 2, GL_TEXTURE_2D_ARRAY, empty_surface_id_.id());
}

}  // namespace sideray::gl
