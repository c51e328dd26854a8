// The light that other surfaces throw on opaque ones.

uniform sampler2D sideray_irradiance_texels;  // alpha 0: not traced
uniform vec2 sideray_irradiance_size;         // pixels
uniform vec2 sideray_irradiance_corner;       // the first one in the framebuffer
uniform int sideray_has_irradiance;

// The light that other surfaces throw on the opaque surface at this fragment's pixel: irradiance over pi, to be added to the
// ambient light of the sky times sideray_ao(), and multiplied by the matt albedo with it; black where there is no answer. A
// channel may be negative, since it makes up for what the mask of the sky, which has one channel, says too bright: the sum is
// not.
vec3 sideray_irradiance() {
  ivec2 pixel = ivec2(floor(gl_FragCoord.xy - sideray_irradiance_corner));
  if (sideray_has_irradiance == 0 || !sideray_is_within(pixel, sideray_irradiance_size)) return vec3(0.0);
  return SIDERAY_FETCH_2D(sideray_irradiance_texels, pixel, sideray_irradiance_size).rgb;
}
