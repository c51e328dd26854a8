#include "rt/masks/mask_filters.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <deque>
#include <memory>
#include <utility>

#include "elementary/functions.h"
#include "rt/base/vectors.h"
#include "rt/masks/kept_masks.h"

namespace sideray::rt {
namespace {

// A point's ambient occlusion is blurred over about the distance of its occluders.
constexpr float open_tangent = 1.0f;

template <typename Work>
void for_rows(Executor& executor, uint32_t height, const Work& work) {
  constexpr uint32_t rows = 16;
  executor.run((height + rows - 1) / rows, [&](size_t piece, uint32_t) {
    const auto first = static_cast<uint32_t>(piece) * rows;
    for (uint32_t y = first; y < std::min(height, first + rows); ++y) work(y);
  });
}

void copy_depths(Executor& executor, const MaskRequest& r, std::vector<float>& to) {
  to.resize(r.view_depths.size());
  for_rows(executor, r.height, [&](uint32_t y) {
    const size_t first = size_t{y} * r.width;
    std::copy_n(&r.view_depths[first], r.width, &to[first]);
  });
}

// Fills in how far, in pixels, static surfaces move on the screen when the camera moves.
void fill_motion(Executor& executor, const FrameCamera& now, const FrameCamera& before, FilterFrame& frame) {
  frame.motion.resize(frame.depth.size());
  const glm::dmat4& m = before.clip_from_local;
  const glm::dvec4 eye = m * glm::dvec4(now.origin, 1.0), ray = m * glm::dvec4(now.ray, 0.0);
  const glm::dvec4 ray_x = m * glm::dvec4(now.ray_x, 0.0), ray_y = m * glm::dvec4(now.ray_y, 0.0);
  const glm::dvec2 half(0.5 * frame.width, 0.5 * frame.height);
  for_rows(executor, frame.height, [&](uint32_t y) {
    for (uint32_t x = 0; x < frame.width; ++x) {
      const size_t i = size_t{y} * frame.width + x;
      const auto depth = static_cast<double>(frame.depth[i]);
      const glm::dvec4 clip = eye + depth * (ray + ray_x * static_cast<double>(x) + ray_y * static_cast<double>(y));
      const glm::dvec2 was = (glm::dvec2(clip) / clip.w + 1.0) * half - 0.5;
      frame.motion[i] = clip.w > 0.0 ? glm::vec2(glm::dvec2(x, y) - was) : glm::vec2(1e6f);
    }
  });
}

// Returns whether a frame's masks are averaged with previous ones. History has been averaged already. If most of a
// frame is history, averaging again would repeat the same rays and cost as much as if all were traced.
bool is_averaged(const MaskRequest& r) {
  return !r.traced || r.traced->are_most;
}

shading::SfView filter_view(const FrameCamera& now, const std::optional<FrameCamera>& before) {
  const auto along = [](const glm::dvec3& a, const glm::dvec3& b) { return static_cast<float>(glm::dot(a, b)); };
  shading::SfView view{along(now.ray, now.right), along(now.ray, now.up), along(now.ray_x, now.right),
                       along(now.ray_y, now.up),  {0.0f, 0.0f, 1.0f},     0.0f};
  if (!before) return view;
  const glm::dvec3& axis = before->forward;
  view.before = {along(axis, now.right), along(axis, now.up), along(axis, now.forward)};
  view.before_offset = along(axis, now.origin - before->origin);
  return view;
}

}  // namespace

shading::SfLight filter_light(const model::Light& light, const FrameCamera& camera) {
  const float most = std::min(std::max(light.filter_radius, 0.0f), shading::sf_most_penumbra);
  const auto frames = static_cast<float>(std::max(light.filter_frames, 1u));
  if (light.type == SIDERAY_LIGHT_DIRECTIONAL) return {{}, 0.0f, elementary::tan(light.angular_radius), most, frames};
  const glm::dvec3 from_eye = glm::dvec3(light.position) - camera.origin;
  const glm::vec3 position(glm::dot(from_eye, camera.right), glm::dot(from_eye, camera.up),
                           glm::dot(from_eye, camera.forward));
  return {position, light.radius, 0.0f, most, frames};
}

shading::SfLight filter_sky() {
  return {{}, 0.0f, open_tangent, shading::sf_most_penumbra, shading::sf_usual_history};
}

bool is_random(sideray_inexact inexact, uint32_t inexact_bits) {
  return inexact_bits != 0 && inexact != SIDERAY_EXACT && inexact != SIDERAY_INEXACT_RESTPOSE;
}

bool is_filtered(const model::Light& light, bool inexact) {
  if (!(light.filter_radius > 0.0f)) return false;
  const bool is_soft = light.type == SIDERAY_LIGHT_DIRECTIONAL ? light.angular_radius > 0.0f : light.radius > 0.0f;
  return is_soft || inexact;
}

bool FilterFrames::next(Executor& executor, const MaskRequest& r, const model::Snapshot& snapshot, FilterFrame& frame) {
  const bool same_size = r.width == width_ && r.height == height_;
  width_ = r.width;
  height_ = r.height;
  if (r.sequence == SequenceStep::next && same_size) {
    before_ = camera_;
    if (before_) before_->shift(origin_ - snapshot.origin);
  } else if (r.sequence != SequenceStep::again || !same_size) {
    before_.reset();
  }
  if (r.sequence != SequenceStep::again) ++number_;
  origin_ = snapshot.origin;
  camera_.reset();
  const FrameCamera camera(r.view, r.width, r.height);
  if (!camera.perspective) return false;
  camera_ = camera;
  frame.width = r.width;
  frame.height = r.height;
  frame.view = filter_view(*camera_, before_);
  if (r.sequence == SequenceStep::next) frame.depth.swap(frame.depth_before);
  if (r.view_depths.empty())
    fill_depths(executor, r.depth, *camera_, frame.depth);
  else
    copy_depths(executor, r, frame.depth);
  frame.motion.clear();
  if (before_ && r.motion.empty() && is_averaged(r) && before_->clip_from_local != camera_->clip_from_local)
    fill_motion(executor, *camera_, *before_, frame);
  return true;
}

bool FilterFrames::follows(uint64_t& last, SequenceStep step) const {
  const uint64_t expected = step == SequenceStep::again ? number_ : number_ - 1;
  return std::exchange(last, number_) == expected && follows();
}

namespace {

// Returns for each of the filters' tiles whether a tint there may differ from 1.
std::vector<uint8_t> tint_seen(const OcclusionMasks& masks, uint32_t place) {
  constexpr uint32_t across = OcclusionMasks::tint_tile / OcclusionMasks::filter_tile;
  std::vector<uint8_t> seen;
  for (uint32_t v = 0; v < masks.filter_rows(); ++v)
    for (uint32_t u = 0; u < masks.filter_columns(); ++u) {
      const bool tinted =
          masks.tint_tiles[masks.tint_tile_index(place, size_t{v / across} * masks.tint_columns() + u / across)] != 0;
      seen.push_back(OcclusionMasks::seen_lit | (tinted ? OcclusionMasks::seen_dark : 0));
    }
  return seen;
}

// The pixels of rows from `first` to before `past`.
struct Columns {
  uint32_t first = 0, past = 0;
  bool none() const { return first == past; }
  void add(Columns other) {
    if (other.none()) return;
    *this = none() ? other : Columns{std::min(first, other.first), std::max(past, other.past)};
  }
};

// Names one of the eight neighbours. The pixels of a row from `first` to before `past` have it.
struct Neighbour {
  uint8_t bit;
  ptrdiff_t offset;
  uint32_t first, past;
};

template <typename Work>
void for_neighbours(const FilterFrame& frame, uint32_t y, Columns columns, const Work& work) {
  uint8_t bit = 1;
  for (int v = -1; v <= 1; ++v)
    for (int u = -1; u <= 1; ++u) {
      if (u == 0 && v == 0) continue;
      const bool inside = v < 0 ? y > 0 : v == 0 || y + 1 < frame.height;
      if (inside)
        work(Neighbour{bit, v * static_cast<ptrdiff_t>(frame.width) + u, std::max<uint32_t>(columns.first, u < 0),
                       std::min(columns.past, frame.width - (u > 0))});
      bit = static_cast<uint8_t>(bit << 1);
    }
}

// Marks the pixels whose neighbour lies on the same surface.
SIDERAY_VECTORS void mark_same_surface(const float* depths, Neighbour neighbour, uint8_t* same) {
  constexpr float same_share = 0.02f;  // of the depth
  const float* const others = depths + neighbour.offset;
  const uint8_t bit = neighbour.bit;
  const size_t past = neighbour.past;
  for (size_t x = neighbour.first; x < past; ++x)
    same[x] |= std::abs(others[x] - depths[x]) <= same_share * depths[x] ? bit : uint8_t{0};
}

// Returns for each pixel in these columns of each row of tiles a bit for each neighbour on the same surface; no bits if
// fewer than six are.
std::unique_ptr<uint8_t[]> find_same_surface(Executor& executor, const FilterFrame& frame, std::span<const Columns> columns) {
  constexpr int fewest = 6;
  auto same = std::make_unique_for_overwrite<uint8_t[]>(size_t{frame.width} * frame.height);
  for_rows(executor, frame.height, [&](uint32_t y) {
    const Columns wanted = columns[y / OcclusionMasks::tint_tile];
    const size_t first = size_t{y} * frame.width;
    std::fill(&same[first + wanted.first], &same[first + wanted.past], uint8_t{0});
    for_neighbours(frame, y, wanted, [&](const Neighbour& n) { mark_same_surface(&frame.depth[first], n, &same[first]); });
    for (size_t i = first + wanted.first; i < first + wanted.past; ++i)
      if (frame.depth[i] <= 0.0f || std::popcount(same[i]) < fewest) same[i] = 0;
  });
  return same;
}

// Holds the three smallest and the three largest tints around each pixel of a row, the outermost first.
struct OuterTints {
  std::array<std::vector<uint8_t>, 3> low, high;

