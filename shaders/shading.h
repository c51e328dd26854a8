// The shading model, once for raster fragments (GLSL) and ray hits (C++, through shading_cpp.h).
// Dialect: f suffixes, no swizzles, no in/out parameters, sr_select instead of branches on data, own type names. The
// includer defines real, real2, real3, real4, boolean, SR_FN, sr_select, sr_atan2.
// Model: metallic-roughness of glTF 2.0 (appendix B): GGX (Walter et al. 2007) with height-correlated Smith visibility
// (Heitz 2014), Schlick's Fresnel, Lambert; split-sum image-based lighting (Karis 2013).

struct SrMaterial {
  real4 base_color;
  real3 emissive;
  real3 specular_color;
  real3 absorption;  // per world unit, from attenuation colour and distance
  real metallic;
  real roughness;
  real transmission;
  real ior;
  real thickness;
  real specular;
  int alpha_mode;  // sideray_alpha_mode: alpha counts for BLEND alone
  boolean unlit;
};

// What the textures say at a point, 1 where there is none; colours linear. The normal is perturbed by the caller.
struct SrTexels {
  real4 base_color;  // times the vertex colour
  real3 emissive;
  real metallic;
  real roughness;
  real occlusion;  // with its strength applied
  real transmission;
  real thickness;
};

struct SrSurface {
  real3 normal;  // unit, on the viewer's side
  real3 albedo;  // the base colour
  real metallic;
  real3 diffuse;
  real3 f0;
  real3 f90;
  real3 emissive;
  real3 tint;  // of straight transmission, before Fresnel; 0 = none
  real alpha;
  real roughness;  // perceptual
  real occlusion;
};

SR_FN real sr_saturate(real x) {
  return clamp(x, 0.0f, 1.0f);
}

SR_FN real3 sr_real3(real x) {
  return real3(x, x, x);
}

SR_FN SrSurface sr_surface(SrMaterial m, SrTexels t, real3 normal) {
  SrSurface s;
  s.normal = normal;
  s.albedo = real3(m.base_color.x * t.base_color.x, m.base_color.y * t.base_color.y, m.base_color.z * t.base_color.z);
  s.alpha = m.alpha_mode == 2 ? sr_saturate(m.base_color.w * t.base_color.w) : 1.0f;
  s.metallic = sr_saturate(m.metallic * t.metallic);
  s.roughness = clamp(m.roughness * t.roughness, 0.04f, 1.0f);
  s.occlusion = t.occlusion;
  real transmission = sr_saturate(m.transmission * t.transmission) * (1.0f - s.metallic);
  real r = (m.ior - 1.0f) / (m.ior + 1.0f);
  real3 dielectric_f0 = min(sr_real3(r * r) * m.specular_color, sr_real3(1.0f)) * m.specular;
  s.f0 = mix(dielectric_f0, s.albedo, s.metallic);
  s.f90 = mix(sr_real3(m.specular), sr_real3(1.0f), s.metallic);
  s.diffuse = s.albedo * ((1.0f - s.metallic) * (1.0f - transmission));
  real depth = m.thickness * t.thickness;
  real3 volume = real3(exp(-m.absorption.x * depth), exp(-m.absorption.y * depth), exp(-m.absorption.z * depth));
  s.tint = s.albedo * volume * transmission;
  s.emissive = m.emissive * t.emissive;
  // Unlit: the base colour is what leaves the surface; nothing is reflected.
  s.emissive = sr_select(m.unlit, s.albedo, s.emissive);
  s.diffuse = sr_select(m.unlit, sr_real3(0.0f), s.diffuse);
  s.f0 = sr_select(m.unlit, sr_real3(0.0f), s.f0);
  s.f90 = sr_select(m.unlit, sr_real3(0.0f), s.f90);
  return s;
}

// Tangent-space normal from a normal map onto a world-space frame; tangent.w = +-1, or 0 where there is no frame.
SR_FN real3 sr_perturb(real3 normal, real4 tangent, real3 map, real scale) {
  real3 t = real3(tangent.x, tangent.y, tangent.z);
  real3 b = cross(normal, t) * tangent.w;
  real3 n = t * (map.x * scale) + b * (map.y * scale) + normal * map.z;
  real size = length(n);
  return sr_select(abs(tangent.w) > 0.5f && size > 1e-6f, n * (1.0f / max(size, 1e-6f)), normal);
}

SR_FN real3 sr_fresnel(real3 f0, real3 f90, real cosine) {
  real x = 1.0f - sr_saturate(cosine);
  real x2 = x * x;
  return f0 + (f90 - f0) * (x2 * x2 * x);
}

