/* Status, errors, versions of structs and the library's own version: the base of all other headers. */
#ifndef SIDERAY_BASE_H
#define SIDERAY_BASE_H

#include <stddef.h>
#include <stdint.h>

#define SIDERAY_VERSION_MAJOR 0
#define SIDERAY_VERSION_MINOR 3
#define SIDERAY_VERSION_PATCH 0

#if defined(__GNUC__)
#define SIDERAY_API __attribute__((visibility("default")))
#else
#define SIDERAY_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

typedef enum sideray_status {
  SIDERAY_OK = 0,
  SIDERAY_NOT_READY = 1,         /* not an error: poll again later, or a wait timed out */
  SIDERAY_INVALID_ARGUMENT = -1, /* the message names the argument and the accepted range */
  SIDERAY_OUT_OF_MEMORY = -2,
  SIDERAY_UNSUPPORTED = -3, /* the driver or build lacks something; the message names it */
  SIDERAY_NO_DEVICE = -4,   /* no usable OpenGL device; the message says why for each candidate */
  SIDERAY_GL_FAILED = -5,   /* the driver reported an error or lost the context */
  SIDERAY_CANCELLED = -6,
  SIDERAY_INTERNAL = -7 /* a defect of Sideray; please report the message */
} sideray_status;

typedef struct sideray_error {
  sideray_status status;
  char message[1020]; /* one line, UTF-8, zero-terminated */
} sideray_error;


/* Returns the version of the loaded library; SIDERAY_VERSION_* is that of the headers. */
SIDERAY_API void sideray_version(int* major, int* minor, int* patch);

/* Declares sideray_NAME_init, which fills the first `size` bytes of a struct with the defaults of the fields in them,
 * and the inline sideray_NAME_defaults, which returns a filled struct. The caller compiles the inline function, so a
 * library with a larger struct never writes beyond the caller's. */
#define SIDERAY_DEFAULTS(type, name)                            \
  SIDERAY_API void sideray_##name##_init(type* out, size_t size); \
  static inline type sideray_##name##_defaults(void) {          \
    type filled;                                                \
    sideray_##name##_init(&filled, sizeof(filled));             \
    return filled;                                              \
  }

#ifdef __cplusplus
}
#endif
#endif
