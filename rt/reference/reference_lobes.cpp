#include "rt/reference/reference_lobes.h"

#include <algorithm>
#include <cmath>

#include "rt/base/sampling.h"
#include "rt/base/largest.h"
#include "rt/textures/environment_lookup.h"

namespace sideray::rt {
namespace {

// The cosine to the eye is at least this when visible normals are sampled.
constexpr float least_cosine = 1e-3f;

glm::vec3 to_frame(const model::Frame& frame, glm::vec3 v) {
  return {glm::dot(frame.x, v), glm::dot(frame.y, v), glm::dot(frame.z, v)};
}

}  // namespace

LobeSampler::Lobe::Lobe(const model::Frame& about, glm::vec3 eye, glm::vec2 alphas)
    : frame(about), to_eye(to_frame(frame, eye)), alpha(alphas), faces_eye(to_eye.z > least_cosine) {}

glm::vec3 LobeSampler::Lobe::sample(glm::vec2 u) const {
  if (!faces_eye) return frame.world(sample_cosine(u));
  const glm::vec3 h = sample_visible_normal(to_eye, alpha, u);
  const glm::vec3 l = 2.0f * glm::dot(to_eye, h) * h - to_eye;
  return l.z > 0.0f ? glm::normalize(frame.world(l)) : glm::vec3(0.0f);
}

float LobeSampler::Lobe::density(glm::vec3 to_light) const {
  const glm::vec3 l = to_frame(frame, to_light);
  if (l.z <= 0.0f) return 0.0f;
  if (!faces_eye) return cosine_density(l.z);
  return visible_reflection_density(to_eye, glm::normalize(to_eye + l), alpha);
}

LobeSampler::LobeSampler(const SurfacePoint& point)
    : base_(frame_of_base(point.surface), point.to_eye, alphas_of_base(point.surface)),
      coat_(model::Frame(point.surface.coat_normal), point.to_eye,
            glm::vec2(point.surface.coat_roughness * point.surface.coat_roughness)) {
  const shading::SrSurface& s = point.surface;
  const float below = s.below_sheen * (1.0f - s.coat_share);
  shares_[diffuse] = largest(s.diffuse) * below + largest(s.sheen) * s.sheen_albedo * (1.0f - s.coat_share);
  shares_[behind] = largest(s.behind) * below;
  shares_[base] = largest(shading::sr_specular_albedo(s)) * below;
  shares_[coat] = s.coat_share;
  glossy_albedo_ = shares_[base] + shares_[coat];
  float sum = 0.0f;
  for (const float share : shares_) sum += share;
  albedo_ = sum;
  if (sum <= 0.0f) return;
  // Every reflecting lobe gets at least this share before shares are normalized.
  constexpr float least_share = 0.05f;
  float all = 0.0f;
  for (float& share : shares_) all += share = share > 0.0f ? std::max(share / sum, least_share) : 0.0f;
  for (float& share : shares_) share /= all;
}

glm::vec3 LobeSampler::sample(glm::vec2 u) const {
  int lobe = 0;
  while (lobe < lobes - 1 && u.x >= shares_[lobe]) u.x -= shares_[lobe++];
  if (!(shares_[lobe] > 0.0f)) return glm::vec3(0.0f);
  u.x = std::min(u.x / shares_[lobe], 0x1.fffffep-1f);  // uniform again
  if (lobe == base) return base_.sample(u);
  if (lobe == coat) return coat_.sample(u);
  const glm::vec3 about_normal = sample_cosine(u);
  return base_.frame.world(lobe == diffuse ? about_normal : -about_normal);
}

float LobeSampler::density(glm::vec3 to_light) const {
  const float cosine = glm::dot(base_.frame.z, to_light);
  float sum = cosine > 0.0f ? shares_[diffuse] * cosine_density(cosine) : shares_[behind] * cosine_density(-cosine);
  if (shares_[base] > 0.0f) sum += shares_[base] * base_.density(to_light);
  if (shares_[coat] > 0.0f) sum += shares_[coat] * coat_.density(to_light);
  return sum;
}

}  // namespace sideray::rt
