// Computes the radiance from a surface toward the eye: punctual lights with shadow maps, and the environment. SR_LOBES:
// as in raster_material.glsl. SR_MASKS: for opaque pixels, whose shadows are in masks. SR_MANY_LIGHTS: there are more
// lights than uniform blocks hold.
struct LightRecord {
  vec4 position_range;
  vec4 direction_inner;
  vec4 intensity_outer;
  // type; map: 0 none, 1 directional, 2 one frustum, 3 six faces; first layer; bits of the texel's size: world units
  // for a directional light, otherwise world units per unit of distance along the frustum's axis.
  ivec4 type_map_layer_texel;
};
#ifdef SR_MANY_LIGHTS
uniform sampler2D light_texels;  // rows of 256 lights; 8 texels each: the record, its integers as floats, then the matrix

vec4 light_texel(int i, int k) {
  return texelFetch(light_texels, ivec2(8 * (i & 255) + k, i >> 8), 0);
}

vec4 light_position_range(int i) {
  return light_texel(i, 0);
}

vec4 light_direction_inner(int i) {
  return light_texel(i, 1);
}

vec4 light_intensity_outer(int i) {
  return light_texel(i, 2);
}

ivec4 light_type_map_layer_texel(int i) {
  vec4 traits = light_texel(i, 3);
  return ivec4(ivec3(traits.xyz), floatBitsToInt(traits.w));
}

mat4 shadow_matrix(int i) {
  return mat4(light_texel(i, 4), light_texel(i, 5), light_texel(i, 6), light_texel(i, 7));
}
#else
layout(std140) uniform Lights {
  LightRecord lights[256];
};
layout(std140) uniform Shadows {
  // Map 1 and 2: texture coordinates and depth, times w. Map 3: column 0 holds (a, b, 1 / tan(half angle)), with depth
  // = a + b / distance along the face's axis.
  mat4 shadow_from_local[256];
};

vec4 light_position_range(int i) {
  return lights[i].position_range;
}

vec4 light_direction_inner(int i) {
  return lights[i].direction_inner;
}

vec4 light_intensity_outer(int i) {
  return lights[i].intensity_outer;
}

ivec4 light_type_map_layer_texel(int i) {
  return lights[i].type_map_layer_texel;
}

mat4 shadow_matrix(int i) {
  return shadow_from_local[i];
}
#endif

uniform int light_count;
uniform bool shadows_on;
uniform vec3 eye;
uniform vec3 toward_eye;  // for orthographic views
uniform bool orthographic;
uniform sampler2DArrayShadow directional_shadows;
uniform sampler2DArrayShadow local_shadows;
uniform sampler2D environment_specular;
uniform sampler2D environment_irradiance;
uniform float environment_last_level;
uniform sampler2D albedo_terms;

vec3 direction_to_eye(vec3 position) {
  return orthographic ? toward_eye : normalize(eye - position);
}

SrLight light_at(int i) {
  vec4 position_range = light_position_range(i);
  vec4 direction_inner = light_direction_inner(i);
  vec4 intensity_outer = light_intensity_outer(i);
  return SrLight(position_range.xyz, direction_inner.xyz, intensity_outer.xyz, position_range.w, direction_inner.w,
                 intensity_outer.w, light_type_map_layer_texel(i).x);
}

// Returns the lit share of a 3x3 neighbourhood: four bilinear taps between texels weigh it as a tent.
float lit_share(sampler2DArrayShadow map, vec3 where, float layer) {
  vec2 step = 0.5 / vec2(textureSize(map, 0).xy);
  float reference = clamp(where.z, 0.0, 1.0);
  return 0.25 * (texture(map, vec4(where.xy - step, layer, reference)) +
                 texture(map, vec4(where.x + step.x, where.y - step.y, layer, reference)) +
                 texture(map, vec4(where.x - step.x, where.y + step.y, layer, reference)) +
                 texture(map, vec4(where.xy + step, layer, reference)));
}

// Moves the lookup off the surface along its normal, in proportion to the sine of the angle between normal and map
// axis: the filter reaches 1.5 texels along each side, 2.1 along the diagonal; the maps' slope offset of one texel
// covers the rest.
vec3 off_surface(vec3 position, vec3 normal, float n_axis, float texel) {
  return position + normal * (texel * (0.1 + 1.5 * sqrt(max(1.0 - n_axis * n_axis, 0.0))));
}

