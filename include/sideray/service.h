/* The service: rays for a host's frame. It moves depth, stencil and results between the host's OpenGL context and a
 * tracer. Calls on one service must not overlap; the host's context is current in each.
 *
 * Conventions are those of sideray.h. */
#ifndef SIDERAY_SERVICE_H
#define SIDERAY_SERVICE_H

#include <sideray/tracer.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sideray_service sideray_service;
typedef struct sideray_diagnostics sideray_diagnostics; /* diagnostics.h */

/* A camera, given by the host's matrices: perspective (also off-axis) or orthographic; the matrix says which. Distances
 * are measured along the view ray from the eye (perspective) or the near plane (orthographic). This struct never grows.
 * */
typedef struct sideray_view {
  double clip_from_world[16];
  double world_from_clip[16];
  int32_t reversed_depth;    /* window depth 1 is near */
  int32_t zero_to_one_depth; /* clip space z runs 0..w (glClipControl) instead of -w..w */
} sideray_view;

/* Makes a view of OpenGL's column-major matrices, clip from eye and eye from world; reversed_depth and
 * zero_to_one_depth are 0. Refuses matrices without an inverse or an eye: they are transposed, or in the wrong order.
 * */
SIDERAY_API sideray_status sideray_view_from_matrices(const double projection[16], const double modelview[16],
                                                      sideray_view* view, sideray_error* error);

typedef enum sideray_mask_source {
  SIDERAY_MASK_NONE = 0,    /* trace every pixel */
  SIDERAY_MASK_STENCIL = 1, /* trace where (stencil & stencil_bits) != 0 */
  SIDERAY_MASK_COUNT = 2,   /* the same, and the value counts the layers there, all bits set = at least that many */
  /* The same from one byte a pixel: 0 = nothing, 255 = trace, others count the layers. For targets without stencil. */
  SIDERAY_MASK_TEXTURE = 3, /* mask_texture */
  SIDERAY_MASK_MEMORY = 4,  /* mask_texels */
  SIDERAY_MASK_FORCE_32 = 0x7fffffff
} sideray_mask_source;

typedef enum sideray_service_mode {
  SIDERAY_CACHE = 0,    /* fill the layer cache for sideray_translucent() (hybrid translucency) */
  SIDERAY_COMPOSITE = 1 /* composite up to max_layers surfaces in ray order (fully ray-traced translucency) */
} sideray_service_mode;

/* How a fragment finds its layer, within the tolerance by which rasterizer and rays may differ (docs/architecture.md).
 * diagnostics.h has one more value. */
typedef enum sideray_match {
  SIDERAY_MATCH_ID = 0,      /* the same surface id, then the nearest distance */
  SIDERAY_MATCH_NEAREST = 1, /* the nearest distance of any surface */
  SIDERAY_MATCH_FORCE_32 = 0x7fffffff
} sideray_match;

/* How a ray finds its surfaces. diagnostics.h has one more value. */
typedef enum sideray_step {
  SIDERAY_STEP_MULTIHIT = 0, /* several in one traversal, in a total order */
  SIDERAY_STEP_RETRACE = 1,  /* one traversal a surface, in the same order */
  SIDERAY_STEP_FORCE_32 = 0x7fffffff
} sideray_step;

/* Which masked pixels are traced; the others take layers of their neighbours, of the same surface and in its plane
 * (sideray_find() of the snippet). */
typedef enum sideray_cache_rate {
  SIDERAY_RATE_FULL = 0,
  SIDERAY_RATE_CHECKERBOARD = 1,
  SIDERAY_RATE_INTERLEAVED = 2, /* every other row */
  SIDERAY_RATE_QUARTER = 3,     /* one of 2x2 */
  SIDERAY_RATE_TEMPORAL4 = 4,   /* deprecated like the next one: both mean FULL, until 0.4 */
  SIDERAY_RATE_TEMPORAL8 = 5
} sideray_cache_rate;

/* How shadow rays of marked pixels deal with plants that rays hit in another pose than the drawn one (RTG2 50.3.2). B
 * is sideray_mask_inputs::inexact_bias, u a random number in 0..1. diagnostics.h has one more value. */
