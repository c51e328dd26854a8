#include "bridge/jobs/layers/layer_textures.h"

#include <algorithm>
#include <span>
#include <utility>

#include "bridge/transport/tile_rectangles.h"
#include "model/failure.h"

namespace sideray::bridge {
namespace {

constexpr uint32_t tile_size = rt::LayerCache::tile_size;

void check_storage(const gl::Functions& gl, const char* what, uint32_t width, uint32_t height) {
  if (gl.GetError() != GL_NO_ERROR)
    fail(SIDERAY_OUT_OF_MEMORY, "{}: the driver has no room for {}x{}; lower the resolution or the number of layers",
         what, width, height);
}

void set_nearest(const gl::Functions& gl, GLenum target) {
  gl.TexParameteri(target, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  gl.TexParameteri(target, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  gl.TexParameteri(target, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  gl.TexParameteri(target, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  gl.TexParameteri(target, GL_TEXTURE_MAX_LEVEL, 0);
}

void allocate_array(const gl::Functions& gl, gl::Texture& texture, const TexelFormat& format,
                    const rt::LayerCache& cache) {
  texture = gl::Texture(gl);
  gl.BindTexture(GL_TEXTURE_2D_ARRAY, texture.id());
  set_nearest(gl, GL_TEXTURE_2D_ARRAY);
  gl.TexImage3D(GL_TEXTURE_2D_ARRAY, 0, static_cast<GLint>(format.internal), static_cast<GLsizei>(cache.width),
                static_cast<GLsizei>(cache.height), static_cast<GLsizei>(cache.layers), 0, format.format, format.type,
                nullptr);
  check_storage(gl, "layer cache", cache.width, cache.height);
}

template <typename Image>
void allocate_image(const gl::Functions& gl, gl::Texture& texture, const Image& image) {
  texture = gl::Texture(gl);
  gl.BindTexture(GL_TEXTURE_2D, texture.id());
  set_nearest(gl, GL_TEXTURE_2D);
  gl.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA16F, static_cast<GLsizei>(image.width), static_cast<GLsizei>(image.height), 0,
                GL_RGBA, GL_HALF_FLOAT, nullptr);
  check_storage(gl, "composite image", image.width, image.height);
}

const TexelFormat& ids_of(const LayerEncoding& encoding) {
  return encoding.float_ids ? single : id32;
}

// Counts the layers of each dirty tile, up to the last one with a distance.
void count_tile_layers(const rt::LayerCache& cache, const std::vector<uint8_t>& dirty, std::vector<uint8_t>& counts,
                       rt::Executor& executor) {
  const uint32_t columns = (cache.width + tile_size - 1) / tile_size;
  const auto holds = [&](size_t tile, uint32_t layer) {
    const uint32_t x = static_cast<uint32_t>(tile % columns) * tile_size;
    const uint32_t y = static_cast<uint32_t>(tile / columns) * tile_size;
    const uint32_t width = std::min(tile_size, cache.width - x), bottom = std::min(y + tile_size, cache.height);
    for (uint32_t row = y; row < bottom; ++row) {
      const float* first = &cache.distance[(size_t{layer} * cache.height + row) * cache.width + x];
      if (std::any_of(first, first + width, [](float d) { return d != 0.0f; })) return true;
    }
    return false;
  };
  executor.run(dirty.size() / columns, [&](size_t row, uint32_t) {
    for (size_t tile = row * columns; tile < (row + 1) * columns; ++tile) {
      if (!dirty[tile]) continue;
      uint32_t count = cache.layers;
      while (count > 0 && !holds(tile, count - 1)) --count;
      counts[tile] = static_cast<uint8_t>(count);
    }
  });
}

bool has_whole(const rt::LayerCache& cache, size_t tile) {
  const uint32_t columns = (cache.width + tile_size - 1) / tile_size;
  const uint32_t x = static_cast<uint32_t>(tile % columns) * tile_size;
  const uint32_t y = static_cast<uint32_t>(tile / columns) * tile_size;
  const uint32_t right = std::min(x + tile_size, cache.width), bottom = std::min(y + tile_size, cache.height);
  for (uint32_t row = y; row < bottom; ++row)
    for (uint32_t column = x; column < right; ++column)
      if (cache.whole_transmittance[4 * (size_t{row} * cache.width + column) + 3] != 0) return true;
  return false;
}

float float_id(uint32_t id) {
  if (id >= 1u << 24)
    fail(SIDERAY_UNSUPPORTED, "surface id {}: floats hold ids below 16777216 alone; give smaller ones", id);
  return static_cast<float>(id);
}

template <typename T>
const std::byte* layer_of(const std::vector<T>& texels, const rt::LayerCache& cache, uint32_t layer) {
  return reinterpret_cast<const std::byte*>(texels.data() + texels.size() / cache.layers * layer);
}

}  // namespace

bool CacheTextures::Storage::fits(const rt::LayerCache& cache, const LayerEncoding& wanted) const {
  return width == cache.width && height == cache.height && layers == cache.layers && encoding == wanted &&
         whole == !cache.whole_radiance.empty();
}

void CacheTextures::Storage::abandon() {
  for (gl::Texture* texture : {&radiance, &distance, &surface_id, &whole_radiance, &whole_transmittance})
    texture->abandon();
  width = height = layers = 0;
}

void CacheTextures::prepare(const gl::Functions& gl, const rt::LayerCache& cache, const LayerEncoding& encoding) {
  if (now_.fits(cache, encoding) || next_.fits(cache, encoding)) return;
  next_ = {};
  Storage storage;
  allocate_array(gl, storage.radiance, half4, cache);
  allocate_array(gl, storage.distance, single, cache);
  allocate_array(gl, storage.surface_id, ids_of(encoding), cache);
  storage.whole = !cache.whole_radiance.empty();
  if (storage.whole) allocate_image(gl, storage.whole_radiance, cache);
  if (storage.whole) allocate_image(gl, storage.whole_transmittance, cache);
  storage.width = cache.width, storage.height = cache.height, storage.layers = cache.layers;
  storage.encoding = encoding;
  next_ = std::move(storage);
}

uint64_t CacheTextures::bytes() const {
  const uint32_t texel = half4.bytes + single.bytes + ids_of(now_.encoding).bytes;
  return uint64_t{now_.width} * now_.height * (uint64_t{now_.layers} * texel + (now_.whole ? 2 * half4.bytes : 0));
}

CacheTextures::Texels CacheTextures::encode(const rt::LayerCache& cache, const LayerEncoding& encoding, uint32_t layer,
                                            const std::vector<Rectangle>& rectangles) {
  Texels texels{layer_of(cache.radiance, cache, layer), layer_of(cache.surface_id, cache, layer)};
  const size_t first = size_t{layer} * cache.width * cache.height;
  const auto for_rows = [&](const auto& work) {
    for (const Rectangle& r : rectangles)
      for (uint32_t y = r.y; y < r.y + r.height; ++y) work(first + size_t{y} * cache.width + r.x, size_t{r.width});
  };
  if (encoding.changes_radiance()) {
    encoded_radiance_.resize(cache.radiance.size());
    for_rows([&](size_t texel, size_t count) {
      radiance_table_.encode(&cache.radiance[4 * texel], &encoded_radiance_[4 * texel], count, encoding);
    });
    texels.radiance = layer_of(encoded_radiance_, cache, layer);
  }
  if (encoding.float_ids) {
    encoded_ids_.resize(cache.surface_id.size());
    for_rows([&](size_t texel, size_t count) {
      for (size_t i = texel; i < texel + count; ++i) encoded_ids_[i] = float_id(cache.surface_id[i]);
    });
    texels.surface_id = layer_of(encoded_ids_, cache, layer);
  }
  return texels;
}

uint64_t CacheTextures::upload(const gl::Functions& gl, const rt::LayerCache& cache, const LayerEncoding& encoding,
                               const UploadWay& way) {
  std::vector<uint8_t> dirty = cache.dirty_tiles;
  prepare(gl, cache, encoding);
  const bool replaces = !now_.fits(cache, encoding);
  const Storage& to = replaces ? next_ : now_;
  if (replaces || stale_) {
    dirty.assign(dirty.size(), 1);
    tile_layers_.assign(dirty.size(), static_cast<uint8_t>(to.layers));
    tile_whole_.assign(dirty.size(), 1);
  }
  const std::vector<uint8_t> before = tile_layers_;
  count_tile_layers(cache, dirty, tile_layers_, way.copiers);
  std::vector<TexturePiece> pieces;
  std::vector<uint8_t> holding(dirty.size()), held(dirty.size());
  for (uint32_t layer = 0; layer < to.layers; ++layer) {
    for (size_t tile = 0; tile < dirty.size(); ++tile) {
      holding[tile] = dirty[tile] && layer < tile_layers_[tile];
      held[tile] = dirty[tile] && layer < std::max(before[tile], tile_layers_[tile]);
    }
    const auto add = [&](const gl::Texture& texture, const TexelFormat& texel, const std::vector<Rectangle>& rectangles,
                         const std::byte* texels) {
      for (const Rectangle& r : rectangles)
        pieces.push_back({GL_TEXTURE_2D_ARRAY, texture.id(), layer, texel, r, texels, to.width});
    };
    const std::vector<Rectangle> filled = rectangles_around(gl, holding, to.width, to.height);
    const Texels texels = encode(cache, encoding, layer, filled);
    add(to.radiance, half4, filled, texels.radiance);
    add(to.surface_id, ids_of(encoding), filled, texels.surface_id);
    add(to.distance, single, rectangles_around(gl, held, to.width, to.height), layer_of(cache.distance, cache, layer));
  }
  if (to.whole) add_whole(gl, cache, to, dirty, way.copiers, pieces);
  // Nothing below fails.
  if (replaces) now_ = std::exchange(next_, {});
  stale_ = false;
  return upload_.send(gl, pieces, way);
}

// Adds the uploads of whole pixels. The transmittance tells which pixels are whole, so it is uploaded where some are or
// were. The radiance of other pixels is never read.
void CacheTextures::add_whole(const gl::Functions& gl, const rt::LayerCache& cache, const Storage& to,
                              const std::vector<uint8_t>& dirty, rt::Executor& executor,
                              std::vector<TexturePiece>& pieces) {
  std::vector<uint8_t> holding(dirty.size(), 0), held(dirty.size(), 0);
  executor.run(dirty.size(), [&](size_t tile, uint32_t) {
    if (!dirty[tile]) return;
    holding[tile] = has_whole(cache, tile);
    held[tile] = holding[tile] | tile_whole_[tile];
    tile_whole_[tile] = holding[tile];
  });
  const auto add = [&](const gl::Texture& texture, const std::vector<uint8_t>& tiles,
                       const std::vector<uint16_t>& halfs) {
    for (const Rectangle& r : rectangles_around(gl, tiles, to.width, to.height))
      pieces.push_back(
          {GL_TEXTURE_2D, texture.id(), 0, half4, r, reinterpret_cast<const std::byte*>(halfs.data()), to.width});
  };
  add(to.whole_radiance, holding, cache.whole_radiance);
  add(to.whole_transmittance, held, cache.whole_transmittance);
}

void CacheTextures::abandon() {
  now_.abandon(), next_.abandon();
  upload_.abandon();
}

void CompositeTextures::Storage::abandon() {
  radiance.abandon(), transmittance.abandon();
  width = height = 0;
}

void CompositeTextures::prepare(const gl::Functions& gl, const rt::CompositeImage& image) {
  if (now_.fits(image) || next_.fits(image)) return;
  next_ = {};
  Storage storage;
  allocate_image(gl, storage.radiance, image);
  allocate_image(gl, storage.transmittance, image);
  storage.width = image.width, storage.height = image.height;
  next_ = std::move(storage);
}

uint64_t CompositeTextures::upload(const gl::Functions& gl, const rt::CompositeImage& image, const UploadWay& way) {
  prepare(gl, image);
  if (!now_.fits(image)) now_ = std::exchange(next_, {}), stale_ = true;
  std::vector<Rectangle> rectangles = rectangles_around(gl, image.dirty_tiles, image.width, image.height);
  if (std::exchange(stale_, false)) rectangles = {{0, 0, image.width, image.height}};
  std::vector<TexturePiece> pieces;
  const auto add = [&](const gl::Texture& texture, const std::vector<uint16_t>& halfs) {
    for (const Rectangle& r : rectangles)
      pieces.push_back(
          {GL_TEXTURE_2D, texture.id(), 0, half4, r, reinterpret_cast<const std::byte*>(halfs.data()), image.width});
  };
  add(now_.radiance, image.radiance);
  add(now_.transmittance, image.transmittance);
  return upload_.send(gl, pieces, way);
}

void CompositeTextures::abandon() {
  now_.abandon(), next_.abandon();
  upload_.abandon();
}

}  // namespace sideray::bridge
