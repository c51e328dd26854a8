#include "bridge/drawing/sequence.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "bridge/drawing/views.h"
#include "bridge/options/same_options.h"
#include "bridge/picture/changed_tiles.h"
#include "rt/base/pixels.h"
#include "rt/base/sampling.h"
#include "rt/scene/scene_difference.h"

namespace sideray::bridge {
namespace {

constexpr uint32_t most_averaged_under_budget = 2;  // weight, in positions of a still view, of the temporal average

bool same_camera(const sideray_camera& a, const sideray_camera& b) {
  return std::equal(std::begin(a.world_from_camera), std::end(a.world_from_camera), std::begin(b.world_from_camera)) &&
         a.orthographic == b.orthographic && a.yfov == b.yfov && a.half_height == b.half_height &&
         a.z_near == b.z_near && a.z_far == b.z_far && a.fx_per_fy == b.fx_per_fy && a.shift_x == b.shift_x &&
         a.shift_y == b.shift_y;
}

// Returns whether the next frame traces the layers that a budget left out, so that a position becomes complete.
bool keeps_layers(const FramePlan& plan) {
  return !plan.traces || plan.draws_by_rays() || (!plan.composites() && plan.layers.cache_rate == SIDERAY_RATE_FULL);
}

// Returns whether pictures may be accumulated. Under a deadline pixels may lack answers, and the mean would keep that.
bool may_add(const FramePlan& plan, const RenderOptions& o, bool has_budget) {
  return plan.averages && o.picture.deadline_ms <= 0.0f && (!has_budget || keeps_layers(plan));
}

// Returns whether single tiles can be drawn: no output or pass needs the content of other tiles.
bool has_parts(const FramePlan& plan, const RenderOptions& o, const model::Snapshot& snapshot) {
  constexpr uint32_t traced = SIDERAY_AOV_LAYERS | SIDERAY_AOV_SHADOW | SIDERAY_AOV_HIT_DISTANCE | SIDERAY_AOV_FIRST |
                              SIDERAY_AOV_GLASS | SIDERAY_AOV_BEHIND | SIDERAY_AOV_REFRACTION | SIDERAY_AOV_ANSWERS;
  return !plan.reference && !plan.composites() && !plan.second_wave && !plan.checks && !plan.distorts &&
         !plan.masks.combined_lights && !o.shows(traced) && !o.diagnostics.exact_points && o.picture.repeats == 0 &&
         o.picture.budget_ms <= 0.0f && o.diagnostics.budget_pieces == 0 && !snapshot.shader.shade;
}

// Returns whether frames with the same options treat everything that has not moved in the same way.
bool same_plans(const FramePlan& a, const FramePlan& b) {
  return a.traces == b.traces && a.draws_mask == b.draws_mask && a.shadow_maps == b.shadow_maps &&
         a.rasters_translucency == b.rasters_translucency && a.traced == b.traced && a.mask_kind == b.mask_kind &&
         a.casts_shadows == b.casts_shadows && a.glass_shadows == b.glass_shadows && a.reflects == b.reflects && a.bounces == b.bounces &&
         a.marks_inexact == b.marks_inexact && a.fills_rest == b.fills_rest &&
         same_through(&sideray_layer_inputs::bounces, a.layers, b.layers) &&
         same_through(&sideray_mask_inputs::checks_surfaces, a.masks, b.masks) &&
         same_through(&sideray_reflection_inputs::denoise, a.reflections, b.reflections) &&
         same_through(&sideray_irradiance_inputs::denoise, a.irradiance, b.irradiance);
}

// Returns what moved between two pictures with the same options; nullopt where that may be everything.
std::optional<std::vector<rt::Mover>> movers_between(const PictureInputs& before, const PictureInputs& now, bool same_plans) {
  if (before.snapshot == now.snapshot) return std::vector<rt::Mover>{};
  if (!same_plans) return std::nullopt;
  return rt::find_movers(*before.snapshot, *now.snapshot);
}

// Returns whether so many tiles restart that all do: in a picture restarted as a whole, masks use their history.
bool are_too_many(const std::vector<uint8_t>& changes) {
  const auto same = static_cast<size_t>(std::ranges::count(changes, tile_unchanged));
  return 4 * same < changes.size();
}

}  // namespace

bool Sequence::has_budget(const RenderOptions& o) {
  return o.picture.budget_ms > 0.0f || o.diagnostics.budget_pieces > 0;
}

bool Sequence::draws_alike(const FramePlan& plan, const PictureInputs& inputs) const {
  return may_add(plan, inputs.options, has_budget(inputs.options)) && same_camera(inputs.camera, inputs_.camera) &&
         draw_alike(inputs.options, inputs_.options);
}

// Continues the still view, except in tiles where something moved; returns false where all tiles must restart.
bool Sequence::repeat(const FramePlan& plan, const PictureInputs& inputs, const std::vector<rt::Mover>& movers) {
  if (movers.empty()) {
    still_.repeat();
    is_restless_ = false;
    return true;
  }
  const model::Snapshot &before = *inputs_.snapshot, &now = *inputs.snapshot;
  if (is_restless_ || !backend_.draws_parts() || !has_parts(plan, inputs.options, now)) return false;
  const gl::RasterView view = backend_.make_view(inputs.camera, glm::vec2(0));
  std::vector<uint8_t> changes = tiles_that_see(movers, {before, now, view, plan.width, plan.height, reach_.get(), plan.bounces});
  is_restless_ = are_too_many(changes);
  if (is_restless_) return false;
  // A view just come to rest starts with all tiles. Otherwise the temporal average continues from what is shown.
  if (!still_.has_added())
    std::ranges::fill(changes, tile_changed);
  else
    backend_.replace_average(still_.shown());
  still_.repeat_without(changes);
  return true;
}

std::shared_ptr<const rt::WantedTiles> Sequence::wanted(const FramePlan& plan) {
  return wanted(plan, &StillPicture::wanted);
}

std::shared_ptr<const rt::WantedTiles> Sequence::wanted_light(const FramePlan& plan) {
  return wanted(plan, &StillPicture::wanted_light);
}

std::shared_ptr<const rt::WantedTiles> Sequence::wanted(const FramePlan& plan,
                                                        std::vector<uint8_t> (StillPicture::*tiles)() const) {
  if (!adds() || !backend_.draws_parts() || !has_parts(plan, inputs_.options, *inputs_.snapshot)) return nullptr;
  if (!reach_)
    reach_ = std::make_shared<rt::TileReach>(size_t{rt::tile_count(plan.width)} * rt::tile_count(plan.height));
  return std::make_shared<const rt::WantedTiles>(rt::WantedTiles{(still_.*tiles)(), reach_});
}

void Sequence::begin(const FramePlan& plan, PictureInputs inputs) {
  const auto& now = inputs.options.picture;
  const auto& then = inputs_.options.picture;
  const bool follows =
      std::exchange(is_kept_, false) && now.continues && now.width == then.width && now.height == then.height;
  if (!follows) before_ = {};
  if (!before_.snapshot || !plan.averages) {
    backend_.forget_averages();
    averaged_ = 0;
  }
  std::optional<std::vector<rt::Mover>> movers;
  if (follows && averaged_ > 0 && draws_alike(plan, inputs)) movers = movers_between(inputs_, inputs, same_plans(plan, plan_));
  if (!movers) is_restless_ = false;
  rests_for_ = movers && movers->empty() ? rests_for_ + 1 : 1;
  if (movers && (is_settled_ || still_.has_added()) && repeat(plan, inputs, *movers)) {
    is_kept_ = still_.is_done();
  } else {
    // The temporal average continues from the picture that the still view showed last.
    if (averaged_ > 0 && still_.has_added()) backend_.replace_average(still_.shown());
    // A view at rest keeps the random numbers of its first picture.
    still_.restart(rests_for_ == 1 ? plan.seed : still_.seed(), plan.width, plan.height);
    reach_.reset();
  }
  if (!still_.is_done()) last_ = {};
  inputs_ = std::move(inputs);
  plan_ = plan;
}

std::unique_ptr<Picture> Sequence::done() const {
  if (!still_.is_done()) return nullptr;
  return std::make_unique<Picture>(last_);
}

void Sequence::keep(const FramePlan& plan, gl::FrameBefore frame, const Picture& picture) {
  is_kept_ = true;
  before_ = std::move(frame);
  if (still_.added() == StillPicture::positions) last_ = picture;
  if (!plan.averages || (adds() && !begins_tiles())) return;
  backend_.keep_average();
  ++averaged_;
}

// Returns no jitter for the first picture of a sequence, so that it equals the picture drawn alone.
glm::vec2 Sequence::jitter(const FramePlan& plan, uint32_t sample) const {
  if (adds()) return sample_jitter(still_.position(), StillPicture::positions);
  if (!plan.averages) return sample_jitter(sample, plan.samples);
  constexpr uint32_t period = SIDERAY_JITTER_PERIOD;
  return averaged_ == 0 ? glm::vec2(0) : sample_jitter(averaged_ % period, period);
}

// Returns a random seed of its own for each position.
uint32_t Sequence::seed(const FramePlan& plan, uint32_t sample) const {
  const uint32_t number = position(sample), seed = adds() ? still_.seed() : plan.seed;
  return number == 0 ? seed : rt::random_key({seed, number});
}

void Sequence::show(const FramePlan& plan, const rt::Counters& trace, std::vector<glm::vec4>& colors,
                    const std::vector<glm::vec4>& average) {
  if (adds()) {
    const bool lacks = trace.pixels_late + trace.mask_pixels_late + trace.reflection_pixels_late + trace.irradiance_pixels_late > 0;
    const bool whole = !lacks && (position_frames() == 0 || trace.frames_waiting < position_frames());
    colors = whole ? still_.add(colors, average) : still_.wait();
    return;
  }
  // Even if no frames wait, pixels that reprojection did not reach may lack answers.
  is_settled_ = trace.frames_waiting < rests_for_;
  // Under a budget, half of the average or more may still show the view before the change, so that it counts as fewer
  // positions.
  const uint32_t counts = has_budget(inputs_.options) ? std::min(averaged_ + 1, most_averaged_under_budget) : averaged_ + 1;
  if (plan.averages) still_.begin_with(colors, counts);
}

}  // namespace sideray::bridge
