/* Sideray: a ray-tracing side service for OpenGL rasterizers. C99 interface; this header is the manual.
 *
 * Three objects, so that each user takes only what they need:
 *   sideray_scene    meshes, instances, materials, textures, lights, environment. Plain memory, no OpenGL.
 *   sideray_tracer   traces a committed scene. Plain memory in, plain memory out, no OpenGL.
 *   sideray_service  moves depth, stencil and results between a host's OpenGL context and a tracer.
 * and a tier for offscreen users: sideray_renderer, which owns a headless context and draws whole pictures.
 *
 * Conventions of the whole interface
 * - Errors are values: a call that can fail returns a sideray_status and, where the caller passes one, fills a
 *   sideray_error whose message says what was wrong, where, and what to do. `error` may always be NULL.
 *   No call throws, exits, aborts, prints, or touches errno. A failed call changes nothing.
 * - Structs begin with `size`, set by the caller to sizeof(the struct). Fill them with the *_defaults function.
 * - Spaces: right-handed world, any unit (call it metre), column vectors, matrices in column-major order.
 *   `a_from_b` maps b to a. Angles in radians unless a name ends in _deg. Colours are linear Rec.709.
 * - Images: row 0 is the bottom row, as in OpenGL, unless a comment says otherwise.
 * - Objects are reference-counted: *_create returns one reference, *_retain adds one, *_release gives one back.
 * - Threads: a scene may be edited by one thread at a time; committed snapshots are immutable and shared freely.
 *   Calls on one tracer, service or renderer must not overlap. Only service and renderer calls touch OpenGL.
 */
#ifndef SIDERAY_SIDERAY_H
#define SIDERAY_SIDERAY_H

#include <stddef.h>
#include <stdint.h>

#define SIDERAY_VERSION_MAJOR 0
#define SIDERAY_VERSION_MINOR 1
#define SIDERAY_VERSION_PATCH 0

#if defined(__GNUC__)
#define SIDERAY_API __attribute__((visibility("default")))
#else
#define SIDERAY_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Status ---- */

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

SIDERAY_API void sideray_version(int* major, int* minor, int* patch);

/* ---- Scene ---- */

typedef struct sideray_scene sideray_scene;

/* Indices returned by the add functions. 0 is never a valid index, and means "none" where a struct allows it. */
typedef uint32_t sideray_mesh;
typedef uint32_t sideray_texture;
typedef uint32_t sideray_material;
typedef uint32_t sideray_instance;

SIDERAY_API sideray_status sideray_scene_create(sideray_scene** scene, sideray_error* error);
SIDERAY_API void sideray_scene_retain(sideray_scene* scene);
SIDERAY_API void sideray_scene_release(sideray_scene* scene); /* NULL is allowed */

/* One vertex attribute: `data` points at floats; consecutive vertices are `stride_bytes` apart, 0 = tightly packed. */
typedef struct sideray_attribute {
  const float* data;
  size_t stride_bytes;
} sideray_attribute;

typedef struct sideray_mesh_desc {
  size_t size;
  uint32_t vertex_count;       /* 1..2^31-1 */
  uint32_t index_count;        /* a multiple of 3, or 0: every three vertices are a triangle */
  const uint32_t* indices;     /* each below vertex_count; counter-clockwise triangles face front */
  sideray_attribute positions; /* 3 floats, required */
  sideray_attribute normals;   /* 3 floats, unit length; absent = flat shading */
  sideray_attribute tangents;  /* 4 floats, w = +-1 bitangent sign; absent = derived from uv where needed */
  sideray_attribute uv0, uv1;  /* 2 floats, origin at the top left of the image; absent = 0 */
  sideray_attribute colors;    /* 4 floats, linear, multiplied onto base_color; absent = 1 */
} sideray_mesh_desc;

SIDERAY_API sideray_mesh_desc sideray_mesh_defaults(void);

/* Copies the mesh. Triangles with a non-finite or out-of-range (|x| > 1e15) vertex, and triangles without area, are
 * dropped and counted in *dropped (may be NULL); non-finite normals, tangents, uvs and colours become their defaults.
 */
SIDERAY_API sideray_status sideray_scene_add_mesh(sideray_scene* scene, const sideray_mesh_desc* desc,
                                                  sideray_mesh* mesh, uint32_t* dropped, sideray_error* error);

/* Replaces the vertices of a mesh, as many as it has, and its bounds: `desc` gives the attributes and vertex_count; its
 * indices are not read, the triangles stay (those that were dropped when it was added stay dropped). A vertex that is
 * not finite or out of range is refused by index. Costs a refit where the mesh is traced. */
SIDERAY_API sideray_status sideray_scene_set_vertices(sideray_scene* scene, sideray_mesh mesh,
                                                      const sideray_mesh_desc* desc, sideray_error* error);

typedef enum sideray_texel_format {
  SIDERAY_RGBA8 = 0,     /* as stored, 0..255 is 0..1 */
  SIDERAY_RGBA8_SRGB = 1 /* RGB through the sRGB transfer function, A as stored */
} sideray_texel_format;

/* Copies `width * height` texels of four bytes, top row first, and builds mip levels (box filter in linear light). */
SIDERAY_API sideray_status sideray_scene_add_texture(sideray_scene* scene, uint32_t width, uint32_t height,
                                                     sideray_texel_format format, const void* texels,
                                                     sideray_texture* texture, sideray_error* error);

typedef enum sideray_wrap { SIDERAY_REPEAT = 0, SIDERAY_CLAMP = 1, SIDERAY_MIRROR = 2 } sideray_wrap;
typedef enum sideray_filter {
  SIDERAY_TRILINEAR = 0,
  SIDERAY_BILINEAR = 1, /* level 0 only */
  SIDERAY_NEAREST = 2   /* level 0 only */
} sideray_filter;

