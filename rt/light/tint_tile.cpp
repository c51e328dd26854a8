#include "rt/light/tint_tile.h"

#include <algorithm>
#include <cmath>

namespace sideray::rt {
namespace {

constexpr uint32_t side = point_tile_size, block_side = 8, across = side / block_side;

size_t place_in_rows(uint32_t pixel) {
  return size_t{row_in_tile(pixel)} * side + column_in_tile(pixel);
}

uint32_t block_of(uint32_t pixel) {
  return row_in_tile(pixel) / block_side * across + column_in_tile(pixel) / block_side;
}

// Returns true for one pixel in five, in each row and each column.
bool is_first(uint32_t pixel) {
  return (column_in_tile(pixel) + 2 * row_in_tile(pixel)) % 5 == 0;
}

// Returns true for every other pixel, and for the others in the next frame.
bool is_in_turn(uint32_t pixel, uint32_t seed) {
  return ((column_in_tile(pixel) + row_in_tile(pixel) + seed) & 1) == 0;
}

uint8_t mean(uint32_t sum, uint32_t count) {
  return static_cast<uint8_t>((sum + count / 2) / count);
}

}  // namespace

// Holds blocks of 8x8 pixels. A fifth of each block's pixels is traced first. If these agree, and neighbouring blocks
// agree on whether they are tinted at all, the other pixels get their mean.
class TileTints::Blocks {
 public:
  void add(uint32_t pixel, const std::array<uint8_t, 3>& left, float distance) {
    Block& block = blocks_[block_of(pixel)];
    for (size_t c = 0; c < 3; ++c) {
      block.least[c] = std::min(block.least[c], left[c]);
      block.most[c] = std::max(block.most[c], left[c]);
      block.sum[c] += left[c];
    }
    ++block.count;
    block.distance = std::min(block.distance, distance);
  }
  void judge() {
    for (Block& block : blocks_) block.even = agrees(block);
    for (uint32_t b = 0; b < blocks_.size(); ++b) {
      Block& block = blocks_[b];
      for (uint32_t v = b / across - (b >= across); v < std::min(b / across + 2, across); ++v)
        for (uint32_t u = b % across - (b % across > 0); u < std::min(b % across + 2, across); ++u) {
          const Block& beside = blocks_[v * across + u];
          block.even = block.even && (beside.count == 0 || is_white(beside) == is_white(block));
        }
    }
  }
  bool is_even(uint32_t pixel) const { return blocks_[block_of(pixel)].even; }
  uint8_t left(uint32_t pixel, size_t channel) const {
    const Block& block = blocks_[block_of(pixel)];
    return mean(block.sum[channel], block.count);
  }
  float distance(uint32_t pixel) const { return blocks_[block_of(pixel)].distance; }

