// Sideray's snippet: what a host's shaders include. See docs/embedding.md.
// It needs GLSL 1.30 or ES 3.00, or 1.20 with EXT_texture_array; in 1.20 surface ids are floats below 2^24
// (sideray_layer_inputs::float_ids). Define before it, where needed:
//   SIDERAY_MAX_LAYERS    1..8, if fewer than 8 layers are ever used
//   SIDERAY_DEBUG         fragments without an answer show a colour that says why
//   SIDERAY_MULTISAMPLED  glass is drawn multisampled, but the frame's source is resolved. (If the source is
//                         multisampled too, the service tells the snippet.)
#ifndef SIDERAY_GLSL
#define SIDERAY_GLSL 1
#ifndef SIDERAY_MAX_LAYERS
#define SIDERAY_MAX_LAYERS 8
#endif

#ifdef GL_ES
precision highp float;
precision highp int;
precision highp sampler2DArray;
precision highp usampler2DArray;
#endif
#if __VERSION__ >= 130
#define SIDERAY_UINT uint
#define SIDERAY_NO_SURFACE 0u
#define SIDERAY_ID_SAMPLER usampler2DArray
#define SIDERAY_FETCH(texture, pixel, layer, size) texelFetch(texture, ivec3(pixel, layer), 0)
#define SIDERAY_FETCH_2D(texture, pixel, size) texelFetch(texture, pixel, 0)
#else
#define SIDERAY_UINT float
#define SIDERAY_NO_SURFACE 0.0
#define SIDERAY_ID_SAMPLER sampler2DArray
#define SIDERAY_FETCH(texture, pixel, layer, size) texture2DArray(texture, vec3((vec2(pixel) + 0.5) / (size), float(layer)))
#define SIDERAY_FETCH_2D(texture, pixel, size) texture2D(texture, (vec2(pixel) + 0.5) / (size))
#endif

uniform sampler2DArray sideray_radiance;
uniform sampler2DArray sideray_distance;
uniform SIDERAY_ID_SAMPLER sideray_surface_id;
uniform vec2 sideray_cache_size;   // pixels of the three above
uniform int sideray_layers;        // 0 = no answer anywhere
uniform vec4 sideray_viewport;     // pixel of gl_FragCoord.xy = xy * zw: origin and scale of the cache
uniform vec4 sideray_eye;          // xyz = eye (w = 1, perspective) or unit view direction (w = 0, orthographic)
uniform vec4 sideray_near_plane;   // xyz = unit view direction; orthographic: distance = dot(xyz, world_position) + w
uniform int sideray_rate;          // pixels that hold layers: 0 all, 1 a checkerboard, 2 every other row, 3 one of 2x2
// Maps (x, y, 1), a pixel of the cache, to a direction along its view ray (perspective) or a point of the near plane.
uniform mat3 sideray_ray_from_pixel;
uniform mat4 sideray_clip_from_world;  // of the view that the cache was traced for
uniform int sideray_match;         // SIDERAY_MATCH_*
uniform float sideray_match_threshold;  // SIDERAY_MATCH_DISTANCE: a share of the distance
uniform float sideray_subpixel;         // the most that rasterization moves a vertex along x or along y, in pixels
uniform int sideray_multisampled;       // the target has several samples a pixel

#define SIDERAY_MATCH_ID 0
#define SIDERAY_MATCH_NEAREST 1
#define SIDERAY_MATCH_DISTANCE 2

// Returns the distance of a world position along its view ray, as layers store it.
float sideray_distance_to(vec3 world_position) {
  return sideray_eye.w > 0.5 ? distance(world_position, sideray_eye.xyz)
                             : dot(sideray_near_plane.xyz, world_position) + sideray_near_plane.w;
}

float sideray_largest(vec3 v) { return max(max(abs(v.x), abs(v.y)), abs(v.z)); }

// Returns a bound on the rounding of a distance d.
float sideray_rounding(vec3 world_position, float d) {
  float coordinates = max(sideray_largest(world_position), sideray_largest(sideray_eye.xyz));
  return max(d, 0.25 * coordinates) * 2.384e-7;  // 2^-22
}

