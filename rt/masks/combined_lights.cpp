#include "rt/masks/combined_lights.h"

#include <algorithm>
#include <limits>

#include "rt/base/sampling.h"

namespace sideray::rt {
namespace {

// A point examines every candidate after so many tries, because bounds may be loose, as around a light.
constexpr uint32_t most_tries = 24;
// Rounding may lift a weight above its bound by this factor.
constexpr float bound_margin = 1.0f + 0x1p-16f;
constexpr float least_distance = 1e-4f;  // as in shading::sr_incidence()

float sum_of(const glm::vec3& v) {
  return v.x + v.y + v.z;
}

// Returns the distance of a point from a box, 0 inside.
float distance_to_box(const glm::vec3& p, const glm::vec3& least, const glm::vec3& most) {
  return glm::length(p - glm::clamp(p, least, most));
}

}  // namespace

CombinedLights::CombinedLights(const ShadingScene& scene) {
  for (size_t i = 0; i < scene.lights.size(); ++i) {
    if (scene.light_numbers[i] < first_light) continue;
    lights_.push_back(scene.lights[i]);
    numbers_.push_back(scene.light_numbers[i]);
  }
}

float CombinedLights::weight(size_t light, const DepthPoint& point) const {
  const shading::SrIncidence in = shading::sr_incidence(lights_[light], point.front);
  return std::max(glm::dot(in.to_light, point.normal), 0.0f) * sum_of(in.irradiance);
}

float CombinedLights::bound(size_t light, const glm::vec3& least, const glm::vec3& most) const {
  const shading::SrLight& l = lights_[light];
  const float intensity = sum_of(l.intensity) * bound_margin;
  if (l.type == SIDERAY_LIGHT_DIRECTIONAL) return intensity;
  const float distance = distance_to_box(l.position, least, most);
  if (l.range > 0.0f && distance >= l.range) return 0.0f;
  const float nearest = std::max(distance, least_distance);
  return intensity / (nearest * nearest);
}

void CombinedLights::Block::begin(const CombinedLights& lights, std::span<const DepthPoint> points) {
  lights_ = &lights;
  candidates_.clear();
  bounds_.clear();
  sums_.clear();
  glm::vec3 least(std::numeric_limits<float>::infinity()), most(-least);
  for (const DepthPoint& p : points) {
    least = glm::min(least, p.front);
    most = glm::max(most, p.front);
  }
  double sum = 0.0;
  for (size_t i = 0; i < lights.lights_.size(); ++i) {
    const float bound = lights.bound(i, least, most);
    if (!(bound > 0.0f)) continue;
    candidates_.push_back(static_cast<uint32_t>(i));
    bounds_.push_back(bound);
    sums_.push_back(sum += double{bound});
  }
}

// A candidate is proposed by its bound and accepted with the probability weight / bound, so accepted ones are
// distributed by weight.
std::optional<uint32_t> CombinedLights::Block::draw(const DepthPoint& point, uint32_t key) {
  if (candidates_.empty()) return std::nullopt;
  for (uint32_t k = 0; k < most_tries; ++k) {
    const uint32_t x = random_key({key, k}), y = hash_bits(x);
    const double u = double{unit_float(x)} * sums_.back();
    const auto at = std::upper_bound(sums_.begin(), sums_.end(), u) - sums_.begin();
    const size_t i = std::min(static_cast<size_t>(at), candidates_.size() - 1);
    if (unit_float(y) * bounds_[i] < lights_->weight(candidates_[i], point)) return lights_->numbers_[candidates_[i]];
  }
  return draw_by_weight(point, unit_float(random_key({key, most_tries})));
}

std::optional<uint32_t> CombinedLights::Block::draw_by_weight(const DepthPoint& point, float u) {
  double sum = 0.0;
  weights_.clear();
  for (const uint32_t light : candidates_) {
    weights_.push_back(lights_->weight(light, point));
    sum += double{weights_.back()};
  }
  if (!(sum > 0.0)) return std::nullopt;
  double left = double{u} * sum;
  size_t drawn = 0;
  for (size_t i = 0; i < candidates_.size() && left >= 0.0; ++i) {
    if (!(weights_[i] > 0.0f)) continue;
    drawn = i;
    left -= double{weights_[i]};
  }
  return lights_->numbers_[candidates_[drawn]];
}

}  // namespace sideray::rt
