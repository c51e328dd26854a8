// The fixed function of OpenGL 1.x (The OpenGL Graphics System, version 2.1, sections 2.14 and 3.8.13) at a point, for
// ray hits: as C++ scalars and SIMD lanes. In the dialect of shading.h, included after it.
//
// In a scene of the fixed function the members of SrSurface have other meanings, so that mirror rays, covers and shadow
// rays use the same code as for the built-in model:
//
//   normal            on the viewer's side; metallic: 1 if that side is lit, -1 if the other one is
//   emissive          the colour without lights, times the texture's factor
//   along             the ambient colour, and diffuse the diffuse one, times that factor
//   sheen             the specular colour: times that factor too, unless it is added after the texture
//   coat_roughness    the shininess
//   albedo            the texture's factor, which limits the lit colour
//   coat_normal       the colour that the texture adds
//   f0, f90           of the mirror, whose share is f0 + (f90 - f0) (1 - n.v)^5

struct SrFixedMaterial {
  real4 color;  // the colour without lighting; alpha always applies
  real3 ambient;
  real3 diffuse;
  real3 specular;
  real3 emission;
  real3 reflectance;
  real fresnel;  // 1: reflectance grows to 1 at grazing angles; like all below, 0 or 1
  real shininess;
  real lit;
  real ambient_follows;  // the vertices' colours
  real diffuse_follows;
  real specular_follows;
  real emission_follows;
  // The texture's factor is of_none + of_texel * texel + of_alpha * the texel's alpha; it adds texel * (adds +
  // adds_alpha * the texel's alpha).
  real of_none;
  real of_texel;
  real of_alpha;
  real adds;
  real adds_alpha;
  real replaces_alpha;
  real modulates_alpha;
  real bends;  // bends or blurs transmitted light: it reflects by its index of refraction
};

struct SrFixedModel {
  one_real3 ambient;
  one_real two_sided;  // 0 or 1
  one_real separate;   // 0 or 1
};

// `s`: from sr_seen(). `texel`: of the texture, 1 without one; `vertex`: the vertices' colour.
SR_FN SrSurface sr_fixed_surface(SrSurface s, SrFixedMaterial m, SrFixedModel model, real4 texel, real4 vertex,
                                 boolean front, boolean blends, real3 to_eye) {
  real3 of_vertex = real3(vertex.x, vertex.y, vertex.z);
  real3 texel_color = real3(texel.x, texel.y, texel.z);
  real3 ambient = mix(m.ambient, of_vertex, m.ambient_follows);
  real3 diffuse = mix(m.diffuse, of_vertex, m.diffuse_follows);
  real3 specular = mix(m.specular, of_vertex, m.specular_follows);
  real3 emission = mix(m.emission, of_vertex, m.emission_follows);
  real3 factor = sr_real3(m.of_none + m.of_alpha * texel.w) + texel_color * m.of_texel;
  real3 unlit = sr_times(of_vertex, real3(m.color.x, m.color.y, m.color.z));
  real3 glowing = emission + sr_times(ambient, real3(model.ambient));
  s.metallic = sr_select(front || real(model.two_sided) > 0.5f, real(1.0f), real(-1.0f));
  s.emissive = sr_times(mix(unlit, glowing, m.lit), factor);
  s.along = sr_times(ambient, factor) * m.lit;
  s.diffuse = sr_times(diffuse, factor) * m.lit;
  s.sheen = sr_times(specular, sr_select(real(model.separate) > 0.5f, sr_real3(1.0f), factor)) * m.lit;
  s.coat_roughness = m.shininess;
  s.albedo = factor;
  s.coat_normal = texel_color * (m.adds + m.adds_alpha * texel.w);
  real own_alpha = m.color.w * mix(real(1.0f), vertex.w, max(m.diffuse_follows, 1.0f - m.lit));
  real alpha = mix(own_alpha, real(1.0f), m.replaces_alpha) * mix(real(1.0f), texel.w, m.modulates_alpha);
  s.alpha = sr_select(blends, sr_saturate(alpha), real(1.0f));
  boolean bends = m.bends > 0.5f;
  real grazing = sr_fifth_power(1.0f - sr_saturate(dot(s.normal, to_eye)));
  s.f0 = sr_select(bends, s.f0, m.reflectance);
  s.f90 = sr_select(bends, s.f90, mix(m.reflectance, sr_real3(1.0f), m.fresnel));
  s.albedo_terms.x = sr_select(bends, s.albedo_terms.x, 1.0f - grazing);
  s.albedo_terms.y = sr_select(bends, s.albedo_terms.y, grazing);
  s.roughness = sr_select(bends, s.roughness, real(0.04f));
  s.behind = sr_real3(0.0f);
  s.occlusion = real(1.0f);
  s.coat = real(0.0f);
  s.coat_share = real(0.0f);
  s.below_sheen = real(1.0f);
  s.sheen_albedo = real(0.0f);
  s.anisotropy = real(0.0f);
  return s;
}