typedef enum sideray_inexact {
  SIDERAY_EXACT = 0,
  SIDERAY_INEXACT_TMIN = 1,     /* hits nearer than u * B do not count (listing 50-3) */
  SIDERAY_INEXACT_BOUNDED = 2,  /* the same; B is the largest distance by which wind moves the pixel */
  SIDERAY_INEXACT_RESTPOSE = 3, /* the ray starts at the pixel's undeformed position */
  SIDERAY_INEXACT_FORCE_32 = 0x7fffffff
} sideray_inexact;

typedef uint64_t sideray_ticket; /* 0 is never a ticket */

/* Who restores the OpenGL state that a frame changes. */
typedef enum sideray_state_policy {
  SIDERAY_SAVE_AND_RESTORE = 0, /* it is put back exactly */
  /* No state is read, and what was changed is left at OpenGL's initial values: nothing bound, no program, unit 0
   * active; viewports are undefined. docs/embedding.md lists it call by call. For engines that set what they need, and
   * for threaded drivers, which stall when state is read. */
  SIDERAY_HOST_RESTORES = 1
} sideray_state_policy;

enum { SIDERAY_MAX_VIEWS = 16 };

/* Where a frame's depth and mask are read. This struct never grows: its last field is reserved. */
typedef struct sideray_frame_source {
  uint32_t framebuffer; /* GL name holding depth (and stencil); 0 allowed; of a multisampled one, one sample is read */
  /* One image in place of `framebuffer`, where it is not 0; depth, or depth and stencil. */
  uint32_t depth_texture;
  uint32_t depth_texture_target; /* GL_TEXTURE_2D (the default), _2D_ARRAY, _2D_MULTISAMPLE or _RECTANGLE */
  int32_t depth_layer;           /* of an array */
  uint32_t depth_renderbuffer;
  int32_t x, y, width, height; /* the rectangle of it that the view covers; within it */
  sideray_mask_source mask;
  uint32_t stencil_bits;      /* contiguous from bit 0, for example 0x3f */
  uint32_t mask_texture;      /* SIDERAY_MASK_TEXTURE: R8 2D of the framebuffer's size */
  const uint8_t* mask_texels; /* SIDERAY_MASK_MEMORY: of the rectangle, read within submit */
  size_t mask_row_bytes;
  /* RG32F or RG16F 2D of the framebuffer's size, read by masks of frames that continue: the pixel's position minus that
   * of the same surface point in the previous frame, in pixels. 0 = only the view has moved. */
  uint32_t motion_texture;
  uint32_t reserved[15]; /* 0 */
} sideray_frame_source;

