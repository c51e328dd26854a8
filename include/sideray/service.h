/* The service: rays for a host's frame. It moves depth, stencil and results between the host's OpenGL context and a
 * tracer. Calls on one service must not overlap, and the host's context must be current in each.
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

/* A camera, given by the host's matrices: perspective (also off-axis) or orthographic, as the matrix says. Distances
 * are measured along the view ray, from the eye (perspective) or from the near plane (orthographic). This struct never
 * grows. */
typedef struct sideray_view {
  double clip_from_world[16];
  double world_from_clip[16];
  int32_t reversed_depth;    /* window depth 1 is near */
  int32_t zero_to_one_depth; /* clip space z runs 0..w (glClipControl) instead of -w..w */
} sideray_view;

/* Makes a view from OpenGL's column-major matrices, clip from eye and eye from world; reversed_depth and
 * zero_to_one_depth become 0. Refuses matrices without an inverse or an eye; they are mostly transposed or multiplied
 * in the wrong order. */
SIDERAY_API sideray_status sideray_view_from_matrices(const double projection[16], const double modelview[16],
                                                      sideray_view* view, sideray_error* error);

typedef enum sideray_mask_source {
  SIDERAY_MASK_NONE = 0,    /* trace every pixel */
  SIDERAY_MASK_STENCIL = 1, /* trace where (stencil & stencil_bits) != 0 */
  SIDERAY_MASK_COUNT = 2,   /* the same, and the value counts the layers there; all bits set = that many or more */
  /* The same from one byte a pixel: 0 = do not trace, 255 = trace, other values count the layers. For targets without
   * stencil. */
  SIDERAY_MASK_TEXTURE = 3, /* mask_texture */
  SIDERAY_MASK_MEMORY = 4,  /* mask_texels */
  SIDERAY_MASK_FORCE_32 = 0x7fffffff
} sideray_mask_source;

typedef enum sideray_service_mode {
  SIDERAY_CACHE = 0,    /* fill the layer cache for sideray_translucent() (hybrid translucency) */
  SIDERAY_COMPOSITE = 1 /* composite up to max_layers surfaces in ray order (fully ray-traced translucency) */
} sideray_service_mode;

/* How a fragment finds its layer, within the tolerance between rasterizer and rays (docs/architecture.md).
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

/* Which masked pixels are traced. The others use layers of neighbours, on the same surface and in its plane
 * (sideray_find() of the snippet). */
typedef enum sideray_cache_rate {
  SIDERAY_RATE_FULL = 0,
  SIDERAY_RATE_CHECKERBOARD = 1,
  SIDERAY_RATE_INTERLEAVED = 2, /* every other row */
  SIDERAY_RATE_QUARTER = 3,     /* one of 2x2 */
  SIDERAY_RATE_TEMPORAL4 = 4,   /* deprecated like the next one: both mean FULL, until 0.4 */
  SIDERAY_RATE_TEMPORAL8 = 5
} sideray_cache_rate;

/* How shadow rays of marked pixels treat plants that rays hit in another pose than the drawn one (RTG2 50.3.2). B is
 * sideray_mask_inputs::inexact_bias, u a random number in 0..1. diagnostics.h has one more value. */
typedef enum sideray_inexact {
  SIDERAY_EXACT = 0,
  SIDERAY_INEXACT_TMIN = 1,     /* ignores hits nearer than u * B (listing 50-3) */
  SIDERAY_INEXACT_BOUNDED = 2,  /* the same; B is the largest distance by which wind moves the pixel */
  SIDERAY_INEXACT_RESTPOSE = 3, /* the ray starts at the pixel's undeformed position */
  SIDERAY_INEXACT_FORCE_32 = 0x7fffffff
} sideray_inexact;

typedef uint64_t sideray_ticket; /* 0 is never a ticket */