bool sideray_has_samples() {
#ifdef SIDERAY_MULTISAMPLED
  return true;
#else
  return sideray_multisampled != 0;
#endif
}

// In a multisampled target a fragment is shaded at the pixel's middle, even if its triangle covers other samples only.
// Its position then lies on the triangle's plane, up to half a pixel outside the triangle, where rays hit the
// neighbouring triangle. The two distances differ by the difference of both slopes. If the triangles are tilted by at
// most 45 degrees against each other, that is less than the fragment's own slope plus a pixel's breadth.
float sideray_beside(float slope, float breadth) { return sideray_has_samples() ? slope + breadth : 0.0; }

// Returns how far the rasterizer's distance d of this fragment may be from the ray's: the slope times how far vertices
// snap, plus rounding. Surfaces twice this apart are never confused; a looser bound would let the inner wall of a thin
// glass take the outer wall's layer. Needs derivatives of world_position.
// `beside`: by how much the distance changes to the neighbouring pixel, and the pixel's breadth at the surface.
float sideray_tolerance(vec3 world_position, float d, out vec2 beside) {
  float coordinates = max(sideray_largest(world_position), sideray_largest(sideray_eye.xyz));
  float slope, breadth;
  float moved = sideray_subpixel;
  if (sideray_eye.w > 0.5) {
    // On a plane in perspective 1 / depth and position / depth are linear in the picture, so their derivatives are
    // exact. Those of the distance are not, at glancing angles.
    vec3 from_eye = world_position - sideray_eye.xyz;
    float inverse_depth = 1.0 / dot(from_eye, sideray_near_plane.xyz);
    vec3 ray = from_eye * inverse_depth;
    float square = dot(ray, ray);
    slope = d * (abs(dot(ray, dFdx(ray)) / square - dFdx(inverse_depth) / inverse_depth) +
                 abs(dot(ray, dFdy(ray)) / square - dFdy(inverse_depth) / inverse_depth));
    // Positions far from their origin (in world space, say) are also rounded across the ray.
    moved += max(coordinates - 4.0 * d, 0.0) * 2.384e-7 * inverse_depth / length(dFdx(ray));
    breadth = length(dFdx(ray)) / abs(inverse_depth);
  } else {
    slope = fwidth(d);
    breadth = length(dFdx(world_position) - sideray_near_plane.xyz * dFdx(d));
  }
  beside = vec2(slope, breadth);
  return slope * moved + sideray_rounding(world_position, d) + sideray_beside(slope, breadth);
}

// Under a budget the cache may hold reprojected layers of earlier frames. Their distance is that of the surface's
// tangent plane in the middle of this pixel. For curved surfaces an eighth of a pixel's breadth is added to the
// tolerance, as for a neighbour's layer at a reduced rate.
uniform int sideray_older;  // whether there are reprojected layers

bool sideray_is_older(ivec2 pixel, int layer) {
  return sideray_older != 0 && SIDERAY_FETCH(sideray_radiance, pixel, layer, sideray_cache_size).a < 0.75;
}

// A surface that refracts is resolved: its layer holds everything that is seen through it. It is the last layer of its
// pixel and hides what lies behind. Its distance is stored as a negative number.
uniform int sideray_refracts;  // whether there are resolved layers

#define SIDERAY_HIDDEN_LAYER (-2)

