/* The fixed function of OpenGL 1.x as a scene's light and material model (The OpenGL Graphics System, version 2.1,
 * sections 2.14 and 3.8.13), for engines that light by glLight and glMaterial. Rays then return what the engine would
 * have drawn: displayed values, lit at each point. docs/fixed-function.md has an example.
 *
 * Conventions are those of sideray.h. */
#ifndef SIDERAY_FIXED_FUNCTION_H
#define SIDERAY_FIXED_FUNCTION_H

#include <sideray/tracer.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The parameters of glLight, except that positions and directions are in world space. Colours are 0..1e15. */
typedef struct sideray_fixed_light {
  size_t size; /* also how far apart the lights of an array lie */
  float ambient[3], diffuse[3], specular[3];
  double position[4];      /* xyz / w; w = 0: xyz is the way to a directional light */
  float spot_direction[3]; /* direction in which the light travels, any length */
  float spot_exponent;     /* 0..128 */
  float spot_cutoff_deg;   /* 0..90, or 180 = all around */
  float constant_attenuation, linear_attenuation, quadratic_attenuation; /* >= 0, not all 0 */
  int32_t casts_shadows; /* 0: its diffuse and specular light is never blocked, as in engines that give it no shadows */
} sideray_fixed_light;

/* As GL_LIGHT1 and up, which are dark, with shadows; GL_LIGHT0 has diffuse and specular 1. */
SIDERAY_DEFAULTS(sideray_fixed_light, fixed_light)

/* Which colours of a material follow the vertex colours: glColorMaterial. */
enum {
  SIDERAY_FOLLOW_AMBIENT = 1u,
  SIDERAY_FOLLOW_DIFFUSE = 2u, /* alpha too */
  SIDERAY_FOLLOW_AMBIENT_AND_DIFFUSE = 3u,
  SIDERAY_FOLLOW_SPECULAR = 4u,
  SIDERAY_FOLLOW_EMISSION = 8u
};

/* How the texture of unit 0, sideray_material_desc::base_color_texture, changes the lit colour: GL_TEXTURE_ENV_MODE for
 * a GL_RGBA texture. */
typedef enum sideray_texture_environment {
  SIDERAY_ENVIRONMENT_MODULATE = 0,
  SIDERAY_ENVIRONMENT_DECAL = 1,
  SIDERAY_ENVIRONMENT_REPLACE = 2, /* alpha too */
  SIDERAY_ENVIRONMENT_ADD = 3,
  SIDERAY_ENVIRONMENT_FORCE_32 = 0x7fffffff
} sideray_texture_environment;

/* The parameters of glMaterial. Alpha is base_color[3] of the sideray_material_desc. That struct's alpha and blend
 * mode, culling, textures of colour and normals and, if it bends light, transmission, ior and volume keep their
 * meaning. `unlit` is glDisable(GL_LIGHTING): the colour is vertex colour times base_color. */
typedef struct sideray_fixed_material {
  size_t size;
  float ambient[3], diffuse[3], specular[3], emission[3];
  float shininess;        /* 0..128 */
  uint32_t follows_color; /* SIDERAY_FOLLOW_*: taken from vertex colours, which are white in a mesh without them */
  sideray_texture_environment environment;
  /* An extension of the fixed function: the weight of the mirrored radiance that is added, at normal incidence, 0..1. 0
   * = no ray is traced. docs/embedding.md says which value looks right if displayed values are blended. */
  float reflectance[3];
  int32_t fresnel; /* the reflectance grows to 1 at grazing angles (Schlick 1994); 0 = constant */
} sideray_fixed_material;

/* OpenGL's initial values: ambient 0.2, diffuse 0.8, the rest black; MODULATE. */
SIDERAY_DEFAULTS(sideray_fixed_material, fixed_material)

/* The parameters of glLightModel, and all enabled lights. */
typedef struct sideray_fixed_function {
  size_t size;
  const sideray_fixed_light* lights; /* all have the `size` of the first; they are copied */
  size_t light_count;                /* 0..4096 */
  float ambient[3];                  /* GL_LIGHT_MODEL_AMBIENT */
  int32_t local_viewer;              /* GL_LIGHT_MODEL_LOCAL_VIEWER; 0: the viewer is toward +z of the frame's view */
  int32_t two_sided;                 /* GL_LIGHT_MODEL_TWO_SIDE, with one material for both sides */
  int32_t separate_specular;         /* GL_SEPARATE_SPECULAR_COLOR: specular is added after texturing */
  /* The space of the engine's pictures: the linear environment is converted to it where rays see it. */
  sideray_radiance_space radiance_space;
} sideray_fixed_function;

/* No light, ambient 0.2, GAMMA22. */
SIDERAY_DEFAULTS(sideray_fixed_function, fixed_function)

/* From the next commit on, surfaces of frames are shaded by the fixed function: in layers and composites, in
 * reflections of these and of opaque surfaces, and behind bent glass. Everything is copied. Its lights replace the
 * scene's, but masks still use the scene's: give both the same positions. Shaded values are displayed values, and
 * radiance_space and radiance_scale of layers are not read. Sideray's own renderer and references, which draw linear
 * light, refuse such a scene, and it cannot be combined with a shader of the host. NULL: the built-in model. */
SIDERAY_API sideray_status sideray_scene_set_fixed_function(sideray_scene* scene, const sideray_fixed_function* model,
                                                            sideray_error* error);
/* Sets the fixed function's properties of `material`, until it is removed or they are replaced. NULL removes them.
 * Without them, its ambient and diffuse colours are its base colour, and its emission is its emissive colour. */
SIDERAY_API sideray_status sideray_scene_set_fixed_material(sideray_scene* scene, sideray_material material,
                                                            const sideray_fixed_material* fixed, sideray_error* error);

#ifdef __cplusplus
}
#endif
#endif
