// How a surface reflects and transmits the light that comes from all around it, and how it covers what is behind it.

// Returns the emission that leaves through the coat.
SR_FN real3 sr_emitted(SrSurface s) {
  return s.emissive * (1.0f - s.coat_share);
}

// Returns what the base reflects of uniform light from all directions.
SR_FN real3 sr_specular_albedo(SrSurface s) {
  return s.f0 * s.albedo_terms.x + s.f90 * s.albedo_terms.y;
}

// Returns the share of uniform light that Fresnel leaves to the diffuse lobe, with each direction's half vector as in
// sr_reflection(): the integral of (1 - v.h)^5 n.l / pi over the hemisphere is a polynomial of n.v to 1e-5.
SR_FN real3 sr_diffuse_share(SrSurface s, real n_v) {
  real grazing = 0.02816534f + n_v * (n_v * (0.08649786f + n_v * (n_v * 0.00900354f - 0.04371874f)) - 0.0798652f);
  return max(sr_real3(1.0f) - s.f0 - (s.f90 - s.f0) * grazing, sr_real3(0.0f));
}

// Holds the surroundings of a point for the lobes. Irradiance is E / pi; radiance is prefiltered or traced.
struct SrSurroundings {
  real3 irradiance;  // about the normal
  real3 behind;      // irradiance about the opposite normal
  real3 specular;    // radiance that the base's lobe reflects
  real3 coat;        // radiance that the coat's lobe reflects
};

// Returns the environment's irradiance over pi, including light that arrives by way of occluders. Opaque occluders of a
// share h are taken to stand upright on this surface and to have its albedo: an occluder sees this surface in a share
// h / 2, and in the rest, p, the environment, half of it behind this surface. So x = open * E + h * albedo * y with
// y = p * E' + (1 - p) * albedo * x, where E' is the mean of E on both sides. In a white furnace x = 1. `from_here` and
// `from_behind`: E about the normal and about its opposite; `unhidden` is 1 - h.
SR_FN real3 sr_sky_light(real3 from_here, real3 from_behind, real open, real unhidden, real3 albedo) {
  real hidden = 1.0f - unhidden;
  real seen_from_there = 0.5f + unhidden * 0.5f;
  real3 matt = min(albedo, sr_real3(1.0f));
  real3 thrown_back = matt * hidden;
  real3 from_both = (from_here + from_behind) * 0.5f;
  real3 once = from_here * open + sr_times(thrown_back * seen_from_there, from_both);
  real3 kept = sr_real3(1.0f) - sr_times(thrown_back * (1.0f - seen_from_there), matt);
  return real3(once.x / kept.x, once.y / kept.y, once.z / kept.z);
}

// `n_v`: |n.v|.
SR_FN real3 sr_environment(SrSurface s, real n_v, SrSurroundings light) {
  real3 base = sr_times(sr_times(s.diffuse, sr_diffuse_share(s, n_v)), light.irradiance) +
               sr_times(s.behind, light.behind) + sr_times(sr_specular_albedo(s), light.specular);
  real3 sheen = sr_times(s.sheen, light.irradiance) * s.sheen_albedo;
  return ((base * s.below_sheen + sheen) * (1.0f - s.coat_share) + light.coat * s.coat_share) * s.occlusion;
}

// Returns the straight transmission per channel: tint times what is not reflected. A rough surface reflects as much as
// its lobe does, so that no light is lost between its microfacets; for a smooth one, Fresnel is more exact than the
// table, which has few angles.
SR_FN real3 sr_transmittance(SrSurface s, real3 to_eye) {
  real3 mirrored = sr_fresnel(s.f0, s.f90, abs(dot(s.normal, to_eye)));
  real3 reflected = sr_select(s.roughness > 0.04f, sr_specular_albedo(s), mirrored);
  real3 through = max(sr_real3(1.0f) - reflected, sr_real3(0.0f));
  return sr_times(s.tint, through) * (s.below_sheen * (1.0f - s.coat_share));
}

// Holds the factors of dst = radiance * cover + dst * through. blend: 0 alpha, 1 premultiplied, 2 additive, 3 multiply.
struct SrBlend {
  real cover;
  real3 through;
};

SR_FN SrBlend sr_blend(SrSurface s, real3 to_eye, integer blend) {
  SrBlend b;
  real3 behind = sr_transmittance(s, to_eye);
  real absent = 1.0f - s.alpha;
  b.cover = sr_select(blend == 1, real(1.0f), sr_select(blend == 3, real(0.0f), s.alpha));
  b.through = sr_real3(absent) + behind * s.alpha;
  b.through = sr_select(blend == 2, sr_real3(1.0f), b.through);
  b.through = sr_select(blend == 3, sr_real3(absent) + s.albedo * s.alpha, b.through);
  return b;
}
