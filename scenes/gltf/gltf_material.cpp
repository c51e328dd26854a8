#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "scenes/gltf/gltf.h"
#include "scenes/gltf/gltf_specular_gloss.h"
#include "scenes/gltf/gltf_texture.h"

namespace sideray::scenes::gltf {
namespace {

class MaterialReader {
 public:
  MaterialReader(const File& file, Content& content)
      : file_(file), content_(content), textures_(file, content), specular_gloss_(content, textures_) {}

  Material read(const tinygltf::Material& source, size_t index) {
    Material material;
    material.name = source.name.empty() ? fmt::format("material{}", index) : source.name;
    material.desc = sideray_material_defaults();
    user_ = fmt::format("material {}", material.name);
    const bool converted = read_specular_glossiness(source, material.desc);
    if (!converted) read_metallic_roughness(source.pbrMetallicRoughness, material.desc);
    read_core(source, material.desc);
    read_extensions(source.extensions, material.desc);
    read_extras(source.extras, material);
    return material;
  }

  void warn_of_conversions() {
    if (specular_gloss_.converted() == 0) return;
    content_.warnings.push_back(
        fmt::format("KHR_materials_pbrSpecularGlossiness: {} material{} converted to metallic-roughness",
                    specular_gloss_.converted(), specular_gloss_.converted() == 1 ? " is" : "s are"));
  }

 private:
  [[noreturn]] void refuse_value(const char* key, double value, const char* range) const {
    refuse("cannot read {}: {} of {} is {}, outside {}; correct it", file_.path, key, user_, value, range);
  }

  void warn_of_value(const char* key, double value, const std::string& consequence) const {
    content_.warnings.push_back(fmt::format("{}: {} is {}; {}", user_, key, value, consequence));
  }

  // Returns `value`, clamped to the range if it is outside by no more than the rounding of exporters.
  double within(double value, double minimum, double maximum, const char* key, const char* range) const {
    constexpr double rounding = 0.01;
    if (value >= minimum && value <= maximum) return value;
    if (!(value >= minimum - rounding && value <= maximum + rounding)) refuse_value(key, value, range);
    const double nearest = std::clamp(value, minimum, maximum);
    warn_of_value(key, value, fmt::format("{} is taken, the nearest value in range", nearest));
    return nearest;
  }

  float unit(double value, const char* key) const { return static_cast<float>(within(value, 0.0, 1.0, key, "0 to 1")); }

  float at_least(double value, double minimum, const char* key) const {
    return static_cast<float>(within(value, minimum, 1e6, key, minimum > 0.0 ? "1 to 1e6" : "0 to 1e6"));
  }

  float unit(const tinygltf::Value& e, const char* key, double fallback) const {
    return unit(number(file_, e, key, fallback), key);
  }

  void read_unit_color(const std::vector<double>& values, float* to, size_t count, const char* key) const {
    if (values.empty()) return;
    if (values.size() != count) {
      refuse("cannot read {}: {} of {} has {} numbers instead of {}; correct it", file_.path, key, user_, values.size(),
             count);
    }
    for (size_t c = 0; c < count; ++c) to[c] = unit(values[c], key);
  }

  void read_metallic_roughness(const tinygltf::PbrMetallicRoughness& pbr, sideray_material_desc& desc) {
    read_unit_color(pbr.baseColorFactor, desc.base_color, 4, "baseColorFactor");
    desc.metallic = unit(pbr.metallicFactor, "metallicFactor");
    desc.roughness = unit(pbr.roughnessFactor, "roughnessFactor");
    desc.base_color_texture = slot(use(pbr.baseColorTexture), Colors::srgb);
    desc.metallic_roughness_texture = slot(use(pbr.metallicRoughnessTexture), Colors::linear);
  }

