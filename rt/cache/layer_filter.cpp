#include "rt/cache/layer_filter.h"

#include <algorithm>
#include <array>
#include <initializer_list>
#include <limits>

#include "model/failure.h"
#include "rt/base/half_bits.h"

namespace sideray::rt {
namespace {

constexpr size_t layers_in_piece = 512;
// Broad tiles make long runs; low tiles keep a thread's data in its processor's cache.
constexpr uint32_t tile_width = 512, tile_height = 8;
// If less than this share of the directions hit something, the lobe's prefiltered surroundings gradually replace the
// sampled ones: they have no noise, and little of them is hidden.
constexpr float most_hidden = 1.0f / 16.0f;
constexpr int32_t none = -1;
constexpr size_t padding = layers_at_once;

float alpha(float roughness) {
  return roughness * roughness;
}

}  // namespace

void LayerFilter::Chunk::add(uint32_t pixel, uint32_t texel, uint32_t surface_id, const SurfacePoint& point,
                             glm::vec3 radiance, const RoughReflection& rough) {
  places.push_back({point.position, point.surface.normal, point.geometric_normal,
                    rough.through ? ~surface_id : surface_id, rough.roughness, point.cone.width, point.cone.spread,
                    rough.nearness});
  const bool is_hit = rough.through || rough.nearness > 0.0f;
  const glm::vec3 noise = rough.weight * (rough.is_sampled && !is_hit ? rough.surroundings : rough.radiance);
  layers.push_back({pixel, texel, radiance - noise, rough.weight, noise, rough.spread, rough.is_sampled,
                    rough.surroundings});
  reflected.emplace_back(rough.radiance, is_hit ? 1.0f : 0.0f);
}

void LayerFilter::begin(size_t chunks) {
  chunks_.resize(chunks);
  for (Chunk& chunk : chunks_) {
    chunk.places.clear();
    chunk.layers.clear();
    chunk.reflected.clear();
  }
}

void LayerFilter::fit(uint32_t width, uint32_t height) {
  if (width == width_ && height == height_) return;
  constexpr size_t border = layer_filter_border;
  const size_t stride = width + 2 * border, pixels = stride * (height + 2 * border) + 2 * padding;
  if (pixels > static_cast<size_t>(std::numeric_limits<int32_t>::max()))
    fail(SIDERAY_INVALID_ARGUMENT, "layer filter: {} x {} pixels are too many; use a smaller picture", width, height);
  width_ = width;
  height_ = height;
  first_.assign(pixels, none);
  columns_.first = &first_[padding + border * stride + border];
  columns_.stride = static_cast<int32_t>(stride);
  tiles_x_ = (width + tile_width - 1) / tile_width;
  tiles_.resize(size_t{tiles_x_} * ((height + tile_height - 1) / tile_height));
}

// Gives each column room for `count` layers and for the padding that lanes read around them.
void LayerFilter::fit_columns(size_t count) {
  if (count > static_cast<size_t>(std::numeric_limits<int32_t>::max()) - padding)
    fail(SIDERAY_INVALID_ARGUMENT, "layer filter: {} layers are too many; use a smaller picture or fewer layers",
         count);
  layers_.resize(count);
  // The number of cache lines is odd: columns that are multiples of 4 KB apart would compete for the same cache sets.
  const size_t lines = (count / layers_at_once + 3) | 1;
  LayerColumns& c = columns_;
  std::vector<float**> floats{&c.roughness, &c.width, &c.spread, &c.nearness, &c.lobe, &c.reach};
  for (auto* vector : {&c.position, &c.normal, &c.geometric_normal})
    for (float*& column : *vector) floats.push_back(&column);
  for (auto* vector : {&c.reflected, &c.filtered})
    for (float*& column : *vector) floats.push_back(&column);
  std::vector<int32_t**> integers{&c.surface, &c.next, &c.pixel};
  for (auto& step : c.near)
    for (int32_t*& column : step) integers.push_back(&column);
  if (floats_.size() < lines * floats.size()) floats_.resize(lines * floats.size());
  if (integers_.size() < lines * integers.size()) integers_.resize(lines * integers.size());
  for (size_t i = 0; i < floats.size(); ++i) *floats[i] = floats_[lines * i + 1].values;
  for (size_t i = 0; i < integers.size(); ++i) *integers[i] = integers_[lines * i + 1].values;
  std::fill_n(c.pixel + count, padding, 0);  // lanes behind the last layer read neighbours of a pixel too
}

// Returns the index of a pixel of the picture in columns_.first.
int32_t LayerFilter::place_of(uint32_t pixel) const {
  return static_cast<int32_t>(pixel / width_) * columns_.stride + static_cast<int32_t>(pixel % width_);
}

int32_t& LayerFilter::first_of(uint32_t pixel) {
  return columns_.first[place_of(pixel)];
}

// Finds the ranks of a chunk's layers within their pixels; `first` counts each pixel's layers, starting from `none`.
void LayerFilter::rank(Chunk& chunk) {
  chunk.ranks.resize(chunk.layers.size());
  for (size_t i = chunk.layers.size(); i-- > 0;) chunk.ranks[i] = ++first_of(chunk.layers[i].pixel);
}

// Calls work(place, width) for each row of a tile, with the row's first index in columns_.first.
template <typename Work>
void LayerFilter::for_rows(size_t tile, const Work& work) {
  const auto column = static_cast<uint32_t>(tile % tiles_x_), row = static_cast<uint32_t>(tile / tiles_x_);
  const uint32_t x = column * tile_width, width = std::min(tile_width, width_ - x);
  for (uint32_t y = row * tile_height; y < std::min(height_, (row + 1) * tile_height); ++y)
    work(place_of(y * width_ + x), static_cast<int32_t>(width));
}

void LayerFilter::count(size_t tile) {
  int32_t sum = 0;
  for_rows(tile, [&](int32_t place, int32_t width) {
    for (int32_t x = 0; x < width; ++x) sum += columns_.first[place + x] - none;
  });
  tiles_[tile].count = sum;
}

// Gives the layers of a tile their indices: row by row, the first layer of every pixel before the second.
void LayerFilter::link(size_t tile) {
  struct Linked {
    int32_t layer, more;
  };
  if (tiles_[tile].count == 0) return;
  int32_t next = tiles_[tile].first;
  for_rows(tile, [&](int32_t place, int32_t width) {
    std::array<Linked, tile_width> linked;
    size_t pixels = 0;
    for (int32_t x = place; x < place + width; ++x) {
      if (columns_.first[x] == none) continue;
      linked[pixels++] = {next, columns_.first[x]};
      columns_.pixel[next] = x;
      columns_.first[x] = next++;
    }
    while (pixels > 0) {
      size_t kept = 0;
      for (size_t i = 0; i < pixels; ++i) {
        const auto [layer, more] = linked[i];
        columns_.next[layer] = more > 0 ? next : none;
        if (more == 0) continue;
        linked[kept++] = {next, more - 1};
        columns_.pixel[next++] = columns_.pixel[layer];
      }
      pixels = kept;
    }
  });
}

// Copies a chunk's layers to their indices.
void LayerFilter::scatter(const Chunk& chunk) {
  const LayerColumns& c = columns_;
  const auto put = [](float* const(&to)[3], int32_t at, const glm::vec3& value) {
    for (int i = 0; i < 3; ++i) to[i][at] = value[i];
  };
  for (size_t i = 0; i < chunk.layers.size(); ++i) {
    const Place& place = chunk.places[i];
    const Layer& layer = chunk.layers[i];
    int32_t at = first_of(layer.pixel);
    for (int32_t rank = 0; rank < chunk.ranks[i]; ++rank) at = c.next[at];
    layers_[static_cast<size_t>(at)] = &layer;
    put(c.position, at, place.position);
    put(c.normal, at, place.normal);
    put(c.geometric_normal, at, place.geometric_normal);
    c.surface[at] = static_cast<int32_t>(place.surface_id);
    c.roughness[at] = place.roughness;
    c.width[at] = place.width;
    c.spread[at] = place.spread;
    c.nearness[at] = place.nearness;
    c.lobe[at] = share_of_lobe * 2.0f * layer.spread * alpha(place.roughness);
    for (int k = 0; k < 4; ++k) c.reflected[k][at] = chunk.reflected[i][k];
  }
}

// Merges the chunks' layers, and returns their number.
size_t LayerFilter::gather(Executor& executor) {
  size_t total = 0;
  filled_.clear();
  for (Chunk& chunk : chunks_) {
    total += chunk.layers.size();
    if (!chunk.layers.empty()) filled_.push_back(&chunk);
  }
  if (total == 0) return 0;
  fit_columns(total);
  // No pixel is in two chunks.
  executor.run(filled_.size(), [&](size_t c, uint32_t) { rank(*filled_[c]); });
  executor.run(tiles_.size(), [&](size_t tile, uint32_t) { count(tile); });
  int32_t before = 0;
  for (Tile& tile : tiles_) {
    tile.first = before;
    before += tile.count;
  }
  executor.run(tiles_.size(), [&](size_t tile, uint32_t) { link(tile); });
  executor.run(filled_.size(), [&](size_t c, uint32_t) { scatter(*filled_[c]); });
  return total;
}

// Computes the radiance of a layer from its entries: its surface's reflection, and the light seen through it. Writes it
// if i is the layer's first entry; returns false if it is not, or if nothing was filtered.
bool LayerFilter::filtered(int32_t i, glm::vec3& radiance) const {
  const LayerColumns& c = columns_;
  const Layer& layer = *layers_[static_cast<size_t>(i)];
  bool is_filtered = false;
  int32_t first = none;
  for (int32_t j = c.first[c.pixel[i]]; j != none; j = c.next[j]) {
    const Layer& other = *layers_[static_cast<size_t>(j)];
    if (other.texel != layer.texel) continue;
    if (first == none && j != i) return false;
    const bool is_first = first == none;
    first = i;
    // If all directions reflect the environment, it is prefiltered already and stays as the rasterizer shows it.
    const bool stays = c.reflected[3][j] == 0.0f;
    is_filtered = is_filtered || !stays;
    glm::vec3 reflected(c.reflected[0][j], c.reflected[1][j], c.reflected[2][j]);
    if (other.is_sampled)
      reflected = glm::mix(other.surroundings, reflected, std::min(c.reflected[3][j] / most_hidden, 1.0f));
    const glm::vec3 now = stays ? other.noise : other.weight * reflected;
    radiance = is_first ? other.rest + now : radiance + (now - other.noise);
  }
  return is_filtered;
}

void LayerFilter::apply(Executor& executor, LayerCache& cache) {
  fit(cache.width, cache.height);
  const size_t count = gather(executor);
  if (count == 0) return;
  const auto run = [&](const auto& work) {
    executor.run((count + layers_in_piece - 1) / layers_in_piece, [&](size_t piece, uint32_t) {
      work(static_cast<int32_t>(piece * layers_in_piece),
           static_cast<int32_t>(std::min(count, (piece + 1) * layers_in_piece)));
    });
  };
  const auto run_pass = [&](const auto& work) {
    run([&](int32_t first, int32_t end) {
      for (int32_t at = first; at < end; at += layers_at_once) work(at);
    });
    std::swap(columns_.reflected, columns_.filtered);
  };
  run_pass([&](int32_t at) { kernels_->prepare(columns_, at); });
  for (int32_t pass = 0; pass < layer_filter_passes; ++pass)
    run_pass([&](int32_t at) { kernels_->blur(columns_, at, pass); });
  run([&](int32_t first, int32_t end) {
    constexpr int32_t ahead = 16;
    for (int32_t i = first; i < end; ++i) {
      // Chunks are far from the columns in memory: without prefetching, half of this loop's time was waiting for them.
      if (i + ahead < end) __builtin_prefetch(layers_[static_cast<size_t>(i + ahead)]);
      glm::vec3 all;
      if (!filtered(i, all)) continue;
      const Layer& layer = *layers_[static_cast<size_t>(i)];
      store_rgba(&cache.radiance[4 * size_t{layer.texel}], all, 1.0f);
    }
  });
  executor.run(filled_.size(), [&](size_t c, uint32_t) {
    for (const Layer& layer : filled_[c]->layers) first_of(layer.pixel) = none;
  });
}

}  // namespace sideray::rt
