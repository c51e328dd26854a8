/* The engine's renderer, as such engines were: OpenGL 2.1 in immediate mode, an RGBA8 framebuffer blended in gamma
 * space, GLSL 1.20. Ends the program on any failure. Calls OpenGL. */
#ifndef ENGINE_H
#define ENGINE_H

#include <glad/gl.h>
#include <stdbool.h>
#include <stdint.h>

#include "room.h"

extern GladGLContext gl;

struct camera {
  float eye[3]; /* looks along -Z */
  double clip_from_world[16], world_from_clip[16];
  float half_width, half_height; /* of the picture at distance 1 */
};

struct engine {
  int width, height;
  GLuint framebuffer;
  GLuint textures[texture_count], lightmaps[face_count];
  GLuint opaque, raster_glass;
  GLuint glass, answers; /* by rays; `answers` is magenta where they have none */
  struct camera camera;
};

void require(bool condition, const char* what);
void* get_proc_address(void* user, const char* name);
void start_engine(struct engine* engine, const struct room* room, int width, int height);

/* Also the mask: stencil counts the glass in each pixel. */
void draw_opaque(const struct engine* engine, const struct room* room);
/* Back to front, with one of the programs. */
void draw_glass(const struct engine* engine, const struct room* room, GLuint program);
/* RGB, bottom row first; the caller frees it. */
uint8_t* read_picture(const struct engine* engine);
/* Top row first in the file; uncompressed. */
void write_png(const char* path, const uint8_t* rgb, int width, int height);

/* What a surface is called in layers. */
uint32_t surface_of(int face);

#endif
