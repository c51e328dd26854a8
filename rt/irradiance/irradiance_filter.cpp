#include "rt/irradiance/irradiance_filter.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "rt/base/half_bits.h"

namespace sideray::rt {
namespace {

constexpr std::array<float, 3> spline{0.25f, 0.5f, 0.25f};
constexpr size_t smooth_steps = 2, light_steps = 4;  // of CellWalls::steps
constexpr uint32_t rings_of_pixels = 2;              // of cells that a pixel reads about its own
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

// How many rows beside those that are written a pass has to get right: what later ones read.
constexpr uint32_t read_after_pass(size_t number) {
  uint32_t rows = rings_of_pixels;
  for (size_t later = number + 1; later < light_steps; ++later) rows += CellWalls::steps[later];
  return rows;
}
constexpr uint32_t read_by_passes = read_after_pass(0) + CellWalls::steps[0];
constexpr uint32_t read_after_smooth(size_t number) {
  uint32_t rows = read_by_passes;
  for (size_t later = number + 1; later < smooth_steps; ++later) rows += CellWalls::steps[later];
  return rows;
}
constexpr uint32_t read_in_all = read_after_smooth(0) + CellWalls::steps[0];

size_t count(CellRows rows) {
  return rows.end - rows.first;
}

}  // namespace

void IrradianceFilter::smooth(const Input& in, size_t number, CellRows rows, Executor& executor) {
  const IrradianceCells& cells = in.cells;
  executor.run(count(rows), [&](size_t index, uint32_t) {
    const size_t row = rows.first + index;
    const auto y = static_cast<uint32_t>(row);
    for (uint32_t x = 0; x < cells.columns; ++x) {
      const size_t own = row * cells.columns + x;
      next_smooth_[own] = smooth_[own];
      if (!(cells.places[own].width > 0.0f)) continue;
      glm::vec2 sum(0.0f);
      float weights = 0.0f;
      for_taps(cells, in.walls, x, y, number, [&](size_t cell, float weight, float) {
        const float w = weight * cells.lights[cell].samples;
        sum += w * smooth_[cell];
        weights += w;
      });
      if (weights > 0.0f) next_smooth_[own] = sum / weights;
    }
  });
  std::swap(smooth_, next_smooth_);
}

void IrradianceFilter::pass(const Input& in, size_t number, CellRows rows, Executor& executor) {
  const IrradianceCells& cells = in.cells;
  executor.run(count(rows), [&](size_t index, uint32_t) {
    const size_t row = rows.first + index;
    const auto y = static_cast<uint32_t>(row);
    for (uint32_t x = 0; x < cells.columns; ++x) {
      const size_t own = row * cells.columns + x;
      next_[own] = light_[own];
      if (!(cells.places[own].width > 0.0f)) continue;
      glm::vec3 sum(0.0f);
      float weights = 0.0f;
      for_taps(cells, in.walls, x, y, number, [&](size_t cell, float weight, float distance) {
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

void IrradianceFilter::begin(const IrradianceCells& cells, CellRows rows) {
  const size_t size = cells.size();
  light_.resize(size), next_.resize(size), smooth_.resize(size), next_smooth_.resize(size);
  for (size_t i = size_t{rows.first} * cells.columns; i < size_t{rows.end} * cells.columns; ++i)
    smooth_[i] = {cells.lights[i].nearness, cells.lights[i].open};
}

// Takes the control variate off: what the mask of the sky says already.
void IrradianceFilter::take_mean_sky(const IrradianceCells& cells, CellRows rows) {
  for (size_t i = size_t{rows.first} * cells.columns; i < size_t{rows.end} * cells.columns; ++i) {
    const CellLight& light = cells.lights[i];
    light_[i] = glm::vec4(light.light - light.tint * smooth_[i].y, light.samples);
  }
}

void IrradianceFilter::spread(const Input& in, PixelRows rows, const Intersector& intersector, Executor& executor,
                              IrradianceImage& image) {
  const IrradianceRequest& r = in.request;
  const FrameCamera camera(r.view, r.width, r.height);
  rows_.resize(executor.threads());
  const CellsToSpread from{in.cells, in.walls, light_};
  image.light.resize(size_t{4} * r.width * r.height);
  executor.run(rows.end - rows.first, [&](size_t index, uint32_t worker) {
    const size_t y = rows.first + index;
    PixelRow& row = rows_[worker];
    row.find(camera, from, intersector, &in.depths[y * r.width], r.width, static_cast<uint32_t>(y));
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
void IrradianceFilter::look_for_walls(const Input& in, size_t number, CellRows rows, const Intersector& intersector,
                                      Executor& executor) {
  const IrradianceCells& cells = in.cells;
  const auto step = static_cast<float>(CellWalls::steps[number]);
  rows.first -= std::min(rows.first, CellWalls::steps[number]);  // which know what is above them
  in.walls.look(number, rows, intersector, executor, [&](size_t a, size_t b, glm::vec3 apart) {
    const CellPlace &from = cells.places[a], &to = cells.places[b];
    if (!(likeness(from, to, apart, step) > 0.0f || likeness(to, from, apart, step) > 0.0f)) return false;
    if (!(cells.lights[a].samples + cells.lights[b].samples > 0.0f)) return false;
    // The first steps come before the harmonic mean distance is known.
    const float distance = glm::length(apart);
    return number < smooth_steps || nearby(cells, a, b, distance) > 0.0f || nearby(cells, b, a, distance) > 0.0f;
  });
}

void IrradianceFilter::apply(const Input& in, PixelRows rows, TracedScene& scene, IrradianceImage& image) {
  Executor& executor = scene.executor();
  const Intersector& intersector = scene.intersector();
  const auto about = [&](uint32_t around) { return in.cells.rows_of(rows, around); };
  begin(in.cells, about(read_in_all));
  in.walls.begin(in.cells, executor);
  for (size_t number = 0; number < smooth_steps; ++number) look_for_walls(in, number, about(read_after_smooth(0)), intersector, executor);
  if (in.request.denoise)
    for (size_t number = 0; number < smooth_steps; ++number) smooth(in, number, about(read_after_smooth(number)), executor);
  take_mean_sky(in.cells, about(read_by_passes));
  for (size_t number = 0; in.request.denoise && number < light_steps; ++number) {
    if (number >= smooth_steps) look_for_walls(in, number, about(read_after_pass(number)), intersector, executor);
    pass(in, number, about(read_after_pass(number)), executor);
  }
  spread(in, rows, intersector, executor, image);
}

}  // namespace sideray::rt
