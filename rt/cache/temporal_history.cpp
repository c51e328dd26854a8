#include "rt/cache/temporal_history.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>

#include "rt/base/deadline.h"
#include "rt/base/half_bits.h"
#include "rt/base/largest.h"
#include "rt/scene/scene_difference.h"
#include "rt/surfaces/surface.h"

namespace sideray::rt {
namespace {

// A point nearer to a pixel's centre than this is that pixel: a still view copies, and loses nothing to rounding.
constexpr double same_pixel_px = 1.0 / 64;
// A neighbour may lie off the plane of the requested surface by this, in widths of its own pixel there.
constexpr double off_plane_px = 0.25;
// At least this share of the four neighbours must know the surface: less would stretch the farthest of them.
constexpr double least_weight = 0.25;
// All four must know it where shading is reused, since edges are shaded.
constexpr double all_weight = 0.999;
// Pixels take their turn, and changes are noted, in cells of so many pixels a side where shading is reused: what is shaded
// together traces rays in full packets, and has donors. A change is taken to reach so many cells beyond its own, since cells
// whose turn it is lie up to three apart.
constexpr uint32_t cell = 4;
constexpr int change_reach = 2;
// A cell has changed where one of so many layers has: a line through it is enough.
constexpr uint32_t least_changed = 4;
// This bounds the angle by which the eye's ray or the surface may have turned: what a mirror shows turns twice as far.
constexpr double least_turn_cosine = 0.998;  // 3.6 degrees

glm::dvec3 local_position(const model::Snapshot& snapshot, const Hit& hit) {
  const model::Instance& instance = snapshot.instances[hit.instance];
  const model::Mesh& mesh = *snapshot.meshes[instance.mesh];
  const glm::uvec3 t = mesh.triangles[hit.primitive];
  const glm::dvec3 p = glm::dvec3(mesh.positions[t.x]) * (1.0 - double{hit.u} - double{hit.v}) +
                       glm::dvec3(mesh.positions[t.y]) * double{hit.u} +
                       glm::dvec3(mesh.positions[t.z]) * double{hit.v};
  return glm::dmat4x3(instance.local_from_object) * glm::dvec4(p, 1.0);
}

// Returns where a point is in the picture; pixel centres lie at whole numbers. None behind the eye and outside the
// picture.
std::optional<glm::dvec2> pixel_of(const CacheRequest& request, glm::dvec3 point) {
  const glm::dvec4 clip = request.view.clip_from_local * glm::dvec4(point, 1.0);
  if (!(clip.w > 0.0)) return std::nullopt;
  const glm::dvec2 size(request.width, request.height);
  const glm::dvec2 pixel = (glm::dvec2(clip) / clip.w * 0.5 + 0.5) * size - 0.5;
  const bool inside = pixel.x > -1.0 && pixel.y > -1.0 && pixel.x < size.x && pixel.y < size.y;
  return inside ? std::optional(pixel) : std::nullopt;
}

bool is_inside(const CacheRequest& request, glm::dvec2 pixel) {
  return pixel.x >= 0.0 && pixel.y >= 0.0 && pixel.x < request.width && pixel.y < request.height;
}

// Calls `use` with each pixel of a picture that a place lies between, and with the pixel's bilinear share of it: four, or the
// one at which it lies.
template <typename Use>
void for_pixels_around(const CacheRequest& picture, glm::dvec2 at, const Use& use) {
  const glm::dvec2 nearest = glm::floor(at + 0.5), corner = glm::floor(at);
  const bool same_pixel = glm::all(glm::lessThan(glm::abs(at - nearest), glm::dvec2(same_pixel_px)));
  for (int i = 0; i < (same_pixel ? 1 : 4); ++i) {
    const glm::dvec2 pixel = same_pixel ? nearest : corner + glm::dvec2(i & 1, i >> 1);
    if (!is_inside(picture, pixel)) continue;
    const glm::dvec2 share = same_pixel ? glm::dvec2(1.0) : 1.0 - glm::abs(at - pixel);
    use(pixel, share.x * share.y);
  }
}

// Makes a weighted mean of layers; the mean of one layer is that layer to the last bit.
struct Blend {
  glm::dvec3 radiance{0.0};
  double weight = 0.0;
  const LayerHistory::Layer* only = nullptr;
  int count = 0;

