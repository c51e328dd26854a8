// The colour of a translucent surface, from the layer cache where it has an answer; raster_order.glsl takes it.
in vec3 v_position;
uniform uint traced_surface_id;  // 0 = not ray traced

void main() {
  // All implicit derivatives come before anything is discarded or skipped.
  vec4 base_color = base_color_texel();
  SrMaterial m = surface_material();
  SrTexels texels = surface_texels(base_color);
  vec3 normal = surface_normal(), coat_normal = surface_coat_normal();
  vec3 cached;
  bool is_cached = sideray_find(v_position, traced_surface_id, cached);
  if (is_absent(base_color) || is_left_out()) discard;

#if SR_ORDER >= 5
  emit_translucent(vec3(0.0), vec3(1.0));  // its place is all that is asked for
#else
  vec3 to_eye = direction_to_eye(v_position);
  SrSurface s = seen(sr_surface(m, texels, normal, coat_normal), to_eye);
  SrBlend blend = sr_blend(s, to_eye, material.unlit_blend_alpha_mode_maps.y);
  vec3 radiance = cached;
  if (!is_cached) radiance = radiance_from(s, v_position, to_eye);
  emit_translucent(radiance * blend.cover, blend.through);
#endif
}
