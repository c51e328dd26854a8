#include "model/scene.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "model/environment.h"
#include "model/failure.h"
#include "model/material_slots.h"
#include "model/particles.h"
#include "model/solid.h"
#include "model/texture.h"
#include "model/wind.h"

namespace sideray::model {
namespace {

constexpr size_t most_lights = 256;
// Of factors and intensities: their products stay inside the range of floats.
constexpr float largest_factor = 1e15f;
// Origins are multiples of this, so that moving a camera or adding an object rarely moves the origin.
constexpr double origin_step = 1024.0;

void require(bool condition, const char* what, double value, const char* range) {
  if (!condition) fail(SIDERAY_INVALID_ARGUMENT, "{} is {}: out of range; give {}", what, value, range);
}

// What a C host has put into an enumeration, be it none of its values: to read it as one would be undefined.
template <typename Enumeration>
int number_of(const Enumeration& enumeration) {
  int number;
  static_assert(sizeof(number) == sizeof(enumeration));
  std::memcpy(&number, &enumeration, sizeof(number));
  return number;
}

void check_slot(const sideray_texture_slot& slot, const char* name, size_t textures) {
  if (slot.texture > textures)
    fail(SIDERAY_INVALID_ARGUMENT, "material {}: there is no texture {}; {} have been added", name, slot.texture,
         textures);
  if (slot.texture == 0) return;
  if (slot.uv_set > 1) fail(SIDERAY_INVALID_ARGUMENT, "material {}: uv_set {} is not 0 or 1", name, slot.uv_set);
  for (const float m : slot.texture_from_uv)
    if (!(std::abs(m) <= largest_factor))
      fail(SIDERAY_INVALID_ARGUMENT, "material {}: texture_from_uv holds {}; give numbers up to 1e15", name, m);
}

void check_unit(float value, const char* name) {
  require(value >= 0.0f && value <= 1.0f, name, double{value}, "0 to 1");
}

void check_material(const sideray_material_desc& d, size_t textures) {
  for (const float c : d.base_color) require(c >= 0.0f && c <= 1e6f, "material base_color", double{c}, "0 to 1");
  check_unit(d.metallic, "material metallic");
  check_unit(d.roughness, "material roughness");
  check_unit(d.transmission, "material transmission");
  check_unit(d.specular, "material specular");
  check_unit(d.occlusion_strength, "material occlusion_strength");
  for (const float e : d.emissive)
    require(e >= 0.0f && e <= largest_factor, "material emissive", double{e}, "0 to 1e15");
  for (const float c : d.specular_color)
    require(c >= 0.0f && c <= largest_factor, "material specular_color", double{c}, "0 to 1e15");
  for (const float c : d.attenuation_color) check_unit(c, "material attenuation_color");
  check_unit(d.clearcoat, "material clearcoat");
  check_unit(d.clearcoat_roughness, "material clearcoat_roughness");
  check_unit(d.sheen_roughness, "material sheen_roughness");
  check_unit(d.diffuse_transmission, "material diffuse_transmission");
  for (const float c : d.sheen_color) check_unit(c, "material sheen_color");
  for (const float c : d.diffuse_transmission_color) check_unit(c, "material diffuse_transmission_color");
  require(std::abs(d.clearcoat_normal_scale) <= largest_factor, "material clearcoat_normal_scale",
          double{d.clearcoat_normal_scale}, "-1e15 to 1e15");
  require(d.ior >= 1.0f && d.ior < 100.0f, "material ior", double{d.ior}, "1 to 100");
  require(d.thickness >= 0.0f && d.thickness <= largest_factor, "material thickness", double{d.thickness}, "0 to 1e15");
  require(d.attenuation_distance > 0.0f, "material attenuation_distance", double{d.attenuation_distance},
          "more than 0, or +inf");
  require(std::abs(d.normal_scale) <= largest_factor, "material normal_scale", double{d.normal_scale}, "-1e15 to 1e15");
  require(d.alpha_cutoff >= 0.0f && std::isfinite(d.alpha_cutoff), "material alpha_cutoff", double{d.alpha_cutoff},
          "0 or more");
  require(d.alpha_mode >= SIDERAY_OPAQUE && d.alpha_mode <= SIDERAY_BLEND, "material alpha_mode",
          static_cast<double>(d.alpha_mode), "a sideray_alpha_mode");
  require(d.blend_mode >= SIDERAY_BLEND_ALPHA && d.blend_mode <= SIDERAY_BLEND_MULTIPLY, "material blend_mode",
          static_cast<double>(d.blend_mode), "a sideray_blend_mode");
  require(d.distortion >= 0.0f && d.distortion <= 100.0f, "material distortion", double{d.distortion}, "0 to 100");
  for (const MaterialSlot& s : material_slots) check_slot(d.*s.slot, s.name, textures);
}

glm::dmat4x3 affine(const double* columns) {
  glm::dmat4x3 m;
  for (int c = 0; c < 4; ++c) m[c] = glm::dvec3(columns[3 * c], columns[3 * c + 1], columns[3 * c + 2]);
  return m;
}

void check_transform(const double* m, size_t index) {
  for (int i = 0; i < 12; ++i)
    if (!std::isfinite(m[i]) || std::abs(m[i]) > 1e15)
      fail(SIDERAY_INVALID_ARGUMENT, "instance {}: world_from_object[{}] is {}; give finite numbers below 1e15", index,
           i, m[i]);
  const glm::dmat4x3 a = affine(m);
  const double determinant = glm::determinant(glm::dmat3(a[0], a[1], a[2]));
  if (!(std::abs(determinant) > 1e-30))
    fail(SIDERAY_INVALID_ARGUMENT, "instance {}: world_from_object cannot be inverted (determinant {}); leave it out",
         index, determinant);
}

void check_light(const sideray_light& l, size_t index) {
  const bool directional = l.type == SIDERAY_LIGHT_DIRECTIONAL;
  if (l.type < SIDERAY_LIGHT_DIRECTIONAL || l.type > SIDERAY_LIGHT_SPOT)
    fail(SIDERAY_INVALID_ARGUMENT, "light {}: type {} is not a sideray_light_type", index, static_cast<int>(l.type));
  for (const float i : l.intensity)
    if (!(i >= 0.0f && i <= largest_factor))
      fail(SIDERAY_INVALID_ARGUMENT, "light {}: intensity holds {}; give 0 to 1e15", index, i);
  const float length = std::hypot(l.direction[0], l.direction[1], l.direction[2]);
  if (l.type != SIDERAY_LIGHT_POINT && !(length > 1e-12f && std::isfinite(length)))
    fail(SIDERAY_INVALID_ARGUMENT, "light {}: direction must be finite and not zero", index);
  for (const double p : l.position)
    if (!directional && !(std::abs(p) < 1e15))
      fail(SIDERAY_INVALID_ARGUMENT, "light {}: position must be finite and below 1e15", index);
  if (!(l.range >= 0.0f))
    fail(SIDERAY_INVALID_ARGUMENT, "light {}: range {} is negative; 0 = unlimited", index, l.range);
  if (!(l.radius >= 0.0f && std::isfinite(l.radius)))
    fail(SIDERAY_INVALID_ARGUMENT, "light {}: radius {} must be finite and not negative", index, l.radius);
  if (!(l.angular_diameter_deg >= 0.0f && l.angular_diameter_deg < 180.0f))
    fail(SIDERAY_INVALID_ARGUMENT, "light {}: angular_diameter_deg {} must be 0 or more and below 180", index,
         l.angular_diameter_deg);
  if (l.type == SIDERAY_LIGHT_SPOT && !(l.inner_cone >= 0.0f && l.inner_cone < l.outer_cone && l.outer_cone <= 1.5708f))
    fail(SIDERAY_INVALID_ARGUMENT, "light {}: cones {} and {} break 0 <= inner < outer <= pi/2", index, l.inner_cone,
         l.outer_cone);
}

float lowest_alpha(const sideray_material_desc& d, const std::vector<std::shared_ptr<const Texture>>& textures) {
  const uint32_t t = d.base_color_texture.texture;
  return d.base_color[3] * (t ? static_cast<float>(textures[t - 1]->minimum_alpha) / 255.0f : 1.0f);
}

// Where alpha below the threshold can come from at all.
bool can_discard(const sideray_material_desc& d, const std::vector<std::shared_ptr<const Texture>>& textures) {
  if (d.alpha_mode == SIDERAY_OPAQUE) return false;
  if (d.alpha_mode == SIDERAY_MASK) return true;
  return lowest_alpha(d, textures) < 1.0f / 255.0f;
}

Bounds transformed(const Bounds& bounds, const glm::mat4x3& m) {
  Bounds result;
  if (bounds.empty()) return result;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::vec3 p((corner & 1) ? bounds.maximum.x : bounds.minimum.x,
                      (corner & 2) ? bounds.maximum.y : bounds.minimum.y,
                      (corner & 4) ? bounds.maximum.z : bounds.minimum.z);
    result.add(m * glm::vec4(p, 1.0f));
  }
  return result;
}

Light local_light(const sideray_light& l, glm::dvec3 origin) {
  Light light{};
  light.type = l.type;
  light.position = glm::vec3(glm::dvec3(l.position[0], l.position[1], l.position[2]) - origin);
  const glm::vec3 direction(l.direction[0], l.direction[1], l.direction[2]);
  light.direction = l.type == SIDERAY_LIGHT_POINT ? glm::vec3(0, -1, 0) : glm::normalize(direction);
  light.intensity = glm::vec3(l.intensity[0], l.intensity[1], l.intensity[2]);
  light.range = l.range;
  light.cos_inner = std::cos(l.inner_cone);
  light.cos_outer = std::cos(l.outer_cone);
  light.radius = l.radius;
  light.angular_radius = 0.5f * glm::radians(l.angular_diameter_deg);
  light.filter_radius = l.shadow_filter_radius == 0.0f ? 32.0f : l.shadow_filter_radius;
  light.filter_frames = l.shadow_filter_frames == 0 ? 8 : l.shadow_filter_frames;
  return light;
}

Instance local_instance(const sideray_instance_desc& d, glm::dvec3 origin, const Mesh& mesh, const Wind* wind) {
  Instance instance{};
  instance.mesh = d.mesh - 1;
  instance.material = d.material - 1;
  glm::dmat4x3 m = affine(d.world_from_object);
  m[3] -= origin;
  instance.local_from_object = glm::mat4x3(m);
  const glm::dmat3 linear(m[0], m[1], m[2]);
  instance.normal_from_object = glm::mat3(glm::transpose(glm::inverse(linear)));
  instance.mirrored = glm::determinant(linear) < 0;
  instance.surface_id = d.surface_id;
  instance.visibility = d.visibility;
  instance.wind = d.wind;
  instance.wind_phase = d.wind_phase;
  instance.user = d.user;
  instance.bounds = transformed(wind ? reached_in_wind(mesh.bounds, *wind) : mesh.bounds, instance.local_from_object);
  return instance;
}

// The middle of all instances' origins, on a coarse grid: 0 for every scene near the world's origin.
glm::dvec3 choose_origin(const std::vector<sideray_instance_desc>& instances) {
  if (instances.empty()) return glm::dvec3(0);
  glm::dvec3 low(INFINITY), high(-INFINITY);
  for (const sideray_instance_desc& d : instances) {
    const glm::dvec3 p(d.world_from_object[9], d.world_from_object[10], d.world_from_object[11]);
    low = glm::min(low, p), high = glm::max(high, p);
  }
  return glm::round(0.5 * (low + high) / origin_step) * origin_step;
}

}  // namespace