float face_visibility(int i, vec3 position, vec3 normal, float texel_scale, float first_layer) {
  vec3 to_surface = position - light_position_range(i).xyz;
  vec3 size = abs(to_surface);
  float reach = max(size.x, max(size.y, size.z));
  float n_axis = reach == size.x ? normal.x : (reach == size.y ? normal.y : normal.z);
  vec3 p = off_surface(to_surface, normal, n_axis, texel_scale * reach);
  size = abs(p);
  vec3 on_face;  // right, up, along the face's axis
  float face;
  if (size.x >= size.y && size.x >= size.z) {
    on_face = vec3(p.y, p.z, size.x);
    face = p.x > 0.0 ? 0.0 : 1.0;
  } else if (size.y >= size.z) {
    on_face = vec3(p.z, p.x, size.y);
    face = p.y > 0.0 ? 2.0 : 3.0;
  } else {
    on_face = vec3(p.x, p.y, size.z);
    face = p.z > 0.0 ? 4.0 : 5.0;
  }
  vec4 terms = shadow_matrix(i)[0];
  float along = max(on_face.z, 1e-9);
  vec2 uv = on_face.xy * (0.5 * terms.z / along) + 0.5;
  return lit_share(local_shadows, vec3(uv, terms.x + terms.y / along), first_layer + face);
}

// `normal` must be on the light's side.
float visibility(int i, vec3 position, vec3 normal) {
  ivec4 r = light_type_map_layer_texel(i);
  if (!shadows_on || r.y == 0) return 1.0;
  float texel = intBitsToFloat(r.w);
  float layer = float(r.z);
  if (r.y == 3) return face_visibility(i, position, normal, texel, layer);
  mat4 shadow_from = shadow_matrix(i);
  vec4 plain = shadow_from * vec4(position, 1.0);
  if (plain.w <= 0.0) return 1.0;
  vec3 off = off_surface(position, normal, dot(normal, light_direction_inner(i).xyz), texel * plain.w);
  vec4 where = shadow_from * vec4(off, 1.0);
  where /= max(where.w, 1e-9);
  if (any(lessThan(where.xy, vec2(0.0))) || any(greaterThan(where.xy, vec2(1.0)))) return 1.0;
  return r.y == 1 ? lit_share(directional_shadows, where.xyz, layer) : lit_share(local_shadows, where.xyz, layer);
}

#ifdef SR_MASKS
uniform uint shadow_mask_lights;        // bit i: light i has a mask
uniform int combined_mask_layer;        // layer of the mask that lights from number 32 on share; -1: none
uniform sampler2DArray shadow_masks;    // a layer for each bit, lowest first; 1 = lit
uniform bool open_mask_on;
uniform sampler2D open_mask;            // 1 = the whole sky is visible
uniform int unhidden_mask_layer;        // in shadow_masks, 1 = nothing opaque hides the sky; -1: the same as open_mask
uniform bool bounced_on;
uniform sampler2D bounced;              // light of other surfaces, over pi; A = 0: not known
uniform bool mirrored_on;
uniform sampler2D mirrored;             // radiance from the mirror direction; A: its weight against the environment's
#endif

#ifdef SR_ANSWERS
uniform sampler2D mask_answers;  // under a budget, 255 times: 1, the lights' masks are known, + 2, the sky's is

bool is_answered(uint bit) {
  uint answers = uint(texelFetch(mask_answers, ivec2(gl_FragCoord.xy), 0).x * 255.0 + 0.5);
  return (answers & bit) != 0u;
}
#endif

#ifdef SR_MASKS
// Returns whether a mask holds the visible share of a light; otherwise its shadow map does.
bool has_mask(int i) {
  bool masked = i < 32 ? ((shadow_mask_lights >> uint(i)) & 1u) != 0u : combined_mask_layer >= 0;
#ifdef SR_ANSWERS
  masked = masked && is_answered(1u);
#endif
  return masked;
}
#endif

