#include "rt/shading/host_shader.h"

#include <algorithm>

#include "model/environment.h"
#include "rt/base/largest.h"
#include "rt/textures/environment_lookup.h"

namespace sideray::rt {
namespace {

constexpr float least_reflectance = 1e-4f;  // the smallest that is worth a ray
constexpr float mirror_roughness = 0.0f;

constexpr HostPoints::Kind seen_layer{0, true, true};
constexpr HostPoints::Kind met_opaque{1, false, true};
constexpr HostPoints::Kind met_layer{1, true, false};

void give_answers(std::span<SurfacePoint> points, const std::vector<HostAnswer>& answers) {
  for (size_t i = 0; i < points.size(); ++i) points[i].answer = &answers[i];
}

}  // namespace

void HostShader::begin(const ShadingScene& scene, const Intersector& intersector, const HostCalls& calls,
                       bool shadows) {
  static_cast<ShaderWork&>(*this) = {};
  scene_ = &scene;
  kernels_ = &shade_kernels(intersector.isa().c_str());
  host_.begin(scene, intersector, calls, shadows);
  mirrors_.begin(scene, intersector, *this);
}

void HostShader::ask(std::span<const SurfacePoint> points, HostPoints::Kind kind, std::vector<HostAnswer>& answers) {
  host_.ask(points, kind, answers);
  rays_shadow = host_.rays_shadow;
  points_asked = host_.asked;
  points_not_finite = host_.not_finite;
  end = host_.end;
}

void HostShader::cover(std::span<SurfacePoint> points) {
  ask(points, seen_layer, seen_);
  give_answers(points, seen_);
}

void HostShader::shade(std::span<const SurfacePoint> points, glm::vec3* radiance) {
  if (points.empty()) return;
  // For refracted rays the host has not been called yet, because materials decide where they continue.
  const bool asked = points.front().answer != nullptr;
  if (!asked) ask(points, seen_layer, seen_);
  of_points_.clear();
  for (size_t i = 0; i < points.size(); ++i) of_points_.push_back(asked ? points[i].answer : &seen_[i]);
  for (size_t i = 0; i < points.size(); ++i) radiance[i] = of_points_[i]->radiance;
  trace_reflections(points);
  for (size_t r = 0; r < mirrors_.size(); ++r)
    radiance[mirrors_.point(r)] += of_points_[mirrors_.point(r)]->reflectance * mirrors_.radiance(r);
}

void HostShader::trace_reflections(std::span<const SurfacePoint> points) {
  mirrors_.clear();
  for (size_t i = 0; i < points.size(); ++i) {
    const HostAnswer& a = *of_points_[i];
    if (largest(a.reflectance) < least_reflectance) continue;
    mirrors_.add(points[i], static_cast<uint32_t>(i), start_of_ray(points[i]),
                 {a.reflection, points[i].surface.normal, mirror_roughness, 0});
  }
  mirrors_.follow();
  rays_reflection = mirrors_.traversals;
}

void HostShader::shade_opaque(std::span<const SurfacePoint> points, glm::vec3* radiance) {
  ask(points, met_opaque, met_);
  for (size_t i = 0; i < points.size(); ++i) radiance[i] = surrounded(met_[i]);
}

void HostShader::shade_secondary_hits(std::span<const HitPlace> hits, glm::vec3* radiance) {
  hits_.clear();
  append_surfaces(*scene_, *kernels_, hits, hits_);
  shade_opaque(hits_, radiance);
}

void HostShader::shade_in_front(std::span<const HitPlace> hits, shading::SrBlend* blends, glm::vec3* radiance) {
  hits_.clear();
  append_surfaces(*scene_, *kernels_, hits, hits_);
  ask(hits_, met_layer, met_);
  for (size_t i = 0; i < hits.size(); ++i) {
    blends[i] = met_[i].blend;
    radiance[i] = surrounded(met_[i]);
  }
}

// Surfaces seen in mirrors reflect only the environment.
glm::vec3 HostShader::surrounded(const HostAnswer& a) const {
  if (largest(a.reflectance) < least_reflectance) return a.radiance;
  return a.radiance + a.reflectance * surroundings(a.reflection, mirror_roughness);
}

glm::vec3 HostShader::encoded(glm::vec3 linear) const {
  const sideray_shader_desc& shader = scene_->snapshot->shader;
  glm::vec3 result;
  for (int c = 0; c < 3; ++c) result[c] = model::encode_radiance(linear[c], shader.radiance_space, shader.radiance_scale);
  return result;
}

glm::vec3 HostShader::surroundings(glm::vec3 direction, float roughness) const {
  return encoded(environment_specular(*scene_->snapshot->environment, direction, roughness));
}

void HostShader::surroundings(std::span<const EnvironmentPlace> places, glm::vec3* radiance) const {
  for (size_t i = 0; i < places.size(); ++i)
    radiance[i] = encoded(environment_specular_at(*scene_->snapshot->environment, places[i]));
}

}  // namespace sideray::rt
