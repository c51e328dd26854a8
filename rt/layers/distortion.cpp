#include "rt/layers/distortion.h"

#include <algorithm>

namespace sideray::rt {

bool distorts(const model::Snapshot& snapshot) {
  return std::any_of(snapshot.instances.begin(), snapshot.instances.end(), [&](const model::Instance& i) {
    const model::Material& material = snapshot.materials[i.material];
    return material.translucent && material.desc.distortion > 0.0f;
  });
}

void DistortionSink::begin(std::span<const PixelRequest> pixels) {
  pixels_ = pixels;
  for (const PixelRequest& p : pixels) offset_of(p) = {};
}

bool DistortionSink::meet(uint32_t pixel, const SurfacePoint& point, const RayHit&, glm::vec3&) {
  if (!(point.distortion > 0.0f)) return false;
  const PixelRequest& p = pixels_[pixel];
  const Ray ray = view_.ray(p.x, p.y);
  PixelOffset& sum = offset_of(p);
  const glm::vec3 normal = point.surface.normal;
  sum.heights += point.distortion * glm::vec2(glm::dot(normal, view_.right()), glm::dot(normal, view_.up()));
  const float distance = glm::dot(point.position - ray.origin, ray.direction);
  sum.nearest = std::min(sum.nearest, view_.depth(p.x, p.y, double{distance}));
  return false;
}

// Does what shaders/translucent/raster_distort_picture.frag.glsl does for the rasterizer's picture.
OpaqueTexel distorted(const std::vector<OpaqueTexel>& picture, uint32_t width, uint32_t x, uint32_t y,
                      const PixelOffset& offset) {
  const OpaqueTexel& plain = picture[size_t{y} * width + x];
  if (!(glm::dot(offset.heights, offset.heights) < 1e12f) || offset.heights == glm::vec2(0.0f)) return plain;
  const glm::ivec2 last(static_cast<int>(width) - 1, static_cast<int>(picture.size() / width) - 1);
  const glm::vec2 at =
      glm::clamp(glm::vec2(x, y) + offset.heights * static_cast<float>(last.y + 1), glm::vec2(0.0f), glm::vec2(last));
  const glm::ivec2 corner(at);
  const glm::vec2 share = at - glm::vec2(corner);
  OpaqueTexel sum{};
  float total = 0.0f;
  for (const glm::ivec2 side : {glm::ivec2(0, 0), glm::ivec2(1, 0), glm::ivec2(0, 1), glm::ivec2(1, 1)}) {
    const glm::ivec2 where = glm::min(corner + side, last);
    const OpaqueTexel& texel = picture[static_cast<size_t>(where.y) * width + static_cast<size_t>(where.x)];
    if (texel.depth < offset.nearest) continue;
    const float weight = (side.x ? share.x : 1.0f - share.x) * (side.y ? share.y : 1.0f - share.y);
    for (int half = 0; half < 2; ++half) sum.radiance[half] += weight * texel.radiance[half];
    sum.coverage += weight * texel.coverage;
    total += weight;
  }
  if (total == 0.0f) return plain;
  for (glm::vec3& radiance : sum.radiance) radiance /= total;
  sum.coverage /= total;
  sum.depth = plain.depth;
  return sum;
}

}  // namespace sideray::rt
