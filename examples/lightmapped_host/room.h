/* Declares the data that the engine loads: a room of flat faces with textures, and lightmaps computed once. Calls no
 * OpenGL. */
#ifndef ROOM_H
#define ROOM_H

#include <stdbool.h>
#include <stdint.h>

enum { texture_size = 64, texture_levels = 7, lightmap_size = 32, face_count = 20 };

enum texture { brick, planks, plaster, tiles, crate, poster, pane, stained, texture_count };

/* Has the corners corner, corner + u, corner + u + v, corner + v, counter-clockwise as seen from the front. */
struct face {
  float corner[3], u[3], v[3];
  float normal[3]; /* unit, u x v */
  float repeats[2];
  enum texture texture;
  float alpha; /* below 1: glass, visible from both sides */
  float shine; /* of glass: reflectance at normal incidence; 0: no reflection */
};

struct room {
  struct face faces[face_count];
  /* RGBA8, gamma space, top row first; A is the strength of highlights. All mip levels, each half the size of the one
   * before. */
  uint8_t* textures[texture_count][texture_levels];
  uint8_t lightmaps[face_count][lightmap_size * lightmap_size * 4]; /* 128 leaves the texture unchanged */
};

void load_room(struct room* room);
void unload_room(struct room* room);

/* Returns the first face other than `skipped` (-1: none) on the line from `origin` along unit `direction`; -1: none. */
int face_along(const struct room* room, const float origin[3], const float direction[3], int skipped, float at[2],
               float* distance);

void subtract(const float a[3], const float b[3], float result[3]);
float dot(const float a[3], const float b[3]);
void normalize(float v[3]);

#endif