// Returns the index of the layer at `pixel` of the cache that holds the surface at distance d, or -1. Behind a resolved
// layer it returns SIDERAY_HIDDEN_LAYER. SIDERAY_MATCH_DISTANCE uses its own threshold (Ray Tracing Gems II, listing
// 50-2). The others take the nearest layer within `tolerance`, or within `older_tolerance` if it is reprojected;
// SIDERAY_MATCH_ID takes layers of this surface id only. A reprojected layer hides nothing, since what was behind it
// may be visible now.
int sideray_find_within(ivec2 pixel, float d, float tolerance, float older_tolerance, SIDERAY_UINT surface_id) {
  float best = sideray_match == SIDERAY_MATCH_DISTANCE ? sideray_match_threshold * d : tolerance;
  // The resolved surface must not hide itself. In multisampled targets the tolerance is wide enough for that.
  float hidden_behind = (sideray_has_samples() ? 1.0 : 4.0) * best;
  float best_older = sideray_match == SIDERAY_MATCH_ID ? older_tolerance : best;
  int found = -1;
  for (int k = 0; k < SIDERAY_MAX_LAYERS; ++k) {
    if (k >= sideray_layers) break;
    float layer = SIDERAY_FETCH(sideray_distance, pixel, k, sideray_cache_size).x;
    if (layer == 0.0) break;
    bool older = sideray_is_older(pixel, k);
    if (layer < 0.0 && found < 0 && d + layer > hidden_behind && !older) return SIDERAY_HIDDEN_LAYER;
    float off = abs(abs(layer) - d);
    bool less = found >= 0 || sideray_match == SIDERAY_MATCH_DISTANCE;
    float within = older ? best_older : best;
    if (!(less ? off < within : off <= within)) continue;
    if (sideray_match == SIDERAY_MATCH_ID && SIDERAY_FETCH(sideray_surface_id, pixel, k, sideray_cache_size).x != surface_id)
      continue;
    best = off;
    best_older = off;
    found = k;
    if (sideray_match == SIDERAY_MATCH_DISTANCE) break;
  }
  return found;
}

int sideray_find_layer_at(ivec2 pixel, float d, float tolerance, SIDERAY_UINT surface_id) {
  return sideray_find_within(pixel, d, tolerance, tolerance, surface_id);
}

ivec2 sideray_pixel() {
  return ivec2(floor((gl_FragCoord.xy - sideray_viewport.xy) * sideray_viewport.zw));
}

// Describes a fragment for its search in the cache.
struct SiderayFragment {
  ivec2 pixel;  // of the cache
  vec3 position, normal;  // of its plane; normal: unit, either side
  float distance;
  float tolerance, older_tolerance;  // of the distance, at the fragment's own pixel
  SIDERAY_UINT surface_id;
};

// Returns the distance at which the view ray meets the fragment's plane. On large polygons, which begin behind the eye
// and end far away, drivers interpolate positions coarsely: on the plane, but up to several pixels beside the ray.
float sideray_on_ray(SiderayFragment f) {
  bool perspective = sideray_eye.w > 0.5;
  vec3 along = sideray_ray_from_pixel * vec3(f.pixel, 1.0);
  vec3 origin = perspective ? sideray_eye.xyz : along;
  vec3 direction = perspective ? normalize(along) : sideray_eye.xyz;
  float farther = dot(f.normal, f.position - origin - direction * f.distance) / dot(f.normal, direction);
  // Triangles without an area have no plane.
  return abs(farther) <= 0.5 * f.distance ? f.distance + farther : f.distance;
}

// Needs derivatives: call it in uniform control flow.
SiderayFragment sideray_fragment(vec3 world_position, SIDERAY_UINT surface_id) {
  SiderayFragment f;
  f.pixel = sideray_pixel();
  f.position = world_position;
  f.normal = normalize(cross(dFdx(world_position), dFdy(world_position)));
  f.distance = sideray_distance_to(world_position);
  vec2 beside;
  f.tolerance = sideray_tolerance(world_position, f.distance, beside);
  f.distance = sideray_on_ray(f);
  f.older_tolerance = f.tolerance + 0.125 * length(beside);
  f.surface_id = surface_id;
  return f;
}

bool sideray_is_even(int i) { return mod(float(i), 2.0) < 0.5; }

// Returns whether a pixel of the cache was traced: it belongs to the pattern, or the second wave found layers there.
bool sideray_is_traced(ivec2 pixel) {
  if (sideray_rate == 0) return true;
  bool even_x = sideray_is_even(pixel.x), even_y = sideray_is_even(pixel.y);
  bool of_pattern = sideray_rate == 1 ? even_x == even_y : even_y && (sideray_rate == 2 || even_x);
  return of_pattern || SIDERAY_FETCH(sideray_distance, pixel, 0, sideray_cache_size).x != 0.0;
}

