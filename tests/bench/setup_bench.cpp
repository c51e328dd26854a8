// Measures the set-up of a scene of instances in each frame before its tree is built, without the commit (commit_ms)
// that all ways share. In a scene that is kept, set_up_shared/all gives Embree a new transform of every instance, and
// set_up_shared/hundredth finds the hundredth of them that moved. set_up_independent makes and releases each instance's
// record and Embree geometry. cull computes the angle of every instance. pose/t/k/r makes k poses of a plant of t
// triangles, whose trees are refit (0) or rebuilt (1); posing_ms is the part before Embree.
#include <benchmark/benchmark.h>

#include <chrono>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "rt/embree/top_level.h"
#include "rt/poses/angle_cull.h"
#include "rt/poses/foliage.h"

namespace sideray::rt {
namespace {

uint32_t opaque(const model::Material&, const model::Instance&) {
  return 1;
}

std::shared_ptr<const model::Mesh> plant(std::mt19937& random, uint32_t triangles) {
  std::uniform_real_distribution<float> place(-1.0f, 1.0f), size(-0.02f, 0.02f);
  auto mesh = std::make_shared<model::Mesh>();
  for (uint32_t i = 0; i < triangles; ++i) {
    const glm::vec3 center(place(random), 1.0f + place(random), place(random));
    for (int k = 0; k < 3; ++k) mesh->positions.push_back(center + glm::vec3(size(random), size(random), size(random)));
    mesh->triangles.emplace_back(3 * i, 3 * i + 1, 3 * i + 2);
  }
  for (const glm::vec3& p : mesh->positions) mesh->bounds.add(p);
  return mesh;
}

// Holds ten kinds of plants on a plain, about two units apart.
struct Field {
  DeviceHandle device = open_device("");
  model::Snapshot snapshot;
  MeshScenes meshes;
  std::mt19937 random{1};

