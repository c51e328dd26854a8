// Camera-facing sprites, for both raster fragments (GLSL) and ray hits (C++): in the dialect of shading.h, included
// after it.

// Returns a sprite's surface: it emits radiance if it is not lit, otherwise it has a diffuse albedo. `fade` 0..1
// removes all of it; `blend` as in sr_blend.
SR_FN SrSurface sr_sprite(real4 color, real3 normal, boolean lit, real fade, integer blend) {
  SrSurface s;
  // Premultiplied radiance is added completely, so alpha does not fade it.
  real3 radiance = real3(color.x, color.y, color.z) * sr_select(blend == 1, fade, real(1.0f));
  s.normal = normal;
  s.albedo = radiance;
  s.metallic = real(0.0f);
  s.diffuse = sr_select(lit, radiance, sr_real3(0.0f));
  s.behind = sr_real3(0.0f);
  s.f0 = sr_real3(0.0f);
  s.f90 = sr_real3(0.0f);
  s.emissive = sr_select(lit, sr_real3(0.0f), radiance);
  s.tint = sr_real3(0.0f);
  s.alpha = sr_saturate(color.w) * fade;
  s.roughness = real(1.0f);
  s.occlusion = real(1.0f);
  s.coat = real(0.0f);
  s.coat_roughness = real(1.0f);
  s.coat_normal = normal;
  s.sheen = sr_real3(0.0f);
  s.sheen_roughness = real(1.0f);
  s.along = sr_real3(0.0f);
  s.anisotropy = real(0.0f);
  s.coat_share = real(0.0f);
  s.below_sheen = real(1.0f);
  s.sheen_albedo = real(0.0f);
  s.albedo_terms = real2(0.0f, 0.0f);
  return s;
}

// Returns whether alpha is too small to draw, before fading; premultiplied sprites add light without alpha.
SR_FN boolean sr_sprite_absent(real alpha, integer blend) {
  return blend != 1 && alpha < 1.0f / 255.0f;
}

// Returns the share that remains at a distance of `gap` in front of an opaque surface; `soft_distance` 0 = all.
SR_FN real sr_soft_fade(real gap, real soft_distance) {
  return sr_select(soft_distance > 0.0f, sr_saturate(gap / max(soft_distance, 1e-20f)), real(1.0f));
}

// Returns the mip level of a whole sprite: `texels` of a cell across its `size`; a pixel is `pixel` wide, world units.
SR_FN real sr_sprite_level(real2 texels, real2 size, real pixel, real last_level) {
  real across = max(texels.x / size.x, texels.y / size.y) * pixel;
  return clamp(log2(max(across, 1e-6f)), 0.0f, last_level);
}

// Returns where to read a flip-book at `corner` of a cell (0..1 each way, from the top left): at least half a texel of
// the coarser of the two mip levels away from the next cell, so that its texels are not mixed in.
SR_FN real2 sr_sprite_place(real2 corner, real2 cell, real2 cells, real2 texels, real level) {
  real half_texel = 0.5f * exp2(ceil(level));
  real inset_x = min(half_texel, 0.5f * texels.x), inset_y = min(half_texel, 0.5f * texels.y);
  real x = clamp(corner.x * texels.x, inset_x, texels.x - inset_x);
  real y = clamp(corner.y * texels.y, inset_y, texels.y - inset_y);
  return real2((cell.x + x / texels.x) / cells.x, (cell.y + y / texels.y) / cells.y);
}
