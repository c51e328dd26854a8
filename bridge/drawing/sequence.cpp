#include "bridge/drawing/sequence.h"

#include <algorithm>
#include <utility>

#include "bridge/options/same_options.h"
#include "bridge/drawing/views.h"
#include "rt/base/sampling.h"

namespace sideray::bridge {
namespace {

bool same_camera(const sideray_camera& a, const sideray_camera& b) {
  return std::equal(std::begin(a.world_from_camera), std::end(a.world_from_camera), std::begin(b.world_from_camera)) &&
         a.orthographic == b.orthographic && a.yfov == b.yfov && a.half_height == b.half_height &&
         a.z_near == b.z_near && a.z_far == b.z_far;
}

// A picture under a deadline may lack answers, which a mean would keep.
bool may_add(const FramePlan& plan, const RenderOptions& o) {
  return plan.averages && o.picture.deadline_ms <= 0.0f;
}

}  // namespace

bool Sequence::repeats_last(const FramePlan& plan, const PictureInputs& inputs) const {
  return may_add(plan, inputs.options) && inputs.snapshot == inputs_.snapshot &&
         same_camera(inputs.camera, inputs_.camera) && draw_alike(inputs.options, inputs_.options);
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
  if (follows && averaged_ > 0 && repeats_last(plan, inputs)) {
    still_.repeat();
    is_kept_ = still_.is_done();
  } else {
    // The average over time goes on from what the still view had become.
    if (averaged_ > 0 && still_.added() > 0) backend_.replace_average(still_.shown());
    still_.restart(plan.seed);
    last_ = {};
  }
  inputs_ = std::move(inputs);
}

std::unique_ptr<Picture> Sequence::done() const {
  if (!still_.is_done()) return nullptr;
  return std::make_unique<Picture>(last_);
}

void Sequence::keep(const FramePlan& plan, gl::FrameBefore frame, const Picture& picture) {
  is_kept_ = true;
  before_ = std::move(frame);
  if (still_.added() == StillPicture::positions) last_ = picture;
  if (!plan.averages || adds()) return;
  backend_.keep_average();
  ++averaged_;
}

// The first picture of a sequence is the one that it is alone.
glm::vec2 Sequence::jitter(const FramePlan& plan, uint32_t sample) const {
  if (adds()) return sample_jitter(still_.position(), StillPicture::positions);
  if (!plan.averages) return sample_jitter(sample, plan.samples);
  constexpr uint32_t period = SIDERAY_JITTER_PERIOD;
  return averaged_ == 0 ? glm::vec2(0) : sample_jitter(averaged_ % period, period);
}

// Each position has random numbers of its own.
uint32_t Sequence::seed(const FramePlan& plan, uint32_t sample) const {
  const uint32_t position = adds() ? still_.position() : sample;
  const uint32_t seed = adds() ? still_.seed() : plan.seed;
  return position == 0 ? seed : rt::random_key({seed, position});
}

void Sequence::show(const FramePlan& plan, std::vector<glm::vec4>& colors) {
  if (adds())
    colors = still_.add(colors);
  else if (plan.averages)
    still_.begin_with(colors, averaged_ + 1);
}

}  // namespace sideray::bridge
