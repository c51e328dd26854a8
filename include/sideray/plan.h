/* What a frame of the offscreen tier would do, before it is drawn: which passes run and why, what is kept in textures,
 * and the most work that it can be. Plain memory, no OpenGL; decided where sideray_renderer_render decides it.
 *
 * Conventions are those of sideray.h. */
#ifndef SIDERAY_PLAN_H
#define SIDERAY_PLAN_H

#include <sideray/sideray.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sideray_plan sideray_plan;

/* Of the committed scene, seen by any camera. Fails as sideray_renderer_render does with these options. The plan is the
 * caller's; it refers to neither scene nor options. */
SIDERAY_API sideray_status sideray_plan_create(sideray_scene* scene, const sideray_render_options* options,
                                               sideray_plan** plan, sideray_error* error);
SIDERAY_API void sideray_plan_release(sideray_plan* plan); /* NULL is allowed */

/* Strings live as long as the plan. */
typedef struct sideray_plan_pass {
  sideray_stage stage;
  int32_t runs;
  const char* reason; /* why it runs, or is left out */
} sideray_plan_pass;

/* Every stage once, in the order of sideray_stage, but for the total. */
SIDERAY_API size_t sideray_plan_pass_count(const sideray_plan* plan);
SIDERAY_API sideray_plan_pass sideray_plan_pass_at(const sideray_plan* plan, size_t index);

/* Layers of the cache that the frame fills, or SIDERAY_COMPOSITE's most surfaces a ray (0 = unlimited): no more than
 * were asked for. 0 where no translucent surface is traced. */
SIDERAY_API uint32_t sideray_plan_layers(const sideray_plan* plan);

/* A texture, or an array of `layers`, that the frame reads or writes; buffers that stand in for one count as one. The
 * scene's own are `layers` equal ones with all their mip levels. Shadow maps and the scene's are as large as given
 * where the driver allows such sides. Not among them: single texels that stand in for a texture that is not there, and
 * the lists of SIDERAY_OIT_ABUFFER beside their heads, which grow with what is seen. */
typedef struct sideray_plan_texture {
  const char* name;
  const char* format; /* OpenGL's name of it, without GL_ */
  uint32_t width, height, layers;
  uint64_t bytes;
  int32_t of_service; /* counted by bytes_cache of sideray_render_stats */
} sideray_plan_texture;

SIDERAY_API size_t sideray_plan_texture_count(const sideray_plan* plan);
SIDERAY_API sideray_plan_texture sideray_plan_texture_at(const sideray_plan* plan, size_t index);

#define SIDERAY_UNBOUNDED UINT64_MAX

/* What the counters of sideray_render_stats cannot exceed; SIDERAY_UNBOUNDED where the scene's content alone decides.
 * bytes_cache is exact, and bytes_readback where there is no second wave. */
typedef struct sideray_plan_work {
  uint64_t rays_primary, rays_reflection, rays_shadow, rays_ao;
  uint64_t fragments; /* layers_matched + layers_missed */
  uint64_t bytes_readback, bytes_upload, bytes_cache;
} sideray_plan_work;

SIDERAY_API sideray_plan_work sideray_plan_most_work(const sideray_plan* plan);

#ifdef __cplusplus
}
#endif
#endif
