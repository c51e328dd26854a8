// Tests that rasterizer and tracer see the same opaque surfaces, with depth within the bound of F8 over whole images.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "bridge/base/handles.h"
#include "frame/frame.h"
#include "gl/context/context.h"
#include "gl/rasterizer.h"
#include "rt/base/view_rays.h"
#include "scenes/builtin/builtin.h"
#include "scenes/images/images.h"

namespace sideray::tests {
namespace {

constexpr uint32_t width = 480, height = 270;

struct BothSides {
  model::Snapshot snapshot;
  gl::RasterView view;
  std::vector<float> depth;
  gl::Rasterizer::GBufferImages raster;
  rt::PrimaryImage rays;
  int subpixel_bits = 0;
};

BothSides draw(const scenes::Content& content) {
  Scene scene = Scene::create().value();
  scenes::fill(scene, content, std::vector<bool>(content.objects.size(), false));
  const auto snapshot = scene.get()->scene.snapshot();
  const auto context = gl::Context::create("auto", "");
  context->make_current();
  BothSides both{*snapshot, {}, {}, {}, {}, 0};
  {
    gl::Rasterizer rasterizer(context->functions());
    rasterizer.set_scene(snapshot);
    rasterizer.resize(width, height);
    both.view = rasterizer.make_view(camera_of(content, {.width = width, .height = height}), glm::vec2(0));
    rasterizer.set_view(both.view);
    rasterizer.gbuffer();
    both.depth = rasterizer.read_depth();
    both.raster = rasterizer.read_gbuffer();
    context->functions().GetIntegerv(GL_SUBPIXEL_BITS, &both.subpixel_bits);
  }
  context->release_current();
  rt::Tracer tracer({});
  tracer.set_scene(snapshot);
  both.rays = tracer.trace_primary(
      {both.view.clip_from_local, both.view.local_from_clip, both.view.reversed_depth, both.view.zero_to_one_depth},
      width, height);
  return both;
}

// Returns the distance along `ray` to the plane of the triangle in the pixel.
double plane_distance(const BothSides& both, glm::uvec2 ids, const rt::Ray& ray) {
  for (const model::Instance& instance : both.snapshot.instances) {
    if (instance.surface_id != ids.x) continue;
    const model::Mesh& mesh = *both.snapshot.meshes[instance.mesh];
    const glm::uvec3 t = mesh.triangles[ids.y - 1];
    const auto corner = [&](uint32_t v) {
      return glm::dvec3(instance.local_from_object * glm::vec4(mesh.positions[v], 1));
    };
    const glm::dvec3 p = corner(t.x), n = glm::cross(corner(t.y) - p, corner(t.z) - p);
    return glm::dot(p - glm::dvec3(ray.origin), n) / glm::dot(glm::dvec3(ray.direction), n);
  }
  return NAN;
}

// Returns half a step of reversed float depth (2^-24 of the distance) or of ordinary depth (z^2 / near 2^25).
double half_step(const BothSides& both, double distance) {
  const bool fine = both.view.reversed_depth && both.view.zero_to_one_depth;
  return fine ? distance * 0x1p-24 : distance * distance / (double{both.view.z_near} * 0x1p25);
}

// Writes pictures of both and of their difference to the folder SIDERAY_WRITE_PICTURES.
void write_pictures(const BothSides& both, const rt::ViewRays& rays, const std::string& name) {
  const char* folder = std::getenv("SIDERAY_WRITE_PICTURES");
  if (!folder) return;
  const auto byte = [](float x) { return static_cast<uint8_t>(std::clamp(x, 0.0f, 1.0f) * 255.0f); };
  const auto hashed = [](uint32_t id) {
    const uint32_t h = id * 2654435761u;
    return glm::vec3(h & 255u, h >> 8 & 255u, h >> 16 & 255u) / 255.0f;
  };
  const auto write = [&](const std::string& what, auto&& color) {
    std::vector<uint8_t> rgb;
    for (uint32_t row = height; row-- > 0;)
      for (uint32_t x = 0; x < width; ++x) {
        const glm::vec3 c = color(x, row, size_t{row} * width + x);
        rgb.insert(rgb.end(), {byte(c.x), byte(c.y), byte(c.z)});
      }
    scenes::write_png(std::string(folder) + "/" + name + "-" + what + ".png", width, height, rgb);
  };
  const auto raster_distance = [&](uint32_t x, uint32_t y, size_t i) {
    return rays.distance(x, y, double{both.depth[i]});
  };
  write("id-raster", [&](uint32_t, uint32_t, size_t i) { return hashed(both.raster.ids[i].x); });
  write("id-rays", [&](uint32_t, uint32_t, size_t i) { return hashed(both.rays.ids[i].x); });
  write("normal-raster", [&](uint32_t, uint32_t, size_t i) {
    return both.raster.ids[i].x ? 0.5f + 0.5f * glm::vec3(both.raster.normal_roughness[i]) : glm::vec3(0);
  });
  write("normal-rays", [&](uint32_t, uint32_t, size_t i) {
    return both.rays.ids[i].x ? 0.5f + 0.5f * both.rays.normal[i] : glm::vec3(0);
  });
  write("depth-raster", [&](uint32_t x, uint32_t y, size_t i) {
    return both.raster.ids[i].x ? glm::vec3(static_cast<float>(std::fmod(raster_distance(x, y, i), 1.0)))
                                : glm::vec3(0);
  });
  write("depth-rays", [&](uint32_t, uint32_t, size_t i) {
    return both.rays.ids[i].x ? glm::vec3(std::fmod(both.rays.distance[i], 1.0f)) : glm::vec3(0);
  });
  // Red: another surface; green: relative difference of distance, white level 1e-5.
  write("difference", [&](uint32_t x, uint32_t y, size_t i) {
    if (both.raster.ids[i].x != both.rays.ids[i].x) return glm::vec3(1, 0, 0);
    if (both.raster.ids[i].x == 0) return glm::vec3(0);
    const double traced = double{both.rays.distance[i]};
    return glm::vec3(0, static_cast<float>(std::abs(raster_distance(x, y, i) - traced) / traced * 1e5), 0);
  });
}

void expect_agreement(const scenes::Content& content, const std::string& name) {
  const BothSides both = draw(content);
  const rt::ViewRays rays(
      {both.view.clip_from_local, both.view.local_from_clip, both.view.reversed_depth, both.view.zero_to_one_depth},
      width, height);
  write_pictures(both, rays, name);
  size_t shown = 0, same_surface = 0, compared = 0, violations = 0;
  for (uint32_t y = 1; y + 1 < height; ++y)
    for (uint32_t x = 1; x + 1 < width; ++x) {
      const size_t i = size_t{y} * width + x;
      const glm::uvec2 ids = both.raster.ids[i];
      shown += ids.x != 0;
      same_surface += ids.x != 0 && ids.x == both.rays.ids[i].x;
      if (ids.x == 0 || ids != both.rays.ids[i]) continue;
      const double traced = double{both.rays.distance[i]};
      const double slope = std::abs(plane_distance(both, ids, rays.ray(x + 1, y)) - traced) +
                           std::abs(plane_distance(both, ids, rays.ray(x, y + 1)) - traced);
      const double bound = half_step(both, traced) + slope * std::exp2(-both.subpixel_bits) + traced * 0x1p-21;
      const double off = std::abs(rays.distance(x, y, double{both.depth[i]}) - traced);
      ++compared;
      violations += off > bound;
    }
  ASSERT_GT(shown, width * height / 20u);
  EXPECT_GE(static_cast<double>(same_surface) / static_cast<double>(shown), 0.995);
  EXPECT_EQ(violations, 0u) << "of " << compared;
  EXPECT_GT(compared, shown * 9 / 10);
}

TEST(DepthAgreement, OnTheEmptyScene) {
  expect_agreement(scenes::generate("empty", {}), "empty");
}

TEST(DepthAgreement, OnATruck) {
  SIDERAY_ASSET_OR_SKIP(path, "CesiumMilkTruck/CesiumMilkTruck.glb");
  expect_agreement(scenes::load(path), "truck");
}

TEST(DepthAgreement, OnALodge) {
  SIDERAY_ASSET_OR_SKIP(path, "Lodge/Lodge.glb");
  expect_agreement(scenes::load(path), "lodge");
}

}  // namespace
}  // namespace sideray::tests
