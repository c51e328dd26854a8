// Holds hits as arrays of numbers and shades them sixteen at a time (rt/surfaces/shade_kernels.h). Traces no rays.
// Holds scratch memory: one object per thread.
#pragma once

#include <glm/glm.hpp>
#include <span>
#include <string>
#include <vector>

#include "rt/surfaces/shade_kernels.h"
#include "rt/surfaces/surface.h"
#include "rt/textures/environment_lookup.h"

namespace sideray::rt {

// Names a hit, the unit ray that made it, and its cone at t = 0. Whoever fills it keeps both.
struct HitPlace {
  const Hit* hit;
  const Ray* ray;
  Cone cone;
  float weight = 1.0f;  // SurfacePoint::weight
};

// Says how much light in the pixel a shadow ray represents. A light that adds `most` or more is traced for sure.
// Fainter ones are drawn: each ray represents all that lights add at the point, but at most `most` and at least
// `least`.
struct LightOdds {
  float least, most;
};

// Makes what surface_point() makes of each hit, bit for bit. `kernels` are those of the instruction set.
void make_surfaces(const ShadingScene& scene, const ShadeKernels& kernels, std::span<const HitPlace> hits,
                   SurfacePoint* points);
// Appends the same.
void append_surfaces(const ShadingScene& scene, const ShadeKernels& kernels, std::span<const HitPlace> hits,
                     std::vector<SurfacePoint>& points);

// Holds shadow rays by component, and the light that each adds to its point if unoccluded. Its memory never shrinks.
class ShadowRays {
 public:
  size_t size() const { return count_; }
  void clear() { count_ = 0; }
  // Makes room for so many more.
  void reserve(size_t more);
  void append(const ShadeKernels& kernels, const LightBlock& light, float share, uint32_t point);
  // Returns the highlight that the fixed function adds apart; where it does not, the number means nothing.
  glm::vec3 shine(size_t ray) const { return {shine_[0][ray], shine_[1][ray], shine_[2][ray]}; }
  RayColumns columns() const;
  uint32_t point(size_t ray) const { return points_[ray]; }
  glm::vec3 gain(size_t ray) const { return {gain_[0][ray], gain_[1][ray], gain_[2][ray]}; }

 private:
  std::vector<float> origin_[3], direction_[3], gain_[3], shine_[3], t_far_;
  std::vector<float> t_near_;  // 0
  std::vector<uint32_t> points_;
  size_t count_ = 0;
};

// Indirect light at a point: thrown = the radiance of a white diffuse surface lit by other surfaces alone; open = the
// unoccluded share of the sky's light.
struct ArrivingLight {
  glm::vec3 thrown{0.0f}, open{1.0f};
};

// A point of a batch as rays leave it.
struct PointAround {
  glm::vec3 origin;  // of rays that do not hit the surface itself
  glm::vec3 normal;  // the geometric one
  float width;       // of a pixel there
  float weight;      // of its light in the pixel
  uint32_t key;      // of random numbers: the place's
};

// Refers to what a block's surfaces say of one of their lobes.
struct LobeRows {
  const BlockRow (&normal)[3];
  const BlockRow& roughness;
};

class SurfaceBatch {
 public:
  // The caller keeps the scene. `isa` is named as Embree does. `viewer`: the way to the viewer, for a fixed function
  // without a local one.
  void begin(const ShadingScene& scene, const std::string& isa, glm::vec3 viewer = {0, 0, 1});

  // Returns how many lights shadow rays go to: the scene's, or those of its fixed function.
  size_t lights() const { return scene_->snapshot->fixed ? shadowed_ : scene_->lights.size(); }

  // Takes the points over, and fills around() except for what the mirror directions show, which starts black.
  void load(std::span<const SurfacePoint> points);
  // The same with the surfaces of hits.
  void load(std::span<const HitPlace> hits);

  // Darkens the sky's light at the points by its visible shares: one `shares` a block.
  void hide_sky(std::span<const SkyShares> shares);

