#include "rt/cache/layer_filter.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "rt/base/half_bits.h"

// The filter runs edge-avoiding a-trous wavelets (Dammertz et al. 2010) with the 3x3 kernel of the linear B-spline; the
// edges are those of surfaces, never of the noisy signal. How far a pixel may look follows from its lobe. If the point
// moves by x on the surface, then what the lobe covers at distance d moves by x (1 + d / D), with D the eye's distance:
// the mirrored eye's rays spread as the eye's do. The lobe's own width there is about 2 alpha d. A radius that is a
// share of that blurs what the lobe has blurred already; toward what touches the surface it shrinks to nothing, and
// contacts stay.
namespace sideray::rt {
namespace {

constexpr size_t layers_in_piece = 512;
constexpr size_t passes = 4;
// The filter's radius is this share of the lobe's: what is reflected gets wider by sqrt(1 + share^2), 12 %.
constexpr float share_of_lobe = 0.5f;
constexpr float least_reach_px = 0.5f;
constexpr float like_roughness = 0.2f;  // how much roughness may differ, as a share

float largest(glm::vec4 v) {
  return std::max({v.x, v.y, v.z});
}

float alpha(float roughness) {
  return roughness * roughness;
}

// Returns how many equal weights average as well as all passes do within the reach. Steps 1, 2, 4, 8 of [1 2 1] / 4 sum
// up to a variance of 0.5 (1 + 4 + 16 + 64) along each axis; the reach cuts it. A Gaussian of variance v averages 4 pi
// v.
float samples_averaged(float reach_px) {
  constexpr float variance = 0.5f * ((1 << 2 * passes) - 1) / 3;
  return std::max(12.566f / (1.0f / variance + 1.0f / (reach_px * reach_px)), 1.0f);
}

// Approximates exp(-q / 2); it ends at 8, and is the same bits everywhere.
float bell(float q) {
  const float rest = std::max(1.0f - q * 0.125f, 0.0f);
  return rest * rest * rest * rest;
}

// Returns whether a point lies on the same part of a surface: near the plane of the other, but for the deviation that a
// curve through both explains.
bool on_one_part(const LayerFilter::Place& a, const LayerFilter::Place& b) {
  constexpr float flat = 0.05f, most_bend = 0.5f;
  const glm::vec3 apart = b.position - a.position, bend = b.geometric_normal - a.geometric_normal;
  const float off = glm::dot(apart, a.geometric_normal), bend2 = glm::dot(bend, bend);
  const float bound = flat + std::sqrt(bend2);
  return bend2 < most_bend * most_bend && off * off <= bound * bound * glm::dot(apart, apart);
}

// Returns 1 for what reflects the same by the same lobe, falling to 0.
float likeness(const LayerFilter::Place& a, const LayerFilter::Place& b) {
  const glm::vec3 apart = b.position - a.position, bend = b.normal - a.normal;
  const float reach = std::min(a.reach_px * a.width, b.reach_px * b.width), turn = share_of_lobe * alpha(a.roughness);
  const float rougher = (b.roughness - a.roughness) / (like_roughness * std::min(a.roughness, b.roughness));
  return bell(glm::dot(apart, apart) / (reach * reach) + glm::dot(bend, bend) / (turn * turn) + rougher * rougher);
}

}  // namespace

void LayerFilter::Chunk::add(uint32_t pixel, uint32_t texel, uint32_t surface_id, const SurfacePoint& point,
                             glm::vec3 radiance, const RoughReflection& rough) {
  places.push_back({point.position, point.surface.normal, point.geometric_normal, rough.through ? ~surface_id : surface_id,
                    none, rough.roughness, point.cone.width, point.cone.spread, rough.nearness, 0.0f});
  const glm::vec3 noise = rough.weight * rough.radiance;
  layers.push_back({pixel, texel, radiance - noise, rough.weight, noise, rough.spread});
  reflected.emplace_back(rough.radiance, rough.through || rough.nearness > 0.0f ? 1.0f : 0.0f);
}

void LayerFilter::begin(size_t chunks) {
  chunks_.resize(chunks);
  for (Chunk& chunk : chunks_) {
    chunk.places.clear();
    chunk.layers.clear();
    chunk.reflected.clear();
  }
}

// Brings the chunks' findings together, links those of each pixel, and returns how many there are.
size_t LayerFilter::gather(Executor& executor, size_t pixels) {
  offsets_.assign(1, 0);
  for (const Chunk& chunk : chunks_) offsets_.push_back(offsets_.back() + chunk.places.size());
  const size_t count = offsets_.back();
  if (count == 0) return 0;
  if (first_.size() != pixels) first_.assign(pixels, none);
  places_.resize(count);
  layers_.resize(count);
  reflected_.resize(count);
  next_reflected_.resize(count);
  executor.run(chunks_.size(), [&](size_t c, uint32_t) {
    const Chunk& chunk = chunks_[c];
    const auto at = static_cast<ptrdiff_t>(offsets_[c]);
    std::copy(chunk.places.begin(), chunk.places.end(), places_.begin() + at);
    std::copy(chunk.layers.begin(), chunk.layers.end(), layers_.begin() + at);
    std::copy(chunk.reflected.begin(), chunk.reflected.end(), reflected_.begin() + at);
    for (size_t i = offsets_[c]; i < offsets_[c + 1]; ++i)
      places_[i].next = std::exchange(first_[layers_[i].pixel], static_cast<uint32_t>(i));
  });
  return count;
}

// Returns the layer of a pixel, whose first is `head`, that is on the same part of the same surface, or none.
uint32_t LayerFilter::like(const Place& at, uint32_t head) const {
  uint32_t best = none;
  float least = 0.0f;
  for (uint32_t j = head; j != none; j = places_[j].next) {
    const Place& other = places_[j];
    if (other.surface_id != at.surface_id || !on_one_part(at, other)) continue;
    const float off = std::abs(glm::dot(other.position - at.position, at.geometric_normal));
    if (best == none || off < least) {
      best = j;
      least = off;
    }
  }
  return best;
}

LayerFilter::Around LayerFilter::around(size_t i, int64_t step) const {
  const int64_t x = layers_[i].pixel % width_, y = layers_[i].pixel / width_;
  Around result;
  size_t k = 0;
  for (int64_t dy = -step; dy <= step; dy += step)
    for (int64_t dx = -step; dx <= step; dx += step) {
      if (dx == 0 && dy == 0) continue;
      const bool inside = x + dx >= 0 && y + dy >= 0 && x + dx < width_ && y + dy < height_;
      const uint32_t head = inside ? first_[static_cast<size_t>((y + dy) * width_ + x + dx)] : none;
      // The eight wait for memory together rather than one after the other.
      if (head != none) __builtin_prefetch(&places_[head]);
      result[k++] = head;
    }
  for (uint32_t& neighbour : result) neighbour = like(places_[i], neighbour);
  return result;
}

// Decides how far to filter, from what is reflected around: one direction alone may have missed what is near. Also
// limits what a single direction brings to what is shown to half of the mean around: otherwise it would be seen as a
// spot. That takes energy only where little is averaged, from four times the mean on; nothing is taken where nothing is
// averaged.
void LayerFilter::prepare(size_t i) {
  const Place& at = places_[i];
  float nearness = at.nearness, light = largest(reflected_[i]), count = 1.0f;
  for (size_t pass = 0; pass < near_.size(); ++pass) {
    near_[pass][i] = around(i, int64_t{1} << pass);
    for (const uint32_t j : near_[pass][i]) {
      if (j == none) continue;
      nearness += places_[j].nearness;
      light += largest(reflected_[j]);
      count += 1.0f;
    }
  }
  nearness /= count;
  light /= count;
  reach_[i] = share_of_lobe * 2.0f * layers_[i].spread * alpha(at.roughness) / (at.width * nearness + at.spread);
  const float most = std::max(0.5f * samples_averaged(reach_[i]), 4.0f) * light, own = largest(reflected_[i]);
  const float kept = reach_[i] >= least_reach_px && own > most ? most / own : 1.0f;
  next_reflected_[i] = reflected_[i] * glm::vec4(kept, kept, kept, 1.0f);
}

glm::vec4 LayerFilter::blurred(size_t i, const Around& neighbours) const {
  // The kernel against 1 in the middle.
  constexpr std::array<float, 8> kernel{0.25f, 0.5f, 0.25f, 0.5f, 0.5f, 0.25f, 0.5f, 0.25f};
  const Place& at = places_[i];
  glm::vec4 sum = reflected_[i];
  float weights = 1.0f;
  for (size_t k = 0; k < neighbours.size(); ++k) {
    const uint32_t j = neighbours[k];
    if (j == none || places_[j].reach_px < least_reach_px) continue;
    const float weight = kernel[k] * likeness(at, places_[j]);
    sum += reflected_[j] * weight;
    weights += weight;
  }
  return sum / weights;
}

// Writes the layer's radiance where index i is the first of its own; returns false elsewhere, and where nothing was
// filtered. What a surface reflects and what is seen through it are apart.
bool LayerFilter::filtered(size_t i, glm::vec3& radiance) const {
  const Layer& layer = layers_[i];
  bool is_filtered = false;
  uint32_t first = none;
  for (uint32_t j = first_[layer.pixel]; j != none; j = places_[j].next) {
    const Layer& other = layers_[j];
    if (other.texel != layer.texel) continue;
    if (first == none && j != i) return false;
    const bool is_first = first == none;
    first = static_cast<uint32_t>(i);
    // Only the environment is reflected all around: it came prefiltered, and stays as the rasterizer has it.
    const bool stays = reflected_[j].w == 0.0f;
    is_filtered = is_filtered || !stays;
    const glm::vec3 now = stays ? other.noise : other.weight * glm::vec3(reflected_[j]);
    radiance = is_first ? other.rest + now : radiance + (now - other.noise);
  }
  return is_filtered;
}

void LayerFilter::apply(Executor& executor, LayerCache& cache, LayerHistory* history) {
  width_ = cache.width;
  height_ = cache.height;
  const size_t count = gather(executor, size_t{cache.width} * cache.height);
  if (count == 0) return;
  reach_.resize(count);
  for (std::vector<Around>& near : near_) near.resize(count);
  const auto each = [&](const auto& work) {
    executor.run((count + layers_in_piece - 1) / layers_in_piece, [&](size_t piece, uint32_t) {
      const size_t end = std::min(count, (piece + 1) * layers_in_piece);
      for (size_t i = piece * layers_in_piece; i < end; ++i) work(i);
    });
  };
  each([&](size_t i) { prepare(i); });
  each([&](size_t i) { places_[i].reach_px = reach_[i]; });
  reflected_.swap(next_reflected_);
  for (size_t pass = 0; pass < passes; ++pass) {
    each([&](size_t i) {
      next_reflected_[i] = places_[i].reach_px < least_reach_px ? reflected_[i]
                           : pass < near_.size()                ? blurred(i, near_[pass][i])
                                                                : blurred(i, around(i, int64_t{1} << pass));
    });
    reflected_.swap(next_reflected_);
  }
  each([&](size_t i) {
    const Layer& layer = layers_[i];
    glm::vec3 all;
    if (!filtered(i, all)) return;
    uint16_t* radiance = &cache.radiance[4 * size_t{layer.texel}];
    store_rgba(radiance, all, 1.0f);
    if (history) history->replace(layer.pixel, layer.texel / (cache.width * cache.height), radiance);
  });
  // Each pixel is in one chunk.
  executor.run(chunks_.size(), [&](size_t chunk, uint32_t) {
    for (size_t i = offsets_[chunk]; i < offsets_[chunk + 1]; ++i) first_[layers_[i].pixel] = none;
  });
}

}  // namespace sideray::rt
