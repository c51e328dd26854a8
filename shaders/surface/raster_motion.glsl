// Computes motion vectors in pixels, x to the right and y up: a surface's position minus that in the frame before.
uniform vec2 half_size;  // of the picture

// Takes positions in -1..1 now, and in clip space (x y w) before. Points behind the previous eye come from far outside.
vec2 motion_between(vec2 now, vec3 before) {
  return before.z > 1e-6 ? (now - before.xy / before.z) * half_size : 8.0 * half_size;
}