  void add(const LayerHistory::Layer& layer, double share) {
    if (share <= 0.0) return;
    only = ++count == 1 ? &layer : nullptr;
    for (int c = 0; c < 3; ++c) radiance[c] += share * double{imath_half_to_float(layer.radiance[c])};
    weight += share;
  }
  LayerHistory::Layer layer(float distance, uint32_t surface_id) const {
    LayerHistory::Layer result{.radiance = {}, .distance = distance, .surface_id = surface_id};
    for (int c = 0; c < 3; ++c)
      result.radiance[c] = only ? only->radiance[c] : half_bits(static_cast<float>(radiance[c] / weight));
    return result;
  }
};

// Returns how many cells a row or column of the picture has.
uint32_t cells(uint32_t pixels) {
  return (pixels + cell - 1) / cell;
}

// Marks what lies within `reach` of a marked cell of a row, whose cells are `step` apart.
void spread_row(const uint8_t* from, size_t count, size_t step, int reach, uint8_t* to) {
  for (size_t i = 0; i < count; ++i) {
    if (from[i * step] == 0) continue;
    const size_t first = i < static_cast<size_t>(reach) ? 0 : i - static_cast<size_t>(reach);
    for (size_t k = first; k < std::min(count, i + static_cast<size_t>(reach) + 1); ++k) to[k * step] = 1;
  }
}

// Marks what lies within `reach` cells of a marked one, along x and along y.
std::vector<uint8_t> spread(const std::vector<uint8_t>& marks, uint32_t width, uint32_t height, int reach) {
  std::vector<uint8_t> along_x(marks.size(), 0), both(marks.size(), 0);
  for (uint32_t y = 0; y < height; ++y)
    spread_row(&marks[size_t{y} * width], width, 1, reach, &along_x[size_t{y} * width]);
  for (uint32_t x = 0; x < width; ++x) spread_row(&along_x[x], height, width, reach, &both[x]);
  return both;
}

glm::vec3 radiance_of(const uint16_t halfs[3]) {
  return {imath_half_to_float(halfs[0]), imath_half_to_float(halfs[1]), imath_half_to_float(halfs[2])};
}

// Mixes layers of the frame before, and finds how far apart they are in their pixels.
struct Mixture {
  bool noisy = false;
  uint16_t age = 0;
  double weight = 0.0;
  int count = 0;
  const LayerHistory::Layer* only = nullptr;
  glm::vec3 radiance{0.0f}, through{0.0f}, lowest{INFINITY}, highest{-INFINITY}, least{INFINITY}, most{-INFINITY};
  float cover = 0.0f;