/* Layers of translucent surfaces. */
typedef struct sideray_layer_inputs {
  size_t size;
  sideray_service_mode mode;
  uint32_t max_layers;     /* CACHE 1..8; COMPOSITE 1..64, or 0 = unlimited */
  int32_t all_translucent; /* also instances without SIDERAY_VISIBLE_LAYERS */
  sideray_step step;
  sideray_match match;           /* CACHE: what sideray_service_bind sets up */
  float match_threshold;         /* SIDERAY_MATCH_DISTANCE: share of the distance, > 0 */
  sideray_cache_rate cache_rate; /* CACHE, as the next three */
  sideray_radiance_space radiance_space;
  float radiance_scale; /* > 0: radiance is multiplied by it before the transfer function */
  int32_t float_ids;    /* surface ids as floats in R32F, below 2^24: for GLSL 1.20; always, without integer textures */
  int32_t denoise;      /* CACHE: what rough surfaces reflect is filtered */
  /* Volumes refract what is seen through them, and rough surfaces blur it. CACHE: the first such surface of a pixel is
   * resolved if it is one of the max_layers: its layer holds everything seen through it, and nothing behind it may be
   * drawn (sideray_look_up() of the snippet). Its distance is stored as a negative number. */
  int32_t refraction;
  int32_t particles;       /* COMPOSITE: rays hit sprites, as quads that face the eye */
  uint32_t requested_bits; /* with adds_to; outside stencil_bits, for example 0x40 where sideray_asks() holds */
  /* CACHE: the ticket of a frame at a reduced cache_rate, of which this frame is the second wave; all other inputs are
   * those of that frame. It must be the newest finished frame, and nothing else may be in flight. Its layers stay, and
   * pixels whose stencil has one of `requested_bits` are traced and added. 0 = a frame of its own. */
  sideray_ticket adds_to;
  /* CACHE: pixels of which the cache holds as many surfaces as the mask counts are also composited along the ray, in
   * exact order: sideray_layer_outputs::whole_radiance_texture. Needs a mask that counts, FULL rate, LINEAR space with
   * a scale of 1, and no shader of the host. */
  int32_t whole_pixels;
  /* Whole pixels: stencil bits outside stencil_bits, one of which the host sets wherever it draws something translucent
   * that the mask does not count; such pixels are not whole. 0 = it draws nothing of the kind. */
  uint32_t others_bits;
  /* One pixel of four traces the shadow and reflection rays of its layers. The others reuse the results of these donors on
   * the same surface, unless the donors differ by more than this much radiance in what a layer adds to its pixel: then the
   * pixel traces its own rays. 0 = every layer traces its own. At FULL rate; not with a COMPOSITE of `refraction`, nor with a
   * shader of the host. */
  float ray_reuse;
  /* COMPOSITE: above 0, surfaces are shaded as in references (sideray_reference_options), with this many samples, at
   * most 2^20, of each light with a size, of the environment and of microfacets. Not with a shader of the host. */
  uint32_t light_samples;
  uint32_t bounces; /* with light_samples: sideray_reference_options::bounces */
} sideray_layer_inputs;

/* CACHE of 4 layers at full rate, matched by id, filtered; every layer traces its own rays; 1 bounce. */
SIDERAY_DEFAULTS(sideray_layer_inputs, layer_inputs)

/* Masks of opaque pixels: the share of each light, and of the sky, that they see. */
typedef struct sideray_mask_inputs {
  size_t size;
  uint32_t shadow_lights; /* bit i: light i of the scene, of its first 32, has a mask of its own */
  /* One more mask for all lights from the 33rd on: the share of their combined light that arrives at the pixel. One ray
   * a pixel goes to one of these lights, drawn by how much it adds. */
  int32_t combined_lights;
  sideray_inexact inexact; /* of pixels whose stencil has one of inexact_bits */
  float inexact_bias;      /* B, world units, >= 0 */
  uint32_t inexact_bits;   /* outside stencil_bits, for example 0x80; 0 = no pixel */
  uint32_t rest_texture;   /* RESTPOSE, BOUNDED: RGBA32F 2D of the framebuffer's size; xyz = undeformed position minus
                            * the drawn one, world units; w unused. 0 = none */
  /* Moves the start of rays farther off the surface, along its normal: world units, >= 0. The error of the depth buffer
   * is covered without it; use it if the drawn and the traced tessellation differ. */
  float shadow_bias;
  uint32_t ao_rays;  /* 0 = no ambient occlusion mask */
  float ao_distance; /* world units, > 0; +inf = unlimited */
  int32_t denoise;
  /* The same in steps of the depth format, >= 0: rays start this many values of the depth buffer nearer to the eye, in
   * addition to what is always allowed for (docs/embedding.md). It grows with distance as the depth's own error does.
   * For drivers and geometry whose depth is less exact than its format. */
  float shadow_bias_steps;
  /* A threshold on the radiance that a light adds to a white matt surface facing it: where it adds less, the light's
   * own mask is lit without a ray. Directional lights always trace theirs. 0 = rays go wherever the light reaches.
   * docs/adr/0039-least-light.md says what it saves. */
  float least_light;
  /* 1: ambient occlusion rays are distributed by the environment's light, for hosts that light by it; 0: by the cosine
   * alone. */
  int32_t ao_by_light;
  /* With ao_rays, one more layer of shadow_texture, behind those of lights, holds the share of the sky's light that opaque
   * surfaces do not hide and translucent ones let through. */
  int32_t unhidden_sky;
  /* For hosts that show masks of an earlier frame: uploads the depth by which sideray_shadow_moving() and the like find
   * a surface after it or the camera has moved. One more texture, of 4 bytes a pixel. */
  int32_t moving;
  /* A check during a retrofit: one more ray for every fourth opaque pixel tests whether its depth lies on a traced
   * surface. sideray_frame_stats::mask_pixels_astray counts those off all surfaces; it is large if a matrix, a depth
   * convention or a transform is wrong, or if something is drawn that is not in the scene. */
  int32_t checks_surfaces;
} sideray_mask_inputs;

