// Tests whether a fragment took another surface's layer, by all surfaces along its ray (gl/passes/layer_truth.h).
uniform usampler2D true_first;     // index of each pixel's first surface, row by row from the bottom
uniform usampler2D true_surfaces;  // x = bits of the distance, y = surface id
uniform int true_columns;          // width of the picture

uvec2 listed(usampler2D list, uint i) {
  uint width = uint(textureSize(list, 0).x);
  return texelFetch(list, ivec2(i % width, i / width), 0).xy;
}

// Returns whether the layer has another id, or is not that of the surface of this id nearest to the fragment. A layer
// belongs to the true surface whose distance is nearest to its own.
bool is_misassigned(int layer, vec3 position, uint surface_id) {
  ivec2 pixel = ivec2((gl_FragCoord.xy - sideray_viewport.xy) * sideray_viewport.zw);
  if (texelFetch(sideray_surface_id, ivec3(pixel, layer), 0).x != surface_id) return true;
  float d = sideray_distance_to(position);
  float d_layer = abs(texelFetch(sideray_distance, ivec3(pixel, layer), 0).x);
  float to_layer = 3e38, to_fragment = 3e38, taken = d_layer;
  uint at = uint(pixel.y) * uint(true_columns) + uint(pixel.x);
  uint end = listed(true_first, at + 1u).x;
  for (uint i = listed(true_first, at).x; i < end; ++i) {
    uvec2 surface = listed(true_surfaces, i);
    if (surface.y != surface_id) continue;
    float d_true = uintBitsToFloat(surface.x);
    to_fragment = min(to_fragment, abs(d_true - d));
    if (abs(d_true - d_layer) < to_layer) {
      to_layer = abs(d_true - d_layer);
      taken = d_true;
    }
  }
  return to_fragment < abs(taken - d);
}