float reached_share(int i, vec3 position, vec3 normal) {
#ifdef SR_MASKS
  if (has_mask(i)) {
    int layer = combined_mask_layer;
    if (i < 32) {
      layer = 0;
      for (uint below = shadow_mask_lights & ((1u << uint(i)) - 1u); below != 0u; below &= below - 1u) ++layer;
    }
    return texelFetch(shadow_masks, ivec3(gl_FragCoord.xy, layer), 0).x;
  }
#endif
  return visibility(i, position, normal);
}

// Returns the optical depth of a share of light that a surface lets pass.
vec3 optical_depth(vec3 through) { return -log(clamp(through, vec3(1e-6), vec3(1.0))); }

#ifdef SR_TINT_MAPS
uniform sampler2DArray directional_tints, local_tints;  // rgb: optical depth; w: distance of the first surface
uniform ivec2 tint_maps_of;                             // which of the two exist
uniform bool tints_reversed;

// Returns the tint at a distance from the light: white in front of a texel's first translucent surface; behind it the
// tint of all its surfaces without `own`, the receiver's optical depth.
vec3 tint_from(sampler2DArray map, vec2 uv, float layer, float away, vec3 own) {
  ivec2 last = textureSize(map, 0).xy - 1;
  vec2 at = uv * vec2(last + 1) - 0.5;
  ivec2 corner = ivec2(floor(at));
  vec2 part = at - vec2(corner);
  vec3 sum = vec3(0.0);
  for (int k = 0; k < 4; ++k) {
    ivec2 off = ivec2(k & 1, k >> 1);
    vec4 texel = texelFetch(map, ivec3(clamp(corner + off, ivec2(0), last), int(layer)), 0);
    vec2 weight = mix(1.0 - part, part, vec2(off));
    bool behind = away > texel.w * 1.002 + 0.001;
    sum += weight.x * weight.y * (behind ? exp(-max(texel.xyz - own, vec3(0.0))) : vec3(1.0));
  }
  return sum;
}

// Returns the share of a light's colour that translucent surfaces let pass, by the maps.
vec3 tint_by_map(int i, vec3 position, vec3 own) {
  ivec4 r = light_type_map_layer_texel(i);
  if (!shadows_on || r.y == 0 || (r.y == 1 ? tint_maps_of.x : tint_maps_of.y) == 0) return vec3(1.0);
  float layer = float(r.z);
  if (r.y == 3) {
    vec3 p = position - light_position_range(i).xyz;
    vec3 size = abs(p);
    vec3 on_face = size.x >= size.y && size.x >= size.z ? vec3(p.y, p.z, size.x)
                   : size.y >= size.z ? vec3(p.z, p.x, size.y) : vec3(p.x, p.y, size.z);
    float face = size.x >= size.y && size.x >= size.z ? (p.x > 0.0 ? 0.0 : 1.0)
                 : size.y >= size.z ? (p.y > 0.0 ? 2.0 : 3.0) : (p.z > 0.0 ? 4.0 : 5.0);
    float along = max(on_face.z, 1e-9);
    return tint_from(local_tints, on_face.xy * (0.5 * shadow_matrix(i)[0].z / along) + 0.5, layer + face, along, own);
  }
  vec4 where = shadow_matrix(i) * vec4(position, 1.0);
  if (where.w <= 0.0) return vec3(1.0);
  vec3 at = where.xyz / max(where.w, 1e-9);
  if (any(lessThan(at.xy, vec2(0.0))) || any(greaterThan(at.xy, vec2(1.0)))) return vec3(1.0);
  if (r.y == 1) return tint_from(directional_tints, at.xy, layer, tints_reversed ? 1.0 - at.z : at.z, own);
  return tint_from(local_tints, at.xy, layer, where.w, own);
}
#endif

#ifdef SR_TINTS
uniform sampler2DArray shadow_tints;  // red, green and blue of each tinted light; 1 = all passes
uniform int tint_layers[33];          // first of a light's three layers, from 1; [32]: of lights from 32 on; 0: none

vec3 tint_by_mask(int i) {
  int layer = tint_layers[min(i, 32)] - 1;
  if (layer < 0) return vec3(1.0);
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  return vec3(texelFetch(shadow_tints, ivec3(pixel, layer), 0).x, texelFetch(shadow_tints, ivec3(pixel, layer + 1), 0).x,
              texelFetch(shadow_tints, ivec3(pixel, layer + 2), 0).x);
}
#endif

