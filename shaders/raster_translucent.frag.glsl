// The colour of a translucent surface, from the layer cache where it has an answer; raster_order.glsl takes it.
in vec3 v_position;
uniform uint traced_surface_id;  // 0 = not ray traced

void main() {
  // All implicit derivatives come before anything is discarded or skipped.
  vec4 base_color = base_color_texel();
  SrMaterial m = surface_material();
  SrTexels texels = surface_texels(base_color);
  vec3 normal = surface_normal(), coat_normal = surface_coat_normal();
  int layer = -1;
  if (traced_surface_id != 0u && sideray_layers != 0) layer = sideray_find_layer(v_position, traced_surface_id);
  if (is_absent(base_color) || is_left_out()) discard;

#if SR_ORDER >= 5
  emit_translucent(vec3(0.0), vec3(1.0));  // its place is all that is asked for
#else
  vec3 to_eye = direction_to_eye(v_position);
  SrSurface s = seen(sr_surface(m, texels, normal, coat_normal), to_eye);
  SrBlend blend = sr_blend(s, to_eye, material.unlit_blend_alpha_mode_maps.y);
  vec3 radiance;
  if (layer >= 0) {
    ivec2 pixel = ivec2((gl_FragCoord.xy - sideray_viewport.xy) * sideray_viewport.zw);
    radiance = texelFetch(sideray_radiance, ivec3(pixel, layer), 0).xyz;
  } else {
    radiance = radiance_from(s, v_position, to_eye);
  }
  emit_translucent(radiance * blend.cover, blend.through);
#endif
}
