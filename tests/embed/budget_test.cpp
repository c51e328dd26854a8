// Tests hosts with a budget: every job continues in every frame, pieces without a turn show older results, and views
// share a frame's time.
#include <gmock/gmock.h>
#include <sideray/diagnostics.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <thread>

#include "bridge/service/frame_budget.h"
#include "embed/hosts/frame_outputs.h"
#include "embed/hosts/small_host.h"

namespace sideray::tests::budget_test {
namespace {

using bridge::FrameBudget;

constexpr float ample = 1e6f, none = 1e-3f;

class Budget : public testing::Test {
 protected:
  FrameInputs inputs(bool continues, double eye_x = 0) {
    FrameInputs in = host_.inputs();
    for (const SmallHost::Case& c : SmallHost::cases())
      if (std::string(c.name) == "everything") c.ask(host_, in);
    SmallHost::set_view(in, SmallHost::clip_from_world(eye_x));
    in.layers->denoise = in.masks->denoise = in.reflections->denoise = 0;
    in.frame.continues = continues;
    return in;
  }
  sideray_frame_stats trace(sideray::Service& service, const FrameInputs& in) {
    const sideray_ticket ticket = service.submit(in).value();
    EXPECT_TRUE(service.wait(ticket));
    return service.stats(ticket);
  }
  static uint64_t late(const sideray_frame_stats& s) {
    return s.pixels_late + s.mask_pixels_late + s.reflection_pixels_late;
  }
  static uint64_t older(const sideray_frame_stats& s) {
    return s.pixels_older + s.mask_pixels_older + s.reflection_pixels_older;
  }

  sideray::Tracer tracer_of(uint32_t threads) {
    sideray_tracer_desc desc = sideray_tracer_defaults();
    desc.threads = threads;
    return sideray::Tracer::create(host_.scene(), desc).value();
  }

