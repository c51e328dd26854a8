#include "rt/textures/environment_lookup.h"

#include <algorithm>
#include <cmath>

#include "shaders/shading/shading_cpp.h"

namespace sideray::rt {
namespace {

using Image = model::Environment::Image;

// Holds two neighbouring texels along one axis and the second one's weight.
struct Pair {
  size_t first, second;
  float weight;
};

// Clamps to 0..`largest`; NaN becomes 0, so that no look-up leaves its image.
float clamped(float x, float largest) {
  return x > 0.0f ? std::min(x, largest) : 0.0f;
}

Pair clamped_pair(float s, uint32_t size) {
  const float x = clamped(s * static_cast<float>(size) - 0.5f, static_cast<float>(size - 1));
  const auto i = static_cast<size_t>(x);
  return {i, std::min<size_t>(i + 1, size - 1), x - static_cast<float>(i)};
}

// `s` is within 0..1, or NaN.
Pair repeated_pair(float s, uint32_t size) {
  const float x = clamped(s, 1.0f) * static_cast<float>(size) - 0.5f;
  const float base = std::floor(x);
  const auto i = static_cast<int64_t>(base);
  const auto n = static_cast<int64_t>(size);
  const int64_t first = i < 0 ? i + n : i, second = i + 1 >= n ? i + 1 - n : i + 1;
  return {static_cast<size_t>(first), static_cast<size_t>(second), x - base};
}

template <typename T>
T blend(const std::vector<T>& texels, size_t width, Pair x, Pair y) {
  const T* row0 = texels.data() + y.first * width;
  const T* row1 = texels.data() + y.second * width;
  return glm::mix(glm::mix(row0[x.first], row0[x.second], x.weight), glm::mix(row1[x.first], row1[x.second], x.weight),
                  y.weight);
}

glm::vec3 sample(const Image& image, glm::vec2 uv) {
  return blend(image.texels, image.width, repeated_pair(uv.x, image.width), clamped_pair(uv.y, image.height));
}

}  // namespace

glm::vec3 environment_irradiance(const model::Environment& environment, glm::vec3 direction) {
  if (is_uniform(environment)) return environment.irradiance.texels[0];
  return sample(environment.irradiance, shading::sr_latlong(direction));
}

glm::vec3 environment_specular(const model::Environment& environment, glm::vec3 direction, float roughness) {
  if (is_uniform(environment)) return environment.specular[0].texels[0];
  return environment_specular_at(environment, {shading::sr_latlong(direction), roughness});
}

glm::vec3 environment_specular_at(const model::Environment& environment, const EnvironmentPlace& place) {
  if (is_uniform(environment)) return environment.specular[0].texels[0];
  const size_t last = environment.specular.size() - 1;
  const float level = clamped(place.roughness, 1.0f) * static_cast<float>(last);
  const auto below = static_cast<size_t>(level);
  const float weight = level - static_cast<float>(below);
  const glm::vec3 sharper = sample(environment.specular[below], place.uv);
  if (weight == 0.0f) return sharper;
  return glm::mix(sharper, sample(environment.specular[below + 1], place.uv), weight);
}

glm::vec2 albedo_terms(const model::AlbedoTable& table, float n_v, float roughness) {
  return glm::vec2(albedo_and_sheen(table, n_v, roughness));
}

glm::vec3 albedo_and_sheen(const model::AlbedoTable& table, float n_v, float roughness) {
  constexpr uint32_t size = model::AlbedoTable::size;
  // The ends of the range are texel centres.
  const auto place = [](float x) { return (x * static_cast<float>(size - 1) + 0.5f) * (1.0f / size); };
  return blend(table.values, size, clamped_pair(place(n_v), size), clamped_pair(place(roughness), size));
}

}  // namespace sideray::rt
