#include "rt/masks/older_masks.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "rt/base/pixels.h"
#include "rt/masks/kept_masks.h"
#include "rt/masks/mask_rays.h"

namespace sideray::rt {
namespace {

constexpr uint32_t tile_side = frame_tile_size;
constexpr uint32_t filter_side = OcclusionMasks::filter_tile;
// By this share of its depth a surface may be off where it was seen before: less than what lies behind an edge.
constexpr float same_depth = 1.0f / 128.0f;
// An eye that moved by less than this stands still, in units of its distance from the origin and 1.
constexpr double same_eye = 1e-8;
constexpr double same_pixel = 1.0 / 1024;

// Leaves out what masks of single lights do not show.
std::vector<model::Light> lights_as_masked(const MaskRequest& request, std::vector<model::Light> lights) {
  if (request.combined_lights) return lights;
  for (model::Light& light : lights) {
    light = reaching(light, request.least_light);
    light.intensity = glm::vec3(0.0f);
  }
  return lights;
}

bool see_alike(const FilterCamera& a, const FilterCamera& b, uint32_t width, uint32_t height) {
  if (glm::length(a.eye - b.eye) > same_eye * (1.0 + glm::length(a.eye))) return false;
  for (int i = 0; i < 4; ++i) {
    const double x = i & 1 ? width : 0.0, y = i & 2 ? height : 0.0;
    const glm::dvec3 moved = a.ray + a.ray_x * x + a.ray_y * y - (b.ray + b.ray_x * x + b.ray_y * y);
    if (!(glm::length(moved) <= same_pixel * glm::length(a.ray_y))) return false;
  }
  return true;
}

// Counts the pixels of a row of a tile that show a surface. `depths`: null where that is not known.
void count_row(std::span<const uint8_t> ages, const float* depths, Counters& counters) {
  std::array<uint8_t, tile_side> shows;
  shows.fill(1);
  for (size_t i = 0; depths && i < ages.size(); ++i) shows[i] = depths[i] > 0.0f;
  uint8_t late = 0, older = 0, most = 0;  // bytes are enough for a row, and vectorized
  for (size_t i = 0; i < ages.size(); ++i) {
    const auto known = static_cast<uint8_t>(shows[i] & (ages[i] != OlderMasks::no_answer));
    late = static_cast<uint8_t>(late + (shows[i] - known));
    older = static_cast<uint8_t>(older + known);
    most = std::max(most, static_cast<uint8_t>(known * ages[i]));
  }
  counters.mask_pixels_late += late;
  counters.mask_pixels_older += older;
  counters.answer_age = std::max<uint64_t>(counters.answer_age, most);
}

// A tile's pixels, cut off at the picture's edge.
struct TilePixels {
  uint32_t x0, y0, x1, y1;
  TilePixels(const MaskRequest& r, size_t tile) {
    const uint32_t columns = tile_count(r.width);
    x0 = static_cast<uint32_t>(tile % columns) * tile_side;
    y0 = static_cast<uint32_t>(tile / columns) * tile_side;
    x1 = std::min(x0 + tile_side, r.width);
    y1 = std::min(y0 + tile_side, r.height);
  }
};

bool is_kept(const MaskRequest& r, uint32_t layer) {
  return r.kept && r.kept->keeps(layer);
}

// Calls work(plane of a part's masks, texels of the masks, layer as KeptMasks counts) for each mask of a part.
template <typename Masks, typename Work>
void for_planes(const MaskRequest& r, OlderMasks::Part part, Masks& masks, const Work& work) {
  const size_t pixels = size_t{r.width} * r.height;
  const uint32_t lights = light_masks_of(r);
  if (part == OlderMasks::of_lights) {
    for (uint32_t layer = 0; layer < lights; ++layer) work(layer, masks.lit.data() + layer * pixels, layer);
    for (uint32_t layer = 0; layer < lights && masks.tints > 0; ++layer)
      for (uint32_t c = 0; c < 3 && masks.tint_places[layer] != 0; ++c) {
        const uint32_t plane = (masks.tint_places[layer] - 1) * 3 + c;
        work(lights + plane, masks.tint.data() + plane * pixels, layer);
      }
    return;
  }
  work(0u, masks.open.data(), masks.layers);
  if (r.unhidden_sky) work(1u, masks.lit.data() + lights * pixels, masks.layers);
}

// What filters have made of a mask lies between.
int seen_of(uint8_t mask) {
  return (mask < 255 ? OcclusionMasks::seen_dark : 0) | (mask > 0 ? OcclusionMasks::seen_lit : 0);
}

size_t planes_of(const MaskRequest& r, OlderMasks::Part part, const OcclusionMasks& masks) {
  if (part == OlderMasks::of_lights) return light_masks_of(r) + size_t{3} * masks.tints;
  return r.ao_rays == 0 ? 0 : r.unhidden_sky ? 2 : 1;
}

}  // namespace

bool OlderMasks::follows(const MaskRequest& r, const model::Snapshot& snapshot) const {
  return camera_ && r.sequence != SequenceStep::first && request_.width == r.width && request_.height == r.height && ask_alike(request_, r) &&
         lights_ == lights_as_masked(r, snapshot.lights) && environment_ == snapshot.environment;
}

void OlderMasks::fit(const MaskRequest& r) {
  const size_t pixels = size_t{r.width} * r.height, tiles = size_t{tile_count(r.width)} * tile_count(r.height);
  for (int part = 0; part < part_count; ++part) {
    Kept& p = parts_[part];
    const bool any = part == of_lights ? light_masks_of(r) > 0 : r.ao_rays > 0;
    for (std::vector<uint8_t>& ages : p.ages) ages.resize(any ? pixels : 0);
    p.turns.assign(tiles, 0);
  }
}

// What moves is read while it is written elsewhere.
void OlderMasks::keep_masks(const MaskRequest& r, const OcclusionMasks& masks, Executor& executor) {
  const size_t pixels = size_t{r.width} * r.height;
  for (int i = 0; i < part_count; ++i) {
    const auto part = static_cast<Part>(i);
    if (!moves_[i]) continue;
    std::vector<uint8_t>& then = parts_[i].then;
    then.resize(pixels * planes_of(r, part, masks));
    for_planes(r, part, masks, [&](uint32_t plane, const uint8_t* texels, uint32_t) {
      executor.run(r.height, [&](size_t y, uint32_t) {
        std::copy_n(texels + y * r.width, r.width, &then[plane * pixels + y * r.width]);
      });
    });
  }
}

void OlderMasks::begin(const MaskRequest& r, TracedScene& scene, const OcclusionMasks& masks) {
  const model::Snapshot& snapshot = *scene.shading().snapshot;
  const bool goes_on = follows(r, snapshot);
  if (!goes_on) {
    forget();
    fit(r);
    number_ = 0;
  }
  ++number_;
  moves_ = std::exchange(known_, {});
  for (Kept& part : parts_) part.ended = false;
  camera_before_ = camera_;
  if (camera_before_) {  // in the local space of this frame
    const glm::dvec3 moved = origin_ - snapshot.origin;
    camera_before_->eye += moved;
    camera_before_->clip_from_local[3] -= camera_before_->clip_from_local * glm::dvec4(moved, 0.0);
  }
  camera_ = filter_camera(r.view, r.width, r.height);
  origin_ = snapshot.origin;
  changed_ = snapshot.revision != revision_ || scene.intersector().opaque_revision() != opaque_revision_;
  revision_ = snapshot.revision;
  opaque_revision_ = scene.intersector().opaque_revision();
  lights_ = lights_as_masked(r, snapshot.lights);
  environment_ = snapshot.environment;
  request_ = r;
  if (!camera_) return;
  std::swap(depth_, depth_before_);
  fill_view_depths(scene.executor(), r, *camera_, depth_);
  if (!goes_on) return;
  same_view_ = see_alike(*camera_, *camera_before_, r.width, r.height);
  // What is kept is not traced; it stays what it is as long as nothing moves.
  if (same_view_) known_ = moves_;
  if (same_view_) return;
  now_ = 1 - now_;
  keep_masks(r, masks, scene.executor());
  find_way(r);
}

void OlderMasks::find_way(const MaskRequest& r) {
  const glm::dmat4& m = camera_before_->clip_from_local;
  // Clip coordinates become pixels, over w.
  const glm::dvec2 half(0.5 * r.width, 0.5 * r.height);
  const auto to_pixels = [&](glm::dvec4 clip) {
    return glm::vec4((clip.x + clip.w) * half.x - 0.5 * clip.w, (clip.y + clip.w) * half.y - 0.5 * clip.w, clip.z, clip.w);
  };
  eye_ = to_pixels(m * glm::dvec4(camera_->eye, 1.0));
  ray_ = to_pixels(m * glm::dvec4(camera_->ray, 0.0));
  ray_x_ = to_pixels(m * glm::dvec4(camera_->ray_x, 0.0));
  ray_y_ = to_pixels(m * glm::dvec4(camera_->ray_y, 0.0));
  per_w_ = static_cast<float>(1.0 / glm::length(glm::dvec3(m[0].w, m[1].w, m[2].w)));
  const double n = number_;
  rounding_ = {n * 0.7548776662 - std::floor(n * 0.7548776662), n * 0.5698402910 - std::floor(n * 0.5698402910)};
}

bool OlderMasks::was_there(glm::ivec2 at, float depth) const {
  if (at.x < 0 || at.y < 0 || at.x >= static_cast<int>(request_.width) || at.y >= static_cast<int>(request_.height))
    return false;
  const float then = depth_before_[static_cast<size_t>(at.y) * request_.width + static_cast<size_t>(at.x)];
  return std::abs(then - depth) <= same_depth * depth;
}

// Returns, of a view that has moved, the pixel that showed a pixel's surface in the frame before. A plane's inverse depth is linear in the picture, so
// that the mean of the four around is exact where one surface is seen in all.
std::optional<size_t> OlderMasks::before(const MaskRequest& r, uint32_t x, uint32_t y) const {
  const size_t pixel = size_t{y} * r.width + x;
  const float depth = depth_[pixel];
  if (!(depth > 0.0f)) return std::nullopt;
  const glm::vec4 was = eye_ + depth * (ray_ + ray_x_ * static_cast<float>(x) + ray_y_ * static_cast<float>(y));
  if (!(was.w > 0.0f)) return std::nullopt;
  const glm::vec2 at = glm::vec2(was) / was.w;
  if (!(at.x >= 0.0f && at.y >= 0.0f && at.x <= static_cast<float>(r.width - 1) && at.y <= static_cast<float>(r.height - 1)))
    return std::nullopt;
  const float expected = was.w * per_w_;
  const glm::ivec2 corner(at), last(static_cast<int>(r.width) - 1, static_cast<int>(r.height) - 1);
  const glm::vec2 part = at - glm::vec2(corner);
  const glm::ivec2 chosen = glm::min(glm::ivec2(glm::floor(at + rounding_)), last);
  const auto index = [&](glm::ivec2 p) { return static_cast<size_t>(p.y) * r.width + static_cast<size_t>(p.x); };
  if (was_there(chosen, expected)) return index(chosen);
  const glm::ivec2 beyond = glm::min(corner + 1, last);
  const auto inverse = [&](int px, int py) { return 1.0f / depth_before_[index({px, py})]; };
  const float below = glm::mix(inverse(corner.x, corner.y), inverse(beyond.x, corner.y), part.x);
  const float above = glm::mix(inverse(corner.x, beyond.y), inverse(beyond.x, beyond.y), part.x);
  if (std::abs(glm::mix(below, above, part.y) * expected - 1.0f) <= same_depth) return index(chosen);
  for (int i = 0; i < 4; ++i) {
    const glm::ivec2 p(i & 1 ? beyond.x : corner.x, i & 2 ? beyond.y : corner.y);
    if (was_there(p, expected)) return index(p);
  }
  return std::nullopt;
}

void OlderMasks::traced(const MaskRequest& r, Part part, size_t tile) {
  if (!camera_) return;
  Kept& p = parts_[part];
  p.turns[tile] = number_;
  const TilePixels t(r, tile);
  for (uint32_t y = t.y0; y < t.y1; ++y)
    std::fill_n(&p.ages[now_][size_t{y} * r.width + t.x0], t.x1 - t.x0, uint8_t{0});
}

void OlderMasks::end(Part part) {
  known_[part] = camera_.has_value();
  parts_[part].ended = true;
}

std::vector<uint8_t> OlderMasks::new_tiles(const OcclusionMasks& masks, Part part) const {
  constexpr uint32_t across = tile_side / filter_side;
  std::vector<uint8_t> found;
  found.reserve(size_t{masks.filter_columns()} * masks.filter_rows());
  for (uint32_t y = 0; y < masks.filter_rows(); ++y)
    for (uint32_t x = 0; x < masks.filter_columns(); ++x)
      found.push_back(parts_[part].turns[size_t{y / across} * tile_count(masks.width) + x / across] == number_);
  return found;
}

bool OlderMasks::most_are_new() const {
  return std::ranges::all_of(parts_, [&](const Kept& part) {
    const auto count = static_cast<size_t>(std::ranges::count(part.turns, number_));
    return !part.ended || 2 * count >= part.turns.size();
  });
}

// Finds of a row of a tile where its pixels were, unless the view stands still, and how old their masks are.
void OlderMasks::look_back(const MaskRequest& r, Part part, const glm::uvec3& row, Row& found) const {
  const Kept& p = parts_[part];
  const size_t first = size_t{row.y} * r.width + row.x;
  const uint8_t step = changed_ ? 1 : 0;
  if (!same_view_) {
    const std::vector<uint8_t>& ages = p.ages[1 - now_];
    for (uint32_t i = 0; i < row.z; ++i) {
      const std::optional<size_t> from = before(r, row.x + i, row.y);
      const bool known = from && ages[*from] < oldest;
      found.from[i] = from.value_or(0);
      found.ages[i] = known ? static_cast<uint8_t>(ages[*from] + step) : no_answer;
    }
    return;
  }
  const float *now = &depth_[first], *then = &depth_before_[first];
  const uint8_t* ages = &p.ages[now_][first];
  std::array<uint8_t, tile_side> same;  // loops of their own, one for floats and one for bytes, are vectorized
  for (uint32_t i = 0; i < row.z; ++i) same[i] = (std::abs(then[i] - now[i]) <= same_depth * now[i]) & (now[i] > 0.0f);
  for (uint32_t i = 0; i < row.z; ++i) {
    const int known = same[i] & (ages[i] < oldest);
    found.ages[i] = static_cast<uint8_t>((ages[i] + step) | (known - 1));  // no_answer has all bits
  }
}

// Writes the older masks of a row of a tile, where they are not in their place already; returns whether any changed.
bool OlderMasks::show(const MaskRequest& r, Part part, const glm::uvec3& row, const Row& found,
                      OcclusionMasks& masks) const {
  const size_t first = size_t{row.y} * r.width + row.x, pixels = size_t{r.width} * r.height;
  const auto end = found.ages.begin() + row.z;
  if (same_view_ && std::find(found.ages.begin(), end, no_answer) == end) return false;
  for_planes(r, part, masks, [&](uint32_t plane, uint8_t* texels, uint32_t layer) {
    if (is_kept(r, layer)) return;
    uint8_t* to = texels + first;
    const uint8_t* from = same_view_ ? nullptr : &parts_[part].then[plane * pixels];  // tints get no place meanwhile
    for (uint32_t i = 0; i < row.z; ++i) {
      if (found.ages[i] == no_answer)
        to[i] = 255;
      else if (from)
        to[i] = from[found.from[i]];
    }
  });
  return true;
}

bool OlderMasks::leave(const MaskRequest& r, Part part, size_t tile, OcclusionMasks& masks, Counters& counters) {
  const TilePixels t(r, tile);
  const bool knows = camera_ && moves_[part], counts = part == of_lights || light_masks_of(r) == 0;
  const uint32_t count = t.x1 - t.x0;
  bool changes = false;
  Row row;
  row.ages.fill(no_answer);
  for (uint32_t y = t.y0; y < t.y1; ++y) {
    const size_t first = size_t{y} * r.width + t.x0;
    if (knows) {
      look_back(r, part, {t.x0, y, count}, row);
      changes |= show(r, part, {t.x0, y, count}, row, masks);
    }
    if (camera_) std::copy_n(row.ages.begin(), count, &parts_[part].ages[now_][first]);
    if (counts) count_row({row.ages.data(), count}, camera_ ? &depth_[first] : nullptr, counters);
  }
  if (changes && part == of_lights) mark_seen(r, tile, masks);
  return knows;
}

// Says what the filters' tiles see now.
void OlderMasks::mark_seen(const MaskRequest& r, size_t tile, OcclusionMasks& masks) {
  const TilePixels t(r, tile);
  for (uint32_t layer = 0; layer < light_masks_of(r); ++layer) {
    if (is_kept(r, layer)) continue;
    for (uint32_t v = t.y0 / filter_side; v * filter_side < t.y1; ++v)
      for (uint32_t u = t.x0 / filter_side; u * filter_side < t.x1; ++u) {
        int seen = 0;
        for (uint32_t y = v * filter_side; y < std::min((v + 1) * filter_side, r.height); ++y)
          for (uint32_t x = u * filter_side; x < std::min((u + 1) * filter_side, r.width); ++x)
            seen |= seen_of(masks.lit[(size_t{layer} * r.height + y) * r.width + x]);
        masks.seen[masks.filter_index(layer, u, v)] = static_cast<uint8_t>(seen);
      }
    if (!r.hit_distances) continue;
    for (uint32_t y = t.y0; y < t.y1; ++y)
      std::fill_n(&masks.hit_distance[(size_t{layer} * r.height + y) * r.width + t.x0], t.x1 - t.x0, INFINITY);
  }
}

}  // namespace sideray::rt
