// Draws a view picture by picture, through the public interface and with its defaults.
#pragma once

#include <cmath>
#include <utility>

#include "frame/frame.h"
#include "scenes/builtin/builtin.h"

namespace sideray::tests {

inline constexpr uint32_t still_positions = 64;

struct Shown {
  std::vector<float> colors;  // RGBA, plane by plane, top row first
  sideray_render_stats stats;
  uint64_t rays() const { return stats.rays_primary + stats.rays_reflection + stats.rays_shadow + stats.rays_ao; }
};

// Each picture has random numbers of its own, as the program's have.
class View {
 public:
  View(scenes::Content content, uint32_t width, uint32_t height)
      : content_(std::move(content)), scene_(Scene::create().value()), renderer_(Renderer::create().value()) {
    camera_ = camera_of(content_, {.width = width, .height = height});
    const scenes::Sky sky = scenes::sky();
    scene_.set_environment(sky.width, sky.height, sky.rgb.data(), 1.0f, 0.0f);
    for (const scenes::Light& light : content_.lights) lights_.push_back(light.light);
    scenes::fill(scene_, content_, scenes::select_ray_traced(content_, "all", camera_, width, height));
    options.picture.width = width;
    options.picture.height = height;
    options.picture.taa = 1;
  }

  Shown draw() {
    const Picture picture = renderer_.render(scene_, camera_, options).value();
    options.picture.continues = 1;
    ++options.picture.seed;
    Shown shown{{}, picture.stats()};
    for (const char* name : {"R", "G", "B", "A"})
      for (size_t i = 0; i < picture.channel_count(); ++i)
        if (std::string(name) == picture.channel(i).name) {
          const auto* values = static_cast<const float*>(picture.channel(i).values);
          shown.colors.insert(shown.colors.end(), values, values + size_t{options.picture.width} * options.picture.height);
        }
    return shown;
  }
  Shown draw(uint32_t pictures) {
    for (uint32_t i = 1; i < pictures; ++i) draw();
    return draw();
  }
  // Returns the picture of all positions by a new renderer.
  Shown alone(uint32_t seed) {
    RenderOptions one = options;
    one.picture.continues = 0;
    one.picture.samples = still_positions;
    one.picture.seed = seed;
    std::swap(options, one);
    std::swap(renderer_, other_);
    Shown shown = draw();
    std::swap(renderer_, other_);
    std::swap(options, one);
    return shown;
  }
  void brighten_first_light() {
    for (float& c : lights_.at(0).intensity) c *= 2.0f;
    scene_.set_lights(lights_);
    scene_.commit();
  }
  void commit() { scene_.commit(); }
  // The following move a light, an object, or the sprites to a time.
  void move_light(size_t light, glm::dvec3 by) {
    for (int i = 0; i < 3; ++i) lights_.at(light).position[i] += by[i];
    scene_.set_lights(lights_);
    scene_.commit();
  }
  void move_object(const char* name, glm::dvec3 by) {
    for (size_t i = 0; i < content_.objects.size(); ++i) {
      if (content_.objects[i].name != name) continue;
      double* m = content_.objects[i].world_from_object;
      for (int axis = 0; axis < 3; ++axis) m[9 + axis] += by[axis];
      scene_.move_instance(static_cast<sideray_instance>(i + 1), m);
    }
    scene_.commit();
  }
  void pose(double time_s) {
    scenes::pose(content_, time_s);
    scenes::move(scene_, content_);
  }
  void step_aside() { camera_.world_from_camera[9] += 0.1; }

  RenderOptions options;

 private:
  scenes::Content content_;
  Scene scene_;
  Renderer renderer_, other_ = Renderer::create().value();
  sideray_camera camera_{};
  std::vector<sideray_light> lights_;
};

}  // namespace sideray::tests
