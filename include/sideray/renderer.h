/* The offscreen tier: a renderer that draws whole pictures, in a headless context of its own or in the host's. Calls on
 * one renderer must not overlap.
 *
 * Conventions are those of sideray.h. */
#ifndef SIDERAY_RENDERER_H
#define SIDERAY_RENDERER_H

#include <sideray/service.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sideray_renderer sideray_renderer;

/* A headless device. Structs that the library returns by pointer have no size field and grow at their end. */
typedef struct sideray_device_info {
  const char* id; /* stable name to pass to sideray_renderer_create */
  const char* gl; /* "egl", "osmesa", "host" or "none" */
  const char* renderer;
  const char* version;
  int32_t usable;
  const char* reason; /* why it cannot be used, and the remedy; empty if usable */
} sideray_device_info;

typedef struct sideray_device_list sideray_device_list;

/* Tries every headless device. The caller owns the list; its entries live as long as it does. */
SIDERAY_API sideray_status sideray_devices(sideray_device_list** devices, sideray_error* error);
SIDERAY_API size_t sideray_device_count(const sideray_device_list* devices);
SIDERAY_API const sideray_device_info* sideray_device_at(const sideray_device_list* devices, size_t index);
SIDERAY_API void sideray_devices_free(sideray_device_list* devices); /* NULL is allowed */

typedef struct sideray_renderer_desc {
  size_t size;
  /* "auto", "egl", "osmesa", or "none": rays alone draw, and no OpenGL library is opened. "auto": the value of the
   * environment variable SIDERAY_GL, else any OpenGL device; if there is none, it is "none", and the device's `reason`
   * says why. */
  const char* gl;
  const char* device; /* an id from sideray_devices, or NULL */
  uint32_t threads;   /* 0 = all */
  const char* isa;    /* as in sideray_tracer_desc */
  /* Not NULL: the renderer draws in the host's context, which must be current in every call, destroy included; `gl` and
   * `device` are not read. It needs OpenGL 3.3; all state that a call touches is restored exactly. No query of samples
   * (it is refused), transform feedback, conditional rendering or GL_EXT_depth_bounds_test may be active, because they
   * would count, capture or clip the drawing. NULL: it owns a headless context. */
  const sideray_host_gl* host;
} sideray_renderer_desc;

/* Any device, all threads, the best instruction set, a context of its own. */
SIDERAY_DEFAULTS(sideray_renderer_desc, renderer)
SIDERAY_API sideray_status sideray_renderer_create(const sideray_renderer_desc* desc, sideray_renderer** renderer,
                                                   sideray_error* error);
SIDERAY_API void sideray_renderer_destroy(sideray_renderer* renderer);
/* Returns the renderer's device, which lives as long as the renderer. */
SIDERAY_API sideray_status sideray_renderer_device(sideray_renderer* renderer, const sideray_device_info** device,
                                                   sideray_error* error);

typedef struct sideray_camera {
  size_t size;
  /* Four columns of three: a rotation, whose columns are unit vectors and orthogonal to within 1e-3, then the position,
   * at most 1e15; others are refused. The camera looks along -Z, +Y is up. */
  double world_from_camera[12];
  int32_t orthographic;
  float yfov;          /* full vertical angle, perspective */
  float half_height;   /* world units, orthographic */
  float z_near, z_far; /* > 0; z_far 0 = infinite (perspective only) */
  /* For intrinsics fx, fy, cx, cy in pixels of a width x height picture, from its top left corner: fx_per_fy = fx / fy,
   * yfov = 2 atan(height / (2 fy)), shift_x = cx / width - 1/2, shift_y = cy / height - 1/2. */
  float fx_per_fy;        /* 1e-3..1e3; 0 = 1, square pixels */
  float shift_x, shift_y; /* principal point minus picture's middle, right in widths and down in heights; +-100 */
} sideray_camera;

/* At the origin, perspective, 45 degrees high, from 0.1 to infinity, square pixels, centred. */
SIDERAY_DEFAULTS(sideray_camera, camera)

typedef enum sideray_translucency {
  SIDERAY_TRANSLUCENCY_OFF = 0,
  SIDERAY_TRANSLUCENCY_RASTER = 1,
  SIDERAY_TRANSLUCENCY_RAYTRACED = 2,
  SIDERAY_TRANSLUCENCY_HYBRID = 3,
  SIDERAY_TRANSLUCENCY_REFERENCE = 4 /* opaque surfaces rasterized, translucent ones as in `reference` */
} sideray_translucency;