/* No light, exact, no ambient occlusion, filtered. */
SIDERAY_DEFAULTS(sideray_mask_inputs, mask_inputs)

/* Reflections of opaque surfaces, by rays. */
typedef struct sideray_reflection_inputs {
  size_t size;
  /* RGBA32F or RGBA16F 2D of the framebuffer's size: world-space shading normal and roughness; pixels above
   * max_roughness, and without a surface, are not traced. */
  uint32_t normal_texture;
  float max_roughness;
  int32_t denoise;
} sideray_reflection_inputs;

/* No texture; filtered. */
SIDERAY_DEFAULTS(sideray_reflection_inputs, reflection_inputs)

/* The light that other surfaces throw on opaque ones, by rays (docs/light.md): of all lamps, of what shines, and of the sky by way
 * of what it lights, bounced as often as it may be. One pixel of four is traced, and filters spread what it finds. */
typedef struct sideray_irradiance_inputs {
  size_t size;
  int32_t denoise;
} sideray_irradiance_inputs;

/* Filtered. */
SIDERAY_DEFAULTS(sideray_irradiance_inputs, irradiance_inputs)

/* The jobs of a frame. Each is traced and uploaded by itself: masks can be used while layers are still traced. */
enum {
  SIDERAY_JOB_LAYERS = 1u,
  SIDERAY_JOB_MASKS = 2u,
  SIDERAY_JOB_REFLECTIONS = 4u,
  SIDERAY_JOB_IRRADIANCE = 8u,
  SIDERAY_JOB_ALL = 15u
};

typedef struct sideray_frame_inputs {
  size_t size;
  sideray_view view;
  sideray_frame_source source;
  const sideray_layer_inputs* layers;           /* NULL: no such job; at least one of the four jobs is given */
  const sideray_mask_inputs* masks;
  const sideray_reflection_inputs* reflections;
  int32_t shadows; /* 0 = lights are visible everywhere: no shadow rays */
  /* 1: the frame follows the last one traced for this view, and may reuse its masks and, under a budget, its layers and
   * reflections. 0: the first frame of a sequence or after a cut. Another size, other lights, materials or options
   * reset the history by themselves; moved instances are followed; a job that was cancelled or failed leaves none. */
  int32_t continues;
  uint32_t seed;
  /* Milliseconds from submit, > 0, after which no more rays start; what is traced by then is uploaded. Read until 0.4;
   * use budget_ms. Masks and layers have an eighth of it in any case, from their first ray on; with layers, masks get
   * half of the remaining time, then reflections half of what remains. The least recently traced pieces come first,
   * then the middle of the picture and pixels of many surfaces. In frames that continue, pixels without a turn show
   * their history, reprojected with camera and instances. Without history fragments keep their raster look, and masks
   * are lit and open. A COMPOSITE is empty there, and reflections are not traced. 0 = none. The bits depend on the
   * machine. */
  float deadline_ms;
  sideray_state_policy state_policy; /* of submit, and of what advance and wait do for this frame */
  /* Which of the host's views it is, 0 to SIDERAY_MAX_VIEWS - 1: an eye, a part of the screen, a mirror's picture. Each
   * has outputs, a history (`continues`, `adds_to`) and three places for frames in flight of its own. */
  uint32_t view_id;
  const sideray_diagnostics* diagnostics; /* NULL: none. Of it, exact_points and budget_pieces are read */
  /* Milliseconds, > 0, from the readback of depth to the last upload, for rays, filters and uploads of all jobs. The
   * service predicts filters and uploads from earlier frames and stops rays in time for them. Views submitted together
   * share the budget of the first. Each job traces at least one piece of the picture a frame, the least recently traced
   * first. Pieces without a turn show their history as under deadline_ms, reflections too. 0 = none. Not with
   * deadline_ms. The bits depend on the machine. */
  float budget_ms;
  const sideray_irradiance_inputs* irradiance; /* NULL: none */
} sideray_frame_inputs;

