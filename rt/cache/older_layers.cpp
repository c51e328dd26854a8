#include "rt/cache/older_layers.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <utility>

#include "rt/cache/layer_cache.h"
#include "rt/scene/scene_difference.h"

namespace sideray::rt {
namespace {

constexpr uint16_t half_zero = 0, half_moved = 0x3800;  // LayerCache::moved_alpha
constexpr float parts_of_pixel = 4096.0f;               // units of Surface::off in a pixel
constexpr uint32_t tile_size = LayerCache::tile_size;

glm::vec2 sign_of(glm::vec2 v) {
  return {v.x < 0.0f ? -1.0f : 1.0f, v.y < 0.0f ? -1.0f : 1.0f};
}

// Encodes the normal on an unfolded octahedron.
void store_normal(glm::vec3 n, int16_t to[2]) {
  n /= std::abs(n.x) + std::abs(n.y) + std::abs(n.z);
  const glm::vec2 flat(n);
  const glm::vec2 p = n.z >= 0.0f ? flat : (1.0f - glm::abs(glm::vec2(flat.y, flat.x))) * sign_of(flat);
  to[0] = static_cast<int16_t>(std::lround(p.x * 32767.0f));
  to[1] = static_cast<int16_t>(std::lround(p.y * 32767.0f));
}

glm::dvec3 normal_of(const int16_t from[2]) {
  const glm::vec2 p = glm::vec2(from[0], from[1]) / 32767.0f;
  glm::vec3 n(p, 1.0f - std::abs(p.x) - std::abs(p.y));
  if (n.z < 0.0f) {
    const glm::vec2 folded = (1.0f - glm::abs(glm::vec2(p.y, p.x))) * sign_of(p);
    n.x = folded.x, n.y = folded.y;
  }
  return glm::normalize(glm::dvec3(n));
}

glm::dmat4 full(const glm::mat4x3& m) {
  return {glm::dvec4(m[0], 0.0), glm::dvec4(m[1], 0.0), glm::dvec4(m[2], 0.0), glm::dvec4(m[3], 1.0)};
}

// Returns whether layers of one request can be history of the other. Random numbers may differ, because they estimate
// the same light.
bool serve_alike(const CacheRequest& a, const CacheRequest& b) {
  return a.width == b.width && a.height == b.height && a.max_layers == b.max_layers &&
         a.all_translucent == b.all_translucent && a.shadows == b.shadows && a.light_bounces == b.light_bounces && a.step == b.step &&
         a.ray_reuse == b.ray_reuse && a.cache_rate == b.cache_rate && a.denoise == b.denoise &&
         a.refraction == b.refraction &&
         a.whole_pixels == b.whole_pixels && a.others_bits == b.others_bits;
}

template <typename T>
void lower(T& value, T to) {
  std::atomic_ref<T> shared(value);
  T seen = shared.load(std::memory_order_relaxed);
  while ((seen == 0 || to < seen) && !shared.compare_exchange_weak(seen, to, std::memory_order_relaxed)) {
  }
}

void set(uint8_t& mark) {
  std::atomic_ref(mark).store(1, std::memory_order_relaxed);
}

}  // namespace

struct OlderLayers::Passage {
  const CacheRequest& request;
  const FramePixels& pixels;
  Executor& executor;
  LayerCache& cache;
  const FrameCamera &then, &now;
  bool same_view;