  void read_core(const tinygltf::Material& source, sideray_material_desc& desc) {
    read_emission(source.emissiveFactor, desc);
    desc.normal_texture = slot(use(source.normalTexture), Colors::linear);
    desc.normal_scale = static_cast<float>(source.normalTexture.scale);
    desc.occlusion_texture = slot(use(source.occlusionTexture), Colors::linear);
    desc.occlusion_strength = unit(source.occlusionTexture.strength, "occlusionTexture.strength");
    desc.emissive_texture = slot(use(source.emissiveTexture), Colors::srgb);
    desc.alpha_cutoff = at_least(source.alphaCutoff, 0.0, "alphaCutoff");
    desc.double_sided = source.doubleSided ? 1 : 0;
    if (source.alphaMode == "MASK")
      desc.alpha_mode = SIDERAY_MASK;
    else if (source.alphaMode == "BLEND")
      desc.alpha_mode = SIDERAY_BLEND;
    else if (source.alphaMode == "OPAQUE")
      desc.alpha_mode = SIDERAY_OPAQUE;
    else
      content_.warnings.push_back(
          fmt::format("{}: alphaMode \"{}\" is unknown; OPAQUE is taken", user_, source.alphaMode));
  }

  // Reads emission. Factors above 1 are of exporters from before KHR_materials_emissive_strength.
  void read_emission(const std::vector<double>& factor, sideray_material_desc& desc) const {
    const double strongest = factor.size() == 3 ? *std::max_element(factor.begin(), factor.end()) : 0.0;
    if (!(strongest > 1.0 && strongest <= 1e6)) return read_unit_color(factor, desc.emissive, 3, "emissiveFactor");
    for (size_t c = 0; c < 3; ++c) desc.emissive[c] = at_least(factor[c], 0.0, "emissiveFactor");
    warn_of_value("emissiveFactor", strongest, "more than 1 is taken as its strength");
  }

  void read_extensions(const tinygltf::ExtensionMap& extensions, sideray_material_desc& desc) {
    desc.unlit = extensions.contains("KHR_materials_unlit") ? 1 : 0;
    if (const auto* e = extension(extensions, "KHR_materials_transmission")) {
      desc.transmission = unit(*e, "transmissionFactor", 0.0);
      desc.transmission_texture = slot(*e, "transmissionTexture", Colors::linear);
    }
    if (const auto* e = extension(extensions, "KHR_materials_ior")) {
      const double ior = number(file_, *e, "ior", 1.5);
      // 0 means a Fresnel term of 1 everywhere (KHR_materials_ior); the largest accepted index differs by 4e-6.
      desc.ior = ior == 0.0 ? 1e6f : at_least(ior, 1.0, "ior");
    }
    if (const auto* e = extension(extensions, "KHR_materials_volume")) read_volume(*e, desc);
    if (const auto* e = extension(extensions, "KHR_materials_dispersion"))
      desc.dispersion = at_least(number(file_, *e, "dispersion", 0.0), 0.0, "dispersion");
    if (const auto* e = extension(extensions, "KHR_materials_specular")) read_specular(*e, desc);
    if (const auto* e = extension(extensions, "KHR_materials_clearcoat")) read_clearcoat(*e, desc);
    if (const auto* e = extension(extensions, "KHR_materials_sheen")) read_sheen(*e, desc);
    if (const auto* e = extension(extensions, "KHR_materials_diffuse_transmission"))
      read_diffuse_transmission(*e, desc);
    if (const auto* e = extension(extensions, "KHR_materials_iridescence")) read_iridescence(*e, desc);
    if (const auto* e = extension(extensions, "KHR_materials_anisotropy")) {
      desc.anisotropy = unit(*e, "anisotropyStrength", 0.0);
      const double rotation = number(file_, *e, "anisotropyRotation", 0.0);
      desc.anisotropy_rotation =
          static_cast<float>(within(rotation, -1e15, 1e15, "anisotropyRotation", "-1e15 to 1e15"));
      desc.anisotropy_texture = slot(*e, "anisotropyTexture", Colors::linear);
    }
    if (const auto* e = extension(extensions, "KHR_materials_emissive_strength")) {
      const float strength = at_least(number(file_, *e, "emissiveStrength", 1.0), 0.0, "emissiveStrength");
      for (float& c : desc.emissive) c *= strength;
    }
  }

