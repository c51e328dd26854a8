#include "rt/irradiance/irradiance_filter.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "rt/base/half_bits.h"

namespace sideray::rt {
namespace {

constexpr std::array<float, 3> spline{0.25f, 0.5f, 0.25f};
constexpr size_t smooth_steps = 2, light_steps = 4;  // of CellWalls::steps
constexpr float reach = 0.5f;        // of the harmonic mean distance
constexpr float least_reach = 8.0f;  // widths of a pixel: noise is worse than what may leak so far
// Calls visit(cell, weight, distance) for a cell and those about it, CellWalls::steps[number] apart, whose light may be its own.
template <typename Visit>
void for_taps(const IrradianceCells& cells, const CellWalls& walls, uint32_t x, uint32_t y, size_t number, const Visit& visit) {
  const int64_t step = CellWalls::steps[number];
  const size_t own = size_t{y} * cells.columns + x;
  const CellPlace& place = cells.places[own];
  for (int j = -1; j <= 1; ++j)
    for (int i = -1; i <= 1; ++i) {
      const int64_t u = x + i * step, v = y + j * step;
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
      if (like > 0.0f && !walls.stands(own, i, j, number)) visit(other, tap * like, glm::length(apart));
    }
}

}  // namespace

void IrradianceFilter::smooth(const IrradianceCells& cells, size_t number, Executor& executor) {
  executor.run(cells.rows, [&](size_t row, uint32_t) {
    const auto y = static_cast<uint32_t>(row);
    for (uint32_t x = 0; x < cells.columns; ++x) {
      const size_t own = row * cells.columns + x;
      next_smooth_[own] = smooth_[own];
      if (!(cells.places[own].width > 0.0f)) continue;
      glm::vec2 sum(0.0f);
      float weights = 0.0f;
      for_taps(cells, walls_, x, y, number, [&](size_t cell, float weight, float) {
        const float w = weight * cells.lights[cell].samples;
        sum += w * smooth_[cell];
        weights += w;
      });
      if (weights > 0.0f) next_smooth_[own] = sum / weights;
    }
  });
  std::swap(smooth_, next_smooth_);
}

void IrradianceFilter::pass(const IrradianceCells& cells, size_t number, Executor& executor) {
  executor.run(cells.rows, [&](size_t row, uint32_t) {
    const auto y = static_cast<uint32_t>(row);
    for (uint32_t x = 0; x < cells.columns; ++x) {
      const size_t own = row * cells.columns + x;
      next_[own] = light_[own];
      if (!(cells.places[own].width > 0.0f)) continue;
      glm::vec3 sum(0.0f);
      float weights = 0.0f;
      for_taps(cells, walls_, x, y, number, [&](size_t cell, float weight, float distance) {
        const float w = weight * nearby(cells, own, cell, distance) * light_[cell].w;
        sum += w * glm::vec3(light_[cell]);
        weights += w;
      });
      if (weights > 0.0f) next_[own] = glm::vec4(sum / weights, light_[own].w);
    }
  });
  std::swap(light_, next_);
}

// How much of the light at a cell is that of another at a distance, by how near what throws it is: 1 to 0.
float IrradianceFilter::nearby(const IrradianceCells& cells, size_t own, size_t other, float distance) const {
  const float nearest = 1.0f / (least_reach * cells.places[own].width);
  return std::max(1.0f - distance * std::min(std::max(smooth_[own].x, smooth_[other].x) / reach, nearest), 0.0f);
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

void IrradianceFilter::spread(const IrradianceRequest& r, const IrradianceCells& cells, const Intersector& intersector,
                              Executor& executor, IrradianceImage& image) {
  const FrameCamera camera(r.view, r.width, r.height);
  fill_depths(executor, r.depth, camera, depths_);
  rows_.resize(executor.threads());
  const CellsToSpread from{cells, walls_, light_};
  image.light.resize(size_t{4} * r.width * r.height);
  executor.run(r.height, [&](size_t y, uint32_t worker) {
    PixelRow& row = rows_[worker];
    row.find(camera, from, intersector, &depths_[y * r.width], r.width, static_cast<uint32_t>(y));
    for (uint32_t x = 0; x < r.width; ++x) {
      const glm::vec4 light = row.light(from, x);
      uint16_t* texel = &image.light[4 * (y * r.width + x)];
      // A channel is negative where the mask of the sky, which has one, says too much.
      for (int c = 0; c < 3; ++c) texel[c] = signed_half_bits(light[c]);
      texel[3] = half_bits(light.w);
    }
  });
}

// Looks for walls between cells that are a few apart, as far as light is shared.
void IrradianceFilter::look_for_walls(const IrradianceCells& cells, size_t number, const Intersector& intersector,
                                      Executor& executor) {
  const auto step = static_cast<float>(CellWalls::steps[number]);
  walls_.look(number, intersector, executor, [&](size_t a, size_t b, glm::vec3 apart) {
    const CellPlace &from = cells.places[a], &to = cells.places[b];
    if (!(likeness(from, to, apart, step) > 0.0f || likeness(to, from, apart, step) > 0.0f)) return false;
    if (!(cells.lights[a].samples + cells.lights[b].samples > 0.0f)) return false;
    // The first steps come before the harmonic mean distance is known.
    const float distance = glm::length(apart);
    return number < smooth_steps || nearby(cells, a, b, distance) > 0.0f || nearby(cells, b, a, distance) > 0.0f;
  });
}

void IrradianceFilter::apply(const IrradianceRequest& r, const IrradianceCells& cells, TracedScene& scene,
                             IrradianceImage& image) {
  Executor& executor = scene.executor();
  begin(cells);
  walls_.begin(cells, executor);
  for (size_t number = 0; number < smooth_steps; ++number) look_for_walls(cells, number, scene.intersector(), executor);
  if (r.denoise)
    for (size_t number = 0; number < smooth_steps; ++number) smooth(cells, number, executor);
  take_mean_sky(cells);
  for (size_t number = 0; r.denoise && number < light_steps; ++number) {
    if (number >= smooth_steps) look_for_walls(cells, number, scene.intersector(), executor);
    pass(cells, number, executor);
  }
  spread(r, cells, scene.intersector(), executor, image);
}

}  // namespace sideray::rt
