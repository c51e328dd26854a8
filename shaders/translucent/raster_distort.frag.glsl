// Writes how far surfaces shift the picture behind them, summed up by blending: xy in picture heights, x to the right
// and y up; w, by maximum: nearness of the nearest one, 0 = none.
layout(location = 0) out vec4 o_offset_nearness;

uniform vec3 view_right, view_up;  // unit
uniform float distortion;
uniform bool reversed_depth;

void main() {
  vec4 base_color = base_color_texel();
  vec3 normal = surface_normal();
  if (is_absent(base_color)) discard;
  float nearness = reversed_depth ? gl_FragCoord.z : 1.0 - gl_FragCoord.z;
  o_offset_nearness = vec4(distortion * vec2(dot(normal, view_right), dot(normal, view_up)), 0.0, nearness);
}
