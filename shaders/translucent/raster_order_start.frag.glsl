// Writes the first key for peeling from the back: the opaque surface's depth.
layout(location = 0) out uvec2 o_key;

uniform sampler2D gbuffer_depth;
uniform uint depth_flip;

void main() {
  o_key = uvec2(floatBitsToUint(texelFetch(gbuffer_depth, ivec2(gl_FragCoord.xy), 0).x) ^ depth_flip, 0u);
}
