#include "rt/masks/shadow_filter.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "model/failure.h"

// Four passes of a-trous wavelets reach 15 pixels, so a tile that, with its neighbours, is all lit or all in shadow
// cannot change and is skipped. Rows of tiles are processed line by line, because a line is contiguous in memory, while
// the lines of a tile are pages apart.
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

// Returns sixteen values from (x, y) on; `otherwise` fills those beyond the picture.
const float* row_of(std::span<const float> image, uint32_t width, uint32_t x, uint32_t y, float otherwise,
                    float (&copy)[side]) {
  const float* from = image.data() + size_t{y} * width + x;
  if (x + side <= width) return from;
  std::fill_n(copy, side, otherwise);
  std::copy_n(from, width - x, copy);
  return copy;
}

// Does the same for a mask of bytes; 1 beyond the picture.
const float* unpacked_row(std::span<const uint8_t> mask, uint32_t width, uint32_t x, uint32_t y, float (&copy)[side]) {
  const uint8_t* from = mask.data() + size_t{y} * width + x;
  const uint32_t count = std::min(side, width - x);
  for (uint32_t i = 0; i < count; ++i) copy[i] = static_cast<float>(from[i]) * (1.0f / 255.0f);
  std::fill_n(copy + count, side - count, 1.0f);
  return copy;
}

uint8_t packed(float visibility) {
  return static_cast<uint8_t>(visibility * 255.0f + 0.5f);
}

}  // namespace

// Is scratch memory of a thread, for a row of tiles.
struct ShadowFilter::ShadowRow {
  std::vector<ShadowColumns> columns;
  std::vector<ShadowTileReach> reaches;
};

int32_t ShadowFilter::at(uint32_t x, uint32_t y) const {
  return static_cast<int32_t>(y + side) * stride_ + static_cast<int32_t>(x + side);
}

ShadowPlanes ShadowFilter::planes() {
  return {planes_[visibility].data(),
          planes_[filtered].data(),
          planes_[nearness].data(),
          leader_->planes_[reach].data(),
          guide_->inverse.data(),
          guide_->slope_x.data(),
          guide_->slope_y.data(),
          at(0, 0),
          stride_};
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
  row_states_.assign(tiles_y_, {});
  for (ZeroedFloats& plane : planes_) plane.reset(size);
  for (auto& frame : history_)
    for (ZeroedFloats& plane : frame) plane.reset(0);
  follows_ = false;
}

// Allocates the history's memory, which a single picture does not need.
void ShadowFilter::fit_history() {
  for (auto& frame : history_)
    for (ZeroedFloats& plane : frame)
      if (plane.size() == 0) plane.reset(planes_[visibility].size());
}

// Returns the union of the Seen bits of a tile and its neighbours.
int ShadowFilter::seen_around(const ShadowFilterInput& input, uint32_t tile_x, uint32_t tile_y) const {
  if (input.seen.empty()) return 3;
  int around = 0;
  for (uint32_t y = tile_y - (tile_y > 0); y < std::min(tiles_y_, tile_y + 2); ++y)
    for (uint32_t x = tile_x - (tile_x > 0); x < std::min(tiles_x_, tile_x + 2); ++x)
      around |= input.seen[size_t{y} * tiles_x_ + x];
  return around;
}

// Returns whether a tile must be filtered: with its neighbours, it may be neither all lit nor all in shadow.
bool ShadowFilter::may_change(const ShadowFilterInput& input, uint32_t tile_x, uint32_t tile_y) const {
  return (input.unfiltered.empty() || input.unfiltered[size_t{tile_y} * tiles_x_ + tile_x]) &&
         (whole_ || seen_around(input, tile_x, tile_y) == 3);
}

// Returns whether a tile, or a neighbour that reads it, may change.
bool ShadowFilter::is_needed(const ShadowFilterInput& input, uint32_t tile_x, uint32_t tile_y) const {
  for (uint32_t y = tile_y - (tile_y > 0); y < std::min(tiles_y_, tile_y + 2); ++y)
    for (uint32_t x = tile_x - (tile_x > 0); x < std::min(tiles_x_, tile_x + 2); ++x)
      if (may_change(input, x, y)) return true;
  return false;
}

// Decides which tiles of a row are needed.
void ShadowFilter::choose(const ShadowFilterInput& input, uint32_t tile_y) {
  row_states_[tile_y] = {false, false};
  for (uint32_t tile_x = 0; tile_x < tiles_x_; ++tile_x) {
    Tile& tile = tiles_[size_t{tile_y} * tiles_x_ + tile_x];
    tile = {1.0f, 0.0f, 0.0f, 0.0f, 0.0f, false, whole_ || is_needed(input, tile_x, tile_y)};
    row_states_[tile_y].loaded |= tile.loaded;
    if (!tile.loaded && !input.seen.empty() && input.seen[size_t{tile_y} * tiles_x_ + tile_x] == 1) tile.least = 0.0f;
  }
}