typedef struct sideray_texture_slot {
  sideray_texture texture; /* 0 = none: the factor alone counts */
  uint32_t uv_set;         /* 0 or 1 */
  sideray_wrap wrap_u, wrap_v;
  sideray_filter filter;
  float texture_from_uv[6]; /* columns of a 2x3 affine map: s = m0 u + m2 v + m4, t = m1 u + m3 v + m5 */
} sideray_texture_slot;

typedef enum sideray_alpha_mode { SIDERAY_OPAQUE = 0, SIDERAY_MASK = 1, SIDERAY_BLEND = 2 } sideray_alpha_mode;

/* dst = C*a + dst*T: alpha and premultiplied T = 1-a, additive T = 1, multiply C = 0 and T = base colour faded by a. */
typedef enum sideray_blend_mode {
  SIDERAY_BLEND_ALPHA = 0,
  SIDERAY_BLEND_PREMULTIPLIED = 1, /* C is added whole: reflections are not scaled by a */
  SIDERAY_BLEND_ADDITIVE = 2,
  SIDERAY_BLEND_MULTIPLY = 3 /* never ray traced into layers */
} sideray_blend_mode;

/* Metallic-roughness material (glTF 2.0 core, KHR_materials_transmission, _ior, _volume, _specular, _unlit, _clearcoat,
 * _sheen, _diffuse_transmission, _emissive_strength folded into `emissive`). Translucent = BLEND, or transmission > 0.
 * A texture is multiplied onto its factor; the letters say which of its channels. */
typedef struct sideray_material_desc {
  size_t size;
  float base_color[4];
  float metallic, roughness; /* 0..1; roughness is perceptual: alpha = roughness^2 */
  float emissive[3];         /* radiance, >= 0 */
  float normal_scale, occlusion_strength;
  sideray_alpha_mode alpha_mode;
  float alpha_cutoff; /* MASK: a fragment with alpha below it is not there */
  sideray_blend_mode blend_mode;
  int32_t double_sided, unlit;
  float transmission;         /* 0..1, share of the diffuse part that passes straight through */
  float ior;                  /* >= 1 */
  float thickness;            /* world units, 0 = thin walled */
  float attenuation_distance; /* world units, +inf = none */
  float attenuation_color[3];
  float specular, specular_color[3];
  float clearcoat, clearcoat_roughness; /* 0..1; a layer of ior 1.5 over everything else */
  float clearcoat_normal_scale;
  float sheen_color[3], sheen_roughness;                     /* 0..1 each */
  float diffuse_transmission, diffuse_transmission_color[3]; /* 0..1: the share of diffuse light that passes through */
  /* >= 0, screen-space distortion of the opaque picture behind a translucent surface: it is read `distortion` times the
   * view-space x and y of the shading normal away, in picture heights. 0 = none. */
  float distortion;
  /* Its shadow rays take the inexact test (sideray_inexact) wherever an explicit mark says so; wind marks it too. */
  int32_t inexact_shadow;
  sideray_texture_slot base_color_texture;         /* RGBA */
  sideray_texture_slot metallic_roughness_texture; /* G roughness, B metallic */
  sideray_texture_slot normal_texture, occlusion_texture, emissive_texture, transmission_texture; /* RGB, R, RGB, R */
  sideray_texture_slot thickness_texture, specular_texture, specular_color_texture;               /* G, A, RGB */
  sideray_texture_slot clearcoat_texture, clearcoat_roughness_texture, clearcoat_normal_texture;  /* R, G, RGB */
  sideray_texture_slot sheen_color_texture, sheen_roughness_texture;                              /* RGB, A */
  sideray_texture_slot diffuse_transmission_texture, diffuse_transmission_color_texture;          /* A, RGB */
} sideray_material_desc;

SIDERAY_API sideray_material_desc sideray_material_defaults(void); /* white, rough, opaque, ior 1.5, no textures */
SIDERAY_API sideray_status sideray_scene_add_material(sideray_scene* scene, const sideray_material_desc* desc,
                                                      sideray_material* material, sideray_error* error);

/* Which rays may meet an instance. LAYERS counts only for translucent materials, SHADOW only for opaque ones. */
enum {
  SIDERAY_VISIBLE_LAYERS = 1u,
  SIDERAY_VISIBLE_REFLECTION = 2u,
  SIDERAY_VISIBLE_SHADOW = 4u,
  SIDERAY_VISIBLE_AO = 8u,
  SIDERAY_VISIBLE_ALL = 15u
};

/* How wind moves what an instance shows: sr_wind() of shaders/shading/wind.h, in the mesh's own space, where the plant's root
 * is the origin and +Y is up. The trunk bends as the square of the height; branches swing as far as they reach from the
 * trunk, their phase changing along the wind; leaves flutter. A plant of several instances gives them the same numbers
 * and phases, and leaf_amplitude 0 to what has no leaves. */
typedef uint32_t sideray_wind;

typedef struct sideray_wind_desc {
  size_t size;
  float direction[3]; /* object space, unit, the way it blows */
  float amplitude;    /* object units that the top of the trunk sways by, at most; >= 0 */
  float frequency;    /* of the trunk, per second, > 0 */
  float height;       /* object units, > 0: of the whole plant */
  float branch_amplitude, branch_frequency;
  float leaf_amplitude, leaf_frequency;
  float wavelength; /* object units along which branches go once through their phases, > 0 */
} sideray_wind_desc;

SIDERAY_API sideray_wind_desc sideray_wind_defaults(void);
SIDERAY_API sideray_status sideray_scene_add_wind(sideray_scene* scene, const sideray_wind_desc* desc,
                                                  sideray_wind* wind, sideray_error* error);
/* The time that wind stands at, and where it stood in the picture before, for motion vectors; seconds, finite. */
SIDERAY_API sideray_status sideray_scene_set_time(sideray_scene* scene, double time_s, double previous_time_s,
                                                  sideray_error* error);

