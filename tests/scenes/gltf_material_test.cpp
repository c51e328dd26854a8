#include <gmock/gmock.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <set>

#include "scenes/base/material_slots.h"
#include "scenes/images/images.h"
#include "scenes/support.h"

// Tests the reading of materials and their textures, and that writing them loses nothing.
namespace sideray::scenes {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;
using Bytes = std::vector<uint8_t>;

struct Rgba {
  uint8_t r, g, b, a;
};

Bytes png_of(uint32_t width, uint32_t height, const std::vector<Rgba>& texels) {
  Bytes pixels;
  for (const Rgba& t : texels) pixels.insert(pixels.end(), {t.r, t.g, t.b, t.a});
  return encode_png(width, height, 4, pixels, "test");
}

// Appends an image and a texture of it; the texture's index.
size_t add_texture(SmallGltf& g, const Bytes& bytes, const char* media_type = "image/png") {
  g.json["images"].push_back({{"bufferView", g.add_view(bytes)}, {"mimeType", media_type}});
  g.json["textures"].push_back({{"source", g.json["images"].size() - 1}});
  return g.json["textures"].size() - 1;
}

Content load_material(SmallGltf& g, json material) {
  material["name"] = "m";
  g.json["materials"] = json::array({std::move(material)});
  g.primitive()["material"] = 0;
  return g.load();
}

// Every slot of a material with a texture of its own, each turned and moved differently.
SmallGltf every_slot() {
  SmallGltf g;
  uint8_t value = 0;
  const auto texture = [&](json more = json::object()) {
    value = static_cast<uint8_t>(value + 10);
    const size_t index = add_texture(g, png_of(1, 1, {{value, 1, 2, 255}}));
    more["index"] = index;
    more["extensions"]["KHR_texture_transform"] = {
        {"offset", {0.25 * value, 0.5}}, {"scale", {2.0, 3.0}}, {"rotation", 0.01 * value}, {"texCoord", index % 2}};
    return more;
  };
  json& m = g.json["materials"][0];
  m["name"] = "m";
  m["pbrMetallicRoughness"] = {{"baseColorTexture", texture()}, {"metallicRoughnessTexture", texture()}};
  m["normalTexture"] = texture({{"scale", 0.5}});
  m["occlusionTexture"] = texture({{"strength", 0.25}});
  m["emissiveTexture"] = texture();
  m["emissiveFactor"] = {1, 0.5, 0.25};
  json& e = m["extensions"];
  e["KHR_materials_transmission"] = {{"transmissionFactor", 0.7}, {"transmissionTexture", texture()}};
  e["KHR_materials_volume"] = {{"thicknessFactor", 0.1}, {"thicknessTexture", texture()}};
  e["KHR_materials_specular"] = {{"specularFactor", 0.9},
                                 {"specularTexture", texture()},
                                 {"specularColorFactor", {2, 1, 0.5}},
                                 {"specularColorTexture", texture()}};
  e["KHR_materials_clearcoat"] = {{"clearcoatFactor", 0.8},
                                  {"clearcoatTexture", texture()},
                                  {"clearcoatRoughnessFactor", 0.3},
                                  {"clearcoatRoughnessTexture", texture()},
                                  {"clearcoatNormalTexture", texture({{"scale", 0.75}})}};
  e["KHR_materials_sheen"] = {{"sheenColorFactor", {0.1, 0.2, 0.3}},
                              {"sheenColorTexture", texture()},
                              {"sheenRoughnessFactor", 0.4},
                              {"sheenRoughnessTexture", texture()}};
  e["KHR_materials_diffuse_transmission"] = {{"diffuseTransmissionFactor", 0.6},
                                             {"diffuseTransmissionTexture", texture()},
                                             {"diffuseTransmissionColorFactor", {0.9, 0.8, 0.7}},
                                             {"diffuseTransmissionColorTexture", texture()}};
  e["KHR_materials_iridescence"] = {{"iridescenceFactor", 0.5},
                                    {"iridescenceTexture", texture()},
                                    {"iridescenceIor", 1.75},
                                    {"iridescenceThicknessMinimum", 120},
                                    {"iridescenceThicknessMaximum", 640},
                                    {"iridescenceThicknessTexture", texture()}};
  e["KHR_materials_anisotropy"] = {
      {"anisotropyStrength", 0.65}, {"anisotropyRotation", 1.5}, {"anisotropyTexture", texture()}};
  e["KHR_materials_emissive_strength"] = {{"emissiveStrength", 8}};
  e["KHR_materials_ior"] = {{"ior", 1.25}};
  e["KHR_materials_dispersion"] = {{"dispersion", 0.375}};
  m["extras"]["sideray"] = {{"rayTraced", true}, {"inexactShadow", true}, {"blend", "multiply"}, {"distortion", 0.125}};
  g.primitive()["material"] = 0;
  return g;
}

TEST(GltfMaterial, EveryFactorIsRead) {
  const Content content = every_slot().load();
  EXPECT_THAT(content.warnings, ElementsAre(HasSubstr("which way")));  // the mesh has no coordinates
  const Material& material = content.materials.at(0);
  const sideray_material_desc& d = material.desc;
  EXPECT_EQ(d.normal_scale, 0.5f);
  EXPECT_EQ(d.occlusion_strength, 0.25f);
  EXPECT_THAT(d.emissive, ElementsAre(8.0f, 4.0f, 2.0f));
  EXPECT_EQ(d.transmission, 0.7f);
  EXPECT_EQ(d.dispersion, 0.375f);
  EXPECT_EQ(d.thickness, 0.1f);
  EXPECT_EQ(d.ior, 1.25f);
  EXPECT_EQ(d.specular, 0.9f);
  EXPECT_THAT(d.specular_color, ElementsAre(2.0f, 1.0f, 0.5f));
  EXPECT_EQ(d.clearcoat, 0.8f);
  EXPECT_EQ(d.clearcoat_roughness, 0.3f);
  EXPECT_EQ(d.clearcoat_normal_scale, 0.75f);
  EXPECT_THAT(d.sheen_color, ElementsAre(0.1f, 0.2f, 0.3f));
  EXPECT_EQ(d.sheen_roughness, 0.4f);
  EXPECT_EQ(d.diffuse_transmission, 0.6f);
  EXPECT_THAT(d.diffuse_transmission_color, ElementsAre(0.9f, 0.8f, 0.7f));
  EXPECT_EQ(d.iridescence, 0.5f);
  EXPECT_EQ(d.iridescence_ior, 1.75f);
  EXPECT_EQ(d.iridescence_thickness_min, 120.0f);
  EXPECT_EQ(d.iridescence_thickness_max, 640.0f);
  EXPECT_EQ(d.anisotropy, 0.65f);
  EXPECT_EQ(d.anisotropy_rotation, 1.5f);
  EXPECT_EQ(material.ray_traced, RayTraced::yes);
  EXPECT_TRUE(material.inexact_shadow);
  EXPECT_EQ(d.blend_mode, SIDERAY_BLEND_MULTIPLY);
  EXPECT_EQ(material.desc.distortion, 0.125f);
}

// The order of `every_slot` is that of `material_slots`; each texture's red value identifies it.
TEST(GltfMaterial, EverySlotHasItsTextureTransformAndColorSpace) {
  const Content content = every_slot().load();
  const std::set<std::string> colors{"base_color", "emissive", "specular_color", "sheen_color",
                                     "diffuse_transmission_color"};
  ASSERT_EQ(content.textures.size(), material_slots.size());
  for (size_t i = 0; i < material_slots.size(); ++i) {
    SCOPED_TRACE(material_slots[i].name);
    const sideray_texture_slot& slot = content.materials[0].desc.*material_slots[i].slot;
    ASSERT_GT(slot.texture, 0u);
    const Texture& texture = content.textures[slot.texture - 1];
    const double value = 10.0 * static_cast<double>(i + 1);
    EXPECT_EQ(texture.rgba[0], value);
    EXPECT_EQ(texture.srgb, colors.contains(material_slots[i].name));
    EXPECT_EQ(slot.uv_set, i % 2);
    // KHR_texture_transform: offset + rotation * (scale * uv), and its matrix turns (1, 0) toward (cos, -sin).
    const double c = std::cos(0.01 * value), s = std::sin(0.01 * value);
    const double expected[6] = {2 * c, -2 * s, 3 * s, 3 * c, 0.25 * value, 0.5};
    for (int k = 0; k < 6; ++k) EXPECT_NEAR(slot.texture_from_uv[k], expected[k], 1e-6) << k;
  }
}

TEST(GltfMaterial, ATextureTransformBeyondItsRangeIsRefused) {
  for (const double scale : {1e16, 1e39, -1e300}) {
    SmallGltf g = every_slot();
    json& used = g.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"];
    used["extensions"]["KHR_texture_transform"]["scale"] = {1.0, scale};
    EXPECT_THAT(message_of([&] { g.load(); }), testing::AllOf(HasSubstr("KHR_texture_transform"), HasSubstr("1e15")));
  }
}

TEST(GltfMaterial, WrittenAndReadAgainIsEqual) {
  const ScratchFolder folder;
  const Content first = every_slot().load();
  write_glb(folder / "a.glb", first);
  const Content again = load(folder / "a.glb");
  EXPECT_THAT(again.warnings, ElementsAre(HasSubstr("which way")));
  EXPECT_THAT(again.extensions, testing::IsSupersetOf({"KHR_materials_clearcoat", "KHR_materials_sheen",
                                                       "KHR_materials_diffuse_transmission", "KHR_materials_specular",
                                                       "KHR_materials_iridescence", "KHR_materials_anisotropy",
                                                       "KHR_texture_transform"}));
  ASSERT_EQ(again.materials.size(), 1u);
  const Material &a = first.materials[0], &b = again.materials[0];
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.ray_traced, b.ray_traced);
  EXPECT_EQ(a.inexact_shadow, b.inexact_shadow);
  EXPECT_EQ(a.desc.distortion, b.desc.distortion);
  sideray_material_desc da = a.desc, db = b.desc;
  for (const MaterialSlot& s : material_slots) {
    SCOPED_TRACE(s.name);
    sideray_texture_slot &sa = da.*s.slot, &sb = db.*s.slot;
    ASSERT_GT(sb.texture, 0u);
    const Texture &ta = first.textures[sa.texture - 1], &tb = again.textures[sb.texture - 1];
    EXPECT_EQ(ta.rgba, tb.rgba);
    EXPECT_EQ(ta.srgb, tb.srgb);
    // Scale and angle are found from the matrix again: equal to rounding.
    for (int k = 0; k < 6; ++k) EXPECT_NEAR(sa.texture_from_uv[k], sb.texture_from_uv[k], 1e-5);
    std::copy_n(sa.texture_from_uv, 6, sb.texture_from_uv);
    sb.texture = sa.texture;
  }
  EXPECT_EQ(std::memcmp(&da, &db, sizeof(da)), 0) << "some factor differs";
}

