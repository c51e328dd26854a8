// Tests the threads of the host's shader: bits are the same, and nothing waits forever.
#include <gmock/gmock.h>

#include <algorithm>
#include <atomic>
#include <optional>

#include "rt/shading/host_shader_scene.h"
#include "rt/shading/shading_queue.h"

namespace sideray::rt {
namespace {

using namespace test;

// Panes that reflect each other, in numbers that no order of additions leaves alone.
void add_maze(TestScene& scene) {
  for (int k = 0; k < 5; ++k) {
    const auto f = static_cast<float>(k);
    scene.quad({0.3f * f, 0, -2 - 0.4f * f}, {1, 0, 0.2f * f}, {0, 1, 0.1f}, blended({0.3f, 0.7f, 0.9f}, 0.3f));
    scene.quad({-0.4f * f, 0, 1 + 0.3f * f}, {1, 0, 0.3f}, {0, 1.5f, 0}, plain_material());
  }
  scene.lights({point_light({0.3f, 2, 0}, 3.0f), point_light({-1, 0.5f, -1}, 2.0f)});
  scene.environment(glm::vec3(0.3f));
}

void shade_maze(const Point& p, Result& r) {
  const auto wave = [](double x) { return static_cast<float>(0.5 + 0.5 * std::sin(x)); };
  set(r.radiance, glm::vec3(wave(7 * p.position[0]), wave(9 * p.position[1]), static_cast<float>(p.lights)));
  set(r.reflectance, glm::vec3(0.3f, wave(p.position[2]), 0.1f));
}

TEST(HostShaderThreads, makes_the_same_bits_on_any_number_of_threads) {
  Shader shader{shade_maze};
  std::optional<LayerCache> first;
  for (const uint32_t threads : {1u, 2u, 8u}) {
    TestScene scene;
    add_maze(scene);
    const LayerCache cache = cache_of(
        scene, shader, [](sideray_shader_desc& d) { d.shadow_lights = 3; }, threads);
    if (!first) first = cache;
    EXPECT_EQ(cache.radiance, first->radiance) << threads;
  }
}

// A frame traced on a thread of its own, whose shader is asked for on this one.
struct InCalls {
  ShadingQueue queue;
  std::atomic<bool> cancelled{false}, finished{false};
  LayerCache cache;
  Counters counters;
  TestScene scene;
  Tracer tracer{TracerConfig{.threads = 4, .isa = ""}};
  TestFrame frame = frame_of(2);
  std::jthread thread;

  // `allowed`: until the deadline, from when tracing starts; 0: there is none.
  void start(Shader& shader, std::chrono::milliseconds allowed = {}) {
    add_maze(scene);
    sideray_shader_desc desc = shader.desc();
    desc.shadow_lights = 3;
    scene.scene.set_shader(&desc);
    tracer.set_scene(scene.commit());
    frame.request.shading_queue = &queue;
    frame.request.cancelled = &cancelled;
    if (allowed.count() > 0) frame.request.work.deadline = Deadline::clock::now() + allowed;
    thread = std::jthread([this] {
      counters = tracer.trace_cache(frame.get(), cache);
      finished = true;
      queue.wake();
    });
  }
  void serve() {
    queue.serve_until(std::chrono::steady_clock::time_point::max(), [&] { return finished.load(); });
    thread.join();
  }
};

TEST(HostShaderThreads, runs_where_the_host_is) {
  Shader shader{shade_maze}, on_workers{shade_maze};
  InCalls calls;
  calls.start(shader);
  calls.serve();
  EXPECT_THAT(shader.threads, testing::ElementsAre(std::this_thread::get_id()));
  TestScene scene;
  add_maze(scene);
  const LayerCache cache = cache_of(scene, on_workers, [](sideray_shader_desc& d) { d.shadow_lights = 3; });
  EXPECT_EQ(calls.cache.radiance, cache.radiance);
}

TEST(HostShaderThreads, is_given_up_when_cancelled) {
  Shader shader{shade_maze};
  InCalls calls;
  calls.start(shader);
  std::this_thread::sleep_for(std::chrono::milliseconds(20));  // batches wait
  EXPECT_FALSE(calls.finished);
  calls.cancelled = true;
  calls.queue.wake();
  calls.thread.join();
  EXPECT_TRUE(shader.points.empty());
}

// After the deadline no piece begins. Those begun are finished, however late the host calls.
TEST(HostShaderThreads, finishes_what_has_begun_before_the_deadline) {
  Shader shader{shade_maze};
  InCalls calls;
  calls.start(shader, std::chrono::milliseconds(500));
  std::this_thread::sleep_until(calls.frame.request.work.deadline + std::chrono::milliseconds(30));
  EXPECT_TRUE(shader.points.empty());
  calls.serve();
  constexpr uint64_t all = uint64_t{size} * size, begun = 4 * pixels_in_late_chunk;
  ASSERT_GT(all, begun);
  EXPECT_GE(calls.counters.pixels_late, all - begun);
  EXPECT_LT(calls.counters.pixels_late, all);
  const auto answered = std::count_if(calls.cache.distance.begin(), calls.cache.distance.begin() + all,
                                      [](float distance) { return distance != 0.0f; });
  EXPECT_EQ(static_cast<uint64_t>(answered), all - calls.counters.pixels_late);
}

// A batch that has begun is waited for, or the callback would read memory that is gone.
TEST(HostShaderThreads, is_waited_for_once_it_runs) {
  InCalls calls;
  std::atomic<bool> ended{false};
  Shader shader{[&](const Point&, Result&) {
    if (calls.cancelled.exchange(true)) return;
    calls.queue.wake();
    std::this_thread::sleep_for(std::chrono::milliseconds(30));
    EXPECT_FALSE(calls.finished);
    ended = true;
  }};
  calls.start(shader);
  calls.serve();
  EXPECT_TRUE(ended);
}

}  // namespace
}  // namespace sideray::rt
