#include "bridge/jobs/masks/mask_textures.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "bridge/transport/tile_rectangles.h"
#include "model/failure.h"

namespace sideray::bridge {
namespace {

constexpr TexelFormat byte1{GL_R8, GL_RED, GL_UNSIGNED_BYTE, 1};

void set_nearest(const gl::Functions& gl, GLenum target) {
  gl.TexParameteri(target, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  gl.TexParameteri(target, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  gl.TexParameteri(target, GL_TEXTURE_MAX_LEVEL, 0);
}

// Returns the part of the picture in which a place's tints differ from 1; width 0: none.
Rectangle tinted_part(const rt::OcclusionMasks& masks, uint32_t place) {
  constexpr uint32_t side = rt::OcclusionMasks::tint_tile;
  uint32_t x0 = masks.width, y0 = masks.height, x1 = 0, y1 = 0;
  for (uint32_t v = 0; v < masks.tint_rows(); ++v)
    for (uint32_t u = 0; u < masks.tint_columns(); ++u) {
      if (!masks.tint_tiles[masks.tint_tile_index(place, size_t{v} * masks.tint_columns() + u)]) continue;
      x0 = std::min(x0, u * side), x1 = std::max(x1, std::min((u + 1) * side, masks.width));
      y0 = std::min(y0, v * side), y1 = std::max(y1, std::min((v + 1) * side, masks.height));
    }
  return x1 > x0 ? Rectangle{x0, y0, x1 - x0, y1 - y0} : Rectangle{};
}

Rectangle around(const Rectangle& a, const Rectangle& b) {
  if (a.width == 0) return b;
  if (b.width == 0) return a;
  const uint32_t x0 = std::min(a.x, b.x), y0 = std::min(a.y, b.y);
  return {x0, y0, std::max(a.x + a.width, b.x + b.width) - x0, std::max(a.y + a.height, b.y + b.height) - y0};
}

}  // namespace

bool MaskTextures::Storage::fits(const rt::OcclusionMasks& masks) const {
  return width == masks.width && height == masks.height && layers == masks.layers && tints == masks.tints &&
         bool(ambient) != masks.open.empty() && bool(depth) != masks.depth.empty() && (answers || masks.answers.empty());
}

void MaskTextures::Storage::abandon() {
  shadow.abandon(), ambient.abandon(), tint.abandon(), depth.abandon(), answers.abandon();
  width = height = layers = tints = 0;
  tinted.clear();
}

void MaskTextures::prepare(const gl::Functions& gl, const rt::OcclusionMasks& masks) {
  if (now_.fits(masks) || next_.fits(masks)) return;
  next_ = {};
  Storage made;
  made.width = masks.width, made.height = masks.height, made.layers = masks.layers, made.tints = masks.tints;
  made.tinted.resize(made.tints);
  const auto width = static_cast<GLsizei>(made.width), height = static_cast<GLsizei>(made.height);
  if (made.layers > 0) made.shadow = gl::Texture(gl);
  if (!masks.open.empty()) made.ambient = gl::Texture(gl);
  if (!masks.depth.empty()) made.depth = gl::Texture(gl);
  if (!masks.answers.empty()) made.answers = gl::Texture(gl);
  gl.BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
  const auto make_array = [&](const gl::Texture& texture, uint32_t layers) {
    if (!texture) return;
    gl.BindTexture(GL_TEXTURE_2D_ARRAY, texture.id());
    set_nearest(gl, GL_TEXTURE_2D_ARRAY);
    gl.TexImage3D(GL_TEXTURE_2D_ARRAY, 0, GL_R8, width, height, static_cast<GLsizei>(layers), 0, GL_RED,
                  GL_UNSIGNED_BYTE, nullptr);
  };
  if (made.tints > 0) made.tint = gl::Texture(gl);
  make_array(made.shadow, made.layers);
  make_array(made.tint, 3 * made.tints);
  const auto make_plane = [&](const gl::Texture& texture, const TexelFormat& format) {
    if (!texture) return;
    gl.BindTexture(GL_TEXTURE_2D, texture.id());
    set_nearest(gl, GL_TEXTURE_2D);
    gl.TexImage2D(GL_TEXTURE_2D, 0, static_cast<GLint>(format.internal), width, height, 0, format.format, format.type, nullptr);
  };
  make_plane(made.ambient, byte1);
  make_plane(made.depth, single);
  make_plane(made.answers, byte1);
  if (gl.GetError() != GL_NO_ERROR)
    fail(SIDERAY_OUT_OF_MEMORY, "masks of {}x{}, {} layers: the driver has no room; lower the resolution", masks.width,
         masks.height, masks.layers);
  next_ = std::move(made);
}

uint64_t MaskTextures::upload(const gl::Functions& gl, const rt::OcclusionMasks& masks, const Held& held,
                              const rt::WantedTiles* wanted, const UploadWay& way) {
  prepare(gl, masks);
  const bool is_new = !now_.fits(masks);
  if (is_new) now_ = std::exchange(next_, {});
  std::vector<TexturePiece> pieces;
  const Rectangle all{0, 0, masks.width, masks.height};
  std::vector<Rectangle> parts{all};
  if (wanted && !wanted->tiles.empty() && !is_new) parts = rectangles_around(gl, wanted->tiles, all.width, all.height);
  bool all_held = !is_new;
  for (uint32_t layer = 0; layer < masks.layers; ++layer) {
    if (!is_new && held(layer)) continue;
    all_held = false;
    const auto* texels = reinterpret_cast<const std::byte*>(&masks.lit[size_t{layer} * all.width * all.height]);
    for (const Rectangle& part : parts)
      pieces.push_back({GL_TEXTURE_2D_ARRAY, now_.shadow.id(), layer, byte1, part, texels, all.width});
  }
  for (uint32_t layer = 0; layer < masks.layers && masks.tints > 0; ++layer) {
    const uint32_t place = masks.tint_places[layer];
    if (place == 0 || (!is_new && held(layer))) continue;
    const Rectangle tinted = tinted_part(masks, place);
    const Rectangle part = is_new ? all : around(now_.tinted[place - 1], tinted);
    now_.tinted[place - 1] = tinted;
    for (uint32_t c = 0; part.width > 0 && c < 3; ++c) {
      const auto* texels = reinterpret_cast<const std::byte*>(masks.tint_plane(place, c).data());
      pieces.push_back({GL_TEXTURE_2D_ARRAY, now_.tint.id(), 3 * (place - 1) + c, byte1, part, texels, all.width});
    }
  }
  const auto add_plane = [&](const gl::Texture& texture, const TexelFormat& format, const void* texels) {
    for (const Rectangle& part : parts)
      pieces.push_back({GL_TEXTURE_2D, texture.id(), 0, format, part, static_cast<const std::byte*>(texels), all.width});
  };
  if (now_.ambient && (is_new || !held(masks.layers))) {
    all_held = false;
    add_plane(now_.ambient, byte1, masks.open.data());
  }
  if (now_.depth && !all_held) add_plane(now_.depth, single, masks.depth.data());  // depth stays where all masks stay
  if (!masks.answers.empty()) add_plane(now_.answers, byte1, masks.answers.data());
  return upload_.send(gl, pieces, way);
}

void MaskTextures::abandon() {
  now_.abandon(), next_.abandon();
  upload_.abandon();
}

}  // namespace sideray::bridge