TEST(GltfMaterial, OneImageReadBothWaysIsTwoTextures) {
  SmallGltf g;
  const size_t t = add_texture(g, png_of(1, 1, {{9, 8, 7, 6}}));
  const json use = {{"index", t}};
  const Content content = load_material(
      g, {{"pbrMetallicRoughness", {{"baseColorTexture", use}, {"metallicRoughnessTexture", use}}},
          {"extensions", {{"KHR_materials_sheen", {{"sheenColorTexture", use}, {"sheenRoughnessTexture", use}}}}}});
  const sideray_material_desc& d = content.materials[0].desc;
  ASSERT_EQ(content.textures.size(), 2u);
  EXPECT_EQ(d.sheen_color_texture.texture, d.base_color_texture.texture);
  EXPECT_EQ(d.sheen_roughness_texture.texture, d.metallic_roughness_texture.texture);
  EXPECT_NE(d.sheen_roughness_texture.texture, d.sheen_color_texture.texture);
  EXPECT_EQ(content.textures[0].rgba, content.textures[1].rgba);
}

TEST(GltfMaterial, OtherLobesAreWarnedOfOrRefusedWhereRequired) {
  const char* name = "KHR_materials_subsurface";
  SmallGltf g;
  g.json["extensionsUsed"] = json::array({name});
  const Content content = load_material(g, {{"extensions", {{name, json::object()}}}});
  EXPECT_THAT(content.warnings, ElementsAre(HasSubstr(name)));
  g.json["extensionsRequired"] = json::array({name});
  EXPECT_THAT(g.load_error(), HasSubstr(name));
}

