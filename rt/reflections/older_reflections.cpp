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
  moves_ = follows(r, *committed) && image.radiance.size() == 4 * pixels;
  known_ = false;
  number_ = moves_ ? number_ + 1 : 1;
  if (!moves_) turns_.assign(size_t{tile_count(r.width)} * tile_count(r.height), 0);
  trail_.begin(r.view, r.depth, {r.width, r.height}, scene.shading().snapshot->origin, moves_, scene.executor());
  std::swap(image.radiance, then_);
  std::swap(ages_, ages_then_);
  image.radiance.resize(4 * pixels);
  ages_.resize(pixels);
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
  for (uint8_t& answer : answers) answer = static_cast<uint8_t>(answer + (answer != 0 && answer != no_answer));
  return answers;
}

void OlderReflections::traced(size_t tile) {
  turns_[tile] = number_;
  for_rows(tile, [&](uint32_t x, uint32_t y, uint32_t count) {
    std::fill_n(&ages_[size_t{y} * width_ + x], count, uint8_t{0});
  });
}

void OlderReflections::leave(const ReflectionRequest& r, size_t tile, ReflectionImage& image, Counters& counters) {
  for_rows(tile, [&](uint32_t x, uint32_t y, uint32_t count) {
    const size_t first = size_t{y} * width_ + x;
    std::array<bool, frame_tile_size> mirror;
    bool any = false;
    for (uint32_t i = 0; i < count; ++i) {
      mirror[i] = trail_.depths()[first + i] > 0.0f &&
                  reflection_share(r.normals.roughness(first + i), r.max_roughness) > 0.0f;
      any = any || mirror[i];
    }
    if (any) counters.frames_waiting = std::max<uint64_t>(counters.frames_waiting, number_ - turns_[tile]);
    if (!any) {  // the case in most of a picture
      std::fill_n(&ages_[first], count, no_answer);
      std::fill_n(&image.radiance[4 * first], 4 * count, uint16_t{0});
      return;
    }
    PixelTrail::Row from;
    from.fill(PixelTrail::nowhere);
    if (moves_) trail_.look_back(x, y, count, from);
    for (uint32_t i = 0; i < count; ++i) {
      const size_t texel = first + i, then = from[i];
      const bool mirrors = mirror[i], known = then != PixelTrail::nowhere && ages_then_[then] < oldest;
      const bool shows = mirrors && known && then_[4 * then + 3] != 0;
      ages_[texel] = shows ? static_cast<uint8_t>(ages_then_[then] + 1) : no_answer;
      for (size_t c = 0; c < 4; ++c) image.radiance[4 * texel + c] = shows ? then_[4 * then + c] : uint16_t{0};
      counters.reflection_pixels_older += shows;
      counters.reflection_pixels_late += mirrors && !shows;
      if (shows) counters.answer_age = std::max<uint64_t>(counters.answer_age, ages_[texel]);
    }
  });
}

}  // namespace sideray::rt
