#include "bridge/renderer/positions.h"

#include "bridge/picture/self_error.h"
#include "bridge/renderer/frame.h"
#include "bridge/renderer/outputs.h"
#include "rt/base/sampling.h"

namespace sideray::bridge {
namespace {

template <typename T>
void add_to(std::vector<T>& sum, const std::vector<T>& values) {
  sum.resize(values.size(), T(0));
  for (size_t i = 0; i < values.size(); ++i) sum[i] += values[i];
}

// Each position has random numbers of its own.
FramePosition position_of(const PictureJob& job, uint32_t sample) {
  const uint32_t seed = job.options.seed;
  return {job.view_of(sample), sample == 0 ? seed : rt::random_key({seed, sample})};
}

}  // namespace

void draw_positions(PictureJob& job, FrameTimer& timer, Picture& picture) {
  std::vector<glm::vec4> sum;
  std::vector<glm::vec3> half_difference;
  FrameCounters counters;
  for (uint32_t sample = 0; sample < job.options.samples; ++sample) {
    const FramePosition position = position_of(job, sample);
    counters += draw_frame(job, position, timer, Fragments::drawn);
    const std::vector<glm::vec4> color = job.rasterizer.read_color();
    if (job.plan.light_samples > 0) add_to(half_difference, job.service->composite().half_difference);
    if (sample == 0) {
      sum = color;
      add_aovs(job, position.view, picture);
    } else {
      add_to(sum, color);
    }
  }
  const auto positions = static_cast<float>(job.options.samples);
  if (job.options.samples > 1)
    for (glm::vec4& c : sum) c /= positions;
  for (glm::vec3& d : half_difference) d /= positions;
  add_color(picture, sum);
  if (timer.staged()) state_counters(counters, picture.stats);
  if (job.plan.light_samples > 0)
    state_self_error(job.plan.light_samples, job.plan.bounces, sum, half_difference, picture.stats);
}

}  // namespace sideray::bridge
