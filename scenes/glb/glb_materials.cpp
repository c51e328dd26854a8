#include "scenes/glb/glb_materials.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <iterator>
#include <optional>
#include <vector>

#include "elementary/functions.h"
#include "scenes/images/images.h"

namespace sideray::scenes {
namespace {

using Json = GlbDocument::Json;

constexpr int gl_nearest = 9728, gl_linear = 9729, gl_linear_mipmap_linear = 9987;
constexpr int gl_repeat = 10497, gl_clamp_to_edge = 33071, gl_mirrored_repeat = 33648;

bool is_set(const sideray_texture_slot& slot) {
  return slot.texture != 0;
}

bool all(const float (&color)[3], float value) {
  return std::all_of(std::begin(color), std::end(color), [value](float c) { return c == value; });
}

// A material extension of glTF whose members are those of a description. It is written for materials that differ from
// one without it.
struct Extension {
  using Desc = sideray_material_desc;
  struct Factor {
    const char* key;
    float Desc::*value;
    std::optional<float> without = {};  // the value without the extension; none: this factor changes nothing by itself
  };
  struct Color {
    const char* key;
    float (Desc::*value)[3];
    float without;  // of each channel
  };
  struct Texture {
    const char* key;
    sideray_texture_slot Desc::*slot;
    float Desc::*scale = nullptr;  // of a normal texture
  };

  const char* name;
  std::vector<Factor> factors;
  std::vector<Color> colors;
  std::vector<Texture> textures;

