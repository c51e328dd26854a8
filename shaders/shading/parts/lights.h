// The light that arrives from a light source, and the place of a direction in a lat-long image.

struct SrLight {
  one_real3 position;
  one_real3 direction;  // in which the light travels
  one_real3 intensity;
  one_real range;  // 0 = unlimited
  one_real cos_inner;
  one_real cos_outer;
  int type;  // sideray_light_type
};

struct SrIncidence {
  real3 to_light;
  real distance;     // 1e30 for a directional light
  real3 irradiance;  // perpendicular to to_light
};

// Returns the light that arrives at `position`, regardless of occluders; attenuation as in KHR_lights_punctual.
SR_FN SrIncidence sr_incidence(SrLight light, real3 position) {
  SrIncidence i;
  if (light.type == 0) {
    i.to_light = real3(-light.direction);
    i.distance = real(1e30f);
    i.irradiance = real3(light.intensity);
    return i;
  }
  real3 offset = real3(light.position) - position;
  i.distance = max(length(offset), 1e-4f);
  i.to_light = offset * (1.0f / i.distance);
  real fade = real(1.0f);
  if (light.range > 0.0f) {
    real q = i.distance * (1.0f / light.range);
    real q2 = q * q;
    fade = sr_saturate(1.0f - q2 * q2);
  }
  if (light.type == 2) {
    real cosine = -dot(i.to_light, real3(light.direction));
    real spot = sr_saturate((cosine - light.cos_outer) * (1.0f / max(light.cos_inner - light.cos_outer, 1e-4f)));
    fade = fade * spot * spot;
  }
  i.irradiance = real3(light.intensity) * (fade / (i.distance * i.distance));
  return i;
}

// Returns lat-long texture coordinates of a unit direction; the first row is +Y, centre = -Z, u grows toward +X.
SR_FN real2 sr_latlong(real3 direction) {
  return real2(0.5f + sr_atan2(direction.x, -direction.z) * 0.159154943f,
               acos(clamp(direction.y, -1.0f, 1.0f)) * 0.318309886f);
}