// Returns the offset of pair 0, 1 or 2; zero if there are no more. The traced neighbours of a pixel that was not traced
// form pairs on opposite sides of it. At full rate, for outlines in multisampled targets, pairs 2 and 3 are the
// diagonals.
ivec2 sideray_pair(ivec2 pixel, int pair) {
  if (pair > 1 && sideray_rate == 0) return pair == 2 ? ivec2(1, 1) : ivec2(-1, 1);
  if (sideray_rate <= 1) return pair == 0 ? ivec2(1, 0) : pair == 1 ? ivec2(0, 1) : ivec2(0);
  if (pair > 2) return ivec2(0);
  if (sideray_rate == 2) return pair == 0 ? ivec2(0, 1) : pair == 1 ? ivec2(1, 1) : ivec2(-1, 1);
  bool even_x = sideray_is_even(pixel.x), even_y = sideray_is_even(pixel.y);
  if (!even_x && !even_y) return pair == 0 ? ivec2(1, 1) : pair == 1 ? ivec2(-1, 1) : ivec2(0);
  return pair > 0 ? ivec2(0) : even_y ? ivec2(1, 0) : ivec2(0, 1);
}

bool sideray_is_within(ivec2 pixel, vec2 size) {
  return all(greaterThanEqual(pixel, ivec2(0))) && all(lessThan(vec2(pixel), size));
}

// Intersects the view ray of `pixel` with the fragment's plane. x = the distance, at most 0 where they do not meet; y =
// the tolerance for a layer of the same surface. Distances of different pixels are not compared directly, since at
// glancing angles they differ by more than surfaces do. Along the plane's normal, y allows rounding and, for curvature,
// an eighth of the distance between the two pixels' rays: a surface seen at angle i that turns by cos(i) / 4 per pixel
// leaves its tangent plane by half that turn times the 1 / cos(i) between its two points.
vec2 sideray_meet_plane(SiderayFragment f, ivec2 pixel) {
  vec3 along = sideray_ray_from_pixel * vec3(pixel, 1.0);
  bool perspective = sideray_eye.w > 0.5;
  vec3 origin = perspective ? sideray_eye.xyz : along;
  vec3 direction = perspective ? normalize(along) : sideray_eye.xyz;
  float toward = dot(f.normal, direction);
  float apart = distance(origin + direction * f.distance, f.position);
  float off_plane = apart * 0.125 + sideray_rounding(f.position, f.distance);
  return vec2(dot(f.normal, f.position - origin) / toward, off_plane / abs(toward));
}

// Returns the index of the layer of the fragment's surface at a pixel of the pattern, in the fragment's plane, or -1.
int sideray_donor(SiderayFragment f, ivec2 pixel) {
  if (!sideray_is_within(pixel, sideray_cache_size)) return -1;
  vec2 met = sideray_meet_plane(f, pixel);
  // The plane of a fragment outside its triangle says little about the neighbouring pixel.
  if (sideray_has_samples()) met = vec2(met.x > 0.0 ? met.x : f.distance, max(met.y, 0.0) + 2.0 * f.tolerance);
  return met.x > 0.0 ? sideray_find_layer_at(pixel, met.x, met.y, f.surface_id) : -1;
}

// Kinds of answers for a fragment.
#define SIDERAY_NOTHING 0    // no answer: keep the raster look
#define SIDERAY_ANSWER 1     // the radiance is C of dst = C*a + dst*T
#define SIDERAY_REFRACTED 2  // the radiance includes what is seen through the surface: dst = C
#define SIDERAY_HIDDEN 3     // the fragment lies behind a resolved surface: discard it

// Reads the layer that was found for a fragment, and returns its kind of answer.
int sideray_answer(ivec2 pixel, int layer, out vec3 radiance) {
  radiance = vec3(0.0);
  if (layer == SIDERAY_HIDDEN_LAYER) return SIDERAY_HIDDEN;
  if (layer < 0) return SIDERAY_NOTHING;
  radiance = SIDERAY_FETCH(sideray_radiance, pixel, layer, sideray_cache_size).rgb;
  bool resolved = sideray_refracts != 0 && SIDERAY_FETCH(sideray_distance, pixel, layer, sideray_cache_size).x < 0.0;
  return resolved ? SIDERAY_REFRACTED : SIDERAY_ANSWER;
}

