// Writes translucent fragments: dst = added + dst * through in every blend mode; alpha is a fourth channel, whose
// transmittance is the mean of the others. SR_ORDER is one of FragmentOrder; all but 0 need raster_order_key.glsl.

// SR_ORDER 0: blends into the picture in drawing order, dual-source (ONE, SRC1_COLOR; alpha ONE, SRC1_ALPHA).
// SR_ORDER 1: the same, but in each pixel only the fragment that `order_keys` names.
#if SR_ORDER == 0 || SR_ORDER == 1
layout(location = 0, index = 0) out vec4 o_added;
layout(location = 0, index = 1) out vec4 o_through;

void emit_translucent(vec3 added, vec3 through) {
  float mean = (through.x + through.y + through.z) * (1.0 / 3.0);
  o_added = vec4(added, 1.0 - mean);
  o_through = vec4(through, mean);
}
#endif

// SR_ORDER 2: adds to the lists of raster_order_lists.glsl.
#if SR_ORDER == 2
// Hidden fragments must be rejected before, since lists would hold them.
layout(early_fragment_tests) in;

void emit_translucent(vec3 added, vec3 through) {
  add_to_list(ivec2(gl_FragCoord.xy), fragment_key(), added, through);
}
#endif

// SR_ORDER 3: does a step of depth peeling from the back, which writes only keys.
#if SR_ORDER == 3
layout(location = 0) out uvec2 o_key;

void emit_translucent(vec3 added, vec3 through) {
  o_key = fragment_key();
}
#endif

// Returns whether a fragment has no part in this pass.
#if SR_ORDER == 0 || SR_ORDER == 2
bool is_left_out() {
  return false;
}
#else
uniform usampler2D order_keys;  // when peeling: keys of the previous step

bool is_left_out() {
  uvec2 named = texelFetch(order_keys, ivec2(gl_FragCoord.xy), 0).xy, key = fragment_key();
#if SR_ORDER == 1
  return key != named;
#else
  return !is_nearer(key, named);
#endif
}
#endif