// Writes the inverse depths of a row of tiles; if `needed` is given, only of those tiles.
void ShadowFilter::invert(std::span<const float> depth, uint32_t tile_y, std::span<const uint8_t> needed,
                          float* inverse) const {
  float copy[side];
  for (uint32_t y = tile_y * side; y < std::min(height_, (tile_y + 1) * side); ++y)
    for (uint32_t x = 0; x < width_; x += side)
      if (needed.empty() || needed[size_t{tile_y} * tiles_x_ + x / side])
        kernels_->invert(row_of(depth, width_, x, y, 0.0f, copy), inverse + at(x, y));
}

// The neighbours of a tile that may change are needed too, so no slope in use reads depths that were not inverted.
void ShadowFilter::slope(uint32_t tile_y, std::span<const uint8_t> needed) {
  const ShadowPlanes to = planes();
  for (uint32_t y = tile_y * side; y < (tile_y + 1) * side; ++y)
    for (uint32_t x = 0; x < width_; x += side)
      if (needed[size_t{tile_y} * tiles_x_ + x / side]) kernels_->slope(to, at(x, y));
}

// Returns the least visibility, over all masks that share the reach, of sixteen pixels.
const float* ShadowFilter::darkest_row(uint32_t x, uint32_t y, float (&copy)[side]) const {
  std::fill_n(copy, side, 1.0f);
  for (const Sharing& shared : sharing_) {
    float row[side];
    unpacked_row(shared.mask, width_, x, y, row);
    for (uint32_t i = 0; i < side; ++i) copy[i] = std::min(copy[i], row[i]);
  }
  return copy;
}

void ShadowFilter::load(const ShadowFilterInput& input, uint32_t tile_y, ShadowRow& row) {
  if (!row_states_[tile_y].loaded) return;
  row.columns.resize(tiles_x_);
  for (uint32_t tile_x = 0; tile_x < tiles_x_; ++tile_x) {
    ShadowColumns& columns = row.columns[tile_x];
    std::fill_n(columns.least, side, 1.0f);
    std::fill_n(columns.most, side, 0.0f);
    std::fill_n(columns.distances, side, 0.0f);
    std::fill_n(columns.hits, side, 0.0f);
  }
  const ShadowPlanes to = planes();
  for (uint32_t y = tile_y * side; y < std::min(height_, (tile_y + 1) * side); ++y)
    for (uint32_t tile_x = 0; tile_x < tiles_x_; ++tile_x) {
      if (!tiles_[size_t{tile_y} * tiles_x_ + tile_x].loaded) continue;
      float copies[3][side];
      const uint32_t x = tile_x * side;
      const float* const seen = input.mask.empty() ? row_of(input.visibility, width_, x, y, 1.0f, copies[0])
                                                   : unpacked_row(input.mask, width_, x, y, copies[0]);
      const float* const darkest = sharing_.size() > 1 ? darkest_row(x, y, copies[1]) : seen;
      kernels_->load(seen, darkest, row_of(input.hit_distance, width_, x, y, 0.0f, copies[2]), to, at(x, y),
                     row.columns[tile_x]);
    }
  for (uint32_t tile_x = 0; tile_x < tiles_x_; ++tile_x) {
    Tile& tile = tiles_[size_t{tile_y} * tiles_x_ + tile_x];
    if (!tile.loaded) continue;
    const ShadowColumns& columns = row.columns[tile_x];
    for (uint32_t i = 0; i < side; ++i) {
      tile.least = std::min(tile.least, columns.least[i]);
      tile.most = std::max(tile.most, columns.most[i]);
      tile.distances += columns.distances[i];
      tile.hits += columns.hits[i];
    }
  }
}

ShadowFilter::Tile ShadowFilter::around(uint32_t tile_x, uint32_t tile_y) const {
  Tile sum{1.0f, 0.0f, 0.0f, 0.0f, 0.0f, false, false};
  for (uint32_t y = tile_y - (tile_y > 0); y < std::min(tiles_y_, tile_y + 2); ++y)
    for (uint32_t x = tile_x - (tile_x > 0); x < std::min(tiles_x_, tile_x + 2); ++x) {
      const Tile& near = tiles_[size_t{y} * tiles_x_ + x];
      sum.least = std::min(sum.least, near.least);
      sum.most = std::max(sum.most, near.most);
      sum.distances += near.distances;
      sum.hits += near.hits;
    }
  return sum;
}

