// The passes of the shadow denoiser, one a STAGE: 0 tiles, 1 what lies around tiles, 2 planes and reaches, 3 one step
// of the filter, 4 the mean with the frames before. rt/masks/shadow_filter.cpp is the same on the CPU.
layout(location = 0) out vec4 o_value;

uniform sampler2D noisy_visibility;
uniform sampler2D hit_distances;
uniform sampler2D view_depth;
uniform sampler2D motion_vectors;
uniform sampler2D tile_map;    // least and most visibility, sum and count of distances; then activity and nearness
uniform sampler2D guide;       // inverse depth, its slopes, reach
uniform sampler2D filtered;    // visibility
uniform sampler2D history;     // value, frames, inverse depth
uniform ivec2 size;
uniform int filter_step;
uniform bool has_motion;
uniform SfView view;
uniform SfLight light;

bool is_inside(ivec2 pixel) {
  return all(greaterThanEqual(pixel, ivec2(0))) && all(lessThan(pixel, size));
}

float inverse_at(ivec2 pixel) {
  return is_inside(pixel) ? sf_inverse_depth(texelFetch(view_depth, pixel, 0).x) : 0.0;
}

float nearness_at(ivec2 pixel) {
  if (!(inverse_at(pixel) > 0.0)) return 0.0;
  return sf_nearness(texelFetch(noisy_visibility, pixel, 0).x, texelFetch(hit_distances, pixel, 0).x);
}

bool is_active(ivec2 pixel) {
  return texelFetch(tile_map, pixel / 16, 0).x > 0.0;
}

vec4 tile_of(ivec2 tile) {
  vec4 found = vec4(1.0, 0.0, 0.0, 0.0);
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 16; ++x) {
      ivec2 pixel = tile * 16 + ivec2(x, y);
      if (!(inverse_at(pixel) > 0.0)) continue;
      float seen = texelFetch(noisy_visibility, pixel, 0).x;
      found.xy = vec2(min(found.x, seen), max(found.y, seen));
      float nearness = nearness_at(pixel);
      if (nearness > 0.0) found.zw += vec2(1.0 / max(nearness, 1e-20), 1.0);
    }
  return found;
}

vec4 around_tile(ivec2 tile) {
  ivec2 last = textureSize(tile_map, 0) - 1;
  vec4 found = vec4(1.0, 0.0, 0.0, 0.0);
  for (int y = max(tile.y - 1, 0); y <= min(tile.y + 1, last.y); ++y)
    for (int x = max(tile.x - 1, 0); x <= min(tile.x + 1, last.x); ++x) {
      vec4 near = texelFetch(tile_map, ivec2(x, y), 0);
      found = vec4(min(found.x, near.x), max(found.y, near.y), found.zw + near.zw);
    }
  return vec4(found.x < 1.0 && found.y > 0.0 ? 1.0 : 0.0, found.w > 0.0 ? found.w / found.z : 0.0, 0.0, 0.0);
}

vec4 guide_of(ivec2 pixel) {
  SfPlane plane;
  plane.inverse = inverse_at(pixel);
  if (!is_active(pixel)) return vec4(plane.inverse, 0.0, 0.0, sf_most_reach);
  plane.slope_x = sf_slope(inverse_at(pixel - ivec2(1, 0)), plane.inverse, inverse_at(pixel + ivec2(1, 0)));
  plane.slope_y = sf_slope(inverse_at(pixel - ivec2(0, 1)), plane.inverse, inverse_at(pixel + ivec2(0, 1)));
  float sum = 0.0;
  float total = 0.0;
  for (int dy = -2; dy <= 2; ++dy)
    for (int dx = -2; dx <= 2; ++dx) {
      ivec2 other = pixel + ivec2(dx, dy);
      float nearness = is_inside(other) ? nearness_at(other) : 0.0;
      if (!(nearness > 0.0)) continue;
      float weight = sf_on_plane(plane, float(dx), float(dy), inverse_at(other));
      sum += weight * nearness;
      total += weight;
    }
  float nearness = mix(texelFetch(tile_map, pixel / 16, 0).y, sum / max(total, 1e-6), min(total, 1.0));
  float reach = sf_reach(light, view, float(pixel.x), float(pixel.y), plane.inverse, nearness);
  return vec4(plane.inverse, plane.slope_x, plane.slope_y, reach);
}

