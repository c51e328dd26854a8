#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "scenes/gltf.h"
#include "scenes/images.h"
#include "scenes/limits.h"

namespace sideray::scenes::gltf {
namespace {

constexpr int gl_nearest = 9728, gl_linear = 9729, gl_clamp_to_edge = 33071, gl_mirrored_repeat = 33648;

struct TextureUse {
  int index = -1;
  int uv_set = 0;
  const tinygltf::ExtensionMap* extensions = nullptr;
};

class MaterialReader {
 public:
  MaterialReader(const File& file, Content& content) : file_(file), content_(content) {}

  Material read(const tinygltf::Material& source, size_t index) {
    Material material;
    material.name = source.name.empty() ? fmt::format("material{}", index) : source.name;
    material.desc = sideray_material_defaults();
    user_ = fmt::format("material {}", material.name);
    read_core(source, material.desc);
    read_extensions(source, material.desc);
    read_extras(source, material);
    return material;
  }

 private:
  [[noreturn]] void refuse_value(const char* key, double value, const char* range) const {
    refuse("cannot read {}: {} of {} is {}, outside {}; correct it", file_.path, key, user_, value, range);
  }

  float unit(double value, const char* key) const {
    if (!(value >= 0.0 && value <= 1.0)) refuse_value(key, value, "0 to 1");
    return static_cast<float>(value);
  }

  float at_least(double value, double minimum, const char* key) const {
    if (!(value >= minimum && value <= 1e6)) refuse_value(key, value, minimum > 0.0 ? "1 to 1e6" : "0 to 1e6");
    return static_cast<float>(value);
  }

  void read_unit_color(const std::vector<double>& values, float* to, size_t count, const char* key) const {
    if (values.empty()) return;
    if (values.size() != count) {
      refuse("cannot read {}: {} of {} has {} numbers instead of {}; correct it", file_.path, key, user_, values.size(),
             count);
    }
    for (size_t c = 0; c < count; ++c) to[c] = unit(values[c], key);
  }

  void read_core(const tinygltf::Material& source, sideray_material_desc& desc) {
    const tinygltf::PbrMetallicRoughness& pbr = source.pbrMetallicRoughness;
    read_unit_color(pbr.baseColorFactor, desc.base_color, 4, "baseColorFactor");
    read_unit_color(source.emissiveFactor, desc.emissive, 3, "emissiveFactor");
    desc.metallic = unit(pbr.metallicFactor, "metallicFactor");
    desc.roughness = unit(pbr.roughnessFactor, "roughnessFactor");
    desc.base_color_texture = slot(use(pbr.baseColorTexture), true);
    desc.metallic_roughness_texture = slot(use(pbr.metallicRoughnessTexture), false);
    desc.normal_texture = slot(use(source.normalTexture), false);
    desc.normal_scale = static_cast<float>(source.normalTexture.scale);
    desc.occlusion_texture = slot(use(source.occlusionTexture), false);
    desc.occlusion_strength = unit(source.occlusionTexture.strength, "occlusionTexture.strength");
    desc.emissive_texture = slot(use(source.emissiveTexture), true);
    desc.alpha_cutoff = at_least(source.alphaCutoff, 0.0, "alphaCutoff");
    desc.double_sided = source.doubleSided ? 1 : 0;
    if (source.alphaMode == "MASK")
      desc.alpha_mode = SIDERAY_MASK;
    else if (source.alphaMode == "BLEND")
      desc.alpha_mode = SIDERAY_BLEND;
    else if (source.alphaMode == "OPAQUE")
      desc.alpha_mode = SIDERAY_OPAQUE;
    else
      refuse("cannot read {}: alphaMode \"{}\" of {} is unknown; correct it", file_.path, source.alphaMode, user_);
  }

  void read_extensions(const tinygltf::Material& source, sideray_material_desc& desc) {
    const tinygltf::ExtensionMap& extensions = source.extensions;
    desc.unlit = extensions.contains("KHR_materials_unlit") ? 1 : 0;
    if (const auto* e = extension(extensions, "KHR_materials_transmission")) {
      desc.transmission = unit(number(file_, *e, "transmissionFactor", 0.0), "transmissionFactor");
      desc.transmission_texture = slot(use(*e, "transmissionTexture"), false);
    }
    if (const auto* e = extension(extensions, "KHR_materials_ior")) {
      const double ior = number(file_, *e, "ior", 1.5);
      // 0 asks for Fresnel 1 everywhere (KHR_materials_ior); the largest accepted index comes near.
      desc.ior = ior == 0.0 ? 99.0f : at_least(ior, 1.0, "ior");
      if (!(desc.ior < 100.0f)) refuse_value("ior", ior, "1 to 100");
    }
    if (const auto* e = extension(extensions, "KHR_materials_volume")) read_volume(*e, desc);
    if (const auto* e = extension(extensions, "KHR_materials_specular")) {
      desc.specular = unit(number(file_, *e, "specularFactor", 1.0), "specularFactor");
      const std::vector<double> color = numbers(file_, *e, "specularColorFactor", {1, 1, 1});
      for (size_t c = 0; c < 3; ++c) desc.specular_color[c] = at_least(color[c], 0.0, "specularColorFactor");
      warn_unread(*e, {"specularTexture", "specularColorTexture"});
    }
    if (const auto* e = extension(extensions, "KHR_materials_emissive_strength")) {
      const float strength = at_least(number(file_, *e, "emissiveStrength", 1.0), 0.0, "emissiveStrength");
      for (float& c : desc.emissive) c *= strength;
    }
    const auto* gloss = extension(extensions, "KHR_materials_pbrSpecularGlossiness");
    if (gloss != nullptr) convert_specular_glossiness(*gloss, desc);
  }

