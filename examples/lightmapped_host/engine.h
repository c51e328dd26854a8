/* The engine's renderer, typical of its time: OpenGL 2.1 in immediate mode, an RGBA8 framebuffer blended in gamma
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
  GLuint glass, answers; /* programs that use rays; `answers` draws magenta without an answer */
  struct camera camera;
};

void require(bool condition, const char* what);
void* get_proc_address(void* user, const char* name);
void start_engine(struct engine* engine, const struct room* room, int width, int height);

/* Draws opaque faces, then the mask: the stencil counts the glass in each pixel. */
void draw_opaque(const struct engine* engine, const struct room* room);
/* Draws glass from back to front, with one of the programs. */
void draw_glass(const struct engine* engine, const struct room* room, GLuint program);
/* Returns RGB, bottom row first; the caller frees it. */
uint8_t* read_picture(const struct engine* engine);
/* Writes an uncompressed PNG. `rgb` has the bottom row first. */
void write_png(const char* path, const uint8_t* rgb, int width, int height);

/* Returns the surface id of a face in layers. */
uint32_t surface_of(int face);

#endif
