#include "rt/surfaces/surface_batch.h"

#include <algorithm>
#include <cstddef>

#include "rt/surfaces/sprite_surface.h"
#include "rt/textures/environment_lookup.h"

namespace sideray::rt {
namespace {

// The blocks' rows are the points' numbers, in the same order.
using shading::SrSurface;
static_assert(sizeof(SrSurface) == SurfaceBlock::surface_rows * sizeof(float));
static_assert(offsetof(SurfacePoint, surface) == 0);
static_assert(offsetof(SurfacePoint, position) * block_size == offsetof(SurfaceBlock, position));
static_assert(offsetof(SurfacePoint, geometric_normal) * block_size == offsetof(SurfaceBlock, geometric_normal));
static_assert(offsetof(SurfacePoint, to_eye) * block_size == offsetof(SurfaceBlock, to_eye));
static_assert(offsetof(SurfacePoint, offset) * block_size == offsetof(SurfaceBlock, offset));
static_assert(sizeof(SurfacePoint) * block_size >= sizeof(SurfaceBlock));
static_assert(offsetof(SrSurface, albedo) == 3 * sizeof(float) && offsetof(SrSurface, diffuse) == 7 * sizeof(float) &&
              offsetof(SrSurface, tint) == 22 * sizeof(float) && offsetof(SrSurface, coat) == 28 * sizeof(float) &&
              offsetof(SrSurface, coat_normal) == 30 * sizeof(float) &&
              offsetof(SrSurface, sheen_albedo) == 39 * sizeof(float));

constexpr uint32_t surface_words = sizeof(SurfaceBlock) / sizeof(BlockRow) - 2;  // without those that pad

TexelView view(const model::Environment::Image& image) {
  return {&image.texels[0].x, static_cast<int32_t>(image.width), static_cast<int32_t>(image.height)};
}

LightTerms terms(const shading::SrLight& l) {
  return {{l.position.x, l.position.y, l.position.z},
          {l.direction.x, l.direction.y, l.direction.z},
          {l.intensity.x, l.intensity.y, l.intensity.z},
          l.range,
          l.cos_inner,
          l.cos_outer,
          l.type};
}

void place_hit(const HitPlace& place, HitBlock& block, size_t lane) {
  const Hit& hit = *place.hit;
  block.u[lane] = hit.u;
  block.v[lane] = hit.v;
  set_vector(block.direction, lane, place.ray->direction);
  block.width[lane] = place.cone.width + place.cone.spread * static_cast<float>(hit.distance);
  block.front[lane] = hit.front ? 1.0f : 0.0f;
  block.instance[lane] = hit.instance;
  block.primitive[lane] = hit.primitive;
}

bool is_sprite(const ShadingScene& scene, const HitPlace& place) {
  return scene.records.instances[place.hit->instance].sprites;
}

void store_point(const SurfacePoint& point, SurfaceBlock& block, size_t lane) {
  const float* words = &point.surface.normal.x;
  BlockRow* rows = block.surface;
  for (uint32_t r = 0; r < surface_words; ++r) rows[r][lane] = words[r];
}

// Makes the surfaces of up to sixteen hits; the last one fills the lanes that are left over.
void make_block(const ShadingScene& scene, const ShadeKernels& kernels, std::span<const HitPlace> hits,
                SurfaceBlock& block) {
  HitBlock places;
  const HitPlace* solid = nullptr;  // any that is no sprite
  for (const HitPlace& place : hits)
    if (!is_sprite(scene, place)) solid = &place;
  if (solid) {
    for (size_t i = 0; i < block_size; ++i) {
      const HitPlace& place = hits[std::min(i, hits.size() - 1)];
      place_hit(is_sprite(scene, place) ? *solid : place, places, i);
    }
    kernels.surfaces(scene.records.tables(), places, block);
  }
  for (size_t i = 0; i < block_size; ++i) {
    const HitPlace& place = hits[std::min(i, hits.size() - 1)];
    if (is_sprite(scene, place))
      store_point(sprite_point(*scene.snapshot, *place.hit, *place.ray, place.cone), block, i);
  }
}

// Fills what blocks have no rows for.
void finish_point(const ShadingScene& scene, const HitPlace& place, SurfacePoint& point) {
  const Hit& hit = *place.hit;
  const sideray_material_desc& desc =
      scene.snapshot->materials[scene.records.instances[hit.instance].material].desc;
  point.cone = {place.cone.width + place.cone.spread * static_cast<float>(hit.distance), place.cone.spread};
  point.distortion = desc.distortion;
  point.blend = static_cast<int>(desc.blend_mode);
  point.allowance = 0.0f;
  point.key = 0;
  point.hit = hit;
  point.answer = nullptr;
}

}  // namespace

void append_surfaces(const ShadingScene& scene, const ShadeKernels& kernels, std::span<const HitPlace> hits,
                     std::vector<SurfacePoint>& points) {
  const size_t before = points.size();
  points.resize(before + hits.size());
  SurfaceBlock block;
  for (size_t first = 0; first < hits.size(); first += block_size) {
    const std::span<const HitPlace> part = hits.subspan(first, std::min<size_t>(block_size, hits.size() - first));
    make_block(scene, kernels, part, block);
    SurfacePoint* out = &points[before + first];
    kernels.unload(block, static_cast<uint32_t>(part.size()), &out->surface.normal.x,
                   sizeof(SurfacePoint) / sizeof(float));
    for (size_t i = 0; i < part.size(); ++i) {
      if (is_sprite(scene, part[i]))
        out[i] = sprite_point(*scene.snapshot, *part[i].hit, *part[i].ray, part[i].cone);
      else
        finish_point(scene, part[i], out[i]);
    }
  }
}

void SurfaceBatch::begin(const ShadingScene& scene, const std::string& isa) {
  scene_ = &scene;
  kernels_ = &shade_kernels(isa.c_str());
}

void SurfaceBatch::load(std::span<const SurfacePoint> points) {
  count_ = points.size();
  blocks_.resize((count_ + block_size - 1) / block_size);
  for (size_t b = 0; b < blocks_.size(); ++b) {
    const size_t first = b * block_size;
    kernels_->load(&points[first].surface.normal.x, sizeof(SurfacePoint) / sizeof(float),
                   static_cast<uint32_t>(std::min<size_t>(block_size, count_ - first)), blocks_[b]);
  }
  look_around();
}

void SurfaceBatch::load(std::span<const HitPlace> hits) {
  count_ = hits.size();
  blocks_.resize((count_ + block_size - 1) / block_size);
  for (size_t b = 0; b < blocks_.size(); ++b) {
    const size_t first = b * block_size;
    make_block(*scene_, *kernels_, hits.subspan(first, std::min<size_t>(block_size, count_ - first)), blocks_[b]);
  }
  look_around();
}

void SurfaceBatch::look_around() {
  around_.resize(blocks_.size());
  const std::vector<glm::vec3>& albedo = model::albedo_table().values;
  const auto size = static_cast<int32_t>(model::AlbedoTable::size);
  const model::Environment& environment = *scene_->snapshot->environment;
  const TexelView irradiance = environment.black ? TexelView{nullptr, 0, 0} : view(environment.irradiance);
  for (size_t b = 0; b < blocks_.size(); ++b) {
    kernels_->look_around(blocks_[b], {&albedo[0].x, size, size}, irradiance, around_[b]);
    for (BlockRow& row : around_[b].specular) std::fill_n(row, block_size, 0.0f);
    for (BlockRow& row : around_[b].coat) std::fill_n(row, block_size, 0.0f);
  }
}

void SurfaceBatch::reflect_environment() {
  const model::Environment& environment = *scene_->snapshot->environment;
  if (environment.black) return;
  constexpr size_t roughness = offsetof(SrSurface, roughness) / sizeof(float),
                   coat_roughness = offsetof(SrSurface, coat_roughness) / sizeof(float);
  alignas(64) BlockRow uv[2];
  for (size_t b = 0; b < blocks_.size(); ++b) {
    AroundBlock& a = around_[b];
    const size_t count = std::min<size_t>(block_size, count_ - b * block_size);
    kernels_->latlong(a.mirror, uv);
    for (size_t i = 0; i < count; ++i)
      set_vector(a.specular, i,
                 environment_specular_at(environment, {uv[0][i], uv[1][i]}, blocks_[b].surface[roughness][i]));
    if (a.coated == 0) continue;
    kernels_->latlong(a.coat_mirror, uv);
    for (size_t i = 0; i < count; ++i)
      if (a.coated >> i & 1u)
        set_vector(a.coat, i,
                   environment_specular_at(environment, {uv[0][i], uv[1][i]}, blocks_[b].surface[coat_roughness][i]));
  }
}

void SurfaceBatch::finish(glm::vec3* radiance) {
  alignas(64) BlockRow rows[3];
  for (size_t b = 0; b < blocks_.size(); ++b) {
    kernels_->finish(blocks_[b], around_[b], rows);
    const size_t first = b * block_size, count = std::min<size_t>(block_size, count_ - first);
    for (size_t i = 0; i < count; ++i) radiance[first + i] = vector_at(rows, i);
  }
}

std::span<const LightBlock> SurfaceBatch::light(const shading::SrLight& light) {
  lights_.resize(blocks_.size());
  const LightTerms t = terms(light);
  for (size_t b = 0; b < blocks_.size(); ++b) kernels_->light(blocks_[b], t, lights_[b]);
  if (count_ % block_size != 0) lights_.back().reached &= (1u << count_ % block_size) - 1u;
  return lights_;
}

}  // namespace sideray::rt
