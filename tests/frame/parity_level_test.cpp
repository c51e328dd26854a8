// Compares the mip levels of a view's rays with those of the driver, over whole pictures.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>

#include "bridge/base/handles.h"
#include "frame/frame.h"
#include "gl/context/context.h"
#include "gl/rasterizer.h"
#include "rt/base/view_rays.h"
#include "rt/embree/intersector.h"
#include "rt/surfaces/surface.h"
#include "scenes/builtin/builtin.h"
#include "scenes/content/shapes.h"

namespace sideray::tests::parity_level_test {
namespace {

constexpr uint32_t width = 320, height = 180;
constexpr int codes_per_level = 16;

// Returns a texture of the size of `source` whose level k has the colour 16 k, so that lookups return the level.
std::shared_ptr<const model::Texture> level_scale(const model::Texture& source) {
  auto texture = std::make_shared<model::Texture>();
  for (size_t k = 0; k < source.levels.size(); ++k) {
    const model::Texture::Level& level = source.levels[k];
    const auto code = static_cast<uint8_t>(std::min<size_t>(codes_per_level * k, 255));
    std::vector<uint8_t> rgba(level.rgba.size(), code);
    texture->levels.push_back({level.width, level.height, std::move(rgba)});
  }
  return texture;
}

// Returns the scene with such base colour textures; a material without a texture shows level 0.
std::shared_ptr<const model::Snapshot> with_level_scales(const model::Snapshot& source) {
  auto snapshot = std::make_shared<model::Snapshot>(source);
  for (auto& texture : snapshot->textures) texture = level_scale(*texture);
  for (model::Material& m : snapshot->materials) {
    const sideray_texture_slot slot = m.desc.base_color_texture;
    m.desc = sideray_material_defaults();
    m.desc.double_sided = !m.cull_back;
    m.desc.base_color_texture = slot;
    m.desc.base_color_texture.filter = SIDERAY_TRILINEAR;
    m.translucent = m.discards = m.traceable = false;
  }
  return snapshot;
}

float level_of(float albedo) {
  return albedo * 255.0f / codes_per_level;
}

struct Levels {
  gl::RasterView view;
  std::vector<glm::vec4> albedo;
  std::vector<glm::uvec2> ids;
};

Levels draw(const std::shared_ptr<const model::Snapshot>& snapshot, const sideray_camera& camera) {
  const auto context = gl::Context::create("auto", "");
  context->make_current();
  Levels levels;
  {
    gl::Rasterizer rasterizer(context->functions());
    rasterizer.set_scene(snapshot);
    rasterizer.resize(width, height);
    levels.view = rasterizer.make_view(camera, glm::vec2(0));
    rasterizer.set_view(levels.view);
    rasterizer.gbuffer();
    gl::Rasterizer::GBufferImages images = rasterizer.read_gbuffer();
    levels.albedo = std::move(images.albedo_metallic), levels.ids = std::move(images.ids);
  }
  context->release_current();
  return levels;
}

// Returns the differences, tracer minus driver, in pixels that show the same triangle and where either minifies.
std::vector<float> differences(const scenes::Content& content, const sideray_camera& camera) {
  Scene scene = Scene::create().value();
  scenes::fill(scene, content, std::vector<bool>(content.objects.size(), false));
  const auto snapshot = with_level_scales(*scene.get()->scene.snapshot());
  const Levels raster = draw(snapshot, camera);
  const rt::ViewRays rays({raster.view.clip_from_local, raster.view.local_from_clip, raster.view.reversed_depth,
                           raster.view.zero_to_one_depth},
                          width, height);
  const rt::ShadingScene shading(snapshot);
  rt::Intersector intersector("");
  intersector.set_scene(snapshot);
  std::vector<float> found;
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) {
      const size_t i = size_t{y} * width + x;
      const rt::Ray ray = rays.ray(x, y);
      rt::Hit hit{};
      intersector.nearest_opaque({&ray, 1}, {}, &hit);
      if (raster.ids[i].x == 0 || hit.instance == rt::no_instance || hit.primitive + 1 != raster.ids[i].y ||
          snapshot->instances[hit.instance].surface_id != raster.ids[i].x)
        continue;
      const sideray_texture_slot& slot =
          snapshot->materials[snapshot->instances[hit.instance].material].desc.base_color_texture;
      if (slot.texture == 0) continue;
      const auto last = static_cast<float>(snapshot->textures[slot.texture - 1]->levels.size() - 1);
      const float by_raster = level_of(raster.albedo[i].x);
      const float by_rays = level_of(rt::surface_point(shading, hit, ray, rays.cone(x, y), &rays.steps()).surface.albedo.x);
      // Levels that are both clamped agree trivially.
      if (std::max(by_raster, by_rays) > 0.0f && std::min(by_raster, by_rays) < last)
        found.push_back(by_rays - by_raster);
    }
  return found;
}

void expect_levels_alike(std::vector<float> found, const char* name) {
  ASSERT_GT(found.size(), size_t{width} * height / 50) << name;
  std::vector<float> sizes;
  for (const float d : found) sizes.push_back(std::abs(d));
  std::sort(sizes.begin(), sizes.end());
  std::sort(found.begin(), found.end());
  const auto at = [](const std::vector<float>& v, double share) {
    return v[static_cast<size_t>(share * static_cast<double>(v.size() - 1))];
  };
  std::cout << "  " << name << ": " << found.size() << " pixels, |difference| median " << at(sizes, 0.5)
            << ", 99 % within " << at(sizes, 0.99) << ", largest " << sizes.back() << "; signed median "
            << at(found, 0.5) << "\n";
  EXPECT_LE(at(sizes, 0.5), 0.1f) << name;
  EXPECT_LE(at(sizes, 0.99), 0.25f) << name;
}

// Returns boxes on a floor to the horizon, whose chequer is turned by `turn`.
scenes::Content floor_and_boxes(float turn) {
  scenes::ContentBuilder builder("floor");
  sideray_material_desc d = scenes::opaque_material(glm::vec3(1), 1);
  d.base_color_texture.texture = builder.checker("tiles", {255, 255, 255}, {0, 0, 0}, 32);
  const float c = std::cos(turn), s = std::sin(turn), m[6] = {c, -s, s, c, 0, 0};
  std::copy_n(m, 6, d.base_color_texture.texture_from_uv);
  const uint32_t material = builder.material("tiles", d);
  builder.object(
      "floor",
      builder.mesh(scenes::Shape().quad({-60, 0, 60}, {60, 0, 60}, {60, 0, -60}, {-60, 0, -60}, glm::vec2(120)),
                   "floor"),
      material);
  const uint32_t box = builder.mesh(scenes::Shape().box({-1, 0, -1}, {1, 2, 1}, 2.0f), "box");
  for (int i = 0; i < 6; ++i) builder.object("box", box, material, {5.0 * (i % 3) - 5, 0, -8.0 * (i / 3)}, 25.0 * i);
  return builder.take();
}

TEST(ParityLevel, OnAFloorSeenAtManyAngles) {
  for (const float turn : {0.0f, 0.5f}) {
    const scenes::Content content = floor_and_boxes(turn);
    sideray_camera camera = scenes::framing_camera(content, 16.0f / 9.0f);
    // Low over the floor, so that it runs from under the eye to grazing.
    const double world_from_camera[12] = {1, 0, 0, 0, 0.98, -0.199, 0, 0.199, 0.98, 0.3, 2, 9};
    std::copy_n(world_from_camera, 12, camera.world_from_camera);
    camera.z_near = 0.1f;
    expect_levels_alike(differences(content, camera), turn == 0.0f ? "floor" : "floor, texture turned");
  }
}

TEST(ParityLevel, OnRealAssets) {
  for (const char* name :
       {"CesiumMilkTruck/CesiumMilkTruck.glb", "Lodge/Lodge.glb", "Sofa03/Sofa03.gltf", "TeaSet/TeaSet.gltf"}) {
    const std::string path = asset(name);
    if (path.empty()) continue;
    const scenes::Content content = scenes::load(path);
    expect_levels_alike(differences(content, camera_of(content, {.width = width, .height = height})), name);
  }
}

}  // namespace
}  // namespace sideray::tests::parity_level_test