typedef enum sideray_shadows {
  SIDERAY_SHADOWS_OFF = 0,
  SIDERAY_SHADOWS_MAP = 1,
  SIDERAY_SHADOWS_EXACT = 2,  /* masks of opaque pixels by rays, one a light */
  SIDERAY_SHADOWS_INEXACT = 3 /* the same, with the inexact test for pixels of its target */
} sideray_shadows;

/* Which pixels take the inexact test. */
typedef enum sideray_inexact_target {
  SIDERAY_TARGET_MODEL = 0,  /* two-sided foliage in the shading model: leaves, not trunks */
  SIDERAY_TARGET_BIT = 1,    /* a bit in the G-buffer: marked materials and instances moved by wind */
  SIDERAY_TARGET_STENCIL = 2 /* the same objects, by a separate pass into the stencil with depth function EQUAL */
} sideray_inexact_target;

/* Special values of sideray_pose_options::poses. */
#define SIDERAY_POSES_REST 0u        /* rays hit the neutral pose, which is the mesh itself */
#define SIDERAY_POSES_ALL UINT32_MAX /* rays hit every instance in its own pose, as it is drawn */

typedef enum sideray_mask { SIDERAY_NO_MASK = 0, SIDERAY_STENCIL_MASK = 1, SIDERAY_COUNT_MASK = 2 } sideray_mask;

/* The order in which translucent fragments are blended, whether their colour is cached or rasterized. */
typedef enum sideray_oit {
  SIDERAY_OIT_SORTED = 0,  /* whole objects, back to front */
  SIDERAY_OIT_ABUFFER = 1, /* all fragments in lists, sorted; OpenGL 4.3 */
  SIDERAY_OIT_PEEL = 2     /* depth peeling to the last fragment */
} sideray_oit;

enum { /* additional outputs */
       SIDERAY_AOV_Z = 1u,
       SIDERAY_AOV_NORMAL = 2u,
       SIDERAY_AOV_ALBEDO = 4u,
       SIDERAY_AOV_MATERIAL = 8u,
       SIDERAY_AOV_ID = 16u,
       SIDERAY_AOV_MASK = 32u,
       SIDERAY_AOV_LAYERS = 64u,
       SIDERAY_AOV_SHADOW = 128u,
       SIDERAY_AOV_HIT_DISTANCE = 256u,
       SIDERAY_AOV_MOTION = 512u,
       SIDERAY_AOV_INEXACT = 1024u, /* pixels that take the inexact shadow test */
       /* Ground truth by rays through the pixels' centres (docs/ground-truth.md); ground_truth.h has more. */
       SIDERAY_AOV_FIRST = 2048u,      /* the first surface, translucent or not: first.* */
       SIDERAY_AOV_GLASS = 4096u,      /* the first translucent surface: glass.* */
       SIDERAY_AOV_BEHIND = 8192u,     /* the opaque surface at the end of the refracted path: behind.* */
       SIDERAY_AOV_REFRACTION = 16384u, /* where that place would be in the picture without glass: refraction.* */
       /* What rays contributed to each pixel: answer.lights, .sky, .reflections and .layers, as far as they are traced.
        * 0 = it needs none; 1 = missing, drawn as without rays; 2 = traced for this picture; 3 + N = from an earlier
        * picture, N relevant changes ago. */
       SIDERAY_AOV_ANSWERS = 32768u
};

/* The plan chooses ray_reuse: 1/64, divided by 2^exposure for exposures above 0; 0 if it is not supported.
 * sideray_plan_ray_reuse returns the chosen value. */
#define SIDERAY_RAY_REUSE_AUTO (-1.0f)

/* Traces reflections if some opaque surface is smooth enough (docs/adr/0034-opaque-rays.md); sideray_plan_reflections
 * returns the choice. */
#define SIDERAY_REFLECTIONS_AUTO (-1)

/* Light of opaque surfaces that does not come directly from lamps. */
typedef enum sideray_ambient {
  SIDERAY_AMBIENT_AUTO = -1,  /* BOUNCE if the scene has light, else OFF: see sideray_plan_ao, sideray_plan_bounce */
  SIDERAY_AMBIENT_OFF = 0,    /* the unoccluded sky */
  SIDERAY_AMBIENT_AO = 1,     /* the sky, through an ambient occlusion mask */
  SIDERAY_AMBIENT_BOUNCE = 2  /* the same, and light that surfaces reflect onto each other: docs/light.md */
} sideray_ambient;

