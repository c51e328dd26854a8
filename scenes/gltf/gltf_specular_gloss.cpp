#include "scenes/gltf/gltf_specular_gloss.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "elementary/functions.h"

// Follows Khronos' conversion (KHR_materials_pbrSpecularGlossiness/examples/convert-between-workflows): metallic is
// the value for which a metallic-roughness surface has the brightness of the given diffuse and specular colours.
namespace sideray::scenes::gltf {
namespace {

constexpr double dielectric = 0.04;

double perceived_brightness(const glm::dvec3& c) {
  return std::sqrt(0.299 * c.r * c.r + 0.587 * c.g * c.g + 0.114 * c.b * c.b);
}

double largest(const glm::dvec3& c) {
  return std::max({c.r, c.g, c.b});
}

double solve_metallic(double diffuse, double specular, double one_minus_specular) {
  if (specular < dielectric) return 0.0;
  const double b = diffuse * one_minus_specular / (1.0 - dielectric) + specular - 2.0 * dielectric;
  const double c = dielectric - specular;
  const double root = std::sqrt(std::max(b * b - 4.0 * dielectric * c, 0.0));
  return std::clamp((-b + root) / (2.0 * dielectric), 0.0, 1.0);
}

double linear_from_srgb(double x) {
  return x <= 0.04045 ? x / 12.92 : elementary::pow((x + 0.055) / 1.055, 2.4);
}

double srgb_from_linear(double x) {
  return x <= 0.0031308 ? 12.92 * x : 1.055 * elementary::pow(x, 1.0 / 2.4) - 0.055;
}

uint8_t byte(double x) {
  return static_cast<uint8_t>(std::lround(std::clamp(x, 0.0, 1.0) * 255.0));
}

// Reads a picture at the texel centres of another, larger picture; a missing picture is white.
class Picture {
 public:
  explicit Picture(const Decoded* pixels) : pixels_(pixels) {
    for (size_t i = 0; i < linear_.size(); ++i) linear_[i] = linear_from_srgb(static_cast<double>(i) / 255.0);
  }

  // Returns RGB in linear light and A as stored. Bilinear in linear light; edge texels repeat.
  glm::dvec4 at(uint32_t x, uint32_t y, uint32_t width, uint32_t height) const {
    if (pixels_ == nullptr) return glm::dvec4(1.0);
    if (pixels_->width == width && pixels_->height == height) return texel(x, y);
    const double u = (x + 0.5) / width * pixels_->width - 0.5, v = (y + 0.5) / height * pixels_->height - 0.5;
    const double left = std::floor(u), top = std::floor(v);
    const auto column = [&](double c) { return clamped(c, pixels_->width); };
    const auto row = [&](double r) { return clamped(r, pixels_->height); };
    const glm::dvec4 above =
        glm::mix(texel(column(left), row(top)), texel(column(left + 1), row(top)), glm::dvec4(u - left));
    const glm::dvec4 below =
        glm::mix(texel(column(left), row(top + 1)), texel(column(left + 1), row(top + 1)), glm::dvec4(u - left));
    return glm::mix(above, below, glm::dvec4(v - top));
  }

 private:
  static uint32_t clamped(double i, uint32_t size) {
    return static_cast<uint32_t>(std::clamp(i, 0.0, static_cast<double>(size - 1)));
  }

  glm::dvec4 texel(uint32_t x, uint32_t y) const {
    const uint8_t* t = &pixels_->rgba[4 * (size_t{y} * pixels_->width + x)];
    return {linear_[t[0]], linear_[t[1]], linear_[t[2]], t[3] / 255.0};
  }

