// sideray_scene_*: arguments in, model::Scene out.
#include <cmath>

#include "bridge/api/border.h"
#include "bridge/base/handles.h"
#include "model/material_slots.h"

using sideray::bridge::guarded;
using sideray::bridge::require;
using sideray::bridge::require_struct;

void sideray_version(int* major, int* minor, int* patch) {
  if (major) *major = SIDERAY_VERSION_MAJOR;
  if (minor) *minor = SIDERAY_VERSION_MINOR;
  if (patch) *patch = SIDERAY_VERSION_PATCH;
}

sideray_mesh_desc sideray_mesh_defaults(void) {
  sideray_mesh_desc d{};
  d.size = sizeof(d);
  return d;
}

sideray_material_desc sideray_material_defaults(void) {
  sideray_material_desc d{};
  d.size = sizeof(d);
  for (float& c : d.base_color) c = 1.0f;
  d.roughness = 1.0f;
  d.normal_scale = d.occlusion_strength = 1.0f;
  d.alpha_cutoff = 0.5f;
  d.ior = 1.5f;
  d.attenuation_distance = INFINITY;
  for (float& c : d.attenuation_color) c = 1.0f;
  d.specular = 1.0f;
  for (float& c : d.specular_color) c = 1.0f;
  d.clearcoat_normal_scale = 1.0f;
  for (float& c : d.diffuse_transmission_color) c = 1.0f;
  for (const auto& s : sideray::model::material_slots) {
    sideray_texture_slot& slot = d.*s.slot;
    slot.texture_from_uv[0] = slot.texture_from_uv[3] = 1.0f;
  }
  return d;
}

sideray_status sideray_scene_create(sideray_scene** scene, sideray_error* error) {
  return guarded(error, [&] {
    require(scene, "scene");
    *scene = new sideray_scene;
  });
}

void sideray_scene_retain(sideray_scene* scene) {
  if (scene) ++scene->references;
}

void sideray_scene_release(sideray_scene* scene) {
  if (scene && --scene->references == 0) delete scene;
}

sideray_status sideray_scene_add_mesh(sideray_scene* scene, const sideray_mesh_desc* desc, sideray_mesh* mesh,
                                      uint32_t* dropped, sideray_error* error) {
  return guarded(error, [&] {
    require(scene, "scene");
    require_struct(desc, "mesh");
    require(mesh, "mesh result");
    *mesh = scene->scene.add_mesh(*desc, dropped);
  });
}

sideray_status sideray_scene_set_vertices(sideray_scene* scene, sideray_mesh mesh, const sideray_mesh_desc* desc,
                                          sideray_error* error) {
  return guarded(error, [&] {
    require(scene, "scene");
    require_struct(desc, "mesh");
    scene->scene.set_vertices(mesh, *desc);
  });
}

sideray_status sideray_scene_add_texture(sideray_scene* scene, uint32_t width, uint32_t height,
                                         sideray_texel_format format, const void* texels, sideray_texture* texture,
                                         sideray_error* error) {
  return guarded(error, [&] {
    require(scene, "scene");
    require(texture, "texture result");
    *texture = scene->scene.add_texture(width, height, format, texels);
  });
}

sideray_status sideray_scene_add_material(sideray_scene* scene, const sideray_material_desc* desc,
                                          sideray_material* material, sideray_error* error) {
  return guarded(error, [&] {
    require(scene, "scene");
    require_struct(desc, "material");
    require(material, "material result");
    *material = scene->scene.add_material(*desc);
  });
}

sideray_status sideray_scene_add_instances(sideray_scene* scene, const sideray_instance_desc* descs, size_t count,
                                           sideray_instance* first, sideray_error* error) {
  return guarded(error, [&] {
    require(scene, "scene");
    require(first, "first");
    *first = scene->scene.add_instances(descs, count);
  });
}

sideray_status sideray_scene_move_instances(sideray_scene* scene, sideray_instance first, size_t count,
                                            const double* world_from_object, sideray_error* error) {
  return guarded(error, [&] {
    require(scene, "scene");
    scene->scene.move_instances(first, count, world_from_object);
  });
}

