// The functions that shaders of glass call.

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
