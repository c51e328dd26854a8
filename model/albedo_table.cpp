#include <tbb/parallel_for.h>

#include <algorithm>

#include "model/hemisphere.h"
#include "model/snapshot.h"

namespace sideray::model {
namespace {

constexpr uint32_t samples = 512;

// Scale and bias on f0 and f90 of the lobe's directional albedo (Karis 2013), height-correlated Smith as in shading.h.
glm::vec2 integrate(float n_v, float roughness) {
  const double alpha = std::max(roughness, 0.04f) * std::max(roughness, 0.04f), alpha2 = alpha * alpha, v = n_v;
  const glm::dvec3 to_eye(std::sqrt(1.0 - v * v), 0.0, v);
  double f0 = 0, f90 = 0;
  for (uint32_t i = 0; i < samples; ++i) {
    const glm::dvec3 h(sample_ggx(hammersley(i, samples), static_cast<float>(alpha)));
    const double v_h = std::max(glm::dot(to_eye, h), 1e-6);
    const double n_l = 2.0 * v_h * h.z - v;
    if (n_l <= 0.0) continue;
    const double visibility =
        0.5 / (n_l * std::sqrt(v * v * (1 - alpha2) + alpha2) + v * std::sqrt(n_l * n_l * (1 - alpha2) + alpha2));
    const double weight = visibility * 4.0 * n_l * v_h / h.z;
    const double c = 1.0 - v_h, fresnel = c * c * c * c * c;
    f0 += (1.0 - fresnel) * weight;
    f90 += fresnel * weight;
  }
  return glm::vec2(f0 / samples, f90 / samples);
}

}  // namespace

const AlbedoTable& albedo_table() {
  static const AlbedoTable table = [] {
    AlbedoTable t;
    t.values.resize(size_t{AlbedoTable::size} * AlbedoTable::size);
    tbb::parallel_for(0u, AlbedoTable::size, [&](uint32_t row) {
      for (uint32_t column = 0; column < AlbedoTable::size; ++column)
        t.values[row * AlbedoTable::size + column] = integrate((static_cast<float>(column) + 0.5f) / AlbedoTable::size,
                                                               (static_cast<float>(row) + 0.5f) / AlbedoTable::size);
    });
    return t;
  }();
  return table;
}

}  // namespace sideray::model
