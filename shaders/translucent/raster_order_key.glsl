// Computes the place of a fragment in its pixel's order: depth, then the primitive's number, which is unique in the
// pass. Smaller = nearer to the eye. SR_SPRITES: an instance is one primitive.
uniform uint depth_flip;    // all bits set where depth is reversed
uniform uint first_number;  // of the drawn item; 1 or more

#ifdef SR_SPRITES
flat in uint v_instance;
#endif

uvec2 fragment_key() {
#ifdef SR_SPRITES
  uint primitive = v_instance;
#else
  uint primitive = uint(gl_PrimitiveID);
#endif
  return uvec2(floatBitsToUint(gl_FragCoord.z) ^ depth_flip, first_number + primitive);
}

bool is_nearer(uvec2 a, uvec2 b) {
  return a.x < b.x || (a.x == b.x && a.y < b.y);
}
