// Draws ray-ordered translucency over the lit picture; blending as in raster_translucent.frag.glsl. SR_WHOLE: only
// pixels whose transmittance has an alpha of 1.
layout(location = 0, index = 0) out vec4 o_added;
layout(location = 0, index = 1) out vec4 o_through;

uniform sampler2D traced_radiance;
uniform sampler2D traced_transmittance;

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec4 traced = texelFetch(traced_transmittance, pixel, 0);
#ifdef SR_WHOLE
  if (traced.w == 0.0) discard;
#endif
  vec3 transmittance = traced.xyz;
  float through = (transmittance.x + transmittance.y + transmittance.z) * (1.0 / 3.0);
  // Its alpha excludes what refracted rays see of the surroundings.
  vec4 radiance = texelFetch(traced_radiance, pixel, 0);
  o_added = vec4(radiance.xyz, radiance.w - through);
  o_through = vec4(transmittance, through);
}
