#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <glm/glm.hpp>

#include "elementary/functions.h"
#include "scenes/base/files.h"
#include "scenes/base/material_slots.h"
#include "scenes/content/animation.h"
#include "scenes/content/content.h"
#include "scenes/gltf/gltf.h"

namespace sideray::scenes {
namespace {

sideray_attribute attribute(const std::vector<float>& values) {
  return {values.empty() ? nullptr : values.data(), 0};
}

// The result is valid as long as the mesh exists.
sideray_mesh_desc desc_of(const Mesh& mesh) {
  sideray_mesh_desc desc = sideray_mesh_defaults();
  desc.vertex_count = static_cast<uint32_t>(mesh.positions.size() / 3);
  desc.index_count = static_cast<uint32_t>(mesh.indices.size());
  desc.indices = mesh.indices.data();
  desc.positions = attribute(mesh.positions);
  desc.normals = attribute(mesh.normals);
  desc.tangents = attribute(mesh.tangents);
  desc.uv0 = attribute(mesh.uv0);
  desc.uv1 = attribute(mesh.uv1);
  desc.colors = attribute(mesh.colors);
  desc.topology = mesh.topology;
  return desc;
}

sideray_material_desc desc_of(const Material& material) {
  sideray_material_desc desc = material.desc;
  desc.inexact_shadow = material.inexact_shadow;
  return desc;
}

// Texture numbers are those that fill() gave when it added them to an empty scene.
void change_materials(Scene& scene, const Content& content) {
  for (const AnimatedMaterial& animated : content.rig->materials)
    for (const AnimatedMaterial::Shown& shown : animated.shown)
      scene.replace_material(shown.material + 1, desc_of(content.materials[shown.material]));
}

void bend_meshes(Scene& scene, const Content& content) {
  if (!content.rig) return;
  for (const SkinnedMesh& skinned : content.rig->skinned)
    scene.set_vertices(skinned.mesh + 1, desc_of(content.meshes[skinned.mesh]));
  for (const MorphedMesh& morphed : content.rig->morphed)
    if (!morphed.is_skinned) scene.set_vertices(morphed.mesh + 1, desc_of(content.meshes[morphed.mesh]));
}

// Adds skinned meshes without their skin and morphed ones in a generic shape, because triangles that a pose makes
// degenerate would be dropped permanently; the pose is set afterwards.
std::vector<sideray_mesh> add_meshes(Scene& scene, const Content& content) {
  std::vector<sideray_mesh_desc> descs;
  for (const Mesh& mesh : content.meshes) descs.push_back(desc_of(mesh));
  if (content.rig)
    for (const SkinnedMesh& skinned : content.rig->skinned)
      descs[skinned.mesh].positions = attribute(skinned.positions);
  std::vector<std::vector<float>> unfolded;
  for (size_t i = 0; content.rig && i < content.rig->morphed.size(); ++i) {
    const MorphedMesh& morphed = content.rig->morphed[i];
    unfolded.push_back(generic_positions(morphed));
    descs[morphed.mesh].positions = attribute(unfolded.back());
  }
  std::vector<sideray_mesh> meshes;
  for (const sideray_mesh_desc& desc : descs) meshes.push_back(scene.add_mesh(desc));
  bend_meshes(scene, content);
  return meshes;
}

void set_lights(Scene& scene, const Content& content) {
  std::vector<sideray_light> lights;
  for (const Light& light : content.lights) lights.push_back(light.light);
  scene.set_lights(lights);
}

uint32_t visibility(bool traced) {
  const uint32_t all = SIDERAY_VISIBLE_ALL;
  return traced ? all : all & ~uint32_t{SIDERAY_VISIBLE_LAYERS};
}

}  // namespace

bool may_be_file(const std::string& scene) {
  const std::string extension = extension_of(scene);
  std::error_code error;
  return extension == ".gltf" || extension == ".glb" || std::filesystem::is_directory(scene, error);
}

Content load_file(const std::string& path, const LoadOptions& options) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) {
    refuse("cannot read {}: it is a folder; give the .gltf or .glb file in it", path);
  }
  if (!may_be_file(path)) {
    throw UnknownScene(SIDERAY_INVALID_ARGUMENT,
                       fmt::format("no scene {0}: it is not a .gltf or .glb file; built-in scenes come with the program, "
                                   "whose `sideray make {0} -o {0}.glb` writes one of that name as a file",
                                   printable(path)));
  }
  try {
    return gltf::load(path, options);
  } catch (const std::bad_alloc&) {
    refuse("cannot read {}: it does not fit into this machine's memory; use a smaller scene", path);
  }
}

void check_animation(const Content& content, const std::string& name) {
  if (name.empty() || name == "all") return;
  std::vector<std::string> names;
  for (const Animation& animation : content.animations) {
    if (animation.name == name) return;
    names.push_back(animation.name);
  }
  if (names.empty()) {
    throw UnknownAnimation(SIDERAY_INVALID_ARGUMENT,
                           fmt::format("no animation {}: the scene has none; name none", name));
  }
  throw UnknownAnimation(
      SIDERAY_INVALID_ARGUMENT,
      fmt::format("no animation {}: the scene has others; choose all or one of {}", name, fmt::join(names, ", ")));
}

