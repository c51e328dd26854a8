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
  uint32_t threads; /* 0 = all */
  const char* isa;  /* NULL = best; "sse4.2", "avx2", "avx512" pin Embree's instruction set */
} sideray_tracer_desc;

SIDERAY_DEFAULTS(sideray_tracer_desc, tracer)
SIDERAY_API sideray_status sideray_tracer_create(sideray_scene* scene, const sideray_tracer_desc* desc,
                                                 sideray_tracer** tracer, sideray_error* error);
SIDERAY_API void sideray_tracer_retain(sideray_tracer* tracer);
SIDERAY_API void sideray_tracer_release(sideray_tracer* tracer);

typedef struct sideray_ray {
  double origin[3];
  float direction[3]; /* need not be unit length: distances are in its lengths */
  float t_near, t_far;
} sideray_ray;

typedef struct sideray_hit {
  double distance;     /* in lengths of the direction; +inf = nothing hit */
  float normal[3];     /* geometric, unit, on the side of the front face */
  float u, v;          /* barycentric weights of the second and third vertex */
  uint32_t surface_id; /* 0 = nothing */
  sideray_instance instance;
  uint32_t primitive; /* triangle number within the mesh as given */
} sideray_hit;

typedef enum sideray_ray_set {
  SIDERAY_RAYS_OPAQUE = 0,     /* OPAQUE and MASK surfaces */
  SIDERAY_RAYS_TRANSLUCENT = 1 /* all translucent surfaces, cull rule and alpha discard as the rasterizer's */
} sideray_ray_set;

/* A batch of rays and where their hits go. Strides are sizeof(sideray_ray) and sizeof(sideray_hit) of the caller:
 * fields that its structs lack are read as 0 and not written. */