typedef struct sideray_instance_desc {
  sideray_mesh mesh;
  sideray_material material;
  double world_from_object[12]; /* 3x4 affine, four columns of three; finite, invertible; mirroring allowed */
  uint32_t surface_id;          /* the host's key of this surface, unique; 0 = never ray traced into layers */
  uint32_t visibility;          /* SIDERAY_VISIBLE_* */
  uint64_t user;                /* the host's, never read; its shader is told it */
  sideray_wind wind;            /* 0 = it stands still */
  float wind_phase;             /* 0..1, of its own, so that neighbours do not move alike */
} sideray_instance_desc;

/* Adds `count` instances; their indices are *first .. *first + count - 1. All or none are added. */
SIDERAY_API sideray_status sideray_scene_add_instances(sideray_scene* scene, const sideray_instance_desc* descs,
                                                       size_t count, sideray_instance* first, sideray_error* error);
/* Replaces the transforms of `count` consecutive instances; 12 doubles each, as in sideray_instance_desc. */
SIDERAY_API sideray_status sideray_scene_move_instances(sideray_scene* scene, sideray_instance first, size_t count,
                                                        const double* world_from_object, sideray_error* error);
SIDERAY_API sideray_status sideray_scene_set_visibility(sideray_scene* scene, sideray_instance instance,
                                                        uint32_t visibility, sideray_error* error);

/* Camera-facing sprites that share a texture: particles as a rasterizer draws them. Rays never meet them, except in the
 * reference and where a render option says so. */
typedef uint32_t sideray_particles;

typedef struct sideray_particles_desc {
  size_t size;
  sideray_texture texture;       /* 0 = white */
  uint32_t columns, rows;        /* cells of its flip-book, row by row from the top left; 1 and 1 = the whole texture */
  sideray_blend_mode blend_mode; /* not MULTIPLY */
  float soft_distance; /* world units along the view axis over which sprites fade before opaque surfaces; 0 = hard */
  int32_t lit;         /* 0: colour is radiance; else it is the albedo of a surface that faces the eye */
} sideray_particles_desc;

SIDERAY_API sideray_particles_desc sideray_particles_defaults(void); /* white, alpha, soft over nothing, unlit */
SIDERAY_API sideray_status sideray_scene_add_particles(sideray_scene* scene, const sideray_particles_desc* desc,
                                                       sideray_particles* particles, sideray_error* error);

typedef struct sideray_sprite {
  double position[3];  /* of its centre, world */
  float width, height; /* world units, > 0 */
  float rotation;      /* radians, counter-clockwise as seen */
  float color[4];      /* linear, multiplied onto the texel; RGB >= 0, A 0..1 */
  float cell;          /* of the flip-book, rounded down, taken modulo columns * rows */
} sideray_sprite;

/* Replaces the sprites of a system, 0..2^20 of them; the order does not count. */
SIDERAY_API sideray_status sideray_scene_set_sprites(sideray_scene* scene, sideray_particles particles,
                                                     const sideray_sprite* sprites, size_t count, sideray_error* error);

typedef enum sideray_light_type {
  SIDERAY_LIGHT_DIRECTIONAL = 0,
  SIDERAY_LIGHT_POINT = 1,
  SIDERAY_LIGHT_SPOT = 2
} sideray_light_type;

typedef struct sideray_light {
  size_t size;
  sideray_light_type type;
  double position[3]; /* point and spot */
  float direction[3]; /* the way the light travels; directional and spot */
  float intensity[3]; /* directional: irradiance (glTF lux); others: radiant intensity (glTF candela); no 683 */
  float range;        /* world units, 0 = unlimited */
  float inner_cone, outer_cone; /* half angles, 0 <= inner < outer <= pi/2 */
  float radius;                 /* world units; of soft shadows by rays */
  float angular_diameter_deg;   /* directional; of soft shadows by rays */
  /* How its traced shadow is denoised: pixels that the filter reaches at most, 0 = 32, negative = not filtered; frames
   * that a mean over time is of at most, 0 = 8, 1 = this frame alone. */
  float shadow_filter_radius;
  uint32_t shadow_filter_frames;
} sideray_light;

/* Replaces all lights; 0..256 of them. */
SIDERAY_API sideray_status sideray_scene_set_lights(sideray_scene* scene, const sideray_light* lights, size_t count,
                                                    sideray_error* error);

/* Sets the lat-long environment: `width * height` linear RGB float triples, top row (+Y) first, image centre = -Z,
 * u grows toward +X. Values are clamped to 0..65504, non-finite ones become 0. NULL texels: no environment (black).
 * `scale` multiplies radiance; `rotation_deg` turns it counter-clockwise about +Y seen from above. */
SIDERAY_API sideray_status sideray_scene_set_environment(sideray_scene* scene, uint32_t width, uint32_t height,
                                                         const float* rgb, float scale, float rotation_deg,
                                                         sideray_error* error);

/* Makes all edits since the last commit one immutable snapshot that tracers, services and renderers use from then on.
 */
SIDERAY_API sideray_status sideray_scene_commit(sideray_scene* scene, sideray_error* error);

/* Bounds of the committed instances in world space. SIDERAY_NOT_READY where nothing is committed or it is empty. */
SIDERAY_API sideray_status sideray_scene_bounds(sideray_scene* scene, double minimum[3], double maximum[3],
                                                sideray_error* error);

/* ---- Tracer: plain memory, no OpenGL ---- */

typedef struct sideray_tracer sideray_tracer;

typedef struct sideray_tracer_desc {
  size_t size;
  uint32_t threads; /* 0 = all */
  const char* isa;  /* NULL = best; "sse4.2", "avx2", "avx512" pin Embree's instruction set */
} sideray_tracer_desc;

SIDERAY_API sideray_tracer_desc sideray_tracer_defaults(void);
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

/* The nearest hits of `count` rays: hits[i * layers + k] is the k-th surface of ray i in the order (distance, surface
 * id, primitive); unused entries have surface_id 0. layers is 1..64. A ray that is not finite is refused by index. */