void check_variant(const Content& content, const std::string& name) {
  const std::vector<std::string>& names = content.variants;
  if (name.empty() || std::find(names.begin(), names.end(), name) != names.end()) return;
  if (names.empty())
    throw UnknownVariant(SIDERAY_INVALID_ARGUMENT, fmt::format("no variant {}: the scene has none; name none", name));
  throw UnknownVariant(SIDERAY_INVALID_ARGUMENT,
                       printable(fmt::format("no variant {}: the scene has others; choose one of {}", name,
                                             fmt::join(names, ", "))));
}

void fill(Scene& scene, const Content& content, const std::vector<bool>& traced) {
  std::vector<sideray_texture> textures;
  for (const Texture& texture : content.textures) {
    textures.push_back(scene.add_texture(texture.width, texture.height,
                                         texture.srgb ? SIDERAY_RGBA8_SRGB : SIDERAY_RGBA8, texture.rgba.data()));
  }
  std::vector<sideray_material> materials;
  for (const Material& material : content.materials) {
    sideray_material_desc desc = desc_of(material);
    for (const MaterialSlot& s : material_slots) {
      uint32_t& texture = (desc.*s.slot).texture;
      if (texture != 0) texture = textures.at(texture - 1);
    }
    materials.push_back(scene.add_material(desc));
  }
  const std::vector<sideray_mesh> meshes = add_meshes(scene, content);
  std::vector<sideray_wind> winds;
  for (const sideray_wind_desc& wind : content.winds) winds.push_back(scene.add_wind(wind));
  std::vector<sideray_instance_desc> instances;
  instances.reserve(content.objects.size());
  for (size_t i = 0; i < content.objects.size(); ++i) {
    const Object& object = content.objects[i];
    sideray_instance_desc desc{};
    desc.mesh = meshes.at(object.mesh);
    desc.material = materials.at(object.material);
    std::copy_n(object.world_from_object, 12, desc.world_from_object);
    desc.surface_id = static_cast<uint32_t>(i + 1);
    desc.visibility = visibility(traced.at(i));
    desc.user = i;
    if (object.wind != 0) desc.wind = winds.at(object.wind - 1);
    desc.wind_phase = object.wind_phase;
    instances.push_back(desc);
  }
  if (!instances.empty()) scene.add_instances(instances);
  set_lights(scene, content);
  for (const Emitter& emitter : content.emitters) {
    sideray_particles_desc desc = emitter.particles.desc;
    desc.texture = emitter.texture ? textures.at(emitter.texture - 1) : 0;
    scene.add_particles(desc);
  }
  set_sprites(scene, content);
  scene.commit();
}

bool moves(const Content& content) {
  return content.rig || !content.emitters.empty() || !content.winds.empty();
}

void move(Scene& scene, const Content& content) {
  const Rig* rig = content.rig.get();
  const bool rig_moves = rig && !(rig->objects.empty() && rig->lights.empty() && rig->light_values.empty() &&
                                  rig->materials.empty() && rig->skinned.empty() && rig->morphed.empty());
  if (!rig_moves && content.emitters.empty() && content.winds.empty()) return;
  if (rig_moves) {
    for (const Attached& a : rig->objects)
      scene.move_instance(static_cast<sideray_instance>(a.index + 1), content.objects[a.index].world_from_object);
    change_materials(scene, content);
    bend_meshes(scene, content);
    set_lights(scene, content);
  }
  set_sprites(scene, content);
  scene.commit();
}

void set_traced(Scene& scene, const Content& content, const std::vector<bool>& traced) {
  for (size_t i = 0; i < content.objects.size(); ++i)
    scene.set_visibility(static_cast<sideray_instance>(i + 1), visibility(traced.at(i)));
  scene.commit();
}

Sky sky() {
  Sky sky{512, 256, {}};
  sky.rgb.reserve(size_t{3} * sky.width * sky.height);
  const glm::dvec3 zenith(0.25, 0.45, 0.9), horizon(0.81, 0.855, 0.9), ground(0.25, 0.22, 0.2);
  for (uint32_t y = 0; y < sky.height; ++y) {
    const double elevation = (0.5 - (y + 0.5) / sky.height) * 3.14159265358979;
    const double up = elementary::sin(elevation);
    // A haze band of about 3 degrees softens the horizon, so that its reflections do not flicker.
    const double above = glm::smoothstep(-0.05, 0.0, up);
    const glm::dvec3 air = glm::mix(horizon, zenith, std::sqrt(std::max(up, 0.0)));
    const glm::dvec3 color = glm::mix(ground, air, above);
    for (uint32_t x = 0; x < sky.width; ++x) {
      for (int c = 0; c < 3; ++c) sky.rgb.push_back(static_cast<float>(color[c]));
    }
  }
  return sky;
}

}  // namespace sideray::scenes
