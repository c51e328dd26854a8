/* glTF files for sideray.h, in a library of its own (sideray_scenes); programs with their own content do without it.
 * Plain memory, no OpenGL.
 *
 * Conventions are those of sideray.h. */
#ifndef SIDERAY_SCENES_H
#define SIDERAY_SCENES_H

#include <sideray/renderer.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The content of a file. Calls on one content must not overlap. */
typedef struct sideray_content sideray_content;

typedef struct sideray_load_options {
  size_t size;
  const char* animation; /* NULL = the first, "all", or a name; they loop */
  double time_s;
  int32_t default_light; /* a file without lights gets a sun; 0 = none */
  /* Limits, because a few bytes can ask for hours and for all memory: processor seconds of the calling thread, and
   * bytes of memory. A file that takes more is refused. 0 = the environment variables SIDERAY_LOAD_SECONDS and
   * SIDERAY_LOAD_GB (of 10^9 bytes), else 20 s and 2 * 10^9 bytes. */
  double max_seconds;
  uint64_t max_bytes;
  const char* variant; /* name of a material variant (KHR_materials_variants); NULL = the file's default */
} sideray_load_options;

/* The first animation, at 0 s, no variant, with a light, within the default limits. */
SIDERAY_DEFAULTS(sideray_load_options, load)

/* Loads a .gltf or .glb file; `sideray make` writes built-in scenes as such. `options` may be NULL. INVALID_ARGUMENT:
 * the message names the file, what is wrong in it, and the remedy. */
SIDERAY_API sideray_status sideray_content_load(const char* path, const sideray_load_options* options,
                                                sideray_content** content, sideray_error* error);
SIDERAY_API void sideray_content_release(sideray_content* content); /* NULL is allowed */

/* Return what was read differently from what the file says: one line each. Strings live as long as the content. */
SIDERAY_API size_t sideray_content_warning_count(const sideray_content* content);
SIDERAY_API const char* sideray_content_warning(const sideray_content* content, size_t index);

/* Return the variants of materials that load options may name. NULL for an index beyond the last. */
SIDERAY_API size_t sideray_content_variant_count(const sideray_content* content);
SIDERAY_API const char* sideray_content_variant_name(const sideray_content* content, size_t index);

SIDERAY_API size_t sideray_content_camera_count(const sideray_content* content);
/* Returns "" for a camera without a name; NULL if there is no such camera. Lives as long as the content. */
SIDERAY_API const char* sideray_content_camera_name(const sideray_content* content, size_t index);
/* Returns a camera. If the content has none, index 0 is one that frames all of it in a picture of this width / height.
 * Fills the first `size` bytes of `camera`; the caller sets `size`. */
SIDERAY_API sideray_status sideray_content_camera(const sideray_content* content, size_t index, float aspect,
                                                  sideray_camera* camera, sideray_error* error);

typedef struct sideray_fill_options {
  size_t size;
  /* Which translucent objects have layers in hybrid translucency: "auto", "all", "none", "largest:K" (as seen by
   * `camera`, in a picture of width x height), or glob patterns of node names, separated by commas. */
  const char* ray_traced;
  const sideray_camera* camera; /* NULL: the content's first */
  uint32_t width, height;
  int32_t sky; /* 1: the built-in sky as the environment; 0: keeps the scene's own */
} sideray_fill_options;

/* "auto", with the sky. */
SIDERAY_DEFAULTS(sideray_fill_options, fill)

/* Adds the whole content to an empty scene and commits. sideray_content_object_name(i - 1) names the object with
 * surface id i. `options` may be NULL. */
SIDERAY_API sideray_status sideray_content_fill(const sideray_content* content, const sideray_fill_options* options,
                                                sideray_scene* scene, sideray_error* error);
SIDERAY_API size_t sideray_content_object_count(const sideray_content* content);
SIDERAY_API const char* sideray_content_object_name(const sideray_content* content, size_t index);

/* Moves the content to another time, together with the scene that it filled, which must hold nothing else; commits if
 * anything changed. `previous_time_s` is that of the previous picture, for motion vectors. */
SIDERAY_API sideray_status sideray_content_move(sideray_content* content, double time_s, double previous_time_s,
                                                sideray_scene* scene, sideray_error* error);

#ifdef __cplusplus
}
#endif
#endif
