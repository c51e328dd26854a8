// Writes model::albedo_table() as a source file: make_albedo_table OUT.cpp. The build runs it once, because the
// integrals took as long as everything else in a small picture.
#include <algorithm>
#include <array>
#include <cstdio>

#include "elementary/functions.h"
#include "model/hemisphere.h"
#include "model/snapshot.h"

namespace sideray::model {
namespace {

constexpr uint32_t samples = 4096;

// Includes both ends: albedos fall fastest at roughness 1, which most rough materials have.
float value_at(uint32_t entry) {
  return static_cast<float>(entry) / (AlbedoTable::size - 1);
}

// Limits the cosine, since at a right angle there are no visible normals.
float cosine_of(uint32_t column) {
  return std::max(value_at(column), 1e-3f);
}

// Holds a direction of the sum over the sheen lobe. All entries use the same ones, spread evenly over the hemisphere,
// as the lobe is strong near the horizon.
struct Direction {
  double x, y, z;
};

const std::vector<Direction>& sheen_directions() {
  static const std::vector<Direction> directions = [] {
    std::vector<Direction> d;
    for (uint32_t i = 0; i < samples; ++i) {
      const glm::dvec2 p(hammersley(i, samples));
      const double z = p.y + 0.5 / samples, sine = std::sqrt(1.0 - z * z), azimuth = glm::two_pi<double>() * p.x;
      d.push_back({sine * elementary::cos(azimuth), sine * elementary::sin(azimuth), z});
    }
    return d;
  }();
  return directions;
}

const std::vector<DiscPoint>& disc_points() {
  static const std::vector<DiscPoint> points = [] {
    std::vector<DiscPoint> p;
    for (uint32_t i = 0; i < samples; ++i) p.emplace_back(hammersley(i, samples));
    return p;
  }();
  return points;
}

// Returns scale and bias on f0 and f90 of the lobe's directional albedo (Karis 2013), with height-correlated Smith as
// in shading.h. Samples the normals that the eye sees, which leaves a smooth integrand.
glm::vec2 integrate(float n_v, float roughness) {
  const double alpha = std::max(roughness, 0.04f) * std::max(roughness, 0.04f), alpha2 = alpha * alpha, v = n_v;
  const glm::dvec3 to_eye(std::sqrt(1.0 - v * v), 0.0, v);
  const double slope = std::sqrt(v * v * (1 - alpha2) + alpha2);
  const VisibleNormals visible(glm::vec3(to_eye), static_cast<float>(alpha));
  double f0 = 0, f90 = 0;
  for (const DiscPoint& point : disc_points()) {
    const glm::dvec3 h(visible.normal(point));
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

// Returns the albedo of the sheen lobe as in shading.h, for all roughnesses of a column: distribution of Estevez and
// Kulla 2017, visibility of Neubelt and Pettineo 2013. In each direction, only the power of the half vector's sine
// depends on the roughness.
std::array<float, AlbedoTable::size> integrate_sheen(float n_v) {
  const double v = n_v, to_eye_x = std::sqrt(1.0 - v * v);
  std::array<double, samples> logarithm, visibility;
  for (uint32_t i = 0; i < samples; ++i) {
    const Direction& l = sheen_directions()[i];
    const glm::dvec3 h = glm::normalize(glm::dvec3(to_eye_x + l.x, l.y, v + l.z));
    logarithm[i] = 0.5 * elementary::log(std::max(1e-300, 1.0 - h.z * h.z));
    visibility[i] = l.z / (4.0 * (l.z + v - l.z * v));
  }
  std::array<float, AlbedoTable::size> albedo;
  for (uint32_t row = 0; row < AlbedoTable::size; ++row) {
    const double r = std::max(value_at(row), 0.07f), inverse_alpha = 1.0 / (r * r);
    double sum = 0;
    for (uint32_t i = 0; i < samples; ++i) sum += elementary::exp(inverse_alpha * logarithm[i]) * visibility[i];
    albedo[row] = static_cast<float>(std::min((2.0 + inverse_alpha) * sum / samples, 1.0));
  }
  return albedo;
}

std::vector<glm::vec3> integrate_all() {
  std::vector<glm::vec3> values(size_t{AlbedoTable::size} * AlbedoTable::size);
  for (uint32_t column = 0; column < AlbedoTable::size; ++column) {
    const std::array<float, AlbedoTable::size> sheen = integrate_sheen(cosine_of(column));
    for (uint32_t row = 0; row < AlbedoTable::size; ++row)
      values[row * AlbedoTable::size + column] = {integrate(cosine_of(column), value_at(row)), sheen[row]};
  }
  return values;
}

// Writes floats in hexadecimal, so that no bits are lost.
bool write_source(const char* path) {
  std::FILE* file = std::fopen(path, "w");
  if (!file) return false;
  std::fputs("#include \"model/snapshot.h\"\n\nnamespace sideray::model {\n\nconst AlbedoTable& albedo_table() {\n"
             "  static const AlbedoTable table{{\n", file);
  for (const glm::vec3& v : integrate_all())
    std::fprintf(file, "    {%af, %af, %af},\n", double{v.x}, double{v.y}, double{v.z});
  std::fputs("  }};\n  return table;\n}\n\n}  // namespace sideray::model\n", file);
  return std::fclose(file) == 0;
}

}  // namespace
}  // namespace sideray::model

int main(int argc, char** argv) {
  if (argc == 2 && sideray::model::write_source(argv[1])) return 0;
  std::fputs("make_albedo_table: give one file that can be written\n", stderr);
  return 1;
}