/* No job, shadows on, the state saved and restored; the mask is a count in stencil bits 0x3f. */
SIDERAY_DEFAULTS(sideray_frame_inputs, frame)

typedef struct sideray_host_gl {
  size_t size;
  /* Entry points of the current context, e.g. eglGetProcAddress. Called only inside sideray_service_create. */
  void* (*get_proc_address)(void* user, const char* name);
  void* user;
} sideray_host_gl;

/* Needs the host's context current, here and in every call below. All OpenGL state that a call touches is put back
 * exactly, except by frames whose inputs say otherwise (state_policy); no OpenGL error is left behind or taken away. */
SIDERAY_API sideray_status sideray_service_create(sideray_tracer* tracer, const sideray_host_gl* host,
                                                  sideray_service** service, sideray_error* error);
/* Deletes the service's GL objects; the context that created it must be current. Joins the tracing threads. */
SIDERAY_API void sideray_service_destroy(sideray_service* service);
/* For a host whose context is gone: drops all GL objects without calling OpenGL. Destroy afterwards. */
SIDERAY_API void sideray_service_abandon_context(sideray_service* service);

/* Starts reading depth and stencil back and returns at once; it copies what `inputs` points at. SIDERAY_NOT_READY:
 * three frames of the view are in flight already. Frames are traced in the order of their tickets, and the jobs of one
 * in the order masks, irradiance, reflections, layers. */
SIDERAY_API sideray_status sideray_service_submit(sideray_service* service, const sideray_frame_inputs* inputs,
                                                  sideray_ticket* ticket, sideray_error* error);
/* Moves every job in flight on as far as it goes without blocking. */
SIDERAY_API sideray_status sideray_service_advance(sideray_service* service, sideray_error* error);
/* Blocks until all jobs of the frame are uploaded, at most `timeout_ms` (negative = for ever): SIDERAY_NOT_READY on
 * time-out. */
SIDERAY_API sideray_status sideray_service_wait(sideray_service* service, sideray_ticket ticket, int32_t timeout_ms,
                                                sideray_error* error);
/* Blocks until these jobs of the frame are uploaded (SIDERAY_JOB_*; those that it does not have count as uploaded). */
SIDERAY_API sideray_status sideray_service_wait_jobs(sideray_service* service, sideray_ticket ticket, uint32_t jobs,
                                                     int32_t timeout_ms, sideray_error* error);
/* Returns without blocking and without OpenGL which of the frame's jobs are uploaded. A job that failed or was
 * cancelled is never among them; wait_jobs returns its status. */
SIDERAY_API sideray_status sideray_service_finished_jobs(sideray_service* service, sideray_ticket ticket,
                                                         uint32_t* jobs, sideray_error* error);
SIDERAY_API sideray_status sideray_service_cancel(sideray_service* service, sideray_ticket ticket,
                                                  sideray_error* error);

/* The service owns the textures; their names are valid until the next submit of the view, advance or wait. Each kind of
 * output belongs to the newest frame whose job is finished, so masks may be of a later frame than layers. */
typedef struct sideray_layer_outputs {
  size_t size;
  sideray_ticket ticket;
  sideray_service_mode mode;
  sideray_view view; /* the view it was traced for */
  int32_t x, y, width, height;
  uint32_t layers;             /* CACHE: layers in the arrays */
  uint32_t radiance_texture;   /* CACHE: RGBA16F 2D array, C of dst = C*a + dst*T. COMPOSITE: RGBA16F 2D, premultiplied */
  uint32_t distance_texture;   /* CACHE: R32F 2D array, 0 in layer 0 = no answer. COMPOSITE: RGBA16F 2D, transmittance */
  uint32_t surface_id_texture; /* CACHE: R32UI, or R32F (see float_ids), 2D array. COMPOSITE: 0 */
  /* RGBA16F 2D; 0 = none were requested. A pixel is whole if the transmittance's alpha is 1, not 0; it shows radiance +
   * picture * transmittance. */
  uint32_t whole_radiance_texture, whole_transmittance_texture;
} sideray_layer_outputs;