  void add(const LayerHistory::Layer& layer, double share) {
    if (share <= 0.0) return;
    only = ++count == 1 ? &layer : nullptr;
    const auto part = static_cast<float>(share);
    const glm::vec3 light = radiance_of(layer.radiance), seen = light * layer.blend.cover;
    radiance += part * light;
    through += part * layer.blend.through;
    cover += part * layer.blend.cover;
    lowest = glm::min(lowest, seen), highest = glm::max(highest, seen);
    least = glm::min(least, layer.blend.through), most = glm::max(most, layer.blend.through);
    noisy = noisy || layer.noisy;
    age = std::max(age, layer.age);
    weight += share;
  }
  // Returns by how much the layers differ in the picture, before something white.
  float apart() const { return std::max(largest(highest - lowest), largest(most - least)); }
  LayerHistory::Layer layer() const {
    if (only) return *only;
    LayerHistory::Layer mixed{};
    const float whole = 1.0f / static_cast<float>(weight);
    for (int c = 0; c < 3; ++c) mixed.radiance[c] = half_bits(radiance[c] * whole);
    mixed.blend = {cover * whole, through * whole};
    mixed.age = age;
    mixed.noisy = noisy;
    return mixed;
  }
};

// Returns whether the shading of one request holds for the other. Random numbers are estimates of the same light.
bool follows(const CacheRequest& before, const CacheRequest& now) {
  return before.shading_reuse == now.shading_reuse && before.refraction == now.refraction &&
         before.denoise == now.denoise && before.width == now.width && before.height == now.height &&
         before.max_layers == now.max_layers &&
         before.all_translucent == now.all_translucent && before.shadows == now.shadows &&
         before.step == now.step && before.cache_rate == now.cache_rate;
}

}  // namespace

uint32_t temporal_period(sideray_cache_rate rate) {
  if (rate == SIDERAY_RATE_TEMPORAL4) return 4;
  return rate == SIDERAY_RATE_TEMPORAL8 ? 8 : 0;
}

uint32_t temporal_period(const CacheRequest& request) {
  return request.shading_reuse > 0.0f ? 8 : temporal_period(request.cache_rate);
}

bool is_shaded_anew(uint32_t period, uint32_t frame, uint32_t x, uint32_t y) {
  // The pixels solve x + 2y = c (mod 4) and x + 3y = c (mod 8): nearest neighbours are 2 and sqrt(8) pixels apart.
  static constexpr uint32_t order4[] = {0, 2, 1, 3}, order8[] = {0, 4, 2, 6, 1, 5, 3, 7};
  if (period == 4) return (x + 2 * y) % 4 == order4[frame % 4];
  return (x + 3 * y) % 8 == order8[frame % 8];
}

void LayerHistory::begin(const CacheRequest& request, std::shared_ptr<const model::Snapshot> snapshot,
                         std::shared_ptr<const model::Snapshot> committed, const FramePixels& pixels) {
  period_ = temporal_period(request);
  if (request.sequence != SequenceStep::again) current_ = 1 - current_;
  Frame& previous = frames_[1 - current_];
  if (request.sequence == SequenceStep::first) previous.complete = false;
  previous_rays_.reset();
  if (previous.complete && follows(previous.request, request) && differ_in_places_only(*previous.committed, *committed))
    previous_rays_.emplace(previous.request.view, previous.request.width, previous.request.height);
  if (previous_rays_ && request.shading_reuse > 0.0f)
    changed_around_ = spread(changed_cells(previous), cells(request.width), cells(request.height), change_reach);
  if (request.sequence != SequenceStep::again) number_ = previous_rays_ ? number_ + 1 : 0;
  Frame& frame = frames_[current_];
  frame.complete = false;
  frame.request = request;
  frame.snapshot = std::move(snapshot);
  frame.committed = std::move(committed);
  allot(pixels);
}

// Returns which cells have changed: a few layers may differ because they reuse rays, or by noise.
std::vector<uint8_t> LayerHistory::changed_cells(const Frame& frame) {
  std::vector<uint8_t> marks(frame.changed.size());
  for (size_t i = 0; i < marks.size(); ++i)
    marks[i] = frame.changed[i] > 0 && frame.changed[i] * least_changed >= frame.compared[i];
  return marks;
}

void LayerHistory::end(bool finished) {
  frames_[current_].complete = finished;
}

void LayerHistory::allot(const FramePixels& pixels) {
  Frame& frame = frames_[current_];
  const size_t texels = size_t{frame.request.width} * frame.request.height;
  frame.first.resize(texels);
  frame.slots.assign(texels, 0);
  uint32_t first = 0;
  for (const PixelRequest& p : pixels.pixels) {
    const size_t texel = size_t{p.y} * frame.request.width + p.x;
    frame.first[texel] = first;
    frame.slots[texel] = static_cast<uint8_t>(p.layers);
    first += p.layers;
  }
  frame.layers.resize(first);
  const bool reuses = frame.request.shading_reuse > 0.0f;
  expected_.resize(reuses ? first : 0);
  const size_t all_cells = reuses ? size_t{cells(frame.request.width)} * cells(frame.request.height) : 0;
  frame.changed.assign(all_cells, 0);
  frame.compared.assign(all_cells, 0);
  // Each pixel is cleared where it is traced; pixels that are given up are not, so all are cleared here.
  if (has_deadline(frame.request.deadline)) std::fill(frame.layers.begin(), frame.layers.end(), Layer{});
}

bool LayerHistory::is_shaded_anew(uint32_t x, uint32_t y) const {
  if (!previous_rays_) return true;
  const bool reuses = frames_[current_].request.shading_reuse > 0.0f;
  return reuses ? rt::is_shaded_anew(period_, number_, x / cell, y / cell)
                : rt::is_shaded_anew(period_, number_, x, y);
}

void LayerHistory::clear(const PixelRequest& pixel) {
  Frame& frame = frames_[current_];
  const size_t texel = size_t{pixel.y} * frame.request.width + pixel.x;
  std::fill_n(frame.layers.begin() + frame.first[texel], frame.slots[texel], Layer{});
  if (!expected_.empty()) std::fill_n(expected_.begin() + frame.first[texel], frame.slots[texel], Expected{});
}

size_t LayerHistory::slot_of(const PixelRequest& pixel, uint32_t slot) const {
  const Frame& frame = frames_[current_];
  return size_t{frame.first[size_t{pixel.y} * frame.request.width + pixel.x]} + slot;
}

void LayerHistory::record(const PixelRequest& pixel, uint32_t slot, const Layer& layer) {
  recorded(pixel, slot) = layer;
}

LayerHistory::Layer& LayerHistory::recorded(const PixelRequest& pixel, uint32_t slot) {
  return frames_[current_].layers[slot_of(pixel, slot)];
}

void LayerHistory::expect(const PixelRequest& pixel, uint32_t slot, const Layer& before) {
  Expected& expected = expected_[slot_of(pixel, slot)];
  std::copy_n(before.radiance, 3, expected.radiance);
  expected.known = true;
}

void LayerHistory::leave_to_filter(const PixelRequest& pixel, uint32_t slot) {
  expected_[slot_of(pixel, slot)].filtered = true;
}

// Counts a layer, and a change of its light, in its pixel's cell, which threads of other pixels may share.
void LayerHistory::compare(uint32_t texel, size_t slot) {
  Frame& frame = frames_[current_];
  const Expected& expected = expected_[slot];
  const Layer& layer = frame.layers[slot];
  if (!expected.known || layer.noisy) return;
  const glm::vec3 change = glm::abs(radiance_of(layer.radiance) - radiance_of(expected.radiance));
  const uint32_t x = texel % frame.request.width, y = texel / frame.request.width;
  const size_t at = size_t{y / cell} * cells(frame.request.width) + x / cell;
  std::atomic_ref(frame.compared[at]).fetch_add(1, std::memory_order_relaxed);
  if (largest(change) * layer.blend.cover > frame.request.shading_reuse)
    std::atomic_ref(frame.changed[at]).fetch_add(1, std::memory_order_relaxed);
}

void LayerHistory::compare(const PixelRequest& pixel) {
  const Frame& frame = frames_[current_];
  const uint32_t texel = pixel.y * frame.request.width + pixel.x;
  for (size_t slot = frame.first[texel]; slot < size_t{frame.first[texel]} + frame.slots[texel]; ++slot)
    if (!expected_[slot].filtered) compare(texel, slot);
}

void LayerHistory::replace(uint32_t texel, uint32_t slot, const uint16_t radiance[3]) {
  Frame& frame = frames_[current_];
  std::copy_n(radiance, 3, frame.layers[frame.first[texel] + slot].radiance);
  if (!expected_.empty()) compare(texel, size_t{frame.first[texel]} + slot);
}

// Returns, among one pixel's layers of this surface, the one that lies nearest to its plane.
const LayerHistory::Layer* LayerHistory::layer_at(glm::ivec2 at, uint32_t surface_id, const Place& place) const {
  const Frame& before = frames_[1 - current_];
  const auto x = static_cast<uint32_t>(at.x), y = static_cast<uint32_t>(at.y);
  const size_t texel = size_t{y} * before.request.width + x;
  if (before.slots[texel] == 0) return nullptr;
  const Ray ray = previous_rays_->ray(x, y);
  const Cone cone = previous_rays_->cone(x, y);
  const Layer* nearest = nullptr;
  double least = std::numeric_limits<double>::infinity();
  for (uint32_t k = 0; k < before.slots[texel]; ++k) {
    const Layer& layer = before.layers[before.first[texel] + k];
    if (layer.distance <= 0.0f) break;
    if (layer.surface_id != surface_id) continue;
    const double distance = double{layer.distance};
    const glm::dvec3 offset = glm::dvec3(ray.origin) + glm::dvec3(ray.direction) * distance - place.point;
    const double off_plane = std::abs(glm::dot(offset, place.normal));
    if (off_plane > off_plane_px * (double{cone.width} + double{cone.spread} * distance) || off_plane >= least)
      continue;
    least = off_plane;
    nearest = &layer;
  }
  return nearest;
}

// Returns where the surface was in the frame before.
LayerHistory::Place LayerHistory::place_before(const Hit& hit, const Ray& ray) const {
  const model::Snapshot& before = *frames_[1 - current_].snapshot;
  const model::Snapshot& current = *frames_[current_].snapshot;
  const model::Instance &then = before.instances[hit.instance], &now = current.instances[hit.instance];
  const bool moved =
      then.local_from_object != now.local_from_object || before.meshes[then.mesh] != current.meshes[now.mesh];
  return {moved ? local_position(before, hit) : glm::dvec3(ray.origin) + glm::dvec3(ray.direction) * hit.distance,
          glm::dvec3(geometric_normal(before, hit))};
}

std::optional<LayerHistory::Layer> LayerHistory::find(const Hit& hit, const Ray& ray) const {
  if (!previous_rays_) return std::nullopt;
  const Frame& before = frames_[1 - current_];
  const model::Instance& instance = frames_[current_].snapshot->instances[hit.instance];
  const Place place = place_before(hit, ray);
  const std::optional<glm::dvec2> at = pixel_of(before.request, place.point);
  if (!at) return std::nullopt;

  Blend blend;
  for_pixels_around(before.request, *at, [&](glm::dvec2 pixel, double share) {
    if (const Layer* layer = layer_at(glm::ivec2(pixel), instance.surface_id, place)) blend.add(*layer, share);
  });
  if (blend.weight < least_weight) return std::nullopt;
  return blend.layer(static_cast<float>(hit.distance), instance.surface_id);
}

// Returns whether light was found to have changed around a place of the picture before.
bool LayerHistory::has_changed_around(glm::dvec2 pixel) const {
  const CacheRequest& before = frames_[1 - current_].request;
  const auto of = [](double p, uint32_t size) { return static_cast<uint32_t>(std::clamp(p, 0.0, size - 1.0)) / cell; };
  return changed_around_[size_t{of(pixel.y, before.height)} * cells(before.width) + of(pixel.x, before.width)] != 0;
}

// Returns whether the surface was seen, and lay, at about the angle that it has now.
bool LayerHistory::sees_alike(const Hit& hit, const Ray& ray, const glm::dvec3& point, bool moved) const {
  const glm::dvec3 towards = previous_rays_->perspective() ? glm::normalize(point - previous_rays_->eye())
                                                           : glm::dvec3(previous_rays_->ray(0, 0).direction);
  if (glm::dot(towards, glm::dvec3(ray.direction)) < least_turn_cosine) return false;
  if (!moved) return true;
  const glm::vec3 before = geometric_normal(*frames_[1 - current_].snapshot, hit);
  return double{glm::dot(before, geometric_normal(*frames_[current_].snapshot, hit))} >= least_turn_cosine;
}

// Looks for a surface among the layers of a pixel of the frame before. Its plane is asked for where the distance alone
// does not tell.
struct LayerHistory::Seeker {
  const Frame& before;
  const Hit& hit;
  uint32_t surface_id;
  glm::dvec3 point;
  double tolerance;
  std::optional<glm::dvec3> normal;

