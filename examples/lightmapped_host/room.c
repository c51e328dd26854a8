#include "room.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "look.h"

static const float gamma_of_old = 2.2f;

void subtract(const float a[3], const float b[3], float result[3]) {
  for (int c = 0; c < 3; ++c) result[c] = a[c] - b[c];
}

float dot(const float a[3], const float b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

void normalize(float v[3]) {
  const float length = sqrtf(dot(v, v));
  for (int c = 0; c < 3; ++c) v[c] /= length;
}

/* ---- Faces: 6 of the room, 5 of each of two crates, a poster, 3 of glass ---- */

static void set_face(struct face* f, const float at[3], const float u[3], const float v[3], enum texture texture) {
  memcpy(f->corner, at, sizeof(f->corner));
  memcpy(f->u, u, sizeof(f->u));
  memcpy(f->v, v, sizeof(f->v));
  const float n[3] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
  memcpy(f->normal, n, sizeof(f->normal));
  normalize(f->normal);
  f->texture = texture;
  f->alpha = 1.0f;
  f->repeats[0] = f->repeats[1] = 1.0f;
}

static struct face* add_face(struct room* room, int* count, const float at[3], const float u[3], const float v[3],
                             enum texture texture) {
  struct face* face = &room->faces[(*count)++];
  set_face(face, at, u, v, texture);
  return face;
}

/* Adds the walls, seen from inside: x -4..4, y 0..3, z -3..5. */
static void add_walls(struct room* room, int* count) {
  static const struct {
    float at[3], u[3], v[3], repeats[2];
    enum texture texture;
  } walls[6] = {
      {{-4, 0, 5}, {8, 0, 0}, {0, 0, -8}, {4, 4}, planks},   {{-4, 3, -3}, {8, 0, 0}, {0, 0, 8}, {3, 3}, plaster},
      {{-4, 0, -3}, {8, 0, 0}, {0, 3, 0}, {4, 1.5f}, brick}, {{4, 0, 5}, {-8, 0, 0}, {0, 3, 0}, {4, 1.5f}, brick},
      {{-4, 0, 5}, {0, 0, -8}, {0, 3, 0}, {8, 3}, tiles},    {{4, 0, -3}, {0, 0, 8}, {0, 3, 0}, {3, 1}, plaster}};
  for (int i = 0; i < 6; ++i) {
    struct face* wall = add_face(room, count, walls[i].at, walls[i].u, walls[i].v, walls[i].texture);
    memcpy(wall->repeats, walls[i].repeats, sizeof(wall->repeats));
  }
}

/* Adds a crate rotated about y; its bottom is never visible. */
static void add_crate(struct room* room, int* count, float x, float z, float size, float angle) {
  const float a[3] = {size * cosf(angle), 0, -size * sinf(angle)}, b[3] = {size * sinf(angle), 0, size * cosf(angle)};
  const float back_a[3] = {-a[0], 0, -a[2]}, back_b[3] = {-b[0], 0, -b[2]}, up[3] = {0, size, 0};
  const float p0[3] = {x, 0, z}, p1[3] = {x + a[0], 0, z + a[2]};
  const float p2[3] = {p1[0] + b[0], 0, p1[2] + b[2]}, p3[3] = {x + b[0], 0, z + b[2]};
  const float top[3] = {p3[0], size, p3[2]};
  add_face(room, count, p3, a, up, crate);
  add_face(room, count, p2, back_b, up, crate);
  add_face(room, count, p1, back_a, up, crate);
  add_face(room, count, p0, b, up, crate);
  add_face(room, count, top, a, back_b, crate);
}

static void add_glass(struct room* room, int* count) {
  static const float at[3][3] = {{-2.9f, 0.1f, 0.4f}, {0.4f, 0.1f, -0.2f}, {-0.75f, 0.5f, 1.6f}};
  static const float u[3][3] = {{2.2f, 0, -0.7f}, {2.6f, 0, 0.7f}, {1.0f, 0, 0.1f}};
  static const float v[3][3] = {{0, 2.4f, 0}, {0, 2.4f, 0}, {0, 1.0f, 0}};
  for (int i = 0; i < 3; ++i) {
    struct face* glass = add_face(room, count, at[i], u[i], v[i], i == 2 ? stained : pane);
    glass->alpha = i == 2 ? 0.75f : 0.35f;
    glass->shine = i == 2 ? 0.0f : 0.35f;
  }
}

static void add_faces(struct room* room) {
  static const float poster_at[3] = {2.2f, 0.7f, 4.99f}, poster_u[3] = {-2.4f, 0, 0}, poster_v[3] = {0, 1.8f, 0};
  int count = 0;
  add_walls(room, &count);
  add_crate(room, &count, -3.4f, -2.6f, 1.1f, 0.3f);
  add_crate(room, &count, 1.6f, 2.4f, 0.9f, -0.5f);
  add_face(room, &count, poster_at, poster_u, poster_v, poster);
  add_glass(room, &count);
}

/* ---- Textures ---- */

static uint32_t noise(uint32_t x) {
  x = (x ^ (x >> 16)) * 0x7feb352du;
  x = (x ^ (x >> 15)) * 0x846ca68bu;
  return x ^ (x >> 16);
}

static void color_brick(int x, int y, float c[4]) {
  const int row = y / 8, column = (x + (row % 2) * 8) / 16;
  const bool mortar = y % 8 == 0 || (x + (row % 2) * 8) % 16 == 0;
  const float shade = (float)(noise((uint32_t)(row * 7 + column % 4)) % 64) / 255.0f;
  c[0] = mortar ? 0.55f : 0.55f + shade;
  c[1] = mortar ? 0.53f : 0.28f + 0.5f * shade;
  c[2] = mortar ? 0.5f : 0.22f + 0.3f * shade;
}

static void color_planks(int x, int y, float c[4]) {
  const float shade = (float)(noise((uint32_t)(x / 16)) % 48) / 255.0f;
  const float grain = (float)(noise((uint32_t)(x * 5 + y / 16 * 977)) % 24) / 255.0f;
  const float seam = x % 16 == 0 ? 0.5f : 1.0f;
  c[0] = seam * (0.5f + shade + grain), c[1] = seam * (0.36f + shade + grain), c[2] = seam * (0.22f + shade);
  c[3] = 0.35f;
}

static void color_tiles(int x, int y, float c[4]) {
  const bool gap = x % 32 < 2 || y % 32 < 2, blue = (x / 32 + y / 32) % 2 == 0;
  c[0] = gap ? 0.4f : blue ? 0.3f : 0.8f;
  c[1] = gap ? 0.4f : blue ? 0.45f : 0.8f;
  c[2] = gap ? 0.4f : blue ? 0.62f : 0.76f;
  c[3] = gap ? 0.0f : 0.6f;
}

static void color_crate(int x, int y, float c[4]) {
  const bool rim = x < 7 || y < 7 || x > 56 || y > 56, brace = abs(x - y) < 5;
  const float base = rim || brace ? 0.62f : 0.48f, grain = (float)(noise((uint32_t)(y / 2 * 3 + x / 32)) % 20) / 255.0f;
  c[0] = base + grain, c[1] = 0.8f * base + grain, c[2] = 0.5f * base;
  c[3] = 0.1f;
}

static void color_poster(int x, int y, float c[4]) {
  static const float stripes[6][3] = {{0.9f, 0.2f, 0.15f}, {0.95f, 0.6f, 0.1f},  {0.95f, 0.9f, 0.2f},
                                      {0.2f, 0.7f, 0.3f},  {0.15f, 0.4f, 0.85f}, {0.5f, 0.2f, 0.7f}};
  const float dx = (float)x - 31.5f, dy = (float)y - 31.5f;
  const int ring = (int)(sqrtf(dx * dx + dy * dy) / 6.0f);
  const bool rim = x < 3 || y < 3 || x > 60 || y > 60;
  for (int k = 0; k < 3; ++k) c[k] = rim ? 0.95f : stripes[ring % 6][k];
  c[3] = 0.2f;
}

static void color_stained(int x, int y, float c[4]) {
  const int cell = x / 16 + y / 16;
  const bool lead = x % 16 == 0 || y % 16 == 0;
  c[0] = lead ? 0.1f : cell % 3 == 0 ? 0.85f : 0.25f;
  c[1] = lead ? 0.1f : cell % 3 == 1 ? 0.75f : 0.3f;
  c[2] = lead ? 0.1f : cell % 3 == 2 ? 0.85f : 0.2f;
  c[3] = lead ? 0.0f : 0.8f;
}

static void color_texel(enum texture texture, int x, int y, float c[4]) {
  c[0] = c[1] = c[2] = 0.75f + (float)(noise((uint32_t)(y * 64 + x)) % 12) / 255.0f; /* plaster */
  c[3] = 0.0f;
  switch (texture) {
    case brick:
      color_brick(x, y, c);
      break;
    case planks:
      color_planks(x, y, c);
      break;
    case tiles:
      color_tiles(x, y, c);
      break;
    case crate:
      color_crate(x, y, c);
      break;
    case poster:
      color_poster(x, y, c);
      break;
    case stained:
      color_stained(x, y, c);
      break;
    case pane:
      c[0] = 0.25f, c[1] = 0.4f, c[2] = 0.35f, c[3] = 1.0f;
      break;
    case plaster:
    case texture_count:
      break;
  }
}

static uint8_t to_byte(float x) {
  return (uint8_t)(fminf(fmaxf(x, 0.0f), 1.0f) * 255.0f + 0.5f);
}

static void halve(const uint8_t* from, int size, uint8_t* to) {
  for (int y = 0; y < size / 2; ++y)
    for (int x = 0; x < size / 2; ++x)
      for (int c = 0; c < 4; ++c) {
        const uint8_t* p = from + 4 * (2 * y * size + 2 * x) + c;
        to[4 * (y * (size / 2) + x) + c] = (uint8_t)((p[0] + p[4] + p[4 * size] + p[4 * size + 4] + 2) / 4);
      }
}

static void make_texture(struct room* room, enum texture texture) {
  uint8_t** levels = room->textures[texture];
  for (int level = 0; level < texture_levels; ++level) {
    const int size = texture_size >> level;
    levels[level] = malloc((size_t)(4 * size * size));
    if (level > 0) {
      halve(levels[level - 1], 2 * size, levels[level]);
      continue;
    }
    for (int i = 0; i < size * size; ++i) {
      float c[4];
      color_texel(texture, i % size, i / size, c);
      for (int k = 0; k < 4; ++k) levels[0][4 * i + k] = to_byte(c[k]);
    }
  }
}

/* ---- Lightmaps: the shadowed lamps and a constant for bounced light; computed linearly, stored in gamma space ----
 */

int face_along(const struct room* room, const float origin[3], const float direction[3], int skipped, float at[2],
               float* distance) {
  int nearest = -1;
  *distance = 1e30f;
  for (int i = 0; i < face_count; ++i) {
    const struct face* f = &room->faces[i];
    const float slant = dot(f->normal, direction);
    if (i == skipped || fabsf(slant) < 1e-6f) continue;
    float to_corner[3], on[3];
    subtract(f->corner, origin, to_corner);
    const float t = dot(f->normal, to_corner) / slant;
    if (t < 1e-4f || t >= *distance) continue;
    for (int c = 0; c < 3; ++c) on[c] = direction[c] * t - to_corner[c];
    const float s = dot(on, f->u) / dot(f->u, f->u), r = dot(on, f->v) / dot(f->v, f->v);
    if (s < 0.0f || s > 1.0f || r < 0.0f || r > 1.0f) continue;
    nearest = i, *distance = t, at[0] = s, at[1] = r;
  }
  return nearest;
}

/* Returns whether an opaque face is between two points. */
static bool blocked(const struct room* room, const float from[3], const float to[3], int skipped) {
  float start[3], direction[3], at[2], distance = 0.0f;
  memcpy(start, from, sizeof(start));
  for (int k = 0; k < face_count; ++k) {
    subtract(to, start, direction);
    const float left = sqrtf(dot(direction, direction));
    normalize(direction);
    const int face = face_along(room, start, direction, skipped, at, &distance);
    if (face < 0 || distance >= left) return false;
    if (room->faces[face].alpha == 1.0f) return true;
    skipped = face; /* glass */
    for (int c = 0; c < 3; ++c) start[c] += direction[c] * distance;
  }
  return true;
}

static void light_texel(const struct room* room, int number, const float point[3], uint8_t texel[4]) {
  const struct face* face = &room->faces[number];
  float light[3] = {0.13f, 0.13f, 0.16f};
  for (int i = 0; i < lamp_count; ++i) {
    float to_lamp[3];
    subtract(lamps[i].position, point, to_lamp);
    const float squared = dot(to_lamp, to_lamp);
    normalize(to_lamp);
    float cosine = dot(face->normal, to_lamp);
    if (face->alpha < 1.0f) cosine = fabsf(cosine);
    if (cosine <= 0.0f || blocked(room, point, lamps[i].position, number)) continue;
    for (int c = 0; c < 3; ++c) light[c] += 3.0f * lamps[i].color[c] * cosine / (1.0f + squared);
  }
  for (int c = 0; c < 3; ++c) texel[c] = to_byte(0.5f * powf(light[c], 1.0f / gamma_of_old));
  texel[3] = 255;
}

static void make_lightmap(struct room* room, int number) {
  const struct face* f = &room->faces[number];
  for (int i = 0; i < lightmap_size * lightmap_size; ++i) {
    const float s = ((float)(i % lightmap_size) + 0.5f) / (float)lightmap_size;
    const float t = ((float)(i / lightmap_size) + 0.5f) / (float)lightmap_size;
    float point[3];
    for (int c = 0; c < 3; ++c) point[c] = f->corner[c] + s * f->u[c] + t * f->v[c];
    light_texel(room, number, point, room->lightmaps[number] + 4 * i);
  }
}

void load_room(struct room* room) {
  memset(room, 0, sizeof(*room));
  add_faces(room);
  for (int i = 0; i < texture_count; ++i) make_texture(room, (enum texture)i);
  for (int i = 0; i < face_count; ++i) make_lightmap(room, i);
}

void unload_room(struct room* room) {
  for (int i = 0; i < texture_count; ++i)
    for (int level = 0; level < texture_levels; ++level) free(room->textures[i][level]);
}
