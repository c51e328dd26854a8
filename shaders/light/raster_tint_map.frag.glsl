// Writes the optical depth that a translucent surface adds to a light's rays, summed up by blending; w, by minimum: its
// distance from the light. A solid absorbs between front and back: one subtracts its distance, the other adds it.
layout(location = 0) out vec4 o_depth_away;

uniform vec4 light_place;      // w = 0: the direction to the light
uniform float light_radius;
uniform float middle_away;  // distance of the instance's centre, which others are relative to: halfs hold little
uniform bool reversed_depth;
in vec3 v_position;

// Returns the share of a light's rays that pass a surface before they end at the light's sphere. Inside, it is that of
// a cylinder around the light: less than a plane's, more than that of a sphere, which no ray reaches.
float passing_share(float distance) {
  float inside = distance / max(light_radius, 1e-30);
  if (inside >= 1.0) return 1.0;
  float missed = sqrt(1.0 - inside * inside);  // nearer to the middle, rays end before the cylinder
  return 1.0 - 0.63662 * (asin(missed) + missed * inside);
}

void main() {
  vec4 base_color = base_color_texel();
  vec3 normal = surface_normal(), coat_normal = surface_coat_normal();
  if (is_absent(base_color)) discard;
  vec3 offset = light_place.xyz - v_position * light_place.w;
  float distance = length(offset);
  vec3 to_light = offset / distance;
  SrMaterial m = surface_material();
  SrTexels t = surface_texels(base_color);
  bool solid = v_solid != 0u;
  if (solid) t.thickness = 0.0;
  SrSurface s = seen(sr_surface(m, t, normal, coat_normal), to_light);
  vec3 through = sr_blend(s, to_light, material.unlit_blend_alpha_mode_maps.y).through;
  vec3 depth = optical_depth(mix(vec3(1.0), through, passing_share(distance)));
  if (solid) {
    float away = light_place.w > 0.5 ? distance : -dot(v_position, light_place.xyz);
    depth += m.absorption * (gl_FrontFacing ? middle_away - away : away - middle_away);
  }
  float window = reversed_depth ? 1.0 - gl_FragCoord.z : gl_FragCoord.z;
  o_depth_away = vec4(depth, light_place.w > 0.5 ? 1.0 / gl_FragCoord.w : window);
}
