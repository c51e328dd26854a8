#include "rt/masks/kept_masks.h"

#include <atomic>
#include <cmath>
#include <cstring>
#include <span>
#include <utility>

#include "model/material.h"
#include "rt/base/view_rays.h"
#include "rt/masks/mask_filters.h"
#include "rt/masks/mask_rays.h"
#include "rt/scene/scene_difference.h"
#include "rt/light/veils.h"

namespace sideray::rt {
namespace {

constexpr size_t first_combined = 32;  // index in the snapshot
constexpr uint32_t never = UINT32_MAX;

// Returns the stencil bits that mark pixels for the inexact test.
uint32_t inexact_bits_of(const MaskRequest& r) {
  return r.inexact == SIDERAY_EXACT ? 0 : r.inexact_bits & 0xffu;
}

bool reads_rest_offsets(const MaskRequest& r) {
  return (r.inexact == SIDERAY_INEXACT_RESTPOSE || r.inexact == SIDERAY_INEXACT_BOUNDED) && r.inexact_bits != 0 &&
         !r.rest_offsets.empty();
}

// In a jittered view, static surfaces move only by rounding: by less than this many pixels.
constexpr float most_still_motion = 0x1p-10f;

bool stands_still(Executor& executor, const MaskRequest& r) {
  if (!r.filters || r.motion.empty()) return true;
  std::atomic<bool> still{true};
  executor.run(r.height, [&](size_t y, uint32_t) {
    const auto row = r.motion.subspan(y * r.width, r.width);
    if (std::any_of(row.begin(), row.end(), [](glm::vec2 moved) {
          return !(std::abs(moved.x) <= most_still_motion && std::abs(moved.y) <= most_still_motion);
        }))
      still = false;
  });
  return still;
}

// Clears the fields of a light on which its own mask does not depend, so that they do not reset it.
model::Light as_masked(model::Light light, float least) {
  light = reaching(light, least);
  light.intensity = glm::vec3(0.0f);
  light.cos_inner = 0.0f;
  return light;
}

// Returns the mask of a light, or the sky's, which follows them.
template <typename Masks>
auto mask_of(Masks& masks, size_t layer) {
  const size_t pixels = size_t{masks.width} * masks.height;
  return layer < masks.layers ? std::span(masks.lit).subspan(layer * pixels, pixels) : std::span(masks.open);
}

// Copies a mask, followed by the tints of its rays, if it has any.
void keep_mask(const OcclusionMasks& masks, size_t layer, std::vector<uint8_t>& kept) {
  const std::span<const uint8_t> mask = mask_of(masks, layer);
  kept.assign(mask.begin(), mask.end());
  const uint32_t place = masks.tints > 0 && layer < masks.layers ? masks.tint_places[layer] : 0;
  if (place == 0 || !masks.is_tinted(place)) return;
  for (uint32_t c = 0; c < 3; ++c)
    kept.insert(kept.end(), masks.tint_plane(place, c).begin(), masks.tint_plane(place, c).end());
}

void bring_back(const std::vector<uint8_t>& kept, size_t layer, OcclusionMasks& masks) {
  const std::span<uint8_t> mask = mask_of(masks, layer);
  const auto pixels = static_cast<ptrdiff_t>(mask.size());
  std::copy_n(kept.begin(), pixels, mask.begin());
  const uint32_t place = masks.tints > 0 && layer < masks.layers ? masks.tint_places[layer] : 0;
  if (place == 0) return;
  const bool tinted = static_cast<ptrdiff_t>(kept.size()) > pixels;
  for (uint32_t c = 0; c < 3; ++c) {
    const std::span<uint8_t> plane = masks.tint_plane(place, c);
    if (tinted)
      std::copy_n(kept.begin() + pixels * static_cast<ptrdiff_t>(c + 1), pixels, plane.begin());
    else
      std::fill(plane.begin(), plane.end(), uint8_t{255});
  }
}

bool has_size(const model::Light& light) {
  return light.type == SIDERAY_LIGHT_DIRECTIONAL ? light.angular_radius > 0.0f : light.radius > 0.0f;
}

}  // namespace

uint32_t KeptMasks::frames_to_settle(uint32_t history) {
  const double left = 1.0 - 1.0 / std::max(history, 1u);
  uint32_t frames = 0;
  for (double weight = left; weight > 0.0 && frames < never; weight *= left) {
    ++frames;
    if (weight < 1.0 / 512.0) break;
  }
  return frames;
}

KeptMasks::Frame KeptMasks::frame_of(const MaskRequest& r, TracedScene& scene, bool hashed) {
  Frame f;
  f.inputs = {r};
  f.width = r.width;
  f.height = r.height;
  f.filters = r.filters != nullptr;
  f.glass_shadows = scene.shading().glass != nullptr;
  f.reversed = r.view.reversed_depth;
  f.zero_to_one = r.view.zero_to_one_depth;
  f.format = r.depth.format;
  f.subpixel = r.subpixel;
  f.clip_from_local = r.view.clip_from_local;
  f.local_from_clip = r.view.local_from_clip;
  f.origin = scene.shading().snapshot->origin;
  f.opaque_revision = scene.intersector().opaque_revision();
  f.hashed = hashed;
  if (!hashed) return f;
  f.depth = hash_depth(scene.executor(), r.depth, r.width, r.height, inexact_bits_of(r));
  if (reads_rest_offsets(r)) f.rest = hash_rows(scene.executor(), std::as_bytes(r.rest_offsets), r.height);
  return f;
}

std::vector<KeptMasks::Layer> KeptMasks::layers_of(const MaskRequest& r, const ShadingScene& scene) const {
  const model::Snapshot& snapshot = *scene.snapshot;
  const bool inexact = is_random(r.inexact, r.inexact_bits);
  const bool filters = r.filters && ViewRays(r.view, r.width, r.height).perspective();
  const auto settles = [&](uint32_t history) { return frames_to_settle(history); };
  const auto usual = static_cast<uint32_t>(shading::sf_usual_history);
  const uint64_t glass = scene.glass ? scene_ : 0;
  std::vector<Layer> layers;
  for (const uint32_t number : lights_of(r.shadow_lights)) {
    const model::Light& light = snapshot.lights[number];
    const bool filtered = filters && is_filtered(light, inexact);
    const uint32_t frames = filtered ? settles(light.filter_frames) : 0;
    layers.push_back({{as_masked(light, r.least_light)}, glass, nullptr, inexact || has_size(light), filtered, frames});
  }
  if (r.combined_lights) {
    const size_t first = std::min(first_combined, snapshot.lights.size());
    layers.push_back({{snapshot.lights.begin() + static_cast<ptrdiff_t>(first), snapshot.lights.end()},
                      glass,
                      nullptr,
                      true,
                      filters,
                      filters ? settles(usual) : 0});
  }
  if (r.ao_rays == 0) return layers;
  const Layer of_sky{{},
                     veils_sky(snapshot) ? scene_ : 0,
                     r.ao_by_light ? snapshot.environment : nullptr,
                     true,
                     filters,
                     filters ? settles(usual) : 0};
  layers.insert(layers.end(), r.unhidden_sky ? 2 : 1, of_sky);
  return layers;
}

bool KeptMasks::keeps_all() const {
  return std::all_of(layers_.begin(), layers_.end(), [](const Layer& layer) { return layer.kept; });
}

void KeptMasks::restart(const Frame& frame) {
  frames_.assign(1, frame);
  cycle_ = turn_ = 0;
}

// Returns how many frames ago the frame's inputs were the same; 0: never.
uint32_t KeptMasks::find_cycle(const Frame& frame, size_t layers) const {
  if (!complete_ || layers_.size() != layers) return 0;
  const auto found = std::find(frames_.rbegin(), frames_.rend(), frame);
  return found == frames_.rend() ? 0 : static_cast<uint32_t>(found - frames_.rbegin()) + 1;
}

// A frame that starts a sequence reuses masks of one with the same inputs that started one too: the bits are the same.
void KeptMasks::begin_first(const Frame& frame, const MaskRequest& r, std::vector<Layer>& layers) {
  const bool same = is_last(frame);
  for (size_t i = 0; i < layers.size(); ++i) {
    Layer& layer = layers[i];
    layer.kept = same && layer.depends_as(layers_[i]) && (!layer.random || r.seed == seed_) &&
                 (!layer.filtered || step_ == SequenceStep::first);
  }
  restart(frame);
}

bool KeptMasks::may_stay(const Layer& layer, size_t index, const MaskRequest& r) const {
  if (layer.random && !layer.filtered && (cycle_ != 1 || r.seed != seed_)) return false;
  if (layer.still <= frames_made(layer)) return false;
  const Place& known = places_[turn_ % longest_cycle];
  return cycle_ == 1 || (index < known.size() && !known[index].empty());
}

void KeptMasks::begin_next(const Frame& frame, const MaskRequest& r, TracedScene& scene, std::vector<Layer>& layers) {
  uint32_t cycle = find_cycle(frame, layers.size());
  if (cycle != 0 && !stands_still(scene.executor(), r)) cycle = 0;
  turn_ = cycle != 0 && cycle == cycle_ ? (turn_ + 1) % cycle : 0;
  if (cycle != cycle_) places_ = {};
  const bool goes_on = cycle != 0 && cycle == cycle_;
  cycle_ = cycle;
  for (size_t i = 0; i < layers.size() && cycle != 0; ++i) {
    Layer& layer = layers[i];
    const Layer& last = layers_[i];
    if (layer.depends_as(last) && layer.settles == last.settles) layer.still = goes_on ? last.still + 1 : 1;
    layer.kept = layer.kept_at_first = may_stay(layer, i, r);
  }
  if (!complete_) frames_.clear();
  frames_.push_back(frame);
  if (frames_.size() > longest_cycle) frames_.erase(frames_.begin());
}

// A redrawn frame reuses the same masks as when it was first drawn.
void KeptMasks::begin_again(const Frame& frame, const MaskRequest& r, std::vector<Layer>& layers) {
  const bool same = is_last(frame) && r.seed == seed_ &&
                    std::equal(layers.begin(), layers.end(), layers_.begin(), layers_.end(),
                               [](const Layer& a, const Layer& b) { return a.depends_as(b); });
  if (!same) return restart(frame);
  for (size_t i = 0; i < layers.size(); ++i) {
    layers[i].still = layers_[i].still;
    layers[i].kept_at_first = layers_[i].kept_at_first;
    layers[i].kept = r.redraw_keeps || layers_[i].kept_at_first;
  }
}

void KeptMasks::begin(const MaskRequest& r, TracedScene& scene, OcclusionMasks& masks) {
  // Under a budget most frames are incomplete, and none is compared with the frame after an incomplete one.
  const Frame frame = frame_of(r, scene, complete_ || !is_bounded(r.work));
  if (!committed_ || !are_equal(*committed_, *scene.committed())) ++scene_;
  committed_ = scene.committed();
  std::vector<Layer> layers = layers_of(r, scene.shading());
  const bool fits = masks.width == r.width && masks.height == r.height && masks.layers == mask_layers_of(r);
  if (!fits || r.hit_distances || !r.points.empty()) complete_ = false;  // those two are needed in every frame
  const bool again = r.sequence == SequenceStep::again;
  if (again)
    begin_again(frame, r, layers);
  else if (r.sequence == SequenceStep::next)
    begin_next(frame, r, scene, layers);
  else
    begin_first(frame, r, layers);
  complete_ = false;
  layers_ = std::move(layers);
  seed_ = r.seed;
  if (!again) step_ = r.sequence;
  if (again || cycle_ <= 1) return;
  for (size_t i = 0; i < layers_.size(); ++i)
    if (layers_[i].kept) bring_back(place()[i], i, masks);
}

void KeptMasks::end(const OcclusionMasks& masks, bool whole) {
  complete_ = whole;
  if (cycle_ <= 1) return;
  place().resize(layers_.size());
  for (size_t i = 0; i < layers_.size(); ++i) {
    const Layer& layer = layers_[i];
    if (layer.kept) continue;
    const bool is_of_use = layer.still + cycle_ > frames_made(layer) && layer.still > 0;
    if (is_of_use)
      keep_mask(masks, i, place()[i]);
    else
      place()[i].clear();
  }
}

}  // namespace sideray::rt
