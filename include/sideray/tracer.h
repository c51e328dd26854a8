/* Tracers: rays through a committed scene, plain memory in, plain memory out, no OpenGL; and shading by the host.
 * Calls on one tracer must not overlap.
 *
 * Conventions are those of sideray.h. */
#ifndef SIDERAY_TRACER_H
#define SIDERAY_TRACER_H

#include <sideray/scene.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sideray_tracer sideray_tracer;

typedef struct sideray_tracer_desc {
  size_t size;
  uint32_t threads; /* 0 = all processors */
  const char* isa;  /* NULL = best; "sse4.2", "avx2", "avx512" pin Embree's instruction set */
} sideray_tracer_desc;

SIDERAY_DEFAULTS(sideray_tracer_desc, tracer)
SIDERAY_API sideray_status sideray_tracer_create(sideray_scene* scene, const sideray_tracer_desc* desc,
                                                 sideray_tracer** tracer, sideray_error* error);
SIDERAY_API void sideray_tracer_retain(sideray_tracer* tracer);
SIDERAY_API void sideray_tracer_release(sideray_tracer* tracer);

typedef struct sideray_ray {
  double origin[3];
  float direction[3]; /* any length: distances are multiples of it */
  float t_near, t_far;
} sideray_ray;

typedef struct sideray_hit {
  double distance;     /* in lengths of the direction; +inf = no hit */
  float normal[3];     /* geometric, unit, on the side of the front face */
  float u, v;          /* barycentric weights of the second and third vertex */
  uint32_t surface_id; /* 0 = no hit */
  sideray_instance instance;
  uint32_t primitive; /* triangle's index in the mesh as added */
} sideray_hit;

typedef enum sideray_ray_set {
  SIDERAY_RAYS_OPAQUE = 0,     /* OPAQUE and MASK surfaces */
  SIDERAY_RAYS_TRANSLUCENT = 1 /* all translucent surfaces; culls and discards by alpha as the rasterizer does */
} sideray_ray_set;

/* A batch of rays and the memory for their hits. Strides are sizeof(sideray_ray) and sizeof(sideray_hit) as the caller
 * was compiled: fields that its structs lack are read as 0 and not written. */
typedef struct sideray_ray_batch {
  size_t size;
  sideray_ray_set set;
  uint32_t layers; /* 1..64: hits per ray */
  const sideray_ray* rays;
  size_t ray_stride_bytes;
  size_t count;
  /* hits[i * layers + k] is the k-th surface of ray i in the order (distance, surface id, primitive). Unused entries
   * have surface_id 0. */
  sideray_hit* hits;
  size_t hit_stride_bytes;
} sideray_ray_batch;

/* Opaque surfaces, one layer, no rays. */
static inline sideray_ray_batch sideray_ray_batch_defaults(void) {
  sideray_ray_batch batch = {sizeof(sideray_ray_batch), SIDERAY_RAYS_OPAQUE, 1, NULL, sizeof(sideray_ray), 0, NULL,
                             sizeof(sideray_hit)};
  return batch;
}

/* Traces the nearest hits of the batch's rays. A ray that is not finite is refused by index. */
SIDERAY_API sideray_status sideray_tracer_trace_rays(sideray_tracer* tracer, const sideray_ray_batch* batch,
                                                     sideray_error* error);

/* ---- Shading by the host ---- */

/* The space in which the host blends; layers are converted to it. sRGB and gamma use the same formula above 1. */
typedef enum sideray_radiance_space {
  SIDERAY_SPACE_LINEAR = 0,
  SIDERAY_SPACE_SRGB = 1,   /* the transfer function of sRGB */
  SIDERAY_SPACE_GAMMA22 = 2 /* x^(1/2.2): the content of a plain RGBA8 target in older engines */
} sideray_radiance_space;

/* A surface that a ray hit. Vectors are in world space; coordinates and colours are interpolated from vertices. */
typedef struct sideray_shading_point {
  double position[3];
  float to_eye[3];           /* unit, toward the ray's origin */
  float geometric_normal[3]; /* unit, the triangle's, on the side that the ray came from */
  float normal[3];           /* unit: interpolated, perturbed by the normal texture, turned to the same side */
  float tangent[4];          /* unit, w = +-1 bitangent sign of the front face; w = 0 without tangents */
  float uv0[2], uv1[2];      /* 0 if the mesh has none */
  /* A pixel's footprint on the triangle, in uv: (u, v) along its longer diameter, then along the shorter one. OpenGL's
   * mip level is log2 of the longer one's length in texels. */
  float uv0_footprint[4], uv1_footprint[4];
  float color[4];      /* of the vertices; 1 if the mesh has none */
  float base_color[4]; /* of the material: factor, texture and vertex colour; A is 1 unless it is BLEND */
  float emissive[3];   /* of the material: factor and texture */
  float distance;      /* along the ray, world units */
  float footprint;     /* a pixel's width at this point, across the ray, world units */
  float u, v;          /* barycentric weights of the second and third vertex */
  uint32_t primitive;  /* triangle's index in the mesh as added */
  sideray_instance instance;
  sideray_material material;
  uint32_t surface_id;
  uint64_t user; /* of the instance */
  /* Bit i: the point is within range and cone of the scene's light i (of the first 32, with an intensity above 0). For
   * lights in sideray_shader_desc::shadow_lights, a ray to the light's centre has also hit nothing opaque. `tints`
   * holds the transmittance of translucent surfaces. */
  uint32_t lights;
  uint32_t bounce;            /* 0: its reflection is traced; 1: seen in a mirror, or opaque behind bent glass */
  int32_t front, translucent; /* 1: its front face was hit; 1: its material is translucent */
  /* Transmittance of translucent surfaces between each of the scene's first 32 lights and this point: red, green, blue.
   * Valid during the call. NULL: 1 for all. */
  const float* tints;
} sideray_shading_point;

