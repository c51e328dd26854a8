/* The parts of any host without Sideray: a context, a function table, a framebuffer, geometry, shader compilation, a
 * camera. Ends the program on any failure. */
#ifndef ENGINE_H
#define ENGINE_H

#include <glad/gl.h>
#include <stdbool.h>
#include <stdint.h>

extern GladGLContext gl;

enum { width = 320, height = 180 };

/* A floor (y = 0) and a pane of glass standing on it: four vertices and six indices each. */
extern const float positions[24];
extern const uint32_t indices[12];

void require(bool condition, const char* what);
void check_errors(const char* where);
void create_context(void);
GLuint create_framebuffer(void); /* RGBA16F and DEPTH24_STENCIL8, bound */
void create_geometry(void);
/* Returns a program; `parts` are the texts of its fragment shader, in order. */
GLuint create_program(const char* vertex, const char* const* parts, int count);
void* get_proc_address(void* user, const char* name);

/* Computes the matrix of a view from `eye` along -Z, column-major, and its inverse. */
void look_forward(const double eye[3], double yfov, double clip_from_world[16], double world_from_clip[16]);

#endif
