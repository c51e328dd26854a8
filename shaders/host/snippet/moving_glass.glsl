// Glass whose layers are those of an earlier frame.

// The functions below are for hosts that show results a frame late, after the object or the camera has moved.
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
