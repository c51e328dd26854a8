/* Declares the engine's shading: lightmap times texture, and Blinn-Phong highlights, in the 8-bit gamma space of its
 * textures, lightmaps and framebuffer. Once as GLSL 1.20 for fragments, once in C for hits of rays. Any thread. */
#ifndef LOOK_H
#define LOOK_H

#include "room.h"

enum { lamp_count = 2 };

struct lamp {
  float position[3], color[3];
};
extern const struct lamp lamps[lamp_count];

/* Defines vec3 look(), 0..1, from the uniforms diffuse_map, light_map, eye, normal and the varyings uv, light_uv,
 * world. */
extern const char look_glsl[];

struct fragment {
  const struct face* face;
  float uv[2], light_uv[2], level; /* of the texture's mip levels */
  float normal[3], to_eye[3];      /* unit */
  float position[3];
};

/* Computes the same in C; `color` is 0..1. */
void look(const struct room* room, const struct fragment* fragment, float color[3]);
/* Returns the factor of what glass reflects: Schlick's curve, not reduced by alpha, because blending keeps reflections;
 * 0 for glass that does not reflect. */
float reflectance(const struct face* face, const float normal[3], const float to_eye[3]);

#endif