/* dst = C*a + dst*T, where C = radiance + reflectance * the light from direction `reflection`. The first value in each
 * comment is the field's value before the call. */
typedef struct sideray_shading_result {
  float radiance[3];      /* 0; below 0 reads as 0 */
  float alpha;            /* a, 0..1; the material's */
  float transmittance[3]; /* T, 0..1; the material's. Opaque surfaces use neither a nor T, cached layers neither */
  float reflectance[3];   /* 0 (no ray is traced); >= 0 */
  float reflection[3];    /* unit; the mirror direction about `normal`, lifted out of the surface if it leads in */
} sideray_shading_result;

#define SIDERAY_SHADING_BATCH 1024

typedef enum sideray_shader_thread {
  SIDERAY_SHADE_ON_WORKERS = 0, /* on tracing threads, several at once */
  /* One batch at a time, on the thread that is inside sideray_service_advance or _wait, sideray_tracer_trace_rays or
   * sideray_renderer_render. Until one of these is called, tracing waits. advance runs the pending batches; wait runs
   * batches until it returns. */
  SIDERAY_SHADE_IN_CALLS = 1
} sideray_shader_thread;

/* Reads points[0 .. count - 1] and fills as many results, 1..SIDERAY_SHADING_BATCH of them. Both arrays have the
 * strides of sideray_shader_desc, so the host can index them as its own structs; they are valid only during the call.
 * The function must return normally (no exception, no longjmp) and call neither OpenGL nor Sideray. Batches, their
 * order and their threads are unspecified: if a result depends only on its point, pictures have the same bits for any
 * number of threads. Denormals are treated as zero during the call. */
typedef void (*sideray_shade)(void* user, const sideray_shading_point* points, size_t count,
                              sideray_shading_result* results);

typedef struct sideray_shader_desc {
  size_t size;
  sideray_shade shade;
  void* user;
  sideray_shader_thread thread;
  uint32_t shadow_lights; /* bit i: sideray_shading_point::lights has a shadow ray for light i; 0 = no shadow rays */
  /* The space of the radiance that `shade` returns, which is mixed and passed on unconverted. The environment, where a
   * ray hits nothing else, is multiplied by radiance_scale (> 0) and converted to this space. The frame's
   * radiance_space and radiance_scale are not read. */
  sideray_radiance_space radiance_space;
  float radiance_scale;
  /* sizeof(sideray_shading_point) and sizeof(sideray_shading_result) as the host was compiled with them. */
  size_t point_stride_bytes, result_stride_bytes;
  /* Called once with `user` when nothing will call `shade` any more: the scene has another shader or is gone, and so
   * are all frames of commits with this shader. May run on any thread; must call neither OpenGL nor Sideray. NULL:
   * none. */
  void (*release)(void* user);
} sideray_shader_desc;

SIDERAY_API void sideray_shader_init(sideray_shader_desc* out, size_t size);
/* No function; on workers, no shadows, linear, scale 1. */
static inline sideray_shader_desc sideray_shader_defaults(void) {
  sideray_shader_desc filled;
  sideray_shader_init(&filled, sizeof(filled));
  filled.point_stride_bytes = sizeof(sideray_shading_point);
  filled.result_stride_bytes = sizeof(sideray_shading_result);
  return filled;
}

/* From the next commit on, `shader` replaces the built-in model wherever rays of a service's frames hit surfaces: in
 * layers, in reflections of layers and opaque surfaces, and behind refracting glass. References and sideray_renderer
 * keep the built-in model. NULL: the built-in model everywhere. `shade` and `user` must stay valid until every tracer,
 * service and renderer of the scene has finished the frames of that commit, or is gone; then `release` is called.
 * Cancelled and late frames start no more calls; abandon_context and destroy wait for running ones. A surface seen in a
 * mirror reflects only the environment; if it is translucent, it has no shadow rays. With `refraction`, transmittance
 * is the material's. A result that is not finite counts as black, with the material's a and T
 * (sideray_frame_stats::points_not_finite). `particles` is refused, because a host's shader cannot shade sprites. */
SIDERAY_API sideray_status sideray_scene_set_shader(sideray_scene* scene, const sideray_shader_desc* shader,
                                                    sideray_error* error);

#ifdef __cplusplus
}
#endif
#endif