SIDERAY_API sideray_status sideray_tracer_trace_rays(sideray_tracer* tracer, sideray_ray_set set,
                                                     const sideray_ray* rays, size_t count, uint32_t layers,
                                                     sideray_hit* hits, sideray_error* error);

/* ---- Shading by the host ---- */

/* What the host's blending works in: layers are given in it. sRGB and gamma go on above 1 as below. */
typedef enum sideray_radiance_space {
  SIDERAY_SPACE_LINEAR = 0,
  SIDERAY_SPACE_SRGB = 1,   /* the transfer function of sRGB */
  SIDERAY_SPACE_GAMMA22 = 2 /* x^(1/2.2): what engines of old write to a plain RGBA8 target */
} sideray_radiance_space;

/* A surface that a ray met. Vectors are in world space; coordinates and colours are interpolated between vertices. */
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
  float footprint;     /* width of a pixel here, across the ray, world units */
  float u, v;          /* barycentric weights of the second and third vertex */
  uint32_t primitive;  /* triangle number within the mesh as given */
  sideray_instance instance;
  sideray_material material;
  uint32_t surface_id;
  uint64_t user; /* of the instance */
  /* Bit i: the scene's light i (of the first 32, if its intensity is not 0) has the point within its range and cone,
   * and nothing opaque is between them: that is traced for sideray_shader_desc::shadow_lights, from the light's middle.
   */
  uint32_t lights;
  uint32_t bounce;            /* 0: what it reflects is traced; 1: seen in a mirror, or opaque behind bent glass */
  int32_t front, translucent; /* 1: its front face was met; its material is translucent */
} sideray_shading_point;

/* dst = C*a + dst*T with C = radiance + reflectance * what comes from `reflection`. Each comes in as said here. */
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
   * sideray_renderer_render of the tracer that asks. Tracing stands still until one of them is called: advance does
   * what is waiting then, wait goes on doing it until its time is out. */
  SIDERAY_SHADE_IN_CALLS = 1
} sideray_shader_thread;

/* Reads points[0 .. count - 1] and fills results of the same number, 1..SIDERAY_SHADING_BATCH of them. Both are valid
 * during the call alone. It returns normally, calls neither OpenGL nor Sideray, and knows nothing but the point: which
 * points come together, in which order and on which thread, is not said. Where that holds, pictures are the same bits
 * for any number of threads. Denormals are zero while it runs. */
typedef void (*sideray_shade)(void* user, const sideray_shading_point* points, size_t count,
                              sideray_shading_result* results);

typedef struct sideray_shader_desc {
  size_t size;
  sideray_shade shade;
  void* user;
  sideray_shader_thread thread;
  uint32_t shadow_lights; /* bit i: sideray_shading_point::lights is traced for light i; 0 = no shadow rays */
  /* What `shade` works in. Its numbers are mixed with each other as they are, and handed to the host so; the
   * environment, where a ray meets nothing else, is multiplied by the scale (> 0) and brought into this space first.
   * The frame's own radiance_space and radiance_scale are not read. */
  sideray_radiance_space radiance_space;
  float radiance_scale;
} sideray_shader_desc;

SIDERAY_API sideray_shader_desc sideray_shader_defaults(void); /* no function, on workers, no shadows, linear, 1 */

/* From the next commit on, `shader` takes the place of the built-in model wherever rays meet surfaces of frames:
 * layers, what they and opaque surfaces reflect, what is behind bent glass; the references and what sideray_renderer
 * draws, in linear radiance, keep the model. NULL: the model. `shade` and `user` stay valid until every tracer, service
 * and renderer of the scene has finished the frames of that commit, or is gone: cancelled and late frames begin no more
 * calls, abandon_context and destroy wait for those under way. A surface that is met in a mirror reflects the
 * environment alone, and has no shadow rays where it is translucent too. With `refraction`, what surfaces let through
 * is their material's. A result with a number that is not finite counts as black, with its material's a and T
 * (sideray_frame_stats::points_not_finite). `layer_threshold` and `particles` are refused: nothing bounds what a host's
 * shader makes of a light, and sprites are no surfaces of its own. */
SIDERAY_API sideray_status sideray_scene_set_shader(sideray_scene* scene, const sideray_shader_desc* shader,
                                                    sideray_error* error);

/* ---- Service: rays for a host's frame ---- */

typedef struct sideray_service sideray_service;

/* A camera as the host's matrices say it. Perspective (also off-axis) and orthographic; the kind is read from the
 * matrix. Distances are measured along the view ray from the eye (perspective) or the near plane (orthographic). */
typedef struct sideray_view {
  size_t size;
  double clip_from_world[16];
  double world_from_clip[16];
  int32_t reversed_depth;    /* window depth 1 is near */
  int32_t zero_to_one_depth; /* clip space z runs 0..w (glClipControl) instead of -w..w */
} sideray_view;

typedef enum sideray_mask_source {
  SIDERAY_MASK_NONE = 0,    /* trace every pixel */
  SIDERAY_MASK_STENCIL = 1, /* trace where (stencil & stencil_bits) != 0 */
  SIDERAY_MASK_COUNT = 2,   /* the same, and the value counts the layers there, all bits set = at least that many */
  /* The same from one byte a pixel: 0 = nothing, 255 = trace, others count the layers. For targets without stencil. */
  SIDERAY_MASK_TEXTURE = 3, /* mask_texture */
  SIDERAY_MASK_MEMORY = 4   /* mask_texels */
} sideray_mask_source;

typedef enum sideray_service_mode {
  SIDERAY_CACHE = 0,    /* fill the layer cache for sideray_translucent() (hybrid translucency) */
  SIDERAY_COMPOSITE = 1 /* composite up to max_layers surfaces in ray order (fully ray-traced translucency) */
} sideray_service_mode;

/* How a fragment finds its layer. All but DISTANCE need the fragment's surface to be the layer's within what
 * rasterization and rays may disagree by (docs/architecture.md). */