typedef struct sideray_ray_batch {
  size_t size;
  sideray_ray_set set;
  uint32_t layers; /* 1..64: hits of a ray */
  const sideray_ray* rays;
  size_t ray_stride_bytes;
  size_t count;
  /* hits[i * layers + k] is the k-th surface of ray i in the order (distance, surface id, primitive); unused entries
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

/* The space in which the host blends; layers are converted to it. sRGB and gamma continue above 1 by the same formula.
 * */
typedef enum sideray_radiance_space {
  SIDERAY_SPACE_LINEAR = 0,
  SIDERAY_SPACE_SRGB = 1,   /* the transfer function of sRGB */
  SIDERAY_SPACE_GAMMA22 = 2 /* x^(1/2.2): what engines of old write to a plain RGBA8 target */
} sideray_radiance_space;

/* A surface that a ray hit. Vectors are in world space; coordinates and colours are interpolated between vertices. */
typedef struct sideray_shading_point {
  double position[3];
  float to_eye[3];           /* unit, to where the ray came from */
  float geometric_normal[3]; /* unit, of the triangle, on the side that the ray came from */
  float normal[3];           /* unit: interpolated, bent by the material's normal texture, turned to the same side */
  float tangent[4];          /* unit, w = +-1 bitangent sign of the front face; w = 0: the mesh has none */
  float uv0[2], uv1[2];      /* 0 where the mesh has none */
  /* How far a pixel reaches over the triangle, in uv: (u, v) along its longer diameter, then along the other. OpenGL's
   * mip level is log2 of the longer of the two in texels. */
  float uv0_footprint[4], uv1_footprint[4];
  float color[4];      /* of the vertices; 1 where the mesh has none */
  float base_color[4]; /* of the material: factor, texture and vertex colour; A is 1 unless it is BLEND */
  float emissive[3];   /* of the material: factor and texture */
  float distance;      /* along the ray, world units */
  float footprint;     /* a pixel's width at this point, across the ray, world units */
  float u, v;          /* barycentric weights of the second and third vertex */
  uint32_t primitive;  /* triangle number within the mesh as given */
  sideray_instance instance;
  sideray_material material;
  uint32_t surface_id;
  uint64_t user; /* of the instance */
  /* Bit i: the point lies within range and cone of the scene's light i (of the first 32, with an intensity above 0).
   * For lights in sideray_shader_desc::shadow_lights a ray to the light's middle has also found nothing opaque in the
   * way. `tints` has what translucent surfaces let through. */
  uint32_t lights;
  uint32_t bounce;            /* 0: what it reflects is traced; 1: seen in a mirror, or opaque behind bent glass */
  int32_t front, translucent; /* 1: its front face was hit; its material is translucent */
  /* Red, green and blue for each of the scene's first 32 lights: the share that translucent surfaces let through to
   * this point; valid during the call. NULL: all of every light. */
  const float* tints;
} sideray_shading_point;

/* dst = C*a + dst*T, where C = radiance + reflectance * the light from direction `reflection`. The first value in each
 * comment is what the field holds before the call. */
typedef struct sideray_shading_result {
  float radiance[3];      /* 0; below 0 reads as 0 */
  float alpha;            /* a, 0..1: the material's */
  float transmittance[3]; /* T, 0..1: the material's. Opaque surfaces have neither; cached layers need neither */
  float reflectance[3];   /* 0: no ray is traced; >= 0 */
  float reflection[3];    /* unit: the mirror direction about `normal`; lifted out of the surface where it leads in */
} sideray_shading_result;

#define SIDERAY_SHADING_BATCH 1024

typedef enum sideray_shader_thread {
  SIDERAY_SHADE_ON_WORKERS = 0, /* on tracing threads, several at once */
  /* One at a time, on the thread that is inside sideray_service_advance or _wait, sideray_tracer_trace_rays or
   * sideray_renderer_render. Until one of these is called, tracing waits: advance runs the batches that are pending,
   * wait runs all batches until it times out. */
  SIDERAY_SHADE_IN_CALLS = 1
} sideray_shader_thread;

/* Reads points[0 .. count - 1] and fills as many results, 1..SIDERAY_SHADING_BATCH of them. Both arrays have the
 * strides of sideray_shader_desc, so that a host indexes them as its own structs; they are valid during the call only.
 * The function returns normally (no exception, no longjmp) and calls neither OpenGL nor Sideray. Batches, their order
 * and their threads are unspecified: if a result depends on its point alone, pictures have the same bits for any number
 * of threads. Denormals are zero while it runs. */
typedef void (*sideray_shade)(void* user, const sideray_shading_point* points, size_t count,
                              sideray_shading_result* results);

typedef struct sideray_shader_desc {
  size_t size;
  sideray_shade shade;
  void* user;
  sideray_shader_thread thread;
  uint32_t shadow_lights; /* bit i: sideray_shading_point::lights is traced for light i; 0 = no shadow rays */
  /* The space of the radiance that `shade` returns. It is mixed and passed on unconverted. The environment, where a ray
   * hits nothing else, is multiplied by the scale (> 0) and converted to this space. The frame's radiance_space and
   * radiance_scale are not read. */
  sideray_radiance_space radiance_space;
  float radiance_scale;
  /* sizeof(sideray_shading_point) and sizeof(sideray_shading_result) as the host was compiled with them. */
  size_t point_stride_bytes, result_stride_bytes;
  /* Called once with `user` when no tracer, service or renderer will call `shade` any more: the scene has another
   * shader or is gone, and so are all frames of commits that had this one. On any thread; it calls neither OpenGL nor
   * Sideray. NULL: none. */
  void (*release)(void* user);
} sideray_shader_desc;

SIDERAY_API void sideray_shader_init(sideray_shader_desc* out, size_t size);
/* No function, on workers, no shadows, linear, scale 1. */
static inline sideray_shader_desc sideray_shader_defaults(void) {
  sideray_shader_desc filled;
  sideray_shader_init(&filled, sizeof(filled));
  filled.point_stride_bytes = sizeof(sideray_shading_point);
  filled.result_stride_bytes = sizeof(sideray_shading_result);
  return filled;
}

/* From the next commit on `shader` replaces the built-in model wherever rays of a service's frames hit surfaces:
 * layers, what they and opaque surfaces reflect, and what is behind refracting glass. References and sideray_renderer
 * keep the model. NULL: the model everywhere. `shade` and `user` must stay valid until every tracer, service and
 * renderer of the scene has finished the frames of that commit, or is gone; `release` is called then. Cancelled and
 * late frames start no more calls; abandon_context and destroy wait for calls under way. A surface that is seen in a
 * mirror reflects the environment alone; if it is translucent it has no shadow rays. With `refraction`, transmittance
 * is the material's. A result that is not finite counts as black, with the material's a and T
 * (sideray_frame_stats::points_not_finite). `particles` is refused: the host's shader knows no sprites. */
SIDERAY_API sideray_status sideray_scene_set_shader(sideray_scene* scene, const sideray_shader_desc* shader,
                                                    sideray_error* error);

#ifdef __cplusplus
}
#endif
#endif
