// sideray_scene_*: arguments in, model::Scene out.
#include <string>
#include <vector>

#include "bridge/api/border.h"
#include "bridge/api/environment_cube.h"
#include "bridge/base/handles.h"
#include "model/material.h"

using sideray::fail;
using sideray::bridge::guarded;
using sideray::bridge::init_struct;
using sideray::bridge::read_elements;
using sideray::bridge::read_struct;
using sideray::bridge::require;

void sideray_version(int* major, int* minor, int* patch) {
  if (major) *major = SIDERAY_VERSION_MAJOR;
  if (minor) *minor = SIDERAY_VERSION_MINOR;
  if (patch) *patch = SIDERAY_VERSION_PATCH;
}

void sideray_mesh_init(sideray_mesh_desc* out, size_t size) {
  sideray_mesh_desc d{};
  init_struct(out, size, d);
}

void sideray_material_init(sideray_material_desc* out, size_t size) {
  init_struct(out, size, sideray::model::default_material());
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
    require(mesh, "mesh result");
    *mesh = scene->scene.add_mesh(read_struct(desc, "mesh", sideray_mesh_init), dropped);
  });
}

sideray_status sideray_scene_replace_mesh(sideray_scene* scene, sideray_mesh mesh, const sideray_mesh_desc* desc,
                                          uint32_t* dropped, sideray_error* error) {
  return guarded(error, [&] {
    require(scene, "scene");
    scene->scene.replace_mesh(mesh, read_struct(desc, "mesh", sideray_mesh_init), dropped);
  });
}

sideray_status sideray_scene_remove_mesh(sideray_scene* scene, sideray_mesh mesh, sideray_error* error) {
  return guarded(error, [&] {
    require(scene, "scene");
    scene->scene.remove_mesh(mesh);
  });
}

