// Tests the rays that a layer threshold skips: the change of each pixel against what the threshold promises.
#include <algorithm>
#include <cmath>

#include "lab/stress/stress_scene.h"

namespace sideray::lab {
namespace {

constexpr uint32_t panes = 6;
// This bounds the rounding of halfs, in the cache and at each of as many blends as there are panes.
constexpr double rounding = static_cast<double>(panes + 2) / 1024.0;

struct Glass {
  const char* name;
  float alpha, transmission, roughness;
};
constexpr std::array<Glass, 4> glasses{{{"faint", 0.05f, 0.0f, 0.04f},
                                        {"half", 0.5f, 0.0f, 0.3f},
                                        {"nearly opaque", 0.95f, 0.0f, 0.04f},
                                        {"tinted", 1.0f, 1.0f, 0.04f}}};

struct Order {
  const char* variant;
  sideray_translucency translucency;
  sideray_oit oit;
};
constexpr std::array<Order, 3> orders{
    {{"--oit sorted", SIDERAY_TRANSLUCENCY_HYBRID, SIDERAY_OIT_SORTED},
     {"--oit peel", SIDERAY_TRANSLUCENCY_HYBRID, SIDERAY_OIT_PEEL},
     {"--translucency raytraced", SIDERAY_TRANSLUCENCY_RAYTRACED, SIDERAY_OIT_SORTED}}};

sideray_material_desc glass_of(const Glass& glass, uint32_t pane) {
  sideray_material_desc m = sideray_material_defaults();
  m.alpha_mode = glass.transmission > 0.0f ? SIDERAY_OPAQUE : SIDERAY_BLEND;
  m.transmission = glass.transmission;
  m.roughness = glass.roughness;
  m.double_sided = 1;
  m.base_color[pane % 3] = 0.3f;
  m.base_color[3] = glass.alpha;
  return m;
}

sideray_light lamp(double x, double y, double z, float intensity) {
  sideray_light light{};
  light.size = sizeof(light);
  light.type = SIDERAY_LIGHT_POINT;
  light.position[0] = x, light.position[1] = y, light.position[2] = z;
  for (float& channel : light.intensity) channel = intensity;
  return light;
}

// Places panes before a wall, turned so that they cross: where they do, objects are drawn in another order than rays
// hit them. Posts and the wall keep some of the light from each pane.
Scene scene_of(const Glass& glass) {
  Scene scene = Scene::create().value();
  for (uint32_t i = 0; i < panes; ++i) {
    Pane pane = pane_across(3.0 + 0.3 * i);
    for (glm::dvec3& corner : pane.corners) corner.z += 0.1 * (i % 3 - 1.0) * corner.x;
    add_quad(scene, pane, glass_of(glass, i), i + 1);
  }
  sideray_material_desc grey = sideray_material_defaults();
  grey.double_sided = 1;
  add_quad(scene, pane_across(12.0), grey, panes + 1);
  for (uint32_t i = 0; i < 5; ++i) {
    const double x = -2.0 + i, z = -2.5;
    add_quad(scene, {{{{x, 1.5, z}, {x + 0.3, 1.5, z}, {x + 0.3, 4.0, z}, {x, 4.0, z}}}}, grey, panes + 2 + i);
  }
  std::vector<sideray_light> lights;
  for (int i = 0; i < 6; ++i)
    lights.push_back(lamp(i - 2.5, i % 2 ? 2.0 : -2.0, i == 5 ? -14.0 : -1.0 - 0.5 * i, 20.0f / float(1 << i)));
  scene.set_lights(lights);
  const std::array<float, 12> sky{0.4f, 0.5f, 0.7f, 0.4f, 0.5f, 0.7f, 0.1f, 0.1f, 0.1f, 0.1f, 0.1f, 0.1f};
  scene.set_environment(2, 2, sky.data(), 1.0f, 0.0f);
  scene.commit();
  return scene;
}

std::vector<std::vector<float>> channels_of(const Picture& picture) {
  const Planes planes(picture);
  std::vector<std::vector<float>> channels;
  for (const char* name : {"R", "G", "B"})
    channels.emplace_back(planes.floats(name), planes.floats(name) + planes.pixels());
  return channels;
}

uint64_t rays_of(const Picture& picture) {
  const sideray_render_stats stats = picture.stats();
  return stats.rays_primary + stats.rays_reflection + stats.rays_shadow;
}

// Returns the largest change of a pixel, beyond rounding, over the threshold.
StressRow change_of(const StressStage& stage, const Picture& test_picture, const Picture& truth_picture,
                    double threshold) {
  const std::vector<std::vector<float>> test = channels_of(test_picture), truth = channels_of(truth_picture);
  StressRow row;
  row.measure = "largest change of a pixel beyond rounding, over the threshold";
  row.map = map_of(stage);
  row.bound = 1.0;
  for (size_t c = 0; c < test.size(); ++c)
    for (size_t i = 0; i < test[c].size(); ++i) {
      const double a = double{test[c][i]}, b = double{truth[c][i]};
      const double change = std::abs(a - b) - rounding * std::max(std::abs(a), std::abs(b));
      row.value = std::max(row.value, change / threshold);
      if (change > threshold) row.map.wrong[i] = 1;
    }
  return row;
}

StressRow rays_left(const Picture& test, const Picture& truth) {
  StressRow row;
  row.measure = "rays left, share";
  row.value = static_cast<double>(rays_of(test)) / static_cast<double>(rays_of(truth));
  row.bound = 1.0;
  return row;
}

RenderOptions options_of(const StressStage& stage, const Order& order) {
  RenderOptions options = picture_options(stage);
  options.shadows->method = SIDERAY_SHADOWS_MAP;
  options.translucency->method = order.translucency;
  options.translucency->oit = order.oit;
  options.translucency->layers = panes;
  options.picture.repeats = 1;
  return options;
}

}  // namespace

std::vector<StressRow> layer_threshold_case(StressStage& stage) {
  const sideray_camera camera = camera_at(glm::dmat4(1.0), 45.0, 0.1);
  std::vector<StressRow> rows;
  for (const Glass& glass : glasses) {
    if (stage.quick && glass.transmission == 0.0f && &glass != &glasses.front()) continue;
    const Scene scene = scene_of(glass);
    for (const Order& order : orders) {
      // Peeling takes the same layers in another order, and is the slowest by far where OpenGL is software.
      if (stage.quick && order.oit == SIDERAY_OIT_PEEL) continue;
      RenderOptions options = options_of(stage, order);
      const Picture truth = stage.renderer.render(scene, camera, options).value();
      for (const double threshold : swept(stage, {1e-4, 1e-3, 1.0 / 255.0, 0.01, 0.1, 1.0}, {1e-3, 0.1})) {
        options.translucency->layer_threshold = static_cast<float>(threshold);
        const Picture test = stage.renderer.render(scene, camera, options).value();
        for (StressRow row : {change_of(stage, test, truth, threshold), rays_left(test, truth)}) {
          row.name = "layer-threshold", row.variant = order.variant;
          row.parameters = {{"glass", glass.name}, {"threshold", threshold}};
          rows.push_back(std::move(row));
        }
      }
    }
  }
  return rows;
}

}  // namespace sideray::lab
