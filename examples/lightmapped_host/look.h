/* The engine's shading: lightmap times texture plus Blinn-Phong highlights, in the 8-bit gamma space of its textures,
 * lightmaps and framebuffer. It exists in GLSL 1.20 for fragments and in C for hits of rays. Any thread. */
#ifndef LOOK_H
#define LOOK_H

#include "room.h"

enum { lamp_count = 2 };

struct lamp {
  float position[3], color[3];
};
extern const struct lamp lamps[lamp_count];

/* vec3 look(), 0..1, of the uniforms diffuse_map, light_map, eye, normal and the varyings uv, light_uv, world. */
extern const char look_glsl[];

struct fragment {
  const struct face* face;
  float uv[2], light_uv[2], level; /* of the texture's mip levels */
  float normal[3], to_eye[3];      /* unit */
  float position[3];
};

/* Computes the same in C; `color` is 0..1. */
void look(const struct room* room, const struct fragment* fragment, float color[3]);
/* Returns the share of reflected light that glass adds: Schlick's approximation, which blending by alpha does not
 * scale; 0 for faces without shine. */
float reflectance(const struct face* face, const float normal[3], const float to_eye[3]);

#endif