  explicit OuterTints(uint32_t width) {
    low.fill(std::vector<uint8_t>(width));
    high.fill(std::vector<uint8_t>(width));
  }
  void clear() {
    for (std::vector<uint8_t>& row : low) std::ranges::fill(row, uint8_t{255});
    for (std::vector<uint8_t>& row : high) std::ranges::fill(row, uint8_t{0});
  }
};

// Adds one neighbour of each pixel of a row. It has no branches and copies what bytes might alias, so that it becomes
// vector code.
SIDERAY_VECTORS void take_neighbour(const uint8_t* tints, const uint8_t* same, Neighbour neighbour,
                                    OuterTints& outer) {
  constexpr auto less = [](uint8_t a, uint8_t b) { return a < b ? a : b; };
  constexpr auto more = [](uint8_t a, uint8_t b) { return a > b ? a : b; };
  uint8_t *const low0 = outer.low[0].data(), *const low1 = outer.low[1].data(), *const low2 = outer.low[2].data();
  uint8_t *const high0 = outer.high[0].data(), *const high1 = outer.high[1].data(), *const high2 = outer.high[2].data();
  const uint8_t* const others = tints + neighbour.offset;
  const uint8_t bit = neighbour.bit;
  const size_t past = neighbour.past;
#if !defined(__clang__)  // which does not know it
#pragma GCC ivdep
#endif
  for (size_t x = neighbour.first; x < past; ++x) {
    const uint8_t kept = (same[x] & bit) != 0 ? 255 : 0;
    const uint8_t up = others[x] | static_cast<uint8_t>(~kept), down = others[x] & kept;
    const uint8_t a = low0[x], b = low1[x], c = low2[x], d = high0[x], e = high1[x], f = high2[x];
    low0[x] = less(a, up), low1[x] = less(b, more(a, up)), low2[x] = less(c, more(b, more(a, up)));
    high0[x] = more(d, down), high1[x] = more(e, less(d, down)), high2[x] = more(f, less(e, less(d, down)));
  }
}

// Marks the pixels of a row that differ from one of their four neighbours by more than a filter leaves. They are few.
// The loops have no branches, so that they become vector code.
void mark_outstanding(const uint8_t* tints, const FilterFrame& frame, uint32_t y, Columns columns, uint8_t* marks) {
  constexpr int smooth = 4;
  const uint32_t width = frame.width;
  const uint8_t* row = tints + size_t{y} * width;
  const uint8_t* below = y > 0 ? row - width : row;
  const uint8_t* above = y + 1 < frame.height ? row + width : row;
  for (uint32_t x = columns.first; x < columns.past; ++x) marks[x] = std::abs(row[x] - below[x]) > smooth || std::abs(row[x] - above[x]) > smooth;
  for (uint32_t x = std::max(columns.first, 1u); x < columns.past; ++x) marks[x] |= std::abs(row[x] - row[x - 1]) > smooth;
  for (uint32_t x = columns.first + 1; x < std::min(columns.past + 1, width); ++x)
    marks[x - 1] |= std::abs(row[x] - row[x - 1]) > smooth;
}

struct Calmed {
  uint32_t texel;
  uint8_t tint;
};

// Returns the pixels from the first to the last tile of a row that is set.
Columns columns_of(std::span<const uint8_t> tiles, uint32_t width) {
  constexpr uint32_t side = OcclusionMasks::tint_tile;
  Columns columns;
  for (uint32_t i = 0; i < tiles.size(); ++i)
    if (tiles[i]) columns.add({i * side, std::min((i + 1) * side, width)});
  return columns;
}

// Finds new tints for single pixels that stand out, in one plane and row of tiles: they are clamped to the third
// smallest and the third largest tint around them. The filter leaves such pixels where glass is near, because it is
// narrow there: some rays through a drinking glass miss the bulb around their lamp.
std::vector<Calmed> calm_row(std::span<const uint8_t> tints, const FilterFrame& frame, const uint8_t* same,
                             std::span<const uint8_t> tinted, uint32_t row) {
  constexpr uint32_t side = OcclusionMasks::tint_tile;
  std::vector<Calmed> calmed;
  const Columns columns = columns_of(tinted, frame.width);
  if (columns.none()) return calmed;
  std::vector<uint8_t> marks(frame.width);
  OuterTints outer(frame.width);
  for (uint32_t y = row * side; y < std::min((row + 1) * side, frame.height); ++y) {
    mark_outstanding(tints.data(), frame, y, columns, marks.data());
    if (std::ranges::find(marks, uint8_t{1}) == marks.end()) continue;
    const size_t first = size_t{y} * frame.width;
    outer.clear();
    for_neighbours(frame, y, columns, [&](const Neighbour& n) { take_neighbour(&tints[first], &same[first], n, outer); });
    for (uint32_t x = columns.first; x < columns.past; ++x) {
      const size_t texel = first + x;
      if (!marks[x] || same[texel] == 0 || tinted[x / side] == 0) continue;
      const uint8_t tint = std::clamp(tints[texel], outer.low[2][x], outer.high[2][x]);
      if (tint != tints[texel]) calmed.push_back({static_cast<uint32_t>(texel), tint});
    }
  }
  return calmed;
}

// Returns for the tiles of a place's row whether they hold a tint that was filtered in this frame. `unfiltered` is as
// in ShadowFilterInput.
std::vector<uint8_t> tiles_to_calm(const OcclusionMasks& masks, uint32_t place, uint32_t row, std::span<const uint8_t> unfiltered) {
  constexpr uint32_t across = OcclusionMasks::tint_tile / OcclusionMasks::filter_tile;
  const auto first = masks.tint_tiles.begin() + static_cast<ptrdiff_t>(masks.tint_tile_index(place, size_t{row} * masks.tint_columns()));
  std::vector<uint8_t> tiles(first, first + masks.tint_columns());
  for (size_t i = 0; i < tiles.size() && !unfiltered.empty(); ++i)
    tiles[i] &= unfiltered[size_t{row} * across * masks.filter_columns() + i * across];
  return tiles;
}

// Clamps outliers in planes of tints, given by place and channel. It changes pixels after all are computed, because
// neighbours read them.
void calm(Executor& executor, const FilterFrame& frame, const std::vector<std::pair<uint32_t, uint32_t>>& planes,
          std::span<const uint8_t> unfiltered, OcclusionMasks& masks) {
  if (planes.empty()) return;
  const size_t rows = masks.tint_rows();
  struct Task {
    std::span<uint8_t> plane;
    uint32_t row;
    std::vector<uint8_t> tiles;
    std::vector<Calmed> calmed;
  };
  std::vector<Task> tasks;
  std::vector<Columns> columns(rows);
  for (const auto& [place, channel] : planes)
    for (uint32_t row = 0; row < rows; ++row) {
      std::vector<uint8_t> tiles = tiles_to_calm(masks, place, row, unfiltered);
      const Columns wanted = columns_of(tiles, frame.width);
      columns[row].add(wanted);
      if (!wanted.none()) tasks.push_back({masks.tint_plane(place, channel), row, std::move(tiles), {}});
    }
  if (tasks.empty()) return;
  const std::unique_ptr<uint8_t[]> same = find_same_surface(executor, frame, columns);
  executor.run(tasks.size(), [&](size_t i, uint32_t) {
    Task& task = tasks[i];
    task.calmed = calm_row(task.plane, frame, same.get(), task.tiles, task.row);
  });
  executor.run(tasks.size(), [&](size_t i, uint32_t) {
    for (const Calmed& pixel : tasks[i].calmed) tasks[i].plane[pixel.texel] = pixel.tint;
  });
}

}  // namespace

// Collects the masks that one frame filters, then filters them.
class MaskFilters::Frame {
 public:
  // All arguments must outlive the object.
  Frame(MaskFilters& filters, const MaskRequest& request, OcclusionMasks& masks)
      : filters_(filters),
        request_(request),
        masks_(masks),
        pixels_(size_t{masks.width} * masks.height),
        tiles_(size_t{masks.filter_columns()} * masks.filter_rows()),
        averaged_(is_averaged(request)),
        traced_(request.traced ? *request.traced : TracedTiles{}) {}

