// Divides the time that a host gives its frames among their jobs, so that a frame ends in time instead of being cut.
// Measures what each job of a view takes without rays, and besides them, reserves that time, and shares the rest in
// proportion to the time of all rays of each job. If the time is too short for all jobs, they take turns: the job that
// waited longest traces, and the others show history alone. One object for a service; any thread.
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

  // Announce a job of a view by its index in ServiceView::jobs, and withdraw it where it ended without being traced.
  void expect(uint32_t view_id, size_t job);
  void drop(uint32_t view_id, size_t job);
  // Returns when a frame with mapped depth must end. Frames of other views that begin before that share the budget; the
  // next frame of the same view begins a new one.
  Time begin(uint32_t view_id, double budget_ms);

  // Holds the time that a job gets.
  struct Turn {
    Time begun, stop;  // no ray begins after `stop`
    bool starved;      // there was no time left for rays
    bool traces;       // at least one piece is traced, even if starved; otherwise none
    Clock::duration least;  // the time that rays have in any case: a part of the budget if a starved job has its turn

    rt::WorkTime work() const {
      return {.deadline = stop, .least = least, .least_pieces = traces ? 1u : 0u, .ends_in_time = true};
    }
  };
  // Begins to trace a job. `later`: whether the frame has jobs of higher indices.
  Turn start(uint32_t view_id, size_t job, const std::array<bool, job_count>& later, Time end);
  void finish(uint32_t view_id, size_t job, const Turn& turn, const rt::Counters& counters);
  void uploaded(uint32_t view_id, size_t job, double ms);

 private:
  // Holds smoothed times of a view's job, in milliseconds.
  struct Cost {
    double rays = 1.0;  // for all rays
    double idle = 0.0;  // for a frame without rays
    double more = 0.0;  // for a frame with rays, besides these and `idle`: pieces that have begun, filters
    double upload = 0.0;
    uint32_t expected = 0, frames = 0;
    uint32_t waited = 0;  // frames since its last rays, the current one included
  };
  struct Round {
    Time end;
    uint32_t views;  // a bit for each
    Clock::duration budget;
  };

  std::mutex mutex_;
  std::optional<Round> round_;
  Time last_turn_{};  // when the last frames in which a job traced rays must end
  std::array<std::array<Cost, job_count>, SIDERAY_MAX_VIEWS> costs_{};
};

}  // namespace sideray::bridge
