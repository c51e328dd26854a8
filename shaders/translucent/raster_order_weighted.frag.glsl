// The sums of weighted blending over the lit picture: the mean of what was summed, as far as it hides what is behind.
layout(location = 0, index = 0) out vec4 o_added;
layout(location = 0, index = 1) out vec4 o_through;

uniform sampler2D weighted_sum;
uniform sampler2D weighted_through;
uniform sampler2D weighted_glow;

// The mean transmittance in front of something that lies anywhere in a body of this transmittance: the integral of
// through^s over s in 0..1.
float mean_visibility(float through) {
  return through > 0.999 ? 0.5 + 0.5 * through : (1.0 - through) / -log(max(through, 1e-6));
}

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec4 sum = texelFetch(weighted_sum, pixel, 0), through = texelFetch(weighted_through, pixel, 0);
  float cover = 1.0 - through.w;
  vec3 added = sum.w > 0.0 ? sum.xyz * (cover / sum.w) : vec3(0.0);
  vec3 visibility = vec3(mean_visibility(through.x), mean_visibility(through.y), mean_visibility(through.z));
  o_added = vec4(added + texelFetch(weighted_glow, pixel, 0).xyz * visibility, cover);
  o_through = through;
}