void check_light_count(size_t count) {
  if (count > most_lights) fail(SIDERAY_INVALID_ARGUMENT, "{} lights: at most {} are possible", count, most_lights);
}

uint32_t Scene::add_mesh(const sideray_mesh_desc& desc, uint32_t* dropped) {
  MeshForm form;
  auto mesh = build_mesh(desc, dropped, form);
  forms_.resize(meshes_.size() + 1);
  forms_.back() = std::move(form);
  meshes_.push_back(std::move(mesh));
  return static_cast<uint32_t>(meshes_.size());
}

void Scene::set_vertices(uint32_t mesh, const sideray_mesh_desc& desc) {
  if (mesh == 0 || mesh > meshes_.size())
    fail(SIDERAY_INVALID_ARGUMENT, "mesh {}: there is none; {} have been added", mesh, meshes_.size());
  std::shared_ptr<const Mesh>& current = meshes_[mesh - 1];
  std::shared_ptr<const Mesh> moved = build_moved_mesh(*current, forms_[mesh - 1], desc);
  // What is closed stays closed: edges are the triangles'. Another mesh may come to lie where this one was.
  if (const auto known = closed_.find(current.get()); known != closed_.end()) {
    const bool closed = known->second;
    closed_.emplace(moved.get(), closed);
    closed_.erase(current.get());
  }
  current = std::move(moved);
}

