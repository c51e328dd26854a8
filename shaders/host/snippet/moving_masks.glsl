// Masks of an earlier frame.

// The functions below look up masks of an earlier frame, after surfaces or the camera have moved
// (sideray_mask_inputs::moving): at the pixels that showed the fragment's point then, not at its own pixel.
uniform sampler2D sideray_mask_depth;  // depth of each mask pixel along the camera's axis; 0 = nothing was drawn
uniform int sideray_has_mask_depth;
uniform mat4 sideray_mask_clip_from_world;
// Map (x, y, 1), a pixel of the masks, to its view ray's origin and direction, of length 1 along the camera's axis.
uniform mat3 sideray_mask_start, sideray_mask_ray;
uniform vec2 sideray_mask_error;  // a depth d is off by at most x * d * d + y

// Holds the place of a fragment's masks: four pixels and their weights, or no answer.
struct SiderayMaskPlace {
  ivec2 pixel;   // the lower left one
  vec4 weights;  // of it, its right neighbour, the ones above these; their sum is 1, or 0 without an answer
  int reason;    // SIDERAY_MATCHED, _BESIDE; without an answer SIDERAY_NOT_ASKED, _NOT_TRACED, _OTHER_SURFACE
};

// Returns whether a pixel of the masks shows the plane through `position`, within half a pixel, since surfaces curve.
bool sideray_mask_shows(ivec2 pixel, vec3 position, vec3 normal) {
  if (!sideray_is_within(pixel, sideray_mask_size)) return false;
  float depth = SIDERAY_FETCH_2D(sideray_mask_depth, pixel, sideray_mask_size).x;
  if (depth <= 0.0) return false;
  vec3 along = sideray_mask_ray * vec3(pixel, 1.0), start = sideray_mask_start * vec3(pixel, 1.0);
  float breadth = max(length(sideray_mask_ray[0]) * depth, length(sideray_mask_start[0]));
  float rounding = sideray_largest(position) * 4.768e-7;  // 2^-21
  float off = abs(dot(normal, start + along * depth - position));
  float least = 0.5 * breadth + rounding + sideray_mask_error.x * depth * depth + sideray_mask_error.y;
  // A plane seen nearly edge-on is close to everything far along it, so the distance is limited too.
  return off <= least && distance(start + along * depth, position) <= 32.0 * breadth / max(abs(dot(normal, normalize(along))), 0.02);
}

ivec2 sideray_compass(int i) {
  if (i < 4) return i < 2 ? ivec2(i == 0 ? 1 : -1, 0) : ivec2(0, i == 2 ? 1 : -1);
  return ivec2(i < 6 ? 1 : -1, sideray_is_even(i) ? 1 : -1);
}

// Finds the masks of a surface by its position and unit normal (either side) in the frame of the masks.
SiderayMaskPlace sideray_find_masks_on(vec3 previous_world_position, vec3 normal) {
  SiderayMaskPlace place = SiderayMaskPlace(ivec2(0), vec4(0.0), SIDERAY_NOT_ASKED);
  if (sideray_has_mask_depth == 0) return place;
  place.reason = SIDERAY_NOT_TRACED;
  vec4 clip = sideray_mask_clip_from_world * vec4(previous_world_position, 1.0);
  if (clip.w <= 0.0) return place;
  vec2 at = (clip.xy / clip.w * 0.5 + 0.5) * sideray_mask_size;
  if (!sideray_is_within(ivec2(floor(at)), sideray_mask_size)) return place;
  place.reason = SIDERAY_MATCHED;
  place.pixel = ivec2(floor(at - 0.5));
  vec2 part = at - 0.5 - vec2(place.pixel);
  // In a view at rest each pixel uses its own masks, bit for bit.
  part = mix(mix(part, vec2(0.0), vec2(lessThan(part, vec2(0.0078125)))), vec2(1.0), vec2(greaterThan(part, vec2(0.9921875))));
  place.weights = vec4((1.0 - part.x) * (1.0 - part.y), part.x * (1.0 - part.y), (1.0 - part.x) * part.y, part.x * part.y);
  if (!sideray_mask_shows(place.pixel, previous_world_position, normal)) place.weights.x = 0.0;
  if (!sideray_mask_shows(place.pixel + ivec2(1, 0), previous_world_position, normal)) place.weights.y = 0.0;
  if (!sideray_mask_shows(place.pixel + ivec2(0, 1), previous_world_position, normal)) place.weights.z = 0.0;
  if (!sideray_mask_shows(place.pixel + ivec2(1, 1), previous_world_position, normal)) place.weights.w = 0.0;
  float sum = dot(place.weights, vec4(1.0));
  if (sum > 0.0) {
    place.weights /= sum;
    return place;
  }
  // A disoccluded surface has no masks: uses those of its plane nearby.
  place.reason = SIDERAY_BESIDE;
  place.weights.x = 1.0;
  ivec2 middle = ivec2(floor(at));
  int step = 1;
  for (int ring = 0; ring < 5; ++ring) {
    for (int i = 0; i < 8; ++i) {
      place.pixel = middle + sideray_compass(i) * step;
      if (sideray_mask_shows(place.pixel, previous_world_position, normal)) return place;
    }
    step *= 2;
  }
  place.weights.x = 0.0;
  place.reason = SIDERAY_OTHER_SURFACE;
  return place;
}

