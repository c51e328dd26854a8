// Shared code for tests of path-traced pictures: their mean and its error, and rooms of diffuse walls.
#pragma once

#include <gtest/gtest.h>

#include <cmath>

#include "rt/tracer_scene.h"

namespace sideray::rt::test {

constexpr uint32_t unlimited = 0;

struct PathOptions {
  uint32_t bounces = unlimited, size = 8, light_samples = 64, seed = 1, threads = 1;
  bool shadows = true, caustics = false;
};

inline ReferenceImage trace_paths(const std::shared_ptr<const model::Snapshot>& snapshot, std::vector<TraceView> views,
                                  const PathOptions& options) {
  Tracer tracer({.threads = options.threads, .isa = ""});
  tracer.set_scene(snapshot);
  ReferenceRequest request;
  request.views = std::move(views);
  request.width = request.height = options.size;
  request.light_samples = options.light_samples;
  request.bounces = options.bounces;
  request.shadows = options.shadows;
  request.caustics = options.caustics;
  request.refraction = true;
  request.seed = options.seed;
  ReferenceImage image;
  tracer.trace_reference(request, image);
  return image;
}

// Holds the mean over pixels and its standard error, from the independent halves of pixels.
struct Mean {
  double value = 0, deviation = 0;
};

// Of the pixels for which `counts(x, y)` holds.
template <typename Counts>
Mean mean_where(const ReferenceImage& image, const Counts& counts, int channel = 1) {
  Mean mean;
  double count = 0;
  for (uint32_t y = 0; y < image.height; ++y)
    for (uint32_t x = 0; x < image.width; ++x) {
      if (!counts(x, y)) continue;
      const size_t texel = size_t{y} * image.width + x;
      const double d = static_cast<double>(image.half_difference[texel][channel]);
      mean.value += static_cast<double>(image.color[texel][channel]);
      mean.deviation += d * d;
      ++count;
    }
  return {mean.value / count, std::sqrt(mean.deviation) / count};
}

inline Mean mean_of(const ReferenceImage& image, int channel = 1) {
  return mean_where(image, [](uint32_t, uint32_t) { return true; }, channel);
}

inline TraceView from_above(double height, double half_width, glm::dvec3 at = glm::dvec3(0)) {
  return perspective(at + glm::dvec3(0, height, 0), at, 2 * std::atan(half_width / height), 1.0, 1e-3);
}

inline sideray_material_desc diffuse(float albedo) {
  sideray_material_desc m = plain_material();
  m.base_color[0] = m.base_color[1] = m.base_color[2] = albedo;
  m.specular = 0.0f;
  return m;
}

inline sideray_material_desc shining(float albedo, float radiance) {
  sideray_material_desc m = diffuse(albedo);
  for (float& e : m.emissive) e = radiance;
  return m;
}

// The inside of a box from -1 to 1.
inline void add_room(TestScene& scene, const sideray_material_desc& material) {
  for (int axis = 0; axis < 3; ++axis)
    for (const float side : {-1.0f, 1.0f}) {
      glm::vec3 center(0.0f), u(0.0f), v(0.0f);
      center[axis] = side;
      u[(axis + 1) % 3] = 1.0f, v[(axis + 2) % 3] = 1.0f;
      scene.quad(center, u, v, material);
    }
}

}  // namespace sideray::rt::test
