#include "rt/layers/fragment_shader.h"

namespace sideray::rt {
namespace {

constexpr size_t rays_of_full_packets = 1024;

}  // namespace

void FragmentShader::begin(const ShadingScene& scene, const Intersector& intersector, bool shadows, bool tints) {
  scene_ = &scene;
  intersector_ = &intersector;
  shadows_ = shadows;
  rays_shadow = 0;
  batch_.begin(scene, intersector.isa());
  light_.begin(scene, intersector, tints);
}

void FragmentShader::shade_opaque(std::span<const SurfacePoint> points, glm::vec3* radiance) {
  if (points.empty()) return;
  batch_.load(points);
  batch_.reflect_environment();
  batch_.finish(radiance);
  light_.clear();
  // Rays of several lights are traced together, because the last packet of each light would be half empty.
  for (size_t i = 0; i < scene_->lights.size(); ++i) {
    light_.gather(batch_, i);
    if (light_.rays() < rays_of_full_packets && i + 1 < scene_->lights.size()) continue;
    if (shadows_) rays_shadow += light_.rays();
    light_.add(shadows_ ? intersector_ : nullptr, radiance);
    light_.clear();
  }
}

glm::vec3 FragmentShader::surroundings(glm::vec3 direction, float roughness) const {
  return environment_specular(*scene_->snapshot->environment, direction, roughness);
}

}  // namespace sideray::rt