// Decides which tiles of a row the filter changes, and how far it reaches there.
void ShadowFilter::classify(const ShadowFilterInput& input, uint32_t tile_y, ShadowRow& row) {
  if (leader_ != this || !row_states_[tile_y].loaded) return;
  row.reaches.assign(tiles_x_, {});
  find_active(input, tile_y, row);
  find_reach(input, tile_y, row);
  for (const Sharing& shared : sharing_) {
    if (shared.filter == this) continue;
    shared.filter->row_states_[tile_y].active = row_states_[tile_y].active;
    for (size_t i = size_t{tile_y} * tiles_x_; i < (size_t{tile_y} + 1) * tiles_x_; ++i)
      shared.filter->tiles_[i].active = tiles_[i].active;
  }
}

// Finds the tiles in which some mask varies, and how near their occluders are.
void ShadowFilter::find_active(const ShadowFilterInput& input, uint32_t tile_y, ShadowRow& row) {
  for (uint32_t tile_x = 0; tile_x < tiles_x_; ++tile_x) {
    Tile& tile = tiles_[size_t{tile_y} * tiles_x_ + tile_x];
    if (!tile.loaded) continue;
    const Tile near = around(tile_x, tile_y);
    const bool varies = std::ranges::any_of(sharing_, [&](const Sharing& shared) {
      const Tile seen = shared.filter == this ? near : shared.filter->around(tile_x, tile_y);
      return seen.least < 1.0f && seen.most > 0.0f;
    });
    tile.active = varies && may_change(input, tile_x, tile_y);
    row_states_[tile_y].active |= tile.active;
    row.reaches[tile_x].nearness = near.hits > 0.0f ? near.hits / near.distances : 0.0f;
  }
}

void ShadowFilter::find_reach(const ShadowFilterInput& input, uint32_t tile_y, ShadowRow& row) {
  const ShadowTerms terms = terms_of(input);
  const ShadowPlanes to = planes();
  for (uint32_t y = tile_y * side; y < (tile_y + 1) * side; ++y)
    for (uint32_t tile_x = 0; tile_x < tiles_x_; ++tile_x) {
      const Tile& tile = tiles_[size_t{tile_y} * tiles_x_ + tile_x];
      const uint32_t x = tile_x * side;
      if (tile.active)
        kernels_->prepare(terms, to, static_cast<int32_t>(x), static_cast<int32_t>(y), row.reaches[tile_x]);
      else if (tile.loaded)
        std::fill_n(to.reach + at(x, y), side, shading::sf_most_reach);
    }
  for (uint32_t tile_x = 0; tile_x < tiles_x_; ++tile_x) {
    Tile& tile = tiles_[size_t{tile_y} * tiles_x_ + tile_x];
    if (tile.loaded) tile.reach = std::ranges::max(row.reaches[tile_x].longest);
  }
}

// Returns whether a pass of this step changes anything in a tile, which it does if sf_bell() extends that far.
bool ShadowFilter::reaches(const Tile& tile, int32_t step) {
  const auto distance = static_cast<float>(step);
  return distance * distance < 8.0f * tile.reach * tile.reach;
}