TEST(GltfMaterial, AFilmHasTheExtensionsDefaultsAndItsFactorsAreChecked) {
  const char* name = "KHR_materials_iridescence";
  SmallGltf g;
  const Content content = load_material(g, {{"extensions", {{name, {{"iridescenceFactor", 1}}}}}});
  EXPECT_THAT(content.warnings, testing::IsEmpty());
  const sideray_material_desc& d = content.materials[0].desc;
  EXPECT_EQ(d.iridescence, 1.0f);
  EXPECT_EQ(d.iridescence_ior, 1.3f);
  EXPECT_EQ(d.iridescence_thickness_min, 100.0f);
  EXPECT_EQ(d.iridescence_thickness_max, 400.0f);
  const std::pair<const char*, double> bad[] = {{"iridescenceFactor", 1.5},
                                                {"iridescenceIor", 0.5},
                                                {"iridescenceThicknessMinimum", -20},
                                                {"iridescenceThicknessMaximum", 1e7}};
  for (const auto& [key, value] : bad) {
    g.json["materials"][0]["extensions"][name] = {{key, value}};
    EXPECT_THAT(g.load_error(), testing::AllOf(HasSubstr(key), HasSubstr("outside")));
  }
}

TEST(GltfMaterial, AnisotropyHasTheExtensionsDefaultsAndItsNumbersAreChecked) {
  const char* name = "KHR_materials_anisotropy";
  SmallGltf g;
  const Content content = load_material(g, {{"extensions", {{name, {{"anisotropyRotation", 7}}}}}});
  EXPECT_EQ(content.materials[0].desc.anisotropy, 0.0f);
  EXPECT_EQ(content.materials[0].desc.anisotropy_rotation, 7.0f);
  EXPECT_THAT(content.warnings, ElementsAre(HasSubstr("which way")));
  for (const double strength : {1.5, -0.5}) {
    g.json["materials"][0]["extensions"][name] = {{"anisotropyStrength", strength}};
    EXPECT_THAT(g.load_error(), testing::AllOf(HasSubstr("anisotropyStrength"), HasSubstr("outside")));
  }
  g.json["materials"][0]["extensions"][name] = {{"anisotropyRotation", -1e300}};
  EXPECT_THAT(g.load_error(), testing::AllOf(HasSubstr("anisotropyRotation"), HasSubstr("outside")));
}