/* Says who restores the OpenGL state that a frame changes. */
typedef enum sideray_state_policy {
  SIDERAY_SAVE_AND_RESTORE = 0, /* the service restores it exactly */
  /* No state is read, and changed state is left at OpenGL's initial values: nothing bound, no program, unit 0 active;
   * viewports are undefined. docs/embedding.md lists it call by call. For engines that set all state they need, and for
   * threaded drivers, which stall when state is read. */
  SIDERAY_HOST_RESTORES = 1
} sideray_state_policy;

enum { SIDERAY_MAX_VIEWS = 16 };

/* Says where a frame's depth and mask are read. This struct never grows: its last field is reserved. */
typedef struct sideray_frame_source {
  uint32_t framebuffer; /* GL name, with depth (and stencil); 0 allowed; of a multisampled one, one sample is read */
  /* If not 0, one image that replaces `framebuffer`: depth, or depth and stencil. */
  uint32_t depth_texture;
  uint32_t depth_texture_target; /* GL_TEXTURE_2D (the default), _2D_ARRAY, _2D_MULTISAMPLE or _RECTANGLE */
  int32_t depth_layer;           /* of an array */
  uint32_t depth_renderbuffer;
  int32_t x, y, width, height; /* the rectangle of the image that the view covers */
  sideray_mask_source mask;
  uint32_t stencil_bits;      /* contiguous from bit 0, for example 0x3f */
  uint32_t mask_texture;      /* SIDERAY_MASK_TEXTURE: R8 2D of the framebuffer's size */
  const uint8_t* mask_texels; /* SIDERAY_MASK_MEMORY: texels of the rectangle, read during submit */
  size_t mask_row_bytes;
  /* RG32F or RG16F 2D of the framebuffer's size, used by masks of frames that continue: the pixel's position minus the
   * previous position of the same surface point, in pixels. 0 = only the camera has moved. */
  uint32_t motion_texture;
  uint32_t reserved[15]; /* 0 */
} sideray_frame_source;

/* Layers of translucent surfaces. */
typedef struct sideray_layer_inputs {
  size_t size;
  sideray_service_mode mode;
  uint32_t max_layers;     /* CACHE 1..8; COMPOSITE 1..64, or 0 = unlimited */
  int32_t all_translucent; /* includes instances without SIDERAY_VISIBLE_LAYERS */
  sideray_step step;
  sideray_match match;           /* CACHE: used by sideray_service_bind */
  float match_threshold;         /* SIDERAY_MATCH_DISTANCE: share of the distance, > 0 */
  sideray_cache_rate cache_rate; /* CACHE, as the next three */
  sideray_radiance_space radiance_space;
  float radiance_scale; /* > 0: radiance is multiplied by it before the transfer function */
  int32_t float_ids;    /* surface ids, below 2^24, as floats in R32F: for GLSL 1.20; always without integer textures */
  int32_t denoise;      /* CACHE: filters reflections of rough surfaces */
  /* Volumes refract the light behind them, and rough surfaces blur it. CACHE: a pixel's first such surface is resolved
   * if it is one of the max_layers: its layer contains everything seen through it, and nothing behind it may be drawn
   * (sideray_look_up() of the snippet). Its distance is stored as a negative number. */
  int32_t refraction;
  int32_t particles;       /* COMPOSITE: rays hit sprites, as quads that face the eye */
  uint32_t requested_bits; /* with adds_to; outside stencil_bits, for example 0x40, set where sideray_asks() is true */
  /* CACHE: the ticket of a frame at a reduced cache_rate, for which this frame is the second wave with otherwise equal
   * inputs. It must be the newest finished frame, and nothing else may be in flight. Its layers stay; pixels whose
   * stencil has one of `requested_bits` are traced and added. 0 = a frame of its own. */
  sideray_ticket adds_to;
  /* CACHE: pixels whose cached layers are as many as the mask counts are also composited along the ray, in exact order:
   * sideray_layer_outputs::whole_radiance_texture. Needs a mask that counts, FULL rate, LINEAR space with a scale of 1,
   * and no shader of the host. */
  int32_t whole_pixels;
  /* With whole_pixels: stencil bits outside stencil_bits. The host sets one where it draws something translucent that
   * the mask does not count; such pixels are not whole. 0 = it draws nothing of the kind. */
  uint32_t others_bits;
  /* One pixel in four, a donor, traces the shadow and reflection rays of its layers. Other pixels reuse the results of
   * donors on the same surface, unless the donors' values differ by more than this much radiance in a layer's
   * contribution to its pixel: then the pixel traces its own rays. 0 = every layer traces its own. Requires FULL rate;
   * not with a COMPOSITE of `refraction`, nor with a shader of the host. */
  float ray_reuse;
  /* COMPOSITE: above 0, surfaces are shaded as in references (sideray_reference_options), with so many samples, at most
   * 2^20, of each light with a size, of the environment and of microfacets. Not with a shader of the host. */
  uint32_t light_samples;
  uint32_t bounces; /* with light_samples: sideray_reference_options::bounces */
} sideray_layer_inputs;

