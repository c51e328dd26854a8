#include "rt/textures/surface_textures.h"

#include <algorithm>
#include <array>

#include "rt/textures/texture_sample.h"

namespace sideray::rt {
namespace {

using model::material_slot_count;
using model::material_slots;
using shading::SrTexels;

using Slot = sideray_texture_slot sideray_material_desc::*;

constexpr uint32_t number(Slot slot) {
  for (uint32_t i = 0; i < material_slot_count; ++i)
    if (material_slots[i].slot == slot) return i;
  return material_slot_count;
}

bool zero(const float (&v)[3]) {
  return v[0] == 0.0f && v[1] == 0.0f && v[2] == 0.0f;
}

// Returns whether the value that the slot's texture scales or perturbs has any effect.
bool counts(const sideray_material_desc& d, uint32_t slot) {
  using D = sideray_material_desc;
  switch (slot) {
    case number(&D::emissive_texture):
      return !zero(d.emissive);
    case number(&D::transmission_texture):
      return d.transmission != 0.0f;
    case number(&D::thickness_texture):
      return d.transmission != 0.0f && d.thickness != 0.0f;
    case number(&D::specular_texture):
    case number(&D::specular_color_texture):
      return d.specular != 0.0f;
    case number(&D::clearcoat_texture):
    case number(&D::clearcoat_roughness_texture):
    case number(&D::clearcoat_normal_texture):
      return d.clearcoat != 0.0f;
    case number(&D::sheen_color_texture):
    case number(&D::sheen_roughness_texture):
      return !zero(d.sheen_color);
    case number(&D::diffuse_transmission_texture):
    case number(&D::diffuse_transmission_color_texture):
      return d.diffuse_transmission != 0.0f;
    case number(&D::iridescence_texture):
    case number(&D::iridescence_thickness_texture):
      return d.iridescence != 0.0f;
    case number(&D::anisotropy_texture):
      return d.anisotropy != 0.0f;
    default:
      return true;
  }
}

bool same_place(const sideray_texture_slot& a, const sideray_texture_slot& b) {
  return a.texture == b.texture && a.uv_set == b.uv_set && a.wrap_u == b.wrap_u && a.wrap_v == b.wrap_v &&
         a.filter == b.filter && std::ranges::equal(a.texture_from_uv, b.texture_from_uv);
}

void take(TextureValues& v, uint32_t slot, glm::vec4 value, float occlusion_strength) {
  using D = sideray_material_desc;
  SrTexels& t = v.texels;
  switch (slot) {
    case number(&D::base_color_texture): t.base_color = value; break;
    case number(&D::metallic_roughness_texture): t.roughness = value.y; t.metallic = value.z; break;
    case number(&D::normal_texture): v.normal = glm::vec3(value) * 2.0f - 1.0f; break;
    case number(&D::occlusion_texture): t.occlusion = 1.0f + occlusion_strength * (value.x - 1.0f); break;
    case number(&D::emissive_texture): t.emissive = glm::vec3(value); break;
    case number(&D::transmission_texture): t.transmission = value.x; break;
    case number(&D::thickness_texture): t.thickness = value.y; break;
    case number(&D::specular_texture): t.specular = value.w; break;
    case number(&D::specular_color_texture): t.specular_color = glm::vec3(value); break;
    case number(&D::clearcoat_texture): t.clearcoat = value.x; break;
    case number(&D::clearcoat_roughness_texture): t.clearcoat_roughness = value.y; break;
    case number(&D::clearcoat_normal_texture): v.coat_normal = glm::vec3(value) * 2.0f - 1.0f; break;
    case number(&D::sheen_color_texture): t.sheen_color = glm::vec3(value); break;
    case number(&D::sheen_roughness_texture): t.sheen_roughness = value.w; break;
    case number(&D::diffuse_transmission_texture): t.diffuse_transmission = value.w; break;
    case number(&D::diffuse_transmission_color_texture): t.diffuse_transmission_color = glm::vec3(value); break;
    case number(&D::iridescence_texture): t.iridescence = value.x; break;
    case number(&D::iridescence_thickness_texture): t.iridescence_thickness = value.y; break;
    case number(&D::anisotropy_texture):
      t.anisotropy_along = value.x * 2.0f - 1.0f;
      t.anisotropy_across = value.y * 2.0f - 1.0f;
      t.anisotropy = value.z;
      break;
  }
}

struct Coordinates {
  glm::vec2 at, edge1, edge2;
};

Coordinates coordinates(const std::vector<glm::vec2>& uv, const TexturePlace& p) {
  const glm::vec2 u0 = uv[p.triangle.x], u1 = uv[p.triangle.y], u2 = uv[p.triangle.z];
  return {u0 * p.weights.x + u1 * p.weights.y + u2 * p.weights.z, u1 - u0, u2 - u0};
}

}  // namespace

std::vector<TextureRead> texture_reads(const model::Snapshot& snapshot, const sideray_material_desc& material) {
  std::vector<TextureRead> reads;
  for (uint32_t i = 0; i < material_slot_count; ++i) {
    const sideray_texture_slot& slot = material.*material_slots[i].slot;
    if (slot.texture == 0 || !counts(material, i)) continue;
    const model::Texture& texture = *snapshot.textures[slot.texture - 1];
    const auto same = std::ranges::find_if(reads, [&](const TextureRead& r) { return same_place(*r.place, slot); });
    reads.push_back({&texture, &slot, i, static_cast<uint32_t>(same - reads.begin())});
  }
  return reads;
}

TextureValues read_textures(std::span<const TextureRead> reads, const TexturePlace& place, float occlusion_strength) {
  TextureValues values = no_textures;
  std::array<Coordinates, 2> uv{};
  bool known[2] = {false, false};
  std::array<glm::vec4, material_slot_count> read;
  for (size_t i = 0; i < reads.size(); ++i) {
    const TextureRead& r = reads[i];
    if (r.same_as != i) {
      read[i] = read[r.same_as];
    } else {
      const size_t set = r.place->uv_set == 0 ? 0 : 1;
      if (!known[set]) {
        uv[set] = coordinates(set == 0 ? place.mesh.uv0 : place.mesh.uv1, place);
        known[set] = true;
      }
      const bool leveled = r.place->filter == SIDERAY_TRILINEAR && r.texture->levels.size() > 1;
      const Coordinates& c = uv[set];
      read[i] = sample(*r.texture, *r.place, c.at,
                       leveled ? texture_level(place.footprint, c.edge1, c.edge2, *r.place, *r.texture) : 0.0f);
    }
    take(values, r.slot, read[i], occlusion_strength);
  }
  return values;
}

}  // namespace sideray::rt
