#include "bridge/jobs/job.h"

#include <chrono>

namespace sideray::bridge {
namespace {

constexpr float least_share = 0.125f;            // of the allowed time that rays get
constexpr std::chrono::microseconds no_time(1);  // shorter times count as 0: whether a ray begins in them is chance

}  // namespace

rt::SequenceStep sequence_step(const FrameInputs& inputs) {
  if (inputs.inspection.redraws) return rt::SequenceStep::again;
  return inputs.continues ? rt::SequenceStep::next : rt::SequenceStep::first;
}

rt::WorkTime time_of(const Job& job, const FrameInputs& inputs, rt::Deadline start) {
  rt::WorkTime time;
  if (!(inputs.deadline_ms > 0.0f)) return time;
  using Duration = rt::Deadline::duration;
  const std::chrono::duration<float, std::milli> allowed(inputs.deadline_ms);
  time.deadline = start + std::chrono::duration_cast<Duration>(allowed);
  time.least = std::chrono::duration_cast<Duration>(allowed * least_share);
  if (time.least < no_time) time.least = {};
  const rt::Deadline now = rt::Deadline::clock::now();
  const double share = job.share_of_time(inputs);
  if (share < 1.0 && time.deadline > now)
    time.deadline = now + std::chrono::duration_cast<Duration>((time.deadline - now) * share);
  return time;
}

}  // namespace sideray::bridge
