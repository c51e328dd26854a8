#include "bridge/result_textures.h"

#include <algorithm>
#include <span>

#include "model/failure.h"

namespace sideray::bridge {
namespace {

constexpr uint32_t tile_size = rt::LayerCache::tile_size;

struct Rectangle {
  uint32_t x, y, width, height;
};

// The dirty tiles as rectangles: runs of neighbours in a row of tiles, and equal runs of neighbouring rows, become one.
std::vector<Rectangle> dirty_rectangles(std::span<const uint8_t> dirty, uint32_t width, uint32_t height) {
  const uint32_t columns = (width + tile_size - 1) / tile_size, rows = (height + tile_size - 1) / tile_size;
  std::vector<Rectangle> rectangles;
  for (uint32_t row = 0; row < rows; ++row)
    for (uint32_t first = 0; first < columns;) {
      if (!dirty[row * columns + first]) {
        ++first;
        continue;
      }
      uint32_t end = first;
      while (end < columns && dirty[row * columns + end]) ++end;
      const Rectangle run{first * tile_size, row * tile_size, std::min(end * tile_size, width) - first * tile_size,
                          std::min(tile_size, height - row * tile_size)};
      const auto above = std::find_if(rectangles.begin(), rectangles.end(), [&](const Rectangle& r) {
        return r.x == run.x && r.width == run.width && r.y + r.height == run.y;
      });
      if (above != rectangles.end())
        above->height += run.height;
      else
        rectangles.push_back(run);
      first = end;
    }
  return rectangles;
}

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

struct TexelFormat {
  GLenum internal, format, type;
  uint32_t bytes;
};
constexpr TexelFormat half4{GL_RGBA16F, GL_RGBA, GL_HALF_FLOAT, 8};
constexpr TexelFormat single{GL_R32F, GL_RED, GL_FLOAT, 4};
constexpr TexelFormat id32{GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, 4};

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

void allocate_image(const gl::Functions& gl, gl::Texture& texture, const rt::CompositeImage& image) {
  texture = gl::Texture(gl);
  gl.BindTexture(GL_TEXTURE_2D, texture.id());
  set_nearest(gl, GL_TEXTURE_2D);
  gl.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA16F, static_cast<GLsizei>(image.width), static_cast<GLsizei>(image.height), 0,
                GL_RGBA, GL_HALF_FLOAT, nullptr);
  check_storage(gl, "composite image", image.width, image.height);
}

void use_rows_of(const gl::Functions& gl, uint32_t width) {
  gl.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
  gl.PixelStorei(GL_UNPACK_ROW_LENGTH, static_cast<GLint>(width));
}

// `first_byte` + offset addresses texel (x, y) of layer 0; rows are the image's.
uint64_t upload_layers(const gl::Functions& gl, const gl::Texture& texture, const TexelFormat& format,
                       const void* texels, const rt::LayerCache& cache, const std::vector<Rectangle>& rectangles) {
  gl.BindTexture(GL_TEXTURE_2D_ARRAY, texture.id());
  uint64_t bytes = 0;
  for (const Rectangle& r : rectangles)
    for (uint32_t layer = 0; layer < cache.layers; ++layer) {
      const size_t first = (size_t{layer} * cache.height + r.y) * cache.width + r.x;
      gl.TexSubImage3D(GL_TEXTURE_2D_ARRAY, 0, static_cast<GLint>(r.x), static_cast<GLint>(r.y),
                       static_cast<GLint>(layer), static_cast<GLsizei>(r.width), static_cast<GLsizei>(r.height), 1,
                       format.format, format.type, static_cast<const std::byte*>(texels) + first * format.bytes);
      bytes += uint64_t{r.width} * r.height * format.bytes;
    }
  return bytes;
}

uint64_t upload_image(const gl::Functions& gl, const gl::Texture& texture, const uint16_t* halfs,
                      const rt::CompositeImage& image, const std::vector<Rectangle>& rectangles) {
  gl.BindTexture(GL_TEXTURE_2D, texture.id());
  uint64_t bytes = 0;
  for (const Rectangle& r : rectangles) {
    gl.TexSubImage2D(GL_TEXTURE_2D, 0, static_cast<GLint>(r.x), static_cast<GLint>(r.y), static_cast<GLsizei>(r.width),
                     static_cast<GLsizei>(r.height), GL_RGBA, GL_HALF_FLOAT,
                     halfs + 4 * (size_t{r.y} * image.width + r.x));
    bytes += uint64_t{r.width} * r.height * half4.bytes;
  }
  return bytes;
}

}  // namespace

uint64_t CacheTextures::upload(const gl::Functions& gl, const rt::LayerCache& cache) {
  std::vector<Rectangle> rectangles = dirty_rectangles(cache.dirty_tiles, cache.width, cache.height);
  if (width_ != cache.width || height_ != cache.height || layers_ != cache.layers) {
    allocate_array(gl, radiance_, half4, cache);
    allocate_array(gl, distance_, single, cache);
    allocate_array(gl, surface_id_, id32, cache);
    width_ = cache.width, height_ = cache.height, layers_ = cache.layers;
    bytes_ = uint64_t{width_} * height_ * layers_ * (half4.bytes + single.bytes + id32.bytes);
    rectangles = {{0, 0, width_, height_}};
  }
  use_rows_of(gl, width_);
  return upload_layers(gl, radiance_, half4, cache.radiance.data(), cache, rectangles) +
         upload_layers(gl, distance_, single, cache.distance.data(), cache, rectangles) +
         upload_layers(gl, surface_id_, id32, cache.surface_id.data(), cache, rectangles);
}

void CacheTextures::abandon() {
  radiance_.abandon(), distance_.abandon(), surface_id_.abandon();
  width_ = height_ = layers_ = 0;
}

uint64_t CompositeTextures::upload(const gl::Functions& gl, const rt::CompositeImage& image) {
  std::vector<Rectangle> rectangles = dirty_rectangles(image.dirty_tiles, image.width, image.height);
  if (width_ != image.width || height_ != image.height) {
    allocate_image(gl, radiance_, image);
    allocate_image(gl, transmittance_, image);
    width_ = image.width, height_ = image.height;
    bytes_ = uint64_t{width_} * height_ * 2 * half4.bytes;
    rectangles = {{0, 0, width_, height_}};
  }
  use_rows_of(gl, width_);
  return upload_image(gl, radiance_, image.radiance.data(), image, rectangles) +
         upload_image(gl, transmittance_, image.transmittance.data(), image, rectangles);
}

void CompositeTextures::abandon() {
  radiance_.abandon(), transmittance_.abandon();
  width_ = height_ = 0;
}

}  // namespace sideray::bridge
