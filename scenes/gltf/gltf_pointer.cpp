#include "scenes/gltf/gltf_pointer.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <string_view>

#include "scenes/base/limits.h"
#include "scenes/gltf/gltf_texture.h"

namespace sideray::scenes::gltf {
namespace {

using Kind = PointerTarget::Kind;

float between(double value, double minimum, double maximum) {
  return static_cast<float>(std::clamp(value, minimum, maximum));
}
float unit(double value) {
  return between(value, 0.0, 1.0);
}
float positive(double value) {
  return between(value, 0.0, 1e6);
}
void set_units(float* to, const glm::dvec4& v, int count) {
  for (int c = 0; c < count; ++c) to[c] = unit(v[c]);
}

// Describes an animated property. Splines may leave its range, and are clamped to it.
template <typename Values>
struct PointedProperty {
  std::string_view path;
  uint32_t numbers;
  void (*set)(Values&, const glm::dvec4&);
};

constexpr PointedProperty<MaterialValues> material_properties[] = {
    {"pbrMetallicRoughness/baseColorFactor", 4,
     [](MaterialValues& m, const glm::dvec4& v) { set_units(m.desc.base_color, v, 4); }},
    {"pbrMetallicRoughness/metallicFactor", 1,
     [](MaterialValues& m, const glm::dvec4& v) { m.desc.metallic = unit(v.x); }},
    {"pbrMetallicRoughness/roughnessFactor", 1,
     [](MaterialValues& m, const glm::dvec4& v) { m.desc.roughness = unit(v.x); }},
    {"alphaCutoff", 1, [](MaterialValues& m, const glm::dvec4& v) { m.desc.alpha_cutoff = positive(v.x); }},
    {"emissiveFactor", 3,
     [](MaterialValues& m, const glm::dvec4& v) {
       for (int c = 0; c < 3; ++c) m.emissive_factor[c] = positive(v[c]);
     }},
    {"normalTexture/scale", 1,
     [](MaterialValues& m, const glm::dvec4& v) { m.desc.normal_scale = between(v.x, -1e6, 1e6); }},
    {"occlusionTexture/strength", 1,
     [](MaterialValues& m, const glm::dvec4& v) { m.desc.occlusion_strength = unit(v.x); }},
    {"extensions/KHR_materials_emissive_strength/emissiveStrength", 1,
     [](MaterialValues& m, const glm::dvec4& v) { m.emissive_strength = positive(v.x); }},
    {"extensions/KHR_materials_anisotropy/anisotropyStrength", 1,
     [](MaterialValues& m, const glm::dvec4& v) { m.desc.anisotropy = unit(v.x); }},
    {"extensions/KHR_materials_anisotropy/anisotropyRotation", 1,
     [](MaterialValues& m, const glm::dvec4& v) { m.desc.anisotropy_rotation = between(v.x, -1e15, 1e15); }},
    {"extensions/KHR_materials_clearcoat/clearcoatFactor", 1,
     [](MaterialValues& m, const glm::dvec4& v) { m.desc.clearcoat = unit(v.x); }},
    {"extensions/KHR_materials_clearcoat/clearcoatRoughnessFactor", 1,
     [](MaterialValues& m, const glm::dvec4& v) { m.desc.clearcoat_roughness = unit(v.x); }},
    {"extensions/KHR_materials_clearcoat/clearcoatNormalTexture/scale", 1,
     [](MaterialValues& m, const glm::dvec4& v) { m.desc.clearcoat_normal_scale = between(v.x, -1e6, 1e6); }},
    {"extensions/KHR_materials_diffuse_transmission/diffuseTransmissionFactor", 1,
     [](MaterialValues& m, const glm::dvec4& v) { m.desc.diffuse_transmission = unit(v.x); }},
    {"extensions/KHR_materials_diffuse_transmission/diffuseTransmissionColorFactor", 3,
     [](MaterialValues& m, const glm::dvec4& v) { set_units(m.desc.diffuse_transmission_color, v, 3); }},
    {"extensions/KHR_materials_dispersion/dispersion", 1,
     [](MaterialValues& m, const glm::dvec4& v) { m.desc.dispersion = positive(v.x); }},
    // 0 means a Fresnel term of 1 everywhere.
    {"extensions/KHR_materials_ior/ior", 1,
     [](MaterialValues& m, const glm::dvec4& v) { m.desc.ior = v.x == 0.0 ? 1e6f : between(v.x, 1.0, 1e6); }},
    {"extensions/KHR_materials_iridescence/iridescenceFactor", 1,
     [](MaterialValues& m, const glm::dvec4& v) { m.desc.iridescence = unit(v.x); }},
    {"extensions/KHR_materials_iridescence/iridescenceIor", 1,
     [](MaterialValues& m, const glm::dvec4& v) { m.desc.iridescence_ior = between(v.x, 1.0, 1e6); }},
    {"extensions/KHR_materials_iridescence/iridescenceThicknessMinimum", 1,
     [](MaterialValues& m, const glm::dvec4& v) { m.desc.iridescence_thickness_min = positive(v.x); }},
    {"extensions/KHR_materials_iridescence/iridescenceThicknessMaximum", 1,
     [](MaterialValues& m, const glm::dvec4& v) { m.desc.iridescence_thickness_max = positive(v.x); }},
    {"extensions/KHR_materials_sheen/sheenColorFactor", 3,
     [](MaterialValues& m, const glm::dvec4& v) { set_units(m.desc.sheen_color, v, 3); }},
    {"extensions/KHR_materials_sheen/sheenRoughnessFactor", 1,
     [](MaterialValues& m, const glm::dvec4& v) { m.desc.sheen_roughness = unit(v.x); }},
    {"extensions/KHR_materials_specular/specularFactor", 1,
     [](MaterialValues& m, const glm::dvec4& v) { m.desc.specular = unit(v.x); }},
    {"extensions/KHR_materials_specular/specularColorFactor", 3,
     [](MaterialValues& m, const glm::dvec4& v) {
       for (int c = 0; c < 3; ++c) m.desc.specular_color[c] = positive(v[c]);
     }},
    {"extensions/KHR_materials_transmission/transmissionFactor", 1,
     [](MaterialValues& m, const glm::dvec4& v) { m.desc.transmission = unit(v.x); }},
    {"extensions/KHR_materials_volume/thicknessFactor", 1,
     [](MaterialValues& m, const glm::dvec4& v) { m.desc.thickness = positive(v.x); }},
    {"extensions/KHR_materials_volume/attenuationDistance", 1,
     [](MaterialValues& m, const glm::dvec4& v) {
       const bool is_infinite = !(v.x > 0.0 && v.x < 1e30);
       m.desc.attenuation_distance = is_infinite ? std::numeric_limits<float>::infinity() : static_cast<float>(v.x);
     }},
    {"extensions/KHR_materials_volume/attenuationColor", 3,
     [](MaterialValues& m, const glm::dvec4& v) { set_units(m.desc.attenuation_color, v, 3); }},
};

constexpr PointedProperty<LightValues> light_properties[] = {
    {"color", 3,
     [](LightValues& l, const glm::dvec4& v) { l.color = glm::clamp(glm::dvec3(v), 0.0, 1e6); }},
    {"intensity", 1, [](LightValues& l, const glm::dvec4& v) { l.intensity = std::clamp(v.x, 0.0, 1e9); }},
    {"range", 1, [](LightValues& l, const glm::dvec4& v) { l.range = std::clamp(v.x, 0.0, 1e15); }},
    {"spot/innerConeAngle", 1,
     [](LightValues& l, const glm::dvec4& v) { l.inner_cone = std::clamp(v.x, 0.0, 1.5709); }},
    {"spot/outerConeAngle", 1,
     [](LightValues& l, const glm::dvec4& v) { l.outer_cone = std::clamp(v.x, 1e-4, 1.5709); }},
};

constexpr PointedProperty<sideray_camera> camera_properties[] = {
    {"perspective/yfov", 1, [](sideray_camera& c, const glm::dvec4& v) { c.yfov = between(v.x, 1e-4, 3.13); }},
    {"perspective/znear", 1, [](sideray_camera& c, const glm::dvec4& v) { c.z_near = between(v.x, 1e-6, 1e15); }},
    {"perspective/zfar", 1, [](sideray_camera& c, const glm::dvec4& v) { c.z_far = between(v.x, 0.0, 1e15); }},
    {"orthographic/ymag", 1,
     [](sideray_camera& c, const glm::dvec4& v) { c.half_height = between(std::abs(v.x), 1e-6, 1e15); }},
    {"orthographic/znear", 1, [](sideray_camera& c, const glm::dvec4& v) { c.z_near = between(v.x, 1e-6, 1e15); }},
    {"orthographic/zfar", 1, [](sideray_camera& c, const glm::dvec4& v) { c.z_far = between(v.x, 1e-6, 1e15); }},
};

template <typename Values, size_t count>
const PointedProperty<Values>* find(const PointedProperty<Values> (&properties)[count], const std::string& path) {
  const auto found = std::find_if(std::begin(properties), std::end(properties),
                                  [&](const PointedProperty<Values>& p) { return p.path == path; });
  return found == std::end(properties) ? nullptr : found;
}

// Locates a texture of material_slots in the file; the list is in their order. Paths of extensions have two parts.
struct TexturePath {
  const char* parent;  // an extension, "pbrMetallicRoughness" or ""
  const char* key;
};
constexpr std::array<TexturePath, material_slots.size()> texture_paths{{
    {"pbrMetallicRoughness", "baseColorTexture"},
    {"pbrMetallicRoughness", "metallicRoughnessTexture"},
    {"", "normalTexture"},
    {"", "occlusionTexture"},
    {"", "emissiveTexture"},
    {"KHR_materials_transmission", "transmissionTexture"},
    {"KHR_materials_volume", "thicknessTexture"},
    {"KHR_materials_specular", "specularTexture"},
    {"KHR_materials_specular", "specularColorTexture"},
    {"KHR_materials_clearcoat", "clearcoatTexture"},
    {"KHR_materials_clearcoat", "clearcoatRoughnessTexture"},
    {"KHR_materials_clearcoat", "clearcoatNormalTexture"},
    {"KHR_materials_sheen", "sheenColorTexture"},
    {"KHR_materials_sheen", "sheenRoughnessTexture"},
    {"KHR_materials_diffuse_transmission", "diffuseTransmissionTexture"},
    {"KHR_materials_diffuse_transmission", "diffuseTransmissionColorTexture"},
    {"KHR_materials_iridescence", "iridescenceTexture"},
    {"KHR_materials_iridescence", "iridescenceThicknessTexture"},
    {"KHR_materials_anisotropy", "anisotropyTexture"},
}};

std::string path_of(const TexturePath& texture) {
  const std::string parent = texture.parent;
  if (parent.empty()) return texture.key;
  return (parent.starts_with("KHR_") ? "extensions/" + parent : parent) + "/" + texture.key;
}

// Names a property of the KHR_texture_transform of a slot.
struct TransformProperty {
  size_t slot;
  std::string name;  // offset, rotation or scale
};

std::optional<TransformProperty> transform_property(const std::string& path) {
  static const std::string between = "/extensions/KHR_texture_transform/";
  const size_t at = path.find(between);
  if (at == std::string::npos) return std::nullopt;
  const std::string texture = path.substr(0, at), name = path.substr(at + between.size());
  if (name != "offset" && name != "rotation" && name != "scale") return std::nullopt;
  for (size_t slot = 0; slot < texture_paths.size(); ++slot)
    if (path_of(texture_paths[slot]) == texture) return TransformProperty{slot, name};
  return std::nullopt;
}

uint32_t numbers_of_material(const std::string& path) {
  if (const auto* property = find(material_properties, path)) return property->numbers;
  const std::optional<TransformProperty> transform = transform_property(path);
  return !transform ? 0 : transform->name == "rotation" ? 1 : 2;
}

// Returns the KHR_texture_transform of a slot's textureInfo at rest.
TextureTransform transform_at_rest(const File& file, const tinygltf::Material& source, const TexturePath& path) {
  const auto of = [&](const auto& info) {
    const tinygltf::Value* e = extension(info.extensions, "KHR_texture_transform");
    return e == nullptr ? TextureTransform{} : read_transform(file, *e);
  };
  const std::string_view key = path.key;
  if (key == "baseColorTexture") return of(source.pbrMetallicRoughness.baseColorTexture);
  if (key == "metallicRoughnessTexture") return of(source.pbrMetallicRoughness.metallicRoughnessTexture);
  if (key == "normalTexture") return of(source.normalTexture);
  if (key == "occlusionTexture") return of(source.occlusionTexture);
  if (key == "emissiveTexture") return of(source.emissiveTexture);
  const tinygltf::Value* e = extension(source.extensions, path.parent);
  if (e == nullptr || !e->Has(path.key)) return {};
  const tinygltf::Value& info = e->Get(path.key);
  if (!info.Has("extensions") || !info.Get("extensions").Has("KHR_texture_transform")) return {};
  return read_transform(file, info.Get("extensions").Get("KHR_texture_transform"));
}

MaterialValues values_at_rest(const File& file, const tinygltf::Material& source, const sideray_material_desc& desc) {
  MaterialValues rest;
  rest.desc = desc;
  for (int c = 0; c < 3; ++c) {
    const auto i = static_cast<size_t>(c);
    rest.emissive_factor[c] = i < source.emissiveFactor.size() ? positive(source.emissiveFactor[i]) : 0.0f;
  }
  if (const tinygltf::Value* e = extension(source.extensions, "KHR_materials_emissive_strength"))
    rest.emissive_strength = positive(number(file, *e, "emissiveStrength", 1.0));
  return rest;
}

void add_transform(const File& file, const tinygltf::Material& source, const AnimatedValue& value,
                   AnimatedMaterial& animated) {
  const TransformProperty property = *transform_property(value.target->property);
  const size_t slot = property.slot;
  if (!animated.rest.changes_transform[slot]) {
    animated.rest.changes_transform[slot] = true;
    animated.rest.transforms[slot] = transform_at_rest(file, source, texture_paths[slot]);
  }
  const std::string name = property.name;
  const auto set = [slot, name](MaterialValues& values, const glm::dvec4& v) {
    const glm::dvec4 usable = glm::clamp(v, glm::dvec4(-1e7), glm::dvec4(1e7));
    TextureTransform& transform = values.transforms[slot];
    if (name == "rotation")
      transform.rotation = usable.x;
    else
      (name == "offset" ? transform.offset : transform.scale) = glm::dvec2(usable);
  };
  animated.changes.push_back({value.channel, set});
}

AnimatedMaterial& animated_material(const File& file, const AnimatedValue& value, const ReadThings& read, Rig& rig,
                                    const Content& content) {
  const auto index = static_cast<uint32_t>(value.target->index);
  for (AnimatedMaterial& animated : rig.materials)
    if (animated.shown.front().material == index) return animated;
  AnimatedMaterial& added = rig.materials.emplace_back();
  added.rest = values_at_rest(file, file.model.materials[index], content.materials[index].desc);
  added.shown.push_back({index, 1.0f});
  for (const ScaledMaterial& scaled : read.materials) {
    if (scaled.source != index) continue;
    if (scaled.material == index)
      added.shown.front().thickness_scale = scaled.scale;
    else
      added.shown.push_back({scaled.material, scaled.scale});
  }
  // The content's thickness is already scaled, so the file's is read again.
  if (const tinygltf::Value* e = extension(file.model.materials[index].extensions, "KHR_materials_volume"))
    added.rest.desc.thickness = positive(number(file, *e, "thicknessFactor", 0.0));
  return added;
}

void animate_material(const File& file, const AnimatedValue& value, const ReadThings& read, Rig& rig,
                      const Content& content) {
  AnimatedMaterial& animated = animated_material(file, value, read, rig, content);
  if (const auto* property = find(material_properties, value.target->property))
    animated.changes.push_back({value.channel, property->set});
  else
    add_transform(file, file.model.materials[value.target->index], value, animated);
}

AnimatedLight& animated_light(const File& file, const ReadThing& thing, Rig& rig) {
  for (AnimatedLight& animated : rig.light_values)
    if (animated.light == thing.of_content) return animated;
  AnimatedLight& added = rig.light_values.emplace_back();
  added.light = thing.of_content;
  added.node = thing.node;
  const tinygltf::Light& source = file.model.lights[thing.of_file];
  for (int c = 0; c < 3; ++c)
    if (source.color.size() == 3) added.rest.color[c] = std::clamp(source.color[static_cast<size_t>(c)], 0.0, 1e6);
  added.rest.intensity = std::clamp(source.intensity, 0.0, 1e9);
  added.rest.range = std::clamp(source.range, 0.0, 1e15);
  added.rest.inner_cone = std::clamp(source.spot.innerConeAngle, 0.0, 1.5709);
  added.rest.outer_cone = std::clamp(source.spot.outerConeAngle, 0.0, 1.5709);
  return added;
}

AnimatedCamera& animated_camera(const ReadThing& thing, Rig& rig, const Content& content) {
  for (AnimatedCamera& animated : rig.camera_values)
    if (animated.camera == thing.of_content) return animated;
  AnimatedCamera& added = rig.camera_values.emplace_back();
  added.camera = thing.of_content;
  added.rest = content.cameras[thing.of_content].camera;
  return added;
}

}  // namespace

PointerTarget pointer_target(const File& file, const std::string& pointer, const std::string& user) {
  struct List {
    const char* prefix;
    Kind kind;
    const char* name;
    size_t count;
  };
  const tinygltf::Model& model = file.model;
  const List lists[] = {{"/nodes/", Kind::node, "node", model.nodes.size()},
                        {"/meshes/", Kind::mesh, "mesh", model.meshes.size()},
                        {"/materials/", Kind::material, "material", model.materials.size()},
                        {"/extensions/KHR_lights_punctual/lights/", Kind::light, "light", model.lights.size()},
                        {"/cameras/", Kind::camera, "camera", model.cameras.size()}};
  if (!pointer.starts_with("/"))
    refuse("cannot read {}: {} has the pointer \"{}\", which does not begin with /; export it again", file.path, user,
           pointer);
  for (const List& list : lists) {
    if (!pointer.starts_with(list.prefix)) continue;
    const char* digits = pointer.data() + std::string_view(list.prefix).size();
    const char* end = pointer.data() + pointer.size();
    int index = -1;
    const auto [stop, error] = std::from_chars(digits, end, index);
    if (error != std::errc() || stop == end || *stop != '/')
      refuse("cannot read {}: {} has the pointer \"{}\", which names no {} by its number; export it again", file.path,
             user, pointer, list.name);
    return {list.kind, checked_index(file, index, list.count, list.name, fmt::format("{}, pointer {},", user, pointer)),
            std::string(stop + 1, end)};
  }
  return {};
}

uint32_t numbers_of(const PointerTarget& target) {
  const auto numbers = [](const auto* property) { return property == nullptr ? 0 : property->numbers; };
  if (target.kind == Kind::material) return numbers_of_material(target.property);
  if (target.kind == Kind::light) return numbers(find(light_properties, target.property));
  if (target.kind == Kind::camera) return numbers(find(camera_properties, target.property));
  return 0;
}

std::set<uint32_t> varying_thickness(std::span<const AnimatedValue> values) {
  std::set<uint32_t> materials;
  for (const AnimatedValue& value : values)
    if (value.target->kind == Kind::material &&
        value.target->property == "extensions/KHR_materials_volume/thicknessFactor")
      materials.insert(static_cast<uint32_t>(value.target->index));
  return materials;
}

void animate_values(const File& file, std::span<const AnimatedValue> values, const ReadThings& read, Rig& rig,
                    Content& content) {
  for (const AnimatedValue& value : values) {
    const size_t index = value.target->index;
    const std::string& property = value.target->property;
    const Kind kind = value.target->kind;
    if (kind == Kind::material) animate_material(file, value, read, rig, content);
    for (const ReadThing& thing : read.lights)
      if (kind == Kind::light && thing.of_file == index)
        animated_light(file, thing, rig).changes.push_back({value.channel, find(light_properties, property)->set});
    for (const ReadThing& thing : read.cameras)
      if (kind == Kind::camera && thing.of_file == index)
        animated_camera(thing, rig, content)
            .changes.push_back({value.channel, find(camera_properties, property)->set});
  }
  // Lights of nodes that are hidden at times need channels too: hidden lights are off.
  for (const ReadThing& thing : read.lights)
    if (rig.nodes[thing.node].blinks) animated_light(file, thing, rig);
}

}  // namespace sideray::scenes::gltf