#if defined(SR_TINTS) || defined(SR_TINT_MAPS)
#ifdef SR_TRANSLUCENT
uniform bool tints_light;  // the surface is in the maps

// Returns the surface's own optical depth toward a light. A solid's is unknown: the whole depth counts as its own.
vec3 own_depth(SrSurface s, vec3 to_light) {
  if (v_solid != 0u) return vec3(1e6);
  if (!tints_light) return vec3(0.0);
  return optical_depth(sr_blend(sr_facing(s, to_light), to_light, material.unlit_blend_alpha_mode_maps.y).through);
}
#else
vec3 own_depth(SrSurface s, vec3 to_light) { return vec3(0.0); }
#endif

// Returns the share of a light's colour that other translucent surfaces let pass, by rays if the light has a mask.
vec3 tint_of(int i, SrSurface s, vec3 position, vec3 to_light) {
#ifdef SR_MASKS
#ifdef SR_TINTS
  if (has_mask(i)) return tint_by_mask(i);
#else
  if (has_mask(i)) return vec3(1.0);
#endif
#endif
#ifdef SR_TINT_MAPS
  return tint_by_map(i, position, own_depth(s, to_light));
#else
  return vec3(1.0);
#endif
}
#endif

#ifdef SR_MASKS
// Returns the light of other surfaces; w = 0: it is not known.
vec4 bounced_light() { return bounced_on ? texelFetch(bounced, ivec2(gl_FragCoord.xy), 0) : vec4(0.0); }
#endif

vec3 irradiance_about(vec3 normal) {
  return textureLod(environment_irradiance, sr_latlong(normal), 0.0).xyz;
}

// Returns the irradiance over pi from the environment, with its occluders and their light where masks know them.
vec3 sky_light(vec3 normal, vec3 albedo) {
  vec3 from_here = irradiance_about(normal);
#ifdef SR_MASKS
#ifdef SR_ANSWERS
  bool knows_open = open_mask_on && is_answered(2u);
#else
  bool knows_open = open_mask_on;
#endif
  vec4 thrown = bounced_light();
  if (thrown.w > 0.0) {
    float seen = knows_open ? texelFetch(open_mask, ivec2(gl_FragCoord.xy), 0).x : 1.0;
    return max(from_here * seen + thrown.xyz, vec3(0.0));
  }
  if (knows_open) {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float open = texelFetch(open_mask, pixel, 0).x;
    float unhidden = unhidden_mask_layer < 0 ? open : texelFetch(shadow_masks, ivec3(pixel, unhidden_mask_layer), 0).x;
    return sr_sky_light(from_here, irradiance_about(-normal), open, unhidden, albedo);
  }
#endif
  return from_here;
}

// Reads model::AlbedoTable, whose first and last texels are at 0 and 1.
vec3 albedos(float n_v, float roughness) {
  float size = float(textureSize(albedo_terms, 0).x);
  return textureLod(albedo_terms, (vec2(n_v, roughness) * (size - 1.0) + 0.5) / size, 0.0).xyz;
}

// Returns the surface as the eye sees it: sr_seen() with the table's albedos.
SrSurface seen(SrSurface away, vec3 to_eye) {
  SrSurface s = sr_facing(away, to_eye);
  float n_v = dot(s.normal, to_eye);
#if (SR_LOBES & 16) != 0
  // The G-buffer rounds normals, so the direction is made perpendicular again.
  vec3 along = s.along - s.normal * dot(s.normal, s.along);
  s.along = s.anisotropy > 0.0 ? along / max(length(along), 1e-6) : vec3(0.0);
  float roughness = sr_round_roughness(s);
  vec2 terms = albedos(n_v, roughness).xy;
  terms = sr_brushed_terms(s, terms, albedos(sr_round_cosine(s, to_eye), roughness).xy);
#else
  vec2 terms = albedos(n_v, s.roughness).xy;
#endif
#if (SR_LOBES & 2) != 0
  return sr_seen(s, to_eye, terms, albedos(n_v, s.sheen_roughness).z);
#else
  return sr_seen(s, to_eye, terms, 0.0);
#endif
}

// Returns the environment's radiance in a lobe about `normal`; `mirror` must be above the geometric surface.
vec3 environment_radiance(vec3 normal, vec3 mirror, float roughness) {
  vec3 direction = sr_dominant(normal, mirror, roughness);
  return textureLod(environment_specular, sr_latlong(direction), roughness * environment_last_level).xyz;
}

