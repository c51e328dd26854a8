// Makes surfaces of hits, a part of rt/surfaces/shade_lanes.cpp. Each step does what surface_point() does, operation by
// operation, so the bits are the same.
#pragma once

#include "elementary/functions.h"
#include "rt/surfaces/image_lanes.h"
#include "rt/surfaces/patch_lanes.h"
#include "rt/surfaces/texture_lanes.h"

namespace sideray::rt::SIDERAY_LANES {

// Holds textures' values and vertex colours of hits. `any` false: nothing was written.
struct alignas(64) TexelBlock {
  BlockRow rows[texel_rows];
  bool any;
};

SIDERAY_LANE void clear_texels(TexelBlock& texels) {
  for (uint32_t r = 0; r < texel_rows; ++r) {
    const bool tangent_plane = (r >= row_normal && (r - row_normal) % 3 != 2) || r == row_anisotropy_across;
    for (int at = 0; at < static_cast<int>(block_size); at += lane_count)
      store(texels.rows[r] + at, real(tangent_plane ? 0.0f : 1.0f));
  }
}

SIDERAY_LANE SrTexels load_texels(const TexelBlock& texels, int at) {
  SurfaceReader r{texels.rows, at};
  SrTexels t;
  t.base_color = r.four(), t.emissive = r.three(), t.metallic = r.one(), t.roughness = r.one();
  t.occlusion = r.one(), t.transmission = r.one(), t.thickness = r.one(), t.specular = r.one();
  t.specular_color = r.three(), t.clearcoat = r.one(), t.clearcoat_roughness = r.one();
  t.sheen_color = r.three(), t.sheen_roughness = r.one();
  t.diffuse_transmission = r.one(), t.diffuse_transmission_color = r.three();
  t.iridescence = r.one(), t.iridescence_thickness = r.one();
  t.anisotropy_along = r.one(), t.anisotropy_across = r.one(), t.anisotropy = r.one();
  return t;
}

SIDERAY_LANE SrTexels no_texels() {
  const real one(1.0f);
  const real3 ones(one, one, one);
  return {real4(one, one, one, one),
          ones,
          one,
          one,
          one,
          one,
          one,
          one,
          ones,
          one,
          one,
          ones,
          one,
          one,
          ones,
          one,
          one,
          one,
          real(0.0f),
          one};
}

struct alignas(64) MaterialBlock {
  BlockRow rows[MaterialRecord::rows];
  const BlockRow& perturbs() const { return rows[MaterialRecord::words]; }
  const BlockRow& normal_scale() const { return rows[MaterialRecord::words + 1]; }
  const BlockRow& coat_normal_scale() const { return rows[MaterialRecord::words + 2]; }
};
static_assert(MaterialRecord::rows * sizeof(float) <= sizeof(MaterialRecord));

SIDERAY_LANE SrMaterial load_material(const MaterialBlock& material, int at) {
  SurfaceReader r{material.rows, at};
  SrMaterial m;
  m.base_color = r.four(), m.emissive = r.three(), m.specular_color = r.three(), m.absorption = r.three();
  m.metallic = r.one(), m.roughness = r.one(), m.transmission = r.one(), m.ior = r.one(), m.thickness = r.one();
  m.specular = r.one(), m.clearcoat = r.one(), m.clearcoat_roughness = r.one();
  m.sheen_color = r.three(), m.sheen_roughness = r.one();
  m.diffuse_transmission = r.one(), m.diffuse_transmission_color = r.three();
  m.iridescence = r.one(), m.iridescence_ior = r.one();
  m.iridescence_thickness_min = r.one(), m.iridescence_thickness_max = r.one();
  m.anisotropy = r.one(), m.anisotropy_cosine = r.one(), m.anisotropy_sine = r.one();
  m.alpha_mode = integer(as_int(r.one().v));
  m.unlit = boolean{as_int(r.one().v)};
  return m;
}

// Computes the transmittance of volumes, with the same exponential as for single hits.
SIDERAY_LANE void fill_volumes(const MaterialBlock& material, const BlockRow* thickness, const BlockRow& leaves,
                               uint32_t absorbing, BlockRow (&volume)[3]) {
  for (int c = 0; c < 3; ++c)
    for (int at = 0; at < static_cast<int>(block_size); at += lane_count) store(volume[c] + at, real(1.0f));
  constexpr uint32_t row_absorption = 10, row_of_thickness = 17;
  for (; absorbing != 0; absorbing &= absorbing - 1) {
    const auto i = static_cast<uint32_t>(__builtin_ctz(absorbing));
    const float depth = material.rows[row_of_thickness][i] * (leaves[i] > 0.0f ? 0.0f
                                                              : thickness      ? (*thickness)[i]
                                                                               : 1.0f);
    if (!(depth > 0.0f)) continue;
    for (uint32_t c = 0; c < 3; ++c) volume[c][i] = elementary::exp(-material.rows[row_absorption + c][i] * depth);
  }
}

// Stores everything that sr_seen() does not fill.
SIDERAY_LANE void store_surface(const SrSurface& s, SurfaceBlock& block, int at) {
  BlockRow* row = block.surface;
  const auto one = [&](real v) { store(*row++ + at, v); };
  const auto three = [&](real3 v) { one(v.x), one(v.y), one(v.z); };
  three(s.normal), three(s.albedo), one(s.metallic);
  three(s.diffuse), three(s.behind), three(s.f0), three(s.f90), three(s.emissive);
  three(s.tint), one(s.alpha), one(s.roughness), one(s.occlusion);
  one(s.coat), one(s.coat_roughness), three(s.coat_normal);
  three(s.sheen), one(s.sheen_roughness);
  three(s.along), one(s.anisotropy);
}

// Returns the coordinate of x in model::AlbedoTable, whose ends are texel centres.
SIDERAY_LANE real place_in_table(real x, float size) {
  return (x * (size - 1.0f) + 0.5f) * (1.0f / size);
}

SIDERAY_LANE real3 albedos(TexelView table, real n_v, real roughness) {
  const auto size = static_cast<float>(table.width);
  return sample(table, clamped_pair(place_in_table(n_v, size), table.width),
                clamped_pair(place_in_table(roughness, size), table.height));
}

SIDERAY_LANE real sheen_albedo(const SrSurface& s, real n_v, TexelView table) {
  const boolean sheen = largest(s.sheen) > 0.0f;
  if (!sr_any(sheen)) return real(0.0f);
  return sr_select(sheen, albedos(table, n_v, s.sheen_roughness).z, real(0.0f));
}

// Stores what sr_seen() changes.
SIDERAY_LANE void store_seen(const SrSurface& s, real3 to_eye, TexelView table, SurfaceBlock& block, int at) {
  const real n_v = abs(dot(s.normal, to_eye));
  const bool brushed = sr_any(s.anisotropy > 0.0f);
  const real roughness = brushed ? sr_round_roughness(s) : s.roughness;
  const real3 found = albedos(table, n_v, roughness);
  real2 terms(found.x, found.y);
  if (brushed) {
    const real3 masked = albedos(table, sr_round_cosine(s, to_eye), roughness);
    terms = sr_brushed_terms(s, terms, real2(masked.x, masked.y));
  }
  const SrSurface seen = sr_seen(s, to_eye, terms, sheen_albedo(s, n_v, table));
  constexpr int row_of_f0 = 13, row_of_coat_share = 41;
  const real from_f0[] = {seen.f0.x, seen.f0.y, seen.f0.z, seen.f90.x, seen.f90.y, seen.f90.z};
  for (int i = 0; i < 6; ++i) store(block.surface[row_of_f0 + i] + at, from_f0[i]);
  const real rest[] = {seen.coat_share, seen.below_sheen, seen.sheen_albedo, terms.x, terms.y};
  for (int i = 0; i < 5; ++i) store(block.surface[row_of_coat_share + i] + at, rest[i]);
}

SIDERAY_LANE real4 tangent_of(const PatchBlock& patches, int at) {
  const real3 along = load3(patches.tangent, at);
  const real squared = dot(along, along);
  const boolean framed = squared > 1e-24f;
  const real3 unit = along * (1.0f / sqrt(squared));
  const real zero(0.0f);
  return {sr_select(framed, unit.x, zero), sr_select(framed, unit.y, zero), sr_select(framed, unit.z, zero),
          sr_select(framed, load(patches.sign + at), zero)};
}

// Perturbs a normal by a map, if the material has normal maps.
SIDERAY_LANE real3 perturbed(real3 normal, real4 tangent, const BlockRow (&map)[3], const BlockRow& scale,
                             boolean perturbs, int at) {
  return sr_select(perturbs, sr_perturb(normal, tangent, load3(map, at), load(scale + at)), normal);
}

struct HitReads {
  uint32_t textured, absorbing, colored, perturbed;  // bits of hits
};

SIDERAY_LANE HitReads gather_hits(const SurfaceTables& tables, const HitBlock& hits, PatchBlock& patches,
                                  MaterialBlock& materials) {
  alignas(64) Patch patch[block_size];
  const float *patch_words[block_size], *material_words[block_size];
  HitReads reads{0, 0, 0, 0};
  for (uint32_t i = 0; i < block_size; ++i)
    __builtin_prefetch(tables.instances[hits.instance[i]].triangles + uint64_t{3} * hits.primitive[i]);
  for (uint32_t i = 0; i < block_size; ++i) fetch_vertices(tables, hits, i);
  for (uint32_t i = 0; i < block_size; ++i) {
    const InstanceRecord& in = tables.instances[hits.instance[i]];
    const MaterialRecord& material = tables.materials[in.material];
    const bool perturbs = material.perturbs > 0.0f;
    patch[i] = patch_of(in, corners_of(tables, hits, i), hits.front[i] > 0.0f, material.framed > 0.0f);
    patch_words[i] = reinterpret_cast<const float*>(&patch[i]);
    material_words[i] = material.shading;
    reads.textured |= static_cast<uint32_t>(material.reads > 0) << i;
    reads.absorbing |= static_cast<uint32_t>(material.absorbs > 0.0f) << i;
    reads.colored |= static_cast<uint32_t>(in.colors != nullptr) << i;
    reads.perturbed |= static_cast<uint32_t>(perturbs) << i;
  }
  transpose(patch_words, PatchBlock::rows, patches.edge1);
  transpose(material_words, MaterialRecord::rows, materials.rows);
  return reads;
}

SIDERAY_LANE void read_block(const SurfaceTables& tables, const HitBlock& hits, const HitReads& reads,
                             const BlockRow (&footprint)[4], TexelBlock& texels) {
  texels.any = (reads.textured | reads.colored) != 0;
  if (!texels.any) return;
  clear_texels(texels);
  SampleList lists[2];
  lists[0].srgb = nullptr;
  lists[1].srgb = tables.srgb;
  alignas(16) float places[block_size][2][8];
  for (uint32_t bits = reads.textured; bits != 0; bits &= bits - 1) {
    const auto i = static_cast<uint32_t>(__builtin_ctz(bits));
    const InstanceRecord& in = tables.instances[hits.instance[i]];
    const MaterialRecord& material = tables.materials[in.material];
    uint32_t known = 0;
    for (uint32_t r = 0; r < material.reads; ++r) {
      const ReadRecord& read = tables.reads[material.first_read + r];
      if (!(known >> read.uv_set & 1u))
        coordinates(in.uv[read.uv_set], corners_of(tables, hits, i), places[i][read.uv_set]);
      known |= 1u << read.uv_set;
      SampleList& list = lists[read.srgb];
      list.samples[list.count++] = {&read, places[i][read.uv_set], i};
      if (list.count == block_size) make_look_ups(tables, footprint, list, texels.rows);
    }
  }
  for (SampleList& list : lists) make_look_ups(tables, footprint, list, texels.rows);
  for (uint32_t bits = reads.colored; bits != 0; bits &= bits - 1) {
    const auto i = static_cast<uint32_t>(__builtin_ctz(bits));
    const Four color = corners_of(tables, hits, i).weigh(tables.instances[hits.instance[i]].colors, 4);
    // The fixed function uses texture and vertex colour separately.
    constexpr uint32_t apart[] = {row_diffuse_transmission_color, row_diffuse_transmission_color + 1,
                                  row_diffuse_transmission_color + 2, row_diffuse_transmission};
    for (uint32_t k = 0; k < 4; ++k)
      if (tables.fixed)
        texels.rows[apart[k]][i] = color[k];
      else
        texels.rows[row_base_color + k][i] *= color[k];
  }
}

SIDERAY_LANE SrFixedMaterial load_fixed(const BlockRow* rows, int at) {
  SurfaceReader r{rows, at};
  SrFixedMaterial m;
  m.color = r.four(), m.ambient = r.three(), m.diffuse = r.three(), m.specular = r.three(), m.emission = r.three();
  m.reflectance = r.three(), m.fresnel = r.one(), m.shininess = r.one(), m.lit = r.one();
  m.ambient_follows = r.one(), m.diffuse_follows = r.one(), m.specular_follows = r.one(), m.emission_follows = r.one();
  m.of_none = r.one(), m.of_texel = r.one(), m.of_alpha = r.one(), m.adds = r.one(), m.adds_alpha = r.one();
  m.replaces_alpha = r.one(), m.modulates_alpha = r.one(), m.bends = r.one();
  return m;
}

// Replaces the surfaces of a block by fixed-function ones.
void fix_surfaces(const SurfaceTables& tables, const HitBlock& hits, const MaterialBlock& materials,
                  const TexelBlock& texels, SurfaceBlock& block) {
  alignas(64) BlockRow rows[FixedRecord::words];
  const float* words[block_size];
  for (uint32_t i = 0; i < block_size; ++i)
    words[i] = tables.fixed[tables.instances[hits.instance[i]].material].shading;
  transpose(words, FixedRecord::words, rows);
  const FixedModelTerms& terms = tables.model;
  const SrFixedModel model = {{terms.ambient[0], terms.ambient[1], terms.ambient[2]}, terms.two_sided, terms.separate};
  for (int at = 0; at < static_cast<int>(block_size); at += lane_count) {
    SrTexels t = no_texels();
    if (texels.any) t = load_texels(texels, at);
    const real3 color = t.diffuse_transmission_color;
    const SrSurface s = sr_fixed_surface(
        load_surface(block, at), load_fixed(rows, at), model, t.base_color,
        real4(color.x, color.y, color.z, t.diffuse_transmission), load(hits.front + at) > 0.0f,
        load_material(materials, at).alpha_mode == 2, load3(block.to_eye, at));
    store_surface(s, block, at);
    constexpr int row_of_coat_share = 41;
    const real rest[] = {s.coat_share, s.below_sheen, s.sheen_albedo, s.albedo_terms.x, s.albedo_terms.y};
    for (int i = 0; i < 5; ++i) store(block.surface[row_of_coat_share + i] + at, rest[i]);
  }
}

// Sets where the hits are, how they lie, and their `smooth` normals.
void place_hits(const PatchBlock& patches, const HitBlock& hits, BlockRow (&smooth)[3], SurfaceBlock& block) {
  for (int at = 0; at < static_cast<int>(block_size); at += lane_count) {
    const real3 normal = cross(load3(patches.edge1, at), load3(patches.edge2, at));
    const boolean mirrored = load(patches.mirrored + at) > 0.0f, front = load(hits.front + at) > 0.0f;
    const real3 unit = unit_or(sr_select(mirrored, -normal, normal), real3(real(0.0f), real(1.0f), real(0.0f)));
    store3(smooth, at, unit_or(load3(patches.normal, at), unit));
    store3(block.geometric_normal, at, sr_select(front, unit, -unit));
    store3(block.to_eye, at, -load3(hits.direction, at));
    store3(block.position, at, load3(patches.position, at));
    store(block.offset + at, load(patches.largest + at) * share_of_rounding);
  }
}

void surfaces_of_hits(const SurfaceTables& tables, const HitBlock& hits, SurfaceBlock& block) {
  PatchBlock patches;
  MaterialBlock materials;
  TexelBlock texels;
  alignas(64) BlockRow footprint[4], smooth[3], volume[3];
  const HitReads reads = gather_hits(tables, hits, patches, materials);
  place_hits(patches, hits, smooth, block);
  for (int at = 0; reads.textured != 0 && at < static_cast<int>(block_size); at += lane_count)
    store_footprint(patches, hits, footprint, at);
  read_block(tables, hits, reads, footprint, texels);
  fill_volumes(materials, texels.any ? &texels.rows[row_thickness] : nullptr, patches.leaves, reads.absorbing, volume);
  for (int at = 0; at < static_cast<int>(block_size); at += lane_count) {
    const boolean front = load(hits.front + at) > 0.0f;
    real3 normal = load3(smooth, at), coat_normal = normal;
    SrTexels t = no_texels();
    if (texels.any) t = load_texels(texels, at);
    if (reads.perturbed != 0) {
      const boolean perturbs = load(materials.perturbs() + at) > 0.0f;
      const BlockRow(&maps)[texel_rows] = texels.rows;
      const real4 tangent = tangent_of(patches, at);
      normal = perturbed(normal, tangent, reinterpret_cast<const BlockRow(&)[3]>(maps[row_normal]),
                         materials.normal_scale(), perturbs, at);
      coat_normal = perturbed(coat_normal, tangent, reinterpret_cast<const BlockRow(&)[3]>(maps[row_coat_normal]),
                              materials.coat_normal_scale(), perturbs, at);
    }
    const SrMaterial m = load_material(materials, at);
    t.thickness = real(0.0f);
    const real3 to_eye = load3(block.to_eye, at);
    // The normals are turned toward the eye first; sr_facing() would copy the whole surface to do so.
    SrSurface s = sr_surface(m, t, sr_toward_eye(sr_select(front, normal, -normal), to_eye),
                             sr_toward_eye(sr_select(front, coat_normal, -coat_normal), to_eye));
    // This sr_surface() computes no volume, because its exponential differs from that of single hits.
    const real transmission = sr_saturate(m.transmission * t.transmission) * (1.0f - s.metallic);
    s.tint = sr_times(s.albedo, load3(volume, at)) * transmission;
    if (sr_any(m.anisotropy > 0.0f)) s = sr_brushed(s, m, t, load3(smooth, at), tangent_of(patches, at));
    if (sr_any(m.iridescence > 0.0f)) s = sr_filmed(s, m, t, to_eye);
    store_surface(s, block, at);
    store_seen(s, to_eye, tables.albedo, block, at);
  }
  if (tables.fixed) fix_surfaces(tables, hits, materials, texels, block);
}

}  // namespace sideray::rt::SIDERAY_LANES
