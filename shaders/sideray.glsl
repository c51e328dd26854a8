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
uniform vec4 sideray_near_plane;   // xyz = unit view direction; orthographic: distance = dot(xyz, world_position) + w
uniform int sideray_match;         // SIDERAY_MATCH_*
uniform float sideray_match_threshold;  // SIDERAY_MATCH_DISTANCE: a share of the distance
uniform float sideray_subpixel;         // by how much of a pixel rasterization moves a vertex along x and along y, at most

#define SIDERAY_MATCH_ID 0
#define SIDERAY_MATCH_NEAREST 1
#define SIDERAY_MATCH_DISTANCE 2

// Distance of a world position along its view ray, as layers store it.
float sideray_distance_to(vec3 world_position) {
  return sideray_eye.w > 0.5 ? distance(world_position, sideray_eye.xyz)
                             : dot(sideray_near_plane.xyz, world_position) + sideray_near_plane.w;
}

float sideray_largest(vec3 v) { return max(max(abs(v.x), abs(v.y)), abs(v.z)); }

// What rasterization and rays may disagree by in the distance d of this fragment: its slope over what vertices are
// moved by, and rounding. Needs derivatives of world_position. Surfaces twice this apart are never taken for each other;
// a looser bound would let the inner wall of a thin glass take the outer wall's layer.
float sideray_tolerance(vec3 world_position, float d) {
  float coordinates = max(sideray_largest(world_position), sideray_largest(sideray_eye.xyz));
  float slope;
  float moved = sideray_subpixel;
  if (sideray_eye.w > 0.5) {
    // Of a plane seen in perspective, 1 / depth and position / depth are linear in the picture: their differences are
    // exact where those of the distance, at a glancing angle, are not.
    vec3 from_eye = world_position - sideray_eye.xyz;
    float inverse_depth = 1.0 / dot(from_eye, sideray_near_plane.xyz);
    vec3 ray = from_eye * inverse_depth;
    float square = dot(ray, ray);
    slope = d * (abs(dot(ray, dFdx(ray)) / square - dFdx(inverse_depth) / inverse_depth) +
                 abs(dot(ray, dFdy(ray)) / square - dFdy(inverse_depth) / inverse_depth));
    // Positions measured from far away (in world space, say) are rounded sideways too.
    moved += max(coordinates - 4.0 * d, 0.0) * 2.384e-7 * inverse_depth / length(dFdx(ray));
  } else {
    slope = fwidth(d);
  }
  return slope * moved + max(d, 0.25 * coordinates) * 2.384e-7;  // 2^-22
}

// Index of the layer at `pixel` of the cache that is the surface at distance d there, or -1. SIDERAY_MATCH_DISTANCE goes
// by its own threshold (Ray Tracing Gems II, listing 50-2); the others take the nearest that is within `tolerance`, and
// SIDERAY_MATCH_ID only of this surface id.
int sideray_find_layer_at(ivec2 pixel, float d, float tolerance, uint surface_id) {
  float best = sideray_match == SIDERAY_MATCH_DISTANCE ? sideray_match_threshold * d : tolerance;
  int found = -1;
  for (int k = 0; k < SIDERAY_MAX_LAYERS; ++k) {
    if (k >= sideray_layers) break;
    float layer = texelFetch(sideray_distance, ivec3(pixel, k), 0).x;
    if (layer <= 0.0) break;
    float off = abs(layer - d);
    bool less = found >= 0 || sideray_match == SIDERAY_MATCH_DISTANCE;
    if (!(less ? off < best : off <= best)) continue;
    if (sideray_match == SIDERAY_MATCH_ID && texelFetch(sideray_surface_id, ivec3(pixel, k), 0).x != surface_id)
      continue;
    best = off;
    found = k;
    if (sideray_match == SIDERAY_MATCH_DISTANCE) break;
  }
  return found;
}

// The same for this fragment.
int sideray_find_layer(vec3 world_position, uint surface_id) {
  float d = sideray_distance_to(world_position);
  ivec2 pixel = ivec2((gl_FragCoord.xy - sideray_viewport.xy) * sideray_viewport.zw);
  return sideray_find_layer_at(pixel, d, sideray_tolerance(world_position, d), surface_id);
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
