// Converts KHR_materials_pbrSpecularGlossiness to metallic-roughness. Knows tinygltf through gltf_texture.h. One
// thread.
#pragma once

#include <map>
#include <string>
#include <tuple>

#include "scenes/gltf/gltf_texture.h"

namespace sideray::scenes::gltf {

struct SpecularGloss {
  glm::dvec4 diffuse{1.0};  // linear, and opacity
  glm::dvec3 specular{1.0};
  double glossiness = 1.0;
  TextureUse diffuse_texture, specular_gloss_texture;  // sRGB; A of the second is glossiness
};

struct MetallicRoughness {
  glm::dvec3 base_color;
  double metallic;
};
// Converts linear diffuse and specular colours, for dielectrics that reflect 4 % at normal incidence.
MetallicRoughness metallic_from_specular(const glm::dvec3& diffuse, const glm::dvec3& specular);

class SpecularGlossConverter {
 public:
  SpecularGlossConverter(Content& content, TextureReader& textures) : content_(content), textures_(textures) {}

  // Fills base colour, metallic, roughness, their textures and, where it is exact, the specular factors.
  void convert(const SpecularGloss& source, const std::string& user, sideray_material_desc& desc);
  size_t converted() const { return converted_; }

 private:
  void convert_textures(const SpecularGloss& source, const std::string& user, sideray_material_desc& desc);

  Content& content_;
  TextureReader& textures_;
  // Maps (diffuse image, specular image, factors), which materials often share, to the two textures.
  std::map<std::tuple<int64_t, int64_t, std::vector<double>>, std::pair<uint32_t, uint32_t>> kept_;
  size_t converted_ = 0;
};

}  // namespace sideray::scenes::gltf
