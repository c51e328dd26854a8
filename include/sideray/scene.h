/* Scenes: meshes, instances, materials, textures, particles, lights and environment as plain memory. No call of this
 * header touches OpenGL. One thread edits a scene at a time; committed snapshots are immutable and shared freely.
 *
 * Conventions are those of sideray.h. */
#ifndef SIDERAY_SCENE_H
#define SIDERAY_SCENE_H

#include <sideray/base.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sideray_scene sideray_scene;

/* Names that the add functions return. None is 0, which means "none" where a struct allows it. The name of a removed
 * object may be returned again by a later add. */
typedef uint32_t sideray_mesh;
typedef uint32_t sideray_texture;
typedef uint32_t sideray_material;
typedef uint32_t sideray_instance;

SIDERAY_API sideray_status sideray_scene_create(sideray_scene** scene, sideray_error* error);
SIDERAY_API void sideray_scene_retain(sideray_scene* scene);
SIDERAY_API void sideray_scene_release(sideray_scene* scene); /* NULL is allowed */

/* One vertex attribute: `data` points to floats; consecutive vertices are `stride_bytes` apart, 0 = tightly packed. */
typedef struct sideray_attribute {
  const float* data;
  size_t stride_bytes;
} sideray_attribute;

/* Says what indices form of vertices. Points and lines are a pixel wide, as rasterizers draw them; pictures show them
 * in front of and behind surfaces, and through translucent ones. They are opaque whatever their material says, except
 * for alpha_mode MASK, and without normals unlit. No ray hits them: they cast no shadow, and are invisible in mirrors,
 * refraction and references. */
typedef enum sideray_topology {
  SIDERAY_TRIANGLES = 0,
  SIDERAY_LINES = 1, /* every two indices are a line */
  SIDERAY_POINTS = 2 /* every index is a point */
} sideray_topology;

/* A surface that the host draws too must have the same triangles in both: a drawn sphere of 28 slices and a traced one
 * of 64 are farther apart than layers and shadow rays tolerate (docs/embedding.md). */
typedef struct sideray_mesh_desc {
  size_t size;
  uint32_t vertex_count;       /* 1..2^31-1 */
  uint32_t index_count;        /* a multiple of 3 (of 2, of 1), or 0: every three vertices are a triangle */
  const uint32_t* indices;     /* each below vertex_count; counter-clockwise triangles face front */
  sideray_attribute positions; /* 3 floats, required */
  sideray_attribute normals;   /* 3 floats, unit length; absent = flat shading */
  sideray_attribute tangents;  /* 4 floats, w = +-1 bitangent sign; absent = derived from uv where needed */
  sideray_attribute uv0, uv1;  /* 2 floats, origin at the top left of the image; absent = 0 */
  sideray_attribute colors;    /* 4 floats, linear, multiplied onto base_color; absent = 1 */
  /* Alternatives in the formats of older engines, instead of `indices` and `colors`, which must then be NULL. */
  const uint16_t* short_indices;
  const uint8_t* color_bytes; /* 4 bytes a vertex, 0..255 is 0..1 */
  size_t color_bytes_stride;  /* 0 = tightly packed */
  int32_t color_bytes_bgra;   /* byte order: 1 = blue, green, red, alpha as in Direct3D; 0 = red, green, blue, alpha */
  sideray_topology topology;
} sideray_mesh_desc;

SIDERAY_DEFAULTS(sideray_mesh_desc, mesh)

/* Copies the mesh. Triangles with a non-finite or out-of-range (|x| > 1e15) vertex, and triangles without area, are
 * dropped and counted in *dropped (may be NULL). Non-finite normals, tangents, uvs and colours get their defaults. */
SIDERAY_API sideray_status sideray_scene_add_mesh(sideray_scene* scene, const sideray_mesh_desc* desc,
                                                  sideray_mesh* mesh, uint32_t* dropped, sideray_error* error);

/* Replaces the shape of `mesh`, as add_mesh does; the name stays, and instances keep their other properties. */
SIDERAY_API sideray_status sideray_scene_replace_mesh(sideray_scene* scene, sideray_mesh mesh,
                                                      const sideray_mesh_desc* desc, uint32_t* dropped,
                                                      sideray_error* error);