void ShadowFilter::blur(uint32_t tile_y, int32_t step) {
  if (leader_ != this || !row_states_[tile_y].active) return;
  std::array<ShadowPlanes, most_sharing> images;
  for (size_t i = 0; i < sharing_.size(); ++i) images[i] = sharing_[i].filter->planes();
  for (uint32_t y = tile_y * side; y < (tile_y + 1) * side; ++y)
    for (uint32_t tile_x = 0; tile_x < tiles_x_; ++tile_x) {
      const Tile& tile = tiles_[size_t{tile_y} * tiles_x_ + tile_x];
      const int32_t first = at(tile_x * side, y);
      if (!tile.active) continue;
      if (reaches(tile, step))
        kernels_->blur(images.data(), static_cast<int32_t>(sharing_.size()), first, step);
      else if (step > 1 && reaches(tile, step / 2))  // from here on the pass before is the last one
        for (size_t i = 0; i < sharing_.size(); ++i)
          std::copy_n(images[i].visibility + first, side, images[i].filtered + first);
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

// Consecutive masks that name the same hit distances are colours of one light; the first one's filter leads.
void ShadowFilter::share_reach(std::span<ShadowFilter* const> filters, std::span<const ShadowFilterInput> inputs) {
  for (size_t i = 0; i < filters.size(); ++i) {
    ShadowFilter* const before = i > 0 ? filters[i - 1]->leader_ : nullptr;
    const bool shares = before && !inputs[i].mask.empty() && !inputs[i - 1].mask.empty() &&
                        before->sharing_.size() < most_sharing &&
                        inputs[i].hit_distance.data() == inputs[i - 1].hit_distance.data();
    filters[i]->leader_ = shares ? before : filters[i];
    filters[i]->sharing_.clear();
    filters[i]->leader_->sharing_.push_back({filters[i], inputs[i].mask});
  }
}

// Returns the first filter of every depth; the others share its guide.
std::vector<size_t> ShadowFilter::share_guides(std::span<ShadowFilter* const> filters,
                                               std::span<const ShadowFilterInput> inputs) {
  std::vector<size_t> firsts;
  for (size_t i = 0; i < filters.size(); ++i) {
    const auto first =
        std::ranges::find_if(firsts, [&](size_t k) { return inputs[k].depth.data() == inputs[i].depth.data(); });
    ShadowFilter& filter = *filters[i];
    if (first != firsts.end()) {
      filter.guide_ = filters[*first]->guide_;
      continue;
    }
    firsts.push_back(i);
    if (!filter.own_guide_) filter.own_guide_ = std::make_shared<Guide>();
    filter.guide_ = filter.own_guide_;
    const size_t size = filter.planes_[visibility].size();
    if (filter.guide_->width == filter.width_ && filter.guide_->height == filter.height_) continue;
    for (ZeroedFloats* plane : {&filter.guide_->inverse, &filter.guide_->slope_x, &filter.guide_->slope_y}) plane->reset(size);
    filter.guide_->width = filter.width_;
    filter.guide_->height = filter.height_;
  }
  return firsts;
}

// Computes the surfaces that the filters share, in all tiles that one of them loads.
void ShadowFilter::fill_guides(Executor& executor, std::span<ShadowFilter* const> filters,
                               std::span<const ShadowFilterInput> inputs) {
  const std::vector<size_t> guides = share_guides(filters, inputs);
  for (const size_t i : guides) filters[i]->guide_->needed.assign(filters[i]->tiles_.size(), 0);
  for (ShadowFilter* filter : filters)
    std::transform(filter->tiles_.begin(), filter->tiles_.end(), filter->guide_->needed.begin(),
                   filter->guide_->needed.begin(),
                   [](const Tile& tile, uint8_t needed) { return static_cast<uint8_t>(tile.loaded ? 1 : needed); });
  const size_t rows = filters[0]->tiles_y_;
  executor.run(rows * guides.size(), [&](size_t piece, uint32_t) {
    const size_t i = guides[piece / rows];
    Guide& to = *filters[i]->guide_;
    filters[i]->invert(inputs[i].depth, static_cast<uint32_t>(piece % rows), to.needed, to.inverse.data());
  });
  executor.run(rows * guides.size(), [&](size_t piece, uint32_t) {
    ShadowFilter& filter = *filters[guides[piece / rows]];
    filter.slope(static_cast<uint32_t>(piece % rows), filter.guide_->needed);
  });
}

void ShadowFilter::spatial(Executor& executor, std::span<ShadowFilter* const> filters,
                           std::span<const ShadowFilterInput> inputs, bool whole) {
  if (filters.empty()) return;
  for (size_t i = 0; i < filters.size(); ++i) {
    filters[i]->fit(inputs[i]);
    filters[i]->whole_ = whole || (inputs[i].seen.empty() && inputs[i].unfiltered.empty());
  }
  const size_t rows = filters[0]->tiles_y_;
  share_reach(filters, inputs);
  std::vector<ShadowRow> scratch(executor.threads());
  const auto run = [&](const auto& work) {
    executor.run(rows * filters.size(), [&](size_t piece, uint32_t thread) {
      work(piece / rows, static_cast<uint32_t>(piece % rows), scratch[thread]);
    });
  };
  run([&](size_t i, uint32_t y, ShadowRow&) { filters[i]->choose(inputs[i], y); });
  std::vector<size_t> loaded;  // pieces, as run() counts them
  for (size_t piece = 0; piece < rows * filters.size(); ++piece)
    if (filters[piece / rows]->row_states_[piece % rows].loaded) loaded.push_back(piece);
  const auto run_loaded = [&](const auto& work) {
    executor.run(loaded.size(), [&](size_t index, uint32_t thread) {
      work(loaded[index] / rows, static_cast<uint32_t>(loaded[index] % rows), scratch[thread]);
    });
  };
  fill_guides(executor, filters, inputs);
  run_loaded([&](size_t i, uint32_t y, ShadowRow& row) { filters[i]->load(inputs[i], y, row); });
  run_loaded([&](size_t i, uint32_t y, ShadowRow& row) { filters[i]->classify(inputs[i], y, row); });
  for (int pass = 0; pass < passes; ++pass) {
    run_loaded([&](size_t i, uint32_t y, ShadowRow&) { filters[i]->blur(y, 1 << pass); });
    for (ShadowFilter* filter : filters) std::swap(filter->planes_[visibility], filter->planes_[filtered]);
  }
}

void ShadowFilter::spatial(Executor& executor, const ShadowFilterInput& input, std::span<float> result) {
  ShadowFilter* const self = this;
  spatial(executor, {&self, 1}, {&input, 1}, true);
  store(executor, planes_[visibility].data(), result);
}

void ShadowFilter::store_row(uint8_t* mask, bool accumulated, uint32_t tile_y) const {
  if (!accumulated && !row_states_[tile_y].active) return;
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

// Pixels that are all lit or all in shadow are certain, so they count as many frames.
void ShadowFilter::accumulate(const ShadowSequence& sequence, std::span<const glm::vec2> moved, uint32_t tile_y) {
  const ShadowPlanes& from = sequence.planes;
  const ShadowHistoryPlanes& after = sequence.after;
  float motion[2 * side] = {};
  for (uint32_t y = tile_y * side; y < std::min(height_, (tile_y + 1) * side); ++y)
    for (uint32_t x = 0; x < width_; x += side) {
      const int32_t first = at(x, y);
      if (!tiles_[size_t{tile_y} * tiles_x_ + x / side].active) {
        std::copy_n(from.visibility + first, side, after.value + first);
        std::copy_n(from.inverse + first, side, after.inverse + first);
        std::fill_n(after.frames + first, side, sequence.terms.light_most_frames);
        continue;
      }
      for (uint32_t i = 0; !moved.empty() && i < std::min(side, width_ - x); ++i) {
        const glm::vec2 pixel = moved[size_t{y} * width_ + x + i];
        motion[i] = pixel.x;
        motion[side + i] = pixel.y;
      }
      kernels_->accumulate(sequence, motion, static_cast<int32_t>(x), static_cast<int32_t>(y));
    }
}

void ShadowFilter::follow(const shading::SfLight& light, std::span<const float> depth) {
  if (width_ == 0 || follows_) return;
  if (depth.size() != size_t{width_} * height_)
    fail(SIDERAY_INVALID_ARGUMENT, "shadow filter: the depth is not {} x {}; give the last frame's", width_, height_);
  fit_history();
  const ShadowHistoryPlanes after = history(current_);
  std::copy_n(planes_[visibility].data(), planes_[visibility].size(), after.value);
  for (uint32_t tile_y = 0; tile_y < tiles_y_; ++tile_y) invert(depth, tile_y, {}, after.inverse);
  for (uint32_t y = 0; y < height_; ++y)
    for (uint32_t x = 0; x < tiles_x_; ++x) {
      const Tile& tile = tiles_[size_t{y / side} * tiles_x_ + x];
      if (!tile.loaded) std::fill_n(after.value + at(x * side, y), side, tile.least);
      std::fill_n(after.frames + at(x * side, y), side, tile.active ? 1.0f : light.most_frames);
    }
  follows_ = true;
}

void ShadowFilter::temporal(Executor& executor, const ShadowFilterInput& input, std::span<float> result, bool again) {
  temporal(executor, input, again);
  store(executor, history_[current_][value].data(), result);
}

void ShadowFilter::temporal(Executor& executor, const ShadowFilterInput& input, bool again) {
  if (input.width != width_ || input.height != height_)
    fail(SIDERAY_INVALID_ARGUMENT, "shadow filter: no frame of {} x {} was filtered; call spatial() first", input.width,
         input.height);
  fit_history();
  if (!follows_) std::fill_n(history_[current_][inverse_then].data(), history_[current_][inverse_then].size(), 0.0f);
  if (!again || !follows_) current_ = 1 - current_;
  const ShadowSequence sequence{terms_of(input),    planes(),
                                history(1 - current_), history(current_),
                                static_cast<int32_t>(width_), static_cast<int32_t>(height_)};
  executor.run(tiles_y_, [&](size_t y, uint32_t) { accumulate(sequence, input.motion, static_cast<uint32_t>(y)); });
  follows_ = true;
}

uint32_t ShadowFilter::active_tiles() const {
  return static_cast<uint32_t>(std::count_if(tiles_.begin(), tiles_.end(), [](const Tile& t) { return t.active; }));
}

}  // namespace sideray::rt
