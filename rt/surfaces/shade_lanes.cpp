// Is compiled once for each instruction set (sideray_lanes() in rt/CMakeLists.txt; rt/base/lanes.h). Any thread may
// call the kernels.
#include "rt/surfaces/image_lanes.h"
#include "rt/surfaces/surface_lanes.h"

namespace sideray::rt::SIDERAY_LANES {

SIDERAY_LANE real3 start_of_ray(const SurfaceBlock& block, int at, real3 direction) {
  const real3 normal = load3(block.geometric_normal, at);
  const real offset = load(block.offset + at);
  return load3(block.position, at) + normal * sr_select(dot(normal, direction) < 0.0f, -offset, offset);
}

SIDERAY_LANE SrLight light_of(const LightTerms& terms) {
  return {{terms.position[0], terms.position[1], terms.position[2]},
          {terms.direction[0], terms.direction[1], terms.direction[2]},
          {terms.intensity[0], terms.intensity[1], terms.intensity[2]},
          terms.range,
          terms.cos_inner,
          terms.cos_outer,
          terms.type};
}

// Returns which hits the light can reach, so that the rest of a surface is loaded only for those.
SIDERAY_LANE boolean reaches(const SurfaceBlock& block, int at, const SrIncidence& in) {
  constexpr int normal = 0, behind = 10;  // rows of an SrSurface
  SrSurface facing;
  facing.normal = load3(reinterpret_cast<const BlockRow(&)[3]>(block.surface[normal]), at);
  facing.behind = load3(reinterpret_cast<const BlockRow(&)[3]>(block.surface[behind]), at);
  return sr_faces(facing, in.to_light) && largest(in.irradiance) > 0.0f;
}

SIDERAY_LANE real3 gain_of(const SurfaceBlock& block, int at, const SrIncidence& in) {
  return sr_times(sr_reflect_light(load_surface(block, at), load3(block.to_eye, at), in.to_light), in.irradiance);
}

SIDERAY_LANE SrFixedLight fixed_light_of(const FixedLightTerms& t) {
  const auto three_of = [](const float(&v)[3]) { return one_real3{v[0], v[1], v[2]}; };
  return {three_of(t.place),
          t.distant,
          three_of(t.ambient),
          three_of(t.diffuse),
          three_of(t.specular),
          three_of(t.axis),
          t.exponent,
          t.cos_cutoff,
          three_of(t.attenuation),
          three_of(t.viewer),
          t.local_viewer};
}

// Computes the contribution of a fixed-function light; highlights go into `lit` unless they are `separate`.
SIDERAY_LANE SrFixedGain fixed_gain(const SurfaceBlock& block, int at, const SrSurface& s, const SrFixedLight& light,
                                    const SrFixedIncidence& in, bool separate) {
  SrFixedGain gain = sr_fixed_gain(s, light, in, load3(block.to_eye, at));
  if (!separate) {
    gain.lit = gain.lit + gain.shine;
    gain.shine = sr_real3(0.0f);
  }
  return gain;
}

void fixed_light_block(const SurfaceBlock& block, const FixedLightTerms& terms, LightBlock& result) {
  const SrFixedLight light = fixed_light_of(terms);
  result.reached = 0;
  result.separate = terms.separate;
  for (int at = 0; at < static_cast<int>(block_size); at += lane_count) {
    const SrFixedIncidence in = sr_fixed_incidence(light, load3(block.position, at));
    const SrFixedGain gain = fixed_gain(block, at, load_surface(block, at), light, in, terms.separate);
    const uint32_t gains = lane_bits(largest(gain.lit + gain.shine) > 0.0f);
    if (gains == 0) continue;
    result.reached |= gains << at;
    store3(result.gain, at, gain.lit);
    if (terms.separate) store3(result.shine, at, gain.shine);
    store3(result.direction, at, in.to_light);
    store(result.distance + at, in.distance);
    store3(result.origin, at, start_of_ray(block, at, in.to_light));
  }
}

void start_fixed(const SurfaceBlock& block, const FixedLightTerms* lights, size_t count, BlockRow (&lit)[3],
                 BlockRow (&shine)[3]) {
  for (int at = 0; at < static_cast<int>(block_size); at += lane_count) {
    const SrSurface s = load_surface(block, at);
    real3 sum = s.emissive, shines = sr_real3(0.0f);
    for (size_t i = 0; i < count; ++i) {
      const SrFixedLight light = fixed_light_of(lights[i]);
      const SrFixedIncidence in = sr_fixed_incidence(light, load3(block.position, at));
      sum = sum + sr_fixed_ambient(s, light, in);
      if (lights[i].casts_shadows) continue;
      const SrFixedGain gain = fixed_gain(block, at, s, light, in, lights[i].separate);
      sum = sum + gain.lit;
      shines = shines + gain.shine;
    }
    store3(lit, at, sum);
    store3(shine, at, shines);
  }
}

void finish_fixed(const SurfaceBlock& block, const AroundBlock& around, BlockRow (&lit)[3], const BlockRow (&shine)[3]) {
  for (int at = 0; at < static_cast<int>(block_size); at += lane_count)
    store3(lit, at,
           sr_fixed_color(load_surface(block, at), load3(lit, at), load3(shine, at), load3(around.specular, at)));
}

void light_block(const SurfaceBlock& block, const LightTerms& terms, LightBlock& result) {
  if (terms.fixed) return fixed_light_block(block, *terms.fixed, result);
  result.separate = false;
  const SrLight light = light_of(terms);
  result.reached = 0;
  for (int at = 0; at < static_cast<int>(block_size); at += lane_count) {
    const SrIncidence in = sr_incidence(light, load3(block.position, at));
    const boolean faces = reaches(block, at, in);
    if (!sr_any(faces)) continue;
    const real3 gain = gain_of(block, at, in);
    const uint32_t gains = lane_bits(faces && largest(gain) > 0.0f);
    if (gains == 0) continue;
    result.reached |= gains << at;
    store3(result.gain, at, gain);
    store3(result.direction, at, in.to_light);
    store(result.distance + at, in.distance);
    store3(result.origin, at, start_of_ray(block, at, in.to_light));
  }
}

// Writes the lanes whose bit is set to consecutive floats at `to`; may overwrite more floats behind them.
SIDERAY_LANE void pack_row(const BlockRow& row, uint32_t lanes, float* to) {
#if defined(__AVX512F__) && SIDERAY_LANE_COUNT == 16
  _mm512_storeu_ps(to, _mm512_maskz_compress_ps(static_cast<__mmask16>(lanes), _mm512_load_ps(row)));
#else
  for (; lanes != 0; lanes &= lanes - 1) *to++ = row[__builtin_ctz(lanes)];
#endif
}

uint32_t pack_rays(const LightBlock& light, float share, uint32_t point, uint32_t first,
                   const ShadowRayColumns& columns) {
  const uint32_t lanes = light.reached;
  if (lanes == 0) return 0;
  alignas(64) BlockRow ends;
  for (int at = 0; at < static_cast<int>(block_size); at += lane_count)
    store(ends + at, load(light.distance + at) * share);
  for (int c = 0; c < 3; ++c) {
    pack_row(light.origin[c], lanes, columns.origin[c] + first);
    pack_row(light.direction[c], lanes, columns.direction[c] + first);
    pack_row(light.gain[c], lanes, columns.gain[c] + first);
    if (light.separate) pack_row(light.shine[c], lanes, columns.shine[c] + first);
  }
  pack_row(ends, lanes, columns.t_far + first);
  uint32_t count = 0;
  for (uint32_t bits = lanes; bits != 0; bits &= bits - 1)
    columns.point[first + count++] = point + static_cast<uint32_t>(__builtin_ctz(bits));
  return count;
}

void add_fixed_light(const SurfaceBlock& block, const FixedLightTerms& terms, BlockRow (&lit)[3], BlockRow (&shine)[3]) {
  const SrFixedLight light = fixed_light_of(terms);
  for (int at = 0; at < static_cast<int>(block_size); at += lane_count) {
    const SrFixedIncidence in = sr_fixed_incidence(light, load3(block.position, at));
    const SrFixedGain gain = fixed_gain(block, at, load_surface(block, at), light, in, terms.separate);
    store3(lit, at, load3(lit, at) + gain.lit);
    if (terms.separate) store3(shine, at, load3(shine, at) + gain.shine);
  }
}

void add_light(const SurfaceBlock& block, const LightTerms& terms, BlockRow (&radiance)[3], BlockRow (&shine)[3]) {
  if (terms.fixed) return add_fixed_light(block, *terms.fixed, radiance, shine);
  const SrLight light = light_of(terms);
  for (int at = 0; at < static_cast<int>(block_size); at += lane_count) {
    const SrIncidence in = sr_incidence(light, load3(block.position, at));
    const boolean faces = reaches(block, at, in);
    if (!sr_any(faces)) continue;
    const real3 gain = gain_of(block, at, in), before = load3(radiance, at);
    store3(radiance, at, sr_select(faces && largest(gain) > 0.0f, before + gain, before));
  }
}

void blend_block(const SurfaceBlock& block, const BlockRow& modes, BlendBlock& result) {
  for (int at = 0; at < static_cast<int>(block_size); at += lane_count) {
    const integer mode(as_int(load(modes + at).v));
    const SrBlend blended = sr_blend(load_surface(block, at), load3(block.to_eye, at), mode);
    store(result.cover + at, blended.cover);
    store3(result.through, at, blended.through);
  }
}

SIDERAY_LANE real3 mirror_direction(const SurfaceBlock& block, int at, real3 normal, real3 to_eye) {
  const real3 r = normal * (2.0f * dot(normal, to_eye)) - to_eye;
  return sr_lifted(r, load3(block.geometric_normal, at));
}

void look_around(const SurfaceBlock& block, TexelView irradiance, AroundBlock& result) {
  result.coated = result.alike = result.brushed = 0;
  for (int at = 0; at < static_cast<int>(block_size); at += lane_count) {
    const SrSurface s = load_surface(block, at);
    const real3 to_eye = load3(block.to_eye, at);
    store3(result.irradiance, at, sample_latlong(irradiance, s.normal));
    const bool behind = sr_any(largest(s.behind) > 0.0f);
    store3(result.behind, at, behind ? sample_latlong(irradiance, -s.normal) : sr_real3(0.0f));
    store(result.share + at, largest(sr_specular_albedo(s)) * s.below_sheen * (1.0f - s.coat_share) * s.occlusion);
    store(result.coat_share + at, s.coat_share * s.occlusion);
    const uint32_t brushed = lane_bits(s.anisotropy > 0.0f);
    if (brushed != 0) result.brushed |= brushed << at;
    const real3 normal = brushed != 0 ? sr_bent(s, to_eye) : s.normal;
    store3(result.normal, at, normal);
    store(result.roughness + at, brushed != 0 ? sr_look_up_roughness(s) : s.roughness);
    const real3 mirror = mirror_direction(block, at, normal, to_eye);
    store3(result.mirror, at, mirror);
    store3(result.mirror_origin, at, start_of_ray(block, at, mirror));
    const uint32_t coated = lane_bits(s.coat_share > 0.0f);
    if (coated == 0) continue;
    result.coated |= coated << at;
    const real3 apart = s.coat_normal - s.normal;
    const boolean differs =
        dot(apart, apart) > 0.0f || abs(s.coat_roughness - s.roughness) > 0.0f || s.anisotropy > 0.0f;
    result.alike |= (coated & ~lane_bits(differs)) << at;
    const real3 coat_mirror = mirror_direction(block, at, s.coat_normal, to_eye);
    store3(result.coat_mirror, at, coat_mirror);
    store3(result.coat_origin, at, start_of_ray(block, at, coat_mirror));
  }
}

void hide_sky(const SurfaceBlock& block, TexelView irradiance, const SkyShares& shares, AroundBlock& result) {
  for (int at = 0; at < static_cast<int>(block_size); at += lane_count) {
    const SrSurface s = load_surface(block, at);
    const real3 behind = sample_latlong(irradiance, -s.normal);
    store3(result.irradiance, at, sr_sky_light(load3(result.irradiance, at), behind, load(shares.open + at),
                                               load(shares.unhidden + at), s.diffuse));
  }
}

void places_of_lobes(const BlockRow (&normal)[3], const BlockRow (&mirror)[3], const BlockRow& roughness,
                     BlockRow (&uv)[2]) {
  for (int at = 0; at < static_cast<int>(block_size); at += lane_count) {
    const real2 place = sr_latlong(sr_dominant(load3(normal, at), load3(mirror, at), load(roughness + at)));
    store(uv[0] + at, place.x);
    store(uv[1] + at, place.y);
  }
}

void finish_block(const SurfaceBlock& block, const AroundBlock& around, BlockRow (&radiance)[3]) {
  for (int at = 0; at < static_cast<int>(block_size); at += lane_count) {
    const SrSurface s = load_surface(block, at);
    const SrSurroundings light = {load3(around.irradiance, at), load3(around.behind, at), load3(around.specular, at),
                                  load3(around.coat, at)};
    // For a NaN normal the look-ups return a number, and so must this.
    const real cosine = abs(dot(s.normal, load3(block.to_eye, at)));
    const real n_v = sr_select(cosine > 0.0f, min(cosine, real(1.0f)), real(0.0f));
    store3(radiance, at, sr_emitted(s) + sr_environment(s, n_v, light));
  }
}

const ShadeKernels& shade_kernels() {
  static constexpr ShadeKernels table{SIDERAY_LANES_NAME, surfaces_of_hits, unload_points,  load_points,
                                      blend_block,        light_block,      add_light,      look_around,
                                      hide_sky,           pack_rays,        places_of_lobes, specular_block,
                                      finish_block,       start_fixed,      finish_fixed};
  return table;
}

}  // namespace sideray::rt::SIDERAY_LANES