  SmallHost host_{gl::Context::create("auto", "")};
  sideray::Tracer tracer_ = tracer_of(1);
};

TEST_F(Budget, ThatIsAmpleChangesNoBit) {
  sideray::Service service = sideray::Service::create(tracer_, host_.loader()).value();
  FrameInputs in = inputs(false);
  trace(service, in);
  const std::vector<uint8_t> whole = host_.texels(*newest_outputs(service.get(), 0));
  in.frame.budget_ms = ample;
  const sideray_frame_stats stats = trace(service, in);
  EXPECT_EQ(late(stats) + older(stats) + stats.jobs_starved, 0u);
  EXPECT_EQ(SmallHost::difference(host_.texels(*newest_outputs(service.get(), 0)), whole), "");
}

// Under any budget, all jobs of a still view are complete in the end.
TEST_F(Budget, ThatIsTooSmallLetsEveryJobGoOn) {
  sideray::Service service = sideray::Service::create(tracer_, host_.loader()).value();
  FrameInputs in = inputs(false);
  trace(service, in);
  const std::vector<uint8_t> whole = host_.texels(*newest_outputs(service.get(), 0));
  in.frame.budget_ms = none;
  sideray_frame_stats before = trace(service, in);
  EXPECT_GT(late(before), 0u);
  EXPECT_EQ(older(before), 0u) << "it follows no frame";
  in.frame.continues = true;
  size_t frames = 1;
  while (late(before) > 0 && frames < 2000) {
    sideray_frame_stats now{};
    for (size_t job = 0; job < bridge::job_count; ++job, ++frames) now = trace(service, in);  // a turn for each
    EXPECT_TRUE(before.pixels_late == 0 || now.pixels_late < before.pixels_late) << frames;
    EXPECT_TRUE(before.mask_pixels_late == 0 || now.mask_pixels_late < before.mask_pixels_late) << frames;
    before = now;
  }
  EXPECT_EQ(late(before), 0u) << "after " << frames << " frames";
  EXPECT_GT(frames, 2u);
  EXPECT_GT(older(before), 0u);
  // The same rays in the end, since nothing is filtered over frames here.
  EXPECT_EQ(SmallHost::difference(host_.texels(*newest_outputs(service.get(), 0)), whole), "");
}

// With a budget in pieces instead of milliseconds, bits depend on inputs alone.
TEST_F(Budget, InPiecesHasTheSameBitsForAnyThreads) {
  std::vector<std::vector<uint8_t>> answers[3];
  const uint32_t threads[] = {1, 2, 5};
  sideray_diagnostics diagnostics = sideray_diagnostics_defaults();
  diagnostics.budget_pieces = 2;
  for (int run = 0; run < 3; ++run) {
    sideray::Tracer tracer = tracer_of(threads[run]);
    sideray::Service service = sideray::Service::create(tracer, host_.loader()).value();
    for (int frame = 0; frame < 8; ++frame) {
      FrameInputs in = inputs(frame > 0, 0.02 * frame);
      in.frame.diagnostics = &diagnostics;
      in.frame.seed = static_cast<uint32_t>(frame);
      const sideray_frame_stats stats = trace(service, in);
      EXPECT_GT(late(stats) + older(stats), 0u);
      answers[run].push_back(host_.texels(*newest_outputs(service.get(), 0)));
    }
  }
  for (int frame = 0; frame < 8; ++frame)
    for (const int run : {1, 2})
      EXPECT_EQ(SmallHost::difference(answers[run][static_cast<size_t>(frame)], answers[0][static_cast<size_t>(frame)]), "")
          << "frame " << frame << ", " << threads[run] << " threads";
}

TEST_F(Budget, IsRefusedWhereItMakesNoSense) {
  sideray::Service service = sideray::Service::create(tracer_, host_.loader()).value();
  FrameInputs in = inputs(false);
  const auto refused = [&] {
    sideray_ticket ticket = 0;
    sideray_error error{};
    return submit_frame(service.get(), in, ticket, &error) == SIDERAY_OK ? std::string("it was taken") : error.message;
  };
  for (const float wrong : {-1.0f, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    in.frame.budget_ms = wrong;
    EXPECT_THAT(refused(), testing::HasSubstr("budget_ms"));
  }
  in.frame.budget_ms = 5.0f;
  in.frame.deadline_ms = 5.0f;
  EXPECT_THAT(refused(), testing::AllOf(testing::HasSubstr("budget_ms"), testing::HasSubstr("deadline_ms")));
}

double ms(FrameBudget::Clock::duration d) {
  return std::chrono::duration<double, std::milli>(d).count();
}

// Sixteen views submitted together share one deadline; a view's next frame has its own.
TEST(FrameBudgets, AreSharedByViews) {
  FrameBudget budget;
  const FrameBudget::Time end = budget.begin(0, 1000.0);
  for (uint32_t view = 1; view < SIDERAY_MAX_VIEWS; ++view) EXPECT_EQ(budget.begin(view, 1000.0), end);
  EXPECT_GT(budget.begin(3, 1000.0), end);
}

// Rays stop early enough for the later stages, as measured before.
TEST(FrameBudgets, KeepTimeForWhatComesBehindRays) {
  FrameBudget budget;
  const std::array<bool, bridge::job_count> alone{};
  rt::Counters unfinished;
  unfinished.pixels_total = unfinished.pixels_masked = 100;
  unfinished.pixels_late = 50;
  for (int frame = 0; frame < 3; ++frame) {
    const FrameBudget::Time end = budget.begin(0, 100.0);
    budget.expect(0, 2);
    const FrameBudget::Turn turn = budget.start(0, 2, alone, end);
    EXPECT_FALSE(turn.starved);
    const double left = ms(end - turn.stop);
    EXPECT_TRUE(frame == 2 ? left > 20.0 : left < 1.0) << left << " ms in frame " << frame;
    std::this_thread::sleep_until(turn.stop + std::chrono::milliseconds(20));
    budget.finish(0, 2, turn, unfinished);
  }
}

// Two jobs that take nine tenths of a budget without rays get the rest for rays, although slow frames left no time for
// them before: the time of a starved turn must not count as fixed cost. A busy machine may wake the test some
// milliseconds late, so the budget is long.
TEST(FrameBudgets, RecoverFromSlowFrames) {
  constexpr int slow_frames = 4, most_frames = 300;
  rt::Counters unfinished;
  unfinished.pixels_total = unfinished.pixels_masked = 100;
  unfinished.pixels_late = 50;
  FrameBudget budget;
  bool starved = true;
  for (int frame = 0; frame < most_frames && starved; ++frame) {
    const std::chrono::microseconds without_rays(frame < slow_frames ? 50'000 : 36'000);
    const FrameBudget::Time end = budget.begin(0, 80.0);
    starved = frame < slow_frames;
    for (const size_t job : {size_t{0}, size_t{1}}) {
      const FrameBudget::Turn turn = budget.start(0, job, {false, job == 0}, end);
      starved = starved || turn.starved;
      const FrameBudget::Time least = turn.begun + without_rays + turn.least;
      std::this_thread::sleep_until(turn.traces ? std::max(turn.stop, least) : least);
      budget.finish(0, job, turn, unfinished);
    }
  }
  EXPECT_FALSE(starved);
}

TEST(FrameBudgets, GoToThoseThatHaveMoreToDo) {
  FrameBudget budget;
  rt::Counters done;
  done.pixels_total = 100;
  const std::array<bool, bridge::job_count> alone{};
  for (int frame = 0; frame < 2; ++frame)
    for (const size_t job : {size_t{0}, size_t{2}}) {
      const FrameBudget::Turn turn = budget.start(0, job, alone, FrameBudget::Clock::now() + std::chrono::seconds(1));
      std::this_thread::sleep_for(std::chrono::milliseconds(job == 0 ? 5 : 45));
      budget.finish(0, job, turn, done);
    }
  const FrameBudget::Time now = FrameBudget::Clock::now(), end = now + std::chrono::seconds(10);
  const FrameBudget::Turn turn = budget.start(0, 0, {false, false, true}, end);
  EXPECT_LT(ms(turn.stop - now), 0.4 * ms(end - now));
}

// Without time for any job, one job of all views that share the budget traces a piece: the one that waited longest.
TEST(FrameBudgets, ThatAreSpentLetJobsTakeTurns) {
  constexpr uint32_t views = 3;
  constexpr size_t jobs = bridge::job_count, all = views * jobs;
  FrameBudget budget;
  std::array<size_t, all> turns{};
  for (size_t frame = 0; frame < 3 * all; ++frame) {
    const FrameBudget::Time end = FrameBudget::Clock::now() - std::chrono::milliseconds(1);
    for (uint32_t view = 0; view < views; ++view)
      for (size_t job = 0; job < jobs; ++job) budget.expect(view, job);
    size_t traced = 0;
    for (uint32_t view = 0; view < views; ++view)
      for (size_t job = 0; job < jobs; ++job) {
        std::array<bool, jobs> later{};
        std::fill(later.begin() + static_cast<ptrdiff_t>(job) + 1, later.end(), true);
        const FrameBudget::Turn turn = budget.start(view, job, later, end);
        EXPECT_EQ(rt::is_over(turn.work()), !turn.traces);
        traced += turn.traces;
        turns[view * jobs + job] += turn.traces;
      }
    EXPECT_EQ(traced, 1u) << "frame " << frame;
  }
  for (const size_t count : turns) EXPECT_EQ(count, 3u);
}

// The job that has its turn traces for a part of the budget, on all threads.
TEST(FrameBudgets, ThatAreSpentLeaveATurnSomeTime) {
  FrameBudget budget;
  budget.begin(0, 16.0);
  const FrameBudget::Time over = FrameBudget::Clock::now() - std::chrono::milliseconds(1);
  const FrameBudget::Turn first = budget.start(0, 0, {false, true}, over), second = budget.start(0, 1, {}, over);
  EXPECT_TRUE(first.traces);
  EXPECT_EQ(first.work().least, std::chrono::milliseconds(2));
  EXPECT_FALSE(second.traces);
  EXPECT_TRUE(rt::is_over(second.work()));
}

constexpr std::array<bool, bridge::job_count> no_others{};
constexpr auto long_time = std::chrono::seconds(100);

// Returns how long before the frame's end the job's rays stop.
double ms_kept(FrameBudget& budget, uint32_t view, size_t job,
               const std::array<bool, bridge::job_count>& later = no_others) {
  const FrameBudget::Time end = FrameBudget::Clock::now() + long_time;
  return ms(end - budget.start(view, job, later, end).stop);
}

TEST(FrameBudgets, EndBeforeAnotherViewBeginsLater) {
  FrameBudget budget;
  const FrameBudget::Time end = budget.begin(0, 1.0);
  std::this_thread::sleep_until(end);
  EXPECT_GT(budget.begin(1, 1000.0), end + std::chrono::milliseconds(500));
}

// Only the last job's upload follows the rays; a longer one counts at once, a shorter one by and by.
TEST(FrameBudgets, KeepTimeForTheLastUpload) {
  FrameBudget budget;
  budget.uploaded(0, 0, 30.0);
  EXPECT_NEAR(ms_kept(budget, 0, 0), 30.0, 1e-3);
  budget.uploaded(0, 0, 10.0);
  EXPECT_NEAR(ms_kept(budget, 0, 0), 25.0, 1e-3);
  budget.uploaded(0, 0, 60.0);
  EXPECT_NEAR(ms_kept(budget, 0, 0), 60.0, 1e-3);
  budget.uploaded(0, 1, 2000.0);
  // The second job needs as many rays: the first stops at half of what the second's upload leaves.
  const double half = 0.5 * std::chrono::duration<double, std::milli>(long_time).count();
  EXPECT_NEAR(ms_kept(budget, 0, 0, {false, true}), half + 1000.0, 20.0);
}

// Jobs of other views that are expected get their share, until they are dropped or have begun.
TEST(FrameBudgets, AreSharedWithWhatIsExpected) {
  const auto kept_beside = [](const std::function<void(FrameBudget&)>& other) {
    FrameBudget budget;
    budget.expect(1, 0);
    other(budget);
    return ms_kept(budget, 0, 0);
  };
  const double half = 0.5 * std::chrono::duration<double, std::milli>(long_time).count();
  EXPECT_NEAR(kept_beside([](FrameBudget&) {}), half, 20.0);
  EXPECT_LT(kept_beside([](FrameBudget& budget) { budget.drop(1, 0); }), 20.0);
  EXPECT_LT(kept_beside([](FrameBudget& budget) { ms_kept(budget, 1, 0); }), 20.0);
}

// Filters of jobs that follow take place after the rays too, and a job of few rays keeps an eighth of the time.
TEST(FrameBudgets, KeepTimeForFiltersAndAnEighthForEachJob) {
  FrameBudget budget;
  rt::Counters done;
  done.pixels_total = 100;
  done.denoise_ms = 1000.0;
  for (int frame = 0; frame < 2; ++frame) {
    FrameBudget::Turn turn = budget.start(0, 1, no_others, FrameBudget::Clock::now() + long_time);
    turn.begun -= std::chrono::seconds(50);  // as long as all its rays took
    budget.finish(0, 1, turn, done);
  }
  const double all = std::chrono::duration<double, std::milli>(long_time).count() - 1000.0;
  EXPECT_NEAR(ms_kept(budget, 0, 0, {false, true}), 1000.0 + all * 7 / 8, 20.0);
}

// A job that waits less than another is only shown beside it, for which time is kept instead of that for its filters.
TEST(FrameBudgets, KeepTimeForJobsThatAreOnlyShown) {
  FrameBudget budget;
  const FrameBudget::Time over = FrameBudget::Clock::now() - std::chrono::milliseconds(1);
  rt::Counters untraced;
  untraced.pixels_total = untraced.pixels_late = 100;
  ASSERT_TRUE(budget.start(0, 0, no_others, over).traces);
  for (int frame = 0; frame < 2; ++frame) {
    FrameBudget::Turn shown = budget.start(0, 1, no_others, over);
    ASSERT_FALSE(shown.traces);
    shown.begun -= std::chrono::seconds(2);
    budget.finish(0, 1, shown, untraced);
  }
  ASSERT_TRUE(budget.start(0, 1, no_others, FrameBudget::Clock::now() + long_time).traces);
  for (int frame = 0; frame < 3; ++frame) budget.start(0, 0, no_others, over);
  const double half = 0.5 * std::chrono::duration<double, std::milli>(long_time).count();
  EXPECT_NEAR(ms_kept(budget, 0, 0, {false, true}), half + 1000.0, 20.0);
}

TEST(FrameBudgets, ThatAreSpentSaySo) {
  FrameBudget budget;
  const FrameBudget::Time now = FrameBudget::Clock::now();
  EXPECT_TRUE(budget.start(0, 0, {}, now - std::chrono::milliseconds(1)).starved);
}

}  // namespace
}  // namespace sideray::tests::budget_test
