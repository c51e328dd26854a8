#include "gl/scene/shadow_casters.h"

#include <algorithm>
#include <cmath>

namespace sideray::gl {
namespace {

// A lookup is offset by 1.6 texels from the surface, and its filter reaches 1.5 texels along both axes
// (raster_lighting.glsl): 3.8 together, and as much again for rounding.
constexpr float slack_texels = 8.0f;

float farthest(glm::vec3 p, const model::Bounds& bounds) {
  return glm::length(glm::max(glm::abs(bounds.minimum - p), glm::abs(bounds.maximum - p)));
}

float nearest(glm::vec3 p, const model::Bounds& bounds) {
  return glm::length(glm::max(glm::max(bounds.minimum - p, p - bounds.maximum), glm::vec3(0.0f)));
}

}  // namespace

Receivers make_receivers(const glm::dmat4& clip_from_local, const model::Bounds& bounds) {
  Receivers receivers{{}, bounds};
  const glm::dmat4 rows = glm::transpose(clip_from_local);
  for (const glm::dvec4& p : {rows[3] + rows[0], rows[3] - rows[0], rows[3] + rows[1], rows[3] - rows[1], rows[3]}) {
    const double length = glm::length(glm::dvec3(p));
    if (length > 1e-12 * std::abs(p.w)) receivers.planes.emplace_back(p / length);
  }
  for (int axis = 0; axis < 3; ++axis) {
    glm::vec4 low(0.0f, 0.0f, 0.0f, -bounds.minimum[axis]), high(0.0f, 0.0f, 0.0f, bounds.maximum[axis]);
    low[axis] = 1.0f;
    high[axis] = -1.0f;
    receivers.planes.push_back(low);
    receivers.planes.push_back(high);
  }
  return receivers;
}

ShadowCasters::ShadowCasters(const model::Light& light, const LightShadow& shadow, const Receivers& receivers)
    : light_(light.position), reach_(INFINITY) {
  const bool directional = light.type == SIDERAY_LIGHT_DIRECTIONAL;
  float slack = slack_texels * shadow.texel;  // of a local light: texels grow with the distance
  if (!directional) {
    const float to_receivers = farthest(light.position, receivers.bounds);
    const float used = light.range > 0.0f ? std::min(light.range, to_receivers) : to_receivers;
    slack *= used;
    reach_ = used + slack;
  }
  for (glm::vec4 plane : receivers.planes) {
    if (directional && glm::dot(glm::vec3(plane), light.direction) > 0.0f) continue;  // the light is far outside
    const float outside = directional ? 0.0f : -(glm::dot(glm::vec3(plane), light.position) + plane.w);
    plane.w += std::max(outside, 0.0f) + slack;
    planes_.push_back(plane);
  }
}

bool ShadowCasters::may_matter(const model::Bounds& caster) const {
  if (caster.empty() || nearest(light_, caster) > reach_) return false;
  return std::none_of(planes_.begin(), planes_.end(), [&](const glm::vec4& plane) {
    const glm::vec3 innermost =
        glm::mix(caster.minimum, caster.maximum, glm::greaterThan(glm::vec3(plane), glm::vec3(0)));
    return glm::dot(glm::vec3(plane), innermost) + plane.w < 0.0f;
  });
}

}  // namespace sideray::gl