uint32_t Scene::add_texture(uint32_t width, uint32_t height, sideray_texel_format format, const void* texels) {
  textures_.push_back(build_texture(width, height, format, texels));
  return static_cast<uint32_t>(textures_.size());
}

uint32_t Scene::add_material(const sideray_material_desc& d) {
  check_material(d, textures_.size());
  Material material{};
  material.desc = d;
  material.translucent = d.alpha_mode == SIDERAY_BLEND || d.transmission > 0.0f;
  material.cull_back = !d.double_sided;
  material.discards = can_discard(d, textures_);
  // Blend modes apply to BLEND; a transmissive material that is not BLEND composites as plain alpha with a = 1.
  if (d.alpha_mode != SIDERAY_BLEND) material.desc.blend_mode = SIDERAY_BLEND_ALPHA;
  material.traceable = material.translucent && material.desc.blend_mode != SIDERAY_BLEND_MULTIPLY;
  materials_.push_back(material);
  return static_cast<uint32_t>(materials_.size());
}

void Scene::add_instances(const sideray_instance_desc* descs, size_t count, uint32_t* instances) {
  if (count && !descs) fail(SIDERAY_INVALID_ARGUMENT, "instances: NULL, although count is {}", count);
  if (instances_.size() + count > 0x7fffffffu) fail(SIDERAY_INVALID_ARGUMENT, "instances: more than 2^31-1 in all");
  for (size_t i = 0; i < count; ++i) {
    const sideray_instance_desc& d = descs[i];
    if (d.mesh == 0 || d.mesh > meshes_.size())
      fail(SIDERAY_INVALID_ARGUMENT, "instance {}: there is no mesh {}; {} have been added", i, d.mesh, meshes_.size());
    if (d.material == 0 || d.material > materials_.size())
      fail(SIDERAY_INVALID_ARGUMENT, "instance {}: there is no material {}; {} have been added", i, d.material,
           materials_.size());
    check_transform(d.world_from_object, i);
    if (d.wind > winds_.size())
      fail(SIDERAY_INVALID_ARGUMENT, "instance {}: there is no wind {}; {} have been added", i, d.wind, winds_.size());
    if (!(d.wind_phase >= 0.0f && d.wind_phase <= 1.0f))
      fail(SIDERAY_INVALID_ARGUMENT, "instance {}: wind_phase is {}; give 0 to 1", i, d.wind_phase);
  }
  const size_t first = instances_.size();
  instances_.insert(instances_.end(), descs, descs + count);
  for (size_t i = 0; i < count && instances; ++i) instances[i] = static_cast<uint32_t>(first + 1 + i);
}

