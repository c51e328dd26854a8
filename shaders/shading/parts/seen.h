// The surface as the eye sees it, and directions that leave it.

// Returns a direction that leaves the geometric surface: lifted as far as needed where a bent normal sends it inside.
SR_FN real3 sr_lifted(real3 direction, real3 geometric_normal) {
  real missing = max(0.001f - dot(direction, geometric_normal), 0.0f);
  return sr_select(missing > 0.0f, normalize(direction + geometric_normal * missing), direction);
}

// Returns the direction in which a lobe about `mirror` is brightest in uniform surroundings: the rougher, the nearer to
// the normal (Lagarde and de Rousiers 2014, "Moving Frostbite to Physically Based Rendering", 4.9.3). Prefiltered
// radiance, whose lobes are those of a view along the normal, is looked up there.
SR_FN real3 sr_dominant(real3 normal, real3 mirror, real roughness) {
  real a = roughness * roughness;
  real smooth_share = max(1.0f - a, 0.0f);
  return normalize(mix(normal, mirror, smooth_share * (sqrt(smooth_share) + a)));
}

// Returns the factor by which multiple scattering increases the single reflection of a rough surface: light that other
// microfacets catch is reflected once more (Turquin 2019, "Practical multiple scattering compensation for microfacet
// models"). A white metal loses nothing.
SR_FN real3 sr_repeated(real3 f0, real2 albedo_terms) {
  real kept = clamp(albedo_terms.x + albedo_terms.y, 0.05f, 1.0f);
  return sr_real3(1.0f) + f0 * (1.0f / kept - 1.0f);
}

// Returns the surface, facing the eye, as the eye sees it; call it once for each surface. `albedo_terms`: x and y of
// model::AlbedoTable at (|n.v|, roughness), or sr_brushed_terms(). `sheen_albedo`: its z at (|n.v|, sheen_roughness).
SR_FN SrSurface sr_seen(SrSurface s, real3 to_eye, real2 albedo_terms, real sheen_albedo) {
  real3 repeated = sr_repeated(s.f0, albedo_terms);
  s.f0 = sr_times(s.f0, repeated);
  s.f90 = sr_times(s.f90, repeated);
  s.albedo_terms = albedo_terms;
  real cosine = sr_saturate(dot(s.coat_normal, to_eye));
  s.coat_share = s.coat * (0.04f + 0.96f * sr_fifth_power(1.0f - cosine));
  s.sheen_albedo = sheen_albedo;
  s.below_sheen = 1.0f - max(s.sheen.x, max(s.sheen.y, s.sheen.z)) * sheen_albedo;
  return s;
}

// Applies a normal map's tangent-space normal to a world-space frame; tangent.w = +-1, or 0 without a frame.
SR_FN real3 sr_perturb(real3 normal, real4 tangent, real3 map, real scale) {
  real3 t = real3(tangent.x, tangent.y, tangent.z);
  real3 b = cross(normal, t) * tangent.w;
  real3 n = t * (map.x * scale) + b * (map.y * scale) + normal * map.z;
  real size = length(n);
  return sr_select(abs(tangent.w) > 0.5f && size > 1e-6f, n * (1.0f / max(size, 1e-6f)), normal);
}
