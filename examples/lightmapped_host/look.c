#include "look.h"

#include <math.h>

/* The colour is that of highlights and of the light in lightmaps. */
const struct lamp lamps[lamp_count] = {{{-1.5f, 2.7f, 0.4f}, {1.6f, 1.35f, 0.9f}},
                                       {{2.4f, 2.2f, 3.4f}, {0.75f, 0.95f, 1.5f}}};

const char look_glsl[] =
    "uniform sampler2D diffuse_map, light_map;\n"
    "uniform vec3 eye, normal, lamp_position[2], lamp_color[2];\n"
    "varying vec2 uv, light_uv;\n"
    "varying vec3 world;\n"
    "vec3 to_eye() { return normalize(eye - world); }\n"
    "vec3 facing() { return dot(normal, to_eye()) < 0.0 ? -normal : normal; }\n"
    "vec3 look() {\n"
    "  vec4 base = texture2D(diffuse_map, uv);\n"
    "  vec3 color = base.rgb * texture2D(light_map, light_uv).rgb * 2.0;\n"
    "  for (int i = 0; i < 2; ++i) {\n"
    "    vec3 half_way = normalize(normalize(lamp_position[i] - world) + to_eye());\n"
    "    color += lamp_color[i] * (0.5 * base.a * pow(max(dot(facing(), half_way), 0.0), 40.0));\n"
    "  }\n"
    "  return min(color, vec3(1.0));\n"
    "}\n";

/* Samples a texture of `size` texels a side as the texture unit does: bilinear, repeated or clamped. */
static void sample(const uint8_t* texels, int size, const float uv[2], bool repeats, float color[4]) {
  int index[2][2];
  float weight[2];
  for (int axis = 0; axis < 2; ++axis) {
    const float at = uv[axis] * (float)size - 0.5f, first = floorf(at);
    weight[axis] = at - first;
    for (int k = 0; k < 2; ++k) {
      const int i = (int)first + k;
      index[axis][k] = repeats ? (i % size + size) % size : i < 0 ? 0 : i >= size ? size - 1 : i;
    }
  }
  for (int c = 0; c < 4; ++c) {
    color[c] = 0.0f;
    for (int k = 0; k < 4; ++k) {
      const float w = (k & 1 ? weight[0] : 1.0f - weight[0]) * (k & 2 ? weight[1] : 1.0f - weight[1]);
      color[c] += w * (float)texels[4 * (index[1][k >> 1] * size + index[0][k & 1]) + c] * (1.0f / 255.0f);
    }
  }
}

static void sample_texture(const struct room* room, const struct fragment* f, float base[4]) {
  uint8_t* const* levels = room->textures[f->face->texture];
  const float level = fminf(fmaxf(f->level, 0.0f), (float)(texture_levels - 1));
  const int sharp = (int)level, blurred = sharp + 1 < texture_levels ? sharp + 1 : sharp;
  const float weight = level - (float)sharp;
  float other[4];
  sample(levels[sharp], texture_size >> sharp, f->uv, true, base);
  if (weight == 0.0f) return;
  sample(levels[blurred], texture_size >> blurred, f->uv, true, other);
  for (int c = 0; c < 4; ++c) base[c] += weight * (other[c] - base[c]);
}

void look(const struct room* room, const struct fragment* f, float color[3]) {
  float base[4], light[4];
  sample_texture(room, f, base);
  sample(room->lightmaps[f->face - room->faces], lightmap_size, f->light_uv, false, light);
  for (int c = 0; c < 3; ++c) color[c] = base[c] * light[c] * 2.0f;
  for (int i = 0; i < lamp_count; ++i) {
    float half_way[3];
    subtract(lamps[i].position, f->position, half_way);
    normalize(half_way);
    for (int c = 0; c < 3; ++c) half_way[c] += f->to_eye[c];
    normalize(half_way);
    const float gleam = 0.5f * base[3] * powf(fmaxf(dot(f->normal, half_way), 0.0f), 40.0f);
    for (int c = 0; c < 3; ++c) color[c] += lamps[i].color[c] * gleam;
  }
  for (int c = 0; c < 3; ++c) color[c] = fminf(color[c], 1.0f);
}

float reflectance(const struct face* face, const float normal[3], const float to_eye[3]) {
  if (face->shine == 0.0f) return 0.0f;
  const float grazing = 1.0f - fminf(fabsf(dot(normal, to_eye)), 1.0f);
  const float squared = grazing * grazing;
  return (face->shine + (1.0f - face->shine) * squared * squared * grazing) / face->alpha;
}