  const Decoded* pixels_;
  std::array<double, 256> linear_;
};

struct Baked {
  Texture base_color, metallic_roughness;
};

Baked bake(const SpecularGloss& source, const Decoded* diffuse, const Decoded* specular_gloss, Budget& budget,
           const std::string& user) {
  const uint32_t width = std::max(diffuse ? diffuse->width : 1, specular_gloss ? specular_gloss->width : 1);
  const uint32_t height = std::max(diffuse ? diffuse->height : 1, specular_gloss ? specular_gloss->height : 1);
  budget.take(uint64_t{8} * width * height, user);
  Baked baked;
  for (Texture* texture : {&baked.base_color, &baked.metallic_roughness}) {
    texture->width = width, texture->height = height;
    texture->rgba.resize(size_t{4} * width * height);
  }
  baked.base_color.srgb = true;
  const Picture from_diffuse(diffuse), from_specular(specular_gloss);
  size_t at = 0;
  for (uint32_t y = 0; y < height; ++y) {
    budget.check_time(user);
    for (uint32_t x = 0; x < width; ++x, at += 4) {
      const glm::dvec4 d = from_diffuse.at(x, y, width, height), s = from_specular.at(x, y, width, height);
      const MetallicRoughness converted =
          metallic_from_specular(glm::dvec3(d) * glm::dvec3(source.diffuse), glm::dvec3(s) * source.specular);
      uint8_t* base = &baked.base_color.rgba[at];
      for (int c = 0; c < 3; ++c) base[c] = byte(srgb_from_linear(converted.base_color[c]));
      base[3] = byte(d.a);
      uint8_t* data = &baked.metallic_roughness.rgba[at];
      data[0] = data[3] = 255;
      data[1] = byte(1.0 - s.a * source.glossiness);
      data[2] = byte(converted.metallic);
    }
  }
  return baked;
}

bool same_place(const sideray_texture_slot& a, const sideray_texture_slot& b) {
  return a.uv_set == b.uv_set && a.wrap_u == b.wrap_u && a.wrap_v == b.wrap_v &&
         std::equal(a.texture_from_uv, a.texture_from_uv + 6, b.texture_from_uv);
}

}  // namespace

MetallicRoughness metallic_from_specular(const glm::dvec3& diffuse, const glm::dvec3& specular) {
  constexpr double epsilon = 1e-6;
  const double one_minus_specular = 1.0 - largest(specular);
  const double metallic =
      solve_metallic(perceived_brightness(diffuse), perceived_brightness(specular), one_minus_specular);
  const glm::dvec3 of_diffuse = diffuse * (one_minus_specular / (1.0 - dielectric) / std::max(1.0 - metallic, epsilon));
  const glm::dvec3 of_specular = (specular - dielectric * (1.0 - metallic)) / std::max(metallic, epsilon);
  const glm::dvec3 base = glm::mix(of_diffuse, of_specular, metallic * metallic);
  return {glm::clamp(base, 0.0, 1.0), metallic};
}

void SpecularGlossConverter::convert(const SpecularGloss& given, const std::string& user, sideray_material_desc& desc) {
  SpecularGloss source = given;
  for (TextureUse* use : {&source.diffuse_texture, &source.specular_gloss_texture}) {
    if (!textures_.source(*use, user)) use->index = -1;
  }
  ++converted_;
  const TextureUse none;
  desc.base_color_texture = desc.metallic_roughness_texture = textures_.slot(none, Colors::linear, user);
  // A surface with less reflectance than dielectrics is not metallic for any diffuse texel, so the texture stays
  // unchanged.
  const bool is_dielectric =
      source.specular_gloss_texture.index < 0 && perceived_brightness(source.specular) < dielectric;
  if (!is_dielectric && (source.diffuse_texture.index >= 0 || source.specular_gloss_texture.index >= 0)) {
    convert_textures(source, user, desc);
    return;
  }
  desc.base_color_texture = textures_.slot(source.diffuse_texture, Colors::srgb, user);
  const MetallicRoughness converted = metallic_from_specular(glm::dvec3(source.diffuse), source.specular);
  for (int c = 0; c < 3; ++c) {
    desc.base_color[c] = static_cast<float>(converted.base_color[c]);
    // KHR_materials_specular expresses this reflectance exactly.
    if (is_dielectric) desc.specular_color[c] = static_cast<float>(source.specular[c] / dielectric);
  }
  desc.base_color[3] = static_cast<float>(source.diffuse.a);
  desc.metallic = static_cast<float>(converted.metallic);
  desc.roughness = static_cast<float>(1.0 - source.glossiness);
}

void SpecularGlossConverter::convert_textures(const SpecularGloss& source, const std::string& user,
                                              sideray_material_desc& desc) {
  const auto diffuse = textures_.source(source.diffuse_texture, user);
  const auto specular_gloss = textures_.source(source.specular_gloss_texture, user);
  if (diffuse && specular_gloss && !same_place(diffuse->slot, specular_gloss->slot)) {
    content_.warnings.push_back(fmt::format(
        "{}: its diffuse and specular-glossiness textures are placed differently; both are placed as the first", user));
  }
  const TextureSource& place = diffuse ? *diffuse : *specular_gloss;
  const auto key =
      std::make_tuple(diffuse ? static_cast<int64_t>(diffuse->image) : -1,
                      specular_gloss ? static_cast<int64_t>(specular_gloss->image) : -1,
                      std::vector<double>{source.diffuse.r, source.diffuse.g, source.diffuse.b, source.specular.r,
                                          source.specular.g, source.specular.b, source.glossiness});
  auto found = kept_.find(key);
  if (found == kept_.end()) {
    std::optional<Decoded> of_diffuse, of_specular;
    if (diffuse) of_diffuse = textures_.pixels(diffuse->image);
    if (specular_gloss) of_specular = textures_.pixels(specular_gloss->image);
    const Decoded* const pictures[] = {of_diffuse ? &*of_diffuse : nullptr, of_specular ? &*of_specular : nullptr};
    Baked baked = bake(source, pictures[0], pictures[1], textures_.budget(), user);
    for (const Decoded* picture : pictures)
      if (picture != nullptr) textures_.budget().give_back(picture->rgba.size());
    const std::string name = place.name.empty() ? fmt::format("image{}", place.image) : place.name;
    baked.base_color.name = name + ".base_color";
    baked.metallic_roughness.name = name + ".metallic_roughness";
    const uint32_t base_color = textures_.add(std::move(baked.base_color));
    found = kept_.emplace(key, std::pair(base_color, textures_.add(std::move(baked.metallic_roughness)))).first;
  }
  desc.base_color_texture = desc.metallic_roughness_texture = place.slot;
  desc.base_color_texture.texture = found->second.first;
  desc.metallic_roughness_texture.texture = found->second.second;
  std::fill_n(desc.base_color, 3, 1.0f);
  desc.base_color[3] = static_cast<float>(source.diffuse.a);
  desc.metallic = desc.roughness = 1.0f;
}

}  // namespace sideray::scenes::gltf