/* How translucent surfaces are drawn. */
typedef struct sideray_translucency_options {
  size_t size;
  sideray_translucency method;
  uint32_t layers;      /* HYBRID 0..8; RAYTRACED 1..64, or 0 = unlimited */
  sideray_mask mask;    /* HYBRID and RAYTRACED */
  sideray_match match;  /* HYBRID, as the next three */
  float match_threshold; /* share of the distance, > 0 */
  sideray_cache_rate cache_rate;
  int32_t second_wave; /* trace pixels for which no neighbour has an answer */
  sideray_step step; /* HYBRID and RAYTRACED */
  /* refraction: volumes refract the light behind them and rough surfaces blur it, by rays; RASTER, and surfaces without
   * a layer, refract the picture of opaque surfaces. particles, for RAYTRACED: rays hit sprites. */
  int32_t refraction, particles;
  sideray_oit oit;               /* RASTER and HYBRID */
  uint32_t light_samples;        /* REFERENCE: light and microfacet samples of each camera position, 1..2^20 */
  int32_t check;                 /* HYBRID: count wrong answers, against all surfaces found by rays */
  /* HYBRID: pixels whose cache holds every surface are composited along the ray and drawn at once
   * (sideray_layer_inputs::whole_pixels). Needs an `oit` of SORTED or ABUFFER, a COUNT mask and FULL rate. */
  int32_t whole_pixels;
  /* HYBRID and RAYTRACED: sideray_layer_inputs::ray_reuse, or SIDERAY_RAY_REUSE_AUTO. Above 0 it excludes a shader of
   * the host and any `cache_rate` but FULL; RAYTRACED with refraction reuses nothing. */
  float ray_reuse;
  uint32_t bounces;    /* REFERENCE: sideray_reference_options::bounces */
} sideray_translucency_options;

/* HYBRID of 4 layers at full rate in sorted order, refracted, with a ray reuse of AUTO; 64 light samples, 1 bounce. */
SIDERAY_DEFAULTS(sideray_translucency_options, translucency)

/* Shadows of lights on opaque surfaces. */
typedef struct sideray_shadow_options {
  size_t size;
  sideray_shadows method;
  sideray_inexact inexact; /* INEXACT, as the next two */
  float inexact_bias;
  sideray_inexact_target inexact_target;
  float bias; /* sideray_mask_inputs::shadow_bias; EXACT and INEXACT */
} sideray_shadow_options;

/* INEXACT by rest poses. */
SIDERAY_DEFAULTS(sideray_shadow_options, shadow)

/* Which geometry rays hit. */
typedef struct sideray_pose_options {
  size_t size;
  uint32_t poses;       /* of plants in the wind: 1..256 that the instances of a mesh share, or SIDERAY_POSES_* */
  float cull_angle_deg; /* instances whose bounding sphere subtends less are not traced; 0 = none */
} sideray_pose_options;

/* 16 shared poses a mesh; nothing is culled for its size. */
SIDERAY_DEFAULTS(sideray_pose_options, pose)

/* Draws everything by rays, exact and unlimited: lights have their sizes, environment and microfacets are sampled. */
typedef struct sideray_reference_options {
  size_t size;
  uint32_t light_samples; /* light and microfacet samples of each camera position, 1..2^20 */
  int32_t refraction;
  /* How many times surfaces may reflect light before it reaches the camera. 1: direct light, the unoccluded
   * environment, and one mirror ray of translucent surfaces: the equations that all other ways of drawing approximate.
   * 2..65536: paths, on which surfaces light each other and occlude the environment; 0: paths of any length. Passing
   * through a surface is not a bounce. */
  uint32_t bounces;
  /* Paths: how light of lamps and emissive surfaces passes glass. 0: straight and tinted, as in all other ways of
   * drawing. 1: light of sources with a size is refracted and mirrored, which makes caustics. The environment and discs
   * of 5 degrees and more are always refracted. */
  int32_t caustics;
} sideray_reference_options;

/* 64 samples, with refraction, 1 bounce, without caustics of lamps. */
SIDERAY_DEFAULTS(sideray_reference_options, reference)

/* The number of sample positions in the pixel that a sequence with temporal anti-aliasing uses in turn. */
enum { SIDERAY_JITTER_PERIOD = 8 };

