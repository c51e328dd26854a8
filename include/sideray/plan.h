/* Plans: what a frame of the offscreen tier would do, before it is drawn. A plan lists which passes run and why, which
 * textures are used, and upper bounds of the work. Plain memory, no OpenGL; sideray_renderer_render uses the same code.
 *
 * Conventions are those of sideray.h. */
#ifndef SIDERAY_PLAN_H
#define SIDERAY_PLAN_H

#include <sideray/renderer.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sideray_plan sideray_plan;

/* Makes the plan of a frame of the committed scene, for any camera. Fails where sideray_renderer_render would fail with
 * these options. The caller owns the plan, which refers to neither scene nor options. */
SIDERAY_API sideray_status sideray_plan_create(sideray_scene* scene, const sideray_render_options* options,
                                               sideray_plan** plan, sideray_error* error);
/* Does the same for a renderer without OpenGL (gl "none"): rays replace the rasterizer, and there are no textures. */
SIDERAY_API sideray_status sideray_plan_create_without_gl(sideray_scene* scene, const sideray_render_options* options,
                                                          sideray_plan** plan, sideray_error* error);
SIDERAY_API void sideray_plan_release(sideray_plan* plan); /* NULL is allowed */

/* Describes a pass. Everything that a plan returns lives as long as the plan; NULL for an index beyond the last. */
typedef struct sideray_plan_pass {
  sideray_stage stage;
  const char* name; /* as in sideray_stage_time */
  int32_t runs;
  const char* reason; /* why it runs, or does not */
} sideray_plan_pass;

/* Return every stage once, in the order of sideray_stage, without the total. */
SIDERAY_API size_t sideray_plan_pass_count(const sideray_plan* plan);
SIDERAY_API const sideray_plan_pass* sideray_plan_pass_at(const sideray_plan* plan, size_t index);

/* Returns the layers that the frame's cache holds, or for SIDERAY_COMPOSITE the most surfaces a ray (0 = unlimited): at
 * most the requested number. 0 if no translucent surface is traced. */
SIDERAY_API uint32_t sideray_plan_layers(const sideray_plan* plan);

/* Returns the maximum spread among donors up to which layers reuse their rays: sideray_translucency_options::ray_reuse,
 * or the value that AUTO stands for. 0: every layer traces its own rays. */
SIDERAY_API float sideray_plan_ray_reuse(const sideray_plan* plan);
/* Returns 1 if ambient occlusion (reflections of opaque surfaces) is traced, as requested in sideray_render_options or
 * chosen by AUTO. In a reference reflections return 1 if requested. */
SIDERAY_API int32_t sideray_plan_ao(const sideray_plan* plan);
/* Returns 1 if light that surfaces reflect onto each other is traced. */
SIDERAY_API int32_t sideray_plan_bounce(const sideray_plan* plan);
SIDERAY_API int32_t sideray_plan_reflections(const sideray_plan* plan);

/* A texture, or an array of `layers`, that the frame reads or writes; buffers that replace one are counted as one.
 * Textures of the scene with equal size and format are one entry of `layers`, with all mip levels. Shadow maps and the
 * scene's textures may be smaller if the driver does not allow their size. Not listed: 1x1 textures that replace
 * missing ones, and the fragment lists of SIDERAY_OIT_ABUFFER, whose size depends on the picture. */
typedef struct sideray_plan_texture {
  const char* name;
  const char* format; /* OpenGL's name, without GL_ */
  uint32_t width, height, layers;
  uint64_t bytes;
  int32_t of_service; /* included in bytes_cache of sideray_render_stats */
} sideray_plan_texture;

SIDERAY_API size_t sideray_plan_texture_count(const sideray_plan* plan);
SIDERAY_API const sideray_plan_texture* sideray_plan_texture_at(const sideray_plan* plan, size_t index);

#define SIDERAY_UNBOUNDED UINT64_MAX

/* Upper bounds of the counters of sideray_render_stats; SIDERAY_UNBOUNDED if only the scene's content limits one.
 * bytes_cache is exact, and so is bytes_readback without a second wave. */
typedef struct sideray_plan_work {
  uint64_t rays_primary, rays_reflection, rays_shadow, rays_ao;
  uint64_t fragments; /* layers_matched + layers_missed */
  uint64_t bytes_readback, bytes_upload, bytes_cache;
  uint64_t rays_bounce;
} sideray_plan_work;

SIDERAY_API const sideray_plan_work* sideray_plan_most_work(const sideray_plan* plan);

/* Facts about a committed scene, by which a frame decides which options have an effect. */
typedef struct sideray_scene_facts {
  size_t size;
  uint64_t triangles, instances, materials;
  uint64_t translucent_objects;
  uint64_t layered_objects;  /* translucent objects that may have layers: visible in layers, with a surface id */
  uint64_t most_layers;      /* most surfaces of layered objects that one ray can hit; SIDERAY_UNBOUNDED: 64 or more */
  uint64_t most_surfaces;    /* the same for all translucent objects */
  uint64_t sprites;
  uint64_t lit_lights;       /* lights that emit */
  uint64_t swaying_objects;  /* opaque objects that wind moves */
  uint64_t swaying_copies;   /* the most swaying objects that share one mesh */
  uint64_t inexact_objects[3]; /* that take the inexact shadow test, by sideray_inexact_target */
  uint64_t glossy_objects;   /* opaque objects smooth enough for `reflections` */
  int32_t has_environment;   /* one that emits light */
  uint64_t traceable_objects; /* translucent objects that may have layers once visible in them */
  uint64_t bending_objects; /* translucent objects that `refraction` affects: they refract or blur */
  int32_t auto_ao, auto_reflections; /* 1 if SIDERAY_AMBIENT_AUTO (SIDERAY_REFLECTIONS_AUTO) traces them */
  int32_t auto_bounce; /* 1 if SIDERAY_AMBIENT_AUTO traces light between surfaces */
} sideray_scene_facts;

/* Fills the first `size` bytes of `facts`; the caller sets `size`. */
SIDERAY_API sideray_status sideray_plan_scene(sideray_scene* scene, sideray_scene_facts* facts, sideray_error* error);
/* Returns the angle in degrees below which `cull_angle_deg` of sideray_pose_options culls instances in this view. It is
 * cull_angle_deg itself for a yfov of 30 degrees and more. In narrower views it is scaled by tan(yfov / 2) / tan(15
 * degrees), so that a telephoto view keeps instances of the same size in pixels. In orthographic views, which cull
 * nothing, it is 0. */
SIDERAY_API float sideray_plan_cull_angle(const sideray_camera* camera, float cull_angle_deg);
/* Returns 1 if surfaces of this material are drawn as translucent: BLEND, or transmission above 0. */
SIDERAY_API int32_t sideray_material_is_translucent(const sideray_material_desc* material);

#ifdef __cplusplus
}
#endif
#endif