  bool is_needed_by(const Desc& desc) const {
    return std::ranges::any_of(factors, [&](const Factor& f) { return f.without && desc.*f.value != *f.without; }) ||
           std::ranges::any_of(colors, [&](const Color& c) { return !all(desc.*c.value, c.without); }) ||
           std::ranges::any_of(textures, [&](const Texture& t) { return is_set(desc.*t.slot); });
  }
};

const std::vector<Extension>& extensions() {
  using D = sideray_material_desc;
  static const std::vector<Extension> all{
      {"KHR_materials_transmission",
       {{"transmissionFactor", &D::transmission, 0.0f}},
       {},
       {{"transmissionTexture", &D::transmission_texture}}},
      {"KHR_materials_ior", {{"ior", &D::ior, 1.5f}}, {}, {}},
      {"KHR_materials_dispersion", {{"dispersion", &D::dispersion, 0.0f}}, {}, {}},
      {"KHR_materials_specular",
       {{"specularFactor", &D::specular, 1.0f}},
       {{"specularColorFactor", &D::specular_color, 1.0f}},
       {{"specularTexture", &D::specular_texture}, {"specularColorTexture", &D::specular_color_texture}}},
      {"KHR_materials_clearcoat",
       {{"clearcoatFactor", &D::clearcoat, 0.0f}, {"clearcoatRoughnessFactor", &D::clearcoat_roughness, 0.0f}},
       {},
       {{"clearcoatTexture", &D::clearcoat_texture},
        {"clearcoatRoughnessTexture", &D::clearcoat_roughness_texture},
        {"clearcoatNormalTexture", &D::clearcoat_normal_texture, &D::clearcoat_normal_scale}}},
      {"KHR_materials_sheen",
       {{"sheenRoughnessFactor", &D::sheen_roughness, 0.0f}},
       {{"sheenColorFactor", &D::sheen_color, 0.0f}},
       {{"sheenColorTexture", &D::sheen_color_texture}, {"sheenRoughnessTexture", &D::sheen_roughness_texture}}},
      {"KHR_materials_diffuse_transmission",
       {{"diffuseTransmissionFactor", &D::diffuse_transmission, 0.0f}},
       {{"diffuseTransmissionColorFactor", &D::diffuse_transmission_color, 1.0f}},
       {{"diffuseTransmissionTexture", &D::diffuse_transmission_texture},
        {"diffuseTransmissionColorTexture", &D::diffuse_transmission_color_texture}}},
      {"KHR_materials_anisotropy",
       {{"anisotropyStrength", &D::anisotropy, 0.0f}, {"anisotropyRotation", &D::anisotropy_rotation}},
       {},
       {{"anisotropyTexture", &D::anisotropy_texture}}},
      {"KHR_materials_iridescence",
       {{"iridescenceFactor", &D::iridescence, 0.0f},
        {"iridescenceIor", &D::iridescence_ior},
        {"iridescenceThicknessMinimum", &D::iridescence_thickness_min},
        {"iridescenceThicknessMaximum", &D::iridescence_thickness_max}},
       {},
       {{"iridescenceTexture", &D::iridescence_texture},
        {"iridescenceThicknessTexture", &D::iridescence_thickness_texture}}}};
  return all;
}

void set_extras(Json& material, const Material& source) {
  static constexpr const char* blends[] = {"alpha", "premultiplied", "additive", "multiply"};
  Json extras = Json::object();
  if (source.ray_traced != RayTraced::by_default) extras["rayTraced"] = source.ray_traced == RayTraced::yes;
  if (source.desc.blend_mode != SIDERAY_BLEND_ALPHA) extras["blend"] = blends[source.desc.blend_mode];
  if (source.inexact_shadow) extras["inexactShadow"] = true;
  if (source.desc.distortion > 0.0f) extras["distortion"] = source.desc.distortion;
  if (!extras.empty()) material["extras"]["sideray"] = std::move(extras);
}

}  // namespace

GlbMaterials::Json GlbMaterials::material(size_t index) {
  const Material& source = content_.materials[index];
  const sideray_material_desc& desc = source.desc;
  Json material{{"name", source.name}};
  Json& pbr = material["pbrMetallicRoughness"];
  pbr = {
      {"baseColorFactor", desc.base_color}, {"metallicFactor", desc.metallic}, {"roughnessFactor", desc.roughness}};
  set_texture(pbr, "baseColorTexture", desc.base_color_texture);
  set_texture(pbr, "metallicRoughnessTexture", desc.metallic_roughness_texture);
  set_texture(material, "normalTexture", desc.normal_texture);
  if (is_set(desc.normal_texture)) material["normalTexture"]["scale"] = desc.normal_scale;
  set_texture(material, "occlusionTexture", desc.occlusion_texture);
  if (is_set(desc.occlusion_texture)) material["occlusionTexture"]["strength"] = desc.occlusion_strength;
  set_texture(material, "emissiveTexture", desc.emissive_texture);
  if (desc.alpha_mode == SIDERAY_MASK) material["alphaMode"] = "MASK", material["alphaCutoff"] = desc.alpha_cutoff;
  if (desc.alpha_mode == SIDERAY_BLEND) material["alphaMode"] = "BLEND";
  if (desc.double_sided != 0) material["doubleSided"] = true;
  set_emission(material, desc);
  set_volume(material, desc, mesh_thickness(index));
  if (desc.unlit != 0) document_.extension(material, "KHR_materials_unlit");
  set_extensions(material, desc);
  set_extras(material, source);
  return material;
}

size_t GlbMaterials::texture(const sideray_texture_slot& slot) {
  const std::pair<size_t, size_t> parts{image(slot.texture - 1), sampler(slot)};
  const auto [found, is_new] = textures_.try_emplace(parts, textures_.size());
  if (is_new) {
    document_.root()["textures"].push_back(
        {{"name", content_.textures[slot.texture - 1].name}, {"source", parts.first}, {"sampler", parts.second}});
  }
  return found->second;
}

size_t GlbMaterials::sampler(const sideray_texture_slot& slot) {
  static constexpr int wraps[] = {gl_repeat, gl_clamp_to_edge, gl_mirrored_repeat};
  static constexpr int minification[] = {gl_linear_mipmap_linear, gl_linear, gl_nearest};
  const auto key = std::make_tuple(slot.wrap_u, slot.wrap_v, slot.filter);
  const auto [found, is_new] = samplers_.try_emplace(key, samplers_.size());
  if (is_new) {
    document_.root()["samplers"].push_back({{"wrapS", wraps[slot.wrap_u]},
                                 {"wrapT", wraps[slot.wrap_v]},
                                 {"magFilter", slot.filter == SIDERAY_NEAREST ? gl_nearest : gl_linear},
                                 {"minFilter", minification[slot.filter]}});
  }
  return found->second;
}

size_t GlbMaterials::image(uint32_t index) {
  const auto [found, is_new] = images_.try_emplace(index, images_.size());
  if (!is_new) return found->second;
  const Texture& texture = content_.textures.at(index);
  const std::vector<uint8_t> png = encode_png(texture.width, texture.height, 4, texture.rgba, texture.name);
  document_.root()["images"].push_back(
      {{"name", texture.name}, {"mimeType", "image/png"}, {"bufferView", document_.add_view(png.data(), png.size())}});
  return found->second;
}

void GlbMaterials::set_texture(Json& parent, const char* key, const sideray_texture_slot& slot) {
  if (!is_set(slot)) return;
  Json info{{"index", texture(slot)}};
  if (slot.uv_set != 0) info["texCoord"] = slot.uv_set;
  set_transform(info, slot.texture_from_uv);
  parent[key] = std::move(info);
}

// Writes the map as scale, rotation and offset; a shear cannot be expressed and is lost.
void GlbMaterials::set_transform(Json& info, const float (&m)[6]) {
  static constexpr float identity[6] = {1, 0, 0, 1, 0, 0};
  if (std::equal(identity, identity + 6, m)) return;
  const double sx = elementary::hypot(double{m[0]}, double{m[1]});
  const double determinant = double{m[0]} * double{m[3]} - double{m[1]} * double{m[2]};
  const double sy = std::copysign(elementary::hypot(double{m[2]}, double{m[3]}), determinant);
  Json& transform = document_.extension(info, "KHR_texture_transform");
  transform = {{"offset", {m[4], m[5]}}, {"scale", {sx, sy}}};
  if (m[1] != 0.0f || m[0] < 0.0f) transform["rotation"] = elementary::atan2(-double{m[1]}, double{m[0]});
}

// Returns the thickness in the mesh's space, as thicknessFactor has it: the reader multiplies by the scale of the
// nodes.
float GlbMaterials::mesh_thickness(size_t index) const {
  const float thickness = content_.materials[index].desc.thickness;
  for (const Object& object : content_.objects) {
    if (object.material != index) continue;
    const double* m = object.world_from_object;
    const glm::dmat3 linear(m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8]);
    const double scale = elementary::cbrt(std::abs(glm::determinant(linear)));
    return std::abs(scale - 1.0) < 1e-5 ? thickness : static_cast<float>(double{thickness} / scale);
  }
  return thickness;
}