typedef enum sideray_match {
  SIDERAY_MATCH_ID = 0,      /* the same surface id, then the nearest distance */
  SIDERAY_MATCH_NEAREST = 1, /* the nearest distance of any surface */
  SIDERAY_MATCH_DISTANCE = 2 /* the first layer whose relative distance is below the threshold (listing 50-2) */
} sideray_match;

/* How a ray finds its surfaces. */
typedef enum sideray_step {
  SIDERAY_STEP_MULTIHIT = 0, /* several in one traversal, in a total order */
  SIDERAY_STEP_RETRACE = 1,  /* one traversal a surface, in the same order */
  SIDERAY_STEP_LISTING = 2   /* one traversal a surface, started as listing 50-1 is printed: loses surfaces */
} sideray_step;

/* Which masked pixels are traced; the others take layers of their neighbours, of the same surface and in its plane
 * (sideray_find() of the snippet), or of the frame before. */
typedef enum sideray_cache_rate {
  SIDERAY_RATE_FULL = 0,
  SIDERAY_RATE_CHECKERBOARD = 1,
  SIDERAY_RATE_INTERLEAVED = 2, /* every other row */
  SIDERAY_RATE_QUARTER = 3,     /* one of 2x2 */
  SIDERAY_RATE_TEMPORAL4 = 4,   /* a fourth anew each frame, the rest reprojected */
  SIDERAY_RATE_TEMPORAL8 = 5
} sideray_cache_rate;

typedef enum sideray_radiance_format {
  SIDERAY_RADIANCE_RGBA16F = 0,
  SIDERAY_RADIANCE_RGB9E5 = 1
} sideray_radiance_format;

/* Whether the shadow rays of marked pixels are exact, or regard that the traced geometry is not posed as the drawn one
 * is (RTG2 50.3.2). B is sideray_frame_inputs::inexact_bias, u a random number in 0..1. */
typedef enum sideray_inexact {
  SIDERAY_EXACT = 0,
  SIDERAY_INEXACT_TMIN = 1,     /* hits nearer than u * B do not count (listing 50-3) */
  SIDERAY_INEXACT_BOUNDED = 2,  /* the same with the most that wind moves the pixel by for B */
  SIDERAY_INEXACT_RESTPOSE = 3, /* the ray starts at the pixel's undeformed position */
  SIDERAY_INEXACT_ORIGIN = 4    /* the ray's origin moves by u * B: loses hit distance; for comparison */
} sideray_inexact;

/* Where the filters of masks run. AUTO: where the masks are, on the CPU. */
typedef enum sideray_denoise_on {
  SIDERAY_DENOISE_AUTO = 0,
  SIDERAY_DENOISE_CPU = 1,
  SIDERAY_DENOISE_GPU = 2
} sideray_denoise_on;

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

typedef struct sideray_frame_inputs {
  size_t size;
  sideray_view view;
  uint32_t framebuffer; /* GL name holding depth (and stencil); 0 allowed; of a multisampled one, one sample is read */
  /* One image in place of `framebuffer`, where it is not 0; depth, or depth and stencil. */
  uint32_t depth_texture;
  uint32_t depth_texture_target; /* GL_TEXTURE_2D (the default), _2D_ARRAY, _2D_MULTISAMPLE or _RECTANGLE */
  int32_t depth_layer;           /* of an array */
  uint32_t depth_renderbuffer;
  int32_t x, y, width, height; /* the rectangle of it that the view covers */
  sideray_mask_source mask;
  uint32_t stencil_bits;      /* contiguous from bit 0, for example 0x3f */
  uint32_t mask_texture;      /* SIDERAY_MASK_TEXTURE: R8 2D of the framebuffer's size */
  const uint8_t* mask_texels; /* SIDERAY_MASK_MEMORY: of the rectangle, read within submit */
  size_t mask_row_bytes;
  sideray_service_mode mode;
  uint32_t max_layers;     /* CACHE 1..8; COMPOSITE 1..64, or 0 = unlimited */
  int32_t all_translucent; /* also instances without SIDERAY_VISIBLE_LAYERS */
  int32_t shadows;         /* 0 = no visibility anywhere */
  sideray_step step;
  sideray_match match;           /* CACHE: what sideray_service_bind sets up */
  float match_threshold;         /* DISTANCE: share of the distance, > 0 */
  sideray_cache_rate cache_rate; /* CACHE */
  /* Temporal rates, and masks: the frame follows the last one traced for this service, so that what was traced for it
   * may be taken over. 0 = the first of a sequence, or behind a cut: every masked pixel is traced. Another size, other
   * lights, materials or options are noticed; moved instances are followed; a frame that was cancelled is followed by
   * none. */
  int32_t continues;
  sideray_radiance_format radiance_format; /* CACHE, as the next three */
  sideray_radiance_space radiance_space;
  float radiance_scale; /* > 0: radiance is multiplied by it before the transfer function */
  int32_t float_ids;    /* surface ids as floats in R32F, below 2^24: for GLSL 1.20; always, without integer textures */
  int32_t denoise;      /* filter masks, and CACHE: what rough surfaces reflect */
  /* Shadow and reflection rays of layers are left out where all that a pixel leaves out changes it by at most this much
   * radiance in any channel: 0 = none is. CACHE: the promise is kept where each fragment takes its own layer and is
   * added times its cover (or less, for what covers it); at a rate other than FULL, and with a match other than ID,
   * with nothing assumed of covers. Light in mirrors counts with no more than the brightest of the environment,
   * emission and
   * 16. Not with `refraction`. */
  float layer_threshold;
  int32_t refraction; /* COMPOSITE: bend transmitted rays */
  int32_t particles;  /* COMPOSITE: meet sprites, as quads that face the eye */
  uint32_t seed;
  /* CACHE: the second wave of a frame that was not traced in full (cache_rate), with the inputs of that frame. Its
   * ticket, where it is the newest finished frame and nothing else is in flight: the frame's answers stay, and pixels
   * whose stencil has one of `asked_bits` are traced and added to them. 0 = a frame of its own. */
  sideray_ticket adds_to;
  uint32_t asked_bits; /* outside stencil_bits, for example 0x40 where sideray_asks() holds */
  /* Shadow masks of opaque pixels, one layer a light: bit i = the scene's light i, at most the first 32. 0 = none.
   * Together with layers (mode) or alone (`layers_off`). */
  uint32_t shadow_lights;
  int32_t layers_off;      /* only masks: no translucent surface is traced */
  sideray_inexact inexact; /* of pixels whose stencil has one of inexact_bits */
  float inexact_bias;      /* B, world units, >= 0 */
  uint32_t inexact_bits;   /* outside stencil_bits, for example 0x80; 0 = no pixel */
  uint32_t rest_texture;   /* RESTPOSE, BOUNDED: RGBA32F 2D of the framebuffer's size; xyz = undeformed position minus
                            * the drawn one, world units; w unused. 0 = none */
  uint32_t ao_rays;        /* 0 = no ambient occlusion mask */
  float ao_distance;       /* world units, > 0; +inf = unlimited */
  sideray_denoise_on denoise_on; /* masks */
  /* Masks that follow a frame: RG32F or RG16F 2D of the framebuffer's size, where what the pixel shows is minus where
   * it was in the frame before, in pixels; 0 = nothing but the view has moved. */
  uint32_t motion_texture;
  /* Reflections of opaque surfaces, by rays. RGBA32F or RGBA16F 2D of the framebuffer's size: world-space shading
   * normal and roughness; pixels above max_roughness, and without a surface, are not traced. 0 = none. */
  uint32_t reflection_normals;
  float reflection_max_roughness;
  /* Milliseconds from submit, > 0, after which no more rays begin: what is there by then is uploaded, the middle of the
   * picture and pixels of many surfaces first. CACHE: the rest has no answer, so that fragments keep their raster look;
   * COMPOSITE: the rest is empty. Masks, which get half of what is left of the time where layers are wanted too, are
   * lit and open where they are late, reflections not traced. 0 = none. The one input that gives up the same bits. */
  float deadline_ms;
  sideray_state_policy state_policy; /* of submit, and of what advance and wait do for this frame */
  /* Which of the host's views it is, 0 to SIDERAY_MAX_VIEWS - 1: an eye, a part of the screen, a mirror's picture. Each
   * has outputs, a past (`continues`, `adds_to`) and three places for frames in flight of its own. */
  uint32_t view_id;
} sideray_frame_inputs;