  double off_plane(const Layer& layer) {
    const glm::dvec3 apart = glm::dvec3(layer.position) - point;
    if (glm::dot(apart, apart) <= tolerance * tolerance) return 0.0;
    if (!normal) normal = glm::dvec3(geometric_normal(*before.snapshot, hit));
    return std::abs(glm::dot(apart, *normal));
  }
  const Layer* at(glm::dvec2 pixel) {
    const size_t texel = static_cast<size_t>(pixel.y) * before.request.width + static_cast<size_t>(pixel.x);
    const Layer* nearest = nullptr;
    double least = tolerance;
    for (uint32_t k = 0; k < before.slots[texel]; ++k) {
      const Layer& layer = before.layers[before.first[texel] + k];
      if (layer.distance <= 0.0f) break;
      if (layer.surface_id != surface_id || layer.front != hit.front) continue;
      const double off = off_plane(layer);
      if (off > least || (nearest && off == least)) continue;
      least = off;
      nearest = &layer;
    }
    return nearest;
  }
};

std::optional<LayerHistory::Past> LayerHistory::past(const Hit& hit, const Ray& ray, float footprint) const {
  if (!previous_rays_) return std::nullopt;
  const Frame &before = frames_[1 - current_], &current = frames_[current_];
  const model::Instance &then = before.snapshot->instances[hit.instance],
                        &now = current.snapshot->instances[hit.instance];
  const bool moved = before.snapshot != current.snapshot &&
                     (then.local_from_object != now.local_from_object ||
                      before.snapshot->meshes[then.mesh] != current.snapshot->meshes[now.mesh]);
  const glm::dvec3 point = moved ? local_position(*before.snapshot, hit)
                                 : glm::dvec3(ray.origin) + glm::dvec3(ray.direction) * hit.distance;
  const std::optional<glm::dvec2> at = pixel_of(before.request, point);
  if (!at) return std::nullopt;

  Seeker seeker{before, hit, now.surface_id, point, off_plane_px * double{footprint}, {}};
  Mixture mixture;
  for_pixels_around(before.request, *at, [&](glm::dvec2 pixel, double share) {
    if (const Layer* layer = seeker.at(pixel)) mixture.add(*layer, share);
  });
  if (mixture.weight < least_weight) return std::nullopt;
  Layer layer = mixture.layer();
  ++layer.age;
  layer.distance = static_cast<float>(hit.distance);
  layer.surface_id = now.surface_id;
  layer.front = hit.front;
  layer.position = ray.origin + ray.direction * static_cast<float>(hit.distance);
  const bool stands = mixture.weight >= all_weight && !mixture.noisy &&
                      mixture.apart() <= current.request.shading_reuse && sees_alike(hit, ray, point, moved);
  return Past{layer, stands, stands && layer.age <= oldest && !has_changed_around(*at)};
}

}  // namespace sideray::rt