/* Removes a mesh that no instance uses. A used one is refused, and the message names an instance. */
SIDERAY_API sideray_status sideray_scene_remove_mesh(sideray_scene* scene, sideray_mesh mesh, sideray_error* error);

/* Replaces the vertices and bounds of a mesh. `desc` holds the attributes and vertex_count, which must be the mesh's;
 * its indices are not read, so triangles stay, and dropped ones stay dropped. A vertex that is not finite or out of
 * range is refused by index. Costs a refit if the mesh is traced. */
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

/* Replaces the texels of `texture`, as add_texture does; the name stays. */
SIDERAY_API sideray_status sideray_scene_replace_texture(sideray_scene* scene, sideray_texture texture, uint32_t width,
                                                         uint32_t height, sideray_texel_format format,
                                                         const void* texels, sideray_error* error);
/* Removes a texture that no material and no particles use. A used one is refused, and the message names the user. */
SIDERAY_API sideray_status sideray_scene_remove_texture(sideray_scene* scene, sideray_texture texture,
                                                        sideray_error* error);

typedef enum sideray_wrap { SIDERAY_REPEAT = 0, SIDERAY_CLAMP = 1, SIDERAY_MIRROR = 2 } sideray_wrap;
typedef enum sideray_filter {
  SIDERAY_TRILINEAR = 0,
  SIDERAY_BILINEAR = 1, /* level 0 only */
  SIDERAY_NEAREST = 2   /* level 0 only */
} sideray_filter;

typedef struct sideray_texture_slot {
  sideray_texture texture; /* 0 = none: only the factor counts */
  uint32_t uv_set;         /* 0 or 1 */
  sideray_wrap wrap_u, wrap_v;
  sideray_filter filter;
  float texture_from_uv[6]; /* columns of a 2x3 affine map: s = m0 u + m2 v + m4, t = m1 u + m3 v + m5 */
} sideray_texture_slot;

typedef enum sideray_alpha_mode { SIDERAY_OPAQUE = 0, SIDERAY_MASK = 1, SIDERAY_BLEND = 2 } sideray_alpha_mode;

/* dst = C*a + dst*T: alpha and premultiplied T = 1-a, additive T = 1, multiply C = 0 and T = base colour faded by a. */
typedef enum sideray_blend_mode {
  SIDERAY_BLEND_ALPHA = 0,
  SIDERAY_BLEND_PREMULTIPLIED = 1, /* C is added in full: reflections are not scaled by a */
  SIDERAY_BLEND_ADDITIVE = 2,
  SIDERAY_BLEND_MULTIPLY = 3 /* never ray traced into layers */
} sideray_blend_mode;

/* Metallic-roughness material (glTF 2.0 core, KHR_materials_transmission, _ior, _volume, _specular, _unlit, _clearcoat,
 * _sheen, _diffuse_transmission, _iridescence, _anisotropy, _dispersion; _emissive_strength is a factor of `emissive`).
 * Translucent = BLEND, or transmission > 0. A texture multiplies its factor; letters name the channels in use. */
