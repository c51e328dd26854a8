// Makes the surface of a hit for the shading model: interpolated attributes, textures, the side that was hit. Immutable
// once built; any thread may use it.
#pragma once

#include <glm/glm.hpp>
#include <memory>
#include <vector>

#include "model/snapshot.h"
#include "rt/base/ray.h"
#include "rt/surfaces/scene_records.h"
#include "rt/surfaces/shade_kernels.h"
#include "rt/surfaces/surface_point.h"
#include "rt/textures/surface_textures.h"
#include "shaders/shading/shading_cpp.h"

namespace sideray::rt {

struct RefractionScene;
class EmittersWhenUsed;

// Holds a snapshot with its materials and lights in the shading model's structs.
struct ShadingScene {
  explicit ShadingScene(std::shared_ptr<const model::Snapshot> committed);

  std::shared_ptr<const model::Snapshot> snapshot;
  std::vector<shading::SrMaterial> materials;      // textures not applied
  std::vector<shading::SrFixedMaterial> fixed_materials;  // in a scene of the fixed function; else empty
  std::vector<FixedLightTerms> fixed_lights;              // the same; lights with shadows come first
  std::vector<std::vector<TextureRead>> textures;  // by material
  std::vector<shading::SrLight> lights;            // lights that emit anything
  std::vector<uint32_t> light_numbers;             // their indices in the snapshot
  SceneRecords records;                            // the same for kernels
  // The media that light passes; null if nothing translucent casts a shadow (model::tints_light()).
  std::shared_ptr<const RefractionScene> glass;
  // Samples the emissive surfaces by which surfaces light each other; null: only random rays find those.
  std::shared_ptr<const EmittersWhenUsed> emitters;
};

// Returns the factors of dst = radiance * cover + dst * through.
shading::SrBlend blend_of(const SurfacePoint& point);

// Holds attributes that the shading model does not need.
struct SurfaceAttributes {
  glm::vec2 uv[2];
  glm::vec2 footprint[2][2];  // for each uv: along the longer diameter of the ray's cone, and across
  glm::vec4 color, tangent;   // tangent: unit; w = 0 if there is none
  uint32_t primitive;         // as numbered by the caller
};
SurfaceAttributes surface_attributes(const model::Snapshot& snapshot, const SurfacePoint& point);

// Makes the surface of a hit. `ray` is the unit ray that made it, `cone` its cone at t = 0, `steps` those of the view
// whose pixel it goes through, or null. SurfaceBatch does the same for many hits.
SurfacePoint surface_point(const ShadingScene& scene, const Hit& hit, const Ray& ray, Cone cone,
                           const PixelSteps* steps = nullptr);

// Returns the surface of an isotropic material without its textures, seen at an angle to its normal; `thick`: with the
// absorption of its thickness.
shading::SrSurface plain_surface(const ShadingScene& scene, uint32_t material, float cosine, bool thick);

// Returns the factor by which the material's texture scales its thickness at a point: 1 if there is no texture.
float thickness_texel(const ShadingScene& scene, const SurfacePoint& point);

// Returns the unit normal on the side of the front face.
glm::vec3 geometric_normal(const model::Snapshot& snapshot, const Hit& hit);

}  // namespace sideray::rt
