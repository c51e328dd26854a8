// Does the arithmetic of shading sixteen hits at a time, compiled for several instruction sets: plain arrays in, plain
// arrays out. Names no types of GLM or the library: the files that implement it share no inline functions. Any thread
// may call it.
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
  // In place of what is above, where it is a light of the fixed function; else null.
  const struct FixedLightTerms* fixed = nullptr;
};

// Holds a light as shading::SrFixedLight does.
struct FixedLightTerms {
  float place[3], distant, ambient[3], diffuse[3], specular[3], axis[3], exponent, cos_cutoff, attenuation[3], viewer[3],
      local_viewer;
  bool separate;  // its highlights are added apart
  bool casts_shadows;
};

// Holds a light's contribution to the hits of a block, if nothing blocks it, and the shadow rays that find out.
struct alignas(64) LightBlock {
  BlockRow origin[3], direction[3];
  BlockRow distance;
  BlockRow gain[3];
  BlockRow shine[3];  // of highlights that are added apart
  uint32_t reached;   // bit i: hit i gains from the light
  bool separate;      // `shine` is filled
};

// Holds the surroundings that a block's hits see.
struct alignas(64) AroundBlock {
  BlockRow irradiance[3], behind[3];
  BlockRow share, coat_share;     // weights of light from the mirror direction in what the eye sees: base and coat
  BlockRow normal[3], roughness;  // of the base's lobe, as it is looked up in prefiltered surroundings
  BlockRow mirror[3], mirror_origin[3], coat_mirror[3], coat_origin[3];  // rays
  BlockRow specular[3], coat[3];  // radiance from there: to be filled in before finish()
  uint32_t coated, alike;         // bit i: hit i has a coat; one that reflects as the base does
  uint32_t brushed;               // bit i: hit i is anisotropic
};

// Holds which share of the sky each hit of a block sees, and which share nothing opaque hides.
struct alignas(64) SkyShares {
  BlockRow open, unhidden;
};

// Holds how a block's hits are composited: what each covers, and lets through.
struct alignas(64) BlendBlock {
  BlockRow cover, through[3];
};

// Refers to columns of shadow rays and of what depends on them, with room for a block behind those that are there.
struct ShadowRayColumns {
  float *origin[3], *direction[3], *t_far, *gain[3];
  float* shine[3];  // filled where LightBlock::separate
  uint32_t* point;
};

// Holds the levels of a prefiltered environment, the sharpest first, of three floats a texel.
struct EnvironmentLevels {
  static constexpr int32_t most = 16;
  const float* texels[most];
  float width[most], height[most];
  int32_t count;  // 0: black
  bool uniform;   // places do not count
};

struct ShadeKernels {
  const char* name;
  // Makes surfaces of hits: what surface_point() makes of each, bit for bit.
  void (*surfaces)(const SurfaceTables& tables, const HitBlock& hits, SurfaceBlock& block);
  // The other way round than load(): writes the rows of the first `count` points.
  void (*unload)(const SurfaceBlock& block, uint32_t count, float* points, uint32_t stride);
  // `points`: `stride` floats from one SurfacePoint to the next.
  void (*load)(const float* points, uint32_t stride, uint32_t count, SurfaceBlock& block);
  // Computes blend_of() of each hit, with the same bits unless it is NaN; `modes` holds the bits of a
  // sideray_blend_mode each.
  void (*blend)(const SurfaceBlock& block, const BlockRow& modes, BlendBlock& result);
  void (*light)(const SurfaceBlock& block, const LightTerms& light, LightBlock& result);
  // Adds what the light adds to each hit where nothing blocks it; highlights that are added apart to `shine`.
  void (*add_light)(const SurfaceBlock& block, const LightTerms& light, BlockRow (&radiance)[3], BlockRow (&shine)[3]);
  // Fills all of `result` but specular and coat.
  void (*look_around)(const SurfaceBlock& block, TexelView irradiance, AroundBlock& result);
  // Darkens the environment's light in `result` by the share of the sky that each hit sees.
  void (*hide_sky)(const SurfaceBlock& block, TexelView irradiance, const SkyShares& shares, AroundBlock& result);
  // Writes the rays of the hits that gain, at `first` and behind it, and returns how many there are. Their ends are
  // `share` of the way to the light; hit 0 is `point`.
  uint32_t (*pack)(const LightBlock& light, float share, uint32_t point, uint32_t first,
                   const ShadowRayColumns& columns);
  // Computes where lobes are looked up in a lat-long image: at the dominant directions of their mirror directions.
  void (*places)(const BlockRow (&normal)[3], const BlockRow (&mirror)[3], const BlockRow& roughness,
                 BlockRow (&uv)[2]);
  // Samples an environment as environment_specular() does, bit for bit, at such coordinates.
  void (*specular)(const EnvironmentLevels& levels, const BlockRow (&uv)[2], const BlockRow& roughness,
                   BlockRow (&radiance)[3]);
  // Adds up emission and what comes from the surroundings.
  void (*finish)(const SurfaceBlock& block, const AroundBlock& around, BlockRow (&radiance)[3]);
  // Of the fixed function. Writes what is lit without shadow rays: what glows, ambient light, and all light that has
  // no shadows.
  void (*start_fixed)(const SurfaceBlock& block, const FixedLightTerms* lights, size_t count, BlockRow (&lit)[3],
                      BlockRow (&shine)[3]);
  // Writes the displayed values to `lit`.
  void (*finish_fixed)(const SurfaceBlock& block, const AroundBlock& around, BlockRow (&lit)[3],
                       const BlockRow (&shine)[3]);
};

// Returns the kernels for an instruction set: "avx512", "avx2", otherwise the baseline; null: the widest of the processor,
// which must have what it is asked for.
const ShadeKernels& shade_kernels(const char* isa = nullptr);

}  // namespace sideray::rt
