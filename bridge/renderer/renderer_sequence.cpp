// The parts of Renderer that know of the picture before.
#include "bridge/renderer/renderer.h"

namespace sideray::bridge {
namespace {

constexpr uint32_t jitter_period = 8;

}  // namespace

// The first picture of a sequence is the one that it is alone.
glm::vec2 Renderer::jitter(const FramePlan& plan, const RenderOptions& options, uint32_t sample) const {
  if (!plan.averages) return sample_jitter(sample, options.samples);
  return averaged_ == 0 ? glm::vec2(0) : sample_jitter(averaged_ % jitter_period, jitter_period);
}

// Nothing is kept until the picture is done: after a failure the next one has none before it.
void Renderer::forget_before(const FramePlan& plan, const RenderOptions& options) {
  if (!options.continues || size_before_ != glm::uvec2(options.width, options.height)) before_ = {};
  size_before_ = {};
  if (before_.snapshot && plan.averages) return;
  rasterizer_->forget_averages();
  averaged_ = 0;
}

void Renderer::keep_frame(const FramePlan& plan, const sideray_camera& camera, const RenderOptions& options) {
  before_ = {rasterizer_->make_view(camera, glm::vec2(0)), snapshot_};
  size_before_ = {options.width, options.height};
  if (!plan.averages) return;
  rasterizer_->keep_average();
  ++averaged_;
}

}  // namespace sideray::bridge
