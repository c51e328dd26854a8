// Shades a sprite's texel, which fades in front of opaque surfaces; raster_order.glsl writes it. Defines: SR_SOFT
// (fades), SR_REFRACTED (surfaces that bend light hide what is behind them).
in vec2 v_corner;
flat in vec4 v_color;  // radiance that texels scale
flat in vec2 v_cell;
flat in float v_level;
flat in float v_depth;
#ifdef SR_REFRACTED
in vec3 v_position;
#endif

uniform sampler2D sprite_map;
uniform ivec2 flip_book;
uniform vec2 cell_texels;
uniform int blend_mode;

#ifdef SR_SOFT
uniform sampler2D opaque_depth;
uniform float soft_distance;
uniform vec2 along_from_depth;  // as in raster_light.frag.glsl
uniform bool orthographic;

float gap_behind() {
  float along = texelFetch(opaque_depth, ivec2(gl_FragCoord.xy), 0).x * along_from_depth.x + along_from_depth.y;
  if (!orthographic) along = 1.0 / max(along, 1e-30);
  return along - v_depth;
}
#endif

void main() {
  vec4 color = v_color * textureLod(sprite_map, sr_sprite_place(v_corner, v_cell, flip_book, cell_texels, v_level),
                                    v_level);
  bool is_hidden = false;
#ifdef SR_REFRACTED
  vec3 none;
  is_hidden = sideray_look_up(v_position, 0u, none) == SIDERAY_HIDDEN;
#endif
  if (sr_sprite_absent(color.w, blend_mode) || is_left_out() || is_hidden) discard;
#ifdef SR_SOFT
  float fade = sr_soft_fade(gap_behind(), soft_distance);
#else
  float fade = 1.0;
#endif
  SrSurface s = sr_sprite(color, vec3(0.0), false, fade, blend_mode);
  SrBlend blend = sr_blend(s, vec3(0.0), blend_mode);
  emit_translucent(s.emissive * blend.cover, blend.through);
}
