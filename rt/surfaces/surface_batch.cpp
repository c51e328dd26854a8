#include "rt/surfaces/surface_batch.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstring>

#include "rt/base/largest.h"
#include "rt/base/sampling.h"
#include "rt/surfaces/environment_lanes.h"
#include "rt/surfaces/sprite_surface.h"
#include "rt/textures/environment_lookup.h"

namespace sideray::rt {
namespace {

// A block's rows are the floats of SurfacePoint, in the same order.
using shading::SrSurface;
static_assert(sizeof(SrSurface) == SurfaceBlock::surface_rows * sizeof(float));
static_assert(offsetof(SurfacePoint, surface) == 0);
static_assert(offsetof(SurfacePoint, position) * block_size == offsetof(SurfaceBlock, position));
static_assert(offsetof(SurfacePoint, geometric_normal) * block_size == offsetof(SurfaceBlock, geometric_normal));
static_assert(offsetof(SurfacePoint, to_eye) * block_size == offsetof(SurfaceBlock, to_eye));
static_assert(offsetof(SurfacePoint, offset) * block_size == offsetof(SurfaceBlock, offset));
static_assert(sizeof(SurfacePoint) * block_size >= sizeof(SurfaceBlock));
static_assert(sizeof(PixelSteps) == 6 * sizeof(float));  // HitBlock::steps
static_assert(offsetof(SrSurface, albedo) == 3 * sizeof(float) && offsetof(SrSurface, diffuse) == 7 * sizeof(float) &&
              offsetof(SrSurface, tint) == 22 * sizeof(float) && offsetof(SrSurface, coat) == 28 * sizeof(float) &&
              offsetof(SrSurface, coat_normal) == 30 * sizeof(float) && offsetof(SrSurface, f0) == 13 * sizeof(float) &&
              offsetof(SrSurface, coat_share) == 41 * sizeof(float) &&
              offsetof(SrSurface, albedo_terms) == 44 * sizeof(float));

// Separates the random numbers that sample lights from others of the same key.
constexpr uint32_t light_purpose = 0x11a6b75u;

// Makes random numbers depend on the position and not on the frame: points at rest sample the same lights in every
// frame and do not flicker; jittered pixels have other positions and average.
uint32_t key_of_place(glm::vec3 p) {
  return random_key({light_purpose, std::bit_cast<uint32_t>(p.x), std::bit_cast<uint32_t>(p.y), std::bit_cast<uint32_t>(p.z)});
}
glm::vec3 place_of(const HitPlace& hit) {
  return hit.ray->origin + hit.ray->direction * static_cast<float>(hit.hit->distance);
}

float width_at(const HitPlace& hit) {
  return hit.cone.width + hit.cone.spread * static_cast<float>(hit.hit->distance);
}

constexpr uint32_t surface_words = sizeof(SurfaceBlock) / sizeof(BlockRow);

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

constexpr size_t occlusion_row = offsetof(SrSurface, occlusion) / sizeof(float);

void load_rows(const glm::vec3* values, size_t count, BlockRow (&rows)[3]) {
  for (size_t i = 0; i < block_size; ++i) set_vector(rows, i, i < count ? values[i] : glm::vec3(0.0f));
}

void place_hit(const HitPlace& place, HitBlock& block, size_t lane) {
  const Hit& hit = *place.hit;
  block.u[lane] = hit.u;
  block.v[lane] = hit.v;
  set_vector(block.direction, lane, place.ray->direction);
  block.width[lane] = width_at(place);
  block.front[lane] = hit.front ? 1.0f : 0.0f;
  block.instance[lane] = hit.instance;
  block.primitive[lane] = hit.primitive;
}

bool is_sprite(const ShadingScene& scene, const HitPlace& place) {
  return scene.records.sprites && scene.records.instances[place.hit->instance].sprites;
}

void store_point(const SurfacePoint& point, SurfaceBlock& block, size_t lane) {
  const float* words = &point.surface.normal.x;
  BlockRow* rows = block.surface;
  for (uint32_t r = 0; r < surface_words; ++r) rows[r][lane] = words[r];
}

// Makes the surfaces of up to sixteen hits, except sprites; the last one fills unused lanes.
void make_solids(const ShadingScene& scene, const ShadeKernels& kernels, std::span<const HitPlace> hits,
                 const PixelSteps* steps, SurfaceBlock& block) {
  HitBlock places;
  if (steps) places.steps = &steps->right.x;
  const HitPlace* solid = nullptr;  // any hit that is not on a sprite
  for (const HitPlace& place : hits)
    if (!is_sprite(scene, place)) solid = &place;
  if (solid) {
    for (size_t i = 0; i < block_size; ++i) {
      const HitPlace& place = hits[std::min(i, hits.size() - 1)];
      place_hit(is_sprite(scene, place) ? *solid : place, places, i);
    }
    kernels.surfaces(scene.records.tables(), places, block);
  }
}

// Makes all surfaces of a block.
void make_block(const ShadingScene& scene, const ShadeKernels& kernels, std::span<const HitPlace> hits,
                const PixelSteps* steps, SurfaceBlock& block) {
  make_solids(scene, kernels, hits, steps, block);
  if (!scene.records.sprites) return;
  for (size_t i = 0; i < block_size; ++i) {
    const HitPlace& place = hits[std::min(i, hits.size() - 1)];
    if (is_sprite(scene, place))
      store_point(sprite_point(*scene.snapshot, *place.hit, *place.ray, place.cone), block, i);
  }
}

// Returns the rows of a lobe, given the offsets of its members in a surface.
LobeRows lobe_of(const SurfaceBlock& block, size_t normal, size_t roughness) {
  return {reinterpret_cast<const BlockRow(&)[3]>(block.surface[normal / sizeof(float)]),
          block.surface[roughness / sizeof(float)]};
}

const sideray_material_desc& material_of(const ShadingScene& scene, const HitPlace& place) {
  return scene.snapshot->materials[scene.records.instances[place.hit->instance].material].desc;
}

// Computes how the hits of a block are composited, except sprites.
void blend_block(const ShadingScene& scene, const ShadeKernels& kernels, std::span<const HitPlace> hits,
                 const SurfaceBlock& block, BlendBlock& blends) {
  alignas(64) BlockRow modes;
  for (size_t i = 0; i < block_size; ++i) {
    const HitPlace& place = hits[std::min(i, hits.size() - 1)];
    const auto mode = is_sprite(scene, place) ? 0 : static_cast<int32_t>(material_of(scene, place).blend_mode);
    std::memcpy(&modes[i], &mode, sizeof(mode));
  }
  kernels.blend(block, modes, blends);
}

shading::SrBlend blend_at(const BlendBlock& blends, size_t lane) {
  return {blends.cover[lane], vector_at(blends.through, lane)};
}

// Fills the fields that blocks do not store.
void finish_point(const ShadingScene& scene, const HitPlace& place, SurfacePoint& point) {
  const Hit& hit = *place.hit;
  const sideray_material_desc& desc = material_of(scene, place);
  point.cone = {place.cone.width + place.cone.spread * static_cast<float>(hit.distance), place.cone.spread};
  point.distortion = desc.distortion;
  point.blend = static_cast<int>(desc.blend_mode);
  point.key = 0;
  point.hit = hit;
  point.weight = 1.0f;
  point.answer = nullptr;
}

}  // namespace

void make_surfaces(const ShadingScene& scene, const ShadeKernels& kernels, std::span<const HitPlace> hits,
                   SurfacePoint* points, const PixelSteps* steps) {
  SurfaceBlock block;
  BlendBlock blends;
  for (size_t first = 0; first < hits.size(); first += block_size) {
    const std::span<const HitPlace> part = hits.subspan(first, std::min<size_t>(block_size, hits.size() - first));
    make_solids(scene, kernels, part, steps, block);
    SurfacePoint* out = points + first;
    kernels.unload(block, static_cast<uint32_t>(part.size()), &out->surface.normal.x,
                   sizeof(SurfacePoint) / sizeof(float));
    blend_block(scene, kernels, part, block, blends);
    for (size_t i = 0; i < part.size(); ++i) {
      if (is_sprite(scene, part[i])) {
        out[i] = sprite_point(*scene.snapshot, *part[i].hit, *part[i].ray, part[i].cone);
      } else {
        finish_point(scene, part[i], out[i]);
        out[i].blended = blend_at(blends, i);
      }
    }
  }
}

void append_surfaces(const ShadingScene& scene, const ShadeKernels& kernels, std::span<const HitPlace> hits,
                     std::vector<SurfacePoint>& points) {
  const size_t before = points.size();
  points.resize(before + hits.size());
  make_surfaces(scene, kernels, hits, points.data() + before);
}

void SurfaceBatch::begin(const ShadingScene& scene, const std::string& isa, glm::vec3 viewer) {
  scene_ = &scene;
  fixed_lights_ = scene.fixed_lights;
  shadowed_ = static_cast<size_t>(std::ranges::count_if(fixed_lights_, &FixedLightTerms::casts_shadows));
  for (FixedLightTerms& light : fixed_lights_)
    for (int c = 0; c < 3; ++c) light.viewer[c] = viewer[c];
  kernels_ = &shade_kernels(isa.c_str());
  levels_ = levels_of(*scene.snapshot->environment);
  occludes_by_rays_ = false;
}

void SurfaceBatch::load(std::span<const SurfacePoint> points) {
  count_ = points.size();
  clear_traits();
  for (const SurfacePoint& p : points) add_traits(p.weight, p.cone.width, key_of_place(p.position));
  blocks_.resize((count_ + block_size - 1) / block_size);
  for (size_t b = 0; b < blocks_.size(); ++b) {
    const size_t first = b * block_size;
    kernels_->load(&points[first].surface.normal.x, sizeof(SurfacePoint) / sizeof(float),
                   static_cast<uint32_t>(std::min<size_t>(block_size, count_ - first)), blocks_[b]);
  }
  look_around();
}

void SurfaceBatch::load(std::span<const HitPlace> hits) {
  make_blocks(hits, nullptr);
  look_around();
}

void SurfaceBatch::load_drawn(std::span<const HitPlace> hits, const PixelSteps& steps) {
  static_assert(offsetof(SrSurface, normal) == 0);
  make_blocks(hits, &steps);
  for (SurfaceBlock& block : blocks_) std::memcpy(block.geometric_normal, block.surface, sizeof(block.geometric_normal));
  look_around();
}

void SurfaceBatch::make_blocks(std::span<const HitPlace> hits, const PixelSteps* steps) {
  count_ = hits.size();
  clear_traits();
  for (const HitPlace& hit : hits) add_traits(hit.weight, width_at(hit), key_of_place(place_of(hit)));
  blocks_.resize((count_ + block_size - 1) / block_size);
  for (size_t b = 0; b < blocks_.size(); ++b) {
    const size_t first = b * block_size;
    make_block(*scene_, *kernels_, hits.subspan(first, std::min<size_t>(block_size, count_ - first)), steps,
               blocks_[b]);
  }
}

void SurfaceBatch::clear_traits() {
  weights_.clear();
  widths_.clear();
  keys_.clear();
}

void SurfaceBatch::add_traits(float weight, float width, uint32_t key) {
  weights_.push_back(weight);
  widths_.push_back(width);
  keys_.push_back(key);
}

void SurfaceBatch::look_around() {
  if (occludes_by_rays_)
    for (SurfaceBlock& block : blocks_) std::fill_n(block.surface[occlusion_row], block_size, 1.0f);
  around_.resize(blocks_.size());
  const model::Environment& environment = *scene_->snapshot->environment;
  const TexelView irradiance = environment.black ? TexelView{nullptr, 0, 0} : view(environment.irradiance);
  for (size_t b = 0; b < blocks_.size(); ++b) {
    kernels_->look_around(blocks_[b], irradiance, around_[b]);
    for (BlockRow& row : around_[b].specular) std::fill_n(row, block_size, 0.0f);
    for (BlockRow& row : around_[b].coat) std::fill_n(row, block_size, 0.0f);
  }
}

void SurfaceBatch::hide_sky(std::span<const SkyShares> shares) {
  const model::Environment& environment = *scene_->snapshot->environment;
  if (environment.black) return;
  for (size_t b = 0; b < blocks_.size(); ++b)
    kernels_->hide_sky(blocks_[b], view(environment.irradiance), shares[b], around_[b]);
}

bool SurfaceBatch::is_matt(size_t point) const {
  const BlockRow* rows = &blocks_[point / block_size].surface[offsetof(SrSurface, diffuse) / sizeof(float)];
  const BlockRow* behind = &blocks_[point / block_size].surface[offsetof(SrSurface, behind) / sizeof(float)];
  const size_t lane = point % block_size;
  for (int c = 0; c < 3; ++c)
    if (rows[c][lane] > 0.0f || behind[c][lane] > 0.0f) return true;
  return false;
}

PointAround SurfaceBatch::point_around(size_t point) const {
  const SurfaceBlock& block = blocks_[point / block_size];
  const size_t lane = point % block_size;
  const glm::vec3 normal = vector_at(block.geometric_normal, lane);
  return {vector_at(block.position, lane) + normal * block.offset[lane], normal, widths_[point],
          std::min(std::max(0.0f, weights_[point]), 1.0f)};
}

void SurfaceBatch::drop_occlusion(size_t point) {
  blocks_[point / block_size].surface[occlusion_row][point % block_size] = 1.0f;
}

void SurfaceBatch::drop_highlights(float least_roughness) {
  constexpr size_t f0 = offsetof(SrSurface, f0) / sizeof(float), f90 = offsetof(SrSurface, f90) / sizeof(float);
  for (SurfaceBlock& block : blocks_) {
    const BlockRow& roughness = block.surface[offsetof(SrSurface, roughness) / sizeof(float)];
    for (size_t i = 0; i < block_size; ++i) {
      if (roughness[i] >= least_roughness) continue;
      for (size_t c = 0; c < 3; ++c) block.surface[f0 + c][i] = block.surface[f90 + c][i] = 0.0f;
    }
    for (float& value : block.surface[offsetof(SrSurface, coat_roughness) / sizeof(float)])
      if (value < least_roughness) value = 1.0f;
  }
}

void SurfaceBatch::let_arrive(std::span<const ArrivingLight> arriving) {
  for (size_t i = 0; i < count_; ++i) {
    AroundBlock& a = around_[i / block_size];
    for (BlockRow(*rows)[3] : {&a.irradiance, &a.behind})
      set_vector(*rows, i % block_size, vector_at(*rows, i % block_size) * arriving[i].open + arriving[i].thrown);
  }
}

void SurfaceBatch::let_arrive_in_mirrors(std::span<const ArrivingLight> arriving) {
  for (size_t i = 0; i < count_; ++i) {
    AroundBlock& a = around_[i / block_size];
    for (BlockRow(*rows)[3] : {&a.specular, &a.coat})
      set_vector(*rows, i % block_size, vector_at(*rows, i % block_size) * arriving[i].open + arriving[i].thrown);
  }
}

void SurfaceBatch::reflect_environment() {
  if (scene_->snapshot->environment->black) return;
  for (size_t b = 0; b < blocks_.size(); ++b) {
    const size_t count = std::min<size_t>(block_size, count_ - b * block_size);
    reflect_environment(b, (1u << count) - 1u);
  }
}

void SurfaceBatch::reflect_environment(size_t block, uint32_t lanes) {
  reflect_environment_in_base(block, lanes);
  AroundBlock& a = around_[block];
  if (scene_->snapshot->environment->black || (a.coated & lanes) == 0) return;
  look_up(a.coat_mirror, lobe_of(blocks_[block], offsetof(SrSurface, coat_normal), offsetof(SrSurface, coat_roughness)),
          a.coated & lanes, a.coat);
}

void SurfaceBatch::reflect_environment_in_base(size_t block, uint32_t lanes) {
  if (scene_->snapshot->environment->black) return;
  AroundBlock& a = around_[block];
  look_up(a.mirror, {a.normal, a.roughness}, lanes, a.specular);
}

// Writes the prefiltered radiance of the lobes, for the lanes whose bit is set.
void SurfaceBatch::look_up(const BlockRow (&mirror)[3], const LobeRows& lobe, uint32_t lanes,
                           BlockRow (&radiance)[3]) const {
  alignas(64) BlockRow uv[2], found[3];
  if (!levels_.uniform) kernels_->places(lobe.normal, mirror, lobe.roughness, uv);
  kernels_->specular(levels_, uv, lobe.roughness, found);
  for (uint32_t bits = lanes; bits != 0; bits &= bits - 1) {
    const auto i = static_cast<size_t>(std::countr_zero(bits));
    set_vector(radiance, i, vector_at(found, i));
  }
}

void SurfaceBatch::surroundings(std::span<const EnvironmentPlace> places, glm::vec3* radiance) const {
  if (levels_.count == 0) return void(std::fill_n(radiance, places.size(), glm::vec3(0.0f)));
  alignas(64) BlockRow uv[2], roughness, found[3];
  for (size_t first = 0; first < places.size(); first += block_size) {
    const size_t count = std::min<size_t>(block_size, places.size() - first);
    for (size_t i = 0; i < block_size; ++i) {
      const EnvironmentPlace& place = places[first + std::min(i, count - 1)];
      uv[0][i] = place.uv.x;
      uv[1][i] = place.uv.y;
      roughness[i] = place.roughness;
    }
    kernels_->specular(levels_, uv, roughness, found);
    for (size_t i = 0; i < count; ++i) radiance[first + i] = vector_at(found, i);
  }
}

void SurfaceBatch::store_radiance(size_t block, const BlockRow (&rows)[3], glm::vec3* radiance) const {
  const size_t first = block * block_size, count = std::min<size_t>(block_size, count_ - first);
  for (size_t i = 0; i < count; ++i) radiance[first + i] = vector_at(rows, i);
}

LightTerms SurfaceBatch::terms_of(size_t light) const {
  if (!scene_->snapshot->fixed) return terms(scene_->lights[light]);
  LightTerms t{};
  t.fixed = &fixed_lights_[light];
  return t;
}

void SurfaceBatch::start_fixed(glm::vec3* radiance) {
  alignas(64) BlockRow rows[3], shine[3];
  shine_.resize(count_);
  for (size_t b = 0; b < blocks_.size(); ++b) {
    kernels_->start_fixed(blocks_[b], fixed_lights_.data(), fixed_lights_.size(), rows, shine);
    store_radiance(b, rows, radiance);
    if (is_separate()) store_radiance(b, shine, shine_.data());
  }
}

void SurfaceBatch::show(glm::vec3* radiance) {
  if (!scene_->snapshot->fixed) return;
  alignas(64) BlockRow rows[3], shine[3]{};
  for (size_t b = 0; b < blocks_.size(); ++b) {
    const size_t first = b * block_size, count = std::min<size_t>(block_size, count_ - first);
    load_rows(radiance + first, count, rows);
    if (is_separate()) load_rows(shine_.data() + first, count, shine);
    kernels_->finish_fixed(blocks_[b], around_[b], rows, shine);
    store_radiance(b, rows, radiance);
  }
}

void SurfaceBatch::finish(glm::vec3* radiance) {
  if (scene_->snapshot->fixed) return start_fixed(radiance);
  alignas(64) BlockRow rows[3];
  for (size_t b = 0; b < blocks_.size(); ++b) {
    kernels_->finish(blocks_[b], around_[b], rows);
    store_radiance(b, rows, radiance);
  }
}

void SurfaceBatch::finish_unblocked(glm::vec3* radiance) {
  const bool fixed = scene_->snapshot->fixed != nullptr;
  alignas(64) BlockRow rows[3], shine[3];
  for (size_t b = 0; b < blocks_.size(); ++b) {
    if (fixed)
      kernels_->start_fixed(blocks_[b], fixed_lights_.data(), fixed_lights_.size(), rows, shine);
    else
      kernels_->finish(blocks_[b], around_[b], rows);
    for (size_t l = 0; l < lights(); ++l) kernels_->add_light(blocks_[b], terms_of(l), rows, shine);
    if (fixed) kernels_->finish_fixed(blocks_[b], around_[b], rows, shine);
    store_radiance(b, rows, radiance);
  }
}

void SurfaceBatch::unblocked(glm::vec3* radiance, glm::vec3* apart) {
  alignas(64) BlockRow rows[3], shine[3];
  for (size_t b = 0; b < blocks_.size(); ++b) {
    for (BlockRow(*all)[3] : {&rows, &shine})
      for (BlockRow& row : *all) std::fill_n(row, block_size, 0.0f);
    for (size_t l = 0; l < lights(); ++l) kernels_->add_light(blocks_[b], terms_of(l), rows, shine);
    if (apart) store_radiance(b, shine, apart);
    for (int c = 0; c < 3; ++c)
      for (size_t i = 0; i < block_size; ++i) rows[c][i] += shine[c][i];
    store_radiance(b, rows, radiance);
  }
}

void SurfaceBatch::blend(std::span<const HitPlace> hits, shading::SrBlend* blends) {
  BlendBlock block;
  for (size_t first = 0; first < hits.size(); first += block_size) {
    const std::span<const HitPlace> part = hits.subspan(first, std::min<size_t>(block_size, hits.size() - first));
    blend_block(*scene_, *kernels_, part, blocks_[first / block_size], block);
    for (size_t i = 0; i < part.size(); ++i)
      blends[first + i] = is_sprite(*scene_, part[i])
                              ? sprite_point(*scene_->snapshot, *part[i].hit, *part[i].ray, part[i].cone).blended
                              : blend_at(block, i);
  }
  for (size_t i = 0; i < hits.size(); ++i) weights_[i] *= blends[i].cover;
}

// Fills candidates_, and adds up their gains.
void SurfaceBatch::list_candidates(size_t b, BlockRow& total, glm::vec3* offered) {
  const size_t first = b * block_size;
  const uint32_t all = first + block_size > count_ ? (1u << (count_ - first)) - 1u : 0xffffu;
  static_assert(block_size == 16);
  if (candidates_.size() < lights()) candidates_.resize(lights());
  std::fill_n(total, block_size, 0.0f);
  for (size_t l = 0; l < lights(); ++l) {
    Candidate& c = candidates_[l];
    kernels_->light(blocks_[b], terms_of(l), c.light);
    c.light.reached &= all;
    for (uint32_t bits = c.light.reached; bits != 0; bits &= bits - 1) {
      const auto i = static_cast<size_t>(std::countr_zero(bits));
      glm::vec3 gain = vector_at(c.light.gain, i);
      if (c.light.separate) gain += vector_at(c.light.shine, i);
      c.size[i] = largest(gain);
      total[i] += c.size[i];
      if (offered) offered[first + i] += gain;
    }
  }
}

// Samples systematically: a point's lights lie end to end on a line, each as long as its gain, and a comb with one
// random offset selects lights. So the number of rays varies by at most one.
void SurfaceBatch::draw(size_t b, const LightOdds& odds, float share, ShadowRays& rays, glm::vec3* offered) {
  constexpr float least_weight = 1e-9f;
  const size_t first = b * block_size;
  BlockRow total, step, next, passed{};
  list_candidates(b, total, offered);
  for (size_t i = 0; i < std::min<size_t>(block_size, count_ - first); ++i) {
    const float weight = std::max(weights_[first + i], least_weight);
    step[i] = std::max(odds.least / weight, std::min(total[i], odds.most / weight));
    next[i] = step[i] * unit_float(keys_[first + i]);
  }
  for (size_t l = 0; l < lights(); ++l) {
    Candidate& c = candidates_[l];
    for (uint32_t bits = c.light.reached; bits != 0; bits &= bits - 1) {
      const auto i = static_cast<size_t>(std::countr_zero(bits));
      if (!(c.size[i] < step[i])) continue;
      passed[i] += c.size[i];
      if (passed[i] > next[i]) {
        next[i] += step[i];
        set_vector(c.light.gain, i, vector_at(c.light.gain, i) * (step[i] / c.size[i]));
        if (c.light.separate) set_vector(c.light.shine, i, vector_at(c.light.shine, i) * (step[i] / c.size[i]));
      } else {
        c.light.reached &= ~(1u << i);
      }
    }
    if (c.light.reached == 0) continue;
    rays.reserve(block_size);
    rays.append(*kernels_, c.light, share, static_cast<uint32_t>(first));
  }
}

void SurfaceBatch::gather(size_t light, float share, ShadowRays& rays) {
  const LightTerms t = terms_of(light);
  rays.reserve(blocks_.size() * block_size);
  LightBlock block;
  for (size_t b = 0; b < blocks_.size(); ++b) {
    const size_t first = b * block_size;
    kernels_->light(blocks_[b], t, block);
    if (first + block_size > count_) block.reached &= (1u << (count_ - first)) - 1u;
    rays.append(*kernels_, block, share, static_cast<uint32_t>(first));
  }
}

std::span<const LightBlock> SurfaceBatch::light(const shading::SrLight& light) {
  lights_.resize(blocks_.size());
  const LightTerms t = terms(light);
  for (size_t b = 0; b < blocks_.size(); ++b) kernels_->light(blocks_[b], t, lights_[b]);
  if (count_ % block_size != 0) lights_.back().reached &= (1u << count_ % block_size) - 1u;
  return lights_;
}

void SurfaceBatch::light(size_t block, const shading::SrLight& light, LightBlock& result) const {
  kernels_->light(blocks_[block], terms(light), result);
}

}  // namespace sideray::rt
