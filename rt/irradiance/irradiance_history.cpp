#include "rt/irradiance/irradiance_history.h"

#include <algorithm>
#include <chrono>

#include "rt/base/pixels.h"
#include "rt/scene/scene_difference.h"

namespace sideray::rt {
namespace {

constexpr float most_samples_moving = 8.0f;  // for cells lit by something that moves, which must follow it
constexpr float same_facing = 0.9f;  // cosine

}  // namespace

void IrradianceHistory::begin(const IrradianceRequest& r, TracedScene& scene) {
  std::shared_ptr<const model::Snapshot> committed = scene.committed();
  again_ = r.sequence == SequenceStep::again && width_ == r.width && height_ == r.height && number_ > 0;
  if (again_) {
    settled_ = settled_ && FrameCamera(r.view, r.width, r.height).sees_as(trail_.camera());
    return;
  }
  follows_ = known_ && r.sequence != SequenceStep::first && r.width == width_ && r.height == height_ &&
             r.shadows == shadows_ && differ_in_places_only(*committed_, *committed);
  counted_ = committed_ == committed ? static_cast<float>(most_samples) : most_samples_moving;
  known_ = false;
  const glm::dvec3 origin = scene.shading().snapshot->origin;
  moved_ = glm::vec3(origin_ - origin);
  origin_ = origin;
  // All frames of a position fill the same cells.
  if (!(follows_ && r.position_frames > 1)) std::swap(before_, after_);
  number_ = follows_ ? number_ + 1 : 1;
  if (!follows_) turns_.assign(size_t{tile_count(r.width)} * tile_count(r.height), 0);
  trail_.begin(r.view, r.depth, {r.width, r.height}, origin, follows_, scene.executor());
  stands_still_ = follows_ && trail_.same_view() && posed_ == scene.shading().snapshot;
  if (!stands_still_) turns_at_rest_.assign(turns_.size(), 0);
  settled_ = r.position_frames == 0 && std::ranges::all_of(turns_at_rest_, [](uint8_t turns) { return turns == most_samples; });
  posed_ = scene.shading().snapshot;
  width_ = r.width, height_ = r.height, shadows_ = r.shadows;
  committed_ = std::move(committed);
}

void IrradianceHistory::traced(size_t tile) {
  turns_[tile] = number_;
  if (!again_ && turns_at_rest_[tile] < most_samples) ++turns_at_rest_[tile];
}

void IrradianceHistory::look_back(size_t tile, const std::vector<glm::u16vec2>& pixels, const Intersector& intersector,
                                  Scratch& scratch, IrradianceCells& cells) const {
  constexpr uint32_t across = frame_tile_size / cell_side;
  const uint32_t columns = tile_count(width_);
  const uint32_t x0 = static_cast<uint32_t>(tile % columns) * across, y0 = static_cast<uint32_t>(tile / columns) * across;
  scratch.rays.clear(), scratch.cells.clear();
  for (uint32_t y = y0; y < std::min(y0 + across, cells.rows); ++y)
    for (uint32_t x = x0; x < std::min(x0 + across, cells.columns); ++x) {
      const size_t cell = size_t{y} * cells.columns + x;
      const CellPlace& place = cells.places[cell];
      cells.lights[cell] = {};
      if (!follows_ || !(place.width > 0.0f)) continue;
      PixelTrail::Row from;
      trail_.look_back(pixels[cell].x, pixels[cell].y, 1, from);
      if (from[0] == PixelTrail::nowhere) continue;
      const size_t then = size_t{from[0] / width_ / cell_side} * cells.columns + from[0] % width_ / cell_side;
      CellPlace was = before_.places[then];
      was.position += moved_;
      // The cell's traced pixel may have shown another surface than the one found.
      if (glm::dot(was.normal, place.normal) < same_facing || !(plane_share(was, place.position) > 0.0f)) continue;
      cells.lights[cell] = before_.lights[then];
      cells.lights[cell].samples = std::min(cells.lights[cell].samples, counted_);
      const glm::vec3 apart = was.position - place.position;
      if (!walls_.is_near(then, glm::dot(apart, apart))) continue;
      scratch.rays.push_back(ray_between(was, place));
      scratch.cells.push_back(static_cast<uint32_t>(cell));
    }
  if (scratch.rays.empty()) return;
  scratch.occluded.resize(scratch.rays.size());
  intersector.occluded(scratch.rays, false, scratch.occluded.data(), OpaqueSet::visible_in_reflection);
  for (size_t i = 0; i < scratch.cells.size(); ++i)
    if (scratch.occluded[i]) cells.lights[scratch.cells[i]] = {};
}

void IrradianceHistory::keep() {
  std::ranges::fill(turns_, number_);
  if (again_) return;
  std::swap(before_, after_);
  known_ = true;
}

void IrradianceHistory::end() {
  if (!again_) known_ = true;
}

uint32_t IrradianceHistory::rows_in(const WorkTime& work) const {
  const uint32_t columns = tile_count(width_), rows = tile_count(height_);
  if (work.pieces) return std::clamp<uint32_t>(static_cast<uint32_t>(std::max(work.pieces->load(), int64_t{0})) / columns, 1, rows);
  if (!has_deadline(work.deadline)) return rows;
  if (row_ms_ <= 0.0) return 1;
  const double left = std::chrono::duration<double, std::milli>(work.deadline - Deadline::clock::now()).count();
  return static_cast<uint32_t>(std::clamp(left / row_ms_, 1.0, static_cast<double>(rows)));
}

void IrradianceHistory::took(double ms, uint32_t rows) {
  const double each = ms / rows;
  row_ms_ = each > row_ms_ ? each : row_ms_ + 0.25 * (each - row_ms_);
}

TileRows IrradianceHistory::next_rows(const WorkTime& work) const {
  const uint32_t columns = tile_count(width_), rows = tile_count(height_), wanted = rows_in(work);
  std::vector<uint32_t> turns(rows);
  for (uint32_t row = 0; row < rows; ++row)
    turns[row] = *std::min_element(&turns_[size_t{row} * columns], &turns_[size_t{row} * columns] + columns);
  uint32_t first = rows / 2;
  for (uint32_t row = 0; row < rows; ++row)
    if (turns[row] < turns[first]) first = row;
  TileRows chosen{first, first + 1};
  while (chosen.end - chosen.first < wanted) {
    const bool has_below = chosen.first > 0, has_above = chosen.end < rows;
    if (has_below && (!has_above || turns[chosen.first - 1] < turns[chosen.end])) --chosen.first;
    else ++chosen.end;
  }
  return chosen;
}

// Continues a cell with the history of the surface at one of its pixels, which was at `from`; returns false if there is
// none.
bool IrradianceHistory::carry(glm::uvec2 pixel, uint32_t from) {
  if (from == PixelTrail::nowhere) return false;
  const FrameCamera& camera = trail_.camera();
  const size_t then = size_t{from / width_ / cell_side} * after_.columns + from % width_ / cell_side;
  CellPlace was = before_.places[then];
  was.position += moved_;
  // The cell's traced pixel may have shown another surface.
  const double depth = trail_.depths()[size_t{pixel.y} * width_ + pixel.x];
  if (!(plane_share(was, glm::vec3(camera.origin_at(pixel) + depth * camera.ray_at(pixel))) > 0.0f)) return false;
  const size_t cell = size_t{pixel.y / cell_side} * after_.columns + pixel.x / cell_side;
  after_.places[cell] = was;
  after_.lights[cell] = before_.lights[then];
  after_.lights[cell].samples = std::min(after_.lights[cell].samples, counted_);
  return true;
}

void IrradianceHistory::carry_cells(Executor& executor) {
  executor.run(after_.rows, [&](size_t row, uint32_t) {
    std::fill_n(&after_.places[row * after_.columns], after_.columns, CellPlace{});
    std::fill_n(&after_.lights[row * after_.columns], after_.columns, CellLight{});
    const uint32_t y = static_cast<uint32_t>(row) * cell_side, above = std::min(y + 1, height_ - 1);
    PixelTrail::Row from, from_above;
    for (uint32_t x0 = 0; follows_ && x0 < width_; x0 += frame_tile_size) {
      const uint32_t pixels = std::min(frame_tile_size, width_ - x0);
      trail_.look_back(x0, y, pixels, from);
      trail_.look_back(x0, above, pixels, from_above);
      for (uint32_t i = 0; i < pixels; i += cell_side) {
        const uint32_t beside = std::min(i + 1, pixels - 1);
        (void)(carry({x0 + i, y}, from[i]) || carry({x0 + beside, y}, from[beside]) ||
               carry({x0 + i, above}, from_above[i]) || carry({x0 + beside, above}, from_above[beside]));
      }
    }
  });
}

void IrradianceHistory::carry_image(PixelRows but, Executor& executor, IrradianceImage& image) {
  const size_t halfs = size_t{4} * width_ * height_;
  std::swap(image.light, light_then_);
  image.light.resize(halfs);
  const bool known = follows_ && light_then_.size() == halfs;
  executor.run(height_, [&](size_t row, uint32_t) {
    const auto y = static_cast<uint32_t>(row);
    if (y >= but.first && y < but.end) return;
    PixelTrail::Row from;
    for (uint32_t x0 = 0; x0 < width_; x0 += frame_tile_size) {
      const uint32_t pixels = std::min(frame_tile_size, width_ - x0);
      uint16_t* light = &image.light[4 * (row * width_ + x0)];
      std::fill_n(light, 4 * pixels, uint16_t{0});
      if (!known) continue;
      trail_.look_back(x0, y, pixels, from);
      for (uint32_t i = 0; i < pixels; ++i)
        if (from[i] != PixelTrail::nowhere) std::copy_n(&light_then_[size_t{4} * from[i]], 4, light + size_t{4} * i);
    }
  });
}

}  // namespace sideray::rt
