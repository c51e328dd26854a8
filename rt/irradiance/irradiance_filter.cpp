#include "rt/irradiance/irradiance_filter.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "rt/base/half_bits.h"
#include "rt/history/frame_camera.h"

namespace sideray::rt {
namespace {

constexpr std::array<float, 3> spline{0.25f, 0.5f, 0.25f};
constexpr std::array<uint32_t, 2> smooth_steps{1, 2};
constexpr std::array<uint32_t, 4> light_steps{1, 2, 4, 8};
constexpr float reach = 0.5f;        // of the harmonic mean distance
constexpr float least_reach = 8.0f;  // widths of a pixel: noise is worse than what may leak so far
constexpr float off_plane = 1.0f;    // widths of a pixel, per pixel apart
constexpr float same_normal = 0.8f;  // cosine, where the weight is 0

// Weight of a cell for another that many cells apart: 1 on the same plane.
float likeness(const CellPlace& a, const CellPlace& b, glm::vec3 apart, float cells) {
  const float off = std::abs(glm::dot(a.normal, apart)) / (off_plane * a.width * static_cast<float>(cell_side) * cells);
  const float turned = (glm::dot(a.normal, b.normal) - same_normal) / (1.0f - same_normal);
  return std::max(1.0f - off, 0.0f) * std::max(turned, 0.0f);
}

template <typename Visit>
void for_taps(const IrradianceCells& cells, uint32_t x, uint32_t y, uint32_t step, const Visit& visit) {
  const size_t own = size_t{y} * cells.columns + x;
  const CellPlace& place = cells.places[own];
  for (int j = -1; j <= 1; ++j)
    for (int i = -1; i <= 1; ++i) {
      const int64_t u = int64_t{x} + i * int64_t{step}, v = int64_t{y} + j * int64_t{step};
      if (u < 0 || v < 0 || u >= cells.columns || v >= cells.rows) continue;
      const size_t other = static_cast<size_t>(v) * cells.columns + static_cast<size_t>(u);
      const CellPlace& there = cells.places[other];
      if (!(there.width > 0.0f)) continue;
      const float tap = spline[static_cast<size_t>(i + 1)] * spline[static_cast<size_t>(j + 1)];
      if (other == own) {
        visit(other, tap, 0.0f);
        continue;
      }
      const glm::vec3 apart = there.position - place.position;
      const float like = likeness(place, there, apart, static_cast<float>(step));
      if (like > 0.0f) visit(other, tap * like, glm::length(apart));
    }
}

// Returns the mean of the cells about a pixel that shows `position`, mostly of those on its plane, and 1; 0 where there is
// none.
glm::vec4 light_at(const IrradianceCells& cells, const std::vector<glm::vec4>& lights, glm::uvec2 pixel,
                   glm::vec3 position) {
  const glm::ivec2 own(pixel / cell_side), last(static_cast<int>(cells.columns) - 1, static_cast<int>(cells.rows) - 1);
  const glm::vec2 place = (glm::vec2(pixel) + 0.5f) / static_cast<float>(cell_side);
  for (int ring = 1; ring <= 2; ++ring) {
    const glm::ivec2 from = glm::max(own - ring, 0), to = glm::min(own + ring, last);
    const float beyond = 1.5f * static_cast<float>(ring);
    glm::vec3 sum(0.0f);
    float weights = 0.0f;
    for (int v = from.y; v <= to.y; ++v)
      for (int u = from.x; u <= to.x; ++u) {
        const size_t cell = static_cast<size_t>(v) * cells.columns + static_cast<size_t>(u);
        const CellPlace& there = cells.places[cell];
        if (!(there.width > 0.0f) || !(lights[cell].w > 0.0f)) continue;
        const glm::vec2 near = glm::max(beyond - glm::abs(place - (glm::vec2(u, v) + 0.5f)), 0.0f);
        const float off = std::abs(glm::dot(there.normal, position - there.position)) / (2.0f * there.width);
        const float weight = near.x * near.y * std::max(1.0f - off, 1e-5f);
        sum += weight * glm::vec3(lights[cell]);
        weights += weight;
      }
    if (weights > 0.0f) return glm::vec4(sum / weights, 1.0f);
  }
  return glm::vec4(0.0f);
}

}  // namespace

void IrradianceFilter::smooth(const IrradianceCells& cells, uint32_t step, Executor& executor) {
  executor.run(cells.rows, [&](size_t row, uint32_t) {
    const auto y = static_cast<uint32_t>(row);
    for (uint32_t x = 0; x < cells.columns; ++x) {
      const size_t own = row * cells.columns + x;
      next_smooth_[own] = smooth_[own];
      if (!(cells.places[own].width > 0.0f)) continue;
      glm::vec2 sum(0.0f);
      float weights = 0.0f;
      for_taps(cells, x, y, step, [&](size_t cell, float weight, float) {
        const float w = weight * cells.lights[cell].samples;
        sum += w * smooth_[cell];
        weights += w;
      });
      if (weights > 0.0f) next_smooth_[own] = sum / weights;
    }
  });
  std::swap(smooth_, next_smooth_);
}

void IrradianceFilter::pass(const IrradianceCells& cells, uint32_t step, Executor& executor) {
  executor.run(cells.rows, [&](size_t row, uint32_t) {
    const auto y = static_cast<uint32_t>(row);
    for (uint32_t x = 0; x < cells.columns; ++x) {
      const size_t own = row * cells.columns + x;
      next_[own] = light_[own];
      if (!(cells.places[own].width > 0.0f)) continue;
      const float nearest = 1.0f / (least_reach * cells.places[own].width);
      glm::vec3 sum(0.0f);
      float weights = 0.0f;
      for_taps(cells, x, y, step, [&](size_t cell, float weight, float distance) {
        const float far = distance * std::min(std::max(smooth_[own].x, smooth_[cell].x) / reach, nearest);
        const float w = weight * std::max(1.0f - far, 0.0f) * light_[cell].w;
        sum += w * glm::vec3(light_[cell]);
        weights += w;
      });
      if (weights > 0.0f) next_[own] = glm::vec4(sum / weights, light_[own].w);
    }
  });
  std::swap(light_, next_);
}

void IrradianceFilter::begin(const IrradianceCells& cells) {
  const size_t count = cells.size();
  light_.resize(count), next_.resize(count), smooth_.resize(count), next_smooth_.resize(count);
  for (size_t i = 0; i < count; ++i) smooth_[i] = {cells.lights[i].nearness, cells.lights[i].open};
}

// Takes the control variate off: what the mask of the sky says already.
void IrradianceFilter::take_mean_sky(const IrradianceCells& cells) {
  for (size_t i = 0; i < cells.size(); ++i) {
    const CellLight& light = cells.lights[i];
    light_[i] = glm::vec4(light.light - light.tint * smooth_[i].y, light.samples);
  }
}

void IrradianceFilter::spread(const IrradianceRequest& r, const IrradianceCells& cells, Executor& executor,
                              IrradianceImage& image) {
  const FrameCamera camera(r.view, r.width, r.height);
  fill_depths(executor, r.depth, camera, depths_);
  image.light.resize(size_t{4} * r.width * r.height);
  executor.run(r.height, [&](size_t row, uint32_t) {
    for (uint32_t x = 0; x < r.width; ++x) {
      const size_t texel = row * r.width + x;
      const double depth = depths_[texel];
      glm::vec4 light(0.0f);
      if (depth > 0.0) {
        const glm::dvec2 pixel(x, row);
        const glm::vec3 position(camera.origin_at(pixel) + depth * camera.ray_at(pixel));
        light = light_at(cells, light_, glm::uvec2(x, row), position);
      }
      store_rgba(&image.light[4 * texel], glm::vec3(light), light.w);
    }
  });
}

void IrradianceFilter::apply(const IrradianceRequest& r, const IrradianceCells& cells, Executor& executor,
                             IrradianceImage& image) {
  begin(cells);
  if (r.denoise)
    for (const uint32_t step : smooth_steps) smooth(cells, step, executor);
  take_mean_sky(cells);
  if (r.denoise)
    for (const uint32_t step : light_steps) pass(cells, step, executor);
  spread(r, cells, executor, image);
}

}  // namespace sideray::rt
