#include "rt/textures/texture_level.h"

#include <algorithm>
#include <cmath>

#include "elementary/functions.h"

namespace sideray::rt {
namespace {

constexpr float least_cosine = 1e-4f;  // limits the footprint of a grazing cone, which would be infinite

}  // namespace

TextureFootprint texture_footprint(glm::vec3 edge1, glm::vec3 edge2, glm::vec3 direction, float width,
                                   const PixelSteps* steps) {
  const glm::vec3 cross = glm::cross(edge1, edge2);
  const float squared_area = glm::dot(cross, cross);
  if (!(squared_area > 1e-36f)) return {glm::vec2(0.0f), glm::vec2(0.0f)};
  const glm::vec3 normal = cross * (1.0f / std::sqrt(squared_area));
  const float cosine = glm::dot(normal, direction);
  const glm::vec3 to_second = glm::cross(edge2, cross) * (1.0f / squared_area),
                  to_third = glm::cross(cross, edge1) * (1.0f / squared_area);
  const auto weights = [&](glm::vec3 v) { return glm::vec2(glm::dot(v, to_second), glm::dot(v, to_third)); };
  if (steps) {
    const float slope = 1.0f / (std::abs(cosine) > least_cosine ? cosine : least_cosine);
    const auto on_plane = [&](glm::vec3 step) { return (step - direction * (glm::dot(normal, step) * slope)) * width; };
    return {weights(on_plane(steps->right)), weights(on_plane(steps->up))};
  }
  const glm::vec3 slide = direction - normal * cosine;
  const float sine = glm::length(slide);
  // Seen head-on, all diameters are equal.
  const glm::vec3 along = sine > 1e-6f ? slide * (1.0f / sine) : glm::normalize(edge1);
  const glm::vec3 long_axis = along * (width / std::max(std::abs(cosine), least_cosine));
  const glm::vec3 short_axis = glm::cross(normal, along) * width;
  return {weights(long_axis), weights(short_axis)};
}

float texture_level(const TextureFootprint& footprint, glm::vec2 edge1, glm::vec2 edge2,
                    const sideray_texture_slot& slot, const model::Texture& texture) {
  const float* m = slot.texture_from_uv;
  const auto width = static_cast<float>(texture.levels[0].width), height = static_cast<float>(texture.levels[0].height);
  const auto squared_texels = [&](glm::vec2 step) {
    const glm::vec2 uv = edge1 * step.x + edge2 * step.y;
    const float s = (m[0] * uv.x + m[2] * uv.y) * width, t = (m[1] * uv.x + m[3] * uv.y) * height;
    return s * s + t * t;
  };
  const float squared = std::max(squared_texels(footprint.along), squared_texels(footprint.across));
  return squared > 1.0f ? 0.5f * elementary::log2(squared) : 0.0f;
}

}  // namespace sideray::rt