// Averages the layers of neighbours. If both pixels of a pair have one, only pairs count: their mean has no first-order
// error. The fragment is hidden if all neighbours hide it.
int sideray_from_donors(SiderayFragment f, out vec3 radiance) {
  vec3 of_pairs = vec3(0.0), of_singles = vec3(0.0);
  float pairs = 0.0, singles = 0.0;
  int answer = SIDERAY_ANSWER, hiding = 0, asked = 0;
  for (int pair = 0; pair < 4; ++pair) {
    ivec2 off = sideray_pair(f.pixel, pair);
    if (off == ivec2(0) || (sideray_rate == 0 && pair > 1 && (singles > 0.0 || pairs > 0.0 || hiding > 0))) break;
    vec3 color_a, color_b;
    int a = sideray_answer(f.pixel - off, sideray_donor(f, f.pixel - off), color_a);
    int b = sideray_answer(f.pixel + off, sideray_donor(f, f.pixel + off), color_b);
    bool has_a = a == SIDERAY_ANSWER || a == SIDERAY_REFRACTED, has_b = b == SIDERAY_ANSWER || b == SIDERAY_REFRACTED;
    asked += 2;
    if (a == SIDERAY_HIDDEN) ++hiding;
    if (b == SIDERAY_HIDDEN) ++hiding;
    if (!has_a && !has_b) continue;
    if (a == SIDERAY_REFRACTED || b == SIDERAY_REFRACTED) answer = SIDERAY_REFRACTED;
    vec3 sum = (has_a ? color_a : vec3(0.0)) + (has_b ? color_b : vec3(0.0));
    if (has_a && has_b) {
      of_pairs += sum;
      pairs += 2.0;
    } else {
      of_singles += sum;
      singles += 1.0;
    }
  }
  radiance = pairs > 0.0 ? of_pairs / pairs : of_singles / max(singles, 1.0);
  if (pairs + singles > 0.0) return answer;
  // At an outline one hiding neighbour is enough: the others see past the glass.
  bool outline = sideray_has_samples() && f.surface_id != SIDERAY_NO_SURFACE;
  return hiding > 0 && (hiding == asked || outline) ? SIDERAY_HIDDEN : SIDERAY_NOTHING;
}

// Returns the index of this fragment's layer at its own pixel; -1 if there is none or the pixel was not traced.
int sideray_find_layer(vec3 world_position, SIDERAY_UINT surface_id) {
  if (surface_id == SIDERAY_NO_SURFACE || sideray_layers == 0) return -1;
  SiderayFragment f = sideray_fragment(world_position, surface_id);
  // GLSL 1.20 has no max() of integers, and NVIDIA's compiler accepts none.
  int layer = sideray_find_within(f.pixel, f.distance, f.tolerance, f.older_tolerance, surface_id);
  return layer > -1 ? layer : -1;
}

// Returns what the cache holds for this fragment: SIDERAY_NOTHING, _ANSWER, _REFRACTED or _HIDDEN. Draws that are not
// traced pass surface id 0 and may be _HIDDEN. Call it in uniform control flow.
int sideray_look_up(vec3 world_position, SIDERAY_UINT surface_id, out vec3 radiance) {
  radiance = vec3(0.0);
  bool is_traced = surface_id != SIDERAY_NO_SURFACE;
  if (sideray_layers == 0 || (!is_traced && sideray_refracts == 0)) return SIDERAY_NOTHING;
  SiderayFragment f = sideray_fragment(world_position, surface_id);
  int answer = SIDERAY_NOTHING;
  if (sideray_is_traced(f.pixel))
    answer = sideray_answer(f.pixel, sideray_find_within(f.pixel, f.distance, f.tolerance, f.older_tolerance, surface_id), radiance);
  // At an outline the ray through the pixel's middle may miss a surface that covers other samples; neighbours hit it.
  if (answer == SIDERAY_NOTHING && (sideray_has_samples() || !sideray_is_traced(f.pixel)))
    answer = sideray_from_donors(f, radiance);
  return is_traced || answer == SIDERAY_HIDDEN ? answer : SIDERAY_NOTHING;
}

