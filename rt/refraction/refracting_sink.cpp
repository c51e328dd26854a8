#include "rt/refraction/refracting_sink.h"

#include "rt/base/sampling.h"

namespace sideray::rt {

bool RefractingSink::bends(const Hit& hit) const {
  return context_.scene->bends[context_.scene->surfaces.snapshot->instances[hit.instance].material] != 0;
}

void RefractingSink::begin(std::span<const PixelRequest> pixels) {
  scratch_.bends.clear();
  scratch_.layers.clear();
  scratch_.rough.clear();
  scratch_.points.clear();
  scratch_.bend_of.assign(pixels.size(), RefractingScratch::none);
  pixels_ = pixels;
  straight_.begin(pixels);
}

bool RefractingSink::meet(uint32_t pixel, const SurfacePoint& point, const RayHit& met, glm::vec3& weight) {
  const bool wanted = straight_.meet(pixel, point, met, weight);
  if (!bends(met.hit)) return wanted;
  // If the eye is inside a medium, the surface is seen from behind, and refracted rays compute its reflection.
  const bool is_lit = wanted && context_.at_eye.empty();
  scratch_.bend_of[pixel] = static_cast<uint32_t>(scratch_.bends.size());
  const LayerRequest& request = *context_.frame->request;
  const uint32_t key = pixel_key(request.seed, context_.frame->position, pixels_[pixel].x, pixels_[pixel].y);
  const uint16_t x = pixels_[pixel].x, y = pixels_[pixel].y;
  scratch_.bends.push_back({met.hit, met.ray, context_.frame->view->cone(x, y), key, 0, {x, y}, is_lit});
  scratch_.layers.push_back({pixel, is_lit ? blend_of(point).cover : 0.0f});
  if (is_scattered(point)) {
    scratch_.layers.back().point = static_cast<uint32_t>(scratch_.points.size());
    scratch_.points.push_back(point);
  }
  return true;
}

void RefractingSink::add(uint32_t pixel, uint32_t layer, const Hit& hit, const glm::vec3* radiance, glm::vec3 weight) {
  if (!bends(hit)) return straight_.add(pixel, layer, hit, radiance, weight);
  RefractingScratch::Layer& bent = scratch_.layers[scratch_.bend_of[pixel]];
  scratch_.bends[scratch_.bend_of[pixel]].before = layer;
  bent.layer = layer;
  bent.radiance = *radiance * bent.cover;
  bent.weight = weight;
}

void RefractingSink::add_rough(uint32_t pixel, uint32_t layer, const SurfacePoint& point, glm::vec3 radiance,
                               const RoughReflection& rough) {
  const uint32_t bend = scratch_.bend_of[pixel];
  if (bend == RefractingScratch::none || scratch_.layers[bend].layer != layer)
    return straight_.add_rough(pixel, layer, point, radiance, rough);
  RefractingScratch::Layer& bent = scratch_.layers[bend];
  bent.rough = static_cast<uint32_t>(scratch_.rough.size());
  scratch_.rough.push_back({point, rough});
  scratch_.rough.back().reflection.weight *= bent.cover;
}

void RefractingSink::end(std::span<const PixelRequest> pixels) {
  if (!scratch_.bends.empty()) {
    const TraceEnd end = scratch_.tracer.follow(context_, scratch_.bends, shader_, scratch_.seen, counters_);
    if (end != TraceEnd::complete) return;
    for (size_t i = 0; i < scratch_.bends.size(); ++i)
      resolve_layer(scratch_.layers[i], scratch_.bends[i].hit, scratch_.seen[i]);
    counters_.layers_refracted += scratch_.bends.size();
  }
  straight_.end(pixels);
}

void RefractingSink::resolve_layer(const RefractingScratch::Layer& layer, const Hit& hit, const RefractedPixel& seen) {
  const glm::vec3 radiance = layer.radiance + seen.radiance[0];
  straight_.add(layer.pixel, layer.layer, hit, &radiance, layer.weight);
  if (layer.rough != RefractingScratch::none) {
    const RefractingScratch::Rough& rough = scratch_.rough[layer.rough];
    straight_.add_rough(layer.pixel, layer.layer, rough.point, radiance, rough.reflection);
  }
  if (seen.roughness > 0.0f && layer.point != RefractingScratch::none)
    straight_.add_rough(layer.pixel, layer.layer, scratch_.points[layer.point], radiance,
                        {seen.radiance[0], glm::vec3(1.0f), seen.roughness, seen.nearness, seen.spread, true});
  straight_.resolve(layer.pixel, layer.layer);
}

}  // namespace sideray::rt
