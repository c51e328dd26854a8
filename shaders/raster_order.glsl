// Where translucent fragments go: dst = added + dst * through in every blend mode. SR_ORDER: 0 blended into the picture
// as they come, by dual-source blending (ONE, SRC1_COLOR; alpha ONE, SRC1_ALPHA).
#if SR_ORDER == 0
layout(location = 0, index = 0) out vec4 o_added;
layout(location = 0, index = 1) out vec4 o_through;

void emit_translucent(vec3 added, vec3 through) {
  float mean = (through.x + through.y + through.z) * (1.0 / 3.0);
  o_added = vec4(added, 1.0 - mean);
  o_through = vec4(through, mean);
}
#endif