typedef struct sideray_material_desc {
  size_t size;
  float base_color[4];
  float metallic, roughness; /* 0..1; roughness is perceptual: alpha = roughness^2 */
  float emissive[3];         /* radiance, >= 0 */
  float normal_scale, occlusion_strength;
  sideray_alpha_mode alpha_mode;
  float alpha_cutoff; /* MASK: a fragment with a lower alpha is discarded */
  sideray_blend_mode blend_mode;
  int32_t double_sided, unlit;
  float transmission;         /* 0..1, share of the diffuse part that passes straight through */
  float ior;                  /* >= 1 */
  float thickness;            /* world units, 0 = thin walled */
  float attenuation_distance; /* world units, +inf = none */
  float attenuation_color[3];
  float specular, specular_color[3];
  float clearcoat, clearcoat_roughness; /* 0..1; a layer of ior 1.5 above everything else */
  float clearcoat_normal_scale;
  float sheen_color[3], sheen_roughness;                     /* 0..1 each */
  float diffuse_transmission, diffuse_transmission_color[3]; /* 0..1: the share of diffuse light that is transmitted */
  /* >= 0: screen-space distortion of the opaque picture behind a translucent surface. The picture is sampled at an
   * offset of `distortion` times the view-space x and y of the shading normal, in picture heights. 0 = none. */
  float distortion;
  /* Marks its pixels for the inexact shadow test (sideray_inexact), if explicit marks select pixels. Wind is a mark
   * too. */
  int32_t inexact_shadow;
  sideray_texture_slot base_color_texture;         /* RGBA */
  sideray_texture_slot metallic_roughness_texture; /* G roughness, B metallic */
  sideray_texture_slot normal_texture, occlusion_texture, emissive_texture, transmission_texture; /* RGB, R, RGB, R */
  sideray_texture_slot thickness_texture, specular_texture, specular_color_texture;               /* G, A, RGB */
  sideray_texture_slot clearcoat_texture, clearcoat_roughness_texture, clearcoat_normal_texture;  /* R, G, RGB */
  sideray_texture_slot sheen_color_texture, sheen_roughness_texture;                              /* RGB, A */
  sideray_texture_slot diffuse_transmission_texture, diffuse_transmission_color_texture;          /* A, RGB */
  /* 0..1: how much longer highlights are along a direction on the surface than across it; and that direction, in
   * radians from the tangent toward the bitangent. Meshes without tangents and texture coordinates have no such
   * direction. */
  float anisotropy, anisotropy_rotation;
  float iridescence;     /* 0..1: strength of a thin film on the base, below sheen and coat */
  float iridescence_ior; /* of the film, >= 1 */
  /* nanometres, 0..1e6, at texture values 0 and 1; without a texture the maximum applies. 0 = no film */
  float iridescence_thickness_min, iridescence_thickness_max;
  float dispersion; /* >= 0: 20 / Abbe number of a volume; 0 = refracts all colours alike */
  sideray_texture_slot anisotropy_texture; /* RG direction in the tangent's frame, B strength */
  sideray_texture_slot iridescence_texture, iridescence_thickness_texture; /* R, G */
} sideray_material_desc;

/* white, rough, opaque, ior 1.5, no textures */
SIDERAY_DEFAULTS(sideray_material_desc, material)
SIDERAY_API sideray_status sideray_scene_add_material(sideray_scene* scene, const sideray_material_desc* desc,
                                                      sideray_material* material, sideray_error* error);
/* Replaces the properties of `material`, as add_material does; the name stays, and all its instances change. */
SIDERAY_API sideray_status sideray_scene_replace_material(sideray_scene* scene, sideray_material material,
                                                          const sideray_material_desc* desc, sideray_error* error);
/* Removes a material that no instance uses. A used one is refused, and the message names an instance. */
SIDERAY_API sideray_status sideray_scene_remove_material(sideray_scene* scene, sideray_material material,
                                                         sideray_error* error);

/* Which rays may hit an instance. LAYERS matters only for translucent materials. Translucent instances with SHADOW tint
 * the light that passes them. */
enum {
  SIDERAY_VISIBLE_LAYERS = 1u,
  SIDERAY_VISIBLE_REFLECTION = 2u,
  SIDERAY_VISIBLE_SHADOW = 4u,
  SIDERAY_VISIBLE_AO = 8u,
  SIDERAY_VISIBLE_ALL = 15u
};

/* How wind moves an instance: sr_wind() of shaders/shading/wind.h, in the mesh's own space, whose origin is the plant's
 * root and whose +Y is up. The trunk bends with the square of the height; branches swing in proportion to their
 * distance from the trunk, with a phase that changes along the wind; leaves flutter. If a plant has several instances,
 * give them the same numbers and phases, and leaf_amplitude 0 to those without leaves. */
typedef uint32_t sideray_wind;

typedef struct sideray_wind_desc {
  size_t size;
  float direction[3]; /* object space, unit, the direction in which it blows */
  float amplitude;    /* object units, >= 0: largest sway of the trunk's top */
  float frequency;    /* of the trunk, per second, > 0 */
  float height;       /* object units, > 0: the height of the whole plant */
  float branch_amplitude, branch_frequency;
  float leaf_amplitude, leaf_frequency;
  float wavelength; /* object units, > 0: distance along which branches run through one cycle */
} sideray_wind_desc;