/* CACHE of 4 layers at full rate, matched by id, filtered; every layer traces its own rays; 1 bounce. */
SIDERAY_DEFAULTS(sideray_layer_inputs, layer_inputs)

/* Masks of opaque pixels: the visible share of each light, and of the sky. */
typedef struct sideray_mask_inputs {
  size_t size;
  uint32_t shadow_lights; /* bit i: light i of the scene, of its first 32, has a mask of its own */
  /* One more mask for all lights from the 33rd on: the share of their combined light that reaches the pixel. Each pixel
   * traces one ray to one of these lights, sampled by its unshadowed contribution. */
  int32_t combined_lights;
  sideray_inexact inexact; /* for pixels whose stencil has one of inexact_bits */
  float inexact_bias;      /* B, world units, >= 0 */
  uint32_t inexact_bits;   /* outside stencil_bits, for example 0x80; 0 = no pixel */
  uint32_t rest_texture;   /* RESTPOSE, BOUNDED: RGBA32F 2D of the framebuffer's size; xyz = undeformed minus drawn
                            * position, world units; w unused. 0 = none */
  /* Moves the start of rays farther off the surface along its normal: world units, >= 0. The depth buffer's error is
   * covered without it; it is needed if drawn and traced tessellation differ. */
  float shadow_bias;
  uint32_t ao_rays;  /* 0 = no ambient occlusion mask */
  float ao_distance; /* world units, > 0; +inf = unlimited */
  int32_t denoise;
  /* The same in steps of the depth format, >= 0: rays start so many steps nearer to the eye than the automatic margin
   * (docs/embedding.md). Like the depth's own error it grows with distance. For drivers and geometry whose depth is
   * less exact than its format. */
  float shadow_bias_steps;
  /* A threshold on the radiance that a light adds to a white diffuse surface facing it: where it adds less, its own
   * mask is lit without a ray. Directional lights always trace rays. 0 = rays go wherever the light reaches.
   * docs/adr/0039-least-light.md says what it saves. */
  float least_light;
  /* 1: ambient occlusion rays are sampled by the environment's light, for hosts that light by it; 0: by the cosine
   * alone. */
  int32_t ao_by_light;
  /* With ao_rays, adds a last layer to shadow_texture, after those of lights: the share of the sky's light that opaque
   * surfaces do not hide and translucent ones transmit. */
  int32_t unhidden_sky;
  /* For hosts that show masks of an earlier frame: uploads the depth by which sideray_shadow_moving() and the like find
   * a surface after it or the camera has moved. Costs one more texture of 4 bytes a pixel. */
  int32_t moving;
  /* A check for retrofits: one more ray for every fourth opaque pixel tests whether its depth lies on a traced surface.
   * sideray_frame_stats::mask_pixels_astray counts pixels off all surfaces. It is large if a matrix, a depth convention
   * or a transform is wrong, or if something is drawn that is not in the scene. */
  int32_t checks_surfaces;
} sideray_mask_inputs;

/* No light, exact, no ambient occlusion, filtered. */
SIDERAY_DEFAULTS(sideray_mask_inputs, mask_inputs)