// From a metallic-roughness grey to specular-glossiness (the definition of both models: F0 = mix(0.04, base, metallic),
// diffuse light = base (1 - metallic), in the older model diffuse (1 - F0)) and back.
TEST(SpecularGlossiness, GreysComeBackExactly) {
  for (const double base : {0.02, 0.2, 0.5, 0.9}) {
    for (const double metallic : {0.0, 0.3, 0.7, 1.0}) {
      const double f0 = 0.04 * (1 - metallic) + base * metallic;
      if (f0 < 0.04) continue;  // such a specular colour has two origins, and only the dielectric one is found
      const double diffuse = base * (1 - metallic) * 0.96 / (1 - f0);
      SmallGltf g;
      const Content content = load_material(g, {{"extensions",
                                                 {{"KHR_materials_pbrSpecularGlossiness",
                                                   {{"diffuseFactor", {diffuse, diffuse, diffuse, 0.5}},
                                                    {"specularFactor", {f0, f0, f0}},
                                                    {"glossinessFactor", 0.75}}}}}});
      SCOPED_TRACE(testing::Message() << "base " << base << ", metallic " << metallic);
      const sideray_material_desc& d = content.materials[0].desc;
      // Root of a difference of nearly equal numbers: about half the digits of a double stay.
      EXPECT_NEAR(d.metallic, metallic, 1e-6);
      EXPECT_NEAR(d.base_color[0], base, 1e-5);
      EXPECT_EQ(d.base_color[3], 0.5f);
      EXPECT_EQ(d.roughness, 0.25f);
      EXPECT_THAT(content.warnings, ElementsAre(HasSubstr("KHR_materials_pbrSpecularGlossiness: 1 material is")));
    }
  }
}