SIDERAY_DEFAULTS(sideray_wind_desc, wind)
SIDERAY_API sideray_status sideray_scene_add_wind(sideray_scene* scene, const sideray_wind_desc* desc,
                                                  sideray_wind* wind, sideray_error* error);
/* Sets the time of the wind and its time in the previous picture, for motion vectors; seconds, finite. */
SIDERAY_API sideray_status sideray_scene_set_time(sideray_scene* scene, double time_s, double previous_time_s,
                                                  sideray_error* error);

typedef struct sideray_instance_desc {
  sideray_mesh mesh;
  sideray_material material;
  double world_from_object[12]; /* 3x4 affine, four columns of three; finite, invertible; mirroring allowed */
  uint32_t surface_id;          /* the host's key of this surface, unique; 0 = never ray traced into layers */
  uint32_t visibility;          /* SIDERAY_VISIBLE_* */
  uint64_t user;                /* the host's value, never read; passed to its shader */
  sideray_wind wind;            /* 0 = not moved by wind */
  float wind_phase;             /* 0..1; differs between instances, so that neighbours do not move alike */
} sideray_instance_desc;

/* Adds `count` instances and writes their names to `instances` (may be NULL). Descriptions are `stride_bytes` apart,
 * which is sizeof(sideray_instance_desc); fields that an older caller's struct lacks are 0. All or none are added. In a
 * scene from which no instance was ever removed, names are consecutive, from 1. */
SIDERAY_API sideray_status sideray_scene_add_instances(sideray_scene* scene, const sideray_instance_desc* descs,
                                                       size_t stride_bytes, size_t count, sideray_instance* instances,
                                                       sideray_error* error);
/* Replaces all properties of `count` instances: mesh, material, surface id and so on; names stay. Instances may swap
 * surface ids in one call. All or none are replaced. */
SIDERAY_API sideray_status sideray_scene_replace_instances(sideray_scene* scene, const sideray_instance* instances,
                                                           const sideray_instance_desc* descs, size_t stride_bytes,
                                                           size_t count, sideray_error* error);
/* Removes `count` instances. All or none are removed; a name that occurs twice is refused. */
SIDERAY_API sideray_status sideray_scene_remove_instances(sideray_scene* scene, const sideray_instance* instances,
                                                          size_t count, sideray_error* error);
/* Replaces the transforms of `count` instances; 12 doubles each, as in sideray_instance_desc. */
SIDERAY_API sideray_status sideray_scene_move_instances(sideray_scene* scene, const sideray_instance* instances,
                                                        size_t count, const double* world_from_object,
                                                        sideray_error* error);
/* Replaces the surface ids of `count` instances, which must stay unique. */
SIDERAY_API sideray_status sideray_scene_renumber_instances(sideray_scene* scene, const sideray_instance* instances,
                                                            size_t count, const uint32_t* surface_ids,
                                                            sideray_error* error);
SIDERAY_API sideray_status sideray_scene_set_visibility(sideray_scene* scene, sideray_instance instance,
                                                        uint32_t visibility, sideray_error* error);

/* Camera-facing sprites that share a texture: particles as a rasterizer draws them. Rays hit them only in the reference
 * and with the `particles` options. */
typedef uint32_t sideray_particles;

typedef struct sideray_particles_desc {
  size_t size;
  sideray_texture texture;       /* 0 = white */
  uint32_t columns, rows;        /* flip-book cells in the texture, row by row from the top left; 1, 1 = one cell */
  sideray_blend_mode blend_mode; /* not MULTIPLY */
  float soft_distance; /* world units along the view axis in which sprites fade in front of opaque surfaces; 0 = hard */
  int32_t lit;         /* 0: colour is radiance; otherwise it is the albedo of a surface that faces the eye */
} sideray_particles_desc;

/* white, alpha, hard, unlit */
SIDERAY_DEFAULTS(sideray_particles_desc, particles)
SIDERAY_API sideray_status sideray_scene_add_particles(sideray_scene* scene, const sideray_particles_desc* desc,
                                                       sideray_particles* particles, sideray_error* error);

