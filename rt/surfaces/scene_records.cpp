#include "rt/surfaces/scene_records.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstring>

#include "model/material_slots.h"
#include "rt/textures/texture_sample.h"

namespace sideray::rt {
namespace {

using shading::SrMaterial;
using shading::SrTexels;

static_assert(offsetof(SrMaterial, alpha_mode) == (MaterialRecord::words - 2) * sizeof(float));
static_assert(offsetof(SrMaterial, unlit) == (MaterialRecord::words - 1) * sizeof(float));
static_assert(offsetof(SrMaterial, absorption) == 10 * sizeof(float) &&
              offsetof(SrMaterial, thickness) == 17 * sizeof(float));
static_assert(sizeof(SrTexels) == row_normal * sizeof(float));
static_assert(offsetof(SrTexels, occlusion) == row_occlusion * sizeof(float) &&
              offsetof(SrTexels, thickness) == row_thickness * sizeof(float) &&
              offsetof(SrTexels, clearcoat) == row_clearcoat * sizeof(float) &&
              offsetof(SrTexels, sheen_roughness) == row_sheen_roughness * sizeof(float) &&
              offsetof(SrTexels, diffuse_transmission_color) == row_diffuse_transmission_color * sizeof(float) &&
              offsetof(SrTexels, iridescence_thickness) == row_iridescence_thickness * sizeof(float) &&
              offsetof(SrTexels, anisotropy) == row_anisotropy * sizeof(float));

using Use = OutputRecord::Use;

// Maps channels of a slot's texture to rows, in the order of model::material_slots.
struct Target {
  uint8_t first_channel, channels, row;
  Use use = Use::plain;
  bool down = false;  // rows decrease as channels increase
};

constexpr std::array<Target, model::material_slot_count> targets{{
    {0, 4, row_base_color},
    {1, 2, row_roughness, Use::plain, true},  // G roughness, B metallic
    {0, 3, row_normal, Use::normal},
    {0, 1, row_occlusion, Use::occlusion},
    {0, 3, row_emissive},
    {0, 1, row_transmission},
    {1, 1, row_thickness},
    {3, 1, row_specular},
    {0, 3, row_specular_color},
    {0, 1, row_clearcoat},
    {1, 1, row_clearcoat_roughness},
    {0, 3, row_coat_normal, Use::normal},
    {0, 3, row_sheen_color},
    {3, 1, row_sheen_roughness},
    {3, 1, row_diffuse_transmission},
    {0, 3, row_diffuse_transmission_color},
    {0, 1, row_iridescence},
    {1, 1, row_iridescence_thickness},
    {0, 3, row_anisotropy_along, Use::normal},  // R and G; B is the strength
}};
static_assert(row_metallic + 1 == row_roughness);

ReadRecord::Wrap wrap_of(sideray_wrap wrap) {
  if (wrap == SIDERAY_CLAMP) return ReadRecord::clamp;
  return wrap == SIDERAY_MIRROR ? ReadRecord::mirror : ReadRecord::repeat;
}

InstanceRecord instance_record(const model::Instance& instance, const model::Mesh& mesh) {
  InstanceRecord r{};
  for (int c = 0; c < 4; ++c)
    for (int k = 0; k < 3; ++k) r.columns[c][k] = instance.local_from_object[c][k];
  for (int c = 0; c < 3; ++c)
    for (int k = 0; k < 3; ++k) r.normal_columns[c][k] = instance.normal_from_object[c][k];
  if (mesh.triangles.empty()) return r;
  r.triangles = &mesh.triangles[0].x;
  r.positions = &mesh.positions[0].x;
  r.normals = &mesh.normals[0].x;
  if (mesh.has_tangents) r.tangents = &mesh.tangents[0].x;
  if (mesh.has_colors) r.colors = &mesh.colors[0].x;
  r.uv[0] = &mesh.uv0[0].x;
  r.uv[1] = &mesh.uv1[0].x;
  r.material = instance.material;
  r.mirrored = instance.mirrored;
  r.solid = instance.solid;
  r.sprites = instance.sprites != 0;
  return r;
}

MaterialRecord material_record(const SrMaterial& m, const sideray_material_desc& desc,
                               std::span<const TextureRead> reads) {
  MaterialRecord r{};
  std::memcpy(r.shading, &m, (MaterialRecord::words - 2) * sizeof(float));
  r.shading[MaterialRecord::words - 2] = std::bit_cast<float>(m.alpha_mode);
  r.shading[MaterialRecord::words - 1] = std::bit_cast<float>(m.unlit ? -1 : 0);
  const bool maps = desc.normal_texture.texture != 0 || desc.clearcoat_normal_texture.texture != 0;
  r.perturbs = !reads.empty() && maps ? 1.0f : 0.0f;
  r.normal_scale = desc.normal_scale;
  r.coat_normal_scale = desc.clearcoat_normal_scale;
  r.framed = r.perturbs > 0.0f || m.anisotropy > 0.0f ? 1.0f : 0.0f;
  r.absorbs = m.thickness > 0.0f && m.absorption != glm::vec3(0.0f) ? 1.0f : 0.0f;
  return r;
}

// Returns the words of a fixed-function material. An absent texture changes nothing.
FixedRecord fixed_record(const shading::SrFixedMaterial& m) {
  FixedRecord r{};
  static_assert(sizeof(m) <= sizeof(r.shading) && sizeof(m) + 4 * sizeof(float) > sizeof(r.shading));
  std::memcpy(r.shading, &m, sizeof(m));
  return r;
}

ReadRecord read_record(const TextureRead& read, const LevelRecord* levels) {
  const sideray_texture_slot& slot = *read.place;
  ReadRecord r{};
  std::ranges::copy(slot.texture_from_uv, r.map);
  r.width = static_cast<float>(levels->width);
  r.height = static_cast<float>(levels->height);
  r.levels = levels;
  r.level_count = static_cast<uint32_t>(read.texture->levels.size());
  r.wrap[0] = wrap_of(slot.wrap_u);
  r.wrap[1] = wrap_of(slot.wrap_v);
  r.srgb = read.texture->srgb;
  r.nearest = slot.filter == SIDERAY_NEAREST;
  r.leveled = slot.filter == SIDERAY_TRILINEAR && r.level_count > 1;
  r.uv_set = slot.uv_set == 0 ? 0 : 1;
  return r;
}

void add_outputs(uint32_t slot, float occlusion_strength, std::vector<OutputRecord>& outputs) {
  const Target& t = targets[slot];
  for (uint8_t k = 0; k < t.channels; ++k) {
    const auto row = static_cast<uint8_t>(t.down ? t.row - k : t.row + k);
    outputs.push_back({static_cast<uint8_t>(t.first_channel + k), row, row == row_anisotropy ? Use::plain : t.use,
                       occlusion_strength});
  }
}

// Appends a material's texture reads; their outputs are consecutive.
uint32_t add_reads(std::span<const TextureRead> reads, float occlusion_strength, SceneRecords& records) {
  uint32_t added = 0;
  for (uint32_t i = 0; i < reads.size(); ++i) {
    if (reads[i].same_as != i) continue;
    const LevelRecord* levels = records.levels.data() + records.levels.size();
    for (const model::Texture::Level& l : reads[i].texture->levels)
      records.levels.push_back({l.rgba.data(), static_cast<int32_t>(l.width), static_cast<int32_t>(l.height)});
    ReadRecord r = read_record(reads[i], levels);
    r.first_output = static_cast<uint32_t>(records.outputs.size());
    for (const TextureRead& other : reads)
      if (other.same_as == i) add_outputs(other.slot, occlusion_strength, records.outputs);
    r.outputs = static_cast<uint32_t>(records.outputs.size()) - r.first_output;
    records.reads.push_back(r);
    ++added;
  }
  return added;
}

FixedModelTerms fixed_model_terms(const model::FixedFunction& f) {
  return {{f.ambient.x, f.ambient.y, f.ambient.z}, f.two_sided ? 1.0f : 0.0f, f.separate_specular ? 1.0f : 0.0f};
}

}  // namespace

SurfaceTables SceneRecords::tables() const {
  const auto size = static_cast<int32_t>(model::AlbedoTable::size);
  return {instances.data(), materials.data(),    reads.data(),
          outputs.data(),   srgb_decode_table(), {&model::albedo_table().values[0].x, size, size},
          fixed.empty() ? nullptr : fixed.data(), model};
}

SceneRecords make_records(const model::Snapshot& snapshot, std::span<const SrMaterial> materials,
                          std::span<const shading::SrFixedMaterial> fixed,
                          std::span<const std::vector<TextureRead>> textures) {
  SceneRecords r;
  for (const shading::SrFixedMaterial& m : fixed) r.fixed.push_back(fixed_record(m));
  if (snapshot.fixed) r.model = fixed_model_terms(*snapshot.fixed);
  r.instances.reserve(snapshot.instances.size() + snapshot.thin.size());
  for (const std::vector<model::Instance>* instances : {&snapshot.instances, &snapshot.thin})
    for (const model::Instance& i : *instances) r.instances.push_back(instance_record(i, *snapshot.meshes[i.mesh]));
  r.sprites = std::ranges::any_of(r.instances, [](const InstanceRecord& i) { return i.sprites; });
  size_t level_count = 0;
  for (const std::vector<TextureRead>& reads : textures)
    for (const TextureRead& read : reads) level_count += read.texture->levels.size();
  r.levels.reserve(level_count);  // no reallocation: records point into it
  for (size_t m = 0; m < materials.size(); ++m) {
    const sideray_material_desc& desc = snapshot.materials[m].desc;
    r.materials.push_back(material_record(materials[m], desc, textures[m]));
    r.materials.back().first_read = static_cast<uint32_t>(r.reads.size());
    r.materials.back().reads = add_reads(textures[m], desc.occlusion_strength, r);
  }
  return r;
}

}  // namespace sideray::rt
