// Writes materials and their textures into a GLB file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <tuple>
#include <utility>

#include "scenes/content/content.h"
#include "scenes/glb/glb_document.h"

namespace sideray::scenes {

class GlbMaterials {
 public:
  using Json = GlbDocument::Json;

  // Keeps both arguments.
  GlbMaterials(const Content& content, GlbDocument& document) : content_(content), document_(document) {}

  // Returns the JSON of one of the content's materials.
  Json material(size_t index);
  // Returns the index of a texture, which is written once.
  size_t texture(const sideray_texture_slot& slot);

 private:
  size_t sampler(const sideray_texture_slot& slot);
  size_t image(uint32_t index);
  void set_texture(Json& parent, const char* key, const sideray_texture_slot& slot);
  void set_transform(Json& info, const float (&texture_from_uv)[6]);
  float mesh_thickness(size_t index) const;
  void set_emission(Json& material, const sideray_material_desc& desc);
  void set_volume(Json& material, const sideray_material_desc& desc, float thickness);
  void set_extensions(Json& material, const sideray_material_desc& desc);

  const Content& content_;
  GlbDocument& document_;
  std::map<std::tuple<sideray_wrap, sideray_wrap, sideray_filter>, size_t> samplers_;
  std::map<uint32_t, size_t> images_;
  std::map<std::pair<size_t, size_t>, size_t> textures_;
};

}  // namespace sideray::scenes
