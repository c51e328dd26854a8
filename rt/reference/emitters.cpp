#include "rt/reference/emitters.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace sideray::rt {
namespace {

constexpr uint32_t no_triangle = 0xffffffffu;

// Returns how much of what shines is taken for an emitter's: texture values are not regarded, 0 = it is not sampled.
float brightness(const model::Snapshot& snapshot, const model::Instance& instance) {
  const model::Material& material = snapshot.materials[instance.material];
  const sideray_material_desc& d = material.desc;
  const bool has_holes = material.translucent || material.discards;
  if (has_holes || instance.sprites != 0 || !(instance.visibility & SIDERAY_VISIBLE_REFLECTION)) return 0.0f;
  const float* shines = d.unlit ? d.base_color : d.emissive;
  return std::max({shines[0], shines[1], shines[2]});
}

}  // namespace

EmitterSampler::EmitterSampler(std::shared_ptr<const model::Snapshot> snapshot) : snapshot_(std::move(snapshot)) {
  first_.assign(snapshot_->instances.size(), no_triangle);
  double sum = 0;
  std::vector<double> weights;
  for (uint32_t i = 0; i < first_.size(); ++i) {
    const model::Instance& instance = snapshot_->instances[i];
    const float bright = brightness(*snapshot_, instance);
    if (!(bright > 0.0f)) continue;
    const model::Mesh& mesh = *snapshot_->meshes[instance.mesh];
    first_[i] = static_cast<uint32_t>(triangles_.size());
    const auto place = [&](uint32_t vertex) {
      return glm::vec3(instance.local_from_object * glm::vec4(mesh.positions[vertex], 1.0f));
    };
    for (uint32_t primitive = 0; primitive < mesh.triangles.size(); ++primitive) {
      const glm::uvec3 t = mesh.triangles[primitive];
      const glm::vec3 corner = place(t.x), edge1 = place(t.y) - corner, edge2 = place(t.z) - corner;
      const glm::vec3 across = glm::cross(edge1, edge2);
      const float area2 = glm::length(across);
      const glm::vec3 normal = area2 > 0.0f ? across / area2 : glm::vec3(0.0f);
      triangles_.push_back({corner, edge1, edge2, instance.mirrored ? -normal : normal, i, primitive, bright});
      weights.push_back(0.5 * static_cast<double>(area2) * static_cast<double>(bright));
      sum += weights.back();
    }
  }
  if (!(sum > 0.0) || !std::isfinite(sum)) {
    triangles_.clear();
    return;
  }
  double until = 0;
  for (size_t i = 0; i < triangles_.size(); ++i) {
    triangles_[i].chance_by_area = static_cast<float>(static_cast<double>(triangles_[i].chance_by_area) / sum);
    until_.push_back(static_cast<float>((until += weights[i]) / sum));
  }
}

EmitterSampler::Sample EmitterSampler::sample(glm::vec3 from, float choice, glm::vec2 u) const {
  const auto at = std::upper_bound(until_.begin(), until_.end(), choice);
  const Triangle& t = triangles_[at == until_.end() ? triangles_.size() - 1 : static_cast<size_t>(at - until_.begin())];
  // Uniform on the triangle (Osada et al. 2002).
  const float root = std::sqrt(u.x), second = root * (1.0f - u.y), third = root * u.y;
  const glm::vec3 way = t.corner + t.edge1 * second + t.edge2 * third - from;
  const float distance = glm::length(way);
  Sample s{};
  s.ray = {from, 0.0f, distance > 0.0f ? way / distance : glm::vec3(0, 1, 0), distance};
  s.hit = {static_cast<double>(distance), second, third, t.instance, t.primitive, glm::dot(t.normal, way) < 0.0f};
  s.density = density(s.hit, s.ray.direction);
  return s;
}

float EmitterSampler::density(const Hit& hit, glm::vec3 direction) const {
  if (triangles_.empty() || first_[hit.instance] == no_triangle) return 0.0f;
  const Triangle& t = triangles_[first_[hit.instance] + hit.primitive];
  const float cosine = std::abs(glm::dot(t.normal, direction)), distance = static_cast<float>(hit.distance);
  return cosine > 0.0f ? t.chance_by_area * distance * distance / cosine : 0.0f;
}

}  // namespace sideray::rt
