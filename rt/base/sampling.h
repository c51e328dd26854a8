// Makes random numbers as functions of their use (pixel, position, purpose, seed), and the distributions that light and
// microfacets are sampled from. It has no state; any thread may call it.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <glm/gtc/constants.hpp>
#include <initializer_list>

#include "elementary/functions.h"
#include "model/hemisphere.h"

namespace sideray::rt {

// Hashes 32 bits by PCG (Jarzynski and Olano 2020, "Hash Functions for GPU Rendering").
inline uint32_t hash_bits(uint32_t x) {
  const uint32_t state = x * 747796405u + 2891336453u;
  const uint32_t word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
  return (word >> 22u) ^ word;
}

// Makes one key from several numbers, whose order matters.
inline uint32_t random_key(std::initializer_list<uint32_t> parts) {
  uint32_t key = 0;
  for (const uint32_t part : parts) key = hash_bits(key + part);
  return key;
}

// Makes the key of everything at one of a pixel's sample positions.
inline uint32_t pixel_key(uint32_t seed, uint32_t position, uint32_t x, uint32_t y) {
  return random_key({seed, position, y << 16 | x});
}

// Returns a float in 0 <= x < 1, from the upper 24 bits.
inline float unit_float(uint32_t bits) {
  return static_cast<float>(bits >> 8) * 0x1p-24f;
}

inline uint32_t reverse_bits(uint32_t x) {
  x = (x << 16) | (x >> 16);
  x = ((x & 0x00ff00ffu) << 8) | ((x & 0xff00ff00u) >> 8);
  x = ((x & 0x0f0f0f0fu) << 4) | ((x & 0xf0f0f0f0u) >> 4);
  x = ((x & 0x33333333u) << 2) | ((x & 0xccccccccu) >> 2);
  return ((x & 0x55555555u) << 1) | ((x & 0xaaaaaaaau) >> 1);
}

// Approximates Owen's nested uniform scrambling by a hash (Burley 2020, "Practical Hash-based Owen Scrambling").
inline uint32_t scramble_nested(uint32_t x, uint32_t key) {
  x = reverse_bits(x) + key;
  x ^= x * 0x6c50b47cu;
  x ^= x * 0xb82f1e52u;
  x ^= x * 0xc7afe638u;
  x ^= x * 0x8d22f6e6u;
  return reverse_bits(x);
}

// Makes the points of one integral over the unit square: Sobol's first two dimensions, scrambled and shuffled by the
// key. The first n points are stratified, best where n is a power of two; sets of different keys are independent of
// each other.
class PointSet {
 public:
  PointSet() = default;
  explicit PointSet(uint32_t key) : order_(hash_bits(key)), x_(hash_bits(key + 1u)), y_(hash_bits(key + 2u)) {}

  // Copies the set that has these keys.
  PointSet(uint32_t order, uint32_t x, uint32_t y) : order_(order), x_(x), y_(y) {}
  uint32_t order_key() const { return order_; }
  uint32_t x_key() const { return x_; }
  uint32_t y_key() const { return y_; }

  glm::vec2 operator[](uint32_t i) const {
    const uint32_t index = scramble_nested(i, order_);
    return {unit_float(scramble_nested(reverse_bits(index), x_)), unit_float(scramble_nested(second(index), y_))};
  }

 private:
  // Returns a point's second coordinate in Sobol's sequence (Kollig and Keller 2002). The k-th direction number is the
  // polynomial (1 + x)^k over bits, so the index, read as a polynomial in x, is evaluated at 1 + x, halving it each
  // step.
  static uint32_t second(uint32_t index) {
    index ^= (index >> 16) & 0x0000ffffu;
    index ^= (index >> 8) & 0x00ff00ffu;
    index ^= (index >> 4) & 0x0f0f0f0fu;
    index ^= (index >> 2) & 0x33333333u;
    index ^= (index >> 1) & 0x55555555u;
    return reverse_bits(index);
  }

  uint32_t order_ = 0, x_ = 0, y_ = 0;
};

// Returns a frame whose third column is `z`, of unit length.
inline glm::mat3 frame_about(glm::vec3 z) {
  const glm::vec3 side = std::abs(z.x) < 0.5f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0);
  const glm::vec3 x = glm::normalize(glm::cross(side, z));
  return {x, glm::cross(z, x), z};
}

