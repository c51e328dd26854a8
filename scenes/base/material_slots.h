// Lists the texture slots of a material, with the names that `info` shows. Any thread.
#pragma once

#include <sideray/sideray.h>

#include <array>

namespace sideray::scenes {

struct MaterialSlot {
  const char* name;
  sideray_texture_slot sideray_material_desc::*slot;
};

inline constexpr std::array<MaterialSlot, 19> material_slots{{
    {"base_color", &sideray_material_desc::base_color_texture},
    {"metallic_roughness", &sideray_material_desc::metallic_roughness_texture},
    {"normal", &sideray_material_desc::normal_texture},
    {"occlusion", &sideray_material_desc::occlusion_texture},
    {"emissive", &sideray_material_desc::emissive_texture},
    {"transmission", &sideray_material_desc::transmission_texture},
    {"thickness", &sideray_material_desc::thickness_texture},
    {"specular", &sideray_material_desc::specular_texture},
    {"specular_color", &sideray_material_desc::specular_color_texture},
    {"clearcoat", &sideray_material_desc::clearcoat_texture},
    {"clearcoat_roughness", &sideray_material_desc::clearcoat_roughness_texture},
    {"clearcoat_normal", &sideray_material_desc::clearcoat_normal_texture},
    {"sheen_color", &sideray_material_desc::sheen_color_texture},
    {"sheen_roughness", &sideray_material_desc::sheen_roughness_texture},
    {"diffuse_transmission", &sideray_material_desc::diffuse_transmission_texture},
    {"diffuse_transmission_color", &sideray_material_desc::diffuse_transmission_color_texture},
    {"iridescence", &sideray_material_desc::iridescence_texture},
    {"iridescence_thickness", &sideray_material_desc::iridescence_thickness_texture},
    {"anisotropy", &sideray_material_desc::anisotropy_texture},
}};

}  // namespace sideray::scenes
