/* What a frame of the offscreen tier would do, before it is drawn: which passes run and why, what is kept in textures,
 * and the most work that it can be. Plain memory, no OpenGL; decided where sideray_renderer_render decides it.
 *
 * Conventions are those of sideray.h. */
#ifndef SIDERAY_PLAN_H
#define SIDERAY_PLAN_H

#include <sideray/renderer.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sideray_plan sideray_plan;

/* Of the committed scene, seen by any camera. Fails as sideray_renderer_render does with these options. The plan is the
 * caller's; it refers to neither scene nor options. */
SIDERAY_API sideray_status sideray_plan_create(sideray_scene* scene, const sideray_render_options* options,
                                               sideray_plan** plan, sideray_error* error);
/* The same for a renderer without OpenGL (gl "none"): rays replace the rasterizer, and there are no textures. */
SIDERAY_API sideray_status sideray_plan_create_without_gl(sideray_scene* scene, const sideray_render_options* options,
                                                          sideray_plan** plan, sideray_error* error);
SIDERAY_API void sideray_plan_release(sideray_plan* plan); /* NULL is allowed */

/* Everything that a plan returns lives as long as the plan; NULL where there is none of that index. */
typedef struct sideray_plan_pass {
  sideray_stage stage;
  const char* name; /* as in sideray_stage_time */
  int32_t runs;
  const char* reason; /* why it runs, or is left out */
} sideray_plan_pass;

/* Every stage once, in the order of sideray_stage, but for the total. */
SIDERAY_API size_t sideray_plan_pass_count(const sideray_plan* plan);
SIDERAY_API const sideray_plan_pass* sideray_plan_pass_at(const sideray_plan* plan, size_t index);

/* Layers of the cache that the frame fills, or SIDERAY_COMPOSITE's most surfaces a ray (0 = unlimited): no more than
 * were asked for. 0 where no translucent surface is traced. */
SIDERAY_API uint32_t sideray_plan_layers(const sideray_plan* plan);

/* The most by which donors may differ for layers to reuse their rays: sideray_translucency_options::ray_reuse, or
 * what AUTO comes to. 0: every layer traces its own rays. */
SIDERAY_API float sideray_plan_ray_reuse(const sideray_plan* plan);
/* 1 where ambient occlusion, or reflections of opaque surfaces, are traced: as sideray_render_options say, or what AUTO comes
 * to. In a reference 1 where reflections are asked for. */
SIDERAY_API int32_t sideray_plan_ao(const sideray_plan* plan);
/* 1 where the light that surfaces throw on each other is traced. */
SIDERAY_API int32_t sideray_plan_bounce(const sideray_plan* plan);
SIDERAY_API int32_t sideray_plan_reflections(const sideray_plan* plan);

/* A texture, or an array of `layers`, that the frame reads or writes; buffers used in place of one count as one.
 * Textures of the scene that are equal in size and format are one entry of `layers`, with all mip levels. Shadow maps
 * and the scene's textures may be smaller if the driver does not allow their size. Not listed: 1x1 textures that
 * replace missing ones, and the fragment lists of SIDERAY_OIT_ABUFFER, whose size depends on the picture. */
typedef struct sideray_plan_texture {
  const char* name;
  const char* format; /* OpenGL's name of it, without GL_ */
  uint32_t width, height, layers;
  uint64_t bytes;
  int32_t of_service; /* counted by bytes_cache of sideray_render_stats */
} sideray_plan_texture;

SIDERAY_API size_t sideray_plan_texture_count(const sideray_plan* plan);
SIDERAY_API const sideray_plan_texture* sideray_plan_texture_at(const sideray_plan* plan, size_t index);

#define SIDERAY_UNBOUNDED UINT64_MAX

/* Upper bounds of the counters of sideray_render_stats; SIDERAY_UNBOUNDED if only the scene's content bounds one.
 * bytes_cache is exact, and so is bytes_readback without a second wave. */
typedef struct sideray_plan_work {
  uint64_t rays_primary, rays_reflection, rays_shadow, rays_ao;
  uint64_t fragments; /* layers_matched + layers_missed */
  uint64_t bytes_readback, bytes_upload, bytes_cache;
  uint64_t rays_bounce;
} sideray_plan_work;

SIDERAY_API const sideray_plan_work* sideray_plan_most_work(const sideray_plan* plan);

/* The facts of a committed scene by which frames decide which options have an effect. */
typedef struct sideray_scene_facts {
  size_t size;
  uint64_t triangles, instances, materials;
  uint64_t translucent_objects;
  uint64_t layered_objects;  /* of them, those that may have layers: visible in layers, with a surface id */
  uint64_t most_layers;      /* most surfaces of these that one ray can hit; SIDERAY_UNBOUNDED: 64 or more */
  uint64_t most_surfaces;    /* the same of all translucent objects */
  uint64_t sprites;
  uint64_t lit_lights;       /* that send light */
  uint64_t swaying_objects;  /* opaque ones that wind moves */
  uint64_t swaying_copies;   /* the most of them that share one mesh */
  uint64_t inexact_objects[3]; /* that take the inexact shadow test, by sideray_inexact_target */
  uint64_t glossy_objects;   /* opaque ones that `reflections` mirrors */
  int32_t has_environment;   /* with light in it */
  uint64_t traceable_objects; /* translucent ones that may have layers once they are visible in them */
  uint64_t bending_objects; /* translucent ones on which `refraction` has an effect: they refract or blur */
  int32_t auto_ao, auto_reflections; /* 1 where SIDERAY_AMBIENT_AUTO and SIDERAY_REFLECTIONS_AUTO trace them */
  int32_t auto_bounce; /* 1 where SIDERAY_AMBIENT_AUTO traces what surfaces throw on each other */
} sideray_scene_facts;

/* Fills as much of `facts` as its `size`, which the caller has set, says. */
SIDERAY_API sideray_status sideray_plan_scene(sideray_scene* scene, sideray_scene_facts* facts, sideray_error* error);
/* The angle in degrees under which `cull_angle_deg` of sideray_pose_options takes instances out of what rays hit in this
 * view: itself at 30 degrees of yfov and more, less by tan(yfov / 2) / tan(15 degrees) in narrower views, so that a
 * telephoto view keeps what fills as many of its pixels; 0 in orthographic views, where nothing is taken out. */
SIDERAY_API float sideray_plan_cull_angle(const sideray_camera* camera, float cull_angle_deg);
/* 1 where a surface of this material is drawn as a translucent one: BLEND, or transmission above 0. */
SIDERAY_API int32_t sideray_material_is_translucent(const sideray_material_desc* material);

#ifdef __cplusplus
}
#endif
#endif