struct SrFixedLight {
  one_real3 place;  // or the direction to it
  one_real distant;  // 0 or 1
  one_real3 ambient;
  one_real3 diffuse;
  one_real3 specular;
  one_real3 axis;  // direction in which the light travels
  one_real exponent;
  one_real cos_cutoff;    // below -1: it shines in all directions
  one_real3 attenuation;  // constant, linear, quadratic
  one_real3 viewer;       // direction to the viewer, unless local
  one_real local_viewer;  // 0 or 1
};

// Returns x^y for x in 0..1, to 1e-4; 0 for x = 0 unless y is 0. Uses the logarithm of the eighth root of x.
SR_FN real sr_fixed_power(real x, real y) {
  real root = sqrt(sqrt(sqrt(max(x, real(1e-30f)))));
  real w = (root - 1.0f) / (root + 1.0f);
  real w2 = w * w;
  real series =
      1.0f + w2 * (0.333333333f + w2 * (0.2f + w2 * (0.142857143f + w2 * (0.111111111f + w2 * 0.0909090909f))));
  real power = sr_faded(max(w * series * y * -16.0f, real(0.0f)));
  return sr_select(x > 0.0f || y == 0.0f, power, real(0.0f));
}

struct SrFixedIncidence {
  real3 to_light;
  real distance;  // 1e30 for a distant light
  real fade;      // attenuation by distance and cone
};

SR_FN SrFixedIncidence sr_fixed_incidence(SrFixedLight light, real3 position) {
  SrFixedIncidence i;
  i.to_light = real3(light.place);
  i.distance = real(1e30f);
  i.fade = real(1.0f);
  if (light.distant < 0.5f) {
    real3 offset = real3(light.place) - position;
    i.distance = max(length(offset), real(1e-20f));
    i.to_light = offset * (1.0f / i.distance);
    i.fade = 1.0f / (light.attenuation.x + i.distance * (light.attenuation.y + i.distance * light.attenuation.z));
  }
  if (light.cos_cutoff >= -1.0f) {
    real along = -dot(i.to_light, real3(light.axis));
    real cone = sr_select(along < light.cos_cutoff, real(0.0f), real(1.0f));
    if (light.exponent > 0.0f) cone = cone * sr_fixed_power(along, real(light.exponent));
    i.fade = i.fade * cone;
  }
  return i;
}

// Holds what a light adds to the lit colour, and its highlight.
struct SrFixedGain {
  real3 lit;
  real3 shine;
};

SR_FN SrFixedGain sr_fixed_gain(SrSurface s, SrFixedLight light, SrFixedIncidence i, real3 to_eye) {
  SrFixedGain gain;
  real toward = dot(s.normal * s.metallic, i.to_light);
  real faces = sr_select(toward > 0.0f, i.fade, real(0.0f));
  gain.lit = sr_times(s.diffuse, real3(light.diffuse)) * (faces * toward);
  gain.shine = sr_times(s.sheen, real3(light.specular)) * faces;
  boolean shines = max(gain.shine.x, max(gain.shine.y, gain.shine.z)) > 0.0f;
  if (sr_any(shines)) {
    real3 to_viewer = sr_select(real(light.local_viewer) > 0.5f, to_eye, real3(light.viewer));
    real3 sum = i.to_light + to_viewer;
    real3 halfway = sum * (1.0f / max(length(sum), real(1e-20f)));
    gain.shine = gain.shine * sr_fixed_power(dot(s.normal * s.metallic, halfway), s.coat_roughness);
  }
  return gain;
}

SR_FN real3 sr_fixed_ambient(SrSurface s, SrFixedLight light, SrFixedIncidence i) {
  return sr_times(s.along, real3(light.ambient)) * i.fade;
}

// Returns the displayed value, plus what the mirror adds. `shine`: highlights that are added after the texture.
SR_FN real3 sr_fixed_color(SrSurface s, real3 lit, real3 shine, real3 mirrored) {
  real3 textured = min(lit, s.albedo) + s.coat_normal + min(shine, sr_real3(1.0f));
  return min(textured, sr_real3(1.0f)) + sr_times(sr_specular_albedo(s), mirrored);
}
