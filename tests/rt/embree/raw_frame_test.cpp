#include "rt/embree/raw_frame.h"

#include <gtest/gtest.h>

#include <vector>

#include "rt/base/view_rays.h"
#include "rt/tracer.h"
#include "rt/tracer_scene.h"

namespace sideray::rt::test::raw_frame_test {
namespace {

constexpr uint32_t width = 64, height = 36;

TraceView view_of(const glm::dmat4& clip_from_local) {
  TraceView view;
  view.clip_from_local = clip_from_local;
  view.local_from_clip = glm::inverse(clip_from_local);
  return view;
}

// Shared meshes at places of their own, opaque and translucent; some are in the picture.
void fill(TestScene& s) {
  const std::vector<glm::vec3> positions{{-1, -1, 0}, {1, -1, 0}, {0, 1, 0.2f}};
  const std::vector<glm::vec2> uv(3, glm::vec2(0));
  for (int i = 0; i < 6; ++i) {
    const glm::dmat4 place = glm::rotate(
        glm::translate(glm::dmat4(1.0), glm::dvec3(1.3 * i - 3.0, 0.4 * (i % 3), -5.0 - i)), 0.3 * i, glm::dvec3(1, 2, 3));
    s.add(positions, uv, {0, 1, 2}, i % 2 == 0 ? plain_material() : glass(), place);
  }
}

// Every ray of the frame that meets a surface, by the tracer itself.
uint64_t hits_of_tracer(Tracer& tracer, const TraceView& view) {
  const ViewRays rays(view, width, height);
  std::vector<sideray_ray> batch;
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) {
      const Ray r = rays.ray(x, y);
      sideray_ray out{};
      for (int c = 0; c < 3; ++c) out.origin[c] = double{r.origin[c]}, out.direction[c] = r.direction[c];
      out.t_far = 1e30f;
      batch.push_back(out);
    }
  std::vector<sideray_hit> opaque(batch.size()), translucent(batch.size());
  tracer.trace_rays(SIDERAY_RAYS_OPAQUE, batch, 1, opaque.data());
  tracer.trace_rays(SIDERAY_RAYS_TRANSLUCENT, batch, 1, translucent.data());
  uint64_t hits = 0;
  for (size_t i = 0; i < batch.size(); ++i) hits += opaque[i].surface_id != 0 || translucent[i].surface_id != 0;
  return hits;
}

TEST(RawFrame, RaysMeetWhatTheTracersMeetInFlatAndInstancedScenes) {
  TestScene s;
  fill(s);
  Tracer tracer({.threads = 2, .isa = ""});
  tracer.set_scene(s.commit());
  const glm::dmat4 perspective = glm::perspective(0.9, double{width} / height, 0.1, 100.0);
  const glm::dmat4 parallel = glm::ortho(-4.0, 4.0, -2.25, 2.25, 0.0, 100.0);
  for (const glm::dmat4& clip : {perspective, parallel}) {
    const TraceView view = view_of(clip);
    const uint64_t expected = hits_of_tracer(tracer, view);
    ASSERT_GT(expected, 100u);
    for (const uint64_t most_flat : {uint64_t{0}, uint64_t{1000}}) {
      const RawFrame raw = tracer.time_raw_frame(
          {.view = view, .width = width, .height = height, .repeats = 2, .most_flat = most_flat});
      EXPECT_GT(raw.ms, 0.0);
      EXPECT_EQ(raw.triangles, 6u);
      EXPECT_EQ(raw.flat, most_flat != 0);
      // Rays in floats may pass an edge on its other side.
      EXPECT_NEAR(static_cast<double>(raw.hits), static_cast<double>(expected), 2.0);
    }
  }
}

TEST(RawFrame, SizesThatAreNoMultiplesOfAPacketAndScenesWithoutTriangles) {
  TestScene s;
  Tracer tracer({.threads = 1, .isa = ""});
  tracer.set_scene(s.commit());
  const TraceView view = view_of(glm::perspective(0.9, 1.0, 0.1, 100.0));
  for (const uint64_t most_flat : {uint64_t{0}, uint64_t{1000}}) {
    const RawFrame raw = tracer.time_raw_frame({.view = view, .width = 5, .height = 1, .most_flat = most_flat});
    EXPECT_EQ(raw.triangles, 0u);
    EXPECT_EQ(raw.hits, 0u);
  }
}

}  // namespace
}  // namespace sideray::rt::test::raw_frame_test