  // Returns whether anything of a point is matt.
  bool is_matt(size_t point) const;
  PointAround point_around(size_t point) const;
  // Replaces the unoccluded sky's irradiance of diffuse surfaces by what arrives.
  void let_arrive(std::span<const ArrivingLight> arriving);
  // The same for the mirrored environment, which reflect_environment() has filled in.
  void let_arrive_in_mirrors(std::span<const ArrivingLight> arriving);

  // Lets the mirror directions show the prefiltered environment.
  void reflect_environment();
  // The same for the lanes of one block whose bit is set, without coats.
  void reflect_environment(size_t block, uint32_t lanes);

  // Writes what environment_specular_at() says of each place, bit for bit.
  void surroundings(std::span<const EnvironmentPlace> places, glm::vec3* radiance) const;

  // Writes radiance[i] = emission and light from the surroundings of point i. With the fixed function: what is lit without
  // shadow rays; show() does the rest.
  void finish(glm::vec3* radiance);
  // Where the fixed function shades: makes what is lit, and shine(), the displayed values. Else changes nothing.
  void show(glm::vec3* radiance);
  // Returns whether the fixed function adds highlights behind textures: they are in shine(), which light is added to
  // after finish().
  bool is_separate() const { return scene_->snapshot->fixed && scene_->snapshot->fixed->separate_specular; }
  glm::vec3* shine() { return shine_.data(); }

  // Does what finish() does, and adds all lights of the scene, with nothing in their way.
  void finish_unblocked(glm::vec3* radiance);

  // Writes what all lights() add, with nothing in their way. `shine`, of it what is added behind textures, may be null.
  void unblocked(glm::vec3* radiance, glm::vec3* shine = nullptr);

  // Says what blend_of() says of each point, and weighs each by its cover. `hits` are those that were loaded.
  void blend(std::span<const HitPlace> hits, shading::SrBlend* blends);

  // Draws lights for the points of one block, and appends their shadow rays, which end at this share of the way. The gain
  // of a light that is drawn grows as its odds fall, so that on average the rays gain what all lights add. Adds what they
  // add to `offered`, where it is not null, which counts from the batch's first point.
  void draw(size_t block, const LightOdds& odds, float share, ShadowRays& rays, glm::vec3* offered);

  // Appends the shadow rays of the points that gain from the light, which end at this share of the way to it.
  void gather(size_t light, float share, ShadowRays& rays);
  // Computes what the light adds to every block's points.
  std::span<const LightBlock> light(const shading::SrLight& light);
  // The same of one block, lanes behind the last point included.
  void light(size_t block, const shading::SrLight& light, LightBlock& result) const;

  size_t size() const { return count_; }
  size_t blocks() const { return blocks_.size(); }
  std::span<AroundBlock> around() { return around_; }
  std::span<const AroundBlock> around() const { return around_; }

 private:
  // Holds what draw() needs of a light: its block, and the greatest channel of each gain.
  struct Candidate {
    LightBlock light;
    BlockRow size;
  };
  LightTerms terms_of(size_t light) const;
  void start_fixed(glm::vec3* radiance);
  void clear_traits();
  void add_traits(float weight, float width, uint32_t key);
  void look_around();
  void list_candidates(size_t block, BlockRow& total, glm::vec3* offered);
  void store_radiance(size_t block, const BlockRow (&rows)[3], glm::vec3* radiance) const;
  void look_up(const BlockRow (&mirror)[3], const LobeRows& lobe, uint32_t lanes, BlockRow (&radiance)[3]) const;

  const ShadingScene* scene_ = nullptr;
  const ShadeKernels* kernels_ = nullptr;
  size_t count_ = 0;
  std::vector<SurfaceBlock> blocks_;
  std::vector<AroundBlock> around_;
  std::vector<LightBlock> lights_;
  std::vector<Candidate> candidates_;  // of one block, one a light
  std::vector<float> weights_, widths_;
  std::vector<uint32_t> keys_;
  EnvironmentLevels levels_{};
  std::vector<FixedLightTerms> fixed_lights_;  // those of the scene, seen by the viewer
  size_t shadowed_ = 0;                        // so many of them, the first ones, have shadows
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
