// Makes points on the hemisphere for the integrals of image-based lighting. Any thread may call it.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <glm/gtc/constants.hpp>

#include "elementary/functions.h"

namespace sideray::model {

// Returns point i of n of the Hammersley set in [0,1)^2 (van der Corput in the second coordinate).
inline glm::vec2 hammersley(uint32_t i, uint32_t n) {
  uint32_t bits = i;
  bits = (bits << 16) | (bits >> 16);
  bits = ((bits & 0x55555555u) << 1) | ((bits & 0xaaaaaaaau) >> 1);
  bits = ((bits & 0x33333333u) << 2) | ((bits & 0xccccccccu) >> 2);
  bits = ((bits & 0x0f0f0f0fu) << 4) | ((bits & 0xf0f0f0f0u) >> 4);
  bits = ((bits & 0x00ff00ffu) << 8) | ((bits & 0xff00ff00u) >> 8);
  return {(static_cast<float>(i) + 0.5f) / static_cast<float>(n), static_cast<float>(bits >> 8) * 0x1p-24f};
}

// Returns a half vector about +Z with density D(h) n.h of the GGX distribution (Walter et al. 2007, section 5.2).
inline glm::vec3 sample_ggx(glm::vec2 point, float alpha) {
  const float azimuth = glm::two_pi<float>() * point.x;
  const float cosine = std::sqrt((1.0f - point.y) / (1.0f + (alpha * alpha - 1.0f) * point.y));
  const float sine = std::sqrt(std::max(0.0f, 1.0f - cosine * cosine));
  return {sine * elementary::cos(azimuth), sine * elementary::sin(azimuth), cosine};
}

// Maps a point of the unit square to the unit disc; an even distribution stays even.
struct DiscPoint {
  float radius, cosine, sine;
  explicit DiscPoint(glm::vec2 u)
      : radius(std::sqrt(u.x)),
        cosine(elementary::cos(glm::two_pi<float>() * u.y)),
        sine(elementary::sin(glm::two_pi<float>() * u.y)) {}
};

// Samples normals of microfacets that `to_eye` sees (Heitz 2018, "Sampling the GGX Distribution of Visible Normals").
// to_eye.z > 0; two alphas are along x and y.
struct VisibleNormals {
  glm::vec3 v, t1, t2;
  glm::vec2 alpha;
  float s;
  VisibleNormals(glm::vec3 to_eye, float alpha_) : VisibleNormals(to_eye, glm::vec2(alpha_)) {}
  VisibleNormals(glm::vec3 to_eye, glm::vec2 alpha_)
      : v(glm::normalize(glm::vec3(alpha_.x * to_eye.x, alpha_.y * to_eye.y, to_eye.z))), alpha(alpha_) {
    const float across2 = v.x * v.x + v.y * v.y;
    t1 = across2 > 0.0f ? glm::vec3(-v.y, v.x, 0.0f) * (1.0f / std::sqrt(across2)) : glm::vec3(1.0f, 0.0f, 0.0f);
    t2 = glm::cross(v, t1);
    s = 0.5f * (1.0f + v.z);
  }
  glm::vec3 normal(DiscPoint p) const {
    const float p1 = p.radius * p.cosine;
    const float p2 = (1.0f - s) * std::sqrt(std::max(1.0f - p1 * p1, 0.0f)) + s * p.radius * p.sine;
    const glm::vec3 n = p1 * t1 + p2 * t2 + std::sqrt(std::max(1.0f - p1 * p1 - p2 * p2, 0.0f)) * v;
    return glm::normalize(glm::vec3(alpha.x * n.x, alpha.y * n.y, std::max(n.z, 1e-6f)));
  }
};

inline glm::vec3 sample_visible_normal(glm::vec3 to_eye, glm::vec2 alpha, glm::vec2 u) {
  return VisibleNormals(to_eye, alpha).normal(DiscPoint(u));
}

inline glm::vec3 sample_visible_normal(glm::vec3 to_eye, float alpha, glm::vec2 u) {
  return sample_visible_normal(to_eye, glm::vec2(alpha), u);
}

inline float ggx_density(float n_h, float alpha) {
  const float f = n_h * n_h * (alpha * alpha - 1.0f) + 1.0f;
  return alpha * alpha / (glm::pi<float>() * f * f);
}

// Describes a right-handed frame about a unit vector (Duff et al. 2017).
struct Frame {
  glm::vec3 x, y, z;
  // `along`: unit and perpendicular to the normal.
  Frame(glm::vec3 n, glm::vec3 along) : x(along), y(glm::cross(n, along)), z(n) {}
  explicit Frame(glm::vec3 n) : z(n) {
    const float sign = std::copysign(1.0f, n.z), a = -1.0f / (sign + n.z), b = n.x * n.y * a;
    x = {1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x};
    y = {b, sign + n.y * n.y * a, -n.y};
  }
  glm::vec3 world(glm::vec3 v) const { return x * v.x + y * v.y + z * v.z; }
};

}  // namespace sideray::model
