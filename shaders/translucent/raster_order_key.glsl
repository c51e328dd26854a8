// The place of a fragment among those of its pixel: depth, then a number that every primitive of the pass has for
// itself. Smaller = nearer to the eye. SR_SPRITES: an instance is one primitive.
uniform uint depth_flip;    // all bits where depth is reversed
uniform uint first_number;  // of the item that is drawn; 1 or more

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
