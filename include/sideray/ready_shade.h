/* What the fixed function of OpenGL 1.x makes of a surface (The OpenGL Graphics System, version 2.1, section 2.14.1), for
 * rays: constant, linear and quadratic attenuation, spot exponent and cutoff, ambient light of each light and of all,
 * emission, specular light with its shininess. It is for hosts without shading of their own to give to
 * sideray_scene_set_shader. Header only, compiled with the host, in C99 or C++: copy it where your engine adds to it.
 *
 *   static sideray_fixed_function look;    lives as long as the shader is used; see sideray_shader_desc
 *   look.lights = lights; look.light_count = 2; look.materials = materials; look.material_count = 7;
 *   sideray_shader_desc shader = sideray_shader_defaults();
 *   shader.shade = sideray_ready_shade;
 *   shader.user = &look;
 *   shader.radiance_space = SIDERAY_SPACE_GAMMA22;   the fixed function adds up what is shown, not light
 *   shader.shadow_lights = 0x1;
 *
 * Each light and material is what glLight and glMaterial are given, but for places and directions, which are in world
 * space. sideray_instance_desc::user is the index of the instance's material in `materials`. The scene's own material has
 * a white base colour and the texture of unit 0, which modulates (GL_MODULATE), and the alpha. */
#ifndef SIDERAY_READY_SHADE_H
#define SIDERAY_READY_SHADE_H

#include <sideray/tracer.h>

#include <math.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A conversion that hosts of either language are not warned of. */
#ifdef __cplusplus
#define SIDERAY_FIXED_CAST(type, value) static_cast<type>(value)
#else
#define SIDERAY_FIXED_CAST(type, value) ((type)(value))
#endif

typedef struct sideray_fixed_light {
  float ambient[3], diffuse[3], specular[3];
  double position[4];      /* xyz / w; w = 0: xyz is the way to a directional light */
  float spot_direction[3]; /* the way the light travels, any length */
  float spot_exponent;     /* 0..128 */
  float spot_cutoff_deg;   /* 0..90, or 180: it shines all around */
  float constant_attenuation, linear_attenuation, quadratic_attenuation;
  int32_t shadow;          /* the scene's light, 0..31, whose shadow takes diffuse and specular away; -1 = none */
} sideray_fixed_light;

typedef struct sideray_fixed_material {
  float ambient[3], diffuse[3], specular[3], emission[3];
  float shininess; /* 0..128 */
  /* What the fixed function has not: how much of what is reflected is added, head on. 0 = no ray is traced. */
  float reflectance[3];
  int32_t fresnel; /* the reflectance grows to 1 at grazing angles (Schlick 1994); 0 = it is the same from everywhere */
} sideray_fixed_material;

typedef struct sideray_fixed_function {
  const sideray_fixed_light* lights;
  size_t light_count;
  const sideray_fixed_material* materials;
  size_t material_count; /* at least 1: an index beyond means the first */
  float ambient[3];      /* GL_LIGHT_MODEL_AMBIENT */
  int32_t local_viewer;  /* GL_LIGHT_MODEL_LOCAL_VIEWER */
  float viewer[3];       /* without it: unit, the way to the viewer, which is the +z axis of the camera */
  int32_t two_sided;     /* GL_LIGHT_MODEL_TWO_SIDE, with one material for both sides */
  int32_t separate_specular; /* GL_SEPARATE_SPECULAR_COLOR: it is added behind the texture */
} sideray_fixed_function;

/* GL_LIGHT1 and up, which are dark; GL_LIGHT0 has diffuse and specular 1. */
static inline sideray_fixed_light sideray_fixed_light_defaults(void) {
  sideray_fixed_light light = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 1, 0}, {0, 0, -1}, 0, 180, 1, 0, 0, -1};
  return light;
}

static inline sideray_fixed_material sideray_fixed_material_defaults(void) {
  sideray_fixed_material material = {{0.2f, 0.2f, 0.2f}, {0.8f, 0.8f, 0.8f}, {0, 0, 0}, {0, 0, 0}, 0, {0, 0, 0}, 0};
  return material;
}

/* No light, no material: fill `lights` and `materials`. */
static inline sideray_fixed_function sideray_fixed_function_defaults(void) {
  sideray_fixed_function look = {NULL, 0, NULL, 0, {0.2f, 0.2f, 0.2f}, 0, {0, 0, 1}, 0, 0};
  return look;
}

