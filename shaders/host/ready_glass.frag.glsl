// Follows the snippet. For glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA).
uniform sampler2D sideray_texture;  // on unit 0, modulated
uniform int sideray_textured;       // 0 = none
uniform float sideray_surface;      // the surface id; 0 = drawn as by the fixed function
varying vec3 sideray_position;

void main() {
  vec4 color = gl_Color;
  if (sideray_textured != 0) color *= texture2D(sideray_texture, gl_TexCoord[0].xy);
  gl_FragColor = sideray_glass(color, sideray_position, sideray_surface);
}
