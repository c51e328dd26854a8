// What any host has before Sideray comes: a context, a function table, a framebuffer, geometry, shader compilation.
// Ends the program on any failure.
#pragma once

#include <glad/gl.h>

#include <cstdint>
#include <string>

extern GladGLContext gl;

inline constexpr int width = 320, height = 180;

// A floor (y = 0) and a pane of glass standing on it: four vertices and six indices each.
extern const float positions[24];
extern const uint32_t indices[12];

void require(bool condition, const char* what);
void check_errors(const char* where);
void create_context();
GLuint create_framebuffer();  // RGBA16F and DEPTH24_STENCIL8, bound
void create_geometry();
GLuint create_program(const std::string& vertex_text, const std::string& fragment_text);
void* get_proc_address(void* user, const char* name);
