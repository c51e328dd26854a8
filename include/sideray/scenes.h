/* glTF files for sideray.h, in a library of its own (sideray_scenes): what draws its own content does without. Plain
 * memory, no OpenGL.
 *
 * Conventions are those of sideray.h. */
#ifndef SIDERAY_SCENES_H
#define SIDERAY_SCENES_H

#include <sideray/renderer.h>

#ifdef __cplusplus
extern "C" {
#endif

/* What a file says. Calls on one content must not overlap. */
typedef struct sideray_content sideray_content;

typedef struct sideray_load_options {
  size_t size;
  const char* animation; /* NULL = the first, "all", or a name; they loop */
  double time_s;
  int32_t default_light; /* a file without lights gets a sun; 0 = it stays without */
  /* A file that takes more is refused: processor seconds of the calling thread, and bytes of memory. A few bytes can ask
   * for hours and for all memory. 0 = what the environment variables SIDERAY_LOAD_SECONDS and SIDERAY_LOAD_GB (of 10^9
   * bytes) say, else 20 s and 2 * 10^9 bytes. */
  double max_seconds;
  uint64_t max_bytes;
  const char* variant; /* of materials (KHR_materials_variants): a name; NULL = those that the file shows without one */
} sideray_load_options;

/* The first animation, at 0 s, no variant, with a light, within the default limits. */
SIDERAY_DEFAULTS(sideray_load_options, load)

/* `path`: a .gltf or .glb file; `sideray make` writes built-in scenes as such. `options` may be NULL. Fails with
 * INVALID_ARGUMENT and names the file, what is wrong in it, and the remedy. */
SIDERAY_API sideray_status sideray_content_load(const char* path, const sideray_load_options* options,
                                                sideray_content** content, sideray_error* error);
SIDERAY_API void sideray_content_release(sideray_content* content); /* NULL is allowed */

/* What was read otherwise than it is written: one line each. Strings live as long as the content. */
SIDERAY_API size_t sideray_content_warning_count(const sideray_content* content);
SIDERAY_API const char* sideray_content_warning(const sideray_content* content, size_t index);

/* The variants of materials that load options may name. NULL where there is no such variant. */
SIDERAY_API size_t sideray_content_variant_count(const sideray_content* content);
SIDERAY_API const char* sideray_content_variant_name(const sideray_content* content, size_t index);

SIDERAY_API size_t sideray_content_camera_count(const sideray_content* content);
/* "" where the file gives it no name; NULL where there is no such camera. Lives as long as the content. */
SIDERAY_API const char* sideray_content_camera_name(const sideray_content* content, size_t index);
/* Where the content has no camera, index 0 is one that frames it all in a picture of this width / height. Fills as much
 * of `camera` as its `size`, which the caller has set, says. */
SIDERAY_API sideray_status sideray_content_camera(const sideray_content* content, size_t index, float aspect,
                                                  sideray_camera* camera, sideray_error* error);

typedef struct sideray_fill_options {
  size_t size;
  /* Which translucent objects take part in hybrid translucency: "auto", "all", "none", "largest:K" (of `camera`, in a
   * picture of width x height), or glob patterns of node names with commas between them. */
  const char* ray_traced;
  const sideray_camera* camera; /* NULL: the content's first */
  uint32_t width, height;
  int32_t sky; /* the built-in sky as the environment; 0 = the scene's own stays */
} sideray_fill_options;

/* "auto", with the sky. */
SIDERAY_DEFAULTS(sideray_fill_options, fill)

/* Adds all of the content to an empty scene and commits. The object of surface id i is the (i - 1)-th that
 * sideray_content_object_name names. `options` may be NULL. */
SIDERAY_API sideray_status sideray_content_fill(const sideray_content* content, const sideray_fill_options* options,
                                                sideray_scene* scene, sideray_error* error);
SIDERAY_API size_t sideray_content_object_count(const sideray_content* content);
SIDERAY_API const char* sideray_content_object_name(const sideray_content* content, size_t index);

/* Moves the content to another time, and the scene that it filled, which holds nothing else; commits where anything
 * changed. `previous_time_s`: of the picture before, for motion vectors. */
SIDERAY_API sideray_status sideray_content_move(sideray_content* content, double time_s, double previous_time_s,
                                                sideray_scene* scene, sideray_error* error);

#ifdef __cplusplus
}
#endif
#endif