typedef struct sideray_mask_outputs {
  size_t size;
  sideray_ticket ticket;
  sideray_view view;
  int32_t x, y, width, height;
  /* R8 2D array, 1 = lit: one layer a bit of shadow_lights, lowest first, then the combined one. 0 = no such mask */
  uint32_t shadow_texture;
  uint32_t shadow_lights;
  int32_t combined_lights;
  uint32_t ao_texture; /* R8 2D, 1 = open; 0 = no mask */
  int32_t unhidden_sky; /* 1: the last layer of shadow_texture is that of sideray_mask_inputs::unhidden_sky */
  /* The share of a light's colour that translucent surfaces let through to the pixel: R8 2D array, 1 = all. The light
   * that arrives is its mask times this. Three layers, red, green and blue, for each light that is tinted somewhere in
   * this frame; 0 = none is. */
  uint32_t tint_texture;
  int32_t tint_layers[33]; /* of light i, [32] of the combined ones: the first of its three, counted from 1; 0 = untinted */
  uint32_t depth_texture;  /* R32F 2D, for the snippet: sideray_mask_inputs::moving; 0 = not requested */
  /* R8 2D: which masks of a pixel are traced or reprojected. 255 times the texel is 1 (lights) + 2 (sky). The others
   * are lit and open: draw what a rasterizer would. 0 = all are traced, as always without a budget. */
  uint32_t answer_texture;
} sideray_mask_outputs;

typedef struct sideray_reflection_outputs {
  size_t size;
  sideray_ticket ticket;
  sideray_view view;
  int32_t x, y, width, height;
  uint32_t reflection_texture; /* RGBA16F 2D: radiance from the mirrored direction; A 0 = not traced */
} sideray_reflection_outputs;

typedef struct sideray_irradiance_outputs {
  size_t size;
  sideray_ticket ticket;
  sideray_view view;
  int32_t x, y, width, height;
  /* RGBA16F 2D: irradiance over pi, i.e. the radiance of a white matt surface, to be added to that of the sky times its mask. It
   * also holds by how much the colour of the visible part of the sky differs from that of all of it, so that a channel may be
   * negative: the sum is not. A 0 = not traced. */
  uint32_t irradiance_texture;
} sideray_irradiance_outputs;

/* The newest finished outputs of a view; SIDERAY_NOT_READY before the first. `size` of the outputs is set by the
 * caller. */
SIDERAY_API sideray_status sideray_service_layers(sideray_service* service, uint32_t view_id,
                                                  sideray_layer_outputs* outputs, sideray_error* error);
SIDERAY_API sideray_status sideray_service_masks(sideray_service* service, uint32_t view_id,
                                                 sideray_mask_outputs* outputs, sideray_error* error);
SIDERAY_API sideray_status sideray_service_reflections(sideray_service* service, uint32_t view_id,
                                                       sideray_reflection_outputs* outputs, sideray_error* error);
SIDERAY_API sideray_status sideray_service_irradiance(sideray_service* service, uint32_t view_id,
                                                      sideray_irradiance_outputs* outputs, sideray_error* error);
/* Returns the transform that an instance had in the frame of the newest outputs of a job (one of SIDERAY_JOB_*): the
 * matrix for the previous_world_position of sideray_translucent_moving() and sideray_shadow_moving(). Its layout is
 * that of sideray_instance_desc, its precision that of single floats about the scene's middle. SIDERAY_NOT_READY: there
 * are no such outputs yet, or the instance is newer than they are. Wind and changed vertices are not part of it. */
SIDERAY_API sideray_status sideray_service_placement(sideray_service* service, uint32_t view_id, uint32_t job,
                                                     sideray_instance instance, double world_from_object[12],
                                                     sideray_error* error);
/* Binds the newest textures of a view and sets the snippet's uniforms in `program`; without outputs the snippet finds
 * no answers. Units from first_unit on: 0 to 2 layers; and, for a program that reads them, 3 shadow masks, 4 ambient
 * occlusion, 5 and 6 whole pixels, 7 tints of masks, 8 their depth, 9 which masks are traced, 10 irradiance. These
 * units stay bound; other state follows the state_policy of the view's last submitted frame. */
