#include "model/material.h"

#include <cmath>

#include "elementary/functions.h"
#include "model/failure.h"
#include "model/material_slots.h"

namespace sideray::model {
namespace {

// Limits factors, so that their products stay in the range of floats.
constexpr float largest_factor = 1e15f;

void require(bool condition, const char* what, double value, const char* range) {
  if (!condition) fail(SIDERAY_INVALID_ARGUMENT, "{} is {}: out of range; give {}", what, value, range);
}

void check_slot(const sideray_texture_slot& slot, const char* name) {
  if (slot.texture == 0) return;
  if (slot.uv_set > 1) fail(SIDERAY_INVALID_ARGUMENT, "material {}: uv_set {} is not 0 or 1", name, slot.uv_set);
  for (const float m : slot.texture_from_uv)
    if (!(std::abs(m) <= largest_factor))
      fail(SIDERAY_INVALID_ARGUMENT, "material {}: texture_from_uv holds {}; give numbers up to 1e15", name, m);
}

void set_identity(sideray_texture_slot& slot) {
  slot.texture_from_uv[0] = 1.0f;
  slot.texture_from_uv[3] = 1.0f;
}

void check_unit(float value, const char* name) {
  require(value >= 0.0f && value <= 1.0f, name, double{value}, "0 to 1");
}

float lowest_roughness(const sideray_material_desc& d, const Texture* metallic_roughness) {
  return d.roughness * (metallic_roughness ? static_cast<float>(metallic_roughness->minimum_green) / 255.0f : 1.0f);
}

// Returns whether an alpha below the threshold can occur.
bool can_discard(const sideray_material_desc& d, const Texture* base_color) {
  if (d.alpha_mode == SIDERAY_OPAQUE) return false;
  if (d.alpha_mode == SIDERAY_MASK) return true;
  return lowest_alpha(d, base_color) < least_blended_alpha;
}

}  // namespace

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
  d.iridescence_ior = 1.3f;
  d.iridescence_thickness_min = 100.0f;
  d.iridescence_thickness_max = 400.0f;
  for (const MaterialSlot& s : material_slots) set_identity(d.*s.slot);
  return d;
}