/* Reflections of opaque surfaces, by rays. */
typedef struct sideray_reflection_inputs {
  size_t size;
  /* RGBA32F or RGBA16F 2D of the framebuffer's size: world-space shading normal, and roughness. Pixels above
   * max_roughness, and pixels without a surface, are not traced. */
  uint32_t normal_texture;
  float max_roughness;
  int32_t denoise;
} sideray_reflection_inputs;

/* No texture; filtered. */
SIDERAY_DEFAULTS(sideray_reflection_inputs, reflection_inputs)

/* Indirect light of opaque surfaces, by rays (docs/light.md): light of lamps, emissive surfaces and the sky that other
 * surfaces reflect, with any number of bounces. One pixel in four is traced; filters spread the results. With masks of
 * unlimited ao_distance in the same frame, layers show surfaces behind glass in the same light. */
typedef struct sideray_irradiance_inputs {
  size_t size;
  int32_t denoise;
} sideray_irradiance_inputs;

/* Filtered. */
SIDERAY_DEFAULTS(sideray_irradiance_inputs, irradiance_inputs)

/* The jobs of a frame. Each is traced and uploaded separately: masks can be used while layers are still traced. */
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
  const sideray_layer_inputs* layers;           /* NULL: no such job; at least one of the four jobs is required */
  const sideray_mask_inputs* masks;
  const sideray_reflection_inputs* reflections;
  int32_t shadows; /* 0 = no shadow rays, lights are visible everywhere */
  /* 1: the frame follows the last one traced for this view. It may reuse that frame's masks and, under a budget, its
   * layers and reflections. 0: the first frame of a sequence or after a cut. A change of size, lights, materials or
   * options resets the history automatically; moved instances are followed. A cancelled or failed job leaves no
   * history. */
  int32_t continues;
  /* Seeds random numbers. Light that bounces onto what mirrors and glass show is drawn by the seed alone: it does not
   * flicker while the seed stays, and averages out over frames in which the seed changes. */
  uint32_t seed;
  /* Milliseconds from submit, > 0, after which no more rays start; traced results are uploaded. Supported until 0.4;
   * use budget_ms. Masks and layers each have at least an eighth of it, counted from their first ray. With layers,
   * masks get half of the remaining time, then reflections half of what remains. The least recently traced pieces come
   * first, then the middle of the picture and pixels with many surfaces. In frames that continue, skipped pixels show
   * their history, reprojected with camera and instances. Without history fragments keep their raster look, and masks
   * are lit and open; a COMPOSITE is empty there, and reflections are not traced. 0 = none. The bits depend on the
   * machine. */
  float deadline_ms;
  sideray_state_policy state_policy; /* for submit, and for advance and wait while they work on this frame */
  /* The index of the host's view, 0 to SIDERAY_MAX_VIEWS - 1: an eye, a part of the screen, a mirror's picture. Each
   * view has its own outputs, history (`continues`, `adds_to`) and three places for frames in flight. */
  uint32_t view_id;
  const sideray_diagnostics* diagnostics; /* NULL: none. exact_points and budget_pieces are read */
  /* Milliseconds, > 0, from the readback of depth to the last upload, for rays, filters and uploads of all jobs. The
   * service predicts filters and uploads from earlier frames and stops rays in time for them. Views submitted together
   * share the budget of the first. If it is too short for all jobs, they take turns, the one that waited longest first;
   * each traces its least recently traced pieces first. Pieces without a turn show their history as under deadline_ms,
   * reflections too. 0 = none. Not with deadline_ms. The bits depend on the machine. */
  float budget_ms;
  const sideray_irradiance_inputs* irradiance; /* NULL: none */
} sideray_frame_inputs;

/* No job, shadows on, the state saved and restored; the mask is a count in stencil bits 0x3f. */
SIDERAY_DEFAULTS(sideray_frame_inputs, frame)

