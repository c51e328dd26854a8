// The shading model, once for raster fragments (GLSL) and ray hits (C++ scalars and SIMD lanes, through shading_cpp.h).
// Dialect: f suffixes, no swizzles, no in/out parameters, sr_select instead of branches on data, own type names. The
// includer defines real, real2, real3, real4, boolean, integer (a value a lane), one_real, one_real3 (the same for all
// lanes), SR_FN, sr_select, sr_any (whether a condition holds in some lane), sr_atan2.
// Model: metallic-roughness of glTF 2.0 (appendix B): GGX (Walter et al. 2007) with height-correlated Smith visibility
// (Heitz 2014), Schlick's Fresnel, Lambert; split-sum image-based lighting (Karis 2013); what is reflected more than
// once between microfacets leaves the surface as the rest does (Turquin 2019). A thin film (KHR_materials_iridescence:
// Belcour and Barla 2017) colours what the base reflects; the base's lobe may be longer along a direction of the surface
// than across it (KHR_materials_anisotropy). Above it, as in the glTF extensions: sheen
// (KHR_materials_sheen: Estevez and Kulla 2017), then clear coat (KHR_materials_clearcoat), each taking from what lies
// below what it reflects itself; below it, diffuse transmission (KHR_materials_diffuse_transmission).

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

// Returns cos(2 pi t) to 1e-6, by operations that are exact everywhere, for |t| < 2^22.
SR_FN real sr_turned(real t) {
  real x = t - floor(t + 0.5f);
  real x2 = x * x;
  real sine =
      x * (3.14159265f -
           x2 * (5.16771278f - x2 * (2.55016404f - x2 * (0.599264529f - x2 * (0.0821458866f - x2 * 0.00737043095f)))));
  return 1.0f - 2.0f * sine * sine;
}

// Returns exp(-x) for x >= 0 to 2e-6, by such operations.
SR_FN real sr_faded(real x) {
  real u = min(x, real(32.0f)) * 0.0625f;
  real grown =
      1.0f +
      u * (1.0f + u * (0.5f + u * (0.166666667f + u * (0.0416666667f + u * (0.00833333333f + u * 0.00138888889f)))));
  real faded = 1.0f / grown;
  real faded2 = faded * faded;
  real faded4 = faded2 * faded2;
  real faded8 = faded4 * faded4;
  return faded8 * faded8;
}

// Holds fringes of the first and second order in linear sRGB: the spectra cos(2 pi path / wavelength), and the same for
// twice the path, as an observer sees them (Belcour and Barla 2017: Gaussians of the frequency for CIE's colour
// matching functions).
struct SrFringes {
  real3 once;
  real3 twice;
};

SR_FN real3 sr_fringe(real3 waves, real second_wave) {
  real x = waves.x * 0.846590002f + second_wave * 0.153868307f;
  real y = waves.y * 1.00022189f;
  real z = waves.z * 1.00112249f;
  return real3(3.2404542f * x - 1.5371385f * y - 0.4985314f * z, 1.8760108f * y - 0.9692660f * x + 0.0415560f * z,
               0.0556434f * x - 0.2040259f * y + 1.0572252f * z);
}

// Evaluates one Gaussian: x its wave, y that of twice the path.
SR_FN real2 sr_waves(real path, real frequency, real width) {
  real wave = sr_turned(path * frequency);
  real faded = sr_faded(path * path * width);
  real faded2 = faded * faded;
  return real2(wave * faded, (2.0f * wave * wave - 1.0f) * (faded2 * faded2));
}

