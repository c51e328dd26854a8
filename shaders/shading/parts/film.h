// A thin film over the base (KHR_materials_iridescence: Belcour and Barla 2017).

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
