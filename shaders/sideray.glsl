// Sideray's snippet: what a host's shaders include. See docs/embedding.md.
// Define SIDERAY_MAX_LAYERS (1..8) before it where fewer than 8 layers are ever used. Needs GLSL 1.30 or later.
#ifndef SIDERAY_GLSL
#define SIDERAY_GLSL 1
#ifndef SIDERAY_MAX_LAYERS
#define SIDERAY_MAX_LAYERS 8
#endif

uniform sampler2DArray sideray_radiance;
uniform sampler2DArray sideray_distance;
uniform usampler2DArray sideray_surface_id;
uniform int sideray_layers;        // 0 = no answer anywhere
uniform vec4 sideray_viewport;     // pixel of gl_FragCoord.xy = xy * zw: origin and scale of the cache
uniform vec4 sideray_eye;          // xyz = eye (w = 1, perspective) or unit view direction (w = 0, orthographic)
uniform vec4 sideray_near_plane;   // orthographic: distance = dot(xyz, world_position) + w

// Distance of a world position along its view ray, as layers store it.
float sideray_distance_to(vec3 world_position) {
  return sideray_eye.w > 0.5 ? distance(world_position, sideray_eye.xyz)
                             : dot(sideray_near_plane.xyz, world_position) + sideray_near_plane.w;
}

// Index of the layer that holds `surface_id` at this fragment, or -1. The same id is needed; among those the nearest
// distance wins, no farther off than what rasterization and rays may disagree by: subpixel snapping moves a fragment by
// up to 1/256 pixel, so the slope of the distance over 1/128 pixel, and rounding of positions and distances. A looser
// bound would let the inner wall of a thin glass take the outer wall's layer.
int sideray_find_layer(vec3 world_position, uint surface_id) {
  float d = sideray_distance_to(world_position);
  float best = fwidth(d) * 0.0078125 + d * 2e-6;
  int found = -1;
  ivec2 pixel = ivec2((gl_FragCoord.xy - sideray_viewport.xy) * sideray_viewport.zw);
  for (int k = 0; k < SIDERAY_MAX_LAYERS; ++k) {
    if (k >= sideray_layers) break;
    float layer = texelFetch(sideray_distance, ivec3(pixel, k), 0).x;
    if (layer <= 0.0) break;
    float off = abs(layer - d);
    if (off <= best && texelFetch(sideray_surface_id, ivec3(pixel, k), 0).x == surface_id) {
      best = off;
      found = k;
    }
  }
  return found;
}

// The ray-traced colour C of dst = C*a + dst*T for this fragment, or `fallback` where there is no answer. surface_id is
// the number given to the scene; 0 skips the search (a branch that is uniform over the draw).
vec3 sideray_translucent(vec3 fallback, vec3 world_position, uint surface_id) {
  if (surface_id == 0u || sideray_layers == 0) return fallback;
  int layer = sideray_find_layer(world_position, surface_id);
  if (layer < 0) return fallback;
  ivec2 pixel = ivec2((gl_FragCoord.xy - sideray_viewport.xy) * sideray_viewport.zw);
  return texelFetch(sideray_radiance, ivec3(pixel, layer), 0).rgb;
}
#endif
