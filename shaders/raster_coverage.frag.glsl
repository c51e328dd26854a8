// Coverage alone: mask, shadow maps and fragment counts. Defines: SR_ALPHA (leave absent fragments out), SR_LOCATED with
// SR_COUNTED (of fragments that look the layer cache up, those that found a layer 1, found none 2, found another
// surface's 3).
#ifdef SR_LOCATED
in vec3 v_position;
uniform uint traced_surface_id;
#endif

void main() {
#ifdef SR_LOCATED
  int layer = -1;
  if (traced_surface_id != 0u && sideray_layers != 0) layer = sideray_find_layer(v_position, traced_surface_id);
#endif
#ifdef SR_ALPHA
  if (is_absent(base_color_texel())) discard;
#endif
#ifdef SR_LOCATED
  if ((layer >= 0) != (SR_COUNTED != 2)) discard;
#if SR_COUNTED == 3
  if (!is_misassigned(layer, v_position, traced_surface_id)) discard;
#endif
#endif
}