TEST(SpecularGlossiness, BelowDielectricsTheReflectanceIsKept) {
  SmallGltf g;
  const Content content = load_material(g, {{"extensions",
                                             {{"KHR_materials_pbrSpecularGlossiness",
                                               {{"diffuseFactor", {0.5, 0.25, 0.125, 1}},
                                                {"specularFactor", {0.01, 0.02, 0.03}},
                                                {"glossinessFactor", 0}}}}}});
  const sideray_material_desc& d = content.materials[0].desc;
  EXPECT_EQ(d.metallic, 0.0f);
  EXPECT_EQ(d.roughness, 1.0f);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(0.04 * double{d.specular_color[c]}, 0.01 * (c + 1), 1e-7);
  // Diffuse light of the older model is diffuse (1 - the largest specular), ours base (1 - 0.04).
  EXPECT_NEAR(d.base_color[0], 0.5 * 0.97 / 0.96, 1e-6);
}

TEST(SpecularGlossiness, TexturesAreConvertedTexelByTexel) {
  SmallGltf g;
  // Left: a mirror of (0.9, 0.9, 0.9) sRGB 243. Right: no reflectance at all. Glossiness 1 and 0.4.
  const size_t specular = add_texture(g, png_of(2, 1, {{243, 243, 243, 255}, {0, 0, 0, 102}}));
  const size_t diffuse =
      add_texture(g, png_of(2, 2, {{0, 0, 0, 255}, {188, 99, 50, 64}, {0, 0, 0, 128}, {188, 99, 50, 32}}));
  const Content content = load_material(g, {{"extensions",
                                             {{"KHR_materials_pbrSpecularGlossiness",
                                               {{"diffuseTexture", {{"index", diffuse}}},
                                                {"specularGlossinessTexture", {{"index", specular}}},
                                                {"glossinessFactor", 0.5}}}}}});
  const sideray_material_desc& d = content.materials[0].desc;
  ASSERT_EQ(content.textures.size(), 2u) << "the pictures of the older model are not kept";
  const Texture& base = content.textures[d.base_color_texture.texture - 1];
  const Texture& data = content.textures[d.metallic_roughness_texture.texture - 1];
  EXPECT_TRUE(base.srgb);
  EXPECT_FALSE(data.srgb);
  EXPECT_EQ(base.width, 2u);
  EXPECT_EQ(base.height, 2u);
  // The mirror's colour becomes the base colour of a metal; without reflectance the diffuse colour stays, lighter by
  // 1 / 0.96 in linear light. Alpha is the diffuse picture's.
  EXPECT_THAT(std::vector(base.rgba.begin(), base.rgba.begin() + 4), ElementsAre(243, 243, 243, 255));
  EXPECT_EQ(base.rgba[7], 64);
  EXPECT_EQ(base.rgba[11], 128);
  EXPECT_EQ(base.rgba[15], 32);
  const auto linear = [](int x) { return std::pow((x / 255.0 + 0.055) / 1.055, 2.4); };
  EXPECT_NEAR(linear(base.rgba[4]), linear(188) / 0.96, 0.5 * (linear(189) - linear(187)));
  EXPECT_EQ(data.rgba[2], 255) << "metal";
  EXPECT_EQ(data.rgba[6], 0) << "no metal";
  // Roughness is 1 - glossiness * factor.
  EXPECT_NEAR(data.rgba[1], 255 * (1 - 0.5), 1);
  EXPECT_NEAR(data.rgba[5], 255 * (1 - 0.5 * 0.4), 1);
  EXPECT_EQ(d.metallic, 1.0f);
  EXPECT_EQ(d.roughness, 1.0f);
}