void check_material(const sideray_material_desc& d) {
  for (const float c : d.base_color) require(c >= 0.0f && c <= 1e6f, "material base_color", double{c}, "0 to 1");
  check_unit(d.metallic, "material metallic");
  check_unit(d.roughness, "material roughness");
  check_unit(d.transmission, "material transmission");
  check_unit(d.specular, "material specular");
  check_unit(d.occlusion_strength, "material occlusion_strength");
  for (const float e : d.emissive)
    require(e >= 0.0f && e <= largest_factor, "material emissive", double{e}, "0 to 1e15");
  for (const float c : d.specular_color)
    require(c >= 0.0f && c <= largest_factor, "material specular_color", double{c}, "0 to 1e15");
  for (const float c : d.attenuation_color) check_unit(c, "material attenuation_color");
  check_unit(d.clearcoat, "material clearcoat");
  check_unit(d.clearcoat_roughness, "material clearcoat_roughness");
  check_unit(d.sheen_roughness, "material sheen_roughness");
  check_unit(d.diffuse_transmission, "material diffuse_transmission");
  for (const float c : d.sheen_color) check_unit(c, "material sheen_color");
  for (const float c : d.diffuse_transmission_color) check_unit(c, "material diffuse_transmission_color");
  check_unit(d.iridescence, "material iridescence");
  require(d.iridescence == 0.0f || (d.iridescence_ior >= 1.0f && d.iridescence_ior <= 1e6f), "material iridescence_ior",
          double{d.iridescence_ior}, "1 to 1e6");
  for (const float t : {d.iridescence_thickness_min, d.iridescence_thickness_max})
    require(t >= 0.0f && t <= 1e6f, "material iridescence_thickness", double{t}, "0 to 1e6 nanometres");
  check_unit(d.anisotropy, "material anisotropy");
  require(std::abs(d.anisotropy_rotation) <= largest_factor, "material anisotropy_rotation",
          double{d.anisotropy_rotation}, "radians, -1e15 to 1e15");
  require(std::abs(d.clearcoat_normal_scale) <= largest_factor, "material clearcoat_normal_scale",
          double{d.clearcoat_normal_scale}, "-1e15 to 1e15");
  require(d.ior >= 1.0f && d.ior <= 1e6f, "material ior", double{d.ior}, "1 to 1e6");
  require(d.dispersion >= 0.0f && d.dispersion <= 1e6f, "material dispersion", double{d.dispersion}, "0 to 1e6");
  require(d.thickness >= 0.0f && d.thickness <= largest_factor, "material thickness", double{d.thickness}, "0 to 1e15");
  require(d.attenuation_distance > 0.0f, "material attenuation_distance", double{d.attenuation_distance},
          "more than 0, or +inf");
  require(std::abs(d.normal_scale) <= largest_factor, "material normal_scale", double{d.normal_scale}, "-1e15 to 1e15");
  require(d.alpha_cutoff >= 0.0f && std::isfinite(d.alpha_cutoff), "material alpha_cutoff", double{d.alpha_cutoff},
          "0 or more");
  require(d.alpha_mode >= SIDERAY_OPAQUE && d.alpha_mode <= SIDERAY_BLEND, "material alpha_mode",
          static_cast<double>(d.alpha_mode), "a sideray_alpha_mode");
  require(d.blend_mode >= SIDERAY_BLEND_ALPHA && d.blend_mode <= SIDERAY_BLEND_MULTIPLY, "material blend_mode",
          static_cast<double>(d.blend_mode), "a sideray_blend_mode");
  require(d.distortion >= 0.0f && d.distortion <= 100.0f, "material distortion", double{d.distortion}, "0 to 100");
  for (const MaterialSlot& s : material_slots) check_slot(d.*s.slot, s.name);
}

void check_fixed_color(const float (&color)[3], const char* what) {
  for (const float c : color)
    if (!(c >= 0.0f && c <= largest_factor))
      fail(SIDERAY_INVALID_ARGUMENT, "{} holds {}: out of range; give 0 to 1e15", what, c);
}

void check_fixed_exponent(float exponent, const char* what) {
  if (!(exponent >= 0.0f && exponent <= 128.0f))
    fail(SIDERAY_INVALID_ARGUMENT, "{} is {}: out of range; give 0 to 128", what, exponent);
}

void check_fixed_material(const sideray_fixed_material& m) {
  check_fixed_color(m.ambient, "fixed material ambient");
  check_fixed_color(m.diffuse, "fixed material diffuse");
  check_fixed_color(m.specular, "fixed material specular");
  check_fixed_color(m.emission, "fixed material emission");
  check_fixed_exponent(m.shininess, "fixed material shininess");
  for (const float r : m.reflectance)
    if (!(r >= 0.0f && r <= 1.0f))
      fail(SIDERAY_INVALID_ARGUMENT, "fixed material reflectance holds {}: out of range; give 0 to 1", r);
  if (m.follows_color & ~15u)
    fail(SIDERAY_INVALID_ARGUMENT, "fixed material follows_color {:#x}: give SIDERAY_FOLLOW_*", m.follows_color);
  if (const auto e = static_cast<int>(m.environment); e < SIDERAY_ENVIRONMENT_MODULATE || e > SIDERAY_ENVIRONMENT_ADD)
    fail(SIDERAY_INVALID_ARGUMENT, "fixed material environment {}: give a sideray_texture_environment", e);
}

sideray_fixed_material fixed_material_of(const sideray_material_desc& desc) {
  sideray_fixed_material m{};
  for (int c = 0; c < 3; ++c) {
    m.ambient[c] = m.diffuse[c] = desc.base_color[c];
    m.emission[c] = desc.emissive[c];
  }
  return m;
}