 private:
  static constexpr uint32_t enough = 8;
  static constexpr int most_apart = 2;  // of 255
  struct Block {
    std::array<uint8_t, 3> least{255, 255, 255}, most{0, 0, 0};
    std::array<uint32_t, 3> sum{};
    uint32_t count = 0;
    float distance = INFINITY;
    bool even = false;
  };
  static bool is_white(const Block& block) { return block.least == std::array<uint8_t, 3>{255, 255, 255}; }
  static bool agrees(const Block& block) {
    bool same = block.count >= enough;
    for (size_t c = 0; c < 3; ++c) same = same && block.most[c] - block.least[c] <= most_apart;
    return same;
  }
  std::array<Block, size_t{across} * across> blocks_{};
};

uint64_t TileTints::trace(const TileLight& light) {
  clear_.clear(), of_clear_.clear();
  known_.fill(0);
  tint_ = nullptr;
  const uint64_t before = straight_.traversals;
  straight_.choose(light.rays, light.blocked, clear_, of_clear_);
  if (clear_.empty()) return 0;
  for (uint32_t& ray : of_clear_) ray = light.pixels[ray];
  const auto choose = [&](const auto& wanted) {
    chosen_.clear(), of_chosen_.clear();
    for (size_t i = 0; i < clear_.size(); ++i) {
      if (!wanted(of_clear_[i])) continue;
      chosen_.push_back(clear_[i]);
      of_chosen_.push_back(of_clear_[i]);
    }
  };
  Blocks blocks, rest;
  choose(is_first);
  follow(light, blocks);
  blocks.judge();
  choose([&](uint32_t pixel) {
    return !is_first(pixel) && !blocks.is_even(pixel) && (!light.filtered || is_in_turn(pixel, light.seed));
  });
  follow(light, rest);
  if (!tint_) return straight_.traversals - before;
  for (const uint32_t pixel : of_clear_) {
    const size_t place = place_in_rows(pixel);
    if (known_[place]) continue;
    if (!blocks.is_even(pixel)) {
      fill_between(pixel);
      continue;
    }
    for (size_t c = 0; c < 3; ++c) tint_->left[c][place] = blocks.left(pixel, c);
    tint_->distance[place] = blocks.distance(pixel);
  }
  if (light.filtered) fill_shadows(light);
  return straight_.traversals - before;
}

void TileTints::follow(const TileLight& light, Blocks& blocks) {
  straight_.follow(chosen_);
  for (size_t i = 0; i < chosen_.size(); ++i) {
    const size_t place = place_in_rows(of_chosen_[i]);
    known_[place] = 1;
    const glm::vec3 through = straight_.through(i);
    std::array<uint8_t, 3> left;
    for (int c = 0; c < 3; ++c) left[static_cast<size_t>(c)] = static_cast<uint8_t>(through[c] * 255.0f + 0.5f);
    blocks.add(of_chosen_[i], left, straight_.distance(i));
    if (through == glm::vec3(1.0f)) continue;
    if (!tint_) {
      tint_ = &found.emplace_back();
      tint_->layer = light.layer;
      tint_->tile = light.tile;
      for (auto& plane : tint_->left) plane.fill(255);
      tint_->distance.fill(INFINITY);
    }
    for (size_t c = 0; c < 3; ++c) tint_->left[c][place] = left[c];
    tint_->distance[place] = straight_.distance(i);
  }
}

// Gives a pixel the mean of its traced neighbours.
void TileTints::fill_between(uint32_t pixel) {
  const uint32_t column = column_in_tile(pixel), row = row_in_tile(pixel);
  const size_t place = place_in_rows(pixel);
  std::array<uint32_t, 3> sum{};
  uint32_t count = 0;
  float distance = INFINITY;
  const auto add = [&](bool inside, size_t beside) {
    if (!inside || !known_[beside]) return;
    for (size_t c = 0; c < 3; ++c) sum[c] += tint_->left[c][beside];
    distance = std::min(distance, tint_->distance[beside]);
    ++count;
  };
  add(column > 0, place - 1);
  add(column + 1 < side, place + 1);
  add(row > 0, place - side);
  add(row + 1 < side, place + side);
  if (count == 0) return;
  for (size_t c = 0; c < 3; ++c) tint_->left[c][place] = mean(sum[c], count);
  tint_->distance[place] = distance;
}

// Gives pixels with an opaque occluder the mean tint of the lit pixels in their block. Filters average mask and tint
// separately, and the mean light is the mask's mean times the mean tint of lit pixels.
void TileTints::fill_shadows(const TileLight& light) {
  std::array<std::array<uint32_t, 4>, size_t{across} * across> sums{};
  for (size_t r = 0; r < light.rays.count; ++r) {
    if (light.blocked[r]) continue;
    std::array<uint32_t, 4>& sum = sums[block_of(light.pixels[r])];
    for (size_t c = 0; c < 3; ++c) sum[c] += tint_->left[c][place_in_rows(light.pixels[r])];
    ++sum[3];
  }
  for (size_t r = 0; r < light.rays.count; ++r) {
    const std::array<uint32_t, 4>& sum = sums[block_of(light.pixels[r])];
    if (!light.blocked[r] || sum[3] == 0) continue;
    for (size_t c = 0; c < 3; ++c) tint_->left[c][place_in_rows(light.pixels[r])] = mean(sum[c], sum[3]);
  }
}

}  // namespace sideray::rt