typedef struct sideray_render_options {
  size_t size;
  uint32_t width, height; /* 1..16384 each */
  uint32_t samples;       /* camera positions per pixel, averaged; 1 = the pixel centre */
  uint32_t seed;
  const sideray_translucency_options* translucency; /* NULL: translucent surfaces are not drawn */
  const sideray_shadow_options* shadows;            /* NULL: lights are visible everywhere, without shadows */
  const sideray_pose_options* poses;                /* NULL: every instance is traced in its drawn pose */
  /* NULL: off. Otherwise everything is drawn by rays: of `shadows` only NULL or not matters, and translucency, poses
   * and `denoise` are not read. */
  const sideray_reference_options* reference;
  /* Traced reflections of opaque surfaces: 0, 1, or SIDERAY_REFLECTIONS_AUTO, which is 0 in a reference. */
  int32_t reflections;
  int32_t ambient; /* a sideray_ambient; ignored by references, whose paths compute that light */
  int32_t denoise;         /* filters masks and ray-traced rough reflections */
  int32_t taa;             /* with `continues`: average with earlier frames along motion vectors */
  /* 1: the picture follows the last one that this renderer drew in a sequence, and temporal methods may use its
   * results. 0: a single picture, or the first. */
  int32_t continues;
  float deadline_ms; /* sideray_frame_inputs::deadline_ms; 0 = none */
  uint32_t aovs;     /* SIDERAY_AOV_*, of sample 0 */
  /* 0: statistics are those of the drawn frame. N: the frame is drawn N more times to time its stages, and once to
   * count its fragments. */
  uint32_t repeats;
  const sideray_diagnostics* diagnostics; /* NULL: none */
  /* The exposure at which the picture will be shown, in stops, -64..64. It is not applied, because pictures hold linear
   * radiance, but bounds such as SIDERAY_RAY_REUSE_AUTO apply to displayed values. */
  float exposure;
  float budget_ms; /* sideray_frame_inputs::budget_ms; 0 = none. Not with deadline_ms */
  /* 1: the picture has no R, G, B and A, and nothing is lit: only depth, ids and the `aovs`, in less time. Not with
   * `reference`. */
  int32_t without_color;
} sideray_render_options;

/* 1280x720, and the defaults of its parts; its pointers point to constants of the library. Reflections and ambient
 * occlusion are AUTO. Filtered. No reference. */
SIDERAY_DEFAULTS(sideray_render_options, render)

typedef enum sideray_stage {
  SIDERAY_STAGE_LOAD = 0, /* filled by the program that loads */
  SIDERAY_STAGE_BUILD,
  SIDERAY_STAGE_UPDATE,
  SIDERAY_STAGE_GBUFFER,
  SIDERAY_STAGE_SHADOW_MAP,
  SIDERAY_STAGE_MASK,
  SIDERAY_STAGE_READBACK,
  SIDERAY_STAGE_TRACE,
  SIDERAY_STAGE_TRACE_SHADOW,
  SIDERAY_STAGE_TRACE_AO,
  SIDERAY_STAGE_DENOISE,
  SIDERAY_STAGE_UPLOAD,
  SIDERAY_STAGE_LIGHT,
  SIDERAY_STAGE_COMPOSITE,
  SIDERAY_STAGE_TOTAL_FRAME,
  /* This is the time of a frame that reuses the shadow maps of everything at rest; TOTAL_FRAME draws all of them anew. It
   * is 0 without shadow maps. */
  SIDERAY_STAGE_KEPT_FRAME,
  SIDERAY_STAGE_FORCE_32 = 0x7fffffff /* later versions may have more */
} sideray_stage;

/* One timed stage, milliseconds. */
typedef struct sideray_stage_time {
  sideray_stage stage;
  const char* name; /* as in the program's statistics: "shadow_map"; valid for ever */
  double p25, median, p75;
} sideray_stage_time;

/* docs/cli.md defines every figure. Without `repeats`, layers_matched and layers_missed are counted only with `check`,
 * and only the stages LOAD, BUILD, UPDATE, TRACE, TRACE_SHADOW, TRACE_AO, DENOISE and TOTAL_FRAME have times: those of
 * the drawn picture. */
