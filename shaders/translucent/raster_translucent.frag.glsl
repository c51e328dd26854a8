// Shades a translucent surface, from the layer cache where it has an answer; raster_order.glsl writes it. SR_ASIDE: the
// surface bends or blurs light, and samples the opaque picture where the cache has no answer. SR_LIVE:
// gl_HelperInvocation is available (GLSL 4.50).
in vec3 v_position;
uniform uint traced_surface_id;  // 0 = not ray traced

// Returns the normal of the triangle's plane on the eye's side. Differences of positions are off by their rounding,
// 6e-8 of the coordinates over a pixel's width of the surface; without a direction the plane lifts nothing.
vec3 geometric_normal(vec3 plane, vec3 to_eye) {
  float size = length(plane);
  return size > 0.0 ? plane * ((dot(plane, to_eye) < 0.0 ? -1.0 : 1.0) / size) : to_eye;
}

void main() {
  // Evaluates all implicit derivatives before anything is discarded or skipped.
  vec4 base_color = base_color_texel();
  SrMaterial m = surface_material();
  SrTexels texels = surface_texels(base_color);
  vec3 normal = surface_normal(), coat_normal = surface_coat_normal();
  vec3 plane = cross(dFdx(v_position), dFdy(v_position));
  vec3 cached;
  int answer = sideray_look_up(v_position, traced_surface_id, cached);
  if (is_absent(base_color) || is_left_out() || answer == SIDERAY_HIDDEN) discard;

#if SR_ORDER == 3
  emit_translucent(vec3(0.0), vec3(1.0));  // only the key matters
#else
  vec3 to_eye = direction_to_eye(v_position);
  SrSurface base = sr_surface(m, texels, normal, coat_normal);
#if (SR_LOBES & 16) != 0
  base = brushed_surface(sr_facing(base, to_eye), m, texels);
#endif
#if (SR_LOBES & 8) != 0
  base = sr_filmed(sr_facing(base, to_eye), m, texels, to_eye);
#endif
  SrSurface s = seen(base, to_eye);
  SrBlend blend = sr_blend(s, to_eye, material.unlit_blend_alpha_mode_maps.y);
  vec3 radiance = cached;
  bool is_lit = answer == SIDERAY_NOTHING;
  if (answer == SIDERAY_REFRACTED) {
    blend.cover = 1.0;
    blend.through = vec3(0.0);
  }
#ifdef SR_LIVE
  // The loop over lights runs as long as one fragment of a SIMD vector needs it; helper invocations, beside an edge or
  // rejected by the stencil, must not.
  is_lit = is_lit && !gl_HelperInvocation;
#endif
  if (is_lit) radiance = radiance_from(s, geometric_normal(plane, to_eye), v_position, to_eye);
  vec3 added = radiance * blend.cover;
#ifdef SR_ASIDE
  // Light is bent once, where it enters a solid.
  if (is_lit && (v_solid == 0u || gl_FrontFacing))
    added += max(blend.through - vec3(1.0 - s.alpha), vec3(0.0)) * seen_aside(m, texels, s, v_position, to_eye,
                                                                                     material.occlusion_alpha_cutoff_spread.z);
#endif
  emit_translucent(added, blend.through);
#endif
}