void GlbMaterials::set_emission(Json& material, const sideray_material_desc& desc) {
  const float strongest = *std::max_element(desc.emissive, desc.emissive + 3);
  if (strongest <= 0.0f) return;
  const float strength = std::max(strongest, 1.0f);
  material["emissiveFactor"] = {desc.emissive[0] / strength, desc.emissive[1] / strength,
                                desc.emissive[2] / strength};
  if (strength > 1.0f) document_.extension(material, "KHR_materials_emissive_strength")["emissiveStrength"] = strength;
}

void GlbMaterials::set_volume(Json& material, const sideray_material_desc& desc, float thickness) {
  const bool attenuates = std::isfinite(desc.attenuation_distance);
  if (thickness <= 0.0f && !attenuates && !is_set(desc.thickness_texture)) return;
  Json& volume = document_.extension(material, "KHR_materials_volume");
  volume["thicknessFactor"] = thickness;
  if (attenuates) volume["attenuationDistance"] = desc.attenuation_distance;
  volume["attenuationColor"] = desc.attenuation_color;
  set_texture(volume, "thicknessTexture", desc.thickness_texture);
}

void GlbMaterials::set_extensions(Json& material, const sideray_material_desc& desc) {
  for (const Extension& extension : extensions()) {
    if (!extension.is_needed_by(desc)) continue;
    Json& e = document_.extension(material, extension.name);
    for (const Extension::Factor& f : extension.factors) e[f.key] = desc.*f.value;
    for (const Extension::Color& c : extension.colors) e[c.key] = desc.*c.value;
    for (const Extension::Texture& t : extension.textures) {
      set_texture(e, t.key, desc.*t.slot);
      if (t.scale && is_set(desc.*t.slot)) e[t.key]["scale"] = desc.*t.scale;
    }
  }
}

}  // namespace sideray::scenes