// `path` in nanometres; beyond 15 micrometres the fringes have vanished.
SR_FN SrFringes sr_fringes(real path) {
  real length_in_film = min(path, real(20000.0f));
  real2 x = sr_waves(length_in_film, 1.6810e-3f, 1.70854696e-7f);
  real2 y = sr_waves(length_in_film, 1.7953e-3f, 3.67330884e-7f);
  real2 z = sr_waves(length_in_film, 2.2084e-3f, 2.61035245e-7f);
  real2 second_x = sr_waves(length_in_film, 2.2399e-3f, 1.78766171e-7f);
  SrFringes f;
  f.once = sr_fringe(real3(x.x, y.x, z.x), second_x.x);
  f.twice = sr_fringe(real3(x.y, y.y, z.y), second_x.y);
  return f;
}

// Returns the reflectance of a film over a base of reflectance f0, in one channel. `first`: reflectance of its upper
// side; `cosine`: of the angle inside the film.
SR_FN real sr_film_channel(real f0, real film_ior, real cosine, real first, real once, real twice) {
  // Amplitude of the lower side's reflection at normal incidence, by the index of refraction that f0 implies: below 0
  // where the base is the thinner medium; a denser one reflects half a wave late.
  real amplitude = sqrt(sr_saturate(f0));
  real above = film_ior * (1.0f - amplitude);
  real jump = (1.0f + amplitude - above) / (1.0f + amplitude + above);
  real second = jump * jump;
  second = second + (1.0f - second) * sr_fifth_power(1.0f - cosine);
  real passed = 1.0f - first;
  real both = min(first * second, real(0.9999f));
  real amplitude_of_both = sqrt(both);
  real from_below = passed * passed * second / (1.0f - both);
  real fringes = sr_select(jump < 0.0f, once, -once) + twice * amplitude_of_both;
  return sr_saturate(first + from_below + 2.0f * (from_below - passed) * amplitude_of_both * fringes);
}

// Returns the reflectance of a film in air, `thickness` nanometres thick, over a base of reflectance f0, at the angle
// of `cosine`: two orders of interference, as KHR_materials_iridescence defines them.
SR_FN real3 sr_film_reflectance(real3 f0, real film_ior, real thickness, real cosine) {
  real inverse_ior = 1.0f / film_ior;
  real inside = sqrt(max(1.0f - inverse_ior * inverse_ior * (1.0f - cosine * cosine), 0.0f));
  real r = (film_ior - 1.0f) / (film_ior + 1.0f);
  real first = r * r + (1.0f - r * r) * sr_fifth_power(1.0f - cosine);
  SrFringes f = sr_fringes(2.0f * film_ior * thickness * inside);
  return real3(sr_film_channel(f0.x, film_ior, inside, first, f.once.x, f.twice.x),
               sr_film_channel(f0.y, film_ior, inside, first, f.once.y, f.twice.y),
               sr_film_channel(f0.z, film_ior, inside, first, f.once.z, f.twice.z));
}

// Returns the surface, facing the eye, with its film; call it before sr_seen(). f0 becomes the value whose Fresnel term
// (Schlick), at the eye's angle to the normal, equals the film's reflectance there, so that a G-buffer can hold it.
SR_FN SrSurface sr_filmed(SrSurface s, SrMaterial m, SrTexels t, real3 to_eye) {
  real thickness = mix(m.iridescence_thickness_min, m.iridescence_thickness_max, t.iridescence_thickness);
  boolean has_film = thickness > 0.0f && !m.unlit;
  real share = sr_select(has_film, sr_saturate(m.iridescence * t.iridescence), real(0.0f));
  boolean filmed = share > 0.0f;  // without a film the index may be anything
  if (sr_any(filmed)) {
    real cosine = clamp(dot(s.normal, to_eye), 0.005f, 1.0f);
    real3 reflected = sr_film_reflectance(s.f0, m.iridescence_ior, thickness, cosine);
    real grazing = sr_fifth_power(1.0f - cosine);
    real3 f0 = max((reflected - sr_real3(grazing)) * (1.0f / (1.0f - grazing)), sr_real3(0.0f));
    s.f0 = sr_select(filmed, mix(s.f0, f0, share), s.f0);
    s.f90 = mix(s.f90, sr_real3(1.0f), share);
  }
  return s;
}

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