SIDERAY_API sideray_frame_inputs sideray_frame_defaults(void);

typedef struct sideray_host_gl {
  size_t size;
  /* Entry points of the current context, e.g. eglGetProcAddress. Called only inside sideray_service_create. */
  void* (*get_proc_address)(void* user, const char* name);
  void* user;
} sideray_host_gl;

/* Needs the host's context current, here and in every call below. All OpenGL state that a call touches is put back
 * exactly, but for frames whose inputs say otherwise (state_policy); no OpenGL error is left behind or taken away. */
SIDERAY_API sideray_status sideray_service_create(sideray_tracer* tracer, const sideray_host_gl* host,
                                                  sideray_service** service, sideray_error* error);
/* Deletes the service's GL objects; the context that created it must be current. Joins the tracing threads. */
SIDERAY_API void sideray_service_destroy(sideray_service* service);
/* For a host whose context is gone: forgets all GL objects without calling OpenGL. Destroy afterwards. */
SIDERAY_API void sideray_service_abandon_context(sideray_service* service);

/* Starts reading depth and stencil back and returns at once. SIDERAY_NOT_READY: three frames of the view are in flight
 * already. Frames are traced in the order of their tickets, one at a time. */
SIDERAY_API sideray_status sideray_service_submit(sideray_service* service, const sideray_frame_inputs* inputs,
                                                  sideray_ticket* ticket, sideray_error* error);
/* Moves every frame in flight on as far as it goes without blocking. */
SIDERAY_API sideray_status sideray_service_advance(sideray_service* service, sideray_error* error);
/* Blocks until the frame is uploaded, at most `timeout_ms` (negative = for ever): SIDERAY_NOT_READY on time-out. */
SIDERAY_API sideray_status sideray_service_wait(sideray_service* service, sideray_ticket ticket, int32_t timeout_ms,
                                                sideray_error* error);
SIDERAY_API sideray_status sideray_service_cancel(sideray_service* service, sideray_ticket ticket,
                                                  sideray_error* error);

/* Texture names are the service's; valid until the next submit of the view, advance or wait. */
typedef struct sideray_frame_outputs {
  size_t size;
  sideray_ticket ticket;
  sideray_service_mode mode;
  sideray_view view; /* the view it was traced for */
  int32_t x, y, width, height;
  uint32_t layers;           /* CACHE: layers in the arrays */
  uint32_t radiance_texture; /* CACHE: RGBA16F 2D array, C of dst = C*a + dst*T. COMPOSITE: RGBA16F 2D, premultiplied */
  uint32_t distance_texture; /* CACHE: R32F 2D array, 0 in layer 0 = no answer. COMPOSITE: RGBA16F 2D, transmittance */
  uint32_t surface_id_texture; /* CACHE: R32UI, or R32F (see float_ids), 2D array. COMPOSITE: 0 */
  uint32_t shadow_texture;     /* R8 2D array, 1 = lit, one layer a bit of shadow_lights, lowest first; 0 = no masks */
  uint32_t shadow_lights;
  uint32_t ao_texture;         /* R8 2D, 1 = open; 0 = no mask */
  uint32_t reflection_texture; /* RGBA16F 2D: radiance from the mirrored direction; A 0 = not traced; 0 = none */
} sideray_frame_outputs;

/* The newest finished frame of view 0; SIDERAY_NOT_READY before the first. */
SIDERAY_API sideray_status sideray_service_latest(sideray_service* service, sideray_frame_outputs* outputs,
                                                  sideray_error* error);