  void add_lights(const model::Snapshot& snapshot) {
    if (masks_.filter_distance.empty()) return;
    const std::vector<uint32_t> lights = lights_of(request_.shadow_lights);
    if (!lights.empty() && filters_.lights_.size() <= lights.back()) filters_.lights_.resize(lights.back() + 1);
    const bool inexact = is_random(request_.inexact, request_.inexact_bits);
    for (size_t layer = 0; layer < lights.size(); ++layer) {
      const model::Light& light = snapshot.lights[lights[layer]];
      if (is_filtered(light, inexact))
        add_light(layer, filter_light(light, filters_.frames_.camera()), filters_.lights_[lights[layer]]);
    }
    if (request_.combined_lights) add_light(lights.size(), filter_sky(), filters_.combined_);
  }

  void add_sky() {
    const size_t last = masks_.layers - size_t{1};
    if (request_.unhidden_sky && !masks_.filter_distance.empty())
      add_unless_kept(last, filter_sky(), {lit(last), distances(last), {}, traced_.of_sky}, filters_.unhidden_);
    if (!masks_.open_distance.empty())
      add_unless_kept(masks_.layers, filter_sky(), {masks_.open, masks_.open_distance, {}, traced_.of_sky},
                      filters_.open_);
  }

  void run(Executor& executor) {
    const bool averaged = filters_.frames_.follows() && averaged_;
    ShadowFilter::spatial(executor, shadow_filters_, inputs_, averaged);
    for (size_t i = 0; averaged && i < inputs_.size(); ++i)
      shadow_filters_[i]->temporal(executor, inputs_[i], request_.sequence == SequenceStep::again);
    ShadowFilter::store(executor, shadow_filters_, results_, averaged);
    calm(executor, filters_.frame_, tints_, traced_.of_lights, masks_);
    for (const uint32_t place : grey_)
      for (const uint32_t c : {1u, 2u})
        std::ranges::copy(masks_.tint_plane(place, 0), masks_.tint_plane(place, c).begin());
  }

