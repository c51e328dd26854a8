#include "rt/composite/composite_sink.h"

#include <algorithm>
#include <array>

#include "rt/base/half_bits.h"
#include "rt/layers/frame_tiles.h"

namespace sideray::rt {
namespace {

constexpr uint16_t half_one = 0x3c00;
constexpr float least_transmittance = 1e-4f;

}  // namespace

void begin_composite(const LayerRequest& request, const std::vector<uint8_t>& tiles, Executor& executor,
                     CompositeImage& image) {
  const bool fresh =
      image.width != request.width || image.height != request.height || image.traced_tiles.size() != tiles.size();
  if (fresh) {
    const size_t texels = size_t{request.width} * request.height;
    image.width = request.width;
    image.height = request.height;
    image.radiance.resize(4 * texels);
    image.transmittance.resize(4 * texels);
  }
  image.half_difference.assign(request.light_samples > 0 ? size_t{request.width} * request.height : 0, glm::vec3(0.0f));
  mark_tiles(fresh, tiles, {}, image.traced_tiles, image.dirty_tiles);
  for_tile_rows(request.width, request.height, image.dirty_tiles, executor, [&](size_t first, uint32_t count) {
    // Nothing is refracted here: alpha is 1, as store_refracted() stores it.
    for (size_t texel = first; texel < first + count; ++texel)
      std::copy_n(std::array<uint16_t, 4>{0, 0, 0, half_one}.begin(), 4, &image.radiance[4 * texel]);
    std::fill_n(image.transmittance.begin() + static_cast<ptrdiff_t>(4 * first), 4 * size_t{count}, half_one);
  });
}

void CompositeSink::begin(std::span<const PixelRequest> pixels) {
  pixels_.assign(pixels.size(), {glm::vec3(0.0f), glm::vec3(0.0f), glm::vec3(1.0f)});
}

bool CompositeSink::meet(uint32_t pixel, const SurfacePoint& point, const RayHit&, glm::vec3& weight) {
  const shading::SrBlend blend = blend_of(point);
  weight = pixels_[pixel].transmittance * blend.cover;
  pixels_[pixel].transmittance *= blend.through;
  return blend.cover > 0.0f;
}

void CompositeSink::add(uint32_t pixel, uint32_t, const Hit&, const glm::vec3* radiance, glm::vec3 weight) {
  Pixel& p = pixels_[pixel];
  if (!exact_) {
    p.radiance += *radiance * weight;
    return;
  }
  p.radiance += 0.5f * (radiance[0] + radiance[1]) * weight;
  p.half_difference += 0.5f * (radiance[0] - radiance[1]) * weight;
}

bool CompositeSink::finished(uint32_t pixel) const {
  const glm::vec3 t = pixels_[pixel].transmittance;
  const float most = std::max({t.x, t.y, t.z});
  return exact_ ? most <= 0.0f : most < least_transmittance;
}

void CompositeSink::end(std::span<const PixelRequest> pixels) {
  for (size_t i = 0; i < pixels.size(); ++i) {
    const size_t texel = 4 * (size_t{pixels[i].y} * image_.width + pixels[i].x);
    store_rgba(&image_.radiance[texel], pixels_[i].radiance, 1.0f);
    store_rgba(&image_.transmittance[texel], pixels_[i].transmittance, 1.0f);
    if (exact_) image_.half_difference[texel / 4] = pixels_[i].half_difference;
  }
}

void store_refracted(std::span<const PixelRequest> pixels, const std::vector<RefractedPixel>& seen, bool exact,
                     CompositeImage& image) {
  for (size_t i = 0; i < pixels.size(); ++i) {
    const size_t texel = size_t{pixels[i].y} * image.width + pixels[i].x;
    const RefractedPixel& p = seen[i];
    const float sky = (p.sky.x + p.sky.y + p.sky.z) / 3.0f;
    store_rgba(&image.radiance[4 * texel], exact ? 0.5f * (p.radiance[0] + p.radiance[1]) : p.radiance[0], 1.0f - sky);
    store_rgba(&image.transmittance[4 * texel], p.transmittance, 1.0f);
    if (exact) image.half_difference[texel] = 0.5f * (p.radiance[0] - p.radiance[1]);
  }
}

}  // namespace sideray::rt
