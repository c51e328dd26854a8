#include "bridge/picture/still_picture.h"

#include <algorithm>

#include "bridge/picture/changed_tiles.h"
#include "rt/base/pixels.h"

namespace sideray::bridge {
namespace {

// Limits the weight of the temporal average, in positions: it is blurred where things moved.
constexpr uint32_t most_averaged = 8;
// A tile that changes again before it is complete is relit only once in this many positions. It shows the temporal
// average meanwhile, and its sum would never be used.
constexpr uint32_t resting_positions = 16;

}  // namespace

uint32_t StillPicture::columns() const {
  return rt::tile_count(width_);
}

// Calls work(texel of the picture, texel of the tile).
template <typename Work>
void StillPicture::for_texels(size_t tile, const Work& work) const {
  constexpr uint32_t size = rt::frame_tile_size;
  const auto x0 = static_cast<uint32_t>(tile % columns()) * size, y0 = static_cast<uint32_t>(tile / columns()) * size;
  size_t in_tile = 0;
  for (uint32_t y = y0; y < std::min(y0 + size, height_); ++y)
    for (uint32_t x = x0; x < std::min(x0 + size, width_); ++x) work(size_t{y} * width_ + x, in_tile++);
}

void StillPicture::restart(uint32_t seed, uint32_t width, uint32_t height) {
  pictures_ = 0;
  is_done_ = begins_tiles_ = waits_ = false;
  seed_ = seed;
  width_ = width;
  height_ = height;
  tiles_.clear();
  tiles_.resize(size_t{columns()} * rt::tile_count(height));
  shown_.clear();
}

void StillPicture::repeat() {
  position_frames_ = waits_ ? position_frames_ + 1 : 1;
  if (waits_) return;
  begins_tiles_ = false;
  for (Tile& tile : tiles_) tile.begins = tile.rests = false;
  is_done_ = std::ranges::all_of(tiles_, [](const Tile& tile) { return tile.added == positions; });
  if (!is_done_) ++pictures_;
}

void StillPicture::repeat_without(const std::vector<uint8_t>& changes) {
  std::vector<uint8_t> goes_on_beginning(tiles_.size());
  for (size_t i = 0; i < tiles_.size(); ++i) goes_on_beginning[i] = tiles_[i].added < positions;
  repeat();
  begins_tiles_ = std::ranges::any_of(changes, [](uint8_t change) { return change != tile_unchanged; });
  if (is_done_ && begins_tiles_) ++pictures_;
  is_done_ = is_done_ && !begins_tiles_;
  const bool may_rest = position() % resting_positions != 0;
  for (size_t i = 0; i < tiles_.size(); ++i) {
    if (changes[i] == tile_unchanged) continue;
    const bool rests = may_rest && changes[i] == tile_drawn_over && goes_on_beginning[i];
    tiles_[i] = {.added = 0, .begins = !rests, .rests = rests, .averaged = 0.0f, .before = {}, .sum = {}};
  }
}

uint32_t StillPicture::added() const {
  if (pictures_ == 0) return 0;
  uint32_t least = positions;
  for (const Tile& tile : tiles_) least = std::min(least, tile.added);
  return least;
}

template <typename Wants>
std::vector<uint8_t> StillPicture::tiles_where(const Wants& wants) const {
  std::vector<uint8_t> wanted(tiles_.size());
  std::ranges::transform(tiles_, wanted.begin(), [&](const Tile& tile) -> uint8_t { return wants(tile); });
  if (std::ranges::find(wanted, 0) == wanted.end()) wanted.clear();
  return wanted;
}

std::vector<uint8_t> StillPicture::wanted() const {
  return tiles_where([](const Tile& tile) { return tile.added < positions; });
}

std::vector<uint8_t> StillPicture::wanted_light() const {
  return tiles_where([](const Tile& tile) { return tile.added < positions && !tile.rests; });
}

void StillPicture::begin_with(const std::vector<glm::vec4>& picture, uint32_t averaged) {
  shown_ = picture;
  for (size_t i = 0; i < tiles_.size(); ++i) {
    Tile& tile = tiles_[i];
    tile.averaged = static_cast<float>(std::min(averaged, most_averaged));
    tile.before.clear();
    for_texels(i, [&](size_t texel, size_t) { tile.before.push_back(picture[texel]); });
  }
}

// Adds a position. The weight of the earlier picture falls to 0 at the last position, so that what is shown never
// jumps. Sums are exact to 2^-53, so that they do not depend on the position at which a tile began.
const std::vector<glm::vec4>& StillPicture::add(const std::vector<glm::vec4>& drawn, const std::vector<glm::vec4>& average) {
  waits_ = false;
  shown_.resize(drawn.size());
  for (size_t i = 0; i < tiles_.size(); ++i) {
    Tile& tile = tiles_[i];
    if (tile.added == positions) continue;
    if (tile.begins || tile.rests) {
      tile.averaged = static_cast<float>(most_averaged);
      for_texels(i, [&](size_t texel, size_t) { tile.before.push_back(shown_[texel] = average[texel]); });
    }
    if (tile.rests) continue;
    ++tile.added;
    tile.sum.resize(rt::frame_tile_size * rt::frame_tile_size, glm::dvec4(0.0));
    if (tile.begins) {
      for_texels(i, [&](size_t texel, size_t in_tile) { tile.sum[in_tile] = drawn[texel]; });
      continue;
    }
    const double left = double{tile.averaged} * (positions - tile.added) / positions, all = tile.added + left;
    for_texels(i, [&](size_t texel, size_t in_tile) {
      glm::dvec4 mean = tile.sum[in_tile] += glm::dvec4(drawn[texel]);
      if (left > 0.0) mean += left * glm::dvec4(tile.before[in_tile]);
      shown_[texel] = glm::vec4(mean / all);
    });
    if (tile.added < positions) continue;
    tile.sum = {};
    tile.before = {};
  }
  return shown_;
}

}  // namespace sideray::bridge