TEST(TextureSources, WebpGoesBeforeItsFallback) {
  SmallGltf g;
  add_texture(g, png_of(1, 1, {{1, 2, 3, 255}}));
  const size_t t = add_texture(g, png_of(1, 1, {{4, 5, 6, 255}}));
  g.json["textures"][t] = {{"source", 0}, {"extensions", {{"EXT_texture_webp", {{"source", 1}}}}}};
  const Content content = load_material(g, {{"emissiveTexture", {{"index", t}}}});
  EXPECT_EQ(content.textures.at(0).rgba[0], 4);
}

std::string base64(const Bytes& bytes) {
  static constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (size_t i = 0; i < bytes.size(); i += 3) {
    const size_t left = bytes.size() - i;
    const uint32_t word =
        static_cast<uint32_t>(bytes[i] << 16 | (left > 1 ? bytes[i + 1] << 8 : 0) | (left > 2 ? bytes[i + 2] : 0));
    for (size_t k = 0; k < 4; ++k) text += k > left ? '=' : digits[word >> (18 - 6 * k) & 63];
  }
  return text;
}

TEST(TextureSources, DataUrisOfAnyMediaType) {
  const Bytes png = png_of(1, 1, {{11, 22, 33, 44}});
  for (const char* type : {"image/png", "image/webp", "application/octet-stream", "image/x-unheard-of"}) {
    SmallGltf g;
    g.json["images"] = {{{"uri", std::string("data:") + type + ";base64," + base64(png)}}};
    g.json["textures"] = {{{"source", 0}}};
    const Content content = load_material(g, {{"emissiveTexture", {{"index", 0}}}});
    EXPECT_THAT(content.textures.at(0).rgba, ElementsAre(11, 22, 33, 44)) << type;
  }
}

struct BrokenMaterial {
  const char* name;
  std::function<json(SmallGltf&)> material;
  std::vector<const char*> message;
};
void PrintTo(const BrokenMaterial& broken, std::ostream* out) {
  *out << broken.name;
}

json with_extras(json extras) {
  return {{"extras", {{"sideray", std::move(extras)}}}};
}
json with_extension(const char* name, json values) {
  return {{"extensions", {{name, std::move(values)}}}};
}

