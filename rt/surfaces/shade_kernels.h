// Does the arithmetic of shading for sixteen hits at a time, compiled for several instruction sets; reads and writes
// plain arrays. Names no types of GLM or the standard library, because the files that implement it must not share
// inline functions. Any thread may call it.
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "rt/surfaces/block_rows.h"
#include "rt/surfaces/surface_records.h"

namespace sideray::rt {

// Holds sixteen SurfacePoints (rt/surfaces/surface.h), number by number in the same order.
struct alignas(64) SurfaceBlock {
  static constexpr uint32_t surface_rows = 46;
  BlockRow surface[surface_rows];
  BlockRow position[3], geometric_normal[3], to_eye[3];
  BlockRow offset;
};

// Holds a light as shading::SrLight does.
struct LightTerms {
  float position[3], direction[3], intensity[3];
  float range, cos_inner, cos_outer;
  int type;
  // replaces the fields above for a light of the fixed function; else null
  const struct FixedLightTerms* fixed = nullptr;
};

// Holds a light as shading::SrFixedLight does.
struct FixedLightTerms {
  float place[3], distant, ambient[3], diffuse[3], specular[3], axis[3], exponent, cos_cutoff, attenuation[3], viewer[3],
      local_viewer;
  bool separate;  // highlights are added after texturing
  bool casts_shadows;
};

// Holds a light's unoccluded contribution to the hits of a block, and the shadow rays toward it.
struct alignas(64) LightBlock {
  BlockRow origin[3], direction[3];
  BlockRow distance;
  BlockRow gain[3];
  BlockRow shine[3];  // highlights that are added after texturing
  uint32_t reached;   // bit i: hit i gains from the light
  bool separate;      // `shine` is filled
};

// Holds the surroundings that a block's hits reflect and transmit.
struct alignas(64) AroundBlock {
  BlockRow irradiance[3], behind[3];
  BlockRow share, coat_share;     // weights of light from the mirror direction in the outgoing light: base and coat
  BlockRow normal[3], roughness;  // of the base's lobe, for the look-up in prefiltered surroundings
  BlockRow mirror[3], mirror_origin[3], coat_mirror[3], coat_origin[3];  // rays
  BlockRow specular[3], coat[3];  // radiance from the mirror directions: fill these before finish()
  uint32_t coated, alike;         // bit i: hit i has a coat; hit i has a coat that reflects as the base does
  uint32_t brushed;               // bit i: hit i is anisotropic
};

// Holds for each hit of a block the visible share of the sky's light, and the share that nothing opaque hides.
struct alignas(64) SkyShares {
  BlockRow open, unhidden;
};

// Holds how much a block's hits cover, and how much they transmit.
struct alignas(64) BlendBlock {
  BlockRow cover, through[3];
};

// Refers to columns of shadow rays and their data, with room for a block behind the used part.
struct ShadowRayColumns {
  float *origin[3], *direction[3], *t_far, *gain[3];
  float* shine[3];  // filled where LightBlock::separate
  uint32_t* point;
};

// Holds the mip levels of a prefiltered environment, the sharpest first, three floats a texel.
struct EnvironmentLevels {
  static constexpr int32_t most = 16;
  const float* texels[most];
  float width[most], height[most];
  int32_t count;  // 0: the environment is black
  bool uniform;   // the same in all directions
};

struct ShadeKernels {
  const char* name;
  // Makes the surfaces of hits, with the same bits as surface_point().
  void (*surfaces)(const SurfaceTables& tables, const HitBlock& hits, SurfaceBlock& block);
  // The inverse of load(): writes the first `count` points.
  void (*unload)(const SurfaceBlock& block, uint32_t count, float* points, uint32_t stride);
  // `points`: `stride` floats from one SurfacePoint to the next.
  void (*load)(const float* points, uint32_t stride, uint32_t count, SurfaceBlock& block);
  // Computes blend_of() of each hit, with the same bits unless it is NaN. `modes` holds each hit's sideray_blend_mode
  // as bits.
  void (*blend)(const SurfaceBlock& block, const BlockRow& modes, BlendBlock& result);
  void (*light)(const SurfaceBlock& block, const LightTerms& light, LightBlock& result);
  // Adds the light's unoccluded contribution to each hit; highlights that come after texturing go to `shine`.
  void (*add_light)(const SurfaceBlock& block, const LightTerms& light, BlockRow (&radiance)[3], BlockRow (&shine)[3]);
  // Fills `result` except specular and coat.
  void (*look_around)(const SurfaceBlock& block, TexelView irradiance, AroundBlock& result);
  // Darkens the environment's light in `result` by the share of the sky that each hit sees.
  void (*hide_sky)(const SurfaceBlock& block, TexelView irradiance, const SkyShares& shares, AroundBlock& result);
  // Writes the shadow rays of the hits that the light reaches, from index `first` on, and returns their number. They
  // end at `share` of the distance to the light; hit 0 is `point`.
  uint32_t (*pack)(const LightBlock& light, float share, uint32_t point, uint32_t first,
                   const ShadowRayColumns& columns);
  // Computes where lobes sample a lat-long image: at the dominant direction of the lobe around each mirror direction.
  void (*places)(const BlockRow (&normal)[3], const BlockRow (&mirror)[3], const BlockRow& roughness,
                 BlockRow (&uv)[2]);
  // Samples an environment at such coordinates, with the same bits as environment_specular().
  void (*specular)(const EnvironmentLevels& levels, const BlockRow (&uv)[2], const BlockRow& roughness,
                   BlockRow (&radiance)[3]);
  // Adds up emission and light from the surroundings.
  void (*finish)(const SurfaceBlock& block, const AroundBlock& around, BlockRow (&radiance)[3]);
  // Fixed function: writes the light that needs no shadow rays, which is emission, ambient light and all lights without
  // shadows.
  void (*start_fixed)(const SurfaceBlock& block, const FixedLightTerms* lights, size_t count, BlockRow (&lit)[3],
                      BlockRow (&shine)[3]);
  // Fixed function: writes the displayed values to `lit`.
  void (*finish_fixed)(const SurfaceBlock& block, const AroundBlock& around, BlockRow (&lit)[3],
                       const BlockRow (&shine)[3]);
};

// Returns the kernels of an instruction set: "avx512", "avx2", otherwise the baseline; null selects the processor's
// widest. The processor must have the set.
const ShadeKernels& shade_kernels(const char* isa = nullptr);

}  // namespace sideray::rt
