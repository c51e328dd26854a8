// Writes motion vectors by the view alone: for still surfaces, and for the sky, which is infinitely far away.
layout(location = 0) out vec2 o_motion;

uniform sampler2D gbuffer_depth;
uniform mat4 before_minus_now, sky_before_minus_now;  // in clip space without jitter; their argument has jitter
uniform vec2 jitter;                                  // in -1..1
uniform vec2 pixel_size;                              // in -1..1
uniform vec2 half_size;
uniform float depth_of_nothing;
uniform vec2 clip_z_from_depth;  // factor, offset

void main() {
  vec2 place = gl_FragCoord.xy * pixel_size - 1.0;
  float depth = texelFetch(gbuffer_depth, ivec2(gl_FragCoord.xy), 0).x;
  vec4 clip = vec4(place, depth * clip_z_from_depth.x + clip_z_from_depth.y, 1.0);
  // Uses differences, so that a small motion keeps its digits: w is 1 now, and was 1 + change.w before.
  vec4 change = (depth == depth_of_nothing ? sky_before_minus_now : before_minus_now) * clip;
  float before = 1.0 + change.w;
  o_motion = before > 1e-6 ? ((place - jitter) * change.w - change.xy) / before * half_size : 8.0 * half_size;
}