// Returns the environment's light for lobes without masks or rays of their own: the visible share of the sky, plus the
// average light of other surfaces.
vec3 under_cover(vec3 of_sky) {
#ifdef SR_MASKS
  vec4 thrown = bounced_light();
  if (thrown.w > 0.0) {
    float seen = open_mask_on ? texelFetch(open_mask, ivec2(gl_FragCoord.xy), 0).x : 1.0;
    return max(of_sky * seen + thrown.xyz, vec3(0.0));
  }
#endif
  return of_sky;
}

// Returns the light that the base mirrors: traced by rays where available, blended over the environment's.
vec3 over_environment(vec3 of_sky) {
  vec3 prefiltered = under_cover(of_sky);
#ifdef SR_MASKS
  if (mirrored_on) {
    vec4 traced = texelFetch(mirrored, ivec2(gl_FragCoord.xy), 0);
    return mix(prefiltered, traced.xyz, traced.w);
  }
#endif
  return prefiltered;
}

vec3 environment_light(SrSurface s, vec3 geometric_normal, vec3 to_eye) {
#ifdef SR_MASKS
  // Rays have found what the occlusion texture stands in for.
  if (bounced_light().w > 0.0) s.occlusion = 1.0;
#endif
  float n_v = dot(s.normal, to_eye);
  SrSurroundings around;
  around.irradiance = sky_light(s.normal, s.diffuse);
#if (SR_LOBES & 16) != 0
  vec3 bent = sr_bent(s, to_eye);
  vec3 mirror = sr_lifted(reflect(-to_eye, bent), geometric_normal);
  vec3 prefiltered = environment_radiance(bent, mirror, sr_look_up_roughness(s));
  // Rays toward the G-buffer's mirror directions only fit round lobes.
  around.specular = s.anisotropy > 0.0 ? under_cover(prefiltered) : over_environment(prefiltered);
#else
  vec3 mirror = sr_lifted(reflect(-to_eye, s.normal), geometric_normal);
  around.specular = over_environment(environment_radiance(s.normal, mirror, s.roughness));
#endif
#if (SR_LOBES & 4) != 0
  around.behind = under_cover(irradiance_about(-s.normal));
#else
  around.behind = vec3(0.0);
#endif
#if (SR_LOBES & 1) != 0
  vec3 coat_mirror = sr_lifted(reflect(-to_eye, s.coat_normal), geometric_normal);
  around.coat = under_cover(environment_radiance(s.coat_normal, coat_mirror, s.coat_roughness));
#else
  around.coat = vec3(0.0);
#endif
  // Where the normal is NaN, lookups still return numbers, and so must this.
  float cosine = abs(n_v) > 0.0 ? min(abs(n_v), 1.0) : 0.0;
  return sr_environment(s, cosine, around);
}

// `s` as from seen(). `geometric_normal` on the eye's side: no mirror direction goes below its plane.
vec3 radiance_from(SrSurface s, vec3 geometric_normal, vec3 position, vec3 to_eye) {
  vec3 sum = sr_emitted(s);
  for (int i = 0; i < light_count; ++i) {
    SrIncidence incidence = sr_incidence(light_at(i), position);
    // Beyond its range and outside its cone a light adds 0: skips its lobes and its map.
    if (!sr_faces(s, incidence.to_light) || incidence.irradiance == vec3(0.0)) continue;
    vec3 lit_side = dot(s.normal, incidence.to_light) < 0.0 ? -s.normal : s.normal;
#if defined(SR_TINTS) || defined(SR_TINT_MAPS)
    vec3 reached = reached_share(i, position, lit_side) * tint_of(i, s, position, incidence.to_light);
#else
    float reached = reached_share(i, position, lit_side);
#endif
    sum += sr_reflect_light(s, to_eye, incidence.to_light) * incidence.irradiance * reached;
  }
  return sum + environment_light(s, geometric_normal, to_eye);
}

// Does the same with the shading normal as the geometric one.
vec3 radiance_from(SrSurface s, vec3 position, vec3 to_eye) {
  return radiance_from(s, s.normal, position, to_eye);
}
