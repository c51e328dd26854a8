// Compares what glass shows with what the picture shows without it: behind a pane that bends almost nothing, surfaces
// have the same bounced light, without noise of their own.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <iterator>
#include <sideray/sideray.hpp>
#include <string>
#include <utility>
#include <vector>

namespace sideray::tests::light_behind_glass_test {
namespace {

constexpr uint32_t width = 96, height = 64;

struct Rectangle {
  float corner[3], across[3], up[3];
};
constexpr Rectangle ground{{-6, 0, -6}, {0, 0, 12}, {12, 0, 0}}, wall{{-6, 0, -2}, {12, 0, 0}, {0, 6, 0}},
    side_wall{{-2, 0, -6}, {0, 6, 0}, {0, 0, 12}},
    pane{{-3, -3, 3.0f}, {6, 0, 0}, {0, 6, 0}}, back_of_pane{{-3, -3, 2.9f}, {0, 6, 0}, {6, 0, 0}};

void add(Scene& scene, std::initializer_list<Rectangle> rectangles, const sideray_material_desc& material, uint32_t id) {
  std::vector<float> positions;
  std::vector<uint32_t> indices;
  for (const Rectangle& r : rectangles) {
    const auto first = static_cast<uint32_t>(positions.size() / 3);
    for (const uint32_t corner : {0u, 1u, 2u, 0u, 2u, 3u}) indices.push_back(first + corner);
    for (const auto& [along, high] : {std::pair(0.0f, 0.0f), {1.0f, 0.0f}, {1.0f, 1.0f}, {0.0f, 1.0f}})
      for (int i = 0; i < 3; ++i) positions.push_back(r.corner[i] + along * r.across[i] + high * r.up[i]);
  }
  sideray_mesh_desc mesh = sideray_mesh_defaults();
  mesh.vertex_count = static_cast<uint32_t>(positions.size() / 3);
  mesh.positions.data = positions.data();
  mesh.index_count = static_cast<uint32_t>(indices.size());
  mesh.indices = indices.data();
  sideray_instance_desc instance{};
  instance.mesh = scene.add_mesh(mesh);
  instance.material = scene.add_material(material);
  for (const int i : {0, 4, 8}) instance.world_from_object[i] = 1;
  instance.visibility = SIDERAY_VISIBLE_ALL;
  instance.surface_id = id;
  scene.add_instances({&instance, 1});
}

sideray_material_desc matt(float red, float green, float blue) {
  sideray_material_desc m = sideray_material_defaults();
  m.double_sided = 1;
  m.specular = 0;
  m.base_color[0] = red, m.base_color[1] = green, m.base_color[2] = blue;
  return m;
}

sideray_material_desc thin_air() {
  sideray_material_desc m = sideray_material_defaults();
  m.transmission = 1;
  m.roughness = 0;
  m.ior = 1.001f;
  m.thickness = 0.1f;
  m.double_sided = 1;
  return m;
}

// Draws a corner of a room open to the sky, on request through a pane before the whole picture.
std::vector<float> draw(Renderer& renderer, bool through_pane) {
  Scene scene = Scene::create().value();
  add(scene, {ground}, matt(0.8f, 0.8f, 0.8f), 1);
  add(scene, {wall}, matt(0.8f, 0.2f, 0.1f), 2);
  add(scene, {side_wall}, matt(0.1f, 0.3f, 0.8f), 3);
  if (through_pane) add(scene, {pane, back_of_pane}, thin_air(), 4);
  const std::vector<float> sky(3 * 8 * 4, 1.0f);
  scene.set_environment(8, 4, sky.data(), 1.0f, 0.0f);
  scene.commit();
  sideray_camera camera = sideray_camera_defaults();
  const double pose[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 1.2, 3.5};
  std::copy(std::begin(pose), std::end(pose), camera.world_from_camera);
  RenderOptions options;
  options.picture.width = width, options.picture.height = height;
  const Picture picture = renderer.render(scene, camera, options).value();
  std::vector<float> rgb;
  for (size_t i = 0; i < picture.channel_count(); ++i) {
    const sideray_channel channel = picture.channel(i);
    const std::string name = channel.name;
    if (name != "R" && name != "G" && name != "B") continue;
    const auto* values = static_cast<const float*>(channel.values);
    rgb.insert(rgb.end(), values, values + size_t{width} * height);
  }
  return rgb;
}

TEST(LightBehindGlass, IsThatOfThePixelsThatShowIt) {
  for (const char* gl : {"none", "auto"}) {
    sideray_renderer_desc desc = sideray_renderer_defaults();
    desc.gl = gl;
    Renderer renderer = Renderer::create(desc).value();
    const std::vector<float> without = draw(renderer, false), with = draw(renderer, true);
    ASSERT_EQ(with.size(), 3u * width * height);
    double sum = 0.0, apart = 0.0;
    size_t far = 0;
    for (size_t i = 0; i < with.size(); ++i) {
      const auto difference = static_cast<double>(std::abs(with[i] - without[i]));
      sum += static_cast<double>(without[i]);
      apart += difference;
      far += difference > 0.05 * static_cast<double>(without[i]);
    }
    EXPECT_GT(sum / static_cast<double>(with.size()), 0.1) << gl << ": the room is lit";
    EXPECT_LT(apart, 0.01 * sum) << gl;
    EXPECT_LT(far, with.size() / 50) << gl << ": of " << with.size() << " values, at edges";
  }
}

}  // namespace
}  // namespace sideray::tests::light_behind_glass_test
