#include "rt/reference/lamp_guide.h"

#include <algorithm>
#include <cmath>

#include "model/hemisphere.h"
#include "rt/base/largest.h"
#include "rt/base/sampling.h"

namespace sideray::rt {

float LampGuide::aperture(uint32_t cone) {
  static const std::array<float, most_cones> apertures = [] {
    std::array<float, most_cones> all{};
    float angle = widest;
    for (float& a : all) a = cone_aperture(angle), angle *= 0.5f;
    return all;
  }();
  return apertures[cone];
}

void LampGuide::add(const ReferenceLight& light, const shading::SrIncidence& in) {
  const float weight = largest(in.irradiance);
  if (light.light.type == SIDERAY_LIGHT_DIRECTIONAL || !(weight > 0.0f) || !std::isfinite(weight)) return;
  // A narrower cone would contain only the lamp.
  uint32_t cones = 1;
  for (float angle = 0.5f * widest; cones < most_cones && angle * in.distance > 0.5f * light.radius; angle *= 0.5f) ++cones;
  const Lamp lamp{in.to_light, weight, cones};
  if (count_ < most_lamps) {
    lamps_[count_++] = lamp;
    sum_ += weight;
    return;
  }
  Lamp& least = *std::min_element(lamps_.begin(), lamps_.end(),
                                  [](const Lamp& a, const Lamp& b) { return a.weight < b.weight; });
  if (least.weight >= weight) return;
  least = lamp;
  sum_ = 0.0f;
  for (const Lamp& l : lamps_) sum_ += l.weight;
}

glm::vec3 LampGuide::sample(glm::vec2 u) const {
  float left = u.x * sum_;
  uint32_t chosen = 0;
  while (chosen + 1 < count_ && left >= lamps_[chosen].weight) left -= lamps_[chosen++].weight;
  const Lamp& lamp = lamps_[chosen];
  const float within = std::min(left / lamp.weight, 0x1.fffffep-1f) * static_cast<float>(lamp.cones);
  const uint32_t cone = std::min(static_cast<uint32_t>(std::max(within, 0.0f)), lamp.cones - 1);
  const glm::vec2 again(std::clamp(within - static_cast<float>(cone), 0.0f, 0x1.fffffep-1f), u.y);
  return glm::normalize(model::Frame(lamp.axis).world(sample_cone(again, aperture(cone))));
}

float LampGuide::density(glm::vec3 direction) const {
  float sum = 0.0f;
  for (uint32_t i = 0; i < count_; ++i) {
    const Lamp& lamp = lamps_[i];
    const float cosine = glm::dot(lamp.axis, direction);
    if (1.0f - cosine >= aperture(0)) continue;
    const glm::vec3 across = glm::cross(lamp.axis, direction);
    const float below = glm::dot(across, across) / (1.0f + cosine);  // 1 - cosine without cancellation
    float cones = 0.0f;
    for (uint32_t k = 0; k < lamp.cones && below < aperture(k); ++k) cones += 1.0f / cone_solid_angle(aperture(k));
    sum += lamp.weight / static_cast<float>(lamp.cones) * cones;
  }
  return sum_ > 0.0f ? sum / sum_ : 0.0f;
}

}  // namespace sideray::rt
