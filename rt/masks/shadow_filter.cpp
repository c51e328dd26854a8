#include "rt/masks/shadow_filter.h"

#include <algorithm>
#include <limits>

#include "model/failure.h"

// Four passes of a-trous wavelets reach 15 pixels: a tile whose neighbours are, like it, all lit or all in shadow
// cannot change, and is skipped.
namespace sideray::rt {
namespace {

constexpr uint32_t side = shadow_tile;
constexpr int passes = 4;

ShadowTerms terms_of(const ShadowFilterInput& input) {
  const shading::SfLight& light = input.light;
  const shading::SfView& view = input.view;
  return {{light.position.x, light.position.y, light.position.z},
          light.radius,
          light.tan_radius,
          light.most_penumbra,
          light.most_frames,
          view.origin_x,
          view.origin_y,
          view.step_x,
          view.step_y,
          {view.before.x, view.before.y, view.before.z},
          view.before_offset};
}

// Returns sixteen values from (x, y) on; `otherwise` right of the picture.
const float* row_of(std::span<const float> image, const ShadowFilterInput& input, uint32_t x, uint32_t y,
                    float otherwise, float (&copy)[side]) {
  const float* from = image.data() + size_t{y} * input.width + x;
  if (x + side <= input.width) return from;
  std::fill_n(copy, side, otherwise);
  std::copy_n(from, input.width - x, copy);
  return copy;
}

}  // namespace

int32_t ShadowFilter::at(uint32_t x, uint32_t y) const {
  return static_cast<int32_t>(y + side) * stride_ + static_cast<int32_t>(x + side);
}

ShadowPlanes ShadowFilter::planes() {
  return {planes_[visibility].data(), planes_[filtered].data(), planes_[nearness].data(), planes_[inverse].data(),
          planes_[slope_x].data(),    planes_[slope_y].data(),  planes_[reach].data(),    stride_};
}

ShadowHistoryPlanes ShadowFilter::history(uint32_t which) {
  return {history_[which][value].data(), history_[which][frames].data(), history_[which][inverse_then].data()};
}

void ShadowFilter::fit(const ShadowFilterInput& input) {
  const size_t texels = size_t{input.width} * input.height;
  if (texels == 0 || input.visibility.size() != texels || input.hit_distance.size() != texels ||
      input.depth.size() != texels || (!input.motion.empty() && input.motion.size() != texels))
    fail(SIDERAY_INVALID_ARGUMENT, "shadow filter: images are not {} x {}; give all of one size", input.width,
         input.height);
  if (input.width == width_ && input.height == height_) return;
  width_ = input.width;
  height_ = input.height;
  tiles_x_ = (width_ + side - 1) / side;
  tiles_y_ = (height_ + side - 1) / side;
  stride_ = static_cast<int32_t>((tiles_x_ + 2) * side);
  const size_t size = static_cast<size_t>(stride_) * (tiles_y_ + 2) * side;
  if (size > static_cast<size_t>(std::numeric_limits<int32_t>::max()))
    fail(SIDERAY_INVALID_ARGUMENT, "shadow filter: {} x {} pixels are too many; use a smaller picture", width_,
         height_);
  tiles_.assign(size_t{tiles_x_} * tiles_y_, {});
  for (std::vector<float>& plane : planes_) plane.assign(size, 0.0f);
  for (auto& frame : history_)
    for (std::vector<float>& plane : frame) plane.assign(size, 0.0f);
  follows_ = false;
}

// Runs one row of tiles as a piece of work.
template <typename Work>
void ShadowFilter::for_tiles(Executor& executor, const Work& work) {
  executor.run(tiles_y_, [&](size_t y, uint32_t) {
    for (uint32_t x = 0; x < tiles_x_; ++x) work(x, static_cast<uint32_t>(y));
  });
}

void ShadowFilter::load(const ShadowFilterInput& input, uint32_t tile_x, uint32_t tile_y) {
  const ShadowPlanes to = planes();
  ShadowColumns columns;
  std::fill_n(columns.least, side, 1.0f);
  std::fill_n(columns.most, side, 0.0f);
  std::fill_n(columns.distances, side, 0.0f);
  std::fill_n(columns.hits, side, 0.0f);
  float copies[3][side];
  const uint32_t x = tile_x * side;
  for (uint32_t y = tile_y * side; y < std::min(height_, (tile_y + 1) * side); ++y)
    kernels_->load(row_of(input.visibility, input, x, y, 1.0f, copies[0]),
                   row_of(input.hit_distance, input, x, y, 0.0f, copies[1]),
                   row_of(input.depth, input, x, y, 0.0f, copies[2]), to, at(x, y), columns);
  Tile& tile = tiles_[size_t{tile_y} * tiles_x_ + tile_x];
  tile = {1.0f, 0.0f, 0.0f, 0.0f, 0.0f, false};
  for (uint32_t i = 0; i < side; ++i) {
    tile.least = std::min(tile.least, columns.least[i]);
    tile.most = std::max(tile.most, columns.most[i]);
    tile.distances += columns.distances[i];
    tile.hits += columns.hits[i];
  }
}

void ShadowFilter::classify(const ShadowTerms& terms, uint32_t tile_x, uint32_t tile_y) {
  float least = 1.0f, most = 0.0f, distances = 0.0f, hits = 0.0f;
  for (uint32_t y = tile_y - (tile_y > 0); y < std::min(tiles_y_, tile_y + 2); ++y)
    for (uint32_t x = tile_x - (tile_x > 0); x < std::min(tiles_x_, tile_x + 2); ++x) {
      const Tile& near = tiles_[size_t{y} * tiles_x_ + x];
      least = std::min(least, near.least);
      most = std::max(most, near.most);
      distances += near.distances;
      hits += near.hits;
    }
  Tile& tile = tiles_[size_t{tile_y} * tiles_x_ + tile_x];
  tile.active = least < 1.0f && most > 0.0f;
  alignas(64) float longest[side] = {};
  const ShadowPlanes to = planes();
  const uint32_t x = tile_x * side;
  for (uint32_t y = tile_y * side; y < (tile_y + 1) * side; ++y) {
    const int32_t first = at(x, y);
    if (tile.active)
      kernels_->prepare(terms, to, first, static_cast<int32_t>(x), static_cast<int32_t>(y),
                        hits > 0.0f ? hits / distances : 0.0f, longest);
    else
      std::fill_n(to.reach + first, side, shading::sf_most_reach);
  }
  tile.reach = *std::max_element(longest, longest + side);
}

void ShadowFilter::blur(uint32_t tile_x, uint32_t tile_y, int32_t step) {
  const Tile& tile = tiles_[size_t{tile_y} * tiles_x_ + tile_x];
  if (!tile.active) return;
  const auto distance = static_cast<float>(step);
  const bool reaches = distance * distance < 8.0f * tile.reach * tile.reach;  // sf_bell's end
  const ShadowPlanes to = planes();
  for (uint32_t y = tile_y * side; y < (tile_y + 1) * side; ++y) {
    const int32_t first = at(tile_x * side, y);
    if (reaches)
      kernels_->blur(to, first, step);
    else
      std::copy_n(to.visibility + first, side, to.filtered + first);
  }
}

void ShadowFilter::store(Executor& executor, const float* plane, std::span<float> result) {
  if (result.size() != size_t{width_} * height_)
    fail(SIDERAY_INVALID_ARGUMENT, "shadow filter: the result is not {} x {}; give one of the images' size", width_,
         height_);
  executor.run(tiles_y_, [&](size_t tile, uint32_t) {
    const auto first = static_cast<uint32_t>(tile) * side;
    for (uint32_t y = first; y < std::min(height_, first + side); ++y)
      std::copy_n(plane + at(0, y), width_, result.data() + size_t{y} * width_);
  });
}

void ShadowFilter::spatial(Executor& executor, const ShadowFilterInput& input, std::span<float> result) {
  fit(input);
  const ShadowTerms terms = terms_of(input);
  for_tiles(executor, [&](uint32_t x, uint32_t y) { load(input, x, y); });
  for_tiles(executor, [&](uint32_t x, uint32_t y) { classify(terms, x, y); });
  for (int pass = 0; pass < passes; ++pass) {
    for_tiles(executor, [&](uint32_t x, uint32_t y) { blur(x, y, 1 << pass); });
    planes_[visibility].swap(planes_[filtered]);
  }
  store(executor, planes_[visibility].data(), result);
}

// Pixels that are all lit or all in shadow are so for certain: as good as many frames.
void ShadowFilter::accumulate(const ShadowTerms& terms, const ShadowFilterInput& input, uint32_t tile_x,
                              uint32_t tile_y) {
  const ShadowPlanes from = planes();
  const ShadowHistoryPlanes before = history(1 - current_), after = history(current_);
  const bool active = tiles_[size_t{tile_y} * tiles_x_ + tile_x].active;
  const uint32_t x = tile_x * side;
  float motion[2 * side] = {};
  for (uint32_t y = tile_y * side; y < std::min(height_, (tile_y + 1) * side); ++y) {
    const int32_t first = at(x, y);
    if (!active) {
      std::copy_n(from.visibility + first, side, after.value + first);
      std::copy_n(from.inverse + first, side, after.inverse + first);
      std::fill_n(after.frames + first, side, terms.light_most_frames);
      continue;
    }
    for (uint32_t i = 0; !input.motion.empty() && i < std::min(side, width_ - x); ++i) {
      const glm::vec2 moved = input.motion[size_t{y} * width_ + x + i];
      motion[i] = moved.x;
      motion[side + i] = moved.y;
    }
    kernels_->accumulate(terms, from, before, after, motion, at(0, 0), static_cast<int32_t>(x), static_cast<int32_t>(y),
                         static_cast<int32_t>(width_), static_cast<int32_t>(height_));
  }
}

void ShadowFilter::follow(const shading::SfLight& light) {
  if (width_ == 0 || follows_) return;
  const ShadowHistoryPlanes after = history(current_);
  std::copy(planes_[visibility].begin(), planes_[visibility].end(), after.value);
  std::copy(planes_[inverse].begin(), planes_[inverse].end(), after.inverse);
  for (uint32_t y = 0; y < height_; ++y)
    for (uint32_t x = 0; x < tiles_x_; ++x)
      std::fill_n(after.frames + at(x * side, y), side,
                  tiles_[size_t{y / side} * tiles_x_ + x].active ? 1.0f : light.most_frames);
  follows_ = true;
}

void ShadowFilter::temporal(Executor& executor, const ShadowFilterInput& input, std::span<float> result, bool again) {
  if (input.width != width_ || input.height != height_)
    fail(SIDERAY_INVALID_ARGUMENT, "shadow filter: no frame of {} x {} was filtered; call spatial() first", input.width,
         input.height);
  if (!follows_) std::fill(history_[current_][inverse_then].begin(), history_[current_][inverse_then].end(), 0.0f);
  if (!again || !follows_) current_ = 1 - current_;
  const ShadowTerms terms = terms_of(input);
  for_tiles(executor, [&](uint32_t x, uint32_t y) { accumulate(terms, input, x, y); });
  follows_ = true;
  store(executor, history_[current_][value].data(), result);
}

uint32_t ShadowFilter::active_tiles() const {
  return static_cast<uint32_t>(std::count_if(tiles_.begin(), tiles_.end(), [](const Tile& t) { return t.active; }));
}

}  // namespace sideray::rt