  void read_volume(const tinygltf::Value& e, sideray_material_desc& desc) {
    desc.thickness = at_least(number(file_, e, "thicknessFactor", 0.0), 0.0, "thicknessFactor");
    desc.thickness_texture = slot(e, "thicknessTexture", Colors::linear);
    double distance = number(file_, e, "attenuationDistance", std::numeric_limits<double>::max());
    if (distance == 0.0) {
      warn_of_value("attenuationDistance", distance, "it is taken for infinite, as viewers do");
      distance = std::numeric_limits<double>::max();
    }
    if (!(distance > 0.0)) refuse_value("attenuationDistance", distance, "the numbers above 0");
    desc.attenuation_distance = static_cast<float>(std::min(distance, 1e30));
    if (distance >= 1e30) desc.attenuation_distance = std::numeric_limits<float>::infinity();
    read_unit_color(numbers(file_, e, "attenuationColor", {1, 1, 1}), desc.attenuation_color, 3, "attenuationColor");
  }

  void read_specular(const tinygltf::Value& e, sideray_material_desc& desc) {
    desc.specular = unit(e, "specularFactor", 1.0);
    desc.specular_texture = slot(e, "specularTexture", Colors::linear);
    const std::vector<double> color = numbers(file_, e, "specularColorFactor", {1, 1, 1});
    for (size_t c = 0; c < 3; ++c) desc.specular_color[c] = at_least(color[c], 0.0, "specularColorFactor");
    desc.specular_color_texture = slot(e, "specularColorTexture", Colors::srgb);
  }

  void read_clearcoat(const tinygltf::Value& e, sideray_material_desc& desc) {
    desc.clearcoat = unit(e, "clearcoatFactor", 0.0);
    desc.clearcoat_texture = slot(e, "clearcoatTexture", Colors::linear);
    desc.clearcoat_roughness = unit(e, "clearcoatRoughnessFactor", 0.0);
    desc.clearcoat_roughness_texture = slot(e, "clearcoatRoughnessTexture", Colors::linear);
    desc.clearcoat_normal_texture = slot(e, "clearcoatNormalTexture", Colors::linear);
    if (desc.clearcoat_normal_texture.texture != 0) {
      desc.clearcoat_normal_scale = static_cast<float>(number(file_, e.Get("clearcoatNormalTexture"), "scale", 1.0));
    }
  }

  void read_sheen(const tinygltf::Value& e, sideray_material_desc& desc) {
    read_unit_color(numbers(file_, e, "sheenColorFactor", {0, 0, 0}), desc.sheen_color, 3, "sheenColorFactor");
    desc.sheen_color_texture = slot(e, "sheenColorTexture", Colors::srgb);
    desc.sheen_roughness = unit(e, "sheenRoughnessFactor", 0.0);
    desc.sheen_roughness_texture = slot(e, "sheenRoughnessTexture", Colors::linear);
  }

  void read_diffuse_transmission(const tinygltf::Value& e, sideray_material_desc& desc) {
    desc.diffuse_transmission = unit(e, "diffuseTransmissionFactor", 0.0);
    desc.diffuse_transmission_texture = slot(e, "diffuseTransmissionTexture", Colors::linear);
    read_unit_color(numbers(file_, e, "diffuseTransmissionColorFactor", {1, 1, 1}), desc.diffuse_transmission_color, 3,
                    "diffuseTransmissionColorFactor");
    desc.diffuse_transmission_color_texture = slot(e, "diffuseTransmissionColorTexture", Colors::srgb);
  }

