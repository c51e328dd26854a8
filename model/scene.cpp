#include "model/scene.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "model/environment.h"
#include "model/failure.h"
#include "model/material.h"
#include "model/material_slots.h"
#include "model/particles.h"
#include "model/placement.h"
#include "model/solid.h"
#include "model/texture.h"
#include "model/wind.h"

namespace sideray::model {
namespace {

constexpr size_t most_lights = 4096;
constexpr size_t most_instances = 0x7fffffffu;

// Returns the number in an enumeration from a C host, which may be none of its values: reading it as the enumeration
// would be undefined.
template <typename Enumeration>
int number_of(const Enumeration& enumeration) {
  int number;
  static_assert(sizeof(number) == sizeof(enumeration));
  std::memcpy(&number, &enumeration, sizeof(number));
  return number;
}

// Returns the object of this name; throws Failure if there is none.
template <typename T>
T& named(Slots<T>& slots, uint32_t name, const char* kind) {
  T* thing = slots.find(name);
  if (!thing)
    fail(SIDERAY_INVALID_ARGUMENT, "{} {}: there is none of this name; give one that was added and not removed", kind,
         name);
  return *thing;
}

// Returns the first instance that `uses` accepts.
template <typename Uses>
uint32_t first_instance(const Slots<sideray_instance_desc>& instances, const Uses& uses) {
  uint32_t first = 0;
  instances.for_each([&](uint32_t name, const sideray_instance_desc& d) {
    if (first == 0 && uses(d)) first = name;
  });
  return first;
}

struct Numbered {
  uint32_t surface_id, instance;
  auto operator<=>(const Numbered&) const = default;
};

// Throws where two surfaces with layers share a surface id, as each would take the other's layers.
void check_unique(std::vector<Numbered> surfaces) {
  std::sort(surfaces.begin(), surfaces.end());
  const auto same = [](const Numbered& a, const Numbered& b) { return a.surface_id == b.surface_id; };
  if (const auto first = std::adjacent_find(surfaces.begin(), surfaces.end(), same); first != surfaces.end())
    fail(SIDERAY_INVALID_ARGUMENT,
         "commit: instances {} and {} are translucent and both have surface_id {}; give each a number of its own, or 0 "
         "where it is not to be ray traced",
         first->instance, std::next(first)->instance, first->surface_id);
}

}  // namespace

void check_light_count(size_t count) {
  if (count > most_lights) fail(SIDERAY_INVALID_ARGUMENT, "{} lights: at most {} are possible", count, most_lights);
}

Scene::SceneMesh& Scene::mesh_named(uint32_t mesh) {
  return named(meshes_, mesh, "mesh");
}

Scene::SceneTexture& Scene::texture_named(uint32_t texture) {
  return named(textures_, texture, "texture");
}

Scene::SceneMaterial& Scene::material_named(uint32_t material) {
  return named(materials_, material, "material");
}

sideray_instance_desc& Scene::instance_named(uint32_t instance) {
  return named(instances_, instance, "instance");
}

uint32_t Scene::add_mesh(const sideray_mesh_desc& desc, uint32_t* dropped) {
  SceneMesh added;
  added.mesh = build_mesh(desc, dropped, added.form);
  return meshes_.add(std::move(added));
}

void Scene::replace_mesh(uint32_t mesh, const sideray_mesh_desc& desc, uint32_t* dropped) {
  SceneMesh& current = mesh_named(mesh);
  SceneMesh replaced;
  replaced.mesh = build_mesh(desc, dropped, replaced.form);
  replaced.users = current.users;
  current = std::move(replaced);
}

void Scene::remove_mesh(uint32_t mesh) {
  if (mesh_named(mesh).users != 0)
    fail(SIDERAY_INVALID_ARGUMENT, "mesh {}: instance {} uses it; remove or replace that first", mesh,
         first_instance(instances_, [&](const sideray_instance_desc& d) { return d.mesh == mesh; }));
  meshes_.remove(mesh);
}

void Scene::set_vertices(uint32_t mesh, const sideray_mesh_desc& desc) {
  SceneMesh& current = mesh_named(mesh);
  // A closed mesh stays closed, since its triangles keep their edges.
  current.mesh = build_moved_mesh(*current.mesh, current.form, desc);
}

uint32_t Scene::add_texture(uint32_t width, uint32_t height, sideray_texel_format format, const void* texels) {
  return textures_.add({build_texture(width, height, format, texels), 0});
}

void Scene::replace_texture(uint32_t texture, uint32_t width, uint32_t height, sideray_texel_format format,
                            const void* texels) {
  SceneTexture& current = texture_named(texture);
  current.texture = build_texture(width, height, format, texels);
}

void Scene::remove_texture(uint32_t texture) {
  if (texture_named(texture).users != 0) {
    materials_.for_each([&](uint32_t material, const SceneMaterial& m) {
      for (const MaterialSlot& s : material_slots)
        if ((m.desc.*s.slot).texture == texture)
          fail(SIDERAY_INVALID_ARGUMENT, "texture {}: material {} has it as {}; remove or replace that first", texture,
               material, s.name);
    });
    for (size_t i = 0; i < particles_.size(); ++i)
      if (particles_[i].desc.texture == texture)
        fail(SIDERAY_INVALID_ARGUMENT, "texture {}: particles {} have it; replace the texture instead", texture, i + 1);
  }
  textures_.remove(texture);
}

void Scene::check_textures(const sideray_material_desc& desc) const {
  for (const MaterialSlot& s : material_slots)
    if (const uint32_t texture = (desc.*s.slot).texture; texture != 0 && !textures_.find(texture))
      fail(SIDERAY_INVALID_ARGUMENT, "material {}: there is no texture {}; add it first, or give 0 for none", s.name,
           texture);
}

void Scene::count_users(const sideray_material_desc& desc, int change) {
  for (const MaterialSlot& s : material_slots)
    if (const uint32_t texture = (desc.*s.slot).texture; texture != 0)
      textures_.find(texture)->users += static_cast<size_t>(change);
}

uint32_t Scene::add_material(const sideray_material_desc& d) {
  check_material(d);
  check_textures(d);
  const uint32_t material = materials_.add({d, 0, {}});
  count_users(d, 1);
  return material;
}

void Scene::replace_material(uint32_t material, const sideray_material_desc& d) {
  SceneMaterial& current = material_named(material);
  check_material(d);
  check_textures(d);
  count_users(current.desc, -1);
  count_users(d, 1);
  current.desc = d;
}

void Scene::remove_material(uint32_t material) {
  const SceneMaterial& current = material_named(material);
  if (current.users != 0)
    fail(SIDERAY_INVALID_ARGUMENT, "material {}: instance {} uses it; remove or replace that first", material,
         first_instance(instances_, [&](const sideray_instance_desc& d) { return d.material == material; }));
  count_users(current.desc, -1);
  materials_.remove(material);
}

void Scene::check_instance(const sideray_instance_desc& d, size_t index) const {
  if (!meshes_.find(d.mesh))
    fail(SIDERAY_INVALID_ARGUMENT, "instance {}: there is no mesh {}; add it first", index, d.mesh);
  if (!materials_.find(d.material))
    fail(SIDERAY_INVALID_ARGUMENT, "instance {}: there is no material {}; add it first", index, d.material);
  check_transform(d.world_from_object, index);
  if (d.wind > winds_.size())
    fail(SIDERAY_INVALID_ARGUMENT, "instance {}: there is no wind {}; {} have been added", index, d.wind,
         winds_.size());
  if (!(d.wind_phase >= 0.0f && d.wind_phase <= 1.0f))
    fail(SIDERAY_INVALID_ARGUMENT, "instance {}: wind_phase is {}; give 0 to 1", index, d.wind_phase);
}

void Scene::check_names(const uint32_t* instances, size_t count) const {
  if (count && !instances) fail(SIDERAY_INVALID_ARGUMENT, "instances: NULL, although count is {}", count);
  for (size_t i = 0; i < count; ++i)
    if (!instances_.find(instances[i]))
      fail(SIDERAY_INVALID_ARGUMENT, "instances[{}]: there is no instance {}; give one that was added and not removed",
           i, instances[i]);
}

void Scene::count_users(const sideray_instance_desc& desc, int change) {
  meshes_.find(desc.mesh)->users += static_cast<size_t>(change);
  materials_.find(desc.material)->users += static_cast<size_t>(change);
}

void Scene::add_instances(const sideray_instance_desc* descs, size_t count, uint32_t* instances) {
  if (count && !descs) fail(SIDERAY_INVALID_ARGUMENT, "instances: NULL, although count is {}", count);
  if (instances_.size() + count > most_instances)
    fail(SIDERAY_INVALID_ARGUMENT, "instances: more than 2^31-1 in all");
  for (size_t i = 0; i < count; ++i) check_instance(descs[i], i);
  instances_.reserve(count);
  for (size_t i = 0; i < count; ++i) {
    const uint32_t name = instances_.add(descs[i]);
    count_users(descs[i], 1);
    if (instances) instances[i] = name;
  }
}

void Scene::replace_instances(const uint32_t* instances, const sideray_instance_desc* descs, size_t count) {
  check_names(instances, count);
  if (count && !descs) fail(SIDERAY_INVALID_ARGUMENT, "instances: NULL, although count is {}", count);
  for (size_t i = 0; i < count; ++i) check_instance(descs[i], i);
  for (size_t i = 0; i < count; ++i) {
    sideray_instance_desc& current = instance_named(instances[i]);
    count_users(current, -1);
    count_users(descs[i], 1);
    current = descs[i];
  }
}

void Scene::remove_instances(const uint32_t* instances, size_t count) {
  check_names(instances, count);
  std::vector<uint32_t> sorted(instances, instances + count);
  std::sort(sorted.begin(), sorted.end());
  if (const auto twice = std::adjacent_find(sorted.begin(), sorted.end()); twice != sorted.end())
    fail(SIDERAY_INVALID_ARGUMENT, "instance {}: is to be removed twice; give each name once", *twice);
  for (const uint32_t name : sorted) {
    count_users(*instances_.find(name), -1);
    instances_.remove(name);
  }
}

void Scene::move_instances(const uint32_t* instances, size_t count, const double* world_from_object) {
  check_names(instances, count);
  if (count && !world_from_object)
    fail(SIDERAY_INVALID_ARGUMENT, "world_from_object: NULL, although count is {}", count);
  for (size_t i = 0; i < count; ++i) check_transform(world_from_object + 12 * i, i);
  for (size_t i = 0; i < count; ++i)
    std::copy_n(world_from_object + 12 * i, 12, instance_named(instances[i]).world_from_object);
}

void Scene::renumber_instances(const uint32_t* instances, size_t count, const uint32_t* surface_ids) {
  check_names(instances, count);
  if (count && !surface_ids) fail(SIDERAY_INVALID_ARGUMENT, "surface_ids: NULL, although count is {}", count);
  for (size_t i = 0; i < count; ++i) instance_named(instances[i]).surface_id = surface_ids[i];
}

void Scene::set_visibility(uint32_t instance, uint32_t visibility) {
  sideray_instance_desc& current = instance_named(instance);
  if (visibility & ~uint32_t{SIDERAY_VISIBLE_ALL})
    fail(SIDERAY_INVALID_ARGUMENT, "visibility {:#x}: has bits beyond SIDERAY_VISIBLE_ALL", visibility);
  current.visibility = visibility;
}

uint32_t Scene::add_particles(const sideray_particles_desc& desc) {
  check_particles(desc);
  SceneTexture* texture = textures_.find(desc.texture);
  if (desc.texture != 0 && !texture)
    fail(SIDERAY_INVALID_ARGUMENT, "particles: there is no texture {}; add it first, or give 0 for white",
         desc.texture);
  particles_.push_back({desc, {}});
  if (texture) ++texture->users;
  return static_cast<uint32_t>(particles_.size());
}

void Scene::set_sprites(uint32_t particles, const sideray_sprite* sprites, size_t count) {
  if (particles == 0 || particles > particles_.size())
    fail(SIDERAY_INVALID_ARGUMENT, "particles {}: there are {} systems", particles, particles_.size());
  check_sprites(sprites, count);
  particles_[particles - 1].sprites.assign(sprites, sprites + count);
}

uint32_t Scene::add_wind(const sideray_wind_desc& desc) {
  winds_.push_back(checked_wind(desc));
  return static_cast<uint32_t>(winds_.size());
}

void Scene::set_time(double time_s, double previous_time_s) {
  for (const double t : {time_s, previous_time_s})
    if (!(std::abs(t) <= 1e9)) fail(SIDERAY_INVALID_ARGUMENT, "time {}: give seconds from -1e9 to 1e9", t);
  time_s_ = time_s;
  previous_time_s_ = previous_time_s;
}

void Scene::set_lights(const sideray_light* lights, size_t count) {
  check_light_count(count);
  if (count && !lights) fail(SIDERAY_INVALID_ARGUMENT, "lights: NULL, although count is {}", count);
  for (size_t i = 0; i < count; ++i) check_light(lights[i], i);
  lights_.assign(lights, lights + count);
}

void Scene::set_environment(uint32_t width, uint32_t height, const float* rgb, float scale, float rotation_deg) {
  environment_ = build_environment(width, height, rgb, scale, rotation_deg);
}

void Scene::set_shader(const sideray_shader_desc* shader) {
  if (!shader) {
    shader_ = {};
    shader_use_.reset();
    return;
  }
  if (fixed_)
    fail(SIDERAY_INVALID_ARGUMENT, "shader: the scene is shaded by the fixed function; take that away first, or leave one out");
  if (!shader->shade)
    fail(SIDERAY_INVALID_ARGUMENT, "shader shade: NULL; give a function, or no shader for the built-in model");
  if (const int thread = number_of(shader->thread);
      thread < SIDERAY_SHADE_ON_WORKERS || thread > SIDERAY_SHADE_IN_CALLS)
    fail(SIDERAY_INVALID_ARGUMENT, "shader thread {}: give a sideray_shader_thread", thread);
  if (const int space = number_of(shader->radiance_space);
      space < SIDERAY_SPACE_LINEAR || space > SIDERAY_SPACE_GAMMA22)
    fail(SIDERAY_INVALID_ARGUMENT, "shader radiance_space {}: give a sideray_radiance_space", space);
  if (!(shader->radiance_scale > 0.0f && std::isfinite(shader->radiance_scale)))
    fail(SIDERAY_INVALID_ARGUMENT, "shader radiance_scale is {}: out of range; give a finite factor above 0",
         double{shader->radiance_scale});
  shader_use_ = shader->release ? std::shared_ptr<const void>(shader->user, shader->release) : nullptr;
  shader_ = *shader;
}

void Scene::set_fixed_function(const FixedDesc* model) {
  if (!model) return fixed_.reset();
  if (shader_.shade)
    fail(SIDERAY_INVALID_ARGUMENT, "fixed function: the scene has a shader of the host; take that away first, or leave one out");
  check_fixed_function(*model);
  fixed_ = *model;
}

void Scene::set_fixed_material(uint32_t material, const sideray_fixed_material* fixed) {
  SceneMaterial& current = material_named(material);
  if (!fixed) return current.fixed.reset();
  check_fixed_material(*fixed);
  current.fixed = *fixed;
}

const std::shared_ptr<const Environment>& Scene::environment() {
  if (!environment_) environment_ = build_environment(0, 0, nullptr, 1.0f, 0.0f);
  return environment_;
}

bool Scene::is_closed_glass(SceneMesh& mesh, const sideray_material_desc& material) {
  if (!has_volume(material) && !(material.transmission > 0.0f && material.double_sided)) return false;
  if (!mesh.closed) mesh.closed = is_closed(*mesh.mesh);
  return *mesh.closed;
}

Material Scene::placed_material(const SceneMaterial& material, const Places& places) const {
  const sideray_material_desc& desc = material.desc;
  sideray_material_desc placed = desc;
  for (const MaterialSlot& s : material_slots)
    if (uint32_t& texture = (placed.*s.slot).texture; texture != 0) texture = places.textures[texture] + 1;
  const auto texture_of = [&](const sideray_texture_slot& slot) {
    const SceneTexture* found = textures_.find(slot.texture);
    return found ? found->texture.get() : nullptr;
  };
  Material made = make_material(placed, texture_of(desc.base_color_texture), texture_of(desc.metallic_roughness_texture));
  if (fixed_) apply_fixed_material(material.fixed.value_or(fixed_material_of(desc)), made);
  return made;
}

// Adds an instance of lines or points, whose material is made opaque, and unlit if the mesh has no normals.
// `materials`: those made before, by name and whether the mesh has normals.
void Scene::commit_thin(const sideray_instance_desc& d, const Places& places, Snapshot& snapshot,
                        std::map<std::pair<uint32_t, bool>, uint32_t>& materials) const {
  const SceneMesh& mesh = *meshes_.find(d.mesh);
  Instance& instance = snapshot.thin.emplace_back(local_instance(d, snapshot.origin, *mesh.mesh, nullptr));
  instance.wind = 0;
  instance.mesh = places.meshes[d.mesh];
  const auto [made, is_new] = materials.try_emplace({d.material, mesh.form.has_normals}, 0);
  if (is_new) {
    made->second = static_cast<uint32_t>(snapshot.materials.size());
    SceneMaterial material = *materials_.find(d.material);
    if (material.desc.alpha_mode == SIDERAY_BLEND) material.desc.alpha_mode = SIDERAY_OPAQUE;
    material.desc.transmission = material.desc.diffuse_transmission = 0.0f;
    if (!mesh.form.has_normals) material.desc.unlit = 1;
    Material placed = placed_material(material, places);
    placed.cull_back = false;
    snapshot.materials.push_back(placed);
  }
  instance.material = made->second;
  if (instance.bounds.empty()) return;
  snapshot.bounds.add(instance.bounds.minimum);
  snapshot.bounds.add(instance.bounds.maximum);
}

void Scene::commit_instances(const Places& places, Snapshot& snapshot) {
  OriginChoice choice;
  instances_.for_each([&](uint32_t, const sideray_instance_desc& d) { choice.add(d.world_from_object); });
  snapshot.origin = choice.origin();
  snapshot.instances.reserve(instances_.size());
  const Names names = instances_.names();
  std::map<std::pair<uint32_t, bool>, uint32_t> thin_materials;
  Names surface_names;
  size_t place = 0;
  instances_.for_each([&](uint32_t, const sideray_instance_desc& d) {
    const Name name = names[place++];
    SceneMesh& mesh = *meshes_.find(d.mesh);
    if (mesh.mesh->topology != SIDERAY_TRIANGLES) return commit_thin(d, places, snapshot, thin_materials);
    surface_names.all.push_back(name);
    const Wind* wind = d.wind ? &winds_[d.wind - 1] : nullptr;
    Instance& instance = snapshot.instances.emplace_back(local_instance(d, snapshot.origin, *mesh.mesh, wind));
    instance.mesh = places.meshes[d.mesh];
    instance.material = places.materials[d.material];
    Material& material = snapshot.materials[instance.material];
    const bool closed = is_closed_glass(mesh, material.desc), volume = has_volume(material.desc);
    instance.solid = closed && volume;
    instance.shell = closed && !volume;
    if (material.desc.alpha_mode == SIDERAY_BLEND && mesh.mesh->has_colors) {
      const uint32_t texture = material.desc.base_color_texture.texture;
      const Texture* base_color = texture ? snapshot.textures[texture - 1].get() : nullptr;
      material.discards |= mesh.mesh->minimum_alpha * lowest_alpha(material.desc, base_color) < least_blended_alpha;
    }
    if (instance.bounds.empty()) return;
    snapshot.bounds.add(instance.bounds.minimum);
    snapshot.bounds.add(instance.bounds.maximum);
  });
  snapshot.instance_names = snapshot.thin.empty() ? names : std::move(surface_names);
}

void Scene::commit_particles(const Places& places, Snapshot& snapshot) const {
  for (const SceneParticles& p : particles_) {
    ParticleSystem& system = snapshot.particles.emplace_back(ParticleSystem{p.desc, {}});
    if (p.desc.texture != 0) system.desc.texture = places.textures[p.desc.texture] + 1;
    system.sprites.reserve(p.sprites.size());
    for (const sideray_sprite& sprite : p.sprites)
      system.sprites.push_back(local_sprite(sprite, p.desc, snapshot.origin));
  }
}

void Scene::commit_shading(Snapshot& snapshot) {
  snapshot.environment = environment();
  snapshot.shader = shader_;
  snapshot.shader_use = shader_use_;
  if (!fixed_) return;
  snapshot.fixed = std::make_shared<FixedFunction>(local_fixed_function(*fixed_, snapshot.origin));
  const sideray_radiance_space space = fixed_->desc.radiance_space;
  if (space == SIDERAY_SPACE_LINEAR || environment_->black) return;
  if (encoded_from_ != environment_ || encoded_space_ != space) encoded_ = encoded_environment(*environment_, space);
  encoded_from_ = environment_, encoded_space_ = space;
  snapshot.environment = encoded_;
}

void Scene::commit() {
  std::vector<Numbered> surfaces;
  instances_.for_each([&](uint32_t name, const sideray_instance_desc& d) {
    const bool layers = d.surface_id != 0 && (d.visibility & SIDERAY_VISIBLE_LAYERS) != 0;
    const bool thin = meshes_.find(d.mesh)->mesh->topology != SIDERAY_TRIANGLES;
    if (layers && !thin && is_translucent(materials_.find(d.material)->desc)) surfaces.push_back({d.surface_id, name});
  });
  check_unique(std::move(surfaces));
  auto snapshot = std::make_shared<Snapshot>();
  const Places places{meshes_.places(), textures_.places(), materials_.places()};
  snapshot->mesh_names = meshes_.names();
  snapshot->material_names = materials_.names();
  meshes_.for_each([&](uint32_t, const SceneMesh& m) { snapshot->meshes.push_back(m.mesh); });
  textures_.for_each([&](uint32_t, const SceneTexture& t) { snapshot->textures.push_back(t.texture); });
  materials_.for_each(
      [&](uint32_t, const SceneMaterial& m) { snapshot->materials.push_back(placed_material(m, places)); });
  snapshot->winds = winds_;
  snapshot->time_s = time_s_;
  snapshot->previous_time_s = previous_time_s_;
  commit_instances(places, *snapshot);
  for (const sideray_light& light : lights_) snapshot->lights.push_back(local_light(light, snapshot->origin));
  commit_particles(places, *snapshot);
  commit_shading(*snapshot);
  snapshot->revision = ++revision_;
  const std::lock_guard lock(snapshot_mutex_);
  snapshot_ = std::move(snapshot);
}

std::shared_ptr<const Snapshot> Scene::snapshot() const {
  const std::lock_guard lock(snapshot_mutex_);
  return snapshot_;
}

size_t Scene::slot_count() const {
  return meshes_.slot_count() + textures_.slot_count() + materials_.slot_count() + instances_.slot_count();
}

}  // namespace sideray::model
