#include "rt/masks/older_masks.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <span>
#include <utility>

#include "rt/base/pixels.h"
#include "rt/base/vectors.h"
#include "rt/masks/kept_masks.h"
#include "rt/masks/mask_rays.h"

namespace sideray::rt {
namespace {

constexpr uint32_t tile_side = frame_tile_size;
constexpr uint32_t filter_side = OcclusionMasks::filter_tile;

// Clears the fields of lights that masks of single lights do not depend on.
std::vector<model::Light> lights_as_masked(const MaskRequest& request, std::vector<model::Light> lights) {
  if (request.combined_lights) return lights;
  for (model::Light& light : lights) {
    light = reaching(light, request.least_light);
    light.intensity = glm::vec3(0.0f);
  }
  return lights;
}

// Counts the pixels with a surface in a row of a tile.
void count_row(std::span<const uint8_t> ages, const float* depths, Counters& counters) {
  std::array<uint8_t, tile_side> shows;
  for (size_t i = 0; i < ages.size(); ++i) shows[i] = depths[i] > 0.0f;
  uint8_t late = 0, older = 0, most = 0;  // bytes suffice for a row, and vectorize
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

// Corrects a row's counters by the sky's masks, after those of lights were counted. A pixel that lacks one mask is
// late; otherwise it is older if one mask is. Counters wrap, so a difference may be negative.
void add_row(std::span<const uint8_t> sky, std::span<const uint8_t> lights, bool lights_are_new, const float* depths,
             Counters& counters) {
  std::array<uint8_t, tile_side> shows;
  for (size_t i = 0; i < sky.size(); ++i) shows[i] = depths[i] > 0.0f;
  uint8_t late = 0, older = 0, most = 0;  // as in count_row()
  for (size_t i = 0; i < sky.size(); ++i) {
    const auto lit = static_cast<uint8_t>(shows[i] & (lights[i] != OlderMasks::no_answer));
    const auto known = static_cast<uint8_t>(lit & (sky[i] != OlderMasks::no_answer));
    late = static_cast<uint8_t>(late + (lit - known));
    older = static_cast<uint8_t>(older + known);
    most = std::max(most, static_cast<uint8_t>(known * sky[i]));
  }
  counters.mask_pixels_late += late;
  if (lights_are_new) counters.mask_pixels_older += older;
  else counters.mask_pixels_older -= late;
  counters.answer_age = std::max<uint64_t>(counters.answer_age, most);
}

// Returns the age of what was `age` old in the previous frame, or no_answer if it expires.
uint8_t grown_age(uint8_t age, uint8_t step) {
  return age < OlderMasks::oldest ? static_cast<uint8_t>(age + step) : OlderMasks::no_answer;
}

// Removes an answer from the pixels that have no mask. Returns the bits that all pixels have.
SIDERAY_VECTORS uint8_t remove_answer(uint8_t answer, const uint8_t* ages, size_t count, uint8_t* answers) {
  const auto others = static_cast<uint8_t>(~answer);
  uint8_t common = 255;
  for (size_t i = 0; i < count; ++i) {
    const auto left = static_cast<uint8_t>(answers[i] & (ages[i] == OlderMasks::no_answer ? others : 255));
    answers[i] = left;
    common &= left;
  }
  return common;
}

// Holds the bounds of a tile's pixels, clipped to the picture.
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

size_t tiles_of(const MaskRequest& r) {
  return size_t{tile_count(r.width)} * tile_count(r.height);
}

bool is_kept(const MaskRequest& r, uint32_t layer) {
  return r.kept && r.kept->keeps(layer);
}

// Calls work(plane in the part, its texels, layer as KeptMasks counts) for each mask of a part. Masks of lights come
// first, then three planes for each place of tints.
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
  if (r.ao_rays == 0) return;
  work(0u, masks.open.data(), masks.layers);
  if (r.unhidden_sky) work(1u, masks.lit.data() + lights * pixels, masks.layers);
}

// Calls work(plane, first tile, end) for each row of tiles of each plane of a part, on all threads.
template <typename Work>
void for_plane_rows(const MaskRequest& r, OlderMasks::Part part, const OcclusionMasks& masks, Executor& executor,
                    const Work& work) {
  struct Plane {
    uint32_t index;
    const uint8_t* texels;
    uint32_t layer;
  };
  std::vector<Plane> planes;
  for_planes(r, part, masks, [&](uint32_t index, const uint8_t* texels, uint32_t layer) {
    planes.push_back({index, texels, layer});
  });
  const size_t columns = tile_count(r.width), rows = tile_count(r.height);
  executor.run(planes.size() * rows, [&](size_t piece, uint32_t) {
    work(planes[piece / rows], piece % rows * columns, (piece % rows + 1) * columns);
  });
}

size_t planes_of(const MaskRequest& r, OlderMasks::Part part, const OcclusionMasks& masks) {
  if (part == OlderMasks::of_lights) return light_masks_of(r) + size_t{3} * masks.tints;
  return r.ao_rays == 0 ? 0 : r.unhidden_sky ? 2 : 1;
}

// Holds the smallest and largest of some texels.
struct Extent {
  uint8_t least = 255, largest = 0;
  void add(const uint8_t* texels, size_t count) {
    for (size_t i = 0; i < count; ++i) {
      least = std::min(least, texels[i]);
      largest = std::max(largest, texels[i]);
    }
  }
  // Filtered masks may hold values between dark and lit, so both bits may be set.
  uint8_t seen() const {
    return static_cast<uint8_t>((least < 255 ? OcclusionMasks::seen_dark : 0) |
                                (largest > 0 ? OcclusionMasks::seen_lit : 0));
  }
};

// Calls work(first texel, count) for each row of a tile in a plane.
template <typename Work>
void for_rows(const MaskRequest& r, size_t tile, const Work& work) {
  const TilePixels t(r, tile);
  for (uint32_t y = t.y0; y < t.y1; ++y) work(size_t{y} * r.width + t.x0, t.x1 - t.x0);
}

// Holds the runs of a tile's pixels (for_runs()) that have history. It is found for the first plane that needs it.
class TileRuns {
 public:
  struct Run {
    uint32_t to, count, from;  // pixels of this picture and of the previous one; from nowhere: no history
  };
  template <typename FromOfRow>
  std::span<const Run> of(const MaskRequest& r, size_t tile, const FromOfRow& from_of_row) {
    if (count_ == 0)
      for_rows(r, tile, [&](size_t first, uint32_t across) {
        std::array<uint32_t, tile_side> from;
        from_of_row(first, across, from.data());
        for_runs(from.data(), across, [&](uint32_t begin, uint32_t count, uint32_t there) {
          runs_[count_++] = {static_cast<uint32_t>(first) + begin, count, there};
        });
      });
    return {runs_.data(), count_};
  }

