// Sorts the lists of raster_order_lists.glsl and composites them over the lit picture.
layout(location = 0, index = 0) out vec4 o_added;
layout(location = 0, index = 1) out vec4 o_through;

uvec2 key_of(uint node) {
  return uvec2(words[node * node_words], words[node * node_words + 1u]);
}
bool is_nearer(uvec2 a, uvec2 b) {
  return a.x < b.x || (a.x == b.x && a.y < b.y);
}
vec3 color_at(uint word) {
  return vec3(uintBitsToFloat(words[word]), uintBitsToFloat(words[word + 1u]), uintBitsToFloat(words[word + 2u]));
}

// Relinks a list, nearest first, by insertion: for any length, without extra memory.
uint sorted(uint rest) {
  uint first = 0u;
  while (rest != 0u) {
    uint node = rest - 1u, before = 0u, after = first;
    rest = words[node * node_words + next_word];
    uvec2 key = key_of(node);
    while (after != 0u && is_nearer(key_of(after - 1u), key)) {
      before = after;
      after = words[(after - 1u) * node_words + next_word];
    }
    words[node * node_words + next_word] = after;
    if (before == 0u)
      first = node + 1u;
    else
      words[(before - 1u) * node_words + next_word] = node + 1u;
  }
  return first;
}

void main() {
  uint node = sorted(heads[head_index(ivec2(gl_FragCoord.xy))]);
  if (node == 0u) discard;
  o_added = vec4(0.0);
  o_through = vec4(1.0);
  for (; node != 0u; node = words[(node - 1u) * node_words + next_word]) {
    uint word = (node - 1u) * node_words;
    vec3 through = color_at(word + 5u);
    float mean = (through.x + through.y + through.z) * (1.0 / 3.0);
    o_added += o_through * vec4(color_at(word + 2u), 1.0 - mean);
    o_through *= vec4(through, mean);
  }
}
