#include "rt/composite/filtered_sink.h"

#include <half.h>

#include <algorithm>
#include <utility>

#include "rt/base/half_bits.h"

namespace sideray::rt {
namespace {

constexpr float least_seen_through = 1e-4f;  // smallest transmittance that matters, as in CompositeSink

}  // namespace

void FilteredSurfaces::begin(uint32_t width, uint32_t height, size_t chunks, bool filters) {
  waiting_.resize(filters ? chunks : 0);
  for (std::vector<Pixel>& pixels : waiting_) pixels.clear();
  filter_.begin(waiting_.size());
  if (!filters) return;
  shown_.width = width;
  shown_.height = height;
  shown_.layers = most;
  shown_.radiance.resize(size_t{4} * most * width * height);
}

void FilteredSurfaces::add(size_t chunk, const Rough& rough) {
  const uint32_t texel = rough.number * shown_.width * shown_.height + rough.pixel;
  store_rgba(&shown_.radiance[size_t{4} * texel], rough.radiance, 1.0f);
  filter_.chunk(chunk).add(rough.pixel, texel, rough.surface_id, rough.point, rough.radiance, rough.reflection);
}

void FilteredSurfaces::finish(Executor& executor, CompositeImage& image) {
  if (!filters()) return;
  filter_.apply(executor, shown_);
  const size_t plane = size_t{shown_.width} * shown_.height;
  executor.run(waiting_.size(), [&](size_t chunk, uint32_t) {
    for (const Pixel& p : waiting_[chunk]) {
      glm::vec3 sum = p.rest;
      for (uint32_t k = 0; k < p.surfaces; ++k) {
        const uint16_t* halfs = &shown_.radiance[4 * (k * plane + p.texel)];
        sum += p.weights[k] * glm::vec3(imath_half_to_float(halfs[0]), imath_half_to_float(halfs[1]),
                                        imath_half_to_float(halfs[2]));
      }
      store_rgba(&image.radiance[size_t{4} * p.texel], sum, 1.0f);
    }
  });
}

void FilteredSink::begin(std::span<const PixelRequest> pixels) {
  requests_ = pixels;
  pixels_.resize(pixels.size());
  for (Pixel& p : pixels_) {
    p.radiance = glm::vec3(0.0f);
    p.transmittance = glm::vec3(1.0f);
    p.rough = 0;
  }
}

// For a refracting surface, cover and transmittance are part of its resolved light.
bool FilteredSink::meet(uint32_t pixel, const SurfacePoint& point, const RayHit& met, glm::vec3& weight) {
  Pixel& p = pixels_[pixel];
  if (!bends_.empty() && bends_[snapshot_.instances[met.hit.instance].material] != 0) {
    weight = std::exchange(p.transmittance, glm::vec3(0.0f));
    return true;
  }
  const shading::SrBlend blend = blend_of(point);
  weight = p.transmittance * blend.cover;
  p.transmittance *= blend.through;
  return blend.cover > 0.0f;
}

void FilteredSink::add(uint32_t pixel, uint32_t layer, const Hit&, const glm::vec3* radiance, glm::vec3 weight) {
  Pixel& p = pixels_[pixel];
  p.radiance += *radiance * weight;
  if (layer < Pixel::most_told) p.weights[layer] = weight;
}

// Subtracts the surface's light, which add() has just added, because it waits for the filter.
void FilteredSink::add_rough(uint32_t pixel, uint32_t layer, const SurfacePoint& point, glm::vec3 radiance,
                             const RoughReflection& rough) {
  if (!surfaces_.filters() || layer >= Pixel::most_told) return;
  Pixel& p = pixels_[pixel];
  uint32_t surface = 0;
  while (surface < p.rough && p.layers[surface] != layer) ++surface;
  if (surface == FilteredSurfaces::most) return;
  if (surface == p.rough) {
    p.layers[p.rough++] = layer;
    p.radiance -= radiance * p.weights[layer];
  }
  const uint32_t surface_id = snapshot_.instances[point.hit.instance].surface_id;
  surfaces_.add(chunk_, {texel_of(requests_[pixel]), surface, surface_id, point, radiance, rough});
}

bool FilteredSink::finished(uint32_t pixel) const {
  const glm::vec3 t = pixels_[pixel].transmittance;
  return std::max({t.x, t.y, t.z}) < least_seen_through;
}

void FilteredSink::end(std::span<const PixelRequest> pixels) {
  for (size_t i = 0; i < pixels.size(); ++i) {
    const Pixel& p = pixels_[i];
    const uint32_t texel = texel_of(pixels[i]);
    store_rgba(&image_.radiance[size_t{4} * texel], p.radiance, 1.0f);
    store_rgba(&image_.transmittance[size_t{4} * texel], p.transmittance, 1.0f);
    if (p.rough == 0) continue;
    FilteredSurfaces::Pixel waits{texel, p.rough, p.radiance, {}};
    for (uint32_t k = 0; k < p.rough; ++k) waits.weights[k] = p.weights[p.layers[k]];
    surfaces_.wait(chunk_, waits);
  }
}

}  // namespace sideray::rt
