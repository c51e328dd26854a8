// Packs depth and stencil of a DEPTH24_STENCIL8 texture, one word per pixel as in GL_UNSIGNED_INT_24_8, row by row
// without gaps.
layout(local_size_x = 16, local_size_y = 16) in;

layout(binding = 0) uniform sampler2D depth_texels;
layout(binding = 1) uniform usampler2D stencil_texels;
layout(std430, binding = 0) writeonly buffer Packed {
  uint words[];
};
uniform uvec2 size;

// Texels are n / (2^24 - 1), rounded to floats. This product, rounded too, gives n again for all 2^24 values once it is
// rounded to an integer; adding 0.5 instead would round twice from 2^23 on, where floats are integers.
uint integer_of(float depth) {
  return uint(roundEven(depth * 16777215.0));
}

void main() {
  uvec2 pixel = gl_GlobalInvocationID.xy;
  if (any(greaterThanEqual(pixel, size))) return;
  float depth = texelFetch(depth_texels, ivec2(pixel), 0).r;
  uint stencil = texelFetch(stencil_texels, ivec2(pixel), 0).r;
  words[pixel.y * size.x + pixel.x] = integer_of(depth) << 8u | stencil;
}
