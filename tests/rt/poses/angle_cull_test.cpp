// Compares culling by apparent size with the rule itself, and tests what the tracer then hits.
#include "rt/poses/angle_cull.h"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "rt/tracer_scene.h"

namespace sideray::rt::test {
namespace {

double full_angle(const model::Instance& instance, glm::vec3 eye) {
  const double radius = glm::length(glm::dvec3(instance.bounds.maximum) - glm::dvec3(instance.bounds.minimum)) / 2;
  const double distance =
      glm::length((glm::dvec3(instance.bounds.maximum) + glm::dvec3(instance.bounds.minimum)) / 2.0 - glm::dvec3(eye));
  return radius >= distance ? 360.0 : 2.0 * std::asin(radius / distance) * 180.0 / std::numbers::pi;
}

model::Snapshot random_boxes(size_t count) {
  std::mt19937 random(23);
  std::uniform_real_distribution<float> place(-100.0f, 100.0f), size(0.01f, 3.0f);
  model::Snapshot snapshot;
  snapshot.instances.resize(count);
  for (model::Instance& i : snapshot.instances) {
    const glm::vec3 center(place(random), place(random), place(random)), half(size(random), size(random), size(random));
    i.bounds = {center - half, center + half};
  }
  return snapshot;
}

TEST(AngleCull, FollowsTheAngleOfTheSphereFromAnyEye) {
  const model::Snapshot snapshot = random_boxes(20000);
  Executor executor(2);
  for (const float angle : {0.5f, 1.0f, 2.0f, 4.0f, 30.0f})
    for (const glm::vec3 eye : {glm::vec3(0.0f), glm::vec3(90.0f, -20.0f, 5.0f)}) {
      AngleCull cull;
      cull.update(snapshot, angle, eye, executor);
      size_t culled = 0;
      for (size_t i = 0; i < snapshot.instances.size(); ++i) {
        const double seen = full_angle(snapshot.instances[i], eye);
        culled += cull.culled()[i];
        if (std::abs(seen / double{angle} - 1.0) > 1e-5) {
          ASSERT_EQ(cull.culled()[i] != 0, seen < double{angle}) << i << ' ' << seen;
        }
      }
      EXPECT_GT(culled, 0u);
      EXPECT_LT(culled, snapshot.instances.size());
    }
}

TEST(AngleCull, KeepsWhatTheEyeIsInsideOfAndWhatHasNoBounds) {
  model::Snapshot snapshot;
  snapshot.instances.resize(2);
  snapshot.instances[0].bounds = {glm::vec3(-1.0f), glm::vec3(1.0f)};
  Executor executor(1);
  AngleCull cull;
  EXPECT_FALSE(cull.update(snapshot, 179.0f, glm::vec3(0.9f), executor));
  EXPECT_TRUE(cull.update(snapshot, 179.0f, glm::vec3(3.0f), executor));
  EXPECT_EQ(cull.culled(), (std::vector<uint8_t>{1, 0}));
  EXPECT_TRUE(cull.update(snapshot, 0.0f, glm::vec3(3.0f), executor));
  EXPECT_TRUE(cull.culled().empty());
}

TEST(AngleCull, ComesBackAboveTheAngleItLeftAt) {
  model::Snapshot snapshot;
  snapshot.instances.resize(1);
  snapshot.instances[0].bounds = {glm::vec3(-1.0f), glm::vec3(1.0f)};
  Executor executor(1);
  AngleCull cull;
  const auto from_angle = [&](double degrees) {
    const double distance = std::sqrt(3.0) / std::sin(degrees * std::numbers::pi / 360.0);
    cull.update(snapshot, 2.0f, glm::vec3(0.0f, 0.0f, static_cast<float>(distance)), executor);
    return cull.culled()[0] != 0;
  };
  EXPECT_FALSE(from_angle(2.01));
  EXPECT_TRUE(from_angle(1.99));
  EXPECT_TRUE(from_angle(2.01));
  EXPECT_TRUE(from_angle(2.19));
  EXPECT_FALSE(from_angle(2.21));
  EXPECT_FALSE(from_angle(2.01));
}

TEST(AngleCull, ForgetsAndSparesAsItIsTold) {
  model::Snapshot snapshot;
  snapshot.instances.resize(2);
  snapshot.materials.resize(2);
  snapshot.materials[1].translucent = true;
  snapshot.instances[1].material = 1;
  for (model::Instance& i : snapshot.instances) i.bounds = {glm::vec3(-1.0f), glm::vec3(1.0f)};
  const auto eye = [](double degrees) {
    return glm::vec3(0.0f, 0.0f, static_cast<float>(std::sqrt(3.0) / std::sin(degrees * std::numbers::pi / 360.0)));
  };
  Executor executor(1);
  AngleCull cull;
  cull.update(snapshot, 2.0f, eye(1.9), executor);
  EXPECT_EQ(cull.culled(), (std::vector<uint8_t>{1, 1}));
  EXPECT_FALSE(cull.update(snapshot, 2.0f, eye(2.1), executor));
  EXPECT_TRUE(cull.update(snapshot, 2.0f, eye(2.1), executor, {.keeps_translucent = false, .remembers = false}));
  EXPECT_EQ(cull.culled(), (std::vector<uint8_t>{0, 0}));
  cull.update(snapshot, 2.0f, eye(1.9), executor, {.keeps_translucent = true, .remembers = true});
  EXPECT_EQ(cull.culled(), (std::vector<uint8_t>{1, 0}));
}

TEST(AngleCull, AnyNumberOfThreadsCullsTheSame) {
  const model::Snapshot snapshot = random_boxes(30000);
  Executor one(1), two(2);
  AngleCull a, b;
  for (const float x : {0.0f, 5.0f, 10.0f, 4.0f}) {
    EXPECT_EQ(a.update(snapshot, 2.0f, glm::vec3(x), one), b.update(snapshot, 2.0f, glm::vec3(x), two));
    EXPECT_EQ(a.culled(), b.culled());
  }
}

sideray_ray ray_down(float x) {
  sideray_ray ray{};
  ray.origin[0] = x, ray.origin[1] = 1.0f;
  ray.direction[1] = -1.0f;
  ray.t_far = INFINITY;
  return ray;
}

// Three opaque squares along x, met from above one by one.
class TracerFoliage : public ::testing::Test {
 protected:
  TracerFoliage() {
    for (const float x : {0.0f, 50.0f, 100.0f}) scene_.quad({x, 0, 0}, {0, 0, 0.5f}, {0.5f, 0, 0}, plain_material());
    snapshot_ = scene_.commit();
  }
  std::vector<bool> met() {
    const std::vector<sideray_ray> rays{ray_down(0.0f), ray_down(50.0f), ray_down(100.0f)};
    std::vector<sideray_hit> hits(3);
    tracer_.trace_rays(SIDERAY_RAYS_OPAQUE, rays, 1, hits.data());
    std::vector<bool> result;
    for (const sideray_hit& hit : hits) result.push_back(hit.surface_id != 0);
    return result;
  }
  TestScene scene_;
  std::shared_ptr<const model::Snapshot> snapshot_;
  Tracer tracer_{{.threads = 2, .isa = ""}};
};

TEST_F(TracerFoliage, CulledInstancesLeaveTheTraceAndComeBack) {
  tracer_.set_scene(snapshot_);
  EXPECT_TRUE(tracer_.culled().empty());
  EXPECT_EQ(met(), (std::vector{true, true, true}));
  FoliageOptions options{.cull_angle_deg = 2.0f, .eye = {0, 1, 0}, .cull = {}};
  tracer_.set_foliage(options);
  EXPECT_EQ(met(), (std::vector{true, false, false}));
  EXPECT_EQ(tracer_.culled(), (std::vector<uint8_t>{0, 1, 1}));
  options.eye = {100, 1, 0};
  tracer_.set_foliage(options);
  EXPECT_EQ(tracer_.culled(), (std::vector<uint8_t>{1, 1, 0}));
  EXPECT_EQ(met(), (std::vector{false, false, true}));
  options.cull_angle_deg = 0.0f;
  tracer_.set_foliage(options);
  EXPECT_EQ(met(), (std::vector{true, true, true}));
}

TEST_F(TracerFoliage, TheNextSceneIsKeptUpWithByItsChangesAlone) {
  tracer_.set_scene(snapshot_);
  auto moved = std::make_shared<model::Snapshot>(*snapshot_);
  moved->instances[1].local_from_object[3].x += 7.0f;
  moved->instances[0].visibility = 0;
  tracer_.set_scene(moved);
  EXPECT_EQ(met(), (std::vector{false, false, true}));  // these rays ask for what reflections see
  auto fewer = std::make_shared<model::Snapshot>(*snapshot_);
  fewer->instances.pop_back();
  tracer_.set_scene(fewer);
  EXPECT_EQ(met(), (std::vector{true, true, false}));
  auto swapped = std::make_shared<model::Snapshot>(*snapshot_);
  std::swap(swapped->instances[0], swapped->instances[2]);
  swapped->instances.erase(swapped->instances.begin() + 1);
  tracer_.set_scene(swapped);
  EXPECT_EQ(met(), (std::vector{true, false, true}));
}

}  // namespace
}  // namespace sideray::rt::test
