#include "bridge/renderer/sequence.h"

#include <utility>

#include "bridge/renderer/views.h"

namespace sideray::bridge {

void Sequence::begin(const FramePlan& plan, const RenderOptions& options) {
  if (!options.picture.continues || size_before_ != glm::uvec2(plan.width, plan.height)) before_ = {};
  size_before_ = {};
  if (before_.snapshot && plan.averages) return;
  rasterizer_.forget_averages();
  averaged_ = 0;
}

void Sequence::keep(const FramePlan& plan, gl::FrameBefore frame) {
  before_ = std::move(frame);
  size_before_ = {plan.width, plan.height};
  if (!plan.averages) return;
  rasterizer_.keep_average();
  ++averaged_;
}

// The first picture of a sequence is the one that it is alone.
glm::vec2 Sequence::jitter(const FramePlan& plan, uint32_t sample) const {
  if (!plan.averages) return sample_jitter(sample, plan.samples);
  constexpr uint32_t period = SIDERAY_JITTER_PERIOD;
  return averaged_ == 0 ? glm::vec2(0) : sample_jitter(averaged_ % period, period);
}

}  // namespace sideray::bridge
