// Motion of a pixel in pixels, x to the right and y up: where a surface is minus where it was in the frame before.
uniform vec2 half_size;  // of the picture

// From places in -1..1 now, and in clip space (x y w) before. What was not before the eye comes from far outside.
vec2 motion_between(vec2 now, vec3 before) {
  return before.z > 1e-6 ? (now - before.xy / before.z) * half_size : 8.0 * half_size;
}