SIDERAY_API sideray_status sideray_service_bind(sideray_service* service, uint32_t view_id, uint32_t program,
                                                uint32_t first_unit, sideray_error* error);

/* Of a finished frame, all its jobs together. */
typedef struct sideray_frame_stats {
  size_t size;
  double readback_ms, trace_ms, denoise_ms, upload_ms, trace_shadow_ms, trace_ao_ms;
  uint64_t rays_primary, rays_reflection, rays_shadow, rays_ao;
  uint64_t pixels_total, pixels_masked;
  uint64_t layers_requested, layers_found, traversals_wasted;
  uint64_t pixels_late;       /* masked pixels that budget or deadline left without an answer */
  uint64_t dropped_particles; /* sprites in view that rays do not hit */
  uint64_t bytes_readback, bytes_upload, bytes_cache;
  uint64_t points_shaded, points_not_finite; /* by a host's shader; of these, results that counted as black */
  uint64_t layers_borrowed; /* under ray_reuse: layers that reuse the rays of donors */
  uint64_t layers_refracted; /* CACHE with refraction: layers that hold what is seen through them */
  /* Masked pixels that had no turn and show an answer of an earlier frame. Those in neither count were traced in this
   * frame. */
  uint64_t pixels_older;
  /* Pixels with an opaque surface whose masks are missing (lit and open), and whose masks are of an earlier frame. */
  uint64_t mask_pixels_late, mask_pixels_older;
  uint64_t answer_age; /* age of the oldest answer shown, in frames; frames without a change do not count */
  /* Mirroring pixels without a reflection, and with one of an earlier frame. */
  uint64_t reflection_pixels_late, reflection_pixels_older;
  uint64_t jobs_starved; /* jobs for whose rays the budget left no time: one piece of each was traced */
  /* Age of the least recently traced piece of the picture, in frames; 0 = all was traced in this one. */
  uint64_t frames_waiting;
  uint64_t rays_bounce; /* of irradiance: along paths, and toward the sky */
  /* Pixels whose irradiance is not of this frame: those without any, and those that show an older one. */
  uint64_t irradiance_pixels_late, irradiance_pixels_older;
  /* Under sideray_mask_inputs::checks_surfaces, of the pixels with an opaque surface: those that were checked, and of them
   * those whose depth lies on no traced surface. */
  uint64_t mask_pixels_checked, mask_pixels_astray;
} sideray_frame_stats;

SIDERAY_API sideray_status sideray_service_stats(sideray_service* service, sideray_ticket ticket,
                                                 sideray_frame_stats* stats, sideray_error* error);

/* The text of sideray.glsl for a `#version` number (120, 130, 150, 330, 450 ..., 300 for ES too), to paste behind the
 * host's #version line; with 120 before anything else, for it asks for EXT_texture_array. Valid for ever. NULL where
 * the version is not supported. Needs no context. */
SIDERAY_API const char* sideray_glsl(int glsl_version);

/* Whole programs in GLSL 1.20 for hosts that have no shaders of their own; shaders/host/ready_*.glsl say what their
 * uniforms are. They need `float_ids`. */
typedef enum sideray_ready_program {
  SIDERAY_READY_GLASS = 0,  /* glass as the fixed function lights and textures it, with answers where there are any */
  SIDERAY_READY_SHADOWS = 1, /* multiplies the opaque picture by a light's shadow mask and the occlusion mask */
  /* Glass by a fragment shader alone: the fixed function goes on to transform, light and texture vertices. It has no
   * vertex shader (NULL); docs/fixed-function.md says how texture coordinates carry world positions. */
  SIDERAY_READY_GLASS_FRAGMENT = 2
} sideray_ready_program;

/* Texts that are valid for ever; NULL where there is no such program. Need no context. */
SIDERAY_API const char* sideray_ready_vertex(sideray_ready_program program);
SIDERAY_API const char* sideray_ready_fragment(sideray_ready_program program);

#ifdef __cplusplus
}
#endif
#endif
