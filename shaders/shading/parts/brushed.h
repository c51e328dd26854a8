// A base whose lobe is longer along a direction of the surface than across it (KHR_materials_anisotropy).

// Returns the surface, facing the eye, with its brushed lobe; call it before sr_seen(). `front_normal` and `tangent`:
// interpolated, of the front face, as for sr_perturb(); without a tangent frame the lobe is round.
SR_FN SrSurface sr_brushed(SrSurface s, SrMaterial m, SrTexels t, real3 front_normal, real4 tangent) {
  real x = t.anisotropy_along * m.anisotropy_cosine - t.anisotropy_across * m.anisotropy_sine;
  real y = t.anisotropy_along * m.anisotropy_sine + t.anisotropy_across * m.anisotropy_cosine;
  real3 u = real3(tangent.x, tangent.y, tangent.z);
  real3 v = cross(front_normal, u) * tangent.w;
  real3 along = u * x + v * y;
  along = along - s.normal * dot(s.normal, along);
  real size = length(along);
  real strength = sr_saturate(m.anisotropy * t.anisotropy);
  boolean brushed = abs(tangent.w) > 0.5f && size > 1e-6f && strength > 0.0f && !m.unlit;
  s.along = sr_select(brushed, along * (1.0f / max(size, 1e-6f)), sr_real3(0.0f));
  s.anisotropy = sr_select(brushed, strength, real(0.0f));
  return s;
}

// Returns the alphas of the base's lobe along and across (KHR_materials_anisotropy); without anisotropy, both are that
// of the roughness.
SR_FN real2 sr_alphas(SrSurface s) {
  real a = s.roughness * s.roughness;
  return real2(mix(a, real(1.0f), s.anisotropy * s.anisotropy), a);
}

// Returns the roughness of a round lobe with about the same albedo as the base's lobe.
SR_FN real sr_round_roughness(SrSurface s) {
  real2 a = sr_alphas(s);
  return sr_select(s.anisotropy > 0.0f, sqrt(sqrt(0.5f * (a.x * a.x + a.y * a.y))), s.roughness);
}

// Returns the cosine at which the round lobe is masked as much as the base's lobe is toward the eye.
SR_FN real sr_round_cosine(SrSurface s, real3 to_eye) {
  real2 a = sr_alphas(s);
  real n_v = abs(dot(s.normal, to_eye));
  real x = dot(s.along, to_eye) * a.x;
  real y = dot(cross(s.normal, s.along), to_eye) * a.y;
  real z2 = n_v * n_v * 0.5f * (a.x * a.x + a.y * a.y);
  return sr_select(s.anisotropy > 0.0f, sqrt(z2 / max(z2 + x * x + y * y, 1e-20f)), n_v);
}

// Returns the base's albedo terms from those of the round lobe at |n.v| (`terms`) and at sr_round_cosine() (`masked`).
// Their sum is that of `masked`, within 7 % of what the lobe reflects; Fresnel's part is that of `terms`.
SR_FN real2 sr_brushed_terms(SrSurface s, real2 terms, real2 masked) {
  real ratio = sr_select(s.anisotropy > 0.0f, (masked.x + masked.y) / max(terms.x + terms.y, 1e-3f), real(1.0f));
  return real2(terms.x * ratio, terms.y * ratio);
}

// Returns the roughness for lookups of a brushed lobe in the prefiltered environment.
SR_FN real sr_look_up_roughness(SrSurface s) {
  return s.roughness;
}

// Returns the normal for lookups of a brushed lobe in the prefiltered environment: bent toward the eye in the plane
// across `along`, more the longer the lobe is. It is the approximation of the extension's sample viewer: round
// prefiltered lobes cannot be long.
SR_FN real3 sr_bent(SrSurface s, real3 to_eye) {
  real3 across = cross(s.normal, s.along);
  real3 bent = cross(cross(across, to_eye), across);
  real kept = 1.0f - s.anisotropy * (1.0f - s.roughness);
  real kept2 = kept * kept;
  real3 mixed = mix(bent, s.normal, kept2 * kept2);
  real size = length(mixed);
  boolean brushed = s.anisotropy > 0.0f && size > 1e-6f;
  return sr_select(brushed, mixed * (1.0f / max(size, 1e-6f)), s.normal);
}