  explicit Field(size_t count) {
    snapshot.materials.resize(1);
    for (int k = 0; k < 10; ++k) {
      snapshot.meshes.push_back(plant(random, 200));
      meshes[snapshot.meshes.back().get()] = build_mesh_scene(device.get(), snapshot.meshes.back());
    }
    std::uniform_real_distribution<float> place(0.0f, 2.0f * std::sqrt(static_cast<float>(count)));
    for (size_t i = 0; i < count; ++i) {
      model::Instance instance{};
      instance.mesh = static_cast<uint32_t>(i % 10);
      instance.local_from_object = glm::mat4x3(1.0f);
      instance.local_from_object[3] = {place(random), 0.0f, place(random)};
      snapshot.instances.push_back(instance);
    }
  }
  void move(size_t every, size_t frame) {
    for (size_t i = frame % every; i < snapshot.instances.size(); i += every)
      snapshot.instances[i].local_from_object[3].y += frame % 2 ? 0.01f : -0.01f;
  }
};

template <typename Work>
double seconds(const Work& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void set_up_shared(benchmark::State& state, size_t every) {
  Field field(static_cast<size_t>(state.range(0)));
  TopLevel top;
  top.set_up(field.device.get(), field.snapshot, field.meshes, {}, opaque);
  top.commit(field.device.get());
  double commit = 0.0;
  size_t frame = 0;
  for (auto _ : state) {
    field.move(every, ++frame);
    state.SetIterationTime(seconds([&] { top.set_up(field.device.get(), field.snapshot, field.meshes, {}, opaque); }));
    commit += seconds([&] { top.commit(field.device.get()); });
  }
  state.counters["commit_ms"] = 1e3 * commit / static_cast<double>(state.iterations());
  state.counters["changed"] = static_cast<double>(top.changes().changed);
}

void set_up_independent(benchmark::State& state) {
  Field field(static_cast<size_t>(state.range(0)));
  double commit = 0.0;
  size_t frame = 0;
  for (auto _ : state) {
    field.move(1, ++frame);
    auto top = std::make_unique<TopLevel>();
    const double made = seconds([&] { top->set_up(field.device.get(), field.snapshot, field.meshes, {}, opaque); });
    commit += seconds([&] { top->commit(field.device.get()); });
    state.SetIterationTime(made + seconds([&] { top.reset(); }));
  }
  state.counters["commit_ms"] = 1e3 * commit / static_cast<double>(state.iterations());
}

void cull(benchmark::State& state) {
  Field field(static_cast<size_t>(state.range(0)));
  for (model::Instance& i : field.snapshot.instances)
    i.bounds = {i.local_from_object[3] - glm::vec3(1.0f), i.local_from_object[3] + glm::vec3(1.0f)};
  Executor executor(0);
  AngleCull angle;
  float x = 0.0f;
  for (auto _ : state) benchmark::DoNotOptimize(angle.update(field.snapshot, 1.0f, {x += 0.01f, 2.0f, 0.0f}, executor));
}

// range(0): triangles of a plant; range(1): poses; range(2): 1 = every tree is rebuilt.
void pose(benchmark::State& state) {
  std::mt19937 random(2);
  auto snapshot = std::make_shared<model::Snapshot>();
  snapshot->meshes.push_back(plant(random, static_cast<uint32_t>(state.range(0))));
  snapshot->materials.resize(1);
  snapshot->winds.push_back({{.size = sizeof(sideray_wind_desc),
                              .direction = {1.0f, 0.0f, 0.0f},
                              .amplitude = 0.2f,
                              .frequency = 0.3f,
                              .height = 2.0f,
                              .branch_amplitude = 0.05f,
                              .branch_frequency = 0.8f,
                              .leaf_amplitude = 0.02f,
                              .leaf_frequency = 3.0f,
                              .wavelength = 0.7f}});
  for (int i = 0; i < state.range(1); ++i) {
    model::Instance instance{};
    instance.local_from_object = glm::mat4x3(1.0f);
    instance.wind = 1;
    instance.wind_phase = static_cast<float>(i) / static_cast<float>(state.range(1));
    snapshot->instances.push_back(instance);
  }
  Executor executor(0);
  Foliage foliage;
  const DeviceHandle device = open_device("");
  std::vector<std::shared_ptr<MeshScene>> scenes;
  const FoliageOptions options{.poses = SIDERAY_POSES_ALL};
  double posing = 0.0;
  for (auto _ : state) {
    snapshot->time_s += 1.0 / 30.0;
    std::shared_ptr<const model::Snapshot> posed;
    posing += seconds([&] { posed = foliage.pose(snapshot, options, executor); });
    std::vector<PosedMesh> changes(foliage.posed().begin(), foliage.posed().end());
    const bool first = scenes.empty();
    scenes.resize(changes.size());
    executor.run(changes.size(), [&](size_t i, uint32_t) {
      if (first) scenes[i] = build_mesh_scene(device.get(), changes[i]);
      if (state.range(2)) changes[i].change = PoseChange::rebuild;
      if (!first) move_mesh_scene(device.get(), *scenes[i], changes[i]);
    });
  }
  state.counters["posing_ms"] = 1e3 * posing / static_cast<double>(state.iterations());
}

BENCHMARK_CAPTURE(set_up_shared, all, 1)
    ->RangeMultiplier(10)
    ->Range(1000, 1000000)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(set_up_shared, hundredth, 100)
    ->RangeMultiplier(10)
    ->Range(1000, 1000000)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK(set_up_independent)
    ->RangeMultiplier(10)
    ->Range(1000, 1000000)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK(cull)->RangeMultiplier(10)->Range(1000, 1000000)->Unit(benchmark::kMillisecond);
BENCHMARK(pose)
    ->Args({10000, 1, 0})
    ->Args({10000, 1, 1})
    ->Args({96000, 1, 0})
    ->Args({96000, 1, 1})
    ->Args({10000, 64, 0})
    ->Args({10000, 64, 1})
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace sideray::rt
