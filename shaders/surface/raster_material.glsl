// The material of the surface being drawn. SR_MAPS: bit k set = texture slot k may be present (in the order below, that
// of model/material_slots.h). SR_LOBES: 1 clear coat, 2 sheen, 4 diffuse transmission, 8 thin film, 16 anisotropy;
// others are omitted.
layout(std140) uniform Material {
  vec4 base_color;
  vec4 emissive_metallic;
  vec4 specular_color_roughness;
  vec4 absorption_transmission;
  vec4 ior_thickness_specular_normal_scale;
  vec4 occlusion_alpha_cutoff_spread;  // xyz
  vec4 coat_roughness_normal_scale;      // xyz
  vec4 sheen_color_roughness;
  vec4 diffuse_transmission_color_share;
  vec4 film_ior_thickness;  // share, ior, thickness at texture values 0 and 1
  vec4 anisotropy_cosine_sine;  // strength, cosine and sine of the rotation
  ivec4 unlit_blend_alpha_mode_maps;  // maps: bit k set = slot k has a texture
  vec4 texture_from_uv[38];           // two rows a slot; w of the first is the uv set
}
material;

#if (SR_MAPS & 0x1) != 0
uniform sampler2D base_color_map;
#endif
#if (SR_MAPS & 0x2) != 0
uniform sampler2D metallic_roughness_map;
#endif
#if (SR_MAPS & 0x4) != 0
uniform sampler2D normal_map;
#endif
#if (SR_MAPS & 0x8) != 0
uniform sampler2D occlusion_map;
#endif
#if (SR_MAPS & 0x10) != 0
uniform sampler2D emissive_map;
#endif
#if (SR_MAPS & 0x20) != 0
uniform sampler2D transmission_map;
#endif
#if (SR_MAPS & 0x40) != 0
uniform sampler2D thickness_map;
#endif
#if (SR_MAPS & 0x80) != 0
uniform sampler2D specular_map;
#endif
#if (SR_MAPS & 0x100) != 0
uniform sampler2D specular_color_map;
#endif
#if (SR_MAPS & 0x200) != 0
uniform sampler2D clearcoat_map;
#endif
#if (SR_MAPS & 0x400) != 0
uniform sampler2D clearcoat_roughness_map;
#endif
#if (SR_MAPS & 0x800) != 0
uniform sampler2D clearcoat_normal_map;
#endif
#if (SR_MAPS & 0x1000) != 0
uniform sampler2D sheen_color_map;
#endif
#if (SR_MAPS & 0x2000) != 0
uniform sampler2D sheen_roughness_map;
#endif
#if (SR_MAPS & 0x4000) != 0
uniform sampler2D diffuse_transmission_map;
#endif
#if (SR_MAPS & 0x8000) != 0
uniform sampler2D diffuse_transmission_color_map;
#endif
#if (SR_MAPS & 0x10000) != 0
uniform sampler2D iridescence_map;
#endif
#if (SR_MAPS & 0x20000) != 0
uniform sampler2D iridescence_thickness_map;
#endif
#if (SR_MAPS & 0x40000) != 0
uniform sampler2D anisotropy_map;
#endif

in vec4 v_uv;
in vec4 v_color;

vec2 map_position(int slot) {
  vec4 row_s = material.texture_from_uv[2 * slot], row_t = material.texture_from_uv[2 * slot + 1];
  vec2 uv = row_s.w > 0.5 ? v_uv.zw : v_uv.xy;
  return vec2(dot(row_s.xyz, vec3(uv, 1.0)), dot(row_t.xyz, vec3(uv, 1.0)));
}

vec4 base_color_texel() {
#if (SR_MAPS & 1) != 0
  return texture(base_color_map, map_position(0)) * v_color;
#else
  return v_color;
#endif
}

