#include "rt/reflections/older_reflections.h"

#include <algorithm>
#include <array>
#include <utility>

#include "rt/base/pixels.h"
#include "rt/reflections/reflection_tracing.h"
#include "rt/scene/scene_difference.h"

namespace sideray::rt {

bool OlderReflections::follows(const ReflectionRequest& r, const model::Snapshot& committed) const {
  return known_ && r.sequence != SequenceStep::first && r.width == width_ && r.height == height_ &&
         r.max_roughness == max_roughness_ && r.shadows == shadows_ && r.light_bounces == light_bounces_ && r.denoise == denoise_ &&
         differ_in_places_only(*committed_, committed);
}

void OlderReflections::begin(const ReflectionRequest& r, TracedScene& scene, ReflectionImage& image) {
  std::shared_ptr<const model::Snapshot> committed = scene.committed();
  const size_t pixels = size_t{r.width} * r.height;
  trail_ = r.frame.trail ? r.frame.trail : &own_trail_;
  trail_->begin({r.view, r.depth, {r.width, r.height}, scene.shading().snapshot->origin,
                 r.sequence != SequenceStep::first, r.frame.number},
                scene.executor());
  moves_ = trail_->follows(std::exchange(step_, trail_->step())) && follows(r, *committed) &&
           image.radiance.size() == 4 * pixels;
  known_ = false;
  step_of_age_ = trail_->same_lines() && committed == committed_ ? 0 : 1;
  number_ = moves_ ? number_ + 1 : 1;
  if (!moves_) turns_.assign(size_t{tile_count(r.width)} * tile_count(r.height), 0);
  std::swap(image.radiance, then_);
  std::swap(ages_, ages_then_);
  std::swap(empty_, empty_then_);
  image.radiance.resize(4 * pixels);
  ages_.resize(pixels);
  if (!moves_) empty_.assign(turns_.size(), 0), empty_then_ = empty_;
  width_ = r.width, height_ = r.height;
  max_roughness_ = r.max_roughness, shadows_ = r.shadows, light_bounces_ = r.light_bounces, denoise_ = r.denoise;
  committed_ = std::move(committed);
}

// Calls work(x, y, pixel count) for each row of a tile.
template <typename Work>
void OlderReflections::for_rows(size_t tile, const Work& work) const {
  const uint32_t columns = tile_count(width_);
  const uint32_t x = static_cast<uint32_t>(tile % columns) * frame_tile_size;
  const uint32_t y = static_cast<uint32_t>(tile / columns) * frame_tile_size;
  for (uint32_t row = y; row < std::min(y + frame_tile_size, height_); ++row)
    work(x, row, std::min(frame_tile_size, width_ - x));
}

std::vector<uint8_t> OlderReflections::answers() const {
  std::vector<uint8_t> answers = ages_;
  for (size_t tile = 0; tile < turns_.size() && !answers.empty(); ++tile) {
    if (turns_[tile] == number_) continue;
    for_rows(tile, [&](uint32_t x, uint32_t y, uint32_t count) {
      for (size_t i = size_t{y} * width_ + x; i < size_t{y} * width_ + x + count; ++i)
        answers[i] = static_cast<uint8_t>(answers[i] + (answers[i] != no_answer));
    });
  }
  return answers;
}

void OlderReflections::traced(size_t tile) {
  turns_[tile] = number_;
  empty_[tile] = 0;
  for_rows(tile, [&](uint32_t x, uint32_t y, uint32_t count) {
    std::fill_n(&ages_[size_t{y} * width_ + x], count, uint8_t{0});
  });
}

// Returns whether a tile's pixels may have shown a reflection in the previous frame.
bool OlderReflections::has_past(size_t tile) const {
  if (!moves_) return false;
  const size_t columns = tile_count(width_);
  const auto& [from, to] = trail_->tiles_from(tile);
  for (uint32_t y = from.y; y <= to.y; ++y)
    for (uint32_t x = from.x; x <= to.x; ++x)
      if (!empty_then_[y * columns + x]) return true;
  return false;
}

void OlderReflections::leave(const ReflectionRequest& r, size_t tile, ReflectionImage& image, Counters& counters) {
  const bool has_past = this->has_past(tile);
  if (!has_past) empty_tile(tile, image);
  uint32_t mirrors = 0, older = 0;
  uint8_t most = 0;
  for_rows(tile, [&](uint32_t x, uint32_t y, uint32_t count) {
    const size_t first = size_t{y} * width_ + x;
    std::array<uint8_t, frame_tile_size> reflects;
    if (!r.normals.find_reflecting(first, count, r.max_roughness, reflects.data())) {  // as in most rows
      if (has_past) empty(first, count, image);
      return;
    }
    for (uint32_t i = 0; i < count; ++i) {
      reflects[i] &= trail_->depths()[first + i] > 0.0f;
      mirrors += reflects[i];
    }
    if (!has_past) return;
    const uint32_t* from = trail_->from(x, y);
    for (uint32_t i = 0; i < count; ++i) {
      const uint32_t then = reflects[i] ? from[i] : PixelTrail::nowhere;
      const bool shows = then != PixelTrail::nowhere && ages_then_[then] < oldest && then_[size_t{4} * then + 3] != 0;
      ages_[first + i] = shows ? static_cast<uint8_t>(ages_then_[then] + step_of_age_) : no_answer;
      if (shows) std::copy_n(&then_[size_t{4} * then], 4, &image.radiance[4 * (first + i)]);
      else std::fill_n(&image.radiance[4 * (first + i)], 4, uint16_t{0});
      older += shows;
      most = std::max(most, shows ? ages_[first + i] : uint8_t{0});
    }
  });
  empty_[tile] = older == 0;
  counters.reflection_pixels_older += older;
  counters.reflection_pixels_late += mirrors - older;
  counters.answer_age = std::max<uint64_t>(counters.answer_age, most);
  if (mirrors > 0) counters.frames_waiting = std::max<uint64_t>(counters.frames_waiting, number_ - turns_[tile]);
}

void OlderReflections::empty_tile(size_t tile, ReflectionImage& image) {
  if (std::exchange(empty_[tile], uint8_t{1})) return;
  for_rows(tile, [&](uint32_t x, uint32_t y, uint32_t count) {
    empty(size_t{y} * width_ + x, count, image);
  });
}

void OlderReflections::empty(size_t first, uint32_t count, ReflectionImage& image) {
  std::fill_n(&ages_[first], count, no_answer);
  std::fill_n(&image.radiance[4 * first], 4 * size_t{count}, uint16_t{0});
}

}  // namespace sideray::rt