/* The same of any view. */
SIDERAY_API sideray_status sideray_service_latest_of(sideray_service* service, uint32_t view_id,
                                                     sideray_frame_outputs* outputs, sideray_error* error);
/* Binds the latest textures of view 0 to units first_unit .. first_unit + 2 and, for a program that reads them, the
 * shadow masks to first_unit + 3 and the ambient occlusion mask to first_unit + 4, and sets the uniforms of the snippet
 * in `program`, for the latest frame, or for "no answer" where there is none. It leaves these units changed, and for
 * the rest follows the state_policy of the view's last submitted frame. */
SIDERAY_API sideray_status sideray_service_bind(sideray_service* service, uint32_t program, uint32_t first_unit,
                                                sideray_error* error);
/* The same of any view. */
SIDERAY_API sideray_status sideray_service_bind_view(sideray_service* service, uint32_t view_id, uint32_t program,
                                                     uint32_t first_unit, sideray_error* error);

typedef struct sideray_frame_stats {
  size_t size;
  double readback_ms, trace_ms, denoise_ms, upload_ms, trace_shadow_ms, trace_ao_ms;
  uint64_t rays_primary, rays_reflection, rays_shadow, rays_ao;
  uint64_t pixels_total, pixels_masked;
  uint64_t layers_requested, layers_found, traversals_wasted;
  uint64_t pixels_late;       /* masked ones that the deadline left without an answer */
  uint64_t dropped_particles; /* sprites in view that rays do not meet */
  uint64_t rays_spared;       /* left out under layer_threshold: shadow rays, and mirrored directions */
  uint64_t layers_skipped;    /* whose rays were all left out */
  uint64_t bytes_readback, bytes_upload, bytes_cache;
  uint64_t points_shaded, points_not_finite; /* by a host's shader; of them, results that were not taken */
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
  SIDERAY_READY_SHADOWS = 1 /* multiplies the opaque picture by a light's shadow mask and the occlusion mask */
} sideray_ready_program;

/* Texts that are valid for ever; NULL where there is no such program. Need no context. */
SIDERAY_API const char* sideray_ready_vertex(sideray_ready_program program);
SIDERAY_API const char* sideray_ready_fragment(sideray_ready_program program);

/* ---- Offscreen tier ---- */

typedef struct sideray_renderer sideray_renderer;

typedef struct sideray_device_info {
  const char* id; /* stable name to pass to sideray_renderer_create */
  const char* gl; /* "egl" or "osmesa" */
  const char* renderer;
  const char* version;
  int32_t usable;
  const char* reason; /* why it cannot be used, and the remedy; empty where it can */
} sideray_device_info;

/* Tries every headless path. Returns a list of *count entries that sideray_devices_free gives back. */
SIDERAY_API sideray_status sideray_devices(const sideray_device_info** devices, size_t* count, sideray_error* error);
SIDERAY_API void sideray_devices_free(const sideray_device_info* devices, size_t count);

typedef struct sideray_renderer_desc {
  size_t size;
  const char* gl;     /* "auto", "egl" or "osmesa" */
  const char* device; /* an id from sideray_devices, or NULL */
  uint32_t threads;   /* 0 = all */
  const char* isa;    /* as in sideray_tracer_desc */
} sideray_renderer_desc;

SIDERAY_API sideray_renderer_desc sideray_renderer_defaults(void);
SIDERAY_API sideray_status sideray_renderer_create(const sideray_renderer_desc* desc, sideray_renderer** renderer,
                                                   sideray_error* error);
SIDERAY_API void sideray_renderer_destroy(sideray_renderer* renderer);
/* What the renderer runs on; strings live as long as the renderer. */
SIDERAY_API sideray_status sideray_renderer_device(sideray_renderer* renderer, sideray_device_info* info,
                                                   sideray_error* error);

typedef struct sideray_camera {
  size_t size;
  double world_from_camera[12]; /* rigid 3x4, four columns of three; looks along -Z, +Y up */
  int32_t orthographic;
  float yfov;          /* full vertical angle, perspective */
  float half_height;   /* world units, orthographic */
  float z_near, z_far; /* > 0; z_far 0 = infinite (perspective only) */
} sideray_camera;

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
  SIDERAY_SHADOWS_EXACT = 2,  /* opaque pixels by rays, one mask a light */
  SIDERAY_SHADOWS_INEXACT = 3 /* the same with the inexact test where its target says so */
} sideray_shadows;

/* Which pixels take the inexact test. */
typedef enum sideray_inexact_target {
  SIDERAY_TARGET_MODEL = 0,  /* whose shading model is two-sided foliage: leaves, no trunks */
  SIDERAY_TARGET_BIT = 1,    /* a bit in the G-buffer: marked materials and what wind moves */
  SIDERAY_TARGET_STENCIL = 2 /* the same objects, by a pass of their own into the stencil with depth function EQUAL */
} sideray_inexact_target;

/* Which poses of moving plants rays meet. */
typedef enum sideray_foliage {
  SIDERAY_FOLIAGE_STATIC = 0, /* the neutral one */
  SIDERAY_FOLIAGE_SHARED = 1, /* `shared_copies` simulated ones a mesh */
  SIDERAY_FOLIAGE_UNIQUE = 2  /* each instance its own, up to `unique_cap` a mesh; the rest shared */
} sideray_foliage;

typedef enum sideray_mask { SIDERAY_NO_MASK = 0, SIDERAY_STENCIL_MASK = 1, SIDERAY_COUNT_MASK = 2 } sideray_mask;

