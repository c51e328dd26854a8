// Computes the light from surfaces toward the viewer, for batches of hits: punctual lights with shadow rays, one
// reflection (and one in the coat; rough ones are sampled), environment, emission. It has scratch memory: one object
// per thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <span>
#include <vector>

#include "rt/embree/intersector.h"
#include "rt/light/direct_light.h"
#include "rt/light/light_around.h"
#include "rt/shading/mirror_rays.h"
#include "rt/shading/point_shader.h"
#include "rt/shading/ray_sharing.h"
#include "rt/surfaces/surface_batch.h"

namespace sideray::rt {

struct HitShading {
  bool shadows = true;      // traces shadow rays
  bool tell_rough = false;  // fills in rough()
  // LayerRequest::ray_reuse. Above 0, faint lights are sampled at random; otherwise every light that reaches a point gets
  // a shadow ray.
  float error = 0.0f;
  glm::vec3 viewer = {0, 0, 1};  // as in SurfaceBatch::begin()
  // If set, surfaces light each other, and occlude the sky for each other. The value is LayerRequest::position.
  std::optional<uint32_t> bounces = std::nullopt;
  std::optional<SeenLight> seen = std::nullopt;  // with `bounces`: as in LightAround::begin()
};

class HitShader final : public PointShader, public SecondaryHitShader, public RaySharing {
 public:
  // Sets the scene and options until the next call; the caller keeps scene and intersector alive, and options with `seen`.
  void begin(const ShadingScene& scene, const Intersector& intersector, const HitShading& options = {});

  void shade(std::span<const SurfacePoint> points, glm::vec3* radiance) override;
  void shade_opaque(std::span<const SurfacePoint> points, glm::vec3* radiance) override;
  std::span<const RoughReflection> rough() const override { return rough_; }
  RaySharing* sharing() override { return this; }

  void write_answers(RayAnswer* answers) const override;
  void consider(std::span<const SurfacePoint> points, RayProspect* prospects) override;
  void shade_reusing(std::span<const SurfacePoint> points, std::span<const ReusedRays> reused,
                     glm::vec3* radiance) override;

  void shade_secondary_hits(std::span<const HitPlace> hits, glm::vec3* radiance) override;
  void shade_in_front(std::span<const HitPlace> hits, shading::SrBlend* blends, glm::vec3* radiance) override;
  glm::vec3 surroundings(glm::vec3 direction, float roughness) const override;
  void surroundings(std::span<const EnvironmentPlace> places, glm::vec3* radiance) const override;

 private:
  // Names a lobe of a point that has a mirror ray.
  struct Lobe {
    uint32_t point;
    uint32_t layer;  // as in Mirror
  };
  // Says where the fields of RayAnswer are added; null: nowhere.
  struct RayAnswers {
    glm::vec3 *offered = nullptr, *arrived = nullptr;
  };
  void add_direct_seen(glm::vec3* radiance);
  void add_lights(SurfaceBatch& batch, glm::vec3* radiance, RayAnswers answers);
  void add_drawn_lights(SurfaceBatch& batch, glm::vec3* radiance, RayAnswers answers);
  void trace_lights(SurfaceBatch& batch, glm::vec3* radiance);
  bool reuses_mirror(size_t point) const { return !without_mirrors_.empty() && without_mirrors_[point] != 0; }
  void see_own_surroundings(std::span<const ReusedRays> reused);
  void trace_reflections(std::span<const SurfacePoint> points);
  void collect_rough(std::span<const SurfacePoint> points);
  void add_rough(size_t ray, glm::vec3 weight, RoughReflection& rough) const;
  Mirror mirror_of(const SurfacePoint& point, size_t i, uint32_t layer) const;
  void choose_lobes(size_t points);
  void collect_mirror_rays(std::span<const SurfacePoint> points);
  std::span<const ArrivingLight> find_arriving(const SurfaceBatch& batch, bool matt);
  void let_arrive(SurfaceBatch& batch);
  void see_around(SurfaceBatch& batch);
  void shade_reflected(glm::vec3* radiance);

  const ShadingScene* scene_ = nullptr;
  const Intersector* intersector_ = nullptr;
  bool shadows_ = true, tell_rough_ = false, bounces_ = false;
  float error_ = 0.0f;

  SurfaceBatch seen_, reflected_, in_front_;  // seen by the eye; seen in mirrors; in front of surfaces seen in mirrors

  MirrorRays mirrors_;  // the bases' rays, then the coats'
  std::vector<Lobe> lobes_;  // of the rays of mirrors_

  DirectLight light_;
  LightAround around_;

  std::vector<RoughReflection> rough_;

  std::vector<glm::vec3> offered_, arrived_;  // fields of RayAnswer, for the points of seen_
  std::vector<glm::vec3> offered_shine_;      // the part of offered_ that the fixed function adds after texturing
  std::vector<uint8_t> without_mirrors_;      // by point: its mirror rays are reused; empty: none are
};

}  // namespace sideray::rt
