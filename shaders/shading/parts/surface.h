// The inputs of the shading model, and the surface that they make.

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
  real clearcoat;
  real clearcoat_roughness;
  real3 sheen_color;
  real sheen_roughness;
  real diffuse_transmission;
  real3 diffuse_transmission_color;
  real iridescence;
  real iridescence_ior;
  real iridescence_thickness_min;  // nanometres
  real iridescence_thickness_max;
  real anisotropy;
  real anisotropy_cosine;  // of the rotation from the tangent toward the bitangent
  real anisotropy_sine;
  integer alpha_mode;  // sideray_alpha_mode: alpha counts for BLEND alone
  boolean unlit;
};

// Holds the textures' values at a point, 1 without a texture (the direction: along the tangent); colours are linear.
// The caller perturbs normals.
struct SrTexels {
  real4 base_color;  // times the vertex colour
  real3 emissive;
  real metallic;
  real roughness;
  real occlusion;  // with its strength applied
  real transmission;
  real thickness;
  real specular;
  real3 specular_color;
  real clearcoat;
  real clearcoat_roughness;
  real3 sheen_color;
  real sheen_roughness;
  real diffuse_transmission;
  real3 diffuse_transmission_color;
  real iridescence;
  real iridescence_thickness;
  real anisotropy_along;  // the direction in the tangent's frame, -1 to 1, of any length
  real anisotropy_across;
  real anisotropy;
};

struct SrSurface {
  real3 normal;  // unit, on the viewer's side
  real3 albedo;  // the base colour
  real metallic;
  real3 diffuse;
  real3 behind;  // for diffuse light that arrives on the other side
  real3 f0;
  real3 f90;
  real3 emissive;
  real3 tint;  // for straight transmission, before Fresnel; 0 = none
  real alpha;
  real roughness;  // perceptual
  real occlusion;
  real coat;
  real coat_roughness;  // perceptual
  real3 coat_normal;    // unit, on the viewer's side
  real3 sheen;
  real sheen_roughness;  // perceptual
  real3 along;           // unit, perpendicular to the normal: the base's lobe is longest along it; or 0
  real anisotropy;       // strength, 0..1
  // For the direction to the eye: what the coat reflects, and what the sheen leaves to the layers below. sr_seen()
  // fills them, and makes f0 and f90 those of all reflections between microfacets, which may exceed 1.
  real coat_share;
  real below_sheen;
  real sheen_albedo;
  real2 albedo_terms;  // x and y of model::AlbedoTable at (|n.v|, roughness), or sr_brushed_terms()
};

SR_FN real sr_saturate(real x) {
  return clamp(x, 0.0f, 1.0f);
}

SR_FN real3 sr_real3(real x) {
  return real3(x, x, x);
}

SR_FN real3 sr_times(real3 a, real3 b) {
  return real3(a.x * b.x, a.y * b.y, a.z * b.z);
}

SR_FN real sr_fifth_power(real x) {
  real x2 = x * x;
  return x2 * x2 * x;
}

// Makes the surface of a material; apply sr_facing() and sr_seen() to it.
SR_FN SrSurface sr_surface(SrMaterial m, SrTexels t, real3 normal, real3 coat_normal) {
  SrSurface s;
  s.normal = normal;
  s.albedo = real3(m.base_color.x * t.base_color.x, m.base_color.y * t.base_color.y, m.base_color.z * t.base_color.z);
  s.alpha = sr_select(m.alpha_mode == 2, sr_saturate(m.base_color.w * t.base_color.w), real(1.0f));
  s.metallic = sr_saturate(m.metallic * t.metallic);
  s.roughness = clamp(m.roughness * t.roughness, 0.04f, 1.0f);
  s.occlusion = t.occlusion;
  real transmission = sr_saturate(m.transmission * t.transmission) * (1.0f - s.metallic);
  real r = (m.ior - 1.0f) / (m.ior + 1.0f);
  real specular = m.specular * t.specular;
  real3 specular_color = sr_times(m.specular_color, t.specular_color);
  real3 dielectric_f0 = min(specular_color * (r * r), sr_real3(1.0f)) * specular;
  s.f0 = mix(dielectric_f0, s.albedo, s.metallic);
  s.f90 = mix(sr_real3(specular), sr_real3(1.0f), s.metallic);
  real diffuse_share = (1.0f - s.metallic) * (1.0f - transmission);
  real behind_share = sr_saturate(m.diffuse_transmission * t.diffuse_transmission);
  s.diffuse = s.albedo * (diffuse_share * (1.0f - behind_share));
  s.behind = sr_times(m.diffuse_transmission_color, t.diffuse_transmission_color) * (diffuse_share * behind_share);
  real depth = m.thickness * t.thickness;
  real3 volume = sr_real3(1.0f);
  if (sr_any(depth > 0.0f))
    volume = real3(exp(-m.absorption.x * depth), exp(-m.absorption.y * depth), exp(-m.absorption.z * depth));
  s.tint = sr_times(s.albedo, volume) * transmission;
  s.emissive = sr_times(m.emissive, t.emissive);
  s.coat = sr_saturate(m.clearcoat * t.clearcoat);
  s.coat_roughness = clamp(m.clearcoat_roughness * t.clearcoat_roughness, 0.04f, 1.0f);
  s.coat_normal = coat_normal;
  s.sheen = sr_times(m.sheen_color, t.sheen_color);
  s.sheen_roughness = clamp(m.sheen_roughness * t.sheen_roughness, 0.07f, 1.0f);
  s.along = sr_real3(0.0f);
  s.anisotropy = real(0.0f);
  // An unlit surface emits its base colour and reflects nothing.
  s.emissive = sr_select(m.unlit, s.albedo, s.emissive);
  s.diffuse = sr_select(m.unlit, sr_real3(0.0f), s.diffuse);
  s.behind = sr_select(m.unlit, sr_real3(0.0f), s.behind);
  s.f0 = sr_select(m.unlit, sr_real3(0.0f), s.f0);
  s.f90 = sr_select(m.unlit, sr_real3(0.0f), s.f90);
  s.coat = sr_select(m.unlit, real(0.0f), s.coat);
  s.sheen = sr_select(m.unlit, sr_real3(0.0f), s.sheen);
  s.coat_share = real(0.0f);
  s.below_sheen = real(1.0f);
  s.sheen_albedo = real(0.0f);
  s.albedo_terms = real2(0.0f, 0.0f);
  return s;
}

// Returns a shading normal that the eye can see: bent toward the eye as far as needed. Interpolation and normal maps
// turn normals away at silhouettes, and such a normal has neither a mirror direction nor lobe albedos.
SR_FN real3 sr_toward_eye(real3 normal, real3 to_eye) {
  real missing = max(0.01f - dot(normal, to_eye), 0.0f);
  return sr_select(missing > 0.0f, normalize(normal + to_eye * missing), normal);
}

// Returns the surface with both normals seen by the eye; call it before any lookup by an angle to the eye.
SR_FN SrSurface sr_facing(SrSurface s, real3 to_eye) {
  s.normal = sr_toward_eye(s.normal, to_eye);
  s.coat_normal = sr_toward_eye(s.coat_normal, to_eye);
  return s;
}