 private:
  // Holds fields of ShadowFilterInput.
  struct Mask {
    std::span<uint8_t> mask;
    std::span<const float> hit_distance;
    std::span<const uint8_t> seen, unfiltered;
  };

  bool is_kept(size_t layer) const { return request_.kept && request_.kept->keeps(static_cast<uint32_t>(layer)); }
  std::span<uint8_t> lit(size_t layer) const { return {&masks_.lit[layer * pixels_], pixels_}; }
  std::span<const float> distances(size_t layer) const { return {&masks_.filter_distance[layer * pixels_], pixels_}; }

  void add_light(size_t layer, const shading::SfLight& light, LightFilters& filters) {
    const std::span<const uint8_t> seen(&masks_.seen[layer * tiles_], tiles_);
    add_unless_kept(layer, light, {lit(layer), distances(layer), seen, traced_.of_lights}, filters.shadow);
    if (masks_.tints > 0 && !masks_.tint_distance.empty()) add_tints(layer, light, filters.tints);
  }

  void add_tints(size_t layer, const shading::SfLight& light, std::array<MaskFilter, 3>& filters) {
    const uint32_t place = masks_.tint_places[layer];
    if (place == 0) return;
    if (is_kept(layer)) {
      for (MaskFilter& filter : filters)
        if (filter.last_frame != 0) keep(filter);
      return;
    }
    if (!masks_.tint_lasts[place - 1] && !masks_.is_tinted(place)) return;
    const bool coloured = masks_.tint_coloured[place - 1];
    if (!coloured) {
      grey_.push_back(place);
      filters[1].last_frame = filters[2].last_frame = 0;
    }
    const std::span<const float> distance(&masks_.tint_distance[(place - 1) * pixels_], pixels_);
    const std::span<const uint8_t> seen = seen_.emplace_back(tint_seen(masks_, place));
    for (uint32_t c = 0; c < (coloured ? 3u : 1u); ++c) {
      tints_.emplace_back(place, c);
      add(light, {masks_.tint_plane(place, c), distance, seen, traced_.of_lights}, filters[c]);
    }
  }

