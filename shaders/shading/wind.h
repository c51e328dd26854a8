// Moves a vertex by wind, in both GLSL and C++ (through shading_cpp.h; dialect: shading.h). Trunk, branches and leaves
// as in GPU Gems 3, chapter 16 (Sousa 2007), with its smooth triangle waves: plain arithmetic, so that both languages
// agree except for rounding.

struct SrWind {
  one_real3 direction;  // unit, object space
  one_real amplitude;
  one_real height;
  one_real branch_amplitude;
  one_real leaf_amplitude;
  one_real wavelength;
};

// Holds the phases of trunk, branches and leaves: cycles, reduced to 0..1 by the caller in double precision.
struct SrWindPhase {
  real trunk;
  real branch;
  real leaf;
};

SR_FN real sr_fract(real x) {
  return x - floor(x);
}

// Returns a smooth wave in -1..1 of period 1.
SR_FN real sr_wave(real x) {
  real t = abs(sr_fract(x) * 2.0f - 1.0f);
  return t * t * (3.0f - 2.0f * t) * 2.0f - 1.0f;
}

// Returns the offset of a vertex at `position` (object space, neutral).
SR_FN real3 sr_wind(SrWind wind, SrWindPhase phase, real3 position) {
  real up = clamp(position.y * (1.0f / wind.height), 0.0f, 2.0f);
  real sway = 0.75f * sr_wave(phase.trunk) + 0.25f * sr_wave(2.0f * phase.trunk + 0.3f);
  real3 moved = real3(wind.direction) * (wind.amplitude * up * up * sway);
  real across = sqrt(position.x * position.x + position.z * position.z);
  real along = (position.x * wind.direction.x + position.z * wind.direction.z) * (1.0f / wind.wavelength);
  real reach = clamp(across * (1.0f / wind.height), 0.0f, 2.0f);
  moved = moved + real3(0.0f, 1.0f, 0.0f) * (wind.branch_amplitude * reach * sr_wave(phase.branch + along));
  real where = (position.x * 1.7f + position.y * 2.3f + position.z * 1.1f) * (3.0f / wind.wavelength);
  real flutter = wind.leaf_amplitude * up;
  return moved + real3(sr_wave(phase.leaf + where), 0.5f * sr_wave(phase.leaf + where * 1.31f + 0.25f),
                       sr_wave(phase.leaf + where * 0.83f + 0.5f)) *
                     flutter;
}

// Returns a bound on the length of sr_wind() at any time.
SR_FN real sr_wind_bound(SrWind wind, real3 position) {
  real up = clamp(position.y * (1.0f / wind.height), 0.0f, 2.0f);
  real across = sqrt(position.x * position.x + position.z * position.z);
  real reach = clamp(across * (1.0f / wind.height), 0.0f, 2.0f);
  return wind.amplitude * up * up + wind.branch_amplitude * reach + 1.5f * wind.leaf_amplitude * up;
}
