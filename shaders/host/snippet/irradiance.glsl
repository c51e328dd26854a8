// Light that other surfaces reflect onto opaque ones.

uniform sampler2D sideray_irradiance_texels;  // alpha 0: not traced
uniform vec2 sideray_irradiance_size;         // pixels
uniform vec2 sideray_irradiance_corner;       // framebuffer coordinates of the first pixel
uniform int sideray_has_irradiance;

// Returns the light that other surfaces reflect onto the opaque surface at this fragment's pixel: irradiance over pi.
// Add it to the sky's ambient light times sideray_ao(), and multiply the sum by the diffuse albedo; it is black where
// there is no answer. Channels may be negative, because the sky's mask, which has one channel, makes some of them too
// bright; the sum is not negative.
vec3 sideray_irradiance() {
  ivec2 pixel = ivec2(floor(gl_FragCoord.xy - sideray_irradiance_corner));
  if (sideray_has_irradiance == 0 || !sideray_is_within(pixel, sideray_irradiance_size)) return vec3(0.0);
  return SIDERAY_FETCH_2D(sideray_irradiance_texels, pixel, sideray_irradiance_size).rgb;
}
