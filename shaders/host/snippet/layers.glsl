// Finds a fragment's layer at its own pixel, or at its neighbours if its own was not traced.

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