/* How raster translucency, with cached and raster colours alike, is put in order. */
typedef enum sideray_oit {
  SIDERAY_OIT_SORTED = 0,   /* whole objects, back to front */
  SIDERAY_OIT_WEIGHTED = 1, /* weighted blending: one pass, any order */
  SIDERAY_OIT_FRONT = 2,    /* the front `layers` exact, by peeling; the rest weighted */
  SIDERAY_OIT_ABUFFER = 3,  /* all fragments in lists, sorted; OpenGL 4.3 */
  SIDERAY_OIT_PEEL = 4      /* depth peeling to the last fragment */
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
       SIDERAY_AOV_INEXACT = 1024u /* pixels that take the inexact shadow test */
};

typedef struct sideray_render_options {
  size_t size;
  uint32_t width, height; /* 1..16384 each */
  sideray_translucency translucency;
  uint32_t layers; /* hybrid 0..8, ray traced 1..64 or 0 = unlimited */
  sideray_mask mask;
  sideray_shadows shadows;
  sideray_inexact inexact; /* SIDERAY_SHADOWS_INEXACT, as the next two */
  float inexact_bias;
  sideray_inexact_target inexact_target;
  sideray_foliage foliage;
  uint32_t shared_copies;  /* 1..256 */
  uint32_t unique_cap;     /* a mesh; 0 = none */
  float cull_angle_deg;    /* instances whose bounding sphere appears under less are not traced; 0 = none */
  int32_t reflections, ao; /* of opaque surfaces, by rays */
  uint32_t samples;        /* camera positions per pixel, averaged; 1 = the pixel centre */
  /* Everything by rays, exact and unlimited: translucency, layers, mask and SIDERAY_SHADOWS_MAP do not count;
   * SIDERAY_SHADOWS_OFF does. Lights have their sizes, environment and microfacets are sampled. */
  int32_t reference;
  uint32_t light_samples; /* reference and SIDERAY_TRANSLUCENCY_REFERENCE: light and microfacet samples a position */
  sideray_match match;    /* hybrid, as the next four */
  float match_threshold;  /* share of the distance, > 0 */
  sideray_cache_rate cache_rate;
  int32_t second_wave; /* trace what no neighbour has an answer for */
  sideray_radiance_format radiance_format;
  sideray_step step;                /* hybrid and ray traced, as the next */
  float layer_threshold;            /* sideray_frame_inputs::layer_threshold; not with `refraction`, nor with an `oit`
                                     * of WEIGHTED or FRONT, which bound no fragment's share; 0 = every ray is traced */
  int32_t refraction, rt_particles; /* ray traced */
  sideray_oit oit;                  /* raster and hybrid */
  int32_t denoise;                  /* filter masks, and what rough surfaces of the layer cache reflect */
  sideray_denoise_on denoise_on;    /* masks */
  int32_t taa;                      /* with `continues`: average with the frames before along the motion */
  int32_t check;                    /* hybrid: count wrong answers against all surfaces by rays */
  /* The picture follows the last one that this renderer drew, as the next of a sequence: temporal methods may use what
   * was traced for it. 0: a single picture, or the first. */
  int32_t continues;
  float deadline_ms; /* sideray_frame_inputs::deadline_ms; 0 = none */
  uint32_t seed;
  uint32_t aovs;    /* SIDERAY_AOV_*, of sample 0 */
  uint32_t repeats; /* 0: untimed; N: the frame is drawn once more untimed, then N times for the statistics */
} sideray_render_options;

SIDERAY_API sideray_render_options sideray_render_defaults(void);

typedef enum sideray_stage {
  SIDERAY_STAGE_LOAD = 0, /* filled by whoever loads */
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
  SIDERAY_STAGE_COUNT
} sideray_stage;

typedef struct sideray_quartiles {
  double p25, median, p75;
} sideray_quartiles;

/* Definitions of every figure: docs/cli.md. Counters come from one extra untimed frame. */
typedef struct sideray_render_stats {
  size_t size;
  uint32_t repeats;
  sideray_quartiles stage_ms[SIDERAY_STAGE_COUNT];
  uint64_t triangles, instances, materials, translucent_objects;
  uint64_t rays_primary, rays_reflection, rays_shadow, rays_ao;
  uint64_t pixels_total, pixels_masked;
  uint64_t layers_requested, layers_found, layers_matched, layers_missed, traversals_wasted;
  uint64_t layers_misassigned, layers_duplicated; /* with `check` */
  uint64_t pixels_late;
  uint64_t dropped_particles;
  uint64_t rays_spared, layers_skipped; /* as in sideray_frame_stats */
  uint64_t bytes_readback, bytes_upload, bytes_cache;
  uint32_t reference_light_samples; /* 0: nothing of the picture is a reference */
  double reference_self_error; /* relMSE between two independent halves of the samples; negative: just one sample */
  uint32_t threads;
  char isa[16];
  char embree[32];
} sideray_render_stats;

typedef enum sideray_channel_type { SIDERAY_CHANNEL_FLOAT = 0, SIDERAY_CHANNEL_UINT = 1 } sideray_channel_type;

/* One named plane of a picture: width * height values, TOP row first. Names are those of docs/cli.md (R, G, B, A, Z,
 * ...). */
typedef struct sideray_channel {
  const char* name;
  sideray_channel_type type;
  const void* values;
} sideray_channel;

typedef struct sideray_picture sideray_picture;

/* Draws the committed scene. The picture is the caller's; release with sideray_picture_release. */
SIDERAY_API sideray_status sideray_renderer_render(sideray_renderer* renderer, sideray_scene* scene,
                                                   const sideray_camera* camera, const sideray_render_options* options,
                                                   sideray_picture** picture, sideray_error* error);
SIDERAY_API void sideray_picture_release(sideray_picture* picture);
SIDERAY_API void sideray_picture_size(const sideray_picture* picture, uint32_t* width, uint32_t* height);
SIDERAY_API size_t sideray_picture_channel_count(const sideray_picture* picture);
SIDERAY_API sideray_channel sideray_picture_channel(const sideray_picture* picture, size_t index);
SIDERAY_API void sideray_picture_stats(const sideray_picture* picture, sideray_render_stats* stats);

#ifdef __cplusplus
}
#endif
#endif
