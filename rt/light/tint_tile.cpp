#include "rt/light/tint_tile.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "rt/base/sampling.h"

namespace sideray::rt {
namespace {

constexpr uint32_t side = point_tile_size, block_side = 8, across = side / block_side;

size_t place_in_rows(uint32_t pixel) {
  return size_t{row_in_tile(pixel)} * side + column_in_tile(pixel);
}

uint32_t block_of(uint32_t pixel) {
  return row_in_tile(pixel) / block_side * across + column_in_tile(pixel) / block_side;
}

// Returns the ranks of a set of 64 points by their index: 0 for sixteen points, 1 for sixteen more, 2 for the others. The
// points of rank 0 are as evenly spread over a light as the first sixteen of the set (a net in base 2). In a block of 8x8
// pixels each 2x2 pixels have one of rank 0 and one of rank 1.
constexpr std::array<uint8_t, 64> ranks_of_points() {
  std::array<uint8_t, 64> ranks{};
  for (uint32_t i = 0; i < ranks.size(); ++i) {
    const auto is_odd = [i](uint32_t bits) { return std::popcount(i & bits) % 2 != 0; };
    ranks[i] = is_odd(0b101101) ? 2 : is_odd(0b110001) ? 1 : 0;
  }
  return ranks;
}

// Returns how wide the penumbra is that an edge at a distance along the ray casts where the ray starts; infinite if
// there is no edge.
float penumbra(const RayLight* to, const Ray& ray, float distance) {
  if (!to || !to->samples) return 0.0f;
  if (!(distance < INFINITY)) return INFINITY;
  if (to->kind == rays_to_directional) return 2.0f * std::sqrt(2.0f * to->aperture) * distance;
  return distance < ray.t_far ? 2.0f * to->radius * distance / (ray.t_far - distance) : INFINITY;
}

uint8_t mean(uint32_t sum, uint32_t count) {
  return static_cast<uint8_t>((sum + count / 2) / count);
}

}  // namespace

// Holds blocks of 8x8 pixels. The rays of a quarter of each block's pixels are followed first. The other pixels get
// their mean in two cases. A block is soft if all glass that its rays hit casts penumbrae as wide as the block: then rays
// differ only by their points on the light. A block is even if its rays agree, and its neighbours agree with it on
// whether they are tinted at all.
class TileTints::Blocks {
 public:
  void add(uint32_t pixel, const std::array<uint8_t, 3>& left, float distance, glm::vec3 origin, float penumbra) {
    Block& block = blocks_[block_of(pixel)];
    for (size_t c = 0; c < 3; ++c) {
      block.least[c] = std::min(block.least[c], left[c]);
      block.most[c] = std::max(block.most[c], left[c]);
      block.sum[c] += left[c];
    }
    ++block.count;
    block.distance = std::min(block.distance, distance);
    block.penumbra = std::min(block.penumbra, penumbra);
    block.origins.add(origin);
  }
  // Marks soft blocks. Their mean includes the neighbours', as the filter of tints would.
  void find_soft() {
    for (uint32_t b = 0; b < blocks_.size(); ++b) {
      Block& block = blocks_[b];
      const bool known = block.count >= enough_if_soft && !is_white(block);
      block.is_mean = known && agree_around(b, [](const Block& beside) { return is_soft(beside); });
      if (block.is_mean) block.left = mean_around(b);
    }
  }
  void find_even() {
    for (uint32_t b = 0; b < blocks_.size(); ++b) {
      Block& block = blocks_[b];
      const bool white = is_white(block);
      if (block.is_mean || !is_even(block)) continue;
      block.is_mean = agree_around(b, [=](const Block& beside) { return is_white(beside) == white; });
      for (size_t c = 0; c < 3; ++c) block.left[c] = mean(block.sum[c], block.count);
    }
  }
  // Returns whether pixels whose rays are not followed get the mean.
  bool takes_mean(uint32_t pixel) const { return blocks_[block_of(pixel)].is_mean; }
  uint8_t left(uint32_t pixel, size_t channel) const { return blocks_[block_of(pixel)].left[channel]; }
  float distance(uint32_t pixel) const { return blocks_[block_of(pixel)].distance; }