// Returns whether a fragment with this texel is absent: MASK below its cut-off, BLEND below what 8 bits can show.
bool is_absent(vec4 texel) {
  float alpha = material.base_color.w * texel.w;
  int mode = material.unlit_blend_alpha_mode_maps.z;
  return mode == 1 ? alpha < material.occlusion_alpha_cutoff_spread.y : mode == 2 && alpha < 1.0 / 255.0;
}

#ifdef SR_SHADED
in vec3 v_normal;
in vec4 v_tangent;
flat in uint v_solid;

SrMaterial surface_material() {
  SrMaterial m;
  m.base_color = material.base_color;
  m.emissive = material.emissive_metallic.xyz;
  m.specular_color = material.specular_color_roughness.xyz;
  m.absorption = material.absorption_transmission.xyz;
  m.metallic = material.emissive_metallic.w;
  m.roughness = material.specular_color_roughness.w;
  m.transmission = material.absorption_transmission.w;
  m.ior = material.ior_thickness_specular_normal_scale.x;
  m.thickness = material.ior_thickness_specular_normal_scale.y;
  m.specular = material.ior_thickness_specular_normal_scale.z;
#if (SR_LOBES & 1) != 0
  m.clearcoat = material.coat_roughness_normal_scale.x;
  m.clearcoat_roughness = material.coat_roughness_normal_scale.y;
#else
  m.clearcoat = 0.0;
  m.clearcoat_roughness = 0.0;
#endif
#if (SR_LOBES & 2) != 0
  m.sheen_color = material.sheen_color_roughness.xyz;
  m.sheen_roughness = material.sheen_color_roughness.w;
#else
  m.sheen_color = vec3(0.0);
  m.sheen_roughness = 0.0;
#endif
#if (SR_LOBES & 4) != 0
  m.diffuse_transmission = material.diffuse_transmission_color_share.w;
  m.diffuse_transmission_color = material.diffuse_transmission_color_share.xyz;
#else
  m.diffuse_transmission = 0.0;
  m.diffuse_transmission_color = vec3(1.0);
#endif
#if (SR_LOBES & 8) != 0
  m.iridescence = material.film_ior_thickness.x;
  m.iridescence_ior = material.film_ior_thickness.y;
  m.iridescence_thickness_min = material.film_ior_thickness.z;
  m.iridescence_thickness_max = material.film_ior_thickness.w;
#else
  m.iridescence = 0.0;
  m.iridescence_ior = 1.0;
  m.iridescence_thickness_min = 0.0;
  m.iridescence_thickness_max = 0.0;
#endif
#if (SR_LOBES & 16) != 0
  m.anisotropy = material.anisotropy_cosine_sine.x;
  m.anisotropy_cosine = material.anisotropy_cosine_sine.y;
  m.anisotropy_sine = material.anisotropy_cosine_sine.z;
#else
  m.anisotropy = 0.0;
  m.anisotropy_cosine = 1.0;
  m.anisotropy_sine = 0.0;
#endif
  m.alpha_mode = material.unlit_blend_alpha_mode_maps.z;
  m.unlit = material.unlit_blend_alpha_mode_maps.x != 0;
  return m;
}

