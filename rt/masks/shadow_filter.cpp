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

// Returns the same of a mask of bytes.
const float* unpacked_row(const ShadowFilterInput& input, uint32_t x, uint32_t y, float (&copy)[side]) {
  const uint8_t* from = input.mask.data() + size_t{y} * input.width + x;
  const uint32_t count = std::min(side, input.width - x);
  for (uint32_t i = 0; i < count; ++i) copy[i] = static_cast<float>(from[i]) * (1.0f / 255.0f);
  std::fill_n(copy + count, side - count, 1.0f);
  return copy;
}

uint8_t packed(float visibility) {
  return static_cast<uint8_t>(visibility * 255.0f + 0.5f);
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
  const size_t seen = input.mask.empty() ? input.visibility.size() : input.mask.size();
  if (texels == 0 || seen != texels || input.hit_distance.size() != texels || input.depth.size() != texels ||
      (!input.motion.empty() && input.motion.size() != texels))
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

// Returns what the pixels of a tile and of its neighbours are.
int ShadowFilter::seen_around(const ShadowFilterInput& input, uint32_t tile_x, uint32_t tile_y) const {
  if (input.seen.empty()) return 3;
  int around = 0;
  for (uint32_t y = tile_y - (tile_y > 0); y < std::min(tiles_y_, tile_y + 2); ++y)
    for (uint32_t x = tile_x - (tile_x > 0); x < std::min(tiles_x_, tile_x + 2); ++x)
      around |= input.seen[size_t{y} * tiles_x_ + x];
  return around;
}

// Returns whether a tile, or a neighbour that looks at it, may change.
bool ShadowFilter::is_needed(const ShadowFilterInput& input, uint32_t tile_x, uint32_t tile_y) const {
  for (uint32_t y = tile_y - (tile_y > 0); y < std::min(tiles_y_, tile_y + 2); ++y)
    for (uint32_t x = tile_x - (tile_x > 0); x < std::min(tiles_x_, tile_x + 2); ++x)
      if (seen_around(input, x, y) == 3) return true;
  return false;
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
    kernels_->load(input.mask.empty() ? row_of(input.visibility, input, x, y, 1.0f, copies[0])
                                      : unpacked_row(input, x, y, copies[0]),
                   row_of(input.hit_distance, input, x, y, 0.0f, copies[1]),
                   row_of(input.depth, input, x, y, 0.0f, copies[2]), to, at(x, y), columns);
  Tile& tile = tiles_[size_t{tile_y} * tiles_x_ + tile_x];
  tile = {1.0f, 0.0f, 0.0f, 0.0f, 0.0f, false, true};
  for (uint32_t i = 0; i < side; ++i) {
    tile.least = std::min(tile.least, columns.least[i]);
    tile.most = std::max(tile.most, columns.most[i]);
    tile.distances += columns.distances[i];
    tile.hits += columns.hits[i];
  }
}

// `may_change`: false where its pixels and its neighbours' are known to be all lit or all in shadow.
void ShadowFilter::classify(const ShadowTerms& terms, uint32_t tile_x, uint32_t tile_y, bool may_change) {
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
  tile.active = may_change && least < 1.0f && most > 0.0f;
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

// Works on a row of tiles in one of the stages.
void ShadowFilter::work(Stage stage, int pass, const ShadowFilterInput& input, bool whole, uint32_t y) {
  const ShadowTerms terms = terms_of(input);
  for (uint32_t x = 0; x < tiles_x_; ++x) {
    Tile& tile = tiles_[size_t{y} * tiles_x_ + x];
    if (stage == load_stage) {
      const bool loads = whole || is_needed(input, x, y);
      if (loads)
        load(input, x, y);
      else
        tile = {input.seen[size_t{y} * tiles_x_ + x] == 1 ? 0.0f : 1.0f, 0.0f, 0.0f, 0.0f, 0.0f, false, false};
    } else if (stage == classify_stage) {
      if (tile.loaded) classify(terms, x, y, whole || seen_around(input, x, y) == 3);
    } else {
      blur(x, y, 1 << pass);
    }
  }
}

void ShadowFilter::spatial(Executor& executor, std::span<ShadowFilter* const> filters,
                           std::span<const ShadowFilterInput> inputs, bool whole) {
  if (filters.empty()) return;
  for (size_t i = 0; i < filters.size(); ++i) {
    filters[i]->fit(inputs[i]);
    filters[i]->whole_ = whole || inputs[i].seen.empty();
  }
  const size_t rows = filters[0]->tiles_y_;
  const auto run = [&](Stage stage, int pass) {
    executor.run(rows * filters.size(), [&](size_t piece, uint32_t) {
      ShadowFilter& filter = *filters[piece / rows];
      filter.work(stage, pass, inputs[piece / rows], filter.whole_, static_cast<uint32_t>(piece % rows));
    });
  };
  run(load_stage, 0);
  run(classify_stage, 0);
  for (int pass = 0; pass < passes; ++pass) {
    run(blur_stage, pass);
    for (ShadowFilter* filter : filters) filter->planes_[visibility].swap(filter->planes_[filtered]);
  }
}

void ShadowFilter::spatial(Executor& executor, const ShadowFilterInput& input, std::span<float> result) {
  ShadowFilter* const self = this;
  spatial(executor, {&self, 1}, {&input, 1}, true);
  store(executor, planes_[visibility].data(), result);
}

void ShadowFilter::store_row(uint8_t* mask, bool accumulated, uint32_t tile_y) const {
  const float* plane = accumulated ? history_[current_][value].data() : planes_[visibility].data();
  for (uint32_t tile_x = 0; tile_x < tiles_x_; ++tile_x) {
    if (!accumulated && !tiles_[size_t{tile_y} * tiles_x_ + tile_x].active) continue;
    const uint32_t x = tile_x * side, count = std::min(side, width_ - x);
    for (uint32_t y = tile_y * side; y < std::min(height_, (tile_y + 1) * side); ++y)
      std::transform(plane + at(x, y), plane + at(x, y) + count, mask + size_t{y} * width_ + x, packed);
  }
}

void ShadowFilter::store(Executor& executor, std::span<ShadowFilter* const> filters, std::span<uint8_t* const> masks,
                         bool accumulated) {
  if (filters.empty()) return;
  const size_t rows = filters[0]->tiles_y_;
  executor.run(rows * filters.size(), [&](size_t piece, uint32_t) {
    filters[piece / rows]->store_row(masks[piece / rows], accumulated, static_cast<uint32_t>(piece % rows));
  });
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

void ShadowFilter::follow(const shading::SfLight& light, std::span<const float> depth) {
  if (width_ == 0 || follows_) return;
  if (!whole_) load_rest(depth);
  const ShadowHistoryPlanes after = history(current_);
  std::copy(planes_[visibility].begin(), planes_[visibility].end(), after.value);
  std::copy(planes_[inverse].begin(), planes_[inverse].end(), after.inverse);
  for (uint32_t y = 0; y < height_; ++y)
    for (uint32_t x = 0; x < tiles_x_; ++x)
      std::fill_n(after.frames + at(x * side, y), side,
                  tiles_[size_t{y / side} * tiles_x_ + x].active ? 1.0f : light.most_frames);
  follows_ = true;
}

// Fills the planes where spatial() left tiles out.
void ShadowFilter::load_rest(std::span<const float> depth) {
  ShadowFilterInput last;
  last.width = width_;
  last.height = height_;
  last.depth = depth;
  if (depth.size() != size_t{width_} * height_)
    fail(SIDERAY_INVALID_ARGUMENT, "shadow filter: the depth is not {} x {}; give the last frame's", width_, height_);
  const ShadowPlanes to = planes();
  const std::vector<float> none(side, std::numeric_limits<float>::infinity());
  ShadowColumns columns{};
  float seen[side], copy[side];
  for (uint32_t y = 0; y < height_; ++y)
    for (uint32_t x = 0; x < tiles_x_; ++x) {
      const Tile& tile = tiles_[size_t{y / side} * tiles_x_ + x];
      if (tile.loaded) continue;
      std::fill_n(seen, side, tile.least);
      std::fill_n(seen + std::min(side, width_ - x * side), side - std::min(side, width_ - x * side), 1.0f);
      kernels_->load(seen, none.data(), row_of(depth, last, x * side, y, 0.0f, copy), to, at(x * side, y), columns);
    }
}

void ShadowFilter::temporal(Executor& executor, const ShadowFilterInput& input, std::span<float> result, bool again) {
  temporal(executor, input, again);
  store(executor, history_[current_][value].data(), result);
}

void ShadowFilter::temporal(Executor& executor, const ShadowFilterInput& input, bool again) {
  if (input.width != width_ || input.height != height_)
    fail(SIDERAY_INVALID_ARGUMENT, "shadow filter: no frame of {} x {} was filtered; call spatial() first", input.width,
         input.height);
  if (!follows_) std::fill(history_[current_][inverse_then].begin(), history_[current_][inverse_then].end(), 0.0f);
  if (!again || !follows_) current_ = 1 - current_;
  const ShadowTerms terms = terms_of(input);
  for_tiles(executor, [&](uint32_t x, uint32_t y) { accumulate(terms, input, x, y); });
  follows_ = true;
}

uint32_t ShadowFilter::active_tiles() const {
  return static_cast<uint32_t>(std::count_if(tiles_.begin(), tiles_.end(), [](const Tile& t) { return t.active; }));
}

}  // namespace sideray::rt