typedef struct sideray_host_gl {
  size_t size;
  /* Returns entry points of the current context, like eglGetProcAddress. Called only during sideray_service_create. */
  void* (*get_proc_address)(void* user, const char* name);
  void* user;
} sideray_host_gl;

/* Creates a service. The host's context must be current, here and in every call below. A call restores all OpenGL state
 * that it touches exactly, except for frames whose state_policy says otherwise; it neither leaves nor takes away OpenGL
 * errors. */
SIDERAY_API sideray_status sideray_service_create(sideray_tracer* tracer, const sideray_host_gl* host,
                                                  sideray_service** service, sideray_error* error);
/* Deletes the service's GL objects; the context that created it must be current. Joins its tracing threads. */
SIDERAY_API void sideray_service_destroy(sideray_service* service);
/* For a host whose context is lost: forgets all GL objects without calling OpenGL. Destroy the service afterwards. */
SIDERAY_API void sideray_service_abandon_context(sideray_service* service);

/* Starts the readback of depth and stencil and returns at once, after copying everything that `inputs` points to.
 * SIDERAY_NOT_READY: three frames of the view are in flight already. Frames are traced in the order of their tickets,
 * and the jobs of one in the order masks, irradiance, reflections, layers. */
SIDERAY_API sideray_status sideray_service_submit(sideray_service* service, const sideray_frame_inputs* inputs,
                                                  sideray_ticket* ticket, sideray_error* error);
/* Advances every job in flight as far as possible without blocking. */
SIDERAY_API sideray_status sideray_service_advance(sideray_service* service, sideray_error* error);
/* Blocks until all jobs of the frame are uploaded, for at most `timeout_ms` (negative = for ever). SIDERAY_NOT_READY:
 * timed out. */
SIDERAY_API sideray_status sideray_service_wait(sideray_service* service, sideray_ticket ticket, int32_t timeout_ms,
                                                sideray_error* error);
/* Blocks until these jobs of the frame are uploaded (SIDERAY_JOB_*). Jobs that the frame does not have count as
 * uploaded. */
SIDERAY_API sideray_status sideray_service_wait_jobs(sideray_service* service, sideray_ticket ticket, uint32_t jobs,
                                                     int32_t timeout_ms, sideray_error* error);
/* Returns in `jobs` which of the frame's jobs are uploaded, without blocking and without OpenGL. Failed or cancelled
 * jobs are never included; wait_jobs returns their status. */
SIDERAY_API sideray_status sideray_service_finished_jobs(sideray_service* service, sideray_ticket ticket,
                                                         uint32_t* jobs, sideray_error* error);
SIDERAY_API sideray_status sideray_service_cancel(sideray_service* service, sideray_ticket ticket,
                                                  sideray_error* error);

/* The service owns the textures; their names are valid until the next submit of the view, advance or wait. Each kind of
 * output belongs to the newest frame that finished its job, so masks may be from a later frame than layers. */
typedef struct sideray_layer_outputs {
  size_t size;
  sideray_ticket ticket;
  sideray_service_mode mode;
  sideray_view view; /* the view that was traced */
  int32_t x, y, width, height;
  uint32_t layers;             /* CACHE: layers in the arrays */
  uint32_t radiance_texture;   /* CACHE: RGBA16F 2D array, C of dst = C*a + dst*T. COMPOSITE: RGBA16F 2D, premultiplied */
  uint32_t distance_texture;   /* CACHE: R32F 2D array, 0 in layer 0 = no answer. COMPOSITE: RGBA16F 2D, transmittance */
  uint32_t surface_id_texture; /* CACHE: R32UI, or R32F (see float_ids), 2D array. COMPOSITE: 0 */
  /* RGBA16F 2D; 0 = not requested. A pixel is whole if the transmittance's alpha is 1, not 0; it then shows radiance +
   * picture * transmittance. */
  uint32_t whole_radiance_texture, whole_transmittance_texture;
} sideray_layer_outputs;

