#include "rt/irradiance/irradiance_history.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "rt/base/pixels.h"
#include "rt/scene/scene_difference.h"

namespace sideray::rt {
namespace {

constexpr float most_samples_moving = 8.0f;  // for cells lit by something that moves, which must follow it
constexpr float same_facing = 0.9f;  // cosine

// Copies the light of a row's pixels from where they were, none from nowhere. Returns how many have light; its fourth
// half is their mark.
uint32_t carry_row(const uint32_t* from, uint32_t count, const uint16_t* then, uint16_t* light) {
  for_runs(from, count, [&](uint32_t first, uint32_t length, uint32_t there) {
    uint16_t* to = light + size_t{4} * first;
    if (there == PixelTrail::nowhere) std::fill_n(to, size_t{4} * length, uint16_t{0});
    else std::copy_n(then + size_t{4} * there, size_t{4} * length, to);
  });
  uint32_t carried = 0;
  for (uint32_t i = 0; i < count; ++i) carried += light[size_t{4} * i + 3] != 0;
  return carried;
}

}  // namespace

void IrradianceHistory::begin(const IrradianceRequest& r, TracedScene& scene) {
  std::shared_ptr<const model::Snapshot> committed = scene.committed();
  again_ = r.sequence == SequenceStep::again && width_ == r.width && height_ == r.height && number_ > 0;
  if (again_) {
    settled_ = settled_ && FrameCamera(r.view, r.width, r.height).sees_as(trail().camera());
    return;
  }
  follows_ = known_ && r.sequence != SequenceStep::first && r.width == width_ && r.height == height_ &&
             r.shadows == shadows_ && differ_in_places_only(*committed_, *committed);
  changed_ = changed_ || committed_ != committed;
  known_ = false;
  origin_ = scene.shading().snapshot->origin;
  number_ = follows_ ? number_ + 1 : 1;
  if (!follows_) turns_.assign(size_t{tile_count(r.width)} * tile_count(r.height), 0);
  width_ = r.width, height_ = r.height, shadows_ = r.shadows;
  committed_ = std::move(committed);
  cells_known_ = cells_known_ && follows_;
  cells_begun_ = false;
  const bool was_in_parts = std::exchange(in_parts_, is_bounded(r.work) && r.position_frames == 0);
  if (in_parts_) {
    shown_ = r.frame.trail ? r.frame.trail : &own_trail_;
    shown_->begin({r.view, r.depth, {width_, height_}, origin_, r.sequence != SequenceStep::first, r.frame.number},
                  scene.executor());
    carries_image_ = shown_->follows(std::exchange(step_, shown_->step())) && was_in_parts && follows_;
  } else {
    begin_cells(r, scene.executor());
  }
  stands_still_ = follows_ && trail().same_view() && posed_ == scene.shading().snapshot;
  if (!stands_still_) turns_at_rest_.assign(turns_.size(), 0);
  settled_ = r.position_frames == 0 && std::ranges::all_of(turns_at_rest_, [](uint8_t turns) { return turns == most_samples; });
  posed_ = scene.shading().snapshot;
}

void IrradianceHistory::begin_cells(const IrradianceRequest& r, Executor& executor) {
  counted_ = changed_ ? most_samples_moving : static_cast<float>(most_samples);
  changed_ = false;
  cells_follow_ = cells_known_;
  cells_begun_ = true;
  moved_ = glm::vec3(cells_origin_ - origin_);
  cells_origin_ = origin_;
  // The frames of a position fill the same cells.
  if (!(cells_follow_ && r.position_frames > 1)) std::swap(before_, after_);
  after_.fit(width_, height_);
  const std::span<const float> depths = in_parts_ ? std::span<const float>(shown_->depths()) : std::span<const float>();
  trail_.begin({r.view, r.depth, {width_, height_}, origin_, cells_follow_, 0, depths}, executor);
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
      if (!cells_follow_ || !(place.width > 0.0f)) continue;
      const uint32_t from = *trail_.from(pixels[cell].x, pixels[cell].y);
      if (from == PixelTrail::nowhere) continue;
      const size_t then = size_t{from / width_ / cell_side} * cells.columns + from % width_ / cell_side;
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
  intersector.occluded(scratch.rays, false, scratch.occluded.data(), OpaqueSet::walls);
  for (size_t i = 0; i < scratch.cells.size(); ++i)
    if (scratch.occluded[i]) cells.lights[scratch.cells[i]] = {};
}

void IrradianceHistory::keep() {
  std::ranges::fill(turns_, number_);
  if (again_) return;
  if (cells_begun_) std::swap(before_, after_);
  known_ = true;
}

void IrradianceHistory::end() {
  if (again_) return;
  known_ = true;
  cells_known_ = cells_known_ || cells_begun_;
}

uint32_t IrradianceHistory::rows_in(const WorkTime& work) const {
  const uint32_t columns = tile_count(width_), rows = tile_count(height_);
  if (work.pieces) return std::clamp<uint32_t>(static_cast<uint32_t>(std::max(work.pieces->load(), int64_t{0})) / columns, 1, rows);
  if (!has_deadline(work.deadline)) return rows;
  const uint32_t least = is_over(work) ? 0 : 1;
  if (row_ms_ <= 0.0) return least;
  const double left = std::chrono::duration<double, std::milli>(work.deadline - Deadline::clock::now()).count();
  return static_cast<uint32_t>(std::clamp(left / row_ms_, static_cast<double>(least), static_cast<double>(rows)));
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
  if (wanted == 0) return {};
  TileRows chosen{first, first + 1};
  while (chosen.end - chosen.first < wanted) {
    const bool has_below = chosen.first > 0, has_above = chosen.end < rows;
    if (has_below && (!has_above || turns[chosen.first - 1] < turns[chosen.end])) --chosen.first;
    else ++chosen.end;
  }
  return chosen;
}

// Gives a cell the history of the surface that one of its pixels shows. Returns false if there is none.
bool IrradianceHistory::carry(glm::uvec2 pixel) {
  const uint32_t from = *trail_.from(pixel.x, pixel.y);
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

void IrradianceHistory::carry_cells(const IrradianceRequest& r, Executor& executor) {
  if (in_parts_) begin_cells(r, executor);
  executor.run(after_.rows, [&](size_t row, uint32_t) {
    const uint32_t y = static_cast<uint32_t>(row) * cell_side, above = std::min(y + 1, height_ - 1);
    for (uint32_t column = 0; column < after_.columns; ++column) {
      const uint32_t x = column * cell_side, beside = std::min(x + 1, width_ - 1);
      if (cells_follow_ && (carry({x, y}) || carry({beside, y}) || carry({x, above}) || carry({beside, above})))
        continue;
      after_.places[row * after_.columns + column] = {};
      after_.lights[row * after_.columns + column] = {};
    }
  });
}

void IrradianceHistory::begin_image(IrradianceImage& image) {
  std::swap(image.light, light_then_);
  image.light.resize(size_t{4} * width_ * height_);
  carries_image_ = carries_image_ && light_then_.size() == image.light.size();
}

void IrradianceHistory::carry_tile(uint32_t tile, IrradianceImage& image, Counters& counters) const {
  const uint32_t columns = tile_count(width_), x0 = tile % columns * frame_tile_size,
                 y0 = tile / columns * frame_tile_size;
  const uint32_t across = std::min(frame_tile_size, width_ - x0);
  for (uint32_t y = y0; y < std::min(y0 + frame_tile_size, height_); ++y) {
    const uint32_t* from = shown_->from(x0, y);
    const float* depth = &depths()[size_t{y} * width_ + x0];
    uint16_t* light = &image.light[4 * (size_t{y} * width_ + x0)];
    uint32_t older = 0, drawn = 0;
    for (uint32_t i = 0; i < across; ++i) drawn += depth[i] > 0.0f;
    if (carries_image_) older = carry_row(from, across, light_then_.data(), light);
    else std::fill_n(light, size_t{4} * across, uint16_t{0});
    counters.irradiance_pixels_older += older;
    counters.irradiance_pixels_late += drawn - older;
    if (drawn > 0) counters.frames_waiting = std::max<uint64_t>(counters.frames_waiting, number_ - turns_[tile]);
  }
}

}  // namespace sideray::rt