  size_t plane() const { return size_t{request.width} * request.height; }
  size_t pixel(glm::uvec2 at) const { return size_t{at.y} * request.width + at.x; }
  size_t tile(glm::uvec2 at) const { return size_t{at.y / tile_size} * tile_count(request.width) + at.x / tile_size; }
  uint32_t rows() const { return tile_count(request.height); }
  // Calls work(pixel) for the pixels with answers in a row of tiles.
  template <typename Work>
  void for_pixels(uint32_t row, const Work& work) const {
    const uint32_t columns = tile_count(request.width);
    for (uint32_t column = 0; column < columns; ++column) {
      if (!cache.traced_tiles[size_t{row} * columns + column]) continue;
      const uint32_t x1 = std::min((column + 1) * tile_size, request.width);
      for (uint32_t y = row * tile_size; y < std::min((row + 1) * tile_size, request.height); ++y)
        for (uint32_t x = column * tile_size; x < x1; ++x) work(glm::uvec2(x, y));
    }
  }
};

bool takes_older(const CacheRequest& request) {
  const RatePattern pattern = pattern_of(request.cache_rate);
  return request.older && is_bounded(request.work) && request.requested_bits == 0 && pattern.cell_width == 1 &&
         pattern.cell_height == 1;
}

size_t OlderLayers::block_of(glm::uvec2 pixel) const {
  const size_t across = (size_t{request_.width} + traced_block - 1) / traced_block;
  return pixel.y / traced_block * across + pixel.x / traced_block;
}

bool OlderLayers::follows(const CacheRequest& request, const model::Snapshot& committed, const LayerCache& cache) const {
  return known_ && request.sequence != SequenceStep::first && serve_alike(request_, request) &&
         cache.width == request.width && cache.height == request.height && cache.layers == request.max_layers &&
         differ_in_places_only(*committed_, committed);
}

void OlderLayers::start(const CacheRequest& request, const FramePixels& pixels, Executor& executor, LayerCache& cache) {
  begin_cache(request, pixels.tiles, {}, executor, cache);
  const size_t plane = size_t{request.width} * request.height;
  traced_in_.assign(plane, 0);
  turns_.assign((size_t{request.width} + traced_block - 1) / traced_block *
                    ((size_t{request.height} + traced_block - 1) / traced_block),
                0);
  tile_oldest_.assign(pixels.tiles.size(), 0);
  surfaces_.resize(plane * request.max_layers);
  number_ = state_ = state_began_ = 1;
  has_moved_ = false;
  camera_ = FrameCamera(request.view, request.width, request.height);
}

// Finds which surfaces of layers have moved, and returns whether anything in the scene has.
bool OlderLayers::find_motions(const model::Snapshot& posed) {
  motions_.clear();
  if (&posed == posed_.get()) return false;
  bool moved = false;
  for (size_t i = 0; i < std::min(posed.instances.size(), posed_->instances.size()); ++i) {
    const model::Instance &then = posed_->instances[i], &now = posed.instances[i];
    const bool lost = posed_->meshes[then.mesh] != posed.meshes[now.mesh];
    if (!lost && then.local_from_object == now.local_from_object) continue;
    moved = true;
    if (now.surface_id == 0) continue;
    Motion motion{lost, glm::dmat4(1.0), glm::dmat3(1.0)};
    const glm::dmat4 from = full(then.local_from_object);
    if (!lost && glm::determinant(from) != 0.0) {
      motion.now_from_then = full(now.local_from_object) * glm::inverse(from);
      motion.normal_now_from_then = glm::transpose(glm::inverse(glm::dmat3(motion.now_from_then)));
    } else {
      motion.lost = true;
    }
    motions_.emplace(now.surface_id, motion);
  }
  return moved;
}

void OlderLayers::begin(const CacheRequest& request, std::shared_ptr<const model::Snapshot> posed,
                        std::shared_ptr<const model::Snapshot> committed, const FramePixels& pixels,
                        Executor& executor, LayerCache& cache) {
  if (follows(request, *committed, cache)) {
    const FrameCamera now(request.view, request.width, request.height);
    const bool same_view = camera_.sees_as(now), moved = find_motions(*posed);
    ++number_;
    const bool drifts = !committed->particles.empty() && !are_equal(*committed_, *committed);
    if (!same_view || moved || drifts || request.position_frames == 1) {
      ++state_;
      state_began_ = number_;
    }
    cache.dirty_tiles.assign(pixels.tiles.size(), 0);
    const Passage passage{request, pixels, executor, cache, camera_, now, same_view};
    if (!same_view || !motions_.empty()) carry(passage);
    drop_old(passage);
    if (request.whole_pixels) refuse_whole(passage);
    if (!same_view) camera_ = now;
  } else {
    start(request, pixels, executor, cache);
  }
  known_ = true;
  request_ = request;
  posed_ = std::move(posed);
  committed_ = std::move(committed);
}

void OlderLayers::mark(const Passage& passage, glm::uvec2 at) const {
  set(passage.cache.dirty_tiles[passage.tile(at)]);
}

// Removes a pixel's layers from index `from` on.
void OlderLayers::empty(LayerCache& cache, size_t pixel, uint32_t from) const {
  const size_t plane = size_t{cache.width} * cache.height;
  for (uint32_t k = from; k < cache.layers && cache.distance[k * plane + pixel] != 0.0f; ++k)
    cache.distance[k * plane + pixel] = 0.0f;
}

void OlderLayers::carry(const Passage& passage) {
  has_moved_ = true;
  rows_.resize(passage.rows());
  passage.executor.run(passage.rows(), [&](size_t row, uint32_t) { pull_row(passage, static_cast<uint32_t>(row)); });
  passage.executor.run(passage.rows(), [&](size_t row, uint32_t) {
    for (const Row& from : rows_)
      for (uint32_t i = from.first[row]; i < from.first[row + 1]; ++i) place(passage, from.sorted[i]);
  });
  if (!passage.same_view) fill_holes(passage);
}

void OlderLayers::pull_row(const Passage& passage, uint32_t row) {
  Row& to = rows_[row];
  to.layers.clear();
  to.last_id = 0;
  to.last_motion = nullptr;
  passage.for_pixels(row, [&](glm::uvec2 at) { pull_pixel(passage, at, to); });
  sort(to, passage.rows());
}

// Returns the motion of a surface, or null if it has not moved. No surface has the id 0.
const OlderLayers::Motion* OlderLayers::motion_of(uint32_t surface_id, Row& row) const {
  if (surface_id == row.last_id) return row.last_motion;
  const auto found = motions_.find(surface_id);
  row.last_id = surface_id;
  return row.last_motion = found == motions_.end() ? nullptr : &found->second;
}

// Removes from a pixel the layers that are now seen elsewhere. The others keep their order.
void OlderLayers::pull_pixel(const Passage& passage, glm::uvec2 at, Row& row) {
  LayerCache& cache = passage.cache;
  const size_t pixel = passage.pixel(at), plane = passage.plane();
  if (traced_in_[pixel] == 0) return;
  uint32_t kept = 0, k = 0;
  for (; k < cache.layers && cache.distance[k * plane + pixel] != 0.0f; ++k) {
    const size_t texel = k * plane + pixel;
    const Motion* motion = motion_of(cache.surface_id[texel], row);
    if (passage.same_view && !motion) {
      const size_t to = kept++ * plane + pixel;
      if (to == texel) continue;
      std::copy_n(&cache.radiance[4 * texel], 4, &cache.radiance[4 * to]);
      cache.distance[to] = cache.distance[texel];
      cache.surface_id[to] = cache.surface_id[texel];
      surfaces_[to] = surfaces_[texel];
      continue;
    }
    if (state_ - traced_in_[pixel] <= oldest)
      pull_layer(passage, at, texel, motion, row);
  }
  if (kept == k && passage.same_view) return;
  empty(cache, pixel, kept);
  if (kept == 0) traced_in_[pixel] = 0;
  if (passage.request.whole_pixels) cache.whole_transmittance[4 * pixel + 3] = half_zero;
  mark(passage, at);
}

void OlderLayers::pull_layer(const Passage& passage, glm::uvec2 at, size_t texel, const Motion* motion, Row& row) const {
  if (motion && motion->lost) return;
  const LayerCache& cache = passage.cache;
  const Surface& surface = surfaces_[texel];
  const glm::dvec2 pixel(at), place = pixel + glm::dvec2(surface.off[0], surface.off[1]) / double{parts_of_pixel};
  glm::dvec3 normal = normal_of(surface.normal);
  const double distance = std::abs(double{cache.distance[texel]});
  std::optional<glm::dvec3> point = passage.then.point(pixel, {distance, normal}, place);
  if (!point) return;
  const bool front = glm::dot(normal, passage.then.direction(pixel)) < 0.0;
  if (motion) {
    point = glm::dvec3(motion->now_from_then * glm::dvec4(*point, 1.0));
    normal = glm::normalize(motion->normal_now_from_then * normal);
  }
  const std::optional<glm::dvec2> seen = passage.now.place(*point);
  if (!seen) return;
  const glm::dvec2 nearest = glm::floor(*seen + 0.5);
  if (!(nearest.x >= 0.0 && nearest.y >= 0.0 && nearest.x < passage.request.width && nearest.y < passage.request.height))
    return;
  const std::optional<double> now = passage.now.distance(nearest, *point, normal);
  // The two sides of a surface look different.
  if (!now || (glm::dot(normal, passage.now.direction(nearest)) < 0.0) != front) return;
  const glm::uvec2 to(nearest);
  Carried carried{.pixel = static_cast<uint32_t>(passage.pixel(to)),
                  .row = to.y / tile_size,
                  .surface_id = cache.surface_id[texel],
                  .traced_in = traced_in_[passage.pixel(at)],
                  .distance = std::copysign(static_cast<float>(*now), cache.distance[texel]),
                  .surface = {},
                  .radiance = {}};
  store_normal(glm::vec3(normal), carried.surface.normal);
  const glm::dvec2 off = (*seen - nearest) * double{parts_of_pixel};
  carried.surface.off[0] = static_cast<int16_t>(std::lround(off.x));
  carried.surface.off[1] = static_cast<int16_t>(std::lround(off.y));
  std::copy_n(&cache.radiance[4 * texel], 3, carried.radiance);
  row.layers.push_back(carried);
}

// Sorts layers stably by the row of tiles that they are moved to.
void OlderLayers::sort(Row& row, uint32_t rows) {
  row.first.assign(size_t{rows} + 1, 0);
  for (const Carried& layer : row.layers) ++row.first[layer.row + 1];
  for (size_t i = 0; i < rows; ++i) row.first[i + 1] += row.first[i];
  std::vector<uint32_t> next(row.first.begin(), row.first.end() - 1);
  row.sorted.resize(row.layers.size());
  for (const Carried& layer : row.layers) row.sorted[next[layer.row]++] = layer;
}

// Inserts a layer into its pixel, nearest first. Of two layers of one surface less than a pixel apart, the one that was
// traced nearer to the pixel's middle stays.
void OlderLayers::place(const Passage& passage, const Carried& layer) {
  LayerCache& cache = passage.cache;
  const size_t plane = passage.plane(), pixel = layer.pixel;
  const auto off = [](const Surface& s) { return s.off[0] * s.off[0] + s.off[1] * s.off[1]; };
  const float distance = std::abs(layer.distance);
  const auto same = static_cast<float>(passage.now.breadth(double{distance}));
  uint32_t count = 0, twin = cache.layers;
  for (; count < cache.layers && cache.distance[count * plane + pixel] != 0.0f; ++count) {
    const size_t texel = count * plane + pixel;
    if (cache.surface_id[texel] == layer.surface_id && std::abs(std::abs(cache.distance[texel]) - distance) <= same)
      twin = count;
  }
  if (twin < cache.layers && off(surfaces_[twin * plane + pixel]) <= off(layer.surface)) return;
  uint32_t at = twin < cache.layers ? twin : std::min(count, cache.layers - 1);
  if (twin == cache.layers && count == cache.layers && std::abs(cache.distance[at * plane + pixel]) <= distance) return;
  const auto move = [&](uint32_t from, uint32_t to) {
    const size_t a = from * plane + pixel, b = to * plane + pixel;
    std::copy_n(&cache.radiance[4 * a], 4, &cache.radiance[4 * b]);
    cache.distance[b] = cache.distance[a];
    cache.surface_id[b] = cache.surface_id[a];
    surfaces_[b] = surfaces_[a];
  };
  for (; at > 0 && std::abs(cache.distance[(at - 1) * plane + pixel]) > distance; --at) move(at - 1, at);
  for (; twin < cache.layers && at + 1 < count && std::abs(cache.distance[(at + 1) * plane + pixel]) < distance; ++at)
    move(at + 1, at);
  const size_t texel = at * plane + pixel;
  std::copy_n(layer.radiance, 3, &cache.radiance[4 * texel]);
  cache.radiance[4 * texel + 3] = half_moved;
  cache.distance[texel] = layer.distance;
  cache.surface_id[texel] = layer.surface_id;
  surfaces_[texel] = layer.surface;
  uint32_t& traced_in = traced_in_[pixel];
  traced_in = traced_in == 0 ? layer.traced_in : std::min(traced_in, layer.traced_in);
  if (passage.request.whole_pixels) cache.whole_transmittance[4 * pixel + 3] = half_zero;
  const glm::uvec2 where(layer.pixel % passage.request.width, layer.pixel / passage.request.width);
  mark(passage, where);
  set(cache.traced_tiles[passage.tile(where)]);
  lower(tile_oldest_[passage.tile(where)], layer.traced_in);
}

// Layers that come nearer leave gaps between their pixels, which are filled from a neighbour.
void OlderLayers::fill_holes(const Passage& passage) {
  constexpr size_t piece = 1024;
  constexpr glm::ivec2 beside[] = {{-1, 0}, {1, 0}, {0, -1}, {0, 1}};
  struct Hole {
    glm::uvec2 at, from;
  };
  const std::vector<PixelRequest>& pixels = passage.pixels.pixels;
  std::vector<std::vector<Hole>> holes((pixels.size() + piece - 1) / piece);
  passage.executor.run(holes.size(), [&](size_t part, uint32_t) {
    for (size_t i = part * piece; i < std::min(pixels.size(), (part + 1) * piece); ++i) {
      const glm::uvec2 at(pixels[i].x, pixels[i].y);
      if (traced_in_[passage.pixel(at)] != 0) continue;
      for (const glm::ivec2 off : beside) {
        const glm::uvec2 from(glm::ivec2(at) + off);
        if (from.x >= passage.request.width || from.y >= passage.request.height) continue;
        if (traced_in_[passage.pixel(from)] == 0) continue;
        holes[part].push_back({at, from});
        break;
      }
    }
  });
  passage.executor.run(holes.size(), [&](size_t part, uint32_t) {
    for (const Hole& hole : holes[part]) fill_hole(passage, hole.at, hole.from);
  });
}

void OlderLayers::fill_hole(const Passage& passage, glm::uvec2 at, glm::uvec2 from) {
  LayerCache& cache = passage.cache;
  const size_t plane = passage.plane(), source = passage.pixel(from);
  const glm::dvec2 off = (glm::dvec2(from) - glm::dvec2(at)) * double{parts_of_pixel};
  for (uint32_t k = 0; k < cache.layers && cache.distance[k * plane + source] != 0.0f; ++k) {
    const size_t texel = k * plane + source;
    const glm::dvec3 normal = normal_of(surfaces_[texel].normal);
    const double then = std::abs(double{cache.distance[texel]});
    const std::optional<glm::dvec3> point = passage.now.point(glm::dvec2(from), {then, normal}, glm::dvec2(from));
    const std::optional<double> now = passage.now.distance(glm::dvec2(at), *point, normal);
    if (!now) continue;
    Carried layer{.pixel = static_cast<uint32_t>(passage.pixel(at)),
                  .row = at.y / tile_size,
                  .surface_id = cache.surface_id[texel],
                  .traced_in = traced_in_[source],
                  .distance = std::copysign(static_cast<float>(*now), cache.distance[texel]),
                  .surface = surfaces_[texel],
                  .radiance = {}};
    layer.surface.off[0] = static_cast<int16_t>(layer.surface.off[0] + static_cast<int>(off.x));
    layer.surface.off[1] = static_cast<int16_t>(layer.surface.off[1] + static_cast<int>(off.y));
    std::copy_n(&cache.radiance[4 * texel], 3, layer.radiance);
    place(passage, layer);
  }
}

// Clears pixels whose history has expired. Tiles without such pixels are skipped.
void OlderLayers::drop_old(const Passage& passage) {
  const uint32_t columns = tile_count(passage.request.width);
  const auto is_old = [&](uint32_t traced_in) { return traced_in != 0 && state_ - traced_in > oldest; };
  passage.executor.run(tile_oldest_.size(), [&](size_t tile, uint32_t) {
    if (!is_old(tile_oldest_[tile])) return;
    uint32_t least = 0;
    const auto x0 = static_cast<uint32_t>(tile % columns) * tile_size, y0 = static_cast<uint32_t>(tile / columns) * tile_size;
    for (uint32_t y = y0; y < std::min(y0 + tile_size, passage.request.height); ++y)
      for (uint32_t x = x0; x < std::min(x0 + tile_size, passage.request.width); ++x) {
        uint32_t& traced_in = traced_in_[passage.pixel({x, y})];
        if (is_old(traced_in)) {
          traced_in = 0;
          empty(passage.cache, passage.pixel({x, y}), 0);
          if (passage.request.whole_pixels)
            passage.cache.whole_transmittance[4 * passage.pixel({x, y}) + 3] = half_zero;
          passage.cache.dirty_tiles[tile] = 1;
        }
        if (traced_in != 0 && (least == 0 || traced_in < least)) least = traced_in;
      }
    tile_oldest_[tile] = least;
  });
}

// A pixel stays whole only if it holds as many surfaces as the mask counts.
void OlderLayers::refuse_whole(const Passage& passage) {
  LayerCache& cache = passage.cache;
  passage.executor.run(passage.rows(), [&](size_t row, uint32_t) {
    passage.for_pixels(static_cast<uint32_t>(row), [&](glm::uvec2 at) {
      const size_t pixel = passage.pixel(at);
      uint16_t& whole = cache.whole_transmittance[4 * pixel + 3];
      if (whole == half_zero) return;
      uint32_t count = 0;
      while (count < cache.layers && cache.distance[count * passage.plane() + pixel] != 0.0f) ++count;
      if (counted_surfaces(passage.request, at.x, at.y) == count) return;
      whole = half_zero;
      cache.dirty_tiles[passage.tile(at)] = 1;
    });
  });
}

std::vector<uint8_t> OlderLayers::answers() const {
  std::vector<uint8_t> answers(traced_in_.size(), no_answer);
  for (uint32_t y = 0; y < request_.height; ++y)
    for (uint32_t x = 0; x < request_.width; ++x) {
      const size_t pixel = size_t{y} * request_.width + x;
      if (traced_in_[pixel] == 0) continue;
      const uint32_t age = std::min(state_ - traced_in_[pixel], oldest);
      answers[pixel] = age == 0 && turns_[block_of({x, y})] == number_ ? uint8_t{0} : static_cast<uint8_t>(1 + age);
    }
  return answers;
}

uint32_t OlderLayers::last_turn(std::span<const PixelRequest> pixels) const {
  uint32_t least = number_;
  size_t nothing = 0;
  for (const PixelRequest& p : pixels) {
    least = std::min(least, turns_[block_of({p.x, p.y})]);
    nothing += traced_in_[size_t{p.y} * request_.width + p.x] == 0;
  }
  return 2 * nothing > pixels.size() ? 0 : least;
}

void OlderLayers::clear(std::span<const PixelRequest> pixels, LayerCache& cache) {
  const size_t plane = size_t{cache.width} * cache.height;
  for (const PixelRequest& p : pixels) {
    const size_t pixel = size_t{p.y} * cache.width + p.x;
    traced_in_[pixel] = 0;
    set(cache.dirty_tiles[size_t{p.y / tile_size} * tile_count(cache.width) + p.x / tile_size]);
    for (uint32_t k = 0; k < cache.layers; ++k) {
      const size_t texel = k * plane + pixel;
      std::fill_n(&cache.radiance[4 * texel], 4, half_zero);
      cache.distance[texel] = 0.0f;
      cache.surface_id[texel] = 0;
    }
    if (!cache.whole_transmittance.empty()) std::fill_n(&cache.whole_transmittance[4 * pixel], 4, half_zero);
  }
}

void OlderLayers::record(size_t texel, glm::vec3 normal) {
  Surface& surface = surfaces_[texel];
  store_normal(normal, surface.normal);
  surface.off[0] = surface.off[1] = 0;
}

void OlderLayers::traced(std::span<const PixelRequest> pixels, LayerCache& cache) {
  for (const PixelRequest& p : pixels) {
    traced_in_[size_t{p.y} * cache.width + p.x] = state_;
    turns_[block_of({p.x, p.y})] = number_;
    const size_t tile = size_t{p.y / tile_size} * tile_count(cache.width) + p.x / tile_size;
    set(cache.traced_tiles[tile]);
    lower(tile_oldest_[tile], state_);
  }
}

uint64_t OlderLayers::leave(std::span<const PixelRequest> pixels, Counters& counters) const {
  uint32_t nothing = 0, earliest = state_, turn = number_;
  for (const PixelRequest& p : pixels) {
    turn = std::min(turn, turns_[block_of({p.x, p.y})]);
    const uint32_t traced_in = traced_in_[size_t{p.y} * request_.width + p.x];
    nothing += traced_in == 0;
    earliest = std::min(earliest, traced_in == 0 ? state_ : traced_in);
  }
  counters.pixels_older += pixels.size() - nothing;
  counters.answer_age = std::max<uint64_t>(counters.answer_age, state_ - earliest);
  // Layers of the present state may be as old as its first frame, and older ones have waited longer. Their block may
  // have been traced since, but only other pixels of it.
  const uint32_t waiting = std::max(number_ - state_began_ + state_ - earliest, number_ - turn);
  counters.frames_waiting = std::max<uint64_t>(counters.frames_waiting, waiting);
  return nothing;
}

}  // namespace sideray::rt