vec4 guide_at(ivec2 pixel) {
  return is_inside(pixel) ? texelFetch(guide, pixel, 0) : vec4(0.0);
}

float blurred(ivec2 pixel) {
  float seen = texelFetch(filtered, pixel, 0).x;
  if (!is_active(pixel)) return seen;
  vec4 here = guide_at(pixel);
  SfPlane plane = SfPlane(here.x, here.y, here.z);
  float sum = seen;
  float total = 1.0;
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx) {
      if (dx == 0 && dy == 0) continue;
      ivec2 offset = ivec2(dx, dy) * filter_step;
      vec4 there = guide_at(pixel + offset);
      float on = sf_on_plane(plane, float(offset.x), float(offset.y), there.x);
      float kernel = dx != 0 && dy != 0 ? 0.25 : 0.5;
      float weight = sf_weight(on, here.w, there.w, float(offset.x * offset.x + offset.y * offset.y)) * kernel;
      if (!(weight > 0.0)) continue;
      sum += weight * texelFetch(filtered, pixel + offset, 0).x;
      total += weight;
    }
  return sum / total;
}

SfMoments moments_around(SfPlane plane, ivec2 pixel) {
  float total = 0.0;
  float sum = 0.0;
  float square = 0.0;
  for (int dy = -2; dy <= 2; ++dy)
    for (int dx = -2; dx <= 2; ++dx) {
      ivec2 other = pixel + ivec2(dx, dy);
      if (!is_inside(other)) continue;
      float seen = texelFetch(filtered, other, 0).x;
      float on = sf_on_plane(plane, float(dx), float(dy), guide_at(other).x);
      total += on;
      sum += on * seen;
      square += on * seen * seen;
    }
  float most = max(total, 1e-6);
  return SfMoments(total, sum / most, square / most);
}

SfHistory history_at(SfPlane plane, vec2 place) {
  vec2 corner = floor(place);
  vec2 sum = vec2(0.0);
  float total = 0.0;
  for (int tap = 0; tap < 4; ++tap) {
    vec2 at = corner + vec2(float(tap & 1), float(tap >> 1));
    if (!is_inside(ivec2(at))) continue;
    vec2 apart = at - place;
    vec4 then = texelFetch(history, ivec2(at), 0);
    float weight = (1.0 - abs(apart.x)) * (1.0 - abs(apart.y)) * sf_on_plane(plane, apart.x, apart.y, then.z);
    sum += weight * then.xy;
    total += weight;
  }
  float most = max(total, 1e-6);
  return SfHistory(sum.x / most, total > 0.05 ? sum.y / most : 0.0);
}

vec4 accumulated(ivec2 pixel) {
  float now = texelFetch(filtered, pixel, 0).x;
  vec4 here = guide_at(pixel);
  if (!is_active(pixel)) return vec4(now, light.most_frames, here.x, 0.0);
  SfPlane plane = SfPlane(here.x, here.y, here.z);
  SfPlane then = plane;
  then.inverse = sf_inverse_before(view, float(pixel.x), float(pixel.y), here.x);
  vec2 motion = has_motion ? texelFetch(motion_vectors, pixel, 0).xy : vec2(0.0);
  vec2 from = vec2(pixel) - motion;
  // A position that is no number, or lies outside, has no history.
  bool known = from.x >= -2.0 && from.y >= -2.0 && from.x <= float(size.x + 1) && from.y <= float(size.y + 1);
  SfHistory before = SfHistory(0.0, 0.0);
  if (known) before = history_at(then, from);
  SfHistory result = sf_accumulate(light, before, now, moments_around(plane, pixel), sf_samples(here.w));
  return vec4(result.value, result.frames, here.x, 0.0);
}

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
#if STAGE == 0
  o_value = tile_of(pixel);
#elif STAGE == 1
  o_value = around_tile(pixel);
#elif STAGE == 2
  o_value = guide_of(pixel);
#elif STAGE == 3
  o_value = vec4(blurred(pixel));
#else
  o_value = accumulated(pixel);
#endif
}
