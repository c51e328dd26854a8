// Hosts that were compiled with other versions of a shading point and its result get the same picture.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstring>

#include "rt/shading/host_shader_scene.h"

namespace sideray::rt {
namespace {

using namespace test;

// Arrays as the host has them: elements of so many bytes each.
struct OtherVersion {
  size_t point_bytes, result_bytes;
  bool unknown_is_zero = true;

  static void call(void* user, const Point* points, size_t count, Result* results) {
    auto& version = *static_cast<OtherVersion*>(user);
    const auto* point_bytes = reinterpret_cast<const std::byte*>(points);
    auto* result_bytes = reinterpret_cast<std::byte*>(results);
    for (size_t i = 0; i < count; ++i) {
      Point point{};
      Result result{};
      std::memcpy(static_cast<void*>(&point), point_bytes + i * version.point_bytes,
                  std::min(version.point_bytes, sizeof(point)));
      for (size_t k = sizeof(point); k < version.point_bytes; ++k)
        version.unknown_is_zero &= point_bytes[i * version.point_bytes + k] == std::byte{0};
      std::byte* at = result_bytes + i * version.result_bytes;
      const size_t known = std::min(version.result_bytes, sizeof(result));
      std::memcpy(static_cast<void*>(&result), at, known);
      set(result.radiance, vec3(point.normal) * 0.5f + 0.5f + 0.001f * static_cast<float>(point.position[0]));
      set(result.reflectance, glm::vec3(0.25f));
      std::memcpy(at, &result, known);
    }
  }
};

LayerCache cache_with(size_t point_bytes, size_t result_bytes) {
  TestScene scene;
  scene.quad({0, 0, -3}, {1, 0, 0.5f}, {0, 1, 0}, blended({1, 1, 1}, 0.5f));
  scene.quad({0.5f, 0, -4}, {1, 0, 0}, {0, 1, 0.25f}, blended({1, 1, 1}, 0.5f));
  scene.quad({0, 0, 3}, {9, 0, 0}, {0, 9, 0}, glowing({1, 2, 3}));
  scene.environment({0.5f, 0.25f, 0.125f});
  OtherVersion version{point_bytes, result_bytes};
  sideray_shader_desc desc{};
  desc.shade = OtherVersion::call;
  desc.user = &version;
  desc.radiance_scale = 1.0f;
  desc.point_stride_bytes = point_bytes;
  desc.result_stride_bytes = result_bytes;
  scene.scene.set_shader(&desc);
  Tracer tracer({.threads = 2, .isa = ""});
  tracer.set_scene(scene.commit());
  TestFrame frame = frame_of(2);
  LayerCache cache;
  tracer.trace_cache(frame.get(), cache);
  EXPECT_TRUE(version.unknown_is_zero);
  return cache;
}

TEST(HostShaderStrides, OlderAndNewerHostsGetTheSamePicture) {
  const LayerCache own = cache_with(sizeof(Point), sizeof(Result));
  ASSERT_TRUE(std::any_of(own.distance.begin(), own.distance.end(), [](float d) { return d > 0.0f; }));
  for (const size_t point_bytes : {offsetof(Point, user), sizeof(Point) + 24})
    for (const size_t result_bytes : {offsetof(Result, reflection), sizeof(Result) + 8}) {
      const LayerCache other = cache_with(point_bytes, result_bytes);
      EXPECT_EQ(other.radiance, own.radiance) << point_bytes << " and " << result_bytes;
      EXPECT_EQ(other.surface_id, own.surface_id);
    }
}

}  // namespace
}  // namespace sideray::rt