SrTexels surface_texels(vec4 base_color) {
  SrTexels t = SrTexels(base_color, vec3(1.0), 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, vec3(1.0), 1.0, 1.0, vec3(1.0), 1.0, 1.0,
                        vec3(1.0), 1.0, 1.0, 1.0, 0.0, 1.0);
#if (SR_MAPS & 0x2) != 0
  vec4 metallic_roughness = texture(metallic_roughness_map, map_position(1));
  t.metallic = metallic_roughness.z;
  t.roughness = metallic_roughness.y;
#endif
#if (SR_MAPS & 0x8) != 0
  float occlusion = texture(occlusion_map, map_position(3)).x;
  t.occlusion = 1.0 + material.occlusion_alpha_cutoff_spread.x * (occlusion - 1.0);
#endif
#if (SR_MAPS & 0x10) != 0
  t.emissive = texture(emissive_map, map_position(4)).xyz;
#endif
#if (SR_MAPS & 0x20) != 0
  t.transmission = texture(transmission_map, map_position(5)).x;
#endif
#if (SR_MAPS & 0x40) != 0
  t.thickness = texture(thickness_map, map_position(6)).y;
#endif
  // A solid absorbs once, where rays enter it.
  if (v_solid != 0u && !gl_FrontFacing) t.thickness = 0.0;
#if (SR_MAPS & 0x80) != 0
  t.specular = texture(specular_map, map_position(7)).w;
#endif
#if (SR_MAPS & 0x100) != 0
  t.specular_color = texture(specular_color_map, map_position(8)).xyz;
#endif
#if (SR_MAPS & 0x200) != 0
  t.clearcoat = texture(clearcoat_map, map_position(9)).x;
#endif
#if (SR_MAPS & 0x400) != 0
  t.clearcoat_roughness = texture(clearcoat_roughness_map, map_position(10)).y;
#endif
#if (SR_MAPS & 0x1000) != 0
  t.sheen_color = texture(sheen_color_map, map_position(12)).xyz;
#endif
#if (SR_MAPS & 0x2000) != 0
  t.sheen_roughness = texture(sheen_roughness_map, map_position(13)).w;
#endif
#if (SR_MAPS & 0x4000) != 0
  t.diffuse_transmission = texture(diffuse_transmission_map, map_position(14)).w;
#endif
#if (SR_MAPS & 0x8000) != 0
  t.diffuse_transmission_color = texture(diffuse_transmission_color_map, map_position(15)).xyz;
#endif
#if (SR_MAPS & 0x10000) != 0
  t.iridescence = texture(iridescence_map, map_position(16)).x;
#endif
#if (SR_MAPS & 0x20000) != 0
  t.iridescence_thickness = texture(iridescence_thickness_map, map_position(17)).y;
#endif
#if (SR_MAPS & 0x40000) != 0
  if ((material.unlit_blend_alpha_mode_maps.w & 0x40000) != 0) {  // a white texture would turn the direction
    vec3 brushed = texture(anisotropy_map, map_position(18)).xyz;
    t.anisotropy_along = brushed.x * 2.0 - 1.0;
    t.anisotropy_across = brushed.y * 2.0 - 1.0;
    t.anisotropy = brushed.z;
  }
#endif
  return t;
}

// Returns the interpolated normal, bent by a normal map's texel.
vec3 bent_normal(vec3 normal, vec3 texel, float scale) {
  vec3 tangent = v_tangent.xyz / max(length(v_tangent.xyz), 1e-20);
  return sr_perturb(normal, vec4(tangent, v_tangent.w), texel * 2.0 - 1.0, scale);
}

#if (SR_LOBES & 16) != 0
// Applies sr_brushed() in the frame of the drawn surface.
SrSurface brushed_surface(SrSurface s, SrMaterial m, SrTexels t) {
  vec3 tangent = v_tangent.xyz / max(length(v_tangent.xyz), 1e-20);
  return sr_brushed(s, m, t, normalize(v_normal), vec4(tangent, v_tangent.w));
}
#endif

// Returns the shading normal on the visible side.
vec3 surface_normal() {
  vec3 n = normalize(v_normal);
#if (SR_MAPS & 0x4) != 0
  if ((material.unlit_blend_alpha_mode_maps.w & 0x4) != 0)
    n = bent_normal(n, texture(normal_map, map_position(2)).xyz, material.ior_thickness_specular_normal_scale.w);
#endif
  return gl_FrontFacing ? n : -n;
}

// Returns the coat's normal on the visible side; without a map of its own the coat is smooth over a bumpy base.
vec3 surface_coat_normal() {
  vec3 n = normalize(v_normal);
#if (SR_MAPS & 0x800) != 0
  if ((material.unlit_blend_alpha_mode_maps.w & 0x800) != 0)
    n = bent_normal(n, texture(clearcoat_normal_map, map_position(11)).xyz, material.coat_roughness_normal_scale.z);
#endif
  return gl_FrontFacing ? n : -n;
}
#endif
