/* The engine's room: flat faces with textures, and lightmaps that it computes once. Plain memory. */
#ifndef ROOM_H
#define ROOM_H

#include <stdbool.h>
#include <stdint.h>

enum { texture_size = 64, texture_levels = 7, lightmap_size = 32, face_count = 20 };

enum texture { brick, planks, plaster, tiles, crate, poster, pane, stained, texture_count };

/* The corners are corner, corner + u, corner + u + v, corner + v, in this order as seen from the front. */
struct face {
  float corner[3], u[3], v[3];
  float normal[3]; /* unit, u x v */
  float repeats[2];
  enum texture texture;
  float alpha; /* below 1: glass, seen from both sides */
  float shine; /* reflectance of glass at normal incidence; 0 = none */
};

struct room {
  struct face faces[face_count];
  /* RGBA8, gamma space, top row first; A: strength of highlights. All mip levels, each half the size of the last. */
  uint8_t* textures[texture_count][texture_levels];
  uint8_t lightmaps[face_count][lightmap_size * lightmap_size * 4]; /* 128 = as the texture is */
};

void load_room(struct room* room);
void unload_room(struct room* room);

/* Returns the first face other than `skipped` (-1 = none) that the ray from `origin` along unit `direction` hits, or
 * -1. */
int face_along(const struct room* room, const float origin[3], const float direction[3], int skipped, float at[2],
               float* distance);

void subtract(const float a[3], const float b[3], float result[3]);
float dot(const float a[3], const float b[3]);
void normalize(float v[3]);

#endif