typedef struct sideray_sprite {
  double position[3];  /* of the centre, world */
  float width, height; /* world units, > 0 */
  float rotation;      /* radians, counter-clockwise as seen */
  float color[4];      /* linear, multiplied onto the texel; RGB >= 0, A 0..1 */
  float cell;          /* of the flip-book, rounded down, modulo columns * rows */
} sideray_sprite;

/* Replaces the sprites of a system, 0..2^20 of them, `stride_bytes` apart, in any order. */
SIDERAY_API sideray_status sideray_scene_set_sprites(sideray_scene* scene, sideray_particles particles,
                                                     const sideray_sprite* sprites, size_t stride_bytes, size_t count,
                                                     sideray_error* error);

typedef enum sideray_light_type {
  SIDERAY_LIGHT_DIRECTIONAL = 0,
  SIDERAY_LIGHT_POINT = 1,
  SIDERAY_LIGHT_SPOT = 2
} sideray_light_type;

typedef struct sideray_light {
  size_t size; /* also the stride of lights in an array */
  sideray_light_type type;
  double position[3]; /* point and spot */
  float direction[3]; /* in which the light travels; directional and spot */
  float intensity[3]; /* directional: irradiance (glTF lux); others: radiant intensity (glTF candela); without 683 */
  float range;        /* world units, 0 = unlimited */
  float inner_cone, outer_cone; /* half angles, 0 <= inner < outer <= pi/2 */
  float radius;                 /* world units; for soft shadows by rays */
  float angular_diameter_deg;   /* directional; for soft shadows by rays */
  /* Denoising of its traced shadow: the filter's largest radius in pixels, 0 = 32, negative = not filtered; and the
   * most frames that are averaged, 0 = 8, 1 = this frame alone. */
  float shadow_filter_radius;
  uint32_t shadow_filter_frames;
} sideray_light;

/* Directional, straight down, white, without size; cone angles of 0 and 45 degrees. */
SIDERAY_DEFAULTS(sideray_light, light)

/* Replaces all lights, 0..4096 of them, which all have the `size` of the first. The first 32 may have shadow masks of
 * their own (sideray_mask_inputs::shadow_lights); the others share one. */
SIDERAY_API sideray_status sideray_scene_set_lights(sideray_scene* scene, const sideray_light* lights, size_t count,
                                                    sideray_error* error);

/* Sets the lat-long environment: `width * height` linear RGB float triples, top row (+Y) first, image centre = -Z,
 * u grows toward +X. Values are clamped to 0..65504, non-finite ones become 0. NULL texels: no environment (black).
 * `scale` multiplies radiance; `rotation_deg` turns it counter-clockwise about +Y seen from above. */
SIDERAY_API sideray_status sideray_scene_set_environment(sideray_scene* scene, uint32_t width, uint32_t height,
                                                         const float* rgb, float scale, float rotation_deg,
                                                         sideray_error* error);

/* Sets the environment from the six faces of a cube map. faces[i] holds `side * side` linear RGB float triples of +X,
 * -X, +Y, -Y, +Z, -Z, in the layout that OpenGL takes for GL_TEXTURE_CUBE_MAP_POSITIVE_X + i. The radiance from the
 * world direction d is texture(samplerCube, cube_from_world * d). cube_from_world: 3x3, columns, orthonormal, mirroring
 * allowed; NULL = the identity. Sides of 1..4096. It is converted to a lat-long picture with 4 * side columns, at most
 * 8192. */
SIDERAY_API sideray_status sideray_scene_set_environment_cube(sideray_scene* scene, uint32_t side,
                                                              const float* const faces[6], float scale,
                                                              const float cube_from_world[9], sideray_error* error);

/* Publishes all edits since the last commit as one immutable snapshot, which tracers, services and renderers use. */
SIDERAY_API sideray_status sideray_scene_commit(sideray_scene* scene, sideray_error* error);

/* Returns the bounds of the committed instances in world space. SIDERAY_NOT_READY: nothing is committed, or the scene
 * is empty. */
SIDERAY_API sideray_status sideray_scene_bounds(sideray_scene* scene, double minimum[3], double maximum[3],
                                                sideray_error* error);

#ifdef __cplusplus
}
#endif
#endif
