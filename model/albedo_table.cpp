#include <tbb/parallel_for.h>

#include <algorithm>

#include "model/hemisphere.h"
#include "model/snapshot.h"

namespace sideray::model {
namespace {

constexpr uint32_t samples = 1024;

// Scale and bias on f0 and f90 of the lobe's directional albedo (Karis 2013), height-correlated Smith as in shading.h,
// over the normals that the eye sees: what remains to be averaged is smooth.
glm::vec2 integrate(float n_v, float roughness) {
  const double alpha = std::max(roughness, 0.04f) * std::max(roughness, 0.04f), alpha2 = alpha * alpha, v = n_v;
  const glm::dvec3 to_eye(std::sqrt(1.0 - v * v), 0.0, v);
  const double slope = std::sqrt(v * v * (1 - alpha2) + alpha2);
  double f0 = 0, f90 = 0;
  for (uint32_t i = 0; i < samples; ++i) {
    const glm::dvec3 h(sample_visible_normal(glm::vec3(to_eye), static_cast<float>(alpha), hammersley(i, samples)));
    const double v_h = std::max(glm::dot(to_eye, h), 1e-6);
    const double n_l = 2.0 * v_h * h.z - v;
    if (n_l <= 0.0) continue;
    const double weight = n_l * (v + slope) / (n_l * slope + v * std::sqrt(n_l * n_l * (1 - alpha2) + alpha2));
    const double c = 1.0 - v_h, fresnel = c * c * c * c * c;
    f0 += (1.0 - fresnel) * weight;
    f90 += fresnel * weight;
  }
  return glm::vec2(f0 / samples, f90 / samples);
}

// Albedo of the sheen lobe as in shading.h: distribution of Estevez and Kulla 2017, visibility of Neubelt and Pettineo
// 2013. The lobe is strong near the horizon: directions are spread evenly over the hemisphere.
float integrate_sheen(float n_v, float roughness) {
  const double r = std::max(roughness, 0.07f), inverse_alpha = 1.0 / (r * r), v = n_v;
  const glm::dvec3 to_eye(std::sqrt(1.0 - v * v), 0.0, v);
  double sum = 0;
  for (uint32_t i = 0; i < samples; ++i) {
    const glm::dvec2 p(hammersley(i, samples));
    const double n_l = p.y + 0.5 / samples, sine = std::sqrt(1.0 - n_l * n_l), azimuth = glm::two_pi<double>() * p.x;
    const glm::dvec3 h = glm::normalize(to_eye + glm::dvec3(sine * std::cos(azimuth), sine * std::sin(azimuth), n_l));
    const double sine_h = std::sqrt(std::max(0.0, 1.0 - h.z * h.z));
    const double d = (2.0 + inverse_alpha) * std::pow(sine_h, inverse_alpha) / glm::two_pi<double>();
    sum += d * n_l / (4.0 * (n_l + v - n_l * v)) * glm::two_pi<double>();
  }
  return static_cast<float>(std::min(sum / samples, 1.0));
}

}  // namespace

const AlbedoTable& albedo_table() {
  static const AlbedoTable table = [] {
    AlbedoTable t;
    t.values.resize(size_t{AlbedoTable::size} * AlbedoTable::size);
    tbb::parallel_for(0u, AlbedoTable::size, [&](uint32_t row) {
      for (uint32_t column = 0; column < AlbedoTable::size; ++column) {
        const float n_v = (static_cast<float>(column) + 0.5f) / AlbedoTable::size;
        const float roughness = (static_cast<float>(row) + 0.5f) / AlbedoTable::size;
        t.values[row * AlbedoTable::size + column] = {integrate(n_v, roughness), integrate_sheen(n_v, roughness)};
      }
    });
    return t;
  }();
  return table;
}

}  // namespace sideray::model
