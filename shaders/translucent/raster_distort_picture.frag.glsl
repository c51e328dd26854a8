// Distorts the opaque picture: reads a copy of it at the offset, bilinear, up to its border. Texels in front of the
// nearest distorting surface do not count, as they are not seen through it; if none is left, the colour stays.
// rt/layers/distortion.cpp does the same on the CPU.
layout(location = 0) out vec4 o_color;

uniform sampler2D distortion_offsets;
uniform sampler2D opaque_picture;
uniform sampler2D gbuffer_depth;
uniform bool reversed_depth;

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec4 offset = texelFetch(distortion_offsets, pixel, 0);
  // Offsets of a million picture heights come from normals that are NaN or infinite.
  if (offset.w == 0.0 || !(dot(offset.xy, offset.xy) < 1e12)) discard;
  ivec2 last = textureSize(opaque_picture, 0) - 1;
  vec2 at = clamp(vec2(pixel) + offset.xy * float(last.y + 1), vec2(0.0), vec2(last));
  ivec2 corner = ivec2(at);
  vec2 share = at - vec2(corner);
  vec4 sum = vec4(0.0);
  float total = 0.0;
  for (int tap = 0; tap < 4; ++tap) {
    ivec2 side = ivec2(tap & 1, tap >> 1);
    ivec2 texel = min(corner + side, last);
    float depth = texelFetch(gbuffer_depth, texel, 0).x;
    if ((reversed_depth ? depth : 1.0 - depth) > offset.w) continue;
    float weight = (side.x == 1 ? share.x : 1.0 - share.x) * (side.y == 1 ? share.y : 1.0 - share.y);
    sum += weight * texelFetch(opaque_picture, texel, 0);
    total += weight;
  }
  if (total == 0.0) discard;
  o_color = sum / total;
}