  void read_iridescence(const tinygltf::Value& e, sideray_material_desc& desc) {
    desc.iridescence = unit(e, "iridescenceFactor", 0.0);
    desc.iridescence_texture = slot(e, "iridescenceTexture", Colors::linear);
    desc.iridescence_ior = at_least(number(file_, e, "iridescenceIor", 1.3), 1.0, "iridescenceIor");
    const auto thickness = [&](const char* key, double otherwise) {
      return at_least(number(file_, e, key, otherwise), 0.0, key);
    };
    desc.iridescence_thickness_min = thickness("iridescenceThicknessMinimum", 100.0);
    desc.iridescence_thickness_max = thickness("iridescenceThicknessMaximum", 400.0);
    desc.iridescence_thickness_texture = slot(e, "iridescenceThicknessTexture", Colors::linear);
  }

  // Reads the archived predecessor of metallic-roughness, which replaces the core's factors where it is present.
  bool read_specular_glossiness(const tinygltf::Material& source, sideray_material_desc& desc) {
    const auto* e = extension(source.extensions, "KHR_materials_pbrSpecularGlossiness");
    if (e == nullptr) return false;
    SpecularGloss gloss;
    const std::vector<double> diffuse = numbers(file_, *e, "diffuseFactor", {1, 1, 1, 1});
    const std::vector<double> specular = numbers(file_, *e, "specularFactor", {1, 1, 1});
    for (size_t c = 0; c < 4; ++c) gloss.diffuse[static_cast<int>(c)] = double{unit(diffuse[c], "diffuseFactor")};
    for (size_t c = 0; c < 3; ++c) gloss.specular[static_cast<int>(c)] = double{unit(specular[c], "specularFactor")};
    gloss.glossiness = double{unit(*e, "glossinessFactor", 1.0)};
    gloss.diffuse_texture = use(*e, "diffuseTexture");
    gloss.specular_gloss_texture = use(*e, "specularGlossinessTexture");
    specular_gloss_.convert(gloss, user_, desc);
    return true;
  }

  void read_extras(const tinygltf::Value& extras, Material& material) {
    if (!extras.IsObject() || !extras.Has("sideray")) return;
    const tinygltf::Value* ours = sideray_extras(extras);
    if (ours == nullptr) refuse("cannot read {}: extras.sideray of {} is not an object; correct it", file_.path, user_);
    for (const std::string& key : ours->Keys()) {
      const tinygltf::Value& value = ours->Get(key);
      if (key == "rayTraced")
        material.ray_traced = truth(value, "rayTraced") ? RayTraced::yes : RayTraced::no;
      else if (key == "inexactShadow")
        material.inexact_shadow = truth(value, "inexactShadow");
      else if (key == "distortion")
        material.desc.distortion = distortion(value);
      else if (key == "blend")
        material.desc.blend_mode = blend_mode(value);
      else
        content_.warnings.push_back(fmt::format("{}: extras.sideray.{} is unknown and left out", user_, key));
    }
  }

  bool truth(const tinygltf::Value& value, const char* key) const {
    if (!value.IsBool()) refuse("cannot read {}: {} of {} is not true or false; correct it", file_.path, key, user_);
    return value.Get<bool>();
  }

  float distortion(const tinygltf::Value& value) const {
    if (!value.IsNumber()) refuse("cannot read {}: distortion of {} is not a number; correct it", file_.path, user_);
    const float strength = at_least(value.GetNumberAsDouble(), 0.0, "distortion");
    if (strength > 100.0f) refuse_value("distortion", value.GetNumberAsDouble(), "0 to 100");
    return strength;
  }

  sideray_blend_mode blend_mode(const tinygltf::Value& value) const {
    static const std::map<std::string, sideray_blend_mode> modes{{"alpha", SIDERAY_BLEND_ALPHA},
                                                                 {"premultiplied", SIDERAY_BLEND_PREMULTIPLIED},
                                                                 {"additive", SIDERAY_BLEND_ADDITIVE},
                                                                 {"multiply", SIDERAY_BLEND_MULTIPLY}};
    const auto found = modes.find(value.IsString() ? value.Get<std::string>() : "");
    if (found == modes.end()) {
      refuse("cannot read {}: blend of {} is unknown; use alpha, premultiplied, additive or multiply", file_.path,
             user_);
    }
    return found->second;
  }

