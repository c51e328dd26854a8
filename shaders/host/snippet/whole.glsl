// Pixels whose translucent surfaces were all composited along the ray.

uniform sampler2D sideray_whole_radiance;
uniform sampler2D sideray_whole_transmittance;  // alpha 1: the pixel is whole
uniform int sideray_has_whole;

// Returns whether this fragment's pixel is whole: all its translucent surfaces were composited along its ray, in exact
// order (sideray_layer_inputs::whole_pixels). One full-screen pass draws such pixels with sideray_whole(). Other
// translucent fragments must not be drawn there: reject them by the stencil that this pass wrote, or discard them.
bool sideray_is_whole() {
  if (sideray_has_whole == 0) return false;
  ivec2 pixel = sideray_pixel();
  if (!sideray_is_within(pixel, sideray_cache_size)) return false;
  return SIDERAY_FETCH_2D(sideray_whole_transmittance, pixel, sideray_cache_size).w > 0.5;
}

// Returns the colour of a whole pixel in two parts: added + picture * through.
void sideray_whole(out vec3 added, out vec3 through) {
  ivec2 pixel = sideray_pixel();
  added = SIDERAY_FETCH_2D(sideray_whole_radiance, pixel, sideray_cache_size).rgb;
  through = SIDERAY_FETCH_2D(sideray_whole_transmittance, pixel, sideray_cache_size).rgb;
}