typedef struct sideray_render_stats {
  size_t size;
  uint32_t repeats;
  uint64_t triangles, instances, materials, translucent_objects;
  uint64_t rays_primary, rays_reflection, rays_shadow, rays_ao;
  uint64_t pixels_total, pixels_masked;
  uint64_t layers_requested, layers_found, layers_matched, layers_missed, traversals_wasted;
  uint64_t layers_misassigned, layers_duplicated; /* with `check` */
  uint64_t pixels_late;
  uint64_t dropped_particles;
  uint64_t bytes_readback, bytes_upload, bytes_cache;
  uint32_t reference_light_samples; /* 0: no part of the picture is a reference */
  double reference_self_error; /* relMSE between two independent halves of the samples; negative: only one sample */
  uint32_t threads;
  char isa[16];
  char embree[32];
  uint64_t layers_borrowed; /* as in sideray_frame_stats */
  uint64_t layers_refracted; /* as in sideray_frame_stats */
  /* The share of the worst thousandth of pixels in reference_self_error; negative: only one sample. Near 1 a few
   * fireflies make up the error, and another seed would change it much. */
  double reference_firefly_share;
  uint32_t reference_bounces; /* 0 = unlimited, or no part of the picture is a reference */
  int32_t reference_caustics; /* sideray_reference_options::caustics */
  uint64_t pixels_older, mask_pixels_late, mask_pixels_older, answer_age; /* as in sideray_frame_stats */
  /* Camera positions averaged in the picture: `samples`, or those that a view at rest has accumulated. */
  uint64_t positions;
  uint64_t reflection_pixels_late, reflection_pixels_older, jobs_starved; /* as in sideray_frame_stats */
  uint64_t rays_bounce, irradiance_pixels_late, irradiance_pixels_older;  /* as in sideray_frame_stats */
} sideray_render_stats;

typedef enum sideray_channel_type { SIDERAY_CHANNEL_FLOAT = 0, SIDERAY_CHANNEL_UINT = 1 } sideray_channel_type;

/* One named plane of a picture: width * height values, TOP row first. Names are listed in docs/cli.md (R, G, B, A, Z,
 * ...). */
typedef struct sideray_channel {
  const char* name;
  sideray_channel_type type;
  const void* values;
} sideray_channel;

typedef struct sideray_picture sideray_picture;

/* Draws the committed scene. The caller owns the picture and releases it by sideray_picture_release. */
SIDERAY_API sideray_status sideray_renderer_render(sideray_renderer* renderer, sideray_scene* scene,
                                                   const sideray_camera* camera, const sideray_render_options* options,
                                                   sideray_picture** picture, sideray_error* error);
/* Draws `count` pictures of the committed scene, one for each camera, each as sideray_renderer_render would draw it
 * alone. Shared work is done once: the scene is updated, and without OpenGL each thread draws a picture of its own if
 * they are small. Cameras are contiguous and all have the `size` of the first. `continues`, `repeats`, budgets and
 * deadlines are refused. `pictures` has `count` elements; the caller owns each picture. A failure returns none. */
SIDERAY_API sideray_status sideray_renderer_render_many(sideray_renderer* renderer, sideray_scene* scene,
                                                        const sideray_camera* cameras, size_t count,
                                                        const sideray_render_options* options, sideray_picture** pictures,
                                                        sideray_error* error);
/* Cancels the picture that another thread is drawing with the renderer: its call returns SIDERAY_CANCELLED after the
 * current tiles, but acceleration structures are first built to their end. The next picture continues none. Does
 * nothing if nothing is being drawn. Any thread. */
SIDERAY_API void sideray_renderer_cancel(sideray_renderer* renderer);
SIDERAY_API void sideray_picture_release(sideray_picture* picture);
SIDERAY_API void sideray_picture_size(const sideray_picture* picture, uint32_t* width, uint32_t* height);
/* Channels, stages and their strings live as long as the picture; NULL for an index beyond the last. */
SIDERAY_API size_t sideray_picture_channel_count(const sideray_picture* picture);
SIDERAY_API const sideray_channel* sideray_picture_channel(const sideray_picture* picture, size_t index);
/* Every stage once, in the order of sideray_stage. */
SIDERAY_API size_t sideray_picture_stage_count(const sideray_picture* picture);
SIDERAY_API const sideray_stage_time* sideray_picture_stage(const sideray_picture* picture, size_t index);
/* Fills the first `size` bytes of `stats`; the caller sets `size`. */
SIDERAY_API sideray_status sideray_picture_stats(const sideray_picture* picture, sideray_render_stats* stats,
                                                 sideray_error* error);

#ifdef __cplusplus
}
#endif
#endif