void Scene::move_instances(const uint32_t* instances, size_t count, const double* world_from_object) {
  if (count && (!instances || !world_from_object))
    fail(SIDERAY_INVALID_ARGUMENT, "instances or world_from_object: NULL, although count is {}", count);
  for (size_t i = 0; i < count; ++i) {
    if (instances[i] == 0 || instances[i] > instances_.size())
      fail(SIDERAY_INVALID_ARGUMENT, "instance {}: there are {}", instances[i], instances_.size());
    check_transform(world_from_object + 12 * i, i);
  }
  for (size_t i = 0; i < count; ++i)
    std::copy_n(world_from_object + 12 * i, 12, instances_[instances[i] - 1].world_from_object);
}

void Scene::set_visibility(uint32_t instance, uint32_t visibility) {
  if (instance == 0 || instance > instances_.size())
    fail(SIDERAY_INVALID_ARGUMENT, "instance {}: there are {}", instance, instances_.size());
  if (visibility & ~uint32_t{SIDERAY_VISIBLE_ALL})
    fail(SIDERAY_INVALID_ARGUMENT, "visibility {:#x}: has bits beyond SIDERAY_VISIBLE_ALL", visibility);
  instances_[instance - 1].visibility = visibility;
}

uint32_t Scene::add_particles(const sideray_particles_desc& desc) {
  check_particles(desc, textures_.size());
  particles_.push_back({desc, {}});
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
  time_s_ = time_s, previous_time_s_ = previous_time_s;
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
    return;
  }
  if (!shader->shade)
    fail(SIDERAY_INVALID_ARGUMENT, "shader shade: NULL; give a function, or no shader for the built-in model");
  if (const int thread = number_of(shader->thread);
      thread < SIDERAY_SHADE_ON_WORKERS || thread > SIDERAY_SHADE_IN_CALLS)
    fail(SIDERAY_INVALID_ARGUMENT, "shader thread {}: give a sideray_shader_thread", thread);
  if (const int space = number_of(shader->radiance_space);
      space < SIDERAY_SPACE_LINEAR || space > SIDERAY_SPACE_GAMMA22)
    fail(SIDERAY_INVALID_ARGUMENT, "shader radiance_space {}: give a sideray_radiance_space", space);
  require(shader->radiance_scale > 0.0f && std::isfinite(shader->radiance_scale), "shader radiance_scale",
          double{shader->radiance_scale}, "a finite factor above 0");
  shader_ = *shader;
}

