/* Ground truth of pictures beside their channels (SIDERAY_AOV_FIRST, _GLASS, _BEHIND, _REFRACTION of renderer.h): masks
 * of whole objects, how much of them is visible, all surfaces behind each pixel, and the rays of a camera.
 * docs/ground-truth.md defines every figure.
 * Plain memory, no OpenGL. Not in sideray.h.
 *
 * Conventions are those of sideray.h, but rows: pixels are counted from the TOP left, as in a picture's channels. */
#ifndef SIDERAY_GROUND_TRUTH_H
#define SIDERAY_GROUND_TRUTH_H

#include <sideray/renderer.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Writes the rays through the centres of a picture's pixels, `width * height` of them, `stride_bytes` apart
 * (sizeof(sideray_ray)), top row first: rays[y * width + x]. They are in world space with unit directions. Perspective
 * rays start at the eye, and t_near and t_far are their distances to the near and far plane; orthographic rays start on
 * the near plane. t_far is 1e30 without a far plane. A point at distance t along a ray has the channel Z = t *
 * (direction . forward), orthographic + z_near, where forward is the camera's -Z. */
SIDERAY_API sideray_status sideray_camera_rays(const sideray_camera* camera, uint32_t width, uint32_t height,
                                               sideray_ray* rays, size_t stride_bytes, sideray_error* error);

/* Which surfaces can hide an object. */
typedef enum sideray_hidden_by {
  SIDERAY_HIDDEN_BY_ALL = 0,    /* every surface: glass hides what is behind it */
  SIDERAY_HIDDEN_BY_OPAQUE = 1, /* only opaque surfaces, along the straight ray: objects behind glass are visible */
  SIDERAY_HIDDEN_BY_FORCE_32 = 0x7fffffff
} sideray_hidden_by;

typedef struct sideray_object_truth_desc {
  size_t size;
  const sideray_camera* camera;
  uint32_t width, height; /* 1..16384 each */
  /* Fractions are counted on a regular grid of N x N samples in every pixel, 1..16; masks use only pixel centres. */
  uint32_t samples_per_side;
  sideray_hidden_by hidden_by;
  /* The instance with surface id surface_ids[i] is a part of object objects[i]; both arrays have `count` elements. An
   * object may have many surfaces, a surface belongs to one object, and neither number is 0. Surfaces that are not
   * listed belong to no object but still hide what is behind them. NULL: every instance with a surface id is an object
   * of that number. */
  const uint32_t* surface_ids;
  const uint32_t* objects;
  size_t count;
} sideray_object_truth_desc;

/* No camera yet, 1280x720, 4 x 4 samples, hidden by all, one object a surface. */
SIDERAY_DEFAULTS(sideray_object_truth_desc, object_truth)

/* One mask, of pixels whose centres are covered. */
typedef struct sideray_object_mask {
  uint32_t pixels;                  /* their number */
  uint32_t x, y, width, height;     /* smallest box around the pixels; 0 without pixels */
  /* Lengths of runs down the columns, the first column first, of pixels outside and inside in turn, starting outside:
   * the uncompressed run-length encoding of COCO, whose `size` is [height, width] of the picture. Their sum is the
   * number of the picture's pixels. */
  const uint32_t* runs;
  size_t run_count;
} sideray_object_mask;

/* One object. Structs that the library returns by pointer have no size field and grow at their end. */
typedef struct sideray_object_truth {
  uint32_t object;
  sideray_object_mask visible; /* visible pixels */
  sideray_object_mask amodal;  /* pixels that would be visible if nothing else were there; within the picture */
  double coverage;             /* pixels that the whole object covers, counted on the grid */
  double visible_fraction;     /* visible share of that, 0..1; 0 if it covers nothing */
} sideray_object_truth;

typedef struct sideray_object_truths sideray_object_truths;

/* Finds the masks of all objects of the committed scene by rays, as a frame without jitter would draw them: plants in
 * their current poses, nothing culled for its size, no particles. The caller owns the list; its entries live as long as
 * it does. They are in ascending order of `object` and include objects out of sight. INVALID_ARGUMENT: a surface id is
 * not in the scene or is listed twice. */
SIDERAY_API sideray_status sideray_object_truths_create(sideray_tracer* tracer, const sideray_object_truth_desc* desc,
                                                        sideray_object_truths** truths, sideray_error* error);