 private:
  std::array<Run, tile_side * tile_side> runs_;
  uint32_t count_ = 0;
};

void copy_runs(std::span<const TileRuns::Run> runs, const uint8_t* then, uint8_t* texels) {
  for (const TileRuns::Run& run : runs)
    if (run.from == PixelTrail::nowhere) std::fill_n(texels + run.to, run.count, uint8_t{255});
    else std::copy_n(then + run.from, run.count, texels + run.to);
}

// Sets the Seen bits of a layer's filter tiles in a tile of the masks.
void mark_seen(const MaskRequest& r, size_t tile, uint32_t layer, OcclusionMasks& masks) {
  const TilePixels t(r, tile);
  const uint8_t* texels = &masks.lit[size_t{layer} * r.width * r.height];
  for (uint32_t v = t.y0; v < t.y1; v += filter_side)
    for (uint32_t u = t.x0; u < t.x1; u += filter_side) {
      Extent extent;
      for (uint32_t y = v; y < std::min(v + filter_side, t.y1); ++y)
        extent.add(texels + size_t{y} * r.width + u, std::min(filter_side, t.x1 - u));
      masks.seen[masks.filter_index(layer, u / filter_side, v / filter_side)] = extent.seen();
    }
}

}  // namespace

bool OlderMasks::follows(const MaskRequest& r, const model::Snapshot& snapshot) const {
  return number_ > 0 && r.sequence != SequenceStep::first && request_.width == r.width && request_.height == r.height &&
         ask_alike(request_, r) && lights_ == lights_as_masked(r, snapshot.lights) && environment_ == snapshot.environment;
}

void OlderMasks::fit(const MaskRequest& r) {
  for (int part = 0; part < part_count; ++part) {
    Kept& p = parts_[part];
    const bool any = part == of_lights ? light_masks_of(r) > 0 : r.ao_rays > 0;
    for (std::vector<uint8_t>& ages : p.ages) ages.resize(any ? size_t{r.width} * r.height : 0);
    for (std::vector<uint8_t>& ages : p.tile_ages) ages.assign(tiles_of(r), various_ages);
    for (std::vector<Shade>& shades : p.shades) shades.clear();
    p.turns.assign(tiles_of(r), 0);
    p.unfiltered.assign(tiles_of(r), 0);
  }
  lacks_sky_.assign(r.ao_rays > 0 ? tiles_of(r) : 0, 1);
}

// Copies the mixed tiles, because reprojection reads them while the masks are overwritten. Copies the tiles beside them
// too, so that tiles that come from both kinds are read without a decision a pixel.
void OlderMasks::keep_mixed(const MaskRequest& r, Part part, const OcclusionMasks& masks, Executor& executor) {
  Kept& p = parts_[part];
  const size_t pixels = size_t{r.width} * r.height, tiles = tiles_of(r);
  p.shades[now_] = p.shades[1 - now_];
  p.then.resize(pixels * planes_of(r, part, masks));
  p.copied.resize(p.shades[now_].size());
  for_plane_rows(r, part, masks, executor, [&](const auto& plane, size_t first_tile, size_t end) {
    const Shade* shades = &p.shades[now_][plane.index * tiles];
    for (size_t tile = first_tile; tile < end; ++tile) {
      const bool copies = has_mixed_around(shades, glm::uvec2(tile - first_tile, first_tile / (end - first_tile)), r);
      p.copied[plane.index * tiles + tile] = copies;
      if (!copies) continue;
      for_rows(r, tile, [&](size_t first, uint32_t count) {
        std::copy_n(plane.texels + first, count, &p.then[plane.index * pixels + first]);
      });
    }
  });
}

bool OlderMasks::has_mixed_around(const Shade* shades, glm::uvec2 tile, const MaskRequest& r) {
  const uint32_t columns = tile_count(r.width), rows = tile_count(r.height);
  for (uint32_t y = tile.y - (tile.y > 0); y < std::min(tile.y + 2, rows); ++y)
    for (uint32_t x = tile.x - (tile.x > 0); x < std::min(tile.x + 2, columns); ++x)
      if (shades[size_t{y} * columns + x] == mixed) return true;
  return false;
}

bool OlderMasks::is_white(const MaskRequest& r, const OcclusionMasks& masks, uint32_t layer, size_t tile) const {
  const Kept& p = parts_[of_lights];
  if (p.turns[tile] == number_ || is_kept(r, layer)) return false;
  const size_t tiles = tiles_of(r), first = light_masks_of(r) + size_t{3} * (masks.tint_places[layer] - 1);
  if ((first + 3) * tiles > p.shades[now_].size()) return false;
  for (size_t plane = first; plane < first + 3; ++plane)
    if (p.shades[now_][plane * tiles + tile] != all_lit) return false;
  return true;
}

void OlderMasks::begin(const MaskRequest& r, TracedScene& scene, const OcclusionMasks& masks) {
  const model::Snapshot& snapshot = *scene.shading().snapshot;
  complete_ = false;
  trail_ = r.frame.trail ? r.frame.trail : &own_trail_;
  trail_->begin({r.view, r.depth, {r.width, r.height}, snapshot.origin, r.sequence != SequenceStep::first, r.frame.number},
                scene.executor());
  const bool goes_on = trail_->follows(std::exchange(step_, trail_->step())) && follows(r, snapshot);
  if (!goes_on) {
    forget();
    fit(r);
    number_ = 0;
  }
  ++number_;
  if (r.ao_rays > 0) coarse_sky_.begin(r.width, r.height);
  moves_ = std::exchange(known_, {});
  changed_ = snapshot.revision != revision_ || scene.intersector().opaque_revision() != opaque_revision_;
  revision_ = snapshot.revision;
  opaque_revision_ = scene.intersector().opaque_revision();
  lights_ = lights_as_masked(r, snapshot.lights);
  environment_ = snapshot.environment;
  request_ = r;
  // A plane that the last frame added for tints is lit elsewhere.
  for (const Part part : {of_lights, of_sky})
    parts_[part].shades[now_].resize(planes_of(r, part, masks) * tiles_of(r), all_lit);
  if (!goes_on) return;
  // In a view at rest the masks stay in place, even those that the frame does not trace.
  if (trail_->same_view()) known_ = moves_;
  if (trail_->same_view()) return;
  now_ = 1 - now_;
  for (const Part part : {of_lights, of_sky}) keep_mixed(r, part, masks, scene.executor());
}

void OlderMasks::traced(const MaskRequest& r, Part part, size_t tile) {
  Kept& p = parts_[part];
  p.turns[tile] = number_;
  p.unfiltered[tile] = r.position_frames > 0;
  p.tile_ages[now_][tile] = 0;
  if (part == of_sky) lacks_sky_[tile] = 0;
  for_rows(r, tile, [&](size_t first, uint32_t count) { std::fill_n(&p.ages[now_][first], count, uint8_t{0}); });
}

void OlderMasks::end(Part part) {
  known_[part] = true;
  parts_[part].ended = true;
}

void OlderMasks::complete() {
  complete_ = true;
  filtered();
}

void OlderMasks::filtered() {
  for (Kept& part : parts_) std::ranges::fill(part.unfiltered, uint8_t{0});
}

void OlderMasks::end_frame(const MaskRequest& r, const OcclusionMasks& masks, Executor& executor) {
  const size_t tiles = tiles_of(r);
  for (const Part part : {of_lights, of_sky}) {
    Kept& p = parts_[part];
    p.shades[now_].resize(planes_of(r, part, masks) * tiles, all_lit);
    if (!r.kept && std::ranges::find(p.turns, number_) == p.turns.end()) continue;
    for_plane_rows(r, part, masks, executor, [&](const auto& plane, size_t first_tile, size_t end) {
      const bool kept = is_kept(r, plane.layer);
      for (size_t tile = first_tile; tile < end; ++tile) {
        Shade& shade = p.shades[now_][plane.index * tiles + tile];
        if (kept) shade = mixed;  // which may be from a much earlier frame
        if (p.turns[tile] != number_ || kept) continue;
        Extent extent;
        for_rows(r, tile, [&](size_t first, uint32_t count) { extent.add(plane.texels + first, count); });
        shade = extent.least == 255 ? all_lit : extent.largest == 0 ? all_dark : mixed;
      }
    });
  }
}

void OlderMasks::tell_answers(const MaskRequest& r, Executor& executor, OcclusionMasks& masks) const {
  const std::vector<uint8_t>&lights = parts_[of_lights].ages[now_], &sky = parts_[of_sky].ages[now_];
  constexpr uint8_t all = OcclusionMasks::answer_of_lights | OcclusionMasks::answer_of_sky;
  masks.answers.resize(size_t{r.width} * r.height);
  std::atomic<bool> whole{true};
  executor.run(tile_count(r.height), [&](size_t row, uint32_t) {
    const size_t first = row * tile_side * r.width;
    const size_t count = std::min(size_t{tile_side} * r.width, masks.answers.size() - first);
    uint8_t* answers = &masks.answers[first];
    std::fill_n(answers, count, all);
    uint8_t common = all;
    if (!lights.empty()) common &= remove_answer(OcclusionMasks::answer_of_lights, &lights[first], count, answers);
    if (!sky.empty()) common &= remove_answer(OcclusionMasks::answer_of_sky, &sky[first], count, answers);
    if (common != all) whole = false;
  });
  if (whole) masks.answers.clear();
}

std::vector<uint8_t> OlderMasks::answers(Part part) const {
  const Kept& p = parts_[part];
  std::vector<uint8_t> answers = p.ages[now_];
  for (size_t tile = 0; tile < p.turns.size() && !answers.empty(); ++tile) {
    if (p.turns[tile] == number_) continue;
    for_rows(request_, tile, [&](size_t first, uint32_t count) {
      for (size_t i = first; i < first + count; ++i)
        if (answers[i] != no_answer) ++answers[i];
    });
  }
  return answers;
}

std::vector<uint8_t> OlderMasks::new_tiles(const OcclusionMasks& masks, Part part) const {
  constexpr uint32_t across = tile_side / filter_side;
  std::vector<uint8_t> found;
  found.reserve(size_t{masks.filter_columns()} * masks.filter_rows());
  for (uint32_t y = 0; y < masks.filter_rows(); ++y)
    for (uint32_t x = 0; x < masks.filter_columns(); ++x) {
      const size_t tile = size_t{y / across} * tile_count(masks.width) + x / across;
      found.push_back(parts_[part].turns[tile] == number_ || parts_[part].unfiltered[tile]);
    }
  return found;
}

bool OlderMasks::most_are_new() const {
  return std::ranges::all_of(parts_, [&](const Kept& part) {
    const auto count = static_cast<size_t>(std::ranges::count(part.turns, number_));
    return !part.ended || 2 * count >= part.turns.size();
  });
}

void OlderMasks::Ages::fill_unknown() {
  for (auto& row : of) row.fill(no_answer);
  common = no_answer;
  all_known = false, none_known = true;
}

// Returns the age that a tile's pixels have where they were in the previous frame, or various_ages.
uint8_t OlderMasks::common_age_there(Part part, size_t tile) const {
  const std::vector<uint8_t>& ages = parts_[part].tile_ages[trail_->same_view() ? now_ : 1 - now_];
  const size_t columns = tile_count(request_.width);
  const auto& [from, to] = trail_->tiles_from(tile);
  if (from.x > to.x) return no_answer;
  const uint8_t first = ages[from.y * columns + from.x];
  for (uint32_t y = from.y; y <= to.y; ++y)
    for (uint32_t x = from.x; x <= to.x; ++x)
      if (ages[y * columns + x] != first) return various_ages;
  return first;
}

// Finds the ages of a tile's masks. Most tiles come from tiles of one age.
void OlderMasks::look_back(Part part, size_t tile, Ages& found) const {
  const uint8_t step = changed_ ? 1 : 0, there = common_age_there(part, tile);
  const uint8_t common = there == various_ages ? there : grown_age(there, step);
  if (common == no_answer) return found.fill_unknown();
  const TilePixels t(request_, tile);
  const std::vector<uint8_t>& ages = parts_[part].ages[trail_->same_view() ? now_ : 1 - now_];
  const uint32_t count = t.x1 - t.x0;
  uint32_t known = 0;
  for (uint32_t y = t.y0; y < t.y1; ++y) {
    const uint32_t* from = trail_->from(t.x0, y);
    std::array<uint8_t, tile_side>& age = found.of[y - t.y0];
    if (common == various_ages)
      for (uint32_t i = 0; i < count; ++i)
        age[i] = from[i] == PixelTrail::nowhere ? no_answer : grown_age(ages[from[i]], step);
    else
      for (uint32_t i = 0; i < count; ++i) age[i] = from[i] == PixelTrail::nowhere ? no_answer : common;
    uint8_t in_row = 0;  // a byte suffices for a row, and vectorizes
    for (uint32_t i = 0; i < count; ++i) in_row = static_cast<uint8_t>(in_row + (age[i] != no_answer));
    known += in_row;
  }
  found.all_known = known == count * (t.y1 - t.y0);
  found.none_known = known == 0;
  found.common = found.none_known ? no_answer : found.all_known ? common : various_ages;
}

// Returns what a plane of the previous frame holds at the reprojected places of a tile's pixels.
OlderMasks::Shade OlderMasks::shade_there(Part part, uint32_t plane, size_t tile, const Ages& found) const {
  if (found.none_known) return all_lit;
  const std::vector<Shade>& shades = parts_[part].shades[1 - now_];
  const size_t columns = tile_count(request_.width), tiles = tiles_of(request_);
  const auto& [from, to] = trail_->tiles_from(tile);
  const Shade first = shades[plane * tiles + from.y * columns + from.x];
  for (uint32_t y = from.y; y <= to.y; ++y)
    for (uint32_t x = from.x; x <= to.x; ++x)
      if (shades[plane * tiles + y * columns + x] != first) return mixed;
  return first == all_dark && !found.all_known ? mixed : first;
}

// Returns whether a plane was copied in each tile from which a tile's pixels are reprojected.
bool OlderMasks::were_copied(Part part, uint32_t plane, size_t tile) const {
  const std::vector<uint8_t>& copied = parts_[part].copied;
  const size_t columns = tile_count(request_.width), tiles = tiles_of(request_);
  const auto& [from, to] = trail_->tiles_from(tile);
  for (uint32_t y = from.y; y <= to.y; ++y)
    for (uint32_t x = from.x; x <= to.x; ++x)
      if (!copied[plane * tiles + y * columns + x]) return false;
  return true;
}

// Writes a tile's history into the masks, unless it is there already.
void OlderMasks::show(const MaskRequest& r, Part part, size_t tile, const Ages& found, OcclusionMasks& masks) {
  const bool same_view = trail_->same_view();
  if (same_view && found.all_known) return;
  const size_t pixels = size_t{r.width} * r.height, tiles = tiles_of(r), columns = tile_count(r.width);
  const TilePixels t(r, tile);
  const uint32_t lights = light_masks_of(r);
  Kept& p = parts_[part];
  TileRuns runs;
  const auto from_of_row = [&](size_t first, uint32_t count, uint32_t* from) {
    const auto y = static_cast<uint32_t>(first / r.width);
    const auto& ages = found.of[y - t.y0];
    const uint32_t* there = trail_->from(t.x0, y);
    for (uint32_t i = 0; i < count; ++i) from[i] = ages[i] == no_answer ? PixelTrail::nowhere : there[i];
  };
  for_planes(r, part, masks, [&](uint32_t plane, uint8_t* texels, uint32_t layer) {
    if (is_kept(r, layer)) return;
    Shade& shade = p.shades[now_][plane * tiles + tile];
    const Shade there = same_view ? (found.none_known ? all_lit : mixed) : shade_there(part, plane, tile, found);
    const Shade before = std::exchange(shade, there);
    if (there != mixed && there == before) return;
    const bool all_copied = !same_view && there == mixed && were_copied(part, plane, tile);
    // Tiles that `then` does not hold are all of one kind.
    const auto texel_there = [&](uint32_t from) {
      const Shade kind = p.shades[1 - now_][plane * tiles + from / r.width / tile_side * columns + from % r.width / tile_side];
      return kind == mixed ? p.then[plane * pixels + from] : static_cast<uint8_t>(kind);
    };
    const auto write_row = [&](size_t first, uint32_t count) {
      if (there != mixed) {
        std::fill_n(texels + first, count, static_cast<uint8_t>(there));
        return;
      }
      const auto y = static_cast<uint32_t>(first / r.width);
      const auto& ages = found.of[y - t.y0];
      const uint32_t* from = trail_->from(t.x0, y);
      for (uint32_t i = 0; i < count; ++i)
        if (ages[i] == no_answer)
          texels[first + i] = 255;
        else if (!same_view)
          texels[first + i] = texel_there(from[i]);
    };
    if (all_copied) copy_runs(runs.of(r, tile, from_of_row), &p.then[plane * pixels], texels);
    else for_rows(r, tile, write_row);
    if (part != of_lights || plane >= lights) return;
    mark_seen(r, tile, plane, masks);
    if (r.hit_distances)
      for_rows(r, tile, [&](size_t first, uint32_t count) {
        std::fill_n(&masks.hit_distance[plane * pixels + first], count, INFINITY);
      });
  });
}

// Fills pixels without a sky mask from the samples, which become their history.
void OlderMasks::take_samples(const MaskRequest& r, size_t tile, Ages& found, OcclusionMasks& masks) {
  lacks_sky_[tile] = 0;
  if (found.all_known) return;
  const TilePixels t(r, tile);
  if (!coarse_sky_.knows(tile)) {
    uint32_t lacking = 0, shown = 0;
    for_rows(r, tile, [&](size_t first, uint32_t count) {
      const uint8_t* ages = found.of[first / r.width - t.y0].data();
      const float* depth = &depths()[first];
      for (uint32_t i = 0; i < count; ++i) {
        shown += depth[i] > 0.0f;
        lacking += (depth[i] > 0.0f) & (ages[i] == no_answer);
      }
    });
    lacks_sky_[tile] = 2 * lacking > shown;
    return;
  }
  const size_t pixels = size_t{r.width} * r.height;
  for (uint32_t y = t.y0; y < t.y1; ++y)
    for (uint32_t x = t.x0; x < t.x1; ++x) {
      const size_t pixel = size_t{y} * r.width + x;
      uint8_t& age = found.of[y - t.y0][x - t.x0];
      if (!(depths()[pixel] > 0.0f) || age != no_answer) continue;
      const SkyShare share = coarse_sky_.at(tile, x, y, depths());
      masks.open[pixel] = share.open;
      if (r.unhidden_sky) masks.lit[light_masks_of(r) * pixels + pixel] = share.unhidden;
      age = 0;
    }
  found.common = various_ages;
  std::vector<Shade>& shades = parts_[of_sky].shades[now_];
  for (size_t i = tile; i < shades.size(); i += tiles_of(r)) shades[i] = mixed;
}

void OlderMasks::leave(const MaskRequest& r, Part part, size_t tile, OcclusionMasks& masks, Counters& counters) {
  const bool knows = moves_[part], counts = part == of_lights || light_masks_of(r) == 0;
  const bool lights_are_new = parts_[of_lights].turns[tile] == number_;
  counters.frames_waiting = std::max<uint64_t>(counters.frames_waiting, number_ - parts_[part].turns[tile]);
  Ages found;
  if (knows) {
    look_back(part, tile, found);
    show(r, part, tile, found, masks);
  } else {
    const std::vector<Shade>& shades = parts_[part].shades[now_];
    for (size_t i = tile; i < shades.size(); i += tiles_of(r)) parts_[part].shades[now_][i] = all_lit;
    found.fill_unknown();
  }
  if (part == of_sky) take_samples(r, tile, found, masks);
  const uint8_t before = std::exchange(parts_[part].tile_ages[now_][tile], found.common);
  const bool stays = before == found.common && before != various_ages;
  const uint32_t y0 = TilePixels(r, tile).y0;
  for_rows(r, tile, [&](size_t first, uint32_t count) {
    const auto& ages = found.of[first / r.width - y0];
    if (!stays) std::copy_n(ages.begin(), count, &parts_[part].ages[now_][first]);
    if (counts)
      count_row({ages.data(), count}, &depths()[first], counters);
    else
      add_row({ages.data(), count}, {&parts_[of_lights].ages[now_][first], count}, lights_are_new, &depths()[first], counters);
  });
}

}  // namespace sideray::rt
