// Why a fragment has its answer or none, as a number and as a colour.

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
