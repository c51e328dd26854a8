#include "bridge/renderer/measurement.h"

#include <array>
#include <cstdio>
#include <mutex>
#include <utility>
#include <vector>

#include "bridge/base/versions.h"
#include "bridge/renderer/positions.h"

namespace sideray::bridge {
namespace {

// Collects the times of each stage in each repetition.
class RepeatedTimes {
 public:
  void add(const FrameTimer& staged, double total_ms, double kept_ms) {
    for (size_t i = 0; i < SIDERAY_STAGE_TOTAL_FRAME; ++i)
      times_[i].push_back(staged.ms(static_cast<sideray_stage>(i)));
    times_[SIDERAY_STAGE_TOTAL_FRAME].push_back(total_ms);
    times_[SIDERAY_STAGE_KEPT_FRAME].push_back(kept_ms);
  }
  // Skips loading, building and updating, which happen once and were timed then.
  void write(StageTimes& stages) {
    for (size_t i = SIDERAY_STAGE_GBUFFER; i < stage_count; ++i)
      stages.set(static_cast<sideray_stage>(i), std::move(times_[i]));
  }

 private:
  std::array<std::vector<double>, stage_count> times_;
};

// Returns the picture's positions, all with the same random numbers.
std::vector<FramePosition> measured_positions(const PictureJob& job) {
  std::vector<FramePosition> positions;
  for (uint32_t sample = 0; sample < job.plan.samples; ++sample)
    positions.push_back({job.view_of(sample), job.plan.seed});
  return positions;
}

// Says whether shadow maps and masks of things that have not moved since the previous frame are made again. The
// picture's reuse of earlier pictures does not change.
enum class Still { made, kept };

FrameCounters draw_all(PictureJob& job, const std::vector<FramePosition>& positions, FrameTimer& timer,
                       Fragments fragments, Still still) {
  FrameCounters counters;
  job.keeps_masks = still == Still::kept;
  for (const FramePosition& position : positions) {
    if (still == Still::made) job.backend.forget_shadow_maps();
    counters += job.backend.draw(job, position, timer, fragments);
    job.require_wanted();
  }
  return counters;
}

double time_whole(PictureJob& job, const std::vector<FramePosition>& positions, Still still) {
  FrameTimer inside(job.backend, FrameTimer::Mode::off);
  FrameTimer whole(job.backend, FrameTimer::Mode::staged);
  whole.stage(SIDERAY_STAGE_TOTAL_FRAME, [&] { draw_all(job, positions, inside, Fragments::drawn, still); });
  return whole.ms(SIDERAY_STAGE_TOTAL_FRAME);
}

void count(PictureJob& job, const std::vector<FramePosition>& positions, sideray_render_stats& stats) {
  FrameTimer untimed(job.backend, FrameTimer::Mode::off);
  state_counters(draw_all(job, positions, untimed, Fragments::counted, Still::made), stats);
}

}  // namespace

void measure(PictureJob& job, Picture& picture) {
  const std::vector<FramePosition> positions = measured_positions(job);
  RepeatedTimes times;
  for (uint32_t repeat = 0; repeat < job.options.picture.repeats; ++repeat) {
    FrameTimer staged(job.backend, FrameTimer::Mode::staged);
    draw_all(job, positions, staged, Fragments::drawn, Still::made);
    const double total_ms = time_whole(job, positions, Still::made);
    const bool keeps = job.plan.shadow_maps || job.plan.masks_occlusion();
    times.add(staged, total_ms, keeps ? time_whole(job, positions, Still::kept) : 0.0);
  }
  times.write(picture.stages);
  count(job, positions, picture.stats);
  picture.stats.repeats = job.options.picture.repeats;
  measure_raw_frame(job);
}

void draw_timed(PictureJob& job, Picture& picture) {
  RepeatedTimes times;
  for (uint32_t repeat = 0; repeat < job.options.picture.repeats; ++repeat) {
    Picture again;
    FrameTimer timer(job.backend, FrameTimer::Mode::staged);
    draw_positions(job, timer, repeat == 0 ? picture : again);
    double total = 0;
    for (int stage = 0; stage < SIDERAY_STAGE_TOTAL_FRAME; ++stage)
      total += timer.ms(static_cast<sideray_stage>(stage));
    times.add(timer, total, 0.0);
  }
  times.write(picture.stages);
  picture.stats.repeats = job.options.picture.repeats;
  measure_raw_frame(job);
}

void describe_tracer(const PictureJob& job, sideray_render_stats& stats) {
  if (!job.tracer) return;
  const rt::Tracer& tracer = job.tracer->tracer;
  stats.threads = tracer.threads();
  std::snprintf(stats.isa, sizeof(stats.isa), "%s", tracer.isa().c_str());
  std::snprintf(stats.embree, sizeof(stats.embree), "%s", tracer.embree().c_str());
}

void measure_raw_frame(const PictureJob& job) {
  if (!job.tracer || !job.options.diagnostics.raw_frame) return;
  const gl::RasterView v = job.view_of(0);
  const std::lock_guard lock(job.tracer->turn);
  const rt::RawFrame raw = job.tracer->tracer.time_raw_frame(
      {.view = {v.clip_from_local, v.local_from_clip, v.reversed_depth, v.zero_to_one_depth},
       .width = job.plan.width,
       .height = job.plan.height,
       .most_flat = job.options.most_flat_triangles});
  const sideray_raw_frame result{sizeof(result), job.options.most_flat_triangles, raw.ms, raw.triangles, raw.flat};
  write_struct(job.options.diagnostics.raw_frame, result, "raw frame");
}

}  // namespace sideray::bridge