const std::shared_ptr<const Environment>& Scene::environment() {
  if (!environment_) environment_ = build_environment(0, 0, nullptr, 1.0f, 0.0f);
  return environment_;
}

bool Scene::is_solid(const std::shared_ptr<const Mesh>& mesh, const Material& material) {
  if (!(material.desc.transmission > 0.0f) || !(material.desc.thickness > 0.0f)) return false;
  const auto [entry, fresh] = closed_.try_emplace(mesh.get(), false);
  if (fresh) entry->second = is_closed(*mesh);
  return entry->second;
}

void Scene::commit() {
  auto snapshot = std::make_shared<Snapshot>();
  snapshot->origin = choose_origin(instances_);
  snapshot->meshes = meshes_;
  snapshot->textures = textures_;
  snapshot->materials = materials_;
  snapshot->winds = winds_;
  snapshot->time_s = time_s_, snapshot->previous_time_s = previous_time_s_;
  snapshot->instances.reserve(instances_.size());
  for (const sideray_instance_desc& d : instances_) {
    const Mesh& mesh = *meshes_[d.mesh - 1];
    snapshot->instances.push_back(local_instance(d, snapshot->origin, mesh, d.wind ? &winds_[d.wind - 1] : nullptr));
    Material& material = snapshot->materials[d.material - 1];
    snapshot->instances.back().solid = is_solid(meshes_[d.mesh - 1], material);
    if (material.desc.alpha_mode == SIDERAY_BLEND && mesh.has_colors)
      material.discards |= mesh.minimum_alpha * lowest_alpha(material.desc, textures_) < 1.0f / 255.0f;
    const Bounds& b = snapshot->instances.back().bounds;
    if (!b.empty()) snapshot->bounds.add(b.minimum), snapshot->bounds.add(b.maximum);
  }
  for (const sideray_light& light : lights_) snapshot->lights.push_back(local_light(light, snapshot->origin));
  for (const Particles& p : particles_) {
    ParticleSystem& system = snapshot->particles.emplace_back(ParticleSystem{p.desc, {}});
    for (const sideray_sprite& sprite : p.sprites)
      system.sprites.push_back(local_sprite(sprite, p.desc, snapshot->origin));
  }
  snapshot->environment = environment();
  snapshot->shader = shader_;
  snapshot->revision = ++revision_;
  const std::lock_guard lock(snapshot_mutex_);
  snapshot_ = std::move(snapshot);
}

std::shared_ptr<const Snapshot> Scene::snapshot() const {
  const std::lock_guard lock(snapshot_mutex_);
  return snapshot_;
}

}  // namespace sideray::model