  void add_unless_kept(size_t layer, const shading::SfLight& light, const Mask& mask, MaskFilter& filter) {
    if (is_kept(layer))
      keep(filter);
    else
      add(light, mask, filter);
  }

  // Makes the filter's last result count for this frame too.
  void keep(MaskFilter& filter) const { filters_.frames_.follows(filter.last_frame, request_.sequence); }

  void add(const shading::SfLight& light, const Mask& mask, MaskFilter& filter) {
    const FilterFrame& frame = filters_.frame_;
    const bool follows = filters_.frames_.follows(filter.last_frame, request_.sequence) && averaged_;
    if (!averaged_) filter.last_frame = 0;  // so that the next frame has no history
    if (!follows) filter.filter.reset();
    if (follows && request_.sequence == SequenceStep::next) filter.filter.follow(light, frame.depth_before);
    shadow_filters_.push_back(&filter.filter);
    results_.push_back(mask.mask.data());
    inputs_.push_back({.width = frame.width,
                       .height = frame.height,
                       .visibility = {},
                       .hit_distance = mask.hit_distance,
                       .depth = frame.depth,
                       .motion = request_.motion.empty() ? std::span<const glm::vec2>(frame.motion) : request_.motion,
                       .view = frame.view,
                       .light = light,
                       .mask = mask.mask,
                       .seen = mask.seen,
                       .unfiltered = mask.unfiltered});
  }

  MaskFilters& filters_;
  const MaskRequest& request_;
  OcclusionMasks& masks_;
  const size_t pixels_, tiles_;
  const bool averaged_;
  const TracedTiles traced_;
  std::vector<ShadowFilter*> shadow_filters_;
  std::vector<ShadowFilterInput> inputs_;
  std::vector<uint8_t*> results_;
  std::deque<std::vector<uint8_t>> seen_;  // of tints
  std::vector<uint32_t> grey_;             // places with grey tints: one channel is filtered for all three
  std::vector<std::pair<uint32_t, uint32_t>> tints_;  // filtered places and channels
};

void MaskFilters::filter(Executor& executor, const MaskRequest& r, const model::Snapshot& snapshot,
                         OcclusionMasks& masks) {
  if (r.traced && r.traced->none()) return frames_.skip();
  if (!frames_.next(executor, r, snapshot, frame_)) return;
  Frame frame(*this, r, masks);
  frame.add_lights(snapshot);
  frame.add_sky();
  frame.run(executor);
}

}  // namespace sideray::rt