// Returns whether the cache has an answer for this fragment: C of dst = C*a + dst*T. For caches without refraction.
// Call it in uniform control flow.
bool sideray_find(vec3 world_position, SIDERAY_UINT surface_id, out vec3 radiance) {
  radiance = vec3(0.0);
  if (surface_id == SIDERAY_NO_SURFACE) return false;
  int answer = sideray_look_up(world_position, surface_id, radiance);
  return answer == SIDERAY_ANSWER || answer == SIDERAY_REFRACTED;
}

// Returns whether a second wave of rays should trace this fragment's pixel: it was not traced, no neighbour has a layer
// of the surface, and some neighbour could have held one, because it has unused layers or its last layer is farther
// away. Otherwise the fragment is behind the last layer that a cache of this size could hold.
bool sideray_asks(vec3 world_position, SIDERAY_UINT surface_id) {
  if (surface_id == SIDERAY_NO_SURFACE || sideray_layers == 0 || sideray_rate == 0) return false;
  SiderayFragment f = sideray_fragment(world_position, surface_id);
  if (sideray_is_traced(f.pixel)) return false;
  bool room = false;
  for (int i = 0; i < 6; ++i) {
    ivec2 off = sideray_pair(f.pixel, i / 2);
    if (off == ivec2(0)) break;
    ivec2 pixel = sideray_is_even(i) ? f.pixel - off : f.pixel + off;
    if (!sideray_is_within(pixel, sideray_cache_size)) continue;
    int donor = sideray_donor(f, pixel);
    if (donor >= 0) return false;
    if (donor == SIDERAY_HIDDEN_LAYER) continue;
    vec2 met = sideray_meet_plane(f, pixel);
    float last = SIDERAY_FETCH(sideray_distance, pixel, sideray_layers - 1, sideray_cache_size).x;
    room = room || last == 0.0 || abs(last) >= (met.x > 0.0 ? met.x : f.distance);
  }
  return room;
}

// Reasons for an answer, or for none.
#define SIDERAY_MATCHED 0          // it has one
#define SIDERAY_NOT_ASKED 1        // surface id 0, or no layers are bound yet
#define SIDERAY_BEYOND 2           // it lies behind the pixel's last layer, and all layers are used: raise max_layers
#define SIDERAY_NOT_TRACED 3       // the pixel is not in the mask, had no turn, or its ray hit no surface
#define SIDERAY_OTHER_ID 4         // a layer lies where the fragment does, but has another surface id
#define SIDERAY_OTHER_DISTANCE 5   // layers of this surface id lie elsewhere: other triangles, transform or matrices
#define SIDERAY_OTHER_SURFACE 6    // neither: rays do not hit this surface, or the scene holds another one
#define SIDERAY_BESIDE 7           // masks only: the fragment is disoccluded and uses masks of its plane nearby

int sideray_explain_miss(SiderayFragment f) {
  if (!sideray_is_within(f.pixel, sideray_cache_size)) return SIDERAY_NOT_TRACED;
  bool at_distance = false, of_id = false, full = true;
  float last = 0.0;
  for (int k = 0; k < SIDERAY_MAX_LAYERS; ++k) {
    if (k >= sideray_layers) break;
    float layer = abs(SIDERAY_FETCH(sideray_distance, f.pixel, k, sideray_cache_size).x);
    full = layer != 0.0;
    if (!full) break;
    last = layer;
    if (abs(layer - f.distance) <= f.tolerance) at_distance = true;
    if (SIDERAY_FETCH(sideray_surface_id, f.pixel, k, sideray_cache_size).x == f.surface_id) of_id = true;
  }
  if (last == 0.0) return SIDERAY_NOT_TRACED;
  if (at_distance) return SIDERAY_OTHER_ID;
  if (full && f.distance > last) return SIDERAY_BEYOND;
  return of_id ? SIDERAY_OTHER_DISTANCE : SIDERAY_OTHER_SURFACE;
}

// Returns why this fragment has its answer or none. To count a reason, draw the surfaces again in an occlusion query,
// depth tested and without colour, and discard fragments of other reasons. Call it in uniform control flow.
int sideray_explain(vec3 world_position, SIDERAY_UINT surface_id) {
  vec3 radiance;
  int answer = sideray_look_up(world_position, surface_id, radiance);
  SiderayFragment f = sideray_fragment(world_position, surface_id);
  if (answer != SIDERAY_NOTHING) return SIDERAY_MATCHED;
  if (surface_id == SIDERAY_NO_SURFACE || sideray_layers == 0) return SIDERAY_NOT_ASKED;
  return sideray_explain_miss(f);
}

