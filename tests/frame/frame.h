// Renders content through the public interface for the tests of whole frames.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <map>
#include <sideray/sideray.hpp>
#include <string>
#include <vector>

#include "scenes/content/content.h"

namespace sideray::tests {

// A picture as a map from channel name to values, top row first.
struct Frame {
  uint32_t width = 0, height = 0;
  std::map<std::string, std::vector<float>> planes;
  std::map<std::string, std::vector<uint32_t>> uint_planes;
  sideray_render_stats stats{};
  std::map<sideray_stage, double> stage_ms;  // medians
  std::vector<float> rgb() const {
    std::vector<float> values;
    for (size_t i = 0; i < planes.at("R").size(); ++i)
      for (const char* channel : {"R", "G", "B"}) values.push_back(planes.at(channel)[i]);
    return values;
  }
};

struct Setup {
  uint32_t width = 320, height = 180;
  sideray_translucency translucency = SIDERAY_TRANSLUCENCY_HYBRID;
  uint32_t layers = 4;
  sideray_mask mask = SIDERAY_COUNT_MASK;
  sideray_shadows shadows = SIDERAY_SHADOWS_MAP;
  uint32_t aovs = 0, threads = 0, repeats = 0, samples = 1;
  bool seen_in_reflections = true;  // false: reflection rays hit the environment alone
  bool sky = true, reference = false, rt_particles = false;
  bool furnace = false;  // constant radiance from everywhere instead of the sky
  sideray_oit oit = SIDERAY_OIT_SORTED;
  bool ao = false;
  bool denoise = false;  // with it, a rough layer is another estimate than a composited surface
  uint32_t light_samples = 64, bounces = 1, seed = 1;  // references: 0 = unlimited bounces
  std::string selection = "all", gl = "auto", isa = "";
  sideray_cache_rate cache_rate = SIDERAY_RATE_FULL;
  bool second_wave = true;
  bool whole_pixels = true;
  float ray_reuse = 0.0f;  // above 0, rays and layers differ in bits from other ways to draw
  sideray_inexact inexact = SIDERAY_INEXACT_RESTPOSE;
  uint32_t poses = 1;
  bool reflections = false;
  double time_s = 0;  // of wind
  bool refraction = false;  // with it, ways of drawing differ by more than their rays where light refracts
  sideray_match match = SIDERAY_MATCH_ID;
};

inline sideray_camera camera_of(const scenes::Content& content, const Setup& setup) {
  if (!content.cameras.empty()) return content.cameras.front().camera;
  return scenes::framing_camera(content, static_cast<float>(setup.width) / static_cast<float>(setup.height));
}

inline Frame render(const scenes::Content& content, const Setup& setup, const sideray_camera* camera = nullptr) {
  sideray_renderer_desc desc = sideray_renderer_defaults();
  desc.gl = setup.gl.c_str();
  desc.threads = setup.threads;
  desc.isa = setup.isa.empty() ? nullptr : setup.isa.c_str();
  Renderer renderer = Renderer::create(desc).value();
  Scene scene = Scene::create().value();
  const scenes::Sky sky = setup.furnace ? scenes::Sky{4, 2, std::vector<float>(24, 0.5f)} : scenes::sky();
  if (setup.sky) scene.set_environment(sky.width, sky.height, sky.rgb.data(), 1.0f, 0.0f);
  const sideray_camera own = camera ? *camera : camera_of(content, setup);
  const std::vector<bool> traced = scenes::select_ray_traced(content, setup.selection, own, setup.width, setup.height);
  scene.set_time(setup.time_s, setup.time_s);
  scenes::fill(scene, content, traced);
  if (!setup.seen_in_reflections) {
    for (size_t i = 0; i < traced.size(); ++i)
      scene.set_visibility(static_cast<sideray_instance>(i + 1),
                           traced[i] ? SIDERAY_VISIBLE_SHADOW | SIDERAY_VISIBLE_LAYERS : SIDERAY_VISIBLE_SHADOW);
    scene.commit();
  }
  RenderOptions options;
  options.picture.width = setup.width;
  options.picture.height = setup.height;
  options.translucency->method = setup.translucency;
  options.translucency->layers = setup.layers;
  options.translucency->mask = setup.mask;
  options.shadows->method = setup.shadows;
  options.picture.aovs = setup.aovs;
  options.picture.repeats = setup.repeats;
  options.picture.samples = setup.samples;
  options.picture.ambient = setup.ao ? SIDERAY_AMBIENT_AO : SIDERAY_AMBIENT_OFF;
  options.picture.denoise = setup.denoise;
  options.picture.seed = setup.seed;
  if (setup.reference) {
    options.reference = sideray_reference_defaults();
    options.reference->light_samples = setup.light_samples;
    options.reference->bounces = setup.bounces;
    options.reference->refraction = setup.refraction;
  }
  options.translucency->refraction = setup.refraction;
  options.translucency->match = setup.match;
  options.translucency->cache_rate = setup.cache_rate;
  options.translucency->second_wave = setup.second_wave;
  options.translucency->whole_pixels = setup.whole_pixels;
  options.translucency->ray_reuse = setup.ray_reuse;
  options.translucency->particles = setup.rt_particles;
  options.translucency->light_samples = setup.light_samples;
  options.translucency->oit = setup.oit;
  options.shadows->inexact = setup.inexact;
  options.poses->poses = setup.poses;
  options.picture.reflections = setup.reflections;
  Picture picture = renderer.render(scene, own, options).value();
  Frame frame{picture.width(), picture.height(), {}, {}, picture.stats(), {}};
  for (int i = 0; i <= SIDERAY_STAGE_TOTAL_FRAME; ++i) {
    const auto stage = static_cast<sideray_stage>(i);
    frame.stage_ms[stage] = picture.stage(stage).median;
  }
  const size_t count = size_t{frame.width} * frame.height;
  for (size_t i = 0; i < picture.channel_count(); ++i) {
    const sideray_channel channel = picture.channel(i);
    if (channel.type == SIDERAY_CHANNEL_UINT) {
      const auto* values = static_cast<const uint32_t*>(channel.values);
      frame.uint_planes[channel.name].assign(values, values + count);
    } else {
      const auto* values = static_cast<const float*>(channel.values);
      frame.planes[channel.name].assign(values, values + count);
    }
  }
  return frame;
}

// Returns the path of third-party content, or nothing where it is not there.
inline std::string asset(const std::string& relative) {
  const char* folder = std::getenv("SIDERAY_ASSETS");
  const std::filesystem::path path =
      std::filesystem::path(folder ? folder : SIDERAY_SOURCE_DIR "/../shared/assets") / relative;
  return std::filesystem::exists(path) ? path.string() : std::string();
}

#define SIDERAY_ASSET_OR_SKIP(variable, relative)                 \
  const std::string variable = ::sideray::tests::asset(relative); \
  if (variable.empty()) GTEST_SKIP() << "third-party asset " << relative << " is absent (set SIDERAY_ASSETS)"

}  // namespace sideray::tests