  void read_volume(const tinygltf::Value& e, sideray_material_desc& desc) {
    desc.thickness = at_least(number(file_, e, "thicknessFactor", 0.0), 0.0, "thicknessFactor");
    desc.thickness_texture = slot(use(e, "thicknessTexture"), false);
    const double distance = number(file_, e, "attenuationDistance", std::numeric_limits<double>::max());
    if (!(distance > 0.0)) refuse_value("attenuationDistance", distance, "the numbers above 0");
    desc.attenuation_distance = static_cast<float>(std::min(distance, 1e30));
    if (distance >= 1e30) desc.attenuation_distance = std::numeric_limits<float>::infinity();
    read_unit_color(numbers(file_, e, "attenuationColor", {1, 1, 1}), desc.attenuation_color, 3, "attenuationColor");
  }

  // The archived predecessor of metallic-roughness: diffuse colour, and specular colour as F0.
  void convert_specular_glossiness(const tinygltf::Value& e, sideray_material_desc& desc) {
    read_unit_color(numbers(file_, e, "diffuseFactor", {1, 1, 1, 1}), desc.base_color, 4, "diffuseFactor");
    desc.base_color_texture = slot(use(e, "diffuseTexture"), true);
    desc.metallic = 0.0f;
    desc.metallic_roughness_texture = slot({}, false);
    desc.roughness = 1.0f - unit(number(file_, e, "glossinessFactor", 1.0), "glossinessFactor");
    const std::vector<double> specular = numbers(file_, e, "specularFactor", {1, 1, 1});
    constexpr double f0_of_ior = 0.04;
    for (size_t c = 0; c < 3; ++c) {
      desc.specular_color[c] = static_cast<float>(double{unit(specular[c], "specularFactor")} / f0_of_ior);
    }
    content_.warnings.push_back(
        fmt::format("{}: KHR_materials_pbrSpecularGlossiness is converted to metallic-roughness", user_));
    warn_unread(e, {"specularGlossinessTexture"});
  }

  void warn_unread(const tinygltf::Value& e, std::initializer_list<const char*> keys) {
    for (const char* key : keys) {
      if (e.Has(key)) content_.warnings.push_back(fmt::format("{}: {} is not read; its factor is used", user_, key));
    }
  }

  void read_extras(const tinygltf::Material& source, Material& material) {
    const tinygltf::Value* extras = sideray_extras(source.extras);
    if (extras == nullptr) return;
    if (extras->Has("rayTraced")) {
      const tinygltf::Value& mark = extras->Get("rayTraced");
      if (!mark.IsBool()) refuse("cannot read {}: rayTraced of {} is not true or false; correct it", file_.path, user_);
      material.ray_traced = mark.Get<bool>() ? RayTraced::yes : RayTraced::no;
    }
    if (!extras->Has("blend")) return;
    static const std::map<std::string, sideray_blend_mode> modes{{"alpha", SIDERAY_BLEND_ALPHA},
                                                                 {"premultiplied", SIDERAY_BLEND_PREMULTIPLIED},
                                                                 {"additive", SIDERAY_BLEND_ADDITIVE},
                                                                 {"multiply", SIDERAY_BLEND_MULTIPLY}};
    const tinygltf::Value& blend = extras->Get("blend");
    const auto found = modes.find(blend.IsString() ? blend.Get<std::string>() : "");
    if (found == modes.end()) {
      refuse("cannot read {}: blend of {} is unknown; use alpha, premultiplied, additive or multiply", file_.path,
             user_);
    }
    material.desc.blend_mode = found->second;
  }

  template <typename Info>
  static TextureUse use(const Info& info) {
    return {info.index, info.texCoord, &info.extensions};
  }

  // A textureInfo inside an extension, which tinygltf leaves as a value.
  TextureUse use(const tinygltf::Value& e, const char* key) {
    if (!e.Has(key)) return {};
    const tinygltf::Value& info = e.Get(key);
    TextureUse use;
    use.index = static_cast<int>(std::clamp(number(file_, info, "index", -1.0), -1.0, 2e9));
    use.uv_set = static_cast<int>(std::clamp(number(file_, info, "texCoord", 0.0), -1.0, 2e9));
    if (!info.Has("extensions") || !info.Get("extensions").IsObject()) return use;
    // Kept here so that the pointer stays valid while the slot is made.
    inner_extensions_ = info.Get("extensions").Get<tinygltf::Value::Object>();
    use.extensions = &inner_extensions_;
    return use;
  }

