/* A preloaded library that makes the window lose an OpenGL context as soon as a file exists:
 *
 *   SIDERAY_LOSE_WINDOW=FILE    the context in which pictures are shown (GLX)
 *   SIDERAY_LOSE_RENDERER=FILE  the next context in which pictures are drawn (EGL); the file is removed
 *   SIDERAY_HANG_WINDOW=FILE    calls of the first do not return
 *   SIDERAY_HANG_RENDERER=FILE  calls of the second do not return
 *
 * Software drivers never lose a context, so the library makes glGetGraphicsResetStatus() report a reset. With
 * SIDERAY_LOSE_BY_FAULT, on an NVIDIA GPU, a shader writes to an unmapped address, and the driver's own answer is
 * returned. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { GUILTY_CONTEXT_RESET = 0x8253, COMPUTE_SHADER = 0x91B9 };

typedef void* (*find_symbol)(void* handle, const char* name);
typedef void (*function)(void);
typedef function (*find_function)(const char* name);

static find_function of_window, of_renderer;

/* Shaders that read or write unmapped memory. */
static const char* const faults[] = {
    "#version 450\n"
    "#extension GL_NV_gpu_shader5 : enable\n"
    "#extension GL_NV_shader_buffer_load : enable\n"
    "#extension GL_NV_shader_buffer_store : enable\n"
    "layout(local_size_x = 1) in;\n"
    "uniform uint64_t place;\n"
    "void main() { float* at = (float*)(place + uint64_t(0x7ead00000000UL)); *at = 1.0; }\n",
    "#version 450\n"
    "#extension GL_ARB_bindless_texture : require\n"
    "layout(local_size_x = 1) in;\n"
    "layout(std430, binding = 0) buffer Out { vec4 value; };\n"
    "void main() { value = texelFetch(sampler2D(uvec2(0xdeadbeef, 0xdeadbeef)), ivec2(0), 0); }\n"};

/* Runs a faulty shader and returns the driver's reset status. */
static unsigned lose_by_fault(find_function find, const char* text) {
  const unsigned shader = ((unsigned (*)(unsigned))find("glCreateShader"))(COMPUTE_SHADER);
  ((void (*)(unsigned, int, const char**, const int*))find("glShaderSource"))(shader, 1, &text, NULL);
  ((void (*)(unsigned))find("glCompileShader"))(shader);
  char log[400] = "";
  ((void (*)(unsigned, int, int*, char*))find("glGetShaderInfoLog"))(shader, sizeof(log), NULL, log);
  const unsigned program = ((unsigned (*)(void))find("glCreateProgram"))();
  ((void (*)(unsigned, unsigned))find("glAttachShader"))(program, shader);
  ((void (*)(unsigned))find("glLinkProgram"))(program);
  ((void (*)(unsigned))find("glUseProgram"))(program);
  ((void (*)(unsigned, unsigned, unsigned))find("glDispatchCompute"))(1, 1, 1);
  ((void (*)(void))find("glFinish"))();
  const unsigned error = ((unsigned (*)(void))find("glGetError"))();
  unsigned status = 0;
  for (int i = 0; i < 50 && status == 0; ++i, usleep(20000))
    status = ((unsigned (*)(void))find("glGetGraphicsResetStatus"))();
  for (char* at = log; *at; ++at)
    if (*at == '\n') *at = ' ';
  fprintf(stderr, "lost_context: the driver says %#x, error %#x %s\n", status, error, log);
  return status;
}

static unsigned lose(find_function find) {
  if (!getenv("SIDERAY_LOSE_BY_FAULT")) return GUILTY_CONTEXT_RESET;
  const unsigned status = lose_by_fault(find, faults[0]);
  return status ? status : lose_by_fault(find, faults[1]);
}

static void hang_if(const char* variable) {
  const char* file = getenv(variable);
  while (file && access(file, F_OK) == 0) pause();
}

static unsigned status_of_window(void) {
  hang_if("SIDERAY_HANG_WINDOW");
  const char* file = getenv("SIDERAY_LOSE_WINDOW");
  return file && access(file, F_OK) == 0 ? lose(of_window) : 0;
}

static unsigned status_of_renderer(void) {
  hang_if("SIDERAY_HANG_RENDERER");
  const char* file = getenv("SIDERAY_LOSE_RENDERER");
  return file && unlink(file) == 0 ? lose(of_renderer) : 0;
}

static int is_status(const char* name) {
  return strncmp(name, "glGetGraphicsResetStatus", 24) == 0;
}

static function find_of_window(const char* name) {
  return is_status(name) ? (function)status_of_window : of_window(name);
}

static function find_of_renderer(const char* name) {
  return is_status(name) ? (function)status_of_renderer : of_renderer(name);
}

/* GLFW and Sideray find the driver's functions by dlsym(), so this one replaces it. */
__attribute__((visibility("default"))) void* dlsym(void* handle, const char* name) {
  static find_symbol real;
  if (!real) *(void**)&real = dlvsym(RTLD_NEXT, "dlsym", "GLIBC_2.2.5");
  void* found = real(handle, name);
  if (found && strncmp(name, "glXGetProcAddress", 17) == 0) {
    *(void**)&of_window = found;
    return (void*)find_of_window;
  }
  if (found && strcmp(name, "eglGetProcAddress") == 0) {
    *(void**)&of_renderer = found;
    return (void*)find_of_renderer;
  }
  return found;
}
