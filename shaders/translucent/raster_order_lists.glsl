// Lists of fragments, one for each pixel. A node is 9 words: key, radiance, transmittance, index + 1 of the next node.
layout(std430, binding = 0) buffer Heads {
  uint used;     // nodes requested
  uint heads[];  // index + 1 of a pixel's first node, 0 = none
};
layout(std430, binding = 1) buffer Nodes {
  uint words[];
};
uniform uint node_capacity;
uniform int list_row;  // width of the picture

const uint node_words = 9u, next_word = 8u;

uint head_index(ivec2 pixel) {
  return uint(pixel.y * list_row + pixel.x);
}

// Adds a node; where there is no room it is only counted.
void add_to_list(ivec2 pixel, uvec2 key, vec3 added, vec3 through) {
  uint node = atomicAdd(used, 1u);
  if (node >= node_capacity) return;
  uint word = node * node_words;
  words[word] = key.x;
  words[word + 1u] = key.y;
  for (int c = 0; c < 3; ++c) {
    words[word + 2u + uint(c)] = floatBitsToUint(added[c]);
    words[word + 5u + uint(c)] = floatBitsToUint(through[c]);
  }
  words[word + next_word] = atomicExchange(heads[head_index(pixel)], node + 1u);
}
