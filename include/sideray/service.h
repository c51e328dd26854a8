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

/* A camera as the host's matrices say it. Perspective (also off-axis) and orthographic; the kind is read from the
 * matrix. Distances are measured along the view ray from the eye (perspective) or the near plane (orthographic). This
 * struct never grows. */
typedef struct sideray_view {
  double clip_from_world[16];
  double world_from_clip[16];
  int32_t reversed_depth;    /* window depth 1 is near */
  int32_t zero_to_one_depth; /* clip space z runs 0..w (glClipControl) instead of -w..w */
} sideray_view;

/* The view of column-major matrices as an engine of OpenGL has them, clip from eye and eye from world; reversed_depth and
 * zero_to_one_depth are 0. Refuses what has no inverse and no eye: matrices that are transposed, or in the wrong order. */
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

/* How a fragment finds its layer: its surface is the layer's within what rasterization and rays may disagree by
 * (docs/architecture.md). diagnostics.h has one more value. */
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
  SIDERAY_RATE_TEMPORAL4 = 4,   /* of version 0.2; as FULL until 0.4, as the next one */
  SIDERAY_RATE_TEMPORAL8 = 5
} sideray_cache_rate;

/* Whether the shadow rays of marked pixels are exact, or regard that the traced geometry is not posed as the drawn one
 * is (RTG2 50.3.2). B is sideray_mask_inputs::inexact_bias, u a random number in 0..1. diagnostics.h has one more
 * value. */
typedef enum sideray_inexact {
  SIDERAY_EXACT = 0,
  SIDERAY_INEXACT_TMIN = 1,     /* hits nearer than u * B do not count (listing 50-3) */
  SIDERAY_INEXACT_BOUNDED = 2,  /* the same with the most that wind moves the pixel by for B */
  SIDERAY_INEXACT_RESTPOSE = 3, /* the ray starts at the pixel's undeformed position */
  SIDERAY_INEXACT_FORCE_32 = 0x7fffffff
} sideray_inexact;

typedef uint64_t sideray_ticket; /* 0 is never a ticket */

/* What becomes of the OpenGL state that is touched for a frame. */
typedef enum sideray_state_policy {
  SIDERAY_SAVE_AND_RESTORE = 0, /* it is put back exactly */
  /* No state is read. It is left as OpenGL has it at first: nothing bound, no program, unit 0 active; viewports are
   * left as they come. docs/embedding.md lists it call by call. For engines that set what they need, and for drivers
   * that work in a thread of their own, which reading state waits for. */
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
  /* RG32F or RG16F 2D of the framebuffer's size, read by masks of frames that continue: where what the pixel shows is
   * minus where it was in the previous frame, in pixels; 0 = nothing but the view has moved. */
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
  /* Surfaces of volumes bend what is seen through them, rough ones blur it. CACHE: the first such surface of a pixel is
   * resolved, where it is one of the max_layers: its layer holds all that is seen there, through it too, and nothing behind
   * it is to be drawn (sideray_look_up() of the snippet). Its distance is stored as a negative number. */
  int32_t refraction;
  int32_t particles;       /* COMPOSITE: rays hit sprites, as quads that face the eye */
  uint32_t requested_bits; /* with adds_to; outside stencil_bits, for example 0x40 where sideray_asks() holds */
  /* CACHE: the second wave of a frame that was not traced in full (cache_rate), with the inputs of that frame. Its
   * ticket, where it is the newest finished frame and nothing else is in flight: the frame's answers stay, and pixels
   * whose stencil has one of `requested_bits` are traced and added to them. 0 = a frame of its own. */
  sideray_ticket adds_to;
  /* CACHE: pixels of which the cache holds every surface, as many as the mask counts, are composited along the ray too,
   * in exact order: sideray_layer_outputs::whole_radiance_texture. For a mask that counts, at FULL rate, in LINEAR space
   * with a scale of 1; not with a shader of the host. */
  int32_t whole_pixels;
  /* Whole pixels: the host has set one of these stencil bits, outside stencil_bits, wherever it draws something
   * translucent that the mask does not count; no such pixel is whole. 0 = it draws nothing of the kind. */
  uint32_t others_bits;
  /* One pixel of four traces the shadow and reflection rays of its layers. The others reuse the results of these donors on
   * the same surface, unless the donors differ by more than this much radiance in what a layer adds to its pixel: then the
   * pixel traces its own rays. 0 = every layer traces its own. At FULL rate; not with a COMPOSITE of `refraction`, nor with a
   * shader of the host. */
  float ray_reuse;
  /* COMPOSITE: above 0, surfaces are shaded as sideray_reference_options has it, by so many samples of each light with a
   * size, of the environment and of microfacets, at most 2^20. Not with a shader of the host. */
  uint32_t light_samples;
  uint32_t bounces; /* with light_samples: sideray_reference_options::bounces */
} sideray_layer_inputs;