SIDERAY_API size_t sideray_object_truths_count(const sideray_object_truths* truths);
/* Returns NULL for an index beyond the last. */
SIDERAY_API const sideray_object_truth* sideray_object_truths_at(const sideray_object_truths* truths, size_t index);
SIDERAY_API void sideray_object_truths_release(sideray_object_truths* truths); /* NULL is allowed */

/* ---- Layered depth: every surface that a pixel looks at, opaque and translucent, in one order ---- */

/* The rays along which surfaces are found. */
typedef enum sideray_layer_path {
  /* The straight ray through the pixel's centre, as sideray_camera_rays writes it, from its t_near to its t_far. It
   * passes through everything, so it finds surfaces behind opaque ones, and both faces of all meshes. */
  SIDERAY_LAYERS_STRAIGHT = 0,
  /* The path of light: refracted and totally reflected by volumes, as in the channels `behind` and `refraction`
   * (docs/ground-truth.md, The path). It ends at the first opaque surface, and hits only what pictures show. */
  SIDERAY_LAYERS_BENT = 1,
  SIDERAY_LAYERS_FORCE_32 = 0x7fffffff
} sideray_layer_path;

/* How rays treat a surface's material. */
typedef enum sideray_surface_kind {
  SIDERAY_KIND_NONE = 0, /* no surface */
  SIDERAY_KIND_OPAQUE = 1,
  SIDERAY_KIND_MASK = 2,  /* opaque, with holes: alpha mode MASK */
  SIDERAY_KIND_BLEND = 3, /* alpha mode BLEND without transmission */
  SIDERAY_KIND_THIN = 4,  /* transmission without thickness: rays pass it straight */
  SIDERAY_KIND_VOLUME = 5 /* transmission and thickness: rays are refracted */
} sideray_surface_kind;

/* Which face of a surface a ray hit. */
typedef enum sideray_surface_face {
  SIDERAY_FACE_NONE = 0, /* no surface */
  SIDERAY_FACE_FRONT = 1,
  SIDERAY_FACE_BACK = 2,       /* of a double-sided material */
  SIDERAY_FACE_HIDDEN_BACK = 3 /* of a material that is not double sided: visible only from within glass */
} sideray_surface_face;

/* The wanted values, and where they are written. The caller owns the arrays; NULL: not wanted. Pixel (x, y), from the
 * top left, has the index p = y * width + x; its layer k, the nearest first, is entry i = p * layers + k. Entries of
 * absent layers hold +inf in `z` and `distance`, and 0 in all others. */
typedef struct sideray_layered_depth_desc {
  size_t size;
  const sideray_camera* camera;
  uint32_t width, height; /* 1..16384 each */
  uint32_t layers;        /* 1..64: how many surfaces of each pixel are stored, the nearest ones */
  sideray_layer_path path;
  uint32_t* counts;            /* [p]: number of the pixel's layers, 0..layers */
  float* z;                    /* [i]: distance along the view axis, world units, as the channel Z */
  float* distance;             /* [i]: length of the path from the start of the pixel's ray, world units */
  float* normals;              /* [3 * i]: shading normal, unit, world space, on the side that the ray comes from */
  float* geometric_normals;    /* [3 * i]: the triangle's normal, unit, world space, on the same side */
  uint32_t* surface_ids;       /* [i] */
  sideray_instance* instances; /* [i] */
  uint32_t* primitives;        /* [i]: triangle's index in the mesh as added */
  uint8_t* kinds;              /* [i]: a sideray_surface_kind */
  uint8_t* faces;              /* [i]: a sideray_surface_face */
} sideray_layered_depth_desc;

/* No camera yet, 1280x720, 8 layers, straight, no arrays. */
SIDERAY_DEFAULTS(sideray_layered_depth_desc, layered_depth)

/* Finds the surfaces of the committed scene behind every pixel, by rays through the pixels' centres, as a frame without
 * jitter would draw them: plants in their current poses, nothing culled for its size, no particles. Layers at the same
 * distance are ordered by surface id and primitive. */
SIDERAY_API sideray_status sideray_tracer_layered_depth(sideray_tracer* tracer, const sideray_layered_depth_desc* desc,
                                                        sideray_error* error);

#ifdef __cplusplus
}
#endif
#endif
