/* A preloaded library that simulates a lost OpenGL context, which software drivers never have: once the file named by
 * SIDERAY_LOSE_CONTEXT exists, glGetGraphicsResetStatus() reports a reset. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef void* (*find_symbol)(void* handle, const char* name);
typedef void (*function)(void);
typedef function (*find_function)(const unsigned char* name);

static find_function driver_function;

static unsigned reset_status(void) {
  const char* file = getenv("SIDERAY_LOSE_CONTEXT");
  return file && access(file, F_OK) == 0 ? 0x8253 /* GL_GUILTY_CONTEXT_RESET */ : 0;
}

static function find(const unsigned char* name) {
  if (strncmp((const char*)name, "glGetGraphicsResetStatus", 24) == 0) return (function)reset_status;
  return driver_function(name);
}

/* GLFW finds the driver's functions through this one. */
__attribute__((visibility("default"))) void* dlsym(void* handle, const char* name) {
  static find_symbol real;
  if (!real) *(void**)&real = dlvsym(RTLD_NEXT, "dlsym", "GLIBC_2.2.5");
  void* found = real(handle, name);
  if (!found || strncmp(name, "glXGetProcAddress", 17) != 0) return found;
  *(void**)&driver_function = found;
  return (void*)find;
}
