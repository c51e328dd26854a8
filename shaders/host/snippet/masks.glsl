// Shadows and the sky's visible share, for opaque surfaces.

uniform sampler2DArray sideray_shadow_masks;  // 1 = lit
uniform sampler2D sideray_ao_mask;            // 1 = open
uniform vec2 sideray_mask_size;               // pixels of both
uniform vec4 sideray_mask_viewport;           // as sideray_viewport: masks may be of another frame and rectangle
uniform int sideray_shadow_layer[32];         // of the masks, counted from 1, for each light; 0 = it has none
uniform int sideray_combined_layer;           // the same for all lights from number 32 on together
uniform int sideray_has_ao;

ivec2 sideray_mask_pixel() {
  return ivec2(floor((gl_FragCoord.xy - sideray_mask_viewport.xy) * sideray_mask_viewport.zw));
}

float sideray_mask_layer(int layer) {
  ivec2 pixel = sideray_mask_pixel();
  if (layer < 0 || !sideray_is_within(pixel, sideray_mask_size)) return 1.0;
  return SIDERAY_FETCH(sideray_shadow_masks, pixel, layer, sideray_mask_size).x;
}

// Returns the visible share of all lights from number 32 on together, weighted by their unshadowed light at this pixel;
// 1 without an answer.
float sideray_shadow_combined() { return sideray_mask_layer(sideray_combined_layer - 1); }

// Returns the visible share of a light, numbered as in the scene, at the opaque surface of this fragment's pixel. It is
// 1 without an answer: there is no mask of this light, or the pixel lies outside of it. Lights from number 32 on share
// one mask. For passes over the depth that was traced.
float sideray_shadow(int light) {
  if (light < 0) return 1.0;
  if (light > 31) return sideray_shadow_combined();
  return sideray_mask_layer(sideray_shadow_layer[light] - 1);
}

uniform sampler2DArray sideray_shadow_tints;  // 1 = all of the colour passes; red, green and blue of each tinted light
uniform int sideray_tint_layer[33];           // the first of a light's three layers, from 1; 0 = nothing tints it

// Returns the share of a light's red, green and blue that translucent surfaces let through to the opaque surface of
// this fragment's pixel; 1 without an answer, and for lights that nothing tints.
vec3 sideray_shadow_tint(int light) {
  if (light < 0) return vec3(1.0);
  int layer = sideray_tint_layer[light > 31 ? 32 : light] - 1;
  ivec2 pixel = sideray_mask_pixel();
  if (layer < 0 || !sideray_is_within(pixel, sideray_mask_size)) return vec3(1.0);
  return vec3(SIDERAY_FETCH(sideray_shadow_tints, pixel, layer, sideray_mask_size).x,
              SIDERAY_FETCH(sideray_shadow_tints, pixel, layer + 1, sideray_mask_size).x,
              SIDERAY_FETCH(sideray_shadow_tints, pixel, layer + 2, sideray_mask_size).x);
}

// Returns the share of a light's red, green and blue that arrives: multiply the light's colour by it.
vec3 sideray_shadow_color(int light) { return sideray_shadow(light) * sideray_shadow_tint(light); }

// Returns the visible share of the sky at the opaque surface of this fragment's pixel; 1 without an answer.
float sideray_ao() {
  if (sideray_has_ao == 0) return 1.0;
  ivec2 pixel = sideray_mask_pixel();
  if (!sideray_is_within(pixel, sideray_mask_size)) return 1.0;
  return SIDERAY_FETCH_2D(sideray_ao_mask, pixel, sideray_mask_size).x;
}

// Under a budget some pixels have no masks yet. sideray_shadow() and sideray_ao() return 1 there; the _or functions
// below return `fallback`, the host's own shadow map or ambient occlusion.
uniform sampler2D sideray_mask_answers;  // 255 times: 1, the lights' masks are known, + 2, the sky's is
uniform int sideray_has_mask_answers;

bool sideray_is_answered(float least) {
  ivec2 pixel = sideray_mask_pixel();
  if (!sideray_is_within(pixel, sideray_mask_size)) return false;
  if (sideray_has_mask_answers == 0) return true;
  float answers = floor(SIDERAY_FETCH_2D(sideray_mask_answers, pixel, sideray_mask_size).x * 255.0 + 0.5);
  return least < 1.5 ? answers == 1.0 || answers == 3.0 : answers >= 2.0;
}

// Return whether a light, numbered as in the scene, or the sky has a mask at this fragment's pixel.
bool sideray_has_shadow(int light) {
  if (light < 0) return false;
  int layer = light > 31 ? sideray_combined_layer : sideray_shadow_layer[light];
  return layer > 0 && sideray_is_answered(1.0);
}
bool sideray_knows_ao() { return sideray_has_ao != 0 && sideray_is_answered(2.0); }

float sideray_shadow_or(int light, float fallback) { return sideray_has_shadow(light) ? sideray_shadow(light) : fallback; }
vec3 sideray_shadow_color_or(int light, vec3 fallback) {
  return sideray_has_shadow(light) ? sideray_shadow_color(light) : fallback;
}
float sideray_ao_or(float fallback) { return sideray_knows_ao() ? sideray_ao() : fallback; }

// Shows the masks at this fragment's pixel as a colour, for a host that integrates them. Red is the light's share,
// green the sky's; magenta: the light has no mask here.
vec3 sideray_debug_masks(int light) {
  return sideray_has_shadow(light) ? vec3(sideray_shadow(light), sideray_ao(), 0.0) : vec3(1.0, 0.0, 1.0);
}
