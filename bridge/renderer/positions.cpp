#include "bridge/renderer/positions.h"

#include "bridge/picture/self_error.h"
#include "bridge/renderer/measurement.h"
#include "bridge/renderer/outputs.h"
#include "model/stopwatch.h"
#include "rt/poses/particle_quads.h"

namespace sideray::bridge {
namespace {

template <typename Sum, typename T>
void add_to(std::vector<Sum>& sum, const std::vector<T>& values) {
  sum.resize(values.size(), Sum(0));
  for (size_t i = 0; i < values.size(); ++i) sum[i] += Sum(values[i]);
}

// Averages positions. Sums are exact to 2^-53, so that still views, which take positions in any order, get the same.
std::vector<glm::vec4> mean_of(const std::vector<glm::dvec4>& sum, uint32_t positions) {
  std::vector<glm::vec4> mean(sum.size());
  for (size_t i = 0; i < sum.size(); ++i) mean[i] = glm::vec4(sum[i] / static_cast<double>(positions));
  return mean;
}

FramePosition position_of(const PictureJob& job, uint32_t sample) {
  return {job.view_of(sample), job.sequence.seed(job.plan, sample), job.sequence.position(sample)};
}

// Sets the times of threads that trace, which time themselves beside OpenGL; other stages would need fences.
void state_times(const FrameTimer& timer, double total_ms, StageTimes& stages) {
  for (const sideray_stage stage : {SIDERAY_STAGE_TRACE, SIDERAY_STAGE_TRACE_SHADOW, SIDERAY_STAGE_TRACE_AO,
                                    SIDERAY_STAGE_DENOISE})
    stages.set(stage, timer.ms(stage));
  stages.set(SIDERAY_STAGE_TOTAL_FRAME, total_ms);
}

// Fills the statistics that need no frame.
void describe_frame(const PictureJob& job, sideray_render_stats& stats) {
  stats.positions = job.sequence.positions(job.plan);
  stats.pixels_total = uint64_t{job.plan.width} * job.plan.height * job.plan.samples;
  if (job.plan.drops_particles) {
    const gl::RasterView v = job.view_of(0);
    stats.dropped_particles = rt::count_sprites_in_view(
        *job.snapshot, {v.clip_from_local, v.local_from_clip, v.reversed_depth, v.zero_to_one_depth});
  }
  if (job.plan.uses_rays()) describe_tracer(job, stats);
}

}  // namespace

void draw_positions(PictureJob& job, FrameTimer& timer, Picture& picture) {
  std::vector<glm::vec4> color, average;
  std::vector<glm::dvec4> sum;
  std::vector<glm::vec3> half_difference;
  FrameCounters counters;
  double total_ms = 0;
  // Fragments are counted in the frames that are drawn again for their times, if there are any.
  const bool counts = job.plan.checks && job.options.picture.repeats == 0;
  for (uint32_t sample = 0; sample < job.plan.samples; ++sample) {
    const FramePosition position = position_of(job, sample);
    const Stopwatch watch;
    counters += job.backend.draw(job, position, timer, counts ? Fragments::counted : Fragments::drawn);
    job.require_wanted();
    job.backend.finish();  // reading the colour would wait anyway
    total_ms += watch.ms();
    if (!job.plan.without_color) color = job.backend.read_color();
    if (job.plan.layers.light_samples > 0) add_to(half_difference, job.backend.composite().half_difference);
    if (sample == 0) add_aovs(job, position.view, picture);
    if (job.plan.samples > 1 && !job.plan.without_color) add_to(sum, color);
  }
  if (job.plan.samples > 1 && !job.plan.without_color) color = mean_of(sum, job.plan.samples);
  for (glm::vec3& d : half_difference) d /= static_cast<float>(job.plan.samples);
  if (job.sequence.begins_tiles()) {
    job.backend.average(job.sequence.before());
    average = job.backend.read_color();
  }
  if (!job.plan.without_color) {
    job.sequence.show(job.plan, counters.trace, color, average);
    add_color(picture, color);
  }
  state_times(timer, total_ms, picture.stages);
  state_counters(counters, picture.stats);
  describe_frame(job, picture.stats);
  if (job.plan.layers.light_samples > 0)
    state_self_error(job.plan.layers.light_samples, job.plan.layers.bounces, color, half_difference, picture.stats);
}

}  // namespace sideray::bridge