sideray_status sideray_scene_set_vertices(sideray_scene* scene, sideray_mesh mesh, const sideray_mesh_desc* desc,
                                          sideray_error* error) {
  return guarded(error, [&] {
    require(scene, "scene");
    scene->scene.set_vertices(mesh, read_struct(desc, "mesh", sideray_mesh_init));
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

sideray_status sideray_scene_replace_texture(sideray_scene* scene, sideray_texture texture, uint32_t width,
                                             uint32_t height, sideray_texel_format format, const void* texels,
                                             sideray_error* error) {
  return guarded(error, [&] {
    require(scene, "scene");
    scene->scene.replace_texture(texture, width, height, format, texels);
  });
}

sideray_status sideray_scene_remove_texture(sideray_scene* scene, sideray_texture texture, sideray_error* error) {
  return guarded(error, [&] {
    require(scene, "scene");
    scene->scene.remove_texture(texture);
  });
}

sideray_status sideray_scene_add_material(sideray_scene* scene, const sideray_material_desc* desc,
                                          sideray_material* material, sideray_error* error) {
  return guarded(error, [&] {
    require(scene, "scene");
    require(material, "material result");
    *material = scene->scene.add_material(read_struct(desc, "material", sideray_material_init));
  });
}

sideray_status sideray_scene_replace_material(sideray_scene* scene, sideray_material material,
                                              const sideray_material_desc* desc, sideray_error* error) {
  return guarded(error, [&] {
    require(scene, "scene");
    scene->scene.replace_material(material, read_struct(desc, "material", sideray_material_init));
  });
}

sideray_status sideray_scene_remove_material(sideray_scene* scene, sideray_material material, sideray_error* error) {
  return guarded(error, [&] {
    require(scene, "scene");
    scene->scene.remove_material(material);
  });
}

sideray_status sideray_scene_add_instances(sideray_scene* scene, const sideray_instance_desc* descs,
                                           size_t stride_bytes, size_t count, sideray_instance* instances,
                                           sideray_error* error) {
  return guarded(error, [&] {
    require(scene, "scene");
    std::vector<sideray_instance_desc> copies;
    scene->scene.add_instances(read_elements(descs, stride_bytes, count, copies, "instances"), count, instances);
  });
}

sideray_status sideray_scene_replace_instances(sideray_scene* scene, const sideray_instance* instances,
                                               const sideray_instance_desc* descs, size_t stride_bytes, size_t count,
                                               sideray_error* error) {
  return guarded(error, [&] {
    require(scene, "scene");
    std::vector<sideray_instance_desc> copies;
    scene->scene.replace_instances(instances, read_elements(descs, stride_bytes, count, copies, "instances"), count);
  });
}

sideray_status sideray_scene_remove_instances(sideray_scene* scene, const sideray_instance* instances, size_t count,
                                              sideray_error* error) {
  return guarded(error, [&] {
    require(scene, "scene");
    scene->scene.remove_instances(instances, count);
  });
}

sideray_status sideray_scene_move_instances(sideray_scene* scene, const sideray_instance* instances, size_t count,
                                            const double* world_from_object, sideray_error* error) {
  return guarded(error, [&] {
    require(scene, "scene");
    scene->scene.move_instances(instances, count, world_from_object);
  });
}

sideray_status sideray_scene_renumber_instances(sideray_scene* scene, const sideray_instance* instances, size_t count,
                                                const uint32_t* surface_ids, sideray_error* error) {
  return guarded(error, [&] {
    require(scene, "scene");
    scene->scene.renumber_instances(instances, count, surface_ids);
  });
}

sideray_status sideray_scene_set_visibility(sideray_scene* scene, sideray_instance instance, uint32_t visibility,
                                            sideray_error* error) {
  return guarded(error, [&] {
    require(scene, "scene");
    scene->scene.set_visibility(instance, visibility);
  });
}

void sideray_wind_init(sideray_wind_desc* out, size_t size) {
  sideray_wind_desc d{};
  d.direction[0] = 1.0f;
  d.amplitude = 0.1f;
  d.frequency = 0.3f;
  d.height = 1.0f;
  d.branch_frequency = 0.8f;
  d.leaf_frequency = 2.0f;
  d.wavelength = 1.0f;
  init_struct(out, size, d);
}

sideray_status sideray_scene_add_wind(sideray_scene* scene, const sideray_wind_desc* desc, sideray_wind* wind,
                                      sideray_error* error) {
  return guarded(error, [&] {
    require(scene, "scene");
    require(wind, "wind result");
    *wind = scene->scene.add_wind(read_struct(desc, "wind description", sideray_wind_init));
  });
}

sideray_status sideray_scene_set_time(sideray_scene* scene, double time_s, double previous_time_s,
                                      sideray_error* error) {
  return guarded(error, [&] {
    require(scene, "scene");
    scene->scene.set_time(time_s, previous_time_s);
  });
}

void sideray_particles_init(sideray_particles_desc* out, size_t size) {
  sideray_particles_desc d{};
  d.columns = d.rows = 1;
  init_struct(out, size, d);
}

sideray_status sideray_scene_add_particles(sideray_scene* scene, const sideray_particles_desc* desc,
                                           sideray_particles* particles, sideray_error* error) {
  return guarded(error, [&] {
    require(scene, "scene");
    require(particles, "particles result");
    *particles = scene->scene.add_particles(read_struct(desc, "particles description", sideray_particles_init));
  });
}

sideray_status sideray_scene_set_sprites(sideray_scene* scene, sideray_particles particles,
                                         const sideray_sprite* sprites, size_t stride_bytes, size_t count,
                                         sideray_error* error) {
  return guarded(error, [&] {
    require(scene, "scene");
    std::vector<sideray_sprite> copies;
    scene->scene.set_sprites(particles, read_elements(sprites, stride_bytes, count, copies, "sprites"), count);
  });
}

void sideray_light_init(sideray_light* out, size_t size) {
  sideray_light l{};
  l.type = SIDERAY_LIGHT_DIRECTIONAL;
  l.direction[1] = -1.0f;
  for (float& i : l.intensity) i = 1.0f;
  l.outer_cone = 0.785398163f;
  init_struct(out, size, l);
}

namespace {

// Returns an array's lights; all elements have the size that the first one states.
template <typename Light>
std::vector<Light> read_lights(const Light* lights, size_t count, const std::string& name, void (*init)(Light*, size_t)) {
  std::vector<Light> read;
  if (count == 0) return read;
  require(lights, (name + "s").c_str());
  sideray::model::check_light_count(count);
  const size_t stride = lights->size;
  sideray::bridge::require_size(stride, sizeof(Light), (name + " 0").c_str());
  sideray::bridge::require_stride<Light>(stride, (name + "s").c_str());
  read.reserve(count);
  for (size_t i = 0; i < count; ++i) {
    const void* light = reinterpret_cast<const unsigned char*>(lights) + i * stride;
    read.push_back(read_struct(static_cast<const Light*>(light), name.c_str(), init));
    if (const size_t size = static_cast<const Light*>(light)->size; size != stride)
      fail(SIDERAY_INVALID_ARGUMENT, "{} {}: size is {}, where {} 0 has {}; give all lights the same", name, i, size, name,
           stride);
  }
  return read;
}

}  // namespace

sideray_status sideray_scene_set_lights(sideray_scene* scene, const sideray_light* lights, size_t count,
                                        sideray_error* error) {
  return guarded(error, [&] {
    require(scene, "scene");
    const std::vector<sideray_light> read = read_lights(lights, count, "light", sideray_light_init);
    scene->scene.set_lights(read.data(), read.size());
  });
}

sideray_status sideray_scene_set_environment(sideray_scene* scene, uint32_t width, uint32_t height, const float* rgb,
                                             float scale, float rotation_deg, sideray_error* error) {
  return guarded(error, [&] {
    require(scene, "scene");
    scene->scene.set_environment(width, height, rgb, scale, rotation_deg);
  });
}

sideray_status sideray_scene_set_environment_cube(sideray_scene* scene, uint32_t side, const float* const faces[6],
                                                  float scale, const float cube_from_world[9], sideray_error* error) {
  return guarded(error, [&] {
    require(scene, "scene");
    require(faces, "environment cube faces");
    const auto picture = sideray::bridge::lat_long_of_cube(side, faces, cube_from_world);
    scene->scene.set_environment(picture.width, picture.height, picture.rgb.data(), scale, 0.0f);
  });
}

void sideray_shader_init(sideray_shader_desc* out, size_t size) {
  sideray_shader_desc d{};
  d.radiance_scale = 1.0f;
  d.point_stride_bytes = sizeof(sideray_shading_point);
  d.result_stride_bytes = sizeof(sideray_shading_result);
  init_struct(out, size, d);
}

sideray_status sideray_scene_set_shader(sideray_scene* scene, const sideray_shader_desc* shader, sideray_error* error) {
  return guarded(error, [&] {
    require(scene, "scene");
    if (!shader) return scene->scene.set_shader(nullptr);
    const sideray_shader_desc desc = read_struct(shader, "shader description", sideray_shader_init);
    sideray::bridge::require_stride<sideray_shading_point>(desc.point_stride_bytes, "shader point_stride_bytes");
    sideray::bridge::require_stride<sideray_shading_result>(desc.result_stride_bytes, "shader result_stride_bytes");
    scene->scene.set_shader(&desc);
  });
}

void sideray_fixed_light_init(sideray_fixed_light* out, size_t size) {
  sideray_fixed_light l{};
  l.position[2] = 1.0;
  l.spot_direction[2] = -1.0f;
  l.spot_cutoff_deg = 180.0f;
  l.constant_attenuation = 1.0f;
  l.casts_shadows = 1;
  init_struct(out, size, l);
}

void sideray_fixed_material_init(sideray_fixed_material* out, size_t size) {
  sideray_fixed_material m{};
  for (float& c : m.ambient) c = 0.2f;
  for (float& c : m.diffuse) c = 0.8f;
  init_struct(out, size, m);
}

void sideray_fixed_function_init(sideray_fixed_function* out, size_t size) {
  sideray_fixed_function f{};
  for (float& c : f.ambient) c = 0.2f;
  f.radiance_space = SIDERAY_SPACE_GAMMA22;
  init_struct(out, size, f);
}

sideray_status sideray_scene_set_fixed_function(sideray_scene* scene, const sideray_fixed_function* model,
                                                sideray_error* error) {
  return guarded(error, [&] {
    require(scene, "scene");
    if (!model) return scene->scene.set_fixed_function(nullptr);
    sideray::model::FixedDesc read{read_struct(model, "fixed function", sideray_fixed_function_init), {}};
    read.lights = read_lights(read.desc.lights, read.desc.light_count, "fixed light", sideray_fixed_light_init);
    read.desc.lights = nullptr;
    scene->scene.set_fixed_function(&read);
  });
}

sideray_status sideray_scene_set_fixed_material(sideray_scene* scene, sideray_material material,
                                                const sideray_fixed_material* fixed, sideray_error* error) {
  return guarded(error, [&] {
    require(scene, "scene");
    if (!fixed) return scene->scene.set_fixed_material(material, nullptr);
    const sideray_fixed_material read = read_struct(fixed, "fixed material", sideray_fixed_material_init);
    scene->scene.set_fixed_material(material, &read);
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