// Reflected radiance per unit of irradiance measured perpendicular to `to_light`: BRDF times cosine.
SR_FN real3 sr_reflect_light(SrSurface s, real3 to_eye, real3 to_light) {
  real3 sum = to_eye + to_light;
  real3 h = sum * (1.0f / max(length(sum), 1e-6f));
  real n_l = sr_saturate(dot(s.normal, to_light));
  real n_v = max(abs(dot(s.normal, to_eye)), 1e-4f);
  real n_h = sr_saturate(dot(s.normal, h));
  real v_h = sr_saturate(dot(to_eye, h));
  real a = s.roughness * s.roughness;
  real a2 = a * a;
  // 1 - (1 - a2) n_h^2 without cancellation near n_h = 1.
  real3 n_x_h = cross(s.normal, h);
  real f = a2 * n_h * n_h + dot(n_x_h, n_x_h);
  real d = a2 / (3.14159265f * max(f * f, 1e-20f));
  real g = 0.5f / max(n_l * sqrt(n_v * n_v * (1.0f - a2) + a2) + n_v * sqrt(n_l * n_l * (1.0f - a2) + a2), 1e-6f);
  real3 fresnel = sr_fresnel(s.f0, s.f90, v_h);
  real3 diffuse = (sr_real3(1.0f) - fresnel) * s.diffuse * 0.318309886f;
  return (diffuse + fresnel * (d * g)) * n_l;
}

// `albedo_terms`: the table of model::AlbedoTable at (|n.v|, roughness). `irradiance` is E / pi, `specular` the radiance
// from the mirror direction, prefiltered or traced.
SR_FN real3 sr_specular_albedo(SrSurface s, real2 albedo_terms) {
  return s.f0 * albedo_terms.x + s.f90 * albedo_terms.y;
}

SR_FN real3 sr_environment(SrSurface s, real2 albedo_terms, real3 irradiance, real3 specular) {
  real3 specular_albedo = sr_specular_albedo(s, albedo_terms);
  return (s.diffuse * (sr_real3(1.0f) - specular_albedo) * irradiance + specular_albedo * specular) * s.occlusion;
}

// Straight transmission of a transmissive surface per channel: tint times what is not reflected.
SR_FN real3 sr_transmittance(SrSurface s, real3 to_eye) {
  real3 reflected = sr_fresnel(s.f0, s.f90, abs(dot(s.normal, to_eye)));
  return s.tint * (sr_real3(1.0f) - reflected);
}

// Factors of dst = radiance * cover + dst * through. blend: 0 alpha, 1 premultiplied, 2 additive, 3 multiply.
struct SrBlend {
  real cover;
  real3 through;
};

SR_FN SrBlend sr_blend(SrSurface s, real3 to_eye, int blend) {
  SrBlend b;
  real3 behind = sr_transmittance(s, to_eye);
  b.cover = blend == 1 ? 1.0f : (blend == 3 ? 0.0f : s.alpha);
  b.through = sr_real3(1.0f - s.alpha) + behind * s.alpha;
  if (blend == 2) b.through = sr_real3(1.0f);
  if (blend == 3) b.through = sr_real3(1.0f - s.alpha) + s.albedo * s.alpha;
  return b;
}

struct SrLight {
  real3 position;
  real3 direction;  // the way the light travels
  real3 intensity;
  real range;  // 0 = unlimited
  real cos_inner;
  real cos_outer;
  int type;  // sideray_light_type
};

struct SrIncidence {
  real3 to_light;
  real distance;     // 1e30 for a directional light
  real3 irradiance;  // perpendicular to to_light
};

// Light arriving at `position` without regard to visibility; fall-off as in KHR_lights_punctual.
SR_FN SrIncidence sr_incidence(SrLight light, real3 position) {
  SrIncidence i;
  if (light.type == 0) {
    i.to_light = -light.direction;
    i.distance = 1e30f;
    i.irradiance = light.intensity;
    return i;
  }
  real3 offset = light.position - position;
  i.distance = max(length(offset), 1e-4f);
  i.to_light = offset * (1.0f / i.distance);
  real fade = 1.0f;
  if (light.range > 0.0f) {
    real q = i.distance / light.range;
    real q2 = q * q;
    fade = sr_saturate(1.0f - q2 * q2);
  }
  if (light.type == 2) {
    real cosine = -dot(i.to_light, light.direction);
    real spot = sr_saturate((cosine - light.cos_outer) / max(light.cos_inner - light.cos_outer, 1e-4f));
    fade = fade * spot * spot;
  }
  i.irradiance = light.intensity * (fade / (i.distance * i.distance));
  return i;
}

// Texture coordinates of a unit direction in a lat-long image whose first row is +Y: centre = -Z, u grows toward +X.
SR_FN real2 sr_latlong(real3 direction) {
  return real2(0.5f + sr_atan2(direction.x, -direction.z) * 0.159154943f,
               acos(clamp(direction.y, -1.0f, 1.0f)) * 0.318309886f);
}