void apply_fixed_material(const sideray_fixed_material& fixed, Material& material) {
  material.fixed = fixed;
  const bool textured = material.desc.base_color_texture.texture != 0;
  const bool replaces = textured && fixed.environment == SIDERAY_ENVIRONMENT_REPLACE;
  const bool decal = textured && fixed.environment == SIDERAY_ENVIRONMENT_DECAL;
  material.without_factor_alpha = replaces;
  material.without_vertex_alpha = replaces || (!material.desc.unlit && !(fixed.follows_color & SIDERAY_FOLLOW_DIFFUSE));
  material.without_texel_alpha = decal;
  if (!material.without_vertex_alpha && !material.desc.unlit) material.desc.base_color[3] = 1.0f;
  // Hits hold the vertices' colours in these textures' rows.
  material.desc.diffuse_transmission_texture.texture = material.desc.diffuse_transmission_color_texture.texture = 0;
}

bool is_translucent(const sideray_material_desc& d) {
  return d.alpha_mode == SIDERAY_BLEND || d.transmission > 0.0f;
}

bool tints_light(const Material& material, const Instance& instance) {
  return material.translucent && !material.desc.unlit && material.desc.blend_mode != SIDERAY_BLEND_ADDITIVE &&
         instance.sprites == 0 && instance.wind == 0 && (instance.visibility & SIDERAY_VISIBLE_SHADOW) != 0;
}

bool has_volume(const sideray_material_desc& d) {
  return d.transmission > 0.0f && d.thickness > 0.0f;
}

bool bends_light(const sideray_material_desc& d) {
  // Below this roughness a thin wall shows what is straight behind it, and stays one of several layers.
  constexpr float clear = 0.1f;
  if (has_volume(d)) return d.ior != 1.0f;
  return d.transmission > 0.0f && d.metallic < 1.0f && d.roughness > clear;
}

float lowest_alpha(const sideray_material_desc& d, const Texture* base_color) {
  return d.base_color[3] * (base_color ? static_cast<float>(base_color->minimum_alpha) / 255.0f : 1.0f);
}

Material make_material(const sideray_material_desc& d, const Texture* base_color, const Texture* metallic_roughness) {
  Material material{};
  material.desc = d;
  // Blend modes apply to BLEND; a transmissive material that is not BLEND composites as plain alpha with a = 1.
  if (d.alpha_mode != SIDERAY_BLEND) material.desc.blend_mode = SIDERAY_BLEND_ALPHA;
  material.translucent = is_translucent(d);
  material.cull_back = !d.double_sided;
  material.discards = can_discard(d, base_color);
  material.mirrors =
      !material.translucent && !d.unlit && lowest_roughness(d, metallic_roughness) <= most_mirrored_roughness;
  material.traceable = material.translucent && material.desc.blend_mode != SIDERAY_BLEND_MULTIPLY;
  return material;
}

float index_spread(const sideray_material_desc& d) {
  return 0.025f * (d.ior - 1.0f) * d.dispersion;
}

glm::vec3 absorption(const sideray_material_desc& d) {
  if (std::isinf(d.attenuation_distance)) return glm::vec3(0.0f);
  const glm::vec3 color(d.attenuation_color[0], d.attenuation_color[1], d.attenuation_color[2]);
  const glm::vec3 kept = glm::max(color, glm::vec3(1e-6f));
  return -glm::vec3(elementary::log(kept.x), elementary::log(kept.y), elementary::log(kept.z)) / d.attenuation_distance;
}

bool takes_inexact(const Material& material, uint32_t wind, sideray_inexact_target target) {
  if (material.translucent) return false;
  if (target == SIDERAY_TARGET_MODEL)
    return material.desc.double_sided &&
           (material.desc.alpha_mode == SIDERAY_MASK || material.desc.diffuse_transmission > 0.0f);
  return material.desc.inexact_shadow || wind != 0;
}

}  // namespace sideray::model
