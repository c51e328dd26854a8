// Lists the texture slots of a material, in the one order that the rasterizer's map bits and the checks follow. Any
// thread may read it.
#pragma once

#include <sideray/sideray.h>

#include <array>
#include <cstddef>

namespace sideray::model {

struct MaterialSlot {
  const char* name;
  sideray_texture_slot sideray_material_desc::*slot;
};

inline constexpr size_t material_slot_count = 19;
inline constexpr std::array<MaterialSlot, material_slot_count> material_slots{{
    {"base_color_texture", &sideray_material_desc::base_color_texture},
    {"metallic_roughness_texture", &sideray_material_desc::metallic_roughness_texture},
    {"normal_texture", &sideray_material_desc::normal_texture},
    {"occlusion_texture", &sideray_material_desc::occlusion_texture},
    {"emissive_texture", &sideray_material_desc::emissive_texture},
    {"transmission_texture", &sideray_material_desc::transmission_texture},
    {"thickness_texture", &sideray_material_desc::thickness_texture},
    {"specular_texture", &sideray_material_desc::specular_texture},
    {"specular_color_texture", &sideray_material_desc::specular_color_texture},
    {"clearcoat_texture", &sideray_material_desc::clearcoat_texture},
    {"clearcoat_roughness_texture", &sideray_material_desc::clearcoat_roughness_texture},
    {"clearcoat_normal_texture", &sideray_material_desc::clearcoat_normal_texture},
    {"sheen_color_texture", &sideray_material_desc::sheen_color_texture},
    {"sheen_roughness_texture", &sideray_material_desc::sheen_roughness_texture},
    {"diffuse_transmission_texture", &sideray_material_desc::diffuse_transmission_texture},
    {"diffuse_transmission_color_texture", &sideray_material_desc::diffuse_transmission_color_texture},
    {"iridescence_texture", &sideray_material_desc::iridescence_texture},
    {"iridescence_thickness_texture", &sideray_material_desc::iridescence_thickness_texture},
    {"anisotropy_texture", &sideray_material_desc::anisotropy_texture},
}};

}  // namespace sideray::model
