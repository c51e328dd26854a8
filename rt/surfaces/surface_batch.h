// Holds hits as arrays of numbers and shades them sixteen at a time (rt/surfaces/shade_kernels.h). It traces no rays
// and has scratch memory: one object per thread.
#pragma once

#include <glm/glm.hpp>
#include <span>
#include <string>
#include <vector>

#include "rt/surfaces/shade_kernels.h"
#include "rt/surfaces/shadow_rays.h"
#include "rt/surfaces/surface.h"
#include "rt/textures/environment_lookup.h"

namespace sideray::rt {

// Names a hit, the unit ray that made it, and the ray's cone at t = 0. Its owner keeps hit and ray alive.
struct HitPlace {
  const Hit* hit;
  const Ray* ray;
  Cone cone;
  float weight = 1.0f;  // SurfacePoint::weight
};

// Says how much of the pixel's light a shadow ray represents. A light that adds at least `most` always gets a ray.
// Fainter lights are sampled: each ray then represents the sum of all lights at the point, limited to `least` ..
// `most`.
struct LightOdds {
  float least, most;
};

// Makes the surface of each hit, with the same bits as surface_point(). `kernels` are those of the instruction set,
// `steps` those of the view whose pixels the rays go through, or null.
void make_surfaces(const ShadingScene& scene, const ShadeKernels& kernels, std::span<const HitPlace> hits,
                   SurfacePoint* points, const PixelSteps* steps = nullptr);
// Does the same, and appends the surfaces to `points`.
void append_surfaces(const ShadingScene& scene, const ShadeKernels& kernels, std::span<const HitPlace> hits,
                     std::vector<SurfacePoint>& points);

// Holds the indirect light at a point. thrown: radiance of a white diffuse surface that only other surfaces light.
// open: unoccluded share of the sky's light.
struct ArrivingLight {
  glm::vec3 thrown{0.0f}, open{1.0f};
};

// Describes a point of a batch as the start of rays.
struct PointAround {
  glm::vec3 origin;  // offset, so that rays do not hit the surface itself
  glm::vec3 normal;  // the geometric one
  float width;       // of a pixel there
  float weight;      // of its light in the pixel
};

// Refers to the rows of one lobe of a block's surfaces.
struct LobeRows {
  const BlockRow (&normal)[3];
  const BlockRow& roughness;
};

class SurfaceBatch {
 public:
  // The caller keeps the scene alive. `isa` has Embree's names. `viewer` is the direction to the viewer, for a fixed
  // function without a local viewer.
  void begin(const ShadingScene& scene, const std::string& isa, glm::vec3 viewer = {0, 0, 1});

  // Returns how many lights have shadow rays: the scene's, or those of its fixed function.
  size_t lights() const { return scene_->snapshot->fixed ? shadowed_ : scene_->lights.size(); }

  // Copies the points and fills around(), except for light from the mirror directions, which starts black.
  void load(std::span<const SurfacePoint> points);
  // Makes the hits' surfaces and does the same with them.
  void load(std::span<const HitPlace> hits);
  // Does so for hits of a view's rays, as a rasterizer draws them: textures are read by the pixels' steps, and mirror
  // directions are about the shading normal alone, since a G-buffer holds no other.
  void load_drawn(std::span<const HitPlace> hits, const PixelSteps& steps);

  // Darkens the sky's light at the points by its visible shares; `shares` has one entry a block.
  void hide_sky(std::span<const SkyShares> shares);

  // Returns whether the point has a diffuse part.
  bool is_matt(size_t point) const;
  PointAround point_around(size_t point) const;
  // Replaces the unoccluded sky's irradiance of diffuse surfaces by the arriving light.
  void let_arrive(std::span<const ArrivingLight> arriving);
  // Does the same for the mirrored environment, which reflect_environment() must have filled in.
  void let_arrive_in_mirrors(std::span<const ArrivingLight> arriving);

  // Fills in the prefiltered environment as light from the mirror directions.
  void reflect_environment();
  // Does so for the lanes of one block whose bit is set.
  void reflect_environment(size_t block, uint32_t lanes);
  // Does so without coats.
  void reflect_environment_in_base(size_t block, uint32_t lanes);

  // Writes environment_specular_at() of each place, with the same bits.
  void surroundings(std::span<const EnvironmentPlace> places, glm::vec3* radiance) const;