static inline float sideray_fixed_dot(const float a[3], const float b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Returns the length that the vector had; the null vector stays. */
static inline float sideray_fixed_normalize(float v[3]) {
  const float length = sqrtf(sideray_fixed_dot(v, v));
  int c;
  for (c = 0; c < 3 && length > 0; ++c) v[c] /= length;
  return length;
}

static inline float sideray_fixed_clamp(float x) { return x < 0 ? 0 : x > 1 ? 1 : x; }

/* Which part of a spot's light arrives in the direction from it to the point, -to_light. */
static inline float sideray_fixed_spot(const sideray_fixed_light* light, const float to_light[3]) {
  float axis[3] = {light->spot_direction[0], light->spot_direction[1], light->spot_direction[2]};
  float along;
  if (light->spot_cutoff_deg >= 180.0f || light->position[3] == 0.0) return 1;
  sideray_fixed_normalize(axis);
  along = -sideray_fixed_dot(axis, to_light);
  if (along < cosf(light->spot_cutoff_deg * 0.017453292520f)) return 0;
  return powf(along > 0 ? along : 0, light->spot_exponent);
}

/* Adds what one light adds: `lit` before the texture, `shine` apart. `direct`: what arrives of red, green
 * and blue, 0 = in shadow. `to_viewer` is unit. */
static inline void sideray_fixed_add_light(const sideray_fixed_light* light, const sideray_fixed_material* material,
                                           const double position[3], const float normal[3], const float to_viewer[3],
                                           const float direct[3], float lit[3], float shine[3]) {
  float to_light[3], halfway[3];
  float distance, fade = 1, toward, gloss;
  int c;
  for (c = 0; c < 3; ++c)
    to_light[c] = SIDERAY_FIXED_CAST(float, light->position[3] != 0.0 ? light->position[c] / light->position[3] - position[c]
                                                                      : light->position[c]);
  distance = sideray_fixed_normalize(to_light);
  if (light->position[3] != 0.0)
    fade = 1.0f / (light->constant_attenuation + light->linear_attenuation * distance +
                   light->quadratic_attenuation * distance * distance);
  fade *= sideray_fixed_spot(light, to_light);
  toward = sideray_fixed_dot(normal, to_light);
  for (c = 0; c < 3; ++c) halfway[c] = to_light[c] + to_viewer[c];
  sideray_fixed_normalize(halfway);
  gloss = sideray_fixed_dot(normal, halfway);
  gloss = powf(gloss > 0 ? gloss : 0, material->shininess);
  for (c = 0; c < 3; ++c) {
    lit[c] += fade * light->ambient[c] * material->ambient[c];
    if (toward <= 0 || !(direct[c] > 0)) continue;
    lit[c] += fade * toward * light->diffuse[c] * material->diffuse[c] * direct[c];
    shine[c] += fade * gloss * light->specular[c] * material->specular[c] * direct[c];
  }
}

/* What the fixed function writes at the point, 0..1. */
static inline void sideray_fixed_color(const sideray_fixed_function* look, const sideray_fixed_material* material,
                                       const sideray_shading_point* point, float color[3]) {
  const float* to_viewer = look->local_viewer ? point->to_eye : look->viewer;
  const float side = !look->two_sided && !point->front ? -1.0f : 1.0f;
  float normal[3], lit[3], shine[3] = {0, 0, 0};
  size_t i;
  int c;
  for (c = 0; c < 3; ++c) normal[c] = side * point->normal[c];
  for (c = 0; c < 3; ++c) lit[c] = material->emission[c] + look->ambient[c] * material->ambient[c];
  for (i = 0; i < look->light_count; ++i) {
    const int32_t shadow = look->lights[i].shadow;
    const int has_shadow = shadow >= 0 && shadow <= 31;
    const float arrives = !has_shadow || (point->lights >> shadow & 1u) != 0 ? 1.0f : 0.0f;
    float direct[3] = {arrives, arrives, arrives};
    for (c = 0; has_shadow && point->tints && c < 3; ++c) direct[c] *= point->tints[3 * shadow + c];
    sideray_fixed_add_light(&look->lights[i], material, point->position, normal, to_viewer, direct, lit, shine);
  }
  for (c = 0; c < 3; ++c) {
    const float behind = look->separate_specular ? sideray_fixed_clamp(shine[c]) : 0;
    const float before = look->separate_specular ? lit[c] : lit[c] + shine[c];
    color[c] = sideray_fixed_clamp(sideray_fixed_clamp(before) * point->base_color[c] + behind);
  }
}

/* A sideray_shade; `user` is a sideray_fixed_function. */
static inline void sideray_ready_shade(void* user, const sideray_shading_point* points, size_t count,
                                       sideray_shading_result* results) {
  const sideray_fixed_function* look = SIDERAY_FIXED_CAST(const sideray_fixed_function*, user);
  size_t i;
  int c;
  for (i = 0; i < count; ++i) {
    const size_t index = points[i].user < look->material_count ? SIDERAY_FIXED_CAST(size_t, points[i].user) : 0;
    const sideray_fixed_material* material = &look->materials[index];
    const float cosine = sideray_fixed_clamp(sideray_fixed_dot(points[i].normal, points[i].to_eye));
    const float grazing = material->fresnel ? powf(1 - cosine, 5) : 0;
    sideray_fixed_color(look, material, &points[i], results[i].radiance);
    for (c = 0; c < 3; ++c)
      results[i].reflectance[c] = material->reflectance[c] + (1 - material->reflectance[c]) * grazing;
  }
}

#undef SIDERAY_FIXED_CAST

#ifdef __cplusplus
}
#endif
#endif
