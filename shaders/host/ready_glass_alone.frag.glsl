// Follows the snippet, without a vertex shader: the fixed function transforms and lights vertices, and its texture
// coordinates of unit 7 are world positions. For glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA).
uniform sampler2D sideray_texture;  // on unit 0
uniform int sideray_textured;       // 0 = none
uniform int sideray_environment;    // its mode: a sideray_texture_environment
uniform float sideray_surface;      // the surface id; 0 = drawn as by the fixed function

vec4 sideray_textured_color(vec4 color, vec4 texel) {
  if (sideray_environment == 1) return vec4(mix(color.rgb, texel.rgb, texel.a), color.a);
  if (sideray_environment == 2) return texel;
  if (sideray_environment == 3) return vec4(color.rgb + texel.rgb, color.a * texel.a);
  return color * texel;
}

void main() {
  vec4 color = gl_Color;
  if (sideray_textured != 0) color = sideray_textured_color(color, texture2D(sideray_texture, gl_TexCoord[0].xy));
  color.rgb = clamp(color.rgb + gl_SecondaryColor.rgb, 0.0, 1.0);
  gl_FragColor = sideray_glass(color, gl_TexCoord[7].xyz, sideray_surface);
}