// The functions below take and return directions in a frame whose z is the normal or axis. `u` is a point of the unit
// square; densities are per steradian.

inline glm::vec3 sample_cosine(glm::vec2 u) {
  const float sine = std::sqrt(u.x), azimuth = glm::two_pi<float>() * u.y;
  return {sine * elementary::cos(azimuth), sine * elementary::sin(azimuth), std::sqrt(1.0f - u.x)};
}

inline float cosine_density(float cosine) {
  return std::max(cosine, 0.0f) * glm::one_over_pi<float>();
}

// Returns a cone's aperture as 1 - cos(half angle), which keeps the digits of narrow cones.
inline float cone_aperture(float half_angle) {
  const float s = elementary::sin(0.5f * half_angle);
  return 2.0f * s * s;
}

inline float cone_solid_angle(float aperture) {
  return glm::two_pi<float>() * aperture;
}

// Samples uniformly within the cone; the density is 1 / cone_solid_angle.
inline glm::vec3 sample_cone(glm::vec2 u, float aperture) {
  const float below = u.x * aperture, azimuth = glm::two_pi<float>() * u.y;
  const float sine = std::sqrt(below * (2.0f - below));
  return {sine * elementary::cos(azimuth), sine * elementary::sin(azimuth), 1.0f - below};
}

// Returns the aperture of the cone that a sphere fills, seen from outside: radius < distance.
inline float sphere_aperture(float radius, float distance) {
  const float sine = radius / distance, sine2 = sine * sine;
  return sine2 / (1.0f + std::sqrt(1.0f - sine2));
}

// Returns the distance to a sphere's near side in a direction within that cone; `below` is 1 - cos of its angle to the
// axis.
inline float distance_to_sphere(float radius, float distance, float below) {
  const float across2 = distance * distance * below * (2.0f - below);
  return distance * (1.0f - below) - std::sqrt(std::max(radius * radius - across2, 0.0f));
}

// Returns the distribution of GGX normals (Walter et al. 2007); alpha is the square of the perceptual roughness.
inline float ggx_distribution(glm::vec3 h, float alpha) {
  const float a2 = alpha * alpha;
  const float f = a2 * h.z * h.z + h.x * h.x + h.y * h.y;  // 1 - (1 - a2) cos^2 without cancellation
  return a2 / (glm::pi<float>() * std::max(f * f, 1e-20f));
}

// Does the same for anisotropic GGX, with alphas along x and y.
inline float ggx_distribution(glm::vec3 h, glm::vec2 alpha) {
  const float both = alpha.x * alpha.y;
  const float x = h.x * alpha.y, y = h.y * alpha.x, z = h.z * both;
  const float f = x * x + y * y + z * z;
  return both * both * both / (glm::pi<float>() * std::max(f * f, 1e-30f));
}

using model::sample_visible_normal;

// Returns the density of directions reflected by visible normals: the density of the normals times 1 / (4 to_eye.h).
inline float visible_reflection_density(glm::vec3 to_eye, glm::vec3 h, float alpha) {
  if (glm::dot(to_eye, h) <= 0.0f || h.z <= 0.0f) return 0.0f;
  const float a2 = alpha * alpha, z = to_eye.z;
  return ggx_distribution(h, alpha) / (2.0f * (z + std::sqrt(a2 + (1.0f - a2) * z * z)));
}

inline float visible_reflection_density(glm::vec3 to_eye, glm::vec3 h, glm::vec2 alpha) {
  if (alpha.x == alpha.y) return visible_reflection_density(to_eye, h, alpha.x);
  if (glm::dot(to_eye, h) <= 0.0f || h.z <= 0.0f) return 0.0f;
  const glm::vec3 v(alpha.x * to_eye.x, alpha.y * to_eye.y, to_eye.z);
  return ggx_distribution(h, alpha) / (2.0f * (to_eye.z + glm::length(v)));
}

// Returns the balance heuristic's weight (Veach 1995) over the sample's own density, for two strategies that take n_a
// and n_b samples.
inline float balance(float n_a, float density_a, float n_b, float density_b) {
  const float sum = n_a * density_a + n_b * density_b;
  return sum > 0.0f ? 1.0f / sum : 0.0f;
}

}  // namespace sideray::rt
