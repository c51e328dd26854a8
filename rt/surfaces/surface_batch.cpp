#include "rt/surfaces/surface_batch.h"

#include <algorithm>
#include <cstddef>

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

}  // namespace

void SurfaceBatch::begin(const ShadingScene& scene, const std::string& isa) {
  scene_ = &scene;
  kernels_ = &shade_kernels(isa.c_str());
}

void SurfaceBatch::load(std::span<const SurfacePoint> points) {
  count_ = points.size();
  const size_t blocks = (count_ + block_size - 1) / block_size;
  blocks_.resize(blocks);
  around_.resize(blocks);
  const std::vector<glm::vec3>& albedo = model::albedo_table().values;
  const auto size = static_cast<int32_t>(model::AlbedoTable::size);
  const model::Environment& environment = *scene_->snapshot->environment;
  const TexelView irradiance = environment.black ? TexelView{nullptr, 0, 0} : view(environment.irradiance);
  for (size_t b = 0; b < blocks; ++b) {
    const size_t first = b * block_size;
    kernels_->load(&points[first].surface.normal.x, sizeof(SurfacePoint) / sizeof(float),
                   static_cast<uint32_t>(std::min<size_t>(block_size, count_ - first)), blocks_[b]);
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
