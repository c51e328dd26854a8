// Coverage alone: mask, shadow maps and fragment counts. Defines: SR_ALPHA (leave absent fragments out), SR_LOCATED
// (count_matched selects the fragments that found a layer, or those that did not).
#ifdef SR_LOCATED
in vec3 v_position;
uniform uint traced_surface_id;
uniform bool count_matched;
#endif

void main() {
#ifdef SR_LOCATED
  bool matched = traced_surface_id != 0u && sideray_layers != 0 &&
                 sideray_find_layer(v_position, traced_surface_id) >= 0;
#endif
#ifdef SR_ALPHA
  if (is_absent(base_color_texel())) discard;
#endif
#ifdef SR_LOCATED
  if (matched != count_matched) discard;
#endif
}