// Returns `color`, or the reason's colour if there is no answer: cyan BEYOND, blue NOT_TRACED, magenta OTHER_ID, yellow
// OTHER_DISTANCE, red OTHER_SURFACE, white BESIDE.
vec3 sideray_reason_color(vec3 color, int reason) {
  if (reason <= SIDERAY_NOT_ASKED) return color;
  if (reason == SIDERAY_BEYOND) return vec3(0.0, 1.0, 1.0);
  if (reason == SIDERAY_NOT_TRACED) return vec3(0.0, 0.0, 1.0);
  if (reason == SIDERAY_OTHER_ID) return vec3(1.0, 0.0, 1.0);
  if (reason == SIDERAY_BESIDE) return vec3(1.0);
  return reason == SIDERAY_OTHER_DISTANCE ? vec3(1.0, 1.0, 0.0) : vec3(1.0, 0.0, 0.0);
}

vec3 sideray_debug_color(vec3 color, vec3 world_position, SIDERAY_UINT surface_id) {
  return sideray_reason_color(color, sideray_explain(world_position, surface_id));
}

// Returns the ray-traced colour C of dst = C*a + dst*T for this fragment, or `fallback` if there is no answer.
// surface_id is that of the scene's instance; 0 skips the search (a branch that is uniform over the draw).
vec3 sideray_translucent(vec3 fallback, vec3 world_position, SIDERAY_UINT surface_id) {
  vec3 radiance;
  bool found = sideray_find(world_position, surface_id, radiance);
#ifdef SIDERAY_DEBUG
  fallback = sideray_debug_color(fallback, world_position, surface_id);
#endif
  return found ? radiance : fallback;
}

// Returns the colour of a fragment of glass for glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA); without an answer,
// the engine's own colour, `raster`. Light that the surface bends replaces what is behind it, and fragments behind such
// a surface are discarded, even with surface id 0.
vec4 sideray_glass(vec4 raster, vec3 world_position, SIDERAY_UINT surface_id) {
  vec3 radiance;
  int answer = sideray_look_up(world_position, surface_id, radiance);
#ifdef SIDERAY_DEBUG
  raster.rgb = sideray_debug_color(raster.rgb, world_position, surface_id);
#endif
  if (answer == SIDERAY_HIDDEN) discard;
  if (answer == SIDERAY_NOTHING) return raster;
  return vec4(radiance, answer == SIDERAY_REFRACTED ? 1.0 : raster.a);
}

// The functions below do the same for hosts that show results a frame late, after the object or the camera has moved.
// `previous_world_position` is the interpolated vertex position by the object's matrix in the frame of the cache (from
// sideray_service_placement()). The layer is looked up at the pixel that showed that position in the cache's view. They
// need derivatives: call them in uniform control flow.
SiderayFragment sideray_moving_fragment(vec3 previous_world_position, SIDERAY_UINT surface_id, out bool in_picture) {
  SiderayFragment f;
  f.position = previous_world_position;
  f.normal = normalize(cross(dFdx(previous_world_position), dFdy(previous_world_position)));
  f.distance = sideray_distance_to(previous_world_position);
  f.tolerance = f.older_tolerance = 0.0;
  f.surface_id = surface_id;
  vec4 clip = sideray_clip_from_world * vec4(previous_world_position, 1.0);
  f.pixel = ivec2(floor((clip.xy / clip.w * 0.5 + 0.5) * sideray_cache_size));
  in_picture = clip.w > 0.0 && sideray_is_within(f.pixel, sideray_cache_size);
  return f;
}

