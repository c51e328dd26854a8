// KHR_materials_pbrSpecularGlossiness as metallic-roughness. Knows tinygltf through gltf_texture.h. One thread.
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
  TextureUse diffuse_texture, specular_gloss_texture;  // RGBA with RGB as sRGB; specular as sRGB, A glossiness
};

struct MetallicRoughness {
  glm::dvec3 base_color;
  double metallic;
};
// From linear diffuse and specular colours, for dielectrics that reflect 4 % head on.
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
  // Materials often share both pictures and factors: (diffuse image, specular image, factors) to the two textures.
  std::map<std::tuple<int64_t, int64_t, std::vector<double>>, std::pair<uint32_t, uint32_t>> kept_;
  size_t converted_ = 0;
};

}  // namespace sideray::scenes::gltf
