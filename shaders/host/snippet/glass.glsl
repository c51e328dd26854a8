// What a shader of glass calls.

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

// Returns what a fragment of glass shows, for glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA): `raster`, the engine's own
// colour, where there is no answer. Light that the surface bends replaces what is behind it, and what lies behind such a
// surface is discarded, also with surface id 0.
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