bool sideray_find_moving(vec3 previous_world_position, SIDERAY_UINT surface_id, out vec3 radiance) {
  radiance = vec3(0.0);
  if (surface_id == SIDERAY_NO_SURFACE || sideray_layers == 0) return false;
  bool in_picture;
  SiderayFragment f = sideray_moving_fragment(previous_world_position, surface_id, in_picture);
  if (!in_picture) return false;
  if (!sideray_is_traced(f.pixel)) {
    int answer = sideray_from_donors(f, radiance);
    return answer == SIDERAY_ANSWER || answer == SIDERAY_REFRACTED;
  }
  int layer = sideray_donor(f, f.pixel);
  if (layer < 0) return false;
  radiance = SIDERAY_FETCH(sideray_radiance, f.pixel, layer, sideray_cache_size).rgb;
  return true;
}

// Returns why sideray_find_moving() has an answer for this fragment or none; counted as by sideray_explain().
int sideray_explain_moving(vec3 previous_world_position, SIDERAY_UINT surface_id) {
  vec3 radiance;
  if (surface_id == SIDERAY_NO_SURFACE || sideray_layers == 0) return SIDERAY_NOT_ASKED;
  if (sideray_find_moving(previous_world_position, surface_id, radiance)) return SIDERAY_MATCHED;
  bool in_picture;
  SiderayFragment f = sideray_moving_fragment(previous_world_position, surface_id, in_picture);
  if (!in_picture) return SIDERAY_NOT_TRACED;
  // Uses the distance at which that pixel's ray meets the plane.
  vec2 met = sideray_meet_plane(f, f.pixel);
  f.distance = met.x;
  f.tolerance = met.y;
  return sideray_explain_miss(f);
}

vec3 sideray_translucent_moving(vec3 fallback, vec3 world_position, SIDERAY_UINT surface_id,
                                vec3 previous_world_position) {
  vec3 radiance;
  bool found = sideray_find_moving(previous_world_position, surface_id, radiance);
#ifdef SIDERAY_DEBUG
  fallback = sideray_reason_color(fallback, sideray_explain_moving(previous_world_position, surface_id));
#endif
  return found ? radiance : fallback;
}

uniform sampler2D sideray_whole_radiance;
uniform sampler2D sideray_whole_transmittance;  // alpha 1: the pixel is whole
uniform int sideray_has_whole;

// Returns whether this fragment's pixel is whole: all its translucent surfaces were composited along its ray, in exact
// order (sideray_layer_inputs::whole_pixels). One full-screen pass draws such pixels with sideray_whole(). Other
// translucent fragments must not be drawn there: reject them by the stencil that this pass wrote, or discard them.
bool sideray_is_whole() {
  if (sideray_has_whole == 0) return false;
  ivec2 pixel = sideray_pixel();
  if (!sideray_is_within(pixel, sideray_cache_size)) return false;
  return SIDERAY_FETCH_2D(sideray_whole_transmittance, pixel, sideray_cache_size).w > 0.5;
}

// Returns the colour of a whole pixel in two parts: added + picture * through.
void sideray_whole(out vec3 added, out vec3 through) {
  ivec2 pixel = sideray_pixel();
  added = SIDERAY_FETCH_2D(sideray_whole_radiance, pixel, sideray_cache_size).rgb;
  through = SIDERAY_FETCH_2D(sideray_whole_transmittance, pixel, sideray_cache_size).rgb;
}

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

uniform sampler2D sideray_irradiance_texels;  // alpha 0: not traced
uniform vec2 sideray_irradiance_size;         // pixels
uniform vec2 sideray_irradiance_corner;       // framebuffer coordinates of the first pixel
uniform int sideray_has_irradiance;

// Returns the light that other surfaces reflect onto the opaque surface at this fragment's pixel: irradiance over pi.
// Add it to the sky's ambient light times sideray_ao(), and multiply the sum by the diffuse albedo; it is black where
// there is no answer. Channels may be negative, because the sky's mask, which has one channel, makes some of them too
// bright; the sum is not negative.
vec3 sideray_irradiance() {
  ivec2 pixel = ivec2(floor(gl_FragCoord.xy - sideray_irradiance_corner));
  if (sideray_has_irradiance == 0 || !sideray_is_within(pixel, sideray_irradiance_size)) return vec3(0.0);
  return SIDERAY_FETCH_2D(sideray_irradiance_texels, pixel, sideray_irradiance_size).rgb;
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
#endif
