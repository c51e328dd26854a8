#include "model/material.h"

#include <cmath>

#include "model/material_slots.h"

namespace sideray::model {

sideray_material_desc default_material() {
  sideray_material_desc d{};
  d.size = sizeof(d);
  for (float& c : d.base_color) c = 1.0f;
  d.roughness = 1.0f;
  d.normal_scale = 1.0f;
  d.occlusion_strength = 1.0f;
  d.alpha_cutoff = 0.5f;
  d.ior = 1.5f;
  d.attenuation_distance = INFINITY;
  for (float& c : d.attenuation_color) c = 1.0f;
  d.specular = 1.0f;
  for (float& c : d.specular_color) c = 1.0f;
  d.clearcoat_normal_scale = 1.0f;
  for (float& c : d.diffuse_transmission_color) c = 1.0f;
  for (const MaterialSlot& s : material_slots) {
    sideray_texture_slot& slot = d.*s.slot;
    slot.texture_from_uv[0] = 1.0f;
    slot.texture_from_uv[3] = 1.0f;
  }
  return d;
}

}  // namespace sideray::model
