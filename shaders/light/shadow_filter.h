// Arithmetic of the shadow denoiser, for single numbers and for lanes; in the dialect of shading.h, included after it.
// The passes, and the loops over pixels: rt/masks/shadow_filter.h. Each pixel has an inverse depth (0 = no surface;
// affine on the screen over any plane) and a reach: the radius, in pixels, in which shadows are about the same. Spatial
// filter: edge-avoiding a-trous wavelets (Dammertz et al. 2010), whose reach is a share of the penumbra's radius.
// Temporal filter: an average over frames, clamped to moments of this frame's neighbourhood (after Salvi), and
// forgotten where that changes it.

const one_real sf_most_penumbra = 32.0f;  // radius in pixels, for any light
const one_real sf_reach_share = 0.4f;     // of the penumbra's radius
const one_real sf_most_reach = 12.8f;     // their product: four passes' support is 15 pixels, less than a tile
const one_real sf_usual_history = 8.0f;   // frames
const one_real sf_sensitivity = 0.02f;    // to a depth off the plane, relative

// Describes a light's disc: tan_radius for a directional light, seen from anywhere; otherwise a sphere in view space.
struct SfLight {
  one_real3 position;
  one_real radius;  // 0 = directional
  one_real tan_radius;
  one_real most_penumbra;  // largest filtered radius in pixels, up to sf_most_penumbra
  one_real most_frames;    // largest number of frames in the average, 1 or more
};

// Maps pixel (x, y) to the point depth * (origin_x + step_x * x, origin_y + step_y * y, 1). If only the view moved, its
// depth in the frame before was depth * dot(before, (.., .., 1)) + before_offset.
struct SfView {
  one_real origin_x;
  one_real origin_y;
  one_real step_x;
  one_real step_y;
  one_real3 before;
  one_real before_offset;
};

struct SfPlane {
  real inverse;
  real slope_x;  // of the inverse depth, per pixel
  real slope_y;
};

struct SfHistory {
  real value;
  real frames;
};

// Holds sums over a pixel's neighbourhood, weighted by how close each neighbour is to the pixel's plane.
struct SfMoments {
  real weight;
  real mean;
  real square;
};

SR_FN real sf_inverse_depth(real depth) {
  return sr_select(depth > 0.0f && depth < 1e30f, 1.0f / max(depth, real(1e-30f)), real(0.0f));
}

// Returns the slope to the neighbour that differs less; 0 where it is steeper than any visible surface.
SR_FN real sf_slope(real behind, real here, real ahead) {
  real back = here - behind;
  real forth = ahead - here;
  boolean use_back = behind > 0.0f && (ahead <= 0.0f || abs(back) <= abs(forth));
  real slope = sr_select(use_back, back, sr_select(ahead > 0.0f, forth, real(0.0f)));
  return sr_select(abs(slope) <= here * 0.25f, slope, real(0.0f));
}

// Returns 1 on the plane, falling to 0.
SR_FN real sf_on_plane(SfPlane plane, real dx, real dy, real inverse) {
  real expected = plane.inverse + plane.slope_x * dx + plane.slope_y * dy;
  real off = (inverse - expected) / (max(expected, real(1e-30f)) * sf_sensitivity);
  return sr_select(expected > 0.0f && inverse > 0.0f, max(1.0f - off * off, real(0.0f)), real(0.0f));
}

// Returns nearly exp(-q / 2), and 0 from q = 8 on.
SR_FN real sf_bell(real q) {
  real rest = max(1.0f - q * 0.125f, real(0.0f));
  real rest2 = rest * rest;
  return rest2 * rest2;
}

// Returns 1 / distance to the occluder; 0 = lit, or not known.
SR_FN real sf_nearness(real visibility, real hit_distance) {
  return sr_select(visibility < 1.0f && hit_distance < 1e30f, 1.0f / max(hit_distance, real(1e-6f)), real(0.0f));
}

// Returns the radius, in pixels, of the filter at pixel (x, y), from the nearness of its occluders. A mean of nearness
// is a harmonic mean of distances, which favours contacts.
SR_FN real sf_reach(SfLight light, SfView view, real x, real y, real inverse, real nearness) {
  real depth = 1.0f / max(inverse, real(1e-30f));
  real hit = 1.0f / max(nearness, real(1e-20f));
  real radius = hit * light.tan_radius;
  if (light.radius > 0.0f) {
    real3 point = real3((x * view.step_x + view.origin_x) * depth, (y * view.step_y + view.origin_y) * depth, depth);
    real distance = length(real3(light.position) - point);
    radius = hit * light.radius / max(distance - hit, distance * 0.001f + 1e-20f);
  }
  real pixels = radius * inverse / abs(view.step_y);
  return min(pixels, real(light.most_penumbra)) * sf_reach_share;
}

// Returns the weight of a neighbour at the squared distance `distance2` in pixels, against 1 for the pixel itself. Uses
// the shorter reach, so that weights are symmetric.
SR_FN real sf_weight(real on_plane, real reach, real other_reach, real distance2) {
  real shorter = max(min(reach, other_reach), real(1e-3f));
  return on_plane * sf_bell(distance2 / (shorter * shorter));
}

// Returns the number of samples that the spatial passes average: steps 1, 2, 4, 8 of [1 2 1] / 4 have a variance of
// 42.5 along an axis, which the reach limits; a Gaussian of variance v averages 4 pi v.
SR_FN real sf_samples(real reach) {
  return max(12.566f / (0.0235294f + 1.0f / max(reach * reach, real(1e-6f))), real(1.0f));
}

// Returns how far the truth may be from the neighbourhood's mean: its spread, plus one to three times (more with longer
// history) the error of a mean of so many samples of 0 or 1. (n p + 1) / (n + 2) estimates p from n samples (Laplace).
SR_FN real sf_allowance(SfMoments m, real samples, real frames) {
  real n = max(m.weight, samples);
  real p = (m.mean * n + 1.0f) / (n + 2.0f);
  real error = sqrt(max(p * (1.0f - p), real(0.0f)) / n);
  real spread = sqrt(max(m.square - m.mean * m.mean, real(0.0f)));
  return spread + error * (1.0f + frames * (2.0f / sf_usual_history));
}

// Returns the inverse depth that a pixel had in the frame before, if only the view moved.
SR_FN real sf_inverse_before(SfView view, real x, real y, real inverse) {
  real depth = 1.0f / max(inverse, real(1e-30f));
  real along = (x * view.step_x + view.origin_x) * view.before.x + (y * view.step_y + view.origin_y) * view.before.y +
               view.before.z;
  return sf_inverse_depth(depth * along + view.before_offset);
}

// history.frames == 0: there is no history.
SR_FN SfHistory sf_accumulate(SfLight light, SfHistory history, real now, SfMoments m, real samples) {
  real allowance = sf_allowance(m, samples, history.frames);
  real held = clamp(history.value, min(m.mean - allowance, now), max(m.mean + allowance, now));
  real moved = abs(held - history.value);
  real frames = history.frames * max(1.0f - moved * 4.0f, real(0.0f));
  SfHistory result;
  real share = 1.0f / min(frames + 1.0f, real(light.most_frames));
  result.value = sr_select(history.frames > 0.0f, held + (now - held) * share, now);
  result.frames = min(frames + 1.0f, real(light.most_frames));
  return result;
}