const BrokenMaterial broken_materials[] = {
    {"ImageCut",
     [](SmallGltf& g) {
       Bytes png = png_of(1, 1, {{1, 2, 3, 4}});
       png.resize(png.size() / 2);
       g.json["images"] = {{{"name", "wood"}, {"bufferView", g.add_view(png)}, {"mimeType", "image/png"}}};
       g.json["textures"] = {{{"source", 0}}};
       return json{{"emissiveTexture", {{"index", 0}}}};
     },
     {"image 0 wood of ", "scene.gltf", "write the file again"}},
    {"ImageDataUriWithoutData",
     [](SmallGltf& g) {
       g.json["images"] = {{{"uri", "data:image/webp,hello"}}};
       g.json["textures"] = {{{"source", 0}}};
       return json{{"emissiveTexture", {{"index", 0}}}};
     },
     {"image 0 of ", "base64"}},
    {"WebpSourceMissing",
     [](SmallGltf& g) {
       g.json["textures"] = {{{"extensions", {{"EXT_texture_webp", {{"source", 7}}}}}}};
       return json{{"emissiveTexture", {{"index", 0}}}};
     },
     {"material m", "image 7"}},
    {"TextureOfUnknownKind",
     [](SmallGltf& g) {
       g.json["textures"] = {{{"extensions", {{"EXT_texture_avif", {{"source", 0}}}}}}};
       return json{{"emissiveTexture", {{"index", 0}}}};
     },
     {"material m", "without a PNG, JPEG or WebP image"}},
    {"Ktx2",
     [](SmallGltf& g) {
       g.json["images"] = {{{"name", "bark"}, {"uri", "data:image/ktx2;base64,q0tUWCAyMLsNChoK"}}};
       g.json["textures"] = {{{"extensions", {{"KHR_texture_basisu", {{"source", 0}}}}}}};
       g.json["extensionsRequired"] = {"KHR_texture_basisu"};
       return json{{"emissiveTexture", {{"index", 0}}}};
     },
     {"image 0 bark of ", "scene.gltf: it is KTX2", "material m", "npx @gltf-transform/cli ktxdecompress "}},
    {"Ktx2WithoutExtension",
     [](SmallGltf& g) {
       g.json["images"] = {{{"name", "bark"}, {"uri", "data:image/ktx2;base64,q0tUWCAyMLsNChoK"}}};
       g.json["textures"] = {{{"source", 0}}};
       return json{{"emissiveTexture", {{"index", 0}}}};
     },
     {"image 0 bark of ", "scene.gltf: it is KTX2", "npx @gltf-transform/cli ktxdecompress "}},
    {"Ktx2ImageMissing",
     [](SmallGltf& g) {
       g.json["textures"] = {{{"extensions", {{"KHR_texture_basisu", {{"source", 4}}}}}}};
       return json{{"emissiveTexture", {{"index", 0}}}};
     },
     {"material m", "image 4"}},
    {"CoatTextureMissing",
     [](SmallGltf&) {
       return with_extension("KHR_materials_clearcoat", {{"clearcoatTexture", {{"index", 4}}}});
     },
     {"material m", "texture 4"}},
    {"CoatTextureNegative",
     [](SmallGltf&) {
       return with_extension("KHR_materials_clearcoat", {{"clearcoatTexture", {{"index", -1}}}});
     },
     {"material m", "texture -1"}},
    {"CoatTextureNoObject",
     [](SmallGltf&) {
       return with_extension("KHR_materials_clearcoat", {{"clearcoatTexture", 3}});
     },
     {"material m", "clearcoatTexture"}},
    {"CoatFactorText",
     [](SmallGltf&) {
       return with_extension("KHR_materials_clearcoat", {{"clearcoatFactor", "much"}});
     },
     {"clearcoatFactor"}},
    {"SheenColorOutside",
     [](SmallGltf&) {
       return with_extension("KHR_materials_sheen", {{"sheenColorFactor", {0, 0, 2}}});
     },
     {"material m", "sheenColorFactor"}},
    {"DiffuseTransmissionOutside",
     [](SmallGltf&) {
       return with_extension("KHR_materials_diffuse_transmission", {{"diffuseTransmissionFactor", -0.1}});
     },
     {"material m", "diffuseTransmissionFactor"}},
    {"ExtrasNoObject", [](SmallGltf&) { return with_extras(3); }, {"material m", "extras.sideray"}},
    {"RayTracedNumber",
     [](SmallGltf&) {
       return with_extras({{"rayTraced", 1}});
     },
     {"material m", "rayTraced", "true or false"}},
    {"InexactShadowText",
     [](SmallGltf&) {
       return with_extras({{"inexactShadow", "yes"}});
     },
     {"material m", "inexactShadow", "true or false"}},
    {"DistortionNegative",
     [](SmallGltf&) {
       return with_extras({{"distortion", -1}});
     },
     {"material m", "distortion"}},
    {"DistortionBeyondWhatScenesTake",
     [](SmallGltf&) {
       return with_extras({{"distortion", 101}});
     },
     {"material m", "distortion", "0 to 100"}},
    {"DistortionText",
     [](SmallGltf&) {
       return with_extras({{"distortion", "x"}});
     },
     {"distortion of material m"}},
    {"BlendNumber",
     [](SmallGltf&) {
       return with_extras({{"blend", 2}});
     },
     {"material m", "blend", "premultiplied"}},
};

class BrokenMaterials : public testing::TestWithParam<BrokenMaterial> {};

