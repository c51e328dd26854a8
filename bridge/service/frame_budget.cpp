#include "bridge/service/frame_budget.h"

#include <algorithm>

namespace sideray::bridge {
namespace {

// The least share of the time for rays that a job gets.
constexpr double job_least_share = 0.125;
// A starved job that has its turn gets at least this part of the budget: in one piece alone all threads but one would
// be idle.
constexpr int part_of_turn = 8;

double ms_between(FrameBudget::Time from, FrameBudget::Time to) {
  return std::chrono::duration<double, std::milli>(to - from).count();
}

FrameBudget::Clock::duration milliseconds(double ms) {
  return std::chrono::duration_cast<FrameBudget::Clock::duration>(std::chrono::duration<double, std::milli>(ms));
}

// Adapts at once to a longer time than expected, but gradually to a shorter one, since a late frame is visible.
void follow(double& known, double seen) {
  known = seen > known ? seen : known + 0.25 * (seen - known);
}

// Returns the share of its pixels that the job has traced in this frame.
double share_traced(const rt::Counters& c) {
  const auto left = static_cast<double>(c.pixels_late + c.pixels_older + c.mask_pixels_late + c.mask_pixels_older +
                                        c.reflection_pixels_late + c.reflection_pixels_older +
                                        c.irradiance_pixels_late + c.irradiance_pixels_older);
  const auto all = static_cast<double>(c.pixels_masked > 0 ? c.pixels_masked : c.pixels_total);
  return all > 0.0 ? std::clamp(1.0 - left / all, 0.0, 1.0) : 1.0;
}

}  // namespace

void FrameBudget::expect(uint32_t view_id, size_t job) {
  const std::lock_guard lock(mutex_);
  ++costs_[view_id][job].expected;
}

void FrameBudget::drop(uint32_t view_id, size_t job) {
  const std::lock_guard lock(mutex_);
  uint32_t& expected = costs_[view_id][job].expected;
  expected -= expected > 0;
}

FrameBudget::Time FrameBudget::begin(uint32_t view_id, double budget_ms) {
  const std::lock_guard lock(mutex_);
  const Time now = Clock::now();
  const uint32_t view = 1u << view_id;
  const bool joins = round_ && now < round_->end && (round_->views & view) == 0;
  if (!joins) round_ = Round{now + milliseconds(budget_ms), 0, milliseconds(budget_ms)};
  round_->views |= view;
  return round_->end;
}

FrameBudget::Turn FrameBudget::start(uint32_t view_id, size_t job, const std::array<bool, job_count>& later, Time end) {
  const std::lock_guard lock(mutex_);
  Cost& own = costs_[view_id][job];
  own.expected -= own.expected > 0;
  ++own.waited;
  // Counts only the last job's upload: the others overlap the rays of the next job.
  double rays = 0.0, idle = own.idle, others = 0.0, last_upload = own.upload;
  bool waited_longest = true;
  const auto add = [&](const Cost& cost) {
    const uint32_t waits = cost.waited + 1;
    rays += cost.rays;
    idle += cost.idle;
    if (waits >= own.waited) others += cost.more;
    last_upload = cost.upload;
    waited_longest = waited_longest && waits <= own.waited;
  };
  for (uint32_t v = 0; v < SIDERAY_MAX_VIEWS; ++v)
    for (size_t j = 0; v != view_id && j < job_count; ++j)
      if (costs_[v][j].expected > 0) add(costs_[v][j]);
  for (size_t j = job + 1; j < job_count; ++j)
    if (later[j]) add(costs_[view_id][j]);
  const Time now = Clock::now();
  const double alone = ms_between(now, end) - idle - own.more - last_upload;  // if no other job traces rays
  const double left = alone - others;
  const double share = std::max(own.rays / (own.rays + rays), job_least_share);
  // At least one job traces rays among the frames that end together.
  const bool traces = left > 0.0 || (waited_longest && last_turn_ != end);
  if (traces) own.waited = 0, last_turn_ = end;
  const bool starved = left <= 0.0;
  if (!traces) return {now, now, starved, traces, {}};
  const Clock::duration part = starved && round_ ? round_->budget / part_of_turn : Clock::duration{0};
  const Clock::duration time = starved ? std::max(milliseconds(alone), part) : milliseconds(left * share);
  return {now, now + milliseconds(own.idle) + time, starved, traces, part};
}

void FrameBudget::finish(uint32_t view_id, size_t job, const Turn& turn, const rt::Counters& counters) {
  const std::lock_guard lock(mutex_);
  Cost& cost = costs_[view_id][job];
  const Time now = Clock::now();
  const double took = ms_between(turn.begun, now), allowed = ms_between(turn.begun, turn.stop);
  const double traced = share_traced(counters);
  if (cost.frames++ == 0) return;  // the first frame allocates memory
  if (!turn.traces) return follow(cost.idle, took);
  if (traced == 1.0) {  // no time limit stopped the rays
    follow(cost.more, counters.denoise_ms);
    cost.rays = std::max(took - cost.more, 0.01);
    return;
  }
  follow(cost.more, std::max(took - allowed, 0.0));
  if (turn.starved) return;
  // Limits the extrapolation from a small share.
  const double whole = std::max(allowed - cost.idle, 0.1) / std::max(traced, 0.01);
  cost.rays += 0.25 * (whole - cost.rays);
}

void FrameBudget::uploaded(uint32_t view_id, size_t job, double ms) {
  const std::lock_guard lock(mutex_);
  follow(costs_[view_id][job].upload, ms);
}

}  // namespace sideray::bridge