typedef struct sideray_mask_outputs {
  size_t size;
  sideray_ticket ticket;
  sideray_view view;
  int32_t x, y, width, height;
  /* R8 2D array, 1 = lit: one layer for each bit of shadow_lights, lowest first, then the combined one. 0 = no masks */
  uint32_t shadow_texture;
  uint32_t shadow_lights;
  int32_t combined_lights;
  uint32_t ao_texture; /* R8 2D, 1 = open; 0 = no mask */
  int32_t unhidden_sky; /* 1: shadow_texture ends with the layer of sideray_mask_inputs::unhidden_sky */
  /* Transmittance of translucent surfaces between a light and the pixel: R8 2D array, 1 = all. The arriving light is
   * the light's mask times this. Three layers, red, green and blue, for each light that is tinted anywhere in this
   * frame; 0 = none is. */
  uint32_t tint_texture;
  int32_t tint_layers[33]; /* first of the three layers of light i ([32]: combined lights), from 1; 0 = untinted */
  uint32_t depth_texture;  /* R32F 2D, for the snippet: sideray_mask_inputs::moving; 0 = not requested */
  /* R8 2D: which masks of a pixel are traced or reprojected; 255 times the texel is 1 (lights) + 2 (sky). Other masks
   * are lit and open, and the pixel should be drawn as without rays. 0 = all are traced, as always without a budget. */
  uint32_t answer_texture;
} sideray_mask_outputs;

typedef struct sideray_reflection_outputs {
  size_t size;
  sideray_ticket ticket;
  sideray_view view;
  int32_t x, y, width, height;
  uint32_t reflection_texture; /* RGBA16F 2D: radiance from the mirror direction; A 0 = not traced */
} sideray_reflection_outputs;

typedef struct sideray_irradiance_outputs {
  size_t size;
  sideray_ticket ticket;
  sideray_view view;
  int32_t x, y, width, height;
  /* RGBA16F 2D: irradiance over pi, which is the radiance of a white diffuse surface, to be added to the sky's light
   * times its mask. It also contains the difference in colour between the visible part of the sky and the whole, so a
   * channel may be negative; the sum is not. A 0 = not traced. */
  uint32_t irradiance_texture;
} sideray_irradiance_outputs;

/* Return the newest finished outputs of a view; SIDERAY_NOT_READY before the first. The caller sets the `size` of
 * `outputs`. */
SIDERAY_API sideray_status sideray_service_layers(sideray_service* service, uint32_t view_id,
                                                  sideray_layer_outputs* outputs, sideray_error* error);
SIDERAY_API sideray_status sideray_service_masks(sideray_service* service, uint32_t view_id,
                                                 sideray_mask_outputs* outputs, sideray_error* error);
SIDERAY_API sideray_status sideray_service_reflections(sideray_service* service, uint32_t view_id,
                                                       sideray_reflection_outputs* outputs, sideray_error* error);
SIDERAY_API sideray_status sideray_service_irradiance(sideray_service* service, uint32_t view_id,
                                                      sideray_irradiance_outputs* outputs, sideray_error* error);
/* Returns the transform of an instance in the frame of the newest outputs of a job (one of SIDERAY_JOB_*): the matrix
 * for the previous_world_position of sideray_translucent_moving() and sideray_shadow_moving(). Its layout is that of
 * sideray_instance_desc; its precision is that of floats relative to the scene's middle. SIDERAY_NOT_READY: there are
 * no such outputs yet, or the instance is newer. Wind and changed vertices are not included. */
SIDERAY_API sideray_status sideray_service_placement(sideray_service* service, uint32_t view_id, uint32_t job,
                                                     sideray_instance instance, double world_from_object[12],
                                                     sideray_error* error);
/* Binds the newest textures of a view and sets the snippet's uniforms in `program`; without outputs the snippet finds
 * no answers. Units from first_unit on: 0 to 2 layers; and, for programs that read them, 3 shadow masks, 4 ambient
 * occlusion, 5 and 6 whole pixels, 7 tints of masks, 8 their depth, 9 which masks are traced, 10 irradiance. These
 * units stay bound; other state follows the state_policy of the view's last submitted frame. */