/* CACHE of 4 layers at full rate, matched by id, filtered; every layer traces its own rays; 1 bounce. */
SIDERAY_DEFAULTS(sideray_layer_inputs, layer_inputs)

/* Masks of opaque pixels: the share of each light, and of the sky, that they see. */
typedef struct sideray_mask_inputs {
  size_t size;
  uint32_t shadow_lights; /* bit i: light i of the scene, of its first 32, has a mask of its own */
  /* One more mask for all lights from the 33rd on together: the share of their light that arrives, weighted as each
   * lights the pixel. One ray a pixel, to a light drawn by its weight. */
  int32_t combined_lights;
  sideray_inexact inexact; /* of pixels whose stencil has one of inexact_bits */
  float inexact_bias;      /* B, world units, >= 0 */
  uint32_t inexact_bits;   /* outside stencil_bits, for example 0x80; 0 = no pixel */
  uint32_t rest_texture;   /* RESTPOSE, BOUNDED: RGBA32F 2D of the framebuffer's size; xyz = undeformed position minus
                            * the drawn one, world units; w unused. 0 = none */
  /* Added to how far rays start off the surface, along its normal: in world units, >= 0. What depth may be wrong by is
   * covered without it; it is for hosts whose drawn and traced tessellation differ. */
  float shadow_bias;
  uint32_t ao_rays;  /* 0 = no ambient occlusion mask */
  float ao_distance; /* world units, > 0; +inf = unlimited */
  int32_t denoise;
  /* The same as shadow_bias in steps of the depth format, >= 0: rays start so many values of the depth buffer nearer to
   * the eye, besides what is always allowed for (docs/embedding.md). It grows with the distance as the depth's own error does.
   * For drivers and geometry whose depth is worse than that. */
  float shadow_bias_steps;
  /* Radiance that a light adds to a white, matt surface which faces it: where it adds less than this, the light's own mask
   * is lit without a ray. Directional lights have their rays everywhere. 0 = a ray goes wherever the light reaches.
   * docs/adr/0039-least-light.md has what it saves. */
  float least_light;
  /* Ambient occlusion rays go where the light of the scene's environment comes from, for pictures that are lit by it; 0 = by
   * the cosine alone. */
  int32_t ao_by_light;
  /* One more layer behind those of lights in shadow_texture, with ao_rays: the share of the sky's light that nothing opaque
   * hides and that translucent surfaces let through. */
  int32_t unhidden_sky;
  /* For a host that shows masks of an earlier frame: what sideray_shadow_moving() and the like need to find a surface
   * that has moved since, or that the camera sees elsewhere. One more texture, of 4 bytes a pixel. */
  int32_t moving;
  /* For an engine that is being fitted with Sideray: one ray more for every fourth opaque pixel finds whether its depth
   * lies on a traced surface, which sideray_frame_stats::mask_pixels_astray counts. Many do not where a matrix, a depth
   * convention or a transform is wrong, or where what is drawn is not in the scene. */
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
  const sideray_layer_inputs* layers;           /* NULL: none, as the next two and `irradiance`; at least one is given */
  const sideray_mask_inputs* masks;
  const sideray_reflection_inputs* reflections;
  int32_t shadows; /* 0 = no visibility of lights anywhere */
  /* Deadlines, and masks: the frame follows the last one traced for this view, so that what was traced for it may be taken
   * over. 0 = the first of a sequence, or behind a cut: nothing is. Another size, other lights, materials or options are
   * noticed; moved instances are followed; a job that was cancelled or failed is followed by none. */
  int32_t continues;
  uint32_t seed;
  /* Milliseconds from submit, > 0, after which no more rays begin: what is there by then is uploaded. Masks and layers
   * have an eighth of it in any case, from their first ray on. What was traced least recently comes first, then the
   * middle of the picture and pixels of many surfaces. In frames that continue, CACHE and masks show their history where
   * nothing was traced, reprojected with camera and instances: no surface shows another's. Where there is none,
   * fragments keep their raster look, and masks are lit and open. COMPOSITE: the rest is empty; reflections are not
   * traced. Where layers are wanted too, masks get half of the time that is left, then reflections half of what is left
   * then. 0 = none. The one input besides budget_ms that makes the bits depend on the machine. */
  float deadline_ms;
  sideray_state_policy state_policy; /* of submit, and of what advance and wait do for this frame */
  /* Which of the host's views it is, 0 to SIDERAY_MAX_VIEWS - 1: an eye, a part of the screen, a mirror's picture. Each
   * has outputs, a history (`continues`, `adds_to`) and three places for frames in flight of its own. */
  uint32_t view_id;
  const sideray_diagnostics* diagnostics; /* NULL: none. Of it, exact_points and budget_pieces are read */
  /* Milliseconds, > 0, within which the frame is finished from when its depth is read back: rays, filters and uploads of
   * all its jobs. The service predicts the filters and uploads from earlier frames, and stops rays in time for them.
   * Views submitted together share the budget of the first. Each job traces at least one piece of the picture in each
   * frame; what has no turn shows history or nothing, as deadline_ms says, reflections too. What waits longest comes
   * first. 0 = none. Not with deadline_ms, which is read until 0.4. */
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
/* Tells without blocking and without OpenGL which of the frame's jobs are uploaded by now. A job that failed or was
 * cancelled is never among them; wait_jobs says so. */
SIDERAY_API sideray_status sideray_service_finished_jobs(sideray_service* service, sideray_ticket ticket,
                                                         uint32_t* jobs, sideray_error* error);
SIDERAY_API sideray_status sideray_service_cancel(sideray_service* service, sideray_ticket ticket,
                                                  sideray_error* error);

/* Texture names are the service's; valid until the next submit of the view, advance or wait. Each kind of output is
 * that of the newest frame whose job is finished, so that masks may be of a later frame than layers. */
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
  /* Whole pixels, which are those where the transmittance's alpha is 1, not 0: radiance + picture * transmittance is all
   * that is seen there. RGBA16F 2D; 0 where none were asked for. */
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
  int32_t unhidden_sky; /* 1: the last layer of shadow_texture is what sideray_mask_inputs::unhidden_sky asks for */
  /* What glass and all else that is translucent leaves of a light's colour on its way to the pixel: R8 2D array, 1 = all.
   * The light that arrives is its mask times these. Three layers, red, green and blue, of each light that is tinted
   * somewhere in this frame; 0 = none is. */
  uint32_t tint_texture;
  int32_t tint_layers[33]; /* of light i, [32] of the combined ones: the first of its three, counted from 1; 0 = untinted */
  uint32_t depth_texture;  /* R32F 2D, for the snippet: sideray_mask_inputs::moving; 0 = not asked for */
  /* R8 2D: which masks of a pixel are traced or reprojected: 255 times the texel is 1 (those of lights) + 2 (that of the
   * sky). The others are lit and open: draw there what a rasterizer would. 0 = all are, as always without a budget. */
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
/* Where an instance was in the frame whose outputs of a job (one of SIDERAY_JOB_*) are the newest: the matrix for the
 * previous_world_position of sideray_translucent_moving() and sideray_shadow_moving(). As
 * sideray_instance_desc has it, to the precision of single floats about the scene's middle. SIDERAY_NOT_READY: there are no such
 * outputs yet, or the instance is newer than they are. Wind and vertices that move by themselves are not in it. */
SIDERAY_API sideray_status sideray_service_placement(sideray_service* service, uint32_t view_id, uint32_t job,
                                                     sideray_instance instance, double world_from_object[12],
                                                     sideray_error* error);
/* Binds the newest textures of a view to units first_unit .. first_unit + 2 and, for a program that reads them, the
 * shadow masks to first_unit + 3, the ambient occlusion mask to first_unit + 4, whole pixels to first_unit + 5 and
 * + 6, the masks' tints to first_unit + 7, their depth to first_unit + 8 and which of them are answered to first_unit + 9, the irradiance to first_unit + 10, and sets the uniforms of the snippet in `program`, for the newest outputs, or for "no answer" where there are
 * none. It leaves these units changed, and for the rest follows the state_policy of the view's last submitted frame. */
SIDERAY_API sideray_status sideray_service_bind(sideray_service* service, uint32_t view_id, uint32_t program,
                                                uint32_t first_unit, sideray_error* error);

/* Of a finished frame, all its jobs together. */
typedef struct sideray_frame_stats {
  size_t size;
  double readback_ms, trace_ms, denoise_ms, upload_ms, trace_shadow_ms, trace_ao_ms;
  uint64_t rays_primary, rays_reflection, rays_shadow, rays_ao;
  uint64_t pixels_total, pixels_masked;
  uint64_t layers_requested, layers_found, traversals_wasted;
  uint64_t pixels_late;       /* masked ones that the deadline left without any answer */
  uint64_t dropped_particles; /* sprites in view that rays do not hit */
  uint64_t bytes_readback, bytes_upload, bytes_cache;
  uint64_t points_shaded, points_not_finite; /* by a host's shader; of them, results that were not taken */
  uint64_t layers_borrowed; /* under ray_reuse: layers that reuse the rays of donors */
  uint64_t layers_refracted; /* CACHE with refraction: layers that hold what is seen through them */
  /* Of pixels_masked, besides pixels_late: those that the deadline gave up and that show an answer of an earlier frame. The
   * others are of this frame. */
  uint64_t pixels_older;
  /* The same of pixels with an opaque surface: those whose masks the deadline left lit and open, and those whose masks are of an
   * earlier frame. */
  uint64_t mask_pixels_late, mask_pixels_older;
  uint64_t answer_age; /* of the oldest of them all, in frames; those without a change do not count */
  /* The same of pixels that mirror: those without a reflection, and those whose reflection is of an earlier frame. */
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

/* Whole programs in GLSL 1.20 for hosts that have no shaders of their own; shaders/ready_*.glsl say what their uniforms
 * are. They need `float_ids`. */
typedef enum sideray_ready_program {
  SIDERAY_READY_GLASS = 0,  /* what the fixed function lights and textures, by rays where there is an answer */
  SIDERAY_READY_SHADOWS = 1, /* multiplies the opaque picture by a light's shadow mask and the occlusion mask */
  /* Glass by a fragment shader alone: the fixed function goes on to transform, light and texture vertices. It has no
   * vertex shader (NULL); docs/fixed-function.md says how texture coordinates hold places in the world. */
  SIDERAY_READY_GLASS_FRAGMENT = 2
} sideray_ready_program;

/* Texts that are valid for ever; NULL where there is no such program. Need no context. */
SIDERAY_API const char* sideray_ready_vertex(sideray_ready_program program);
SIDERAY_API const char* sideray_ready_fragment(sideray_ready_program program);

#ifdef __cplusplus
}
#endif
#endif
