// Draws only coverage: mask, shadow maps, fragment counts and the second wave's mask. Defines: SR_ALPHA (discards
// absent fragments), SR_LOCATED with SR_COUNTED (keeps fragments that look up the layer cache and 1 find an answer, 2
// find none, 3 find another surface's at their own pixel, 4 request a second wave), SR_REST (writes where rays hit the
// surface), SR_MOTION (writes motion vectors).
#ifdef SR_LOCATED
in vec3 v_position;
uniform uint traced_surface_id;
#endif

#ifdef SR_REST
in vec4 v_rest;
layout(location = 0) out vec4 o_rest;
#endif

#ifdef SR_MOTION
in vec3 v_now;
in vec3 v_before;
layout(location = 0) out vec2 o_motion;
#endif

void main() {
#ifdef SR_MOTION
  o_motion = motion_between(v_now.xy / v_now.z, v_before);
#endif
#ifdef SR_REST
  o_rest = v_rest;
#endif
#ifdef SR_LOCATED
#if SR_COUNTED == 4
  bool counted = sideray_asks(v_position, traced_surface_id);
#elif SR_COUNTED == 3
  int layer = sideray_find_layer(v_position, traced_surface_id);
  bool counted = layer >= 0 && is_misassigned(layer, v_position, traced_surface_id);
#else
  vec3 radiance;
  int answer = sideray_look_up(v_position, traced_surface_id, radiance);
  bool counted = SR_COUNTED == 1 ? answer == SIDERAY_ANSWER || answer == SIDERAY_REFRACTED : answer == SIDERAY_NOTHING;
#endif
#endif
#ifdef SR_ALPHA
  if (is_absent(base_color_texel())) discard;
#endif
#ifdef SR_LOCATED
  if (!counted) discard;
#endif
}