SIDERAY_API sideray_status sideray_service_bind(sideray_service* service, uint32_t view_id, uint32_t program,
                                                uint32_t first_unit, sideray_error* error);

/* Statistics of a finished frame, over all its jobs. */
typedef struct sideray_frame_stats {
  size_t size;
  double readback_ms, trace_ms, denoise_ms, upload_ms, trace_shadow_ms, trace_ao_ms;
  uint64_t rays_primary, rays_reflection, rays_shadow, rays_ao;
  uint64_t pixels_total, pixels_masked;
  uint64_t layers_requested, layers_found, traversals_wasted;
  uint64_t pixels_late;       /* masked pixels without an answer because of budget or deadline */
  uint64_t dropped_particles; /* sprites in view that rays cannot hit */
  uint64_t bytes_readback, bytes_upload, bytes_cache;
  uint64_t points_shaded, points_not_finite; /* of a host's shader; results that were not finite and count as black */
  uint64_t layers_borrowed; /* with ray_reuse: layers that reuse the rays of donors */
  uint64_t layers_refracted; /* CACHE with refraction: resolved layers */
  /* Masked pixels that were skipped and show an answer of an earlier frame. Pixels in neither count were traced in this
   * frame. */
  uint64_t pixels_older;
  /* Pixels with an opaque surface whose masks are missing (lit and open); and whose masks are from an earlier frame. */
  uint64_t mask_pixels_late, mask_pixels_older;
  uint64_t answer_age; /* age of the oldest answer shown, in frames with changes */
  /* Reflecting pixels without a reflection; and with one from an earlier frame. */
  uint64_t reflection_pixels_late, reflection_pixels_older;
  uint64_t jobs_starved; /* jobs without time for rays in the budget: they trace a few pieces if it is their turn */
  /* Age of the least recently traced piece of the picture, in frames; 0 = all was traced in this one. */
  uint64_t frames_waiting;
  uint64_t rays_bounce; /* of irradiance: rays of paths, and rays to the sky */
  /* Pixels without irradiance; and with irradiance from an earlier frame. */
  uint64_t irradiance_pixels_late, irradiance_pixels_older;
  /* With sideray_mask_inputs::checks_surfaces: pixels with an opaque surface that were checked; and those of them whose
   * depth is on no traced surface. */
  uint64_t mask_pixels_checked, mask_pixels_astray;
} sideray_frame_stats;

SIDERAY_API sideray_status sideray_service_stats(sideray_service* service, sideray_ticket ticket,
                                                 sideray_frame_stats* stats, sideray_error* error);

/* Returns the text of sideray.glsl for a `#version` number (120, 130, 150, 330, 450 ..., 300 for ES too). Paste it
 * after the host's #version line; with 120 before anything else, because it enables EXT_texture_array. Valid for ever.
 * NULL: the version is not supported. Needs no context. */
SIDERAY_API const char* sideray_glsl(int glsl_version);

/* Whole programs in GLSL 1.20 for hosts without shaders of their own; shaders/host/ready_*.glsl explain their uniforms.
 * They need `float_ids`. */
typedef enum sideray_ready_program {
  SIDERAY_READY_GLASS = 0,  /* glass lit and textured by the fixed function, with answers where there are any */
  SIDERAY_READY_SHADOWS = 1, /* multiplies the opaque picture by a light's shadow mask and the ambient occlusion mask */
  /* Glass by a fragment shader alone: the fixed function still transforms, lights and textures vertices. It has no
   * vertex shader (NULL); docs/fixed-function.md explains how texture coordinates carry world positions. */
  SIDERAY_READY_GLASS_FRAGMENT = 2
} sideray_ready_program;

/* Return texts that are valid for ever; NULL if there is no such program. Need no context. */
SIDERAY_API const char* sideray_ready_vertex(sideray_ready_program program);
SIDERAY_API const char* sideray_ready_fragment(sideray_ready_program program);

#ifdef __cplusplus
}
#endif
#endif