// Does the same for a fragment of the surface; `previous_world_position` as in sideray_find_moving(). Needs
// derivatives: call it in uniform control flow.
SiderayMaskPlace sideray_find_masks(vec3 previous_world_position) {
  vec3 normal = normalize(cross(dFdx(previous_world_position), dFdy(previous_world_position)));
  return sideray_find_masks_on(previous_world_position, normal);
}

// Reads the square of four pixels whose lower left one is `pixel`: the lower row, then the upper. Clamps coordinates.
vec4 sideray_four_texels(sampler2DArray masks, ivec2 pixel, int layer) {
  vec2 last = sideray_mask_size - 1.0;
  ivec2 low = ivec2(clamp(vec2(pixel), vec2(0.0), last)), high = ivec2(clamp(vec2(pixel) + 1.0, vec2(0.0), last));
  return vec4(SIDERAY_FETCH(masks, low, layer, sideray_mask_size).x,
              SIDERAY_FETCH(masks, ivec2(high.x, low.y), layer, sideray_mask_size).x,
              SIDERAY_FETCH(masks, ivec2(low.x, high.y), layer, sideray_mask_size).x,
              SIDERAY_FETCH(masks, high, layer, sideray_mask_size).x);
}

bool sideray_has_masks(SiderayMaskPlace place) { return dot(place.weights, vec4(1.0)) > 0.0; }

// Return what sideray_shadow(), _shadow_tint(), _shadow_color() and _ao() do, at a place from sideray_find_masks().
float sideray_shadow_at(SiderayMaskPlace place, int light) {
  int layer = light < 0 ? -1 : (light > 31 ? sideray_combined_layer : sideray_shadow_layer[light]) - 1;
  if (layer < 0 || !sideray_has_masks(place)) return 1.0;
  return dot(place.weights, sideray_four_texels(sideray_shadow_masks, place.pixel, layer));
}

vec3 sideray_shadow_tint_at(SiderayMaskPlace place, int light) {
  int layer = light < 0 ? -1 : sideray_tint_layer[light > 31 ? 32 : light] - 1;
  if (layer < 0 || !sideray_has_masks(place)) return vec3(1.0);
  return vec3(dot(place.weights, sideray_four_texels(sideray_shadow_tints, place.pixel, layer)),
              dot(place.weights, sideray_four_texels(sideray_shadow_tints, place.pixel, layer + 1)),
              dot(place.weights, sideray_four_texels(sideray_shadow_tints, place.pixel, layer + 2)));
}

vec3 sideray_shadow_color_at(SiderayMaskPlace place, int light) {
  return sideray_shadow_at(place, light) * sideray_shadow_tint_at(place, light);
}

float sideray_ao_at(SiderayMaskPlace place) {
  if (sideray_has_ao == 0 || !sideray_has_masks(place)) return 1.0;
  vec2 last = sideray_mask_size - 1.0;
  ivec2 low = ivec2(clamp(vec2(place.pixel), vec2(0.0), last)), high = ivec2(clamp(vec2(place.pixel) + 1.0, vec2(0.0), last));
  return dot(place.weights, vec4(SIDERAY_FETCH_2D(sideray_ao_mask, low, sideray_mask_size).x,
                                 SIDERAY_FETCH_2D(sideray_ao_mask, ivec2(high.x, low.y), sideray_mask_size).x,
                                 SIDERAY_FETCH_2D(sideray_ao_mask, ivec2(low.x, high.y), sideray_mask_size).x,
                                 SIDERAY_FETCH_2D(sideray_ao_mask, high, sideray_mask_size).x));
}

// Return the same, with the search; 1 without an answer. Shaders with several lights should call sideray_find_masks()
// once.
float sideray_shadow_moving(int light, vec3 previous_world_position) {
  return sideray_shadow_at(sideray_find_masks(previous_world_position), light);
}

vec3 sideray_shadow_color_moving(int light, vec3 previous_world_position) {
  return sideray_shadow_color_at(sideray_find_masks(previous_world_position), light);
}

float sideray_ao_moving(vec3 previous_world_position) { return sideray_ao_at(sideray_find_masks(previous_world_position)); }

// Returns why this fragment has masks or none: SIDERAY_MATCHED, _BESIDE, _NOT_ASKED, _NOT_TRACED (outside the earlier
// picture) or _OTHER_SURFACE (it was hidden, and its plane was not visible nearby).
int sideray_explain_masks_moving(vec3 previous_world_position) {
  return sideray_find_masks(previous_world_position).reason;
}
