// Divides the time that a host gives its frames among their jobs, so that a frame ends in time instead of being cut: it
// measures what each job of a view takes besides its rays, reserves that time, and shares the rest by how long the rays
// of each take in all. Where that is not enough for all, jobs take turns, the one that waited longest first; the others
// show history alone. One object a service; any thread.
#pragma once

#include <sideray/service.h>

#include <array>
#include <cstdint>
#include <mutex>
#include <optional>

#include "bridge/service/service_frame.h"
#include "rt/base/counters.h"
#include "rt/base/deadline.h"

namespace sideray::bridge {

class FrameBudget {
 public:
  using Clock = rt::Deadline::clock;
  using Time = Clock::time_point;

  // Jobs of a frame of a view are about to come, by their index in ServiceView::jobs; and one of them has ended otherwise.
  void expect(uint32_t view_id, size_t job);
  void drop(uint32_t view_id, size_t job);
  // Returns when a frame with mapped depth is to be finished. Frames of other views that come before that share the
  // budget; the next frame of the same view begins another.
  Time begin(uint32_t view_id, double budget_ms);

  // The time that a job gets, and what it used of it.
  struct Turn {
    Time begun, stop;  // no ray begins after that
    bool starved;      // there was no time left for rays
    bool traces;       // at least one piece, even so; otherwise none

    rt::WorkTime work() const { return {.deadline = stop, .least_pieces = traces ? 1u : 0u, .ends_in_time = true}; }
  };
  // A job is about to be traced. `later`: whether the frame has jobs of higher indices, too.
  Turn start(uint32_t view_id, size_t job, const std::array<bool, job_count>& later, Time end);
  void finish(uint32_t view_id, size_t job, const Turn& turn, const rt::Counters& counters);
  void uploaded(uint32_t view_id, size_t job, double ms);

 private:
  // The times of a view's job in its last frames, in milliseconds.
  struct Cost {
    double rays = 1.0;   // until all are traced
    double after = 0.0;  // from when they are stopped until the job is traced: pieces that have begun, filters
    double idle = 0.0;   // of a frame without rays
    double upload = 0.0;
    uint32_t expected = 0, frames = 0;
    uint32_t waited = 0;  // frames since the last one with rays, the one that is traced included
  };
  struct Round {
    Time end;
    uint32_t views;  // a bit each
  };

  std::mutex mutex_;
  std::optional<Round> round_;
  Time last_turn_{};  // the end of the last frames of which a job has traced anything
  std::array<std::array<Cost, job_count>, SIDERAY_MAX_VIEWS> costs_{};
};

}  // namespace sideray::bridge