  // Writes radiance[i] = emission and light from the surroundings of point i. With the fixed function it writes the
  // light that needs no shadow rays; show() does the rest.
  void finish(glm::vec3* radiance);
  // In scenes of the fixed function, turns light and shine() into displayed values. Otherwise it changes nothing.
  void show(glm::vec3* radiance);
  // Returns whether the fixed function adds highlights after texturing. They are in shine(), to which lights are added
  // after finish().
  bool is_separate() const { return scene_->snapshot->fixed && scene_->snapshot->fixed->separate_specular; }
  glm::vec3* shine() { return shine_.data(); }

  // From the next load on, until begin(), occlusion textures have no effect: rays find what they stand in for.
  void occlude_by_rays() { occludes_by_rays_ = true; }
  // Takes the effect of its occlusion texture from one loaded point.
  void drop_occlusion(size_t point);

  // Removes the highlights of lights that are drawn or gathered from now on, of bases and coats less rough than this.
  // The diffuse part receives what Fresnel would have reflected, and a coat becomes rough. Call it after finish().
  void drop_highlights(float least_roughness);

  // Does what finish() does, and adds all lights of the scene unoccluded.
  void finish_unblocked(glm::vec3* radiance);

  // Writes the sum of all lights(), unoccluded. `shine` receives the part added after texturing, and may be null.
  void unblocked(glm::vec3* radiance, glm::vec3* shine = nullptr);

  // Fills `blends` by blend_of() for each point, and weights each point by its cover. `hits`: those that were loaded.
  void blend(std::span<const HitPlace> hits, shading::SrBlend* blends);

  // Samples lights for the points of one block and appends their shadow rays, which end at `share` of the distance. A
  // sampled light's gain is divided by its probability, so that the rays add the sum of all lights on average. Unless
  // `offered` is null, adds that sum to it; it is indexed from the batch's first point.
  void draw(size_t block, const LightOdds& odds, float share, ShadowRays& rays, glm::vec3* offered);

  // Appends the shadow rays of the points that the light reaches; they end at `share` of the distance to it.
  void gather(size_t light, float share, ShadowRays& rays);
  // Computes the light's contribution to the points of all blocks.
  std::span<const LightBlock> light(const shading::SrLight& light);
  // Does so for one block, including lanes behind the last point.
  void light(size_t block, const shading::SrLight& light, LightBlock& result) const;

  size_t size() const { return count_; }
  size_t blocks() const { return blocks_.size(); }
  std::span<AroundBlock> around() { return around_; }
  std::span<const AroundBlock> around() const { return around_; }

 private:
  // Holds the data of a light that draw() needs: its block, and the largest channel of each gain.
  struct Candidate {
    LightBlock light;
    BlockRow size;
  };
  LightTerms terms_of(size_t light) const;
  void start_fixed(glm::vec3* radiance);
  void make_blocks(std::span<const HitPlace> hits, const PixelSteps* steps);
  void clear_traits();
  void add_traits(float weight, float width, uint32_t key);
  void look_around();
  void list_candidates(size_t block, BlockRow& total, glm::vec3* offered);
  void store_radiance(size_t block, const BlockRow (&rows)[3], glm::vec3* radiance) const;
  void look_up(const BlockRow (&mirror)[3], const LobeRows& lobe, uint32_t lanes, BlockRow (&radiance)[3]) const;

  const ShadingScene* scene_ = nullptr;
  const ShadeKernels* kernels_ = nullptr;
  bool occludes_by_rays_ = false;
  size_t count_ = 0;
  std::vector<SurfaceBlock> blocks_;
  std::vector<AroundBlock> around_;
  std::vector<LightBlock> lights_;
  std::vector<Candidate> candidates_;  // of one block, one entry a light
  std::vector<float> weights_, widths_;
  std::vector<uint32_t> keys_;
  EnvironmentLevels levels_{};
  std::vector<FixedLightTerms> fixed_lights_;  // the scene's, for this viewer
  size_t shadowed_ = 0;                        // the first so many of them have shadows
  std::vector<glm::vec3> shine_;
};

inline glm::vec3 vector_at(const BlockRow (&rows)[3], size_t lane) {
  return {rows[0][lane], rows[1][lane], rows[2][lane]};
}

inline void set_vector(BlockRow (&rows)[3], size_t lane, glm::vec3 v) {
  rows[0][lane] = v.x;
  rows[1][lane] = v.y;
  rows[2][lane] = v.z;
}

}  // namespace sideray::rt