  sideray_texture_slot slot(const TextureUse& use, bool srgb) {
    sideray_texture_slot slot{};
    slot.texture_from_uv[0] = slot.texture_from_uv[3] = 1.0f;
    if (use.index < 0) return slot;
    const auto& textures = file_.model.textures;
    const tinygltf::Texture& texture = textures[checked_index(file_, use.index, textures.size(), "texture", user_)];
    int uv_set = use.uv_set;
    if (use.extensions != nullptr) transform(*use.extensions, slot, uv_set);
    if (uv_set < 0 || uv_set > 1) {
      refuse("cannot read {}: {} uses TEXCOORD_{}; only 0 and 1 are read", file_.path, user_, uv_set);
    }
    slot.uv_set = static_cast<uint32_t>(uv_set);
    if (texture.source < 0) {
      refuse("cannot read {}: {} uses a texture without a PNG or JPEG image; use a decoded copy", file_.path, user_);
    }
    slot.texture = content_texture(texture.source, srgb, texture.name);
    if (texture.sampler >= 0) sample(texture.sampler, slot);
    return slot;
  }

  // KHR_texture_transform: scale, then turn counter-clockwise as seen (v points down), then move.
  void transform(const tinygltf::ExtensionMap& extensions, sideray_texture_slot& slot, int& uv_set) {
    const tinygltf::Value* e = extension(extensions, "KHR_texture_transform");
    if (e == nullptr) return;
    const std::vector<double> offset = numbers(file_, *e, "offset", {0, 0});
    const std::vector<double> scale = numbers(file_, *e, "scale", {1, 1});
    const double rotation = number(file_, *e, "rotation", 0.0);
    const double c = std::cos(rotation), s = std::sin(rotation);
    const double texture_from_uv[6] = {c * scale[0], -s * scale[0], s * scale[1], c * scale[1], offset[0], offset[1]};
    std::transform(texture_from_uv, texture_from_uv + 6, slot.texture_from_uv,
                   [](double m) { return static_cast<float>(m); });
    uv_set = static_cast<int>(std::clamp(number(file_, *e, "texCoord", uv_set), -1.0, 2e9));
  }

  void sample(int index, sideray_texture_slot& slot) {
    const auto& samplers = file_.model.samplers;
    const tinygltf::Sampler& sampler = samplers[checked_index(file_, index, samplers.size(), "sampler", user_)];
    const auto wrap = [](int mode) {
      if (mode == gl_clamp_to_edge) return SIDERAY_CLAMP;
      return mode == gl_mirrored_repeat ? SIDERAY_MIRROR : SIDERAY_REPEAT;
    };
    slot.wrap_u = wrap(sampler.wrapS);
    slot.wrap_v = wrap(sampler.wrapT);
    if (sampler.magFilter == gl_nearest || sampler.minFilter == gl_nearest)
      slot.filter = SIDERAY_NEAREST;
    else if (sampler.minFilter == gl_linear)
      slot.filter = SIDERAY_BILINEAR;
  }

  // Index + 1 into Content::textures; each image is kept once for each way of reading its colours.
  uint32_t content_texture(int image_index, bool srgb, const std::string& texture_name) {
    const auto& images = file_.model.images;
    const size_t index = checked_index(file_, image_index, images.size(), "image", user_);
    const auto [found, is_new] = kept_.try_emplace({index, srgb}, 0);
    if (!is_new) return found->second;
    Texture texture;
    texture.name = !texture_name.empty() ? texture_name : images[index].name;
    if (texture.name.empty()) texture.name = fmt::format("image{}", index);
    texture.srgb = srgb;
    if (const auto other = kept_.find({index, !srgb}); other != kept_.end()) {
      const Texture& same = content_.textures[other->second - 1];
      texture.width = same.width, texture.height = same.height, texture.rgba = same.rgba;
    } else {
      Decoded decoded = decode(index);
      texture.width = decoded.width, texture.height = decoded.height, texture.rgba = std::move(decoded.rgba);
    }
    texels_ += uint64_t{texture.width} * texture.height;
    if (texels_ > limits::texels) {
      refuse("cannot read {}: its textures have more than {} texels; use smaller pictures", file_.path, limits::texels);
    }
    content_.textures.push_back(std::move(texture));
    return found->second = static_cast<uint32_t>(content_.textures.size());
  }

  Decoded decode(size_t index) const {
    const tinygltf::Image& image = file_.model.images[index];
    const bool own_file = !image.uri.empty() && !image.uri.starts_with("data:");
    const std::string name = own_file ? image.uri : image.name;
    return decode_image(image.image,
                        fmt::format("image {}{}{} of {}", index, name.empty() ? "" : " ", name, file_.path));
  }

  const File& file_;
  Content& content_;
  std::string user_;
  tinygltf::ExtensionMap inner_extensions_;
  std::map<std::pair<size_t, bool>, uint32_t> kept_;
  uint64_t texels_ = 0;
};

}  // namespace

void read_materials(const File& file, Content& content) {
  MaterialReader reader(file, content);
  for (size_t i = 0; i < file.model.materials.size(); ++i) {
    content.materials.push_back(reader.read(file.model.materials[i], i));
  }
}

}  // namespace sideray::scenes::gltf