TEST_P(BrokenMaterials, AreOneClearLine) {
  SmallGltf g;
  const json material = GetParam().material(g);
  const std::string message = message_of([&] { load_material(g, material); });
  EXPECT_THAT(message, HasSubstr("scene.gltf"));
  for (const char* part : GetParam().message) EXPECT_THAT(message, HasSubstr(part));
  EXPECT_EQ(message.find('\n'), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(Values, BrokenMaterials, testing::ValuesIn(broken_materials),
                         [](const testing::TestParamInfo<BrokenMaterial>& test) { return test.param.name; });

TEST(GltfMaterial, UnknownExtrasAreWarnedOf) {
  SmallGltf g;
  const Content content = load_material(g, with_extras({{"raytraced", true}}));
  EXPECT_THAT(content.warnings, ElementsAre("material m: extras.sideray.raytraced is unknown and left out"));
}

TEST(NodeExtras, WindAndParticlesAreKeptAndWrittenBack) {
  const json wind = {{"amplitude", 0.3},        {"frequency", 2},          {"height", 1.7},
                     {"direction", {0, 0, -2}}, {"branch_amplitude", 0.1}, {"branch_frequency", 1.1},
                     {"leaf_amplitude", 0.02},  {"leaf_frequency", 3.3},   {"wavelength", 0.9}};
  const json particles = {{"count", 40}, {"size", {0.1, 0.5}}, {"soft_distance", 0.25}};
  SmallGltf g;
  g.json["nodes"] = {
      {{"name", "tree"}, {"mesh", 0}, {"extras", {{"sideray", {{"wind", wind}}}}}},
      {{"name", "fire"}, {"translation", {1, 2, 3}}, {"extras", {{"sideray", {{"particles", particles}}}}}}};
  g.json["scenes"][0]["nodes"] = {0, 1};
  const ScratchFolder folder;
  write_glb(folder / "a.glb", g.load());
  for (const Content& content : {g.load(), load(folder / "a.glb")}) {
    ASSERT_EQ(content.winds.size(), 1u);
    const sideray_wind_desc& d = content.winds[0];
    EXPECT_THAT(std::vector<float>({d.amplitude, d.frequency, d.height, d.direction[2], d.branch_amplitude,
                                    d.branch_frequency, d.leaf_amplitude, d.leaf_frequency, d.wavelength}),
                ElementsAre(0.3f, 2.0f, 1.7f, -1.0f, 0.1f, 1.1f, 0.02f, 3.3f, 0.9f));
    ASSERT_EQ(content.objects.size(), 1u);
    EXPECT_EQ(content.objects[0].wind, 1u);
    EXPECT_EQ(content.objects[0].wind_phase, g.load().objects[0].wind_phase);
    ASSERT_EQ(content.emitters.size(), 1u);
    EXPECT_EQ(content.emitters[0].node, "fire");
    EXPECT_EQ(json::parse(content.emitters[0].json), particles);
    EXPECT_EQ(content.emitters[0].world_from_node[10], 2.0);
  }
}

TEST(NodeExtras, MistakesAreNamed) {
  SmallGltf g;
  json& ours = g.json["nodes"][0]["extras"]["sideray"];
  ours = {{"wind", 3}};
  EXPECT_THAT(g.load_error(), HasSubstr("wind of node a is not an object"));
  ours = {{"wind", {{"amplitude", -1}}}};
  EXPECT_THAT(g.load_error(), HasSubstr("amplitude of wind of node a"));
  ours = {{"wind", {{"phase", 1.5}}}};
  EXPECT_THAT(g.load_error(), HasSubstr("phase of wind of node a"));
  ours = {{"wind", {{"direction", {0, 0, 0}}}}};
  EXPECT_THAT(g.load_error(), HasSubstr("direction of wind of node a"));
  ours = {{"wind", {{"gusts", 1}}}};
  EXPECT_THAT(g.load().warnings, ElementsAre("node a: gusts of wind is unknown and left out"));
  ours = {{"particles", "many"}};
  EXPECT_THAT(g.load_error(), HasSubstr("particles of node a is not an object"));
  ours = {{"winds", {{"amplitude", 1}}}};
  EXPECT_THAT(g.load().warnings, ElementsAre("node a: extras.sideray.winds is unknown and left out"));
}

}  // namespace
}  // namespace sideray::scenes