  template <typename Info>
  static TextureUse use(const Info& info) {
    return {info.index, info.texCoord, info.extensions};
  }

  // Reads a textureInfo inside an extension, which tinygltf keeps as a value.
  TextureUse use(const tinygltf::Value& e, const char* key) const {
    if (!e.Has(key)) return {};
    const tinygltf::Value& info = e.Get(key);
    if (!info.IsObject() || !info.Has("index")) {
      refuse("cannot read {}: {} of {} names no texture; export it again", file_.path, key, user_);
    }
    TextureUse use;
    // A negative index is an error, which -1 must not hide as "no texture".
    use.index = static_cast<int>(std::clamp(number(file_, info, "index", -1.0), -1.0, 2e9));
    checked_index(file_, use.index, file_.model.textures.size(), "texture", user_);
    use.uv_set = static_cast<int>(std::clamp(number(file_, info, "texCoord", 0.0), -1.0, 2e9));
    if (info.Has("extensions") && info.Get("extensions").IsObject()) {
      use.extensions = info.Get("extensions").Get<tinygltf::Value::Object>();
    }
    return use;
  }

  sideray_texture_slot slot(const TextureUse& use, Colors colors) { return textures_.slot(use, colors, user_); }
  sideray_texture_slot slot(const tinygltf::Value& e, const char* key, Colors colors) {
    return slot(use(e, key), colors);
  }

  const File& file_;
  Content& content_;
  TextureReader textures_;
  SpecularGlossConverter specular_gloss_;
  std::string user_;
};

// Returns for each material whether anything in the scene uses it.
std::vector<bool> shown_materials(const File& file, std::span<const PlacedNode> nodes) {
  std::vector<bool> shown(file.model.materials.size(), false);
  for (const PlacedNode& placed : nodes) {
    if (placed.is_hidden) continue;
    const auto mesh = static_cast<size_t>(file.model.nodes[placed.node].mesh);
    if (mesh >= file.model.meshes.size()) continue;
    for (const tinygltf::Primitive& primitive : file.model.meshes[mesh].primitives) {
      const auto material = static_cast<size_t>(primitive.material);
      if (material < shown.size()) shown[material] = true;
    }
  }
  return shown;
}

// Reads a material that nothing shows. If it is broken it becomes a warning, and the scene is still read.
Material read_or_leave_out(const File& file, MaterialReader& reader, size_t index, Content& content) {
  const tinygltf::Material& source = file.model.materials[index];
  try {
    return reader.read(source, index);
  } catch (const Error& error) {
    Material material;
    material.name = source.name.empty() ? fmt::format("material{}", index) : source.name;
    material.desc = sideray_material_defaults();
    content.warnings.push_back(
        fmt::format("{}; nothing shown has material {}, which is left out", reason_of(error, file), material.name));
    return material;
  }
}

}  // namespace

std::map<uint32_t, Scattering> read_materials(const File& file, std::span<const PlacedNode> nodes, Content& content) {
  const std::vector<bool> shown = shown_materials(file, nodes);
  MaterialReader reader(file, content);
  std::map<uint32_t, Scattering> scattering;
  for (size_t i = 0; i < file.model.materials.size(); ++i) {
    if (!shown[i]) {
      content.materials.push_back(read_or_leave_out(file, reader, i, content));
      continue;
    }
    const tinygltf::Material& source = file.model.materials[i];
    content.materials.push_back(reader.read(source, i));
    const std::string user = "material " + content.materials.back().name;
    if (const auto found = read_scattering(file, source, user, content))
      scattering.emplace(static_cast<uint32_t>(i), *found);
  }
  reader.warn_of_conversions();
  return scattering;
}

}  // namespace sideray::scenes::gltf
