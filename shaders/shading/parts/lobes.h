// How a surface reflects the light of one direction.

SR_FN real3 sr_fresnel(real3 f0, real3 f90, real cosine) {
  return f0 + (f90 - f0) * sr_fifth_power(1.0f - sr_saturate(cosine));
}

// Returns distribution times visibility of the GGX lobe about `normal`, without Fresnel and cosine.
SR_FN real sr_ggx(real3 normal, real3 h, real n_l, real n_v, real roughness) {
  real n_h = sr_saturate(dot(normal, h));
  real a = roughness * roughness;
  real a2 = a * a;
  // 1 - (1 - a2) n_h^2 without cancellation near n_h = 1.
  real3 n_x_h = cross(normal, h);
  real f = a2 * n_h * n_h + dot(n_x_h, n_x_h);
  real d = a2 / (3.14159265f * max(f * f, 1e-20f));
  return d * 0.5f / max(n_l * sqrt(n_v * n_v * (1.0f - a2) + a2) + n_v * sqrt(n_l * n_l * (1.0f - a2) + a2), 1e-6f);
}

// Returns the same for the base's brushed lobe (Heitz 2014).
SR_FN real sr_long_ggx(SrSurface s, real3 to_eye, real3 to_light, real3 h, real n_l, real n_v) {
  real2 a = sr_alphas(s);
  real3 across = cross(s.normal, s.along);
  real n_h = sr_saturate(dot(s.normal, h));
  real x = dot(s.along, h) * a.y;
  real y = dot(across, h) * a.x;
  real z = n_h * a.x * a.y;
  // a.x a.y times the slopes' term, so that only the last step divides by small numbers.
  real f = x * x + y * y + z * z;
  real a2 = a.x * a.y;
  real d = a2 * a2 * a2 / (3.14159265f * max(f * f, 1e-30f));
  real v_x = dot(s.along, to_eye) * a.x;
  real v_y = dot(across, to_eye) * a.y;
  real l_x = dot(s.along, to_light) * a.x;
  real l_y = dot(across, to_light) * a.y;
  return d * 0.5f /
         max(n_l * sqrt(v_x * v_x + v_y * v_y + n_v * n_v) + n_v * sqrt(l_x * l_x + l_y * l_y + n_l * n_l), 1e-6f);
}

// Returns the same for the sheen lobe: distribution of Estevez and Kulla 2017, visibility of Neubelt and Pettineo 2013.
SR_FN real sr_sheen(real n_h, real n_l, real n_v, real roughness) {
  real inverse_alpha = 1.0f / (roughness * roughness);
  real sine2 = max(1.0f - n_h * n_h, 1e-7f);
  real d = (2.0f + inverse_alpha) * exp(log(sine2) * (0.5f * inverse_alpha)) * 0.159154943f;
  return d / max(4.0f * (n_l + n_v - n_l * n_v), 1e-4f);
}

// Returns whether light from a direction can matter: from the front, or through the surface.
SR_FN boolean sr_faces(SrSurface s, real3 to_light) {
  return dot(s.normal, to_light) > 0.0f || max(s.behind.x, max(s.behind.y, s.behind.z)) > 0.0f;
}

// Holds radiance toward the eye per irradiance perpendicular to `to_light`, which is BSDF times cosine: of the lobes
// that scatter everywhere (diffuse, transmitted diffuse, sheen) and of those about the mirror direction (base, coat).
struct SrReflection {
  real3 wide;
  real3 glossy;
};

SR_FN SrReflection sr_reflection(SrSurface s, real3 to_eye, real3 to_light) {
  real3 sum = to_eye + to_light;
  real3 h = sum * (1.0f / max(length(sum), 1e-6f));
  real cosine = dot(s.normal, to_light);
  real n_l = sr_saturate(cosine);
  real n_v = max(abs(dot(s.normal, to_eye)), 1e-4f);
  real3 fresnel = sr_fresnel(s.f0, s.f90, dot(to_eye, h));
  SrReflection r;
  r.wide = sr_times(max(sr_real3(1.0f) - fresnel, sr_real3(0.0f)), s.diffuse) * (n_l * 0.318309886f) +
           s.behind * (sr_saturate(-cosine) * 0.318309886f);
  real base = sr_ggx(s.normal, h, n_l, n_v, s.roughness);
  if (sr_any(s.anisotropy > 0.0f))
    base = sr_select(s.anisotropy > 0.0f, sr_long_ggx(s, to_eye, to_light, h, n_l, n_v), base);
  r.glossy = fresnel * (base * n_l);
  if (sr_any(max(s.sheen.x, max(s.sheen.y, s.sheen.z)) > 0.0f)) {
    real sheen = sr_sheen(sr_saturate(dot(s.normal, h)), n_l, n_v, s.sheen_roughness) * n_l;
    r.wide = r.wide * s.below_sheen + s.sheen * sheen;
    r.glossy = r.glossy * s.below_sheen;
  }
  if (sr_any(s.coat_share > 0.0f)) {
    real coat_n_l = sr_saturate(dot(s.coat_normal, to_light));
    real coat_n_v = max(abs(dot(s.coat_normal, to_eye)), 1e-4f);
    real coat = sr_ggx(s.coat_normal, h, coat_n_l, coat_n_v, s.coat_roughness) * coat_n_l;
    r.wide = r.wide * (1.0f - s.coat_share);
    r.glossy = r.glossy * (1.0f - s.coat_share) + sr_real3(coat * s.coat_share);
  }
  return r;
}

SR_FN real3 sr_reflect_light(SrSurface s, real3 to_eye, real3 to_light) {
  SrReflection r = sr_reflection(s, to_eye, to_light);
  return r.wide + r.glossy;
}