sideray_status sideray_scene_set_visibility(sideray_scene* scene, sideray_instance instance, uint32_t visibility,
                                            sideray_error* error) {
  return guarded(error, [&] {
    require(scene, "scene");
    scene->scene.set_visibility(instance, visibility);
  });
}

sideray_wind_desc sideray_wind_defaults(void) {
  sideray_wind_desc d{};
  d.size = sizeof(d);
  d.direction[0] = 1.0f;
  d.amplitude = 0.1f, d.frequency = 0.3f, d.height = 1.0f;
  d.branch_frequency = 0.8f, d.leaf_frequency = 2.0f;
  d.wavelength = 1.0f;
  return d;
}

sideray_status sideray_scene_add_wind(sideray_scene* scene, const sideray_wind_desc* desc, sideray_wind* wind,
                                      sideray_error* error) {
  return guarded(error, [&] {
    require(scene, "scene");
    require_struct(desc, "wind description");
    require(wind, "wind result");
    *wind = scene->scene.add_wind(*desc);
  });
}

sideray_status sideray_scene_set_time(sideray_scene* scene, double time_s, double previous_time_s,
                                      sideray_error* error) {
  return guarded(error, [&] {
    require(scene, "scene");
    scene->scene.set_time(time_s, previous_time_s);
  });
}

sideray_particles_desc sideray_particles_defaults(void) {
  sideray_particles_desc d{};
  d.size = sizeof(d);
  d.columns = d.rows = 1;
  return d;
}

sideray_status sideray_scene_add_particles(sideray_scene* scene, const sideray_particles_desc* desc,
                                           sideray_particles* particles, sideray_error* error) {
  return guarded(error, [&] {
    require(scene, "scene");
    require_struct(desc, "particles description");
    require(particles, "particles result");
    *particles = scene->scene.add_particles(*desc);
  });
}

sideray_status sideray_scene_set_sprites(sideray_scene* scene, sideray_particles particles,
                                         const sideray_sprite* sprites, size_t count, sideray_error* error) {
  return guarded(error, [&] {
    require(scene, "scene");
    scene->scene.set_sprites(particles, sprites, count);
  });
}

sideray_status sideray_scene_set_lights(sideray_scene* scene, const sideray_light* lights, size_t count,
                                        sideray_error* error) {
  return guarded(error, [&] {
    require(scene, "scene");
    for (size_t i = 0; i < count && lights; ++i) require_struct(lights + i, "light");
    scene->scene.set_lights(lights, count);
  });
}

sideray_status sideray_scene_set_environment(sideray_scene* scene, uint32_t width, uint32_t height, const float* rgb,
                                             float scale, float rotation_deg, sideray_error* error) {
  return guarded(error, [&] {
    require(scene, "scene");
    scene->scene.set_environment(width, height, rgb, scale, rotation_deg);
  });
}

sideray_shader_desc sideray_shader_defaults(void) {
  sideray_shader_desc d{};
  d.size = sizeof(d);
  d.radiance_scale = 1.0f;
  return d;
}

sideray_status sideray_scene_set_shader(sideray_scene* scene, const sideray_shader_desc* shader, sideray_error* error) {
  return guarded(error, [&] {
    require(scene, "scene");
    if (shader) require_struct(shader, "shader description");
    scene->scene.set_shader(shader);
  });
}

sideray_status sideray_scene_commit(sideray_scene* scene, sideray_error* error) {
  return guarded(error, [&] {
    require(scene, "scene");
    scene->scene.commit();
  });
}

sideray_status sideray_scene_bounds(sideray_scene* scene, double minimum[3], double maximum[3], sideray_error* error) {
  return guarded(error, [&] {
    require(scene, "scene");
    const auto snapshot = scene->scene.snapshot();
    if (!snapshot || snapshot->bounds.empty()) return SIDERAY_NOT_READY;
    for (int i = 0; i < 3; ++i) {
      minimum[i] = snapshot->origin[i] + double{snapshot->bounds.minimum[i]};
      maximum[i] = snapshot->origin[i] + double{snapshot->bounds.maximum[i]};
    }
    return SIDERAY_OK;
  });
}