 private:
  static constexpr uint32_t enough = 8, enough_if_soft = 4;
  static constexpr int most_apart = 2;  // of 255
  struct Block {
    std::array<uint8_t, 3> least{255, 255, 255}, most{0, 0, 0};
    std::array<uint32_t, 3> sum{};
    uint32_t count = 0;
    float distance = INFINITY, penumbra = INFINITY;
    model::Bounds origins;
    bool is_mean = false;
    std::array<uint8_t, 3> left{};  // the mean
  };
  static bool is_white(const Block& block) { return block.least == std::array<uint8_t, 3>{255, 255, 255}; }
  static bool is_soft(const Block& block) { return block.penumbra >= 2.0f * block.origins.radius(); }
  static bool is_even(const Block& block) {
    bool same = block.count >= enough;
    for (size_t c = 0; c < 3; ++c) same = same && block.most[c] - block.least[c] <= most_apart;
    return same;
  }
  // Calls work(block, weight) for block b and its neighbours; the weights are those of [1 2 1] along rows and columns.
  template <typename Work>
  void for_around(uint32_t b, const Work& work) const {
    const uint32_t column = b % across, row = b / across;
    for (uint32_t v = row - (row > 0); v < std::min(row + 2, across); ++v)
      for (uint32_t u = column - (column > 0); u < std::min(column + 2, across); ++u)
        work(blocks_[v * across + u], (u == column ? 2 : 1) * (v == row ? 2 : 1));
  }
  // Returns whether block b and its neighbours agree, but for those without rays.
  template <typename Agrees>
  bool agree_around(uint32_t b, const Agrees& agrees) const {
    bool all = true;
    for_around(b, [&](const Block& block, uint32_t) { all = all && (block.count == 0 || agrees(block)); });
    return all;
  }
  std::array<uint8_t, 3> mean_around(uint32_t b) const {
    std::array<uint32_t, 3> sum{};
    uint32_t count = 0;
    for_around(b, [&](const Block& block, uint32_t weight) {
      for (size_t c = 0; c < 3; ++c) sum[c] += weight * block.sum[c];
      count += weight * block.count;
    });
    return {mean(sum[0], count), mean(sum[1], count), mean(sum[2], count)};
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
  rank_pixels(light.orders);
  const auto rank = [&](uint32_t pixel) { return ranks_[place_in_rows(pixel)]; };
  Blocks blocks, rest;
  follow(light, blocks, [&](uint32_t pixel) { return rank(pixel) == 0; });
  if (light.filtered) blocks.find_soft();
  blocks.find_even();
  const int last = light.filtered ? 1 : 2;
  follow(light, rest, [&](uint32_t pixel) {
    return rank(pixel) > 0 && rank(pixel) <= last && !blocks.takes_mean(pixel);
  });
  if (!tint_) return straight_.traversals - before;
  for (const uint32_t pixel : of_clear_) {
    const size_t place = place_in_rows(pixel);
    if (known_[place]) continue;
    if (!blocks.takes_mean(pixel)) {
      fill_between(pixel);
      continue;
    }
    for (size_t c = 0; c < 3; ++c) tint_->left[c][place] = blocks.left(pixel, c);
    tint_->distance[place] = blocks.distance(pixel);
  }
  if (light.filtered) fill_shadows(light);
  return straight_.traversals - before;
}

void TileTints::rank_pixels(const uint32_t* orders) {
  static constexpr std::array<uint8_t, 64> ranks = ranks_of_points();
  for (uint32_t block = 0; block < across * across; ++block) {
    const size_t first = size_t{block / across} * block_side * side + block % across * block_side;
    for (uint32_t i = 0; i < ranks.size(); ++i)
      ranks_[first + i / block_side * side + i % block_side] = ranks[scramble_nested(i, orders[block]) % ranks.size()];
  }
}

template <typename Wanted>
void TileTints::follow(const TileLight& light, Blocks& blocks, const Wanted& wanted) {
  chosen_.clear(), of_chosen_.clear();
  for (size_t i = 0; i < clear_.size(); ++i) {
    if (!wanted(of_clear_[i])) continue;
    chosen_.push_back(clear_[i]);
    of_chosen_.push_back(of_clear_[i]);
  }
  straight_.follow(chosen_);
  for (size_t i = 0; i < chosen_.size(); ++i) note(light, i, blocks);
}

void TileTints::note(const TileLight& light, size_t ray, Blocks& blocks) {
  const size_t place = place_in_rows(of_chosen_[ray]);
  const glm::vec3 through = straight_.through(ray);
  const float distance = straight_.distance(ray);
  std::array<uint8_t, 3> left;
  for (int c = 0; c < 3; ++c) left[static_cast<size_t>(c)] = static_cast<uint8_t>(through[c] * 255.0f + 0.5f);
  known_[place] = 1;
  blocks.add(of_chosen_[ray], left, distance, chosen_[ray].origin, penumbra(light.to, chosen_[ray], distance));
  if (through == glm::vec3(1.0f)) return;
  if (!tint_) {
    tint_ = &found.emplace_back();
    tint_->layer = light.layer;
    tint_->tile = light.tile;
    for (auto& plane : tint_->left) plane.fill(255);
    tint_->distance.fill(INFINITY);
  }
  for (size_t c = 0; c < 3; ++c) tint_->left[c][place] = left[c];
  tint_->distance[place] = distance;
}

// Gives a pixel the mean of its traced neighbours.
void TileTints::fill_between(uint32_t pixel) {
  const uint32_t column = column_in_tile(pixel), row = row_in_tile(pixel);
  std::array<uint32_t, 3> sum{};
  uint32_t count = 0;
  float distance = INFINITY;
  for (uint32_t v = row - (row > 0); v < std::min(row + 2, side); ++v)
    for (uint32_t u = column - (column > 0); u < std::min(column + 2, side); ++u) {
      const size_t beside = size_t{v} * side + u;
      if (!known_[beside]) continue;
      for (size_t c = 0; c < 3; ++c) sum[c] += tint_->left[c][beside];
      distance = std::min(distance, tint_->distance[beside]);
      ++count;
    }
  if (count == 0) return;
  const size_t place = place_in_rows(pixel);
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
