// Implements sideray_content_*: glTF files for programs in any language.
#include <sideray/scenes.h>

#include "scenes/base/border.h"
#include "scenes/content/content.h"

using sideray::Error;
using sideray::scenes::Content;
using sideray::scenes::guarded;
using sideray::scenes::init_struct;
using sideray::scenes::read_struct;
using sideray::scenes::require;

struct sideray_content {
  Content content;
};

namespace {

// Returns the content's first camera, or one that frames everything in a picture of this size.
sideray_camera first_camera(const Content& content, uint32_t width, uint32_t height) {
  if (!content.cameras.empty()) return content.cameras.front().camera;
  const uint32_t rows = height == 0 ? 1 : height;
  return sideray::scenes::framing_camera(content, static_cast<float>(width) / static_cast<float>(rows));
}

void set_sky(sideray::Scene& scene) {
  const sideray::scenes::Sky sky = sideray::scenes::sky();
  scene.set_environment(sky.width, sky.height, sky.rgb.data(), 1.0f, 0.0f);
}

}  // namespace

void sideray_load_init(sideray_load_options* out, size_t size) {
  sideray_load_options o{};
  o.default_light = 1;
  init_struct(out, size, o);
}

sideray_status sideray_content_load(const char* path, const sideray_load_options* options, sideray_content** content,
                                    sideray_error* error) {
  return guarded(error, [&] {
    require(path, "path");
    require(content, "content result");
    const sideray_load_options o = read_struct(options, "load options", sideray_load_init);
    *content = new sideray_content{
        sideray::scenes::load_file(path, {.animation = o.animation ? o.animation : "",
                                                          .variant = o.variant ? o.variant : "",
                                                          .time_s = o.time_s,
                                                          .default_light = o.default_light != 0,
                                                          .limits = {o.max_seconds, o.max_bytes}})};
  });
}

void sideray_content_release(sideray_content* content) {
  delete content;
}

size_t sideray_content_warning_count(const sideray_content* content) {
  return content->content.warnings.size();
}

const char* sideray_content_warning(const sideray_content* content, size_t index) {
  return index < content->content.warnings.size() ? content->content.warnings[index].c_str() : nullptr;
}

size_t sideray_content_variant_count(const sideray_content* content) {
  return content->content.variants.size();
}

const char* sideray_content_variant_name(const sideray_content* content, size_t index) {
  return index < content->content.variants.size() ? content->content.variants[index].c_str() : nullptr;
}

size_t sideray_content_camera_count(const sideray_content* content) {
  return content->content.cameras.size();
}

const char* sideray_content_camera_name(const sideray_content* content, size_t index) {
  return index < content->content.cameras.size() ? content->content.cameras[index].name.c_str() : nullptr;
}

sideray_status sideray_content_camera(const sideray_content* content, size_t index, float aspect,
                                      sideray_camera* camera, sideray_error* error) {
  return guarded(error, [&] {
    require(content, "content");
    const auto& cameras = content->content.cameras;
    const bool frames_all = cameras.empty() && index == 0;
    if (!frames_all && index >= cameras.size())
      throw Error(SIDERAY_INVALID_ARGUMENT,
                  fmt::format("camera {}: the scene has {}; count them from 0", index, cameras.size()));
    sideray::scenes::write_struct(
        camera, frames_all ? sideray::scenes::framing_camera(content->content, aspect) : cameras[index].camera,
        "camera result");
  });
}

void sideray_fill_init(sideray_fill_options* out, size_t size) {
  sideray_fill_options options{};
  options.ray_traced = "auto";
  options.width = 1280;
  options.height = 720;
  options.sky = 1;
  init_struct(out, size, options);
}

sideray_status sideray_content_fill(const sideray_content* content, const sideray_fill_options* options,
                                    sideray_scene* scene, sideray_error* error) {
  return guarded(error, [&] {
    require(content, "content");
    require(scene, "scene");
    const sideray_fill_options o = read_struct(options, "fill options", sideray_fill_init);
    require(o.ray_traced, "ray_traced");
    const sideray_camera camera = o.camera ? read_struct(o.camera, "fill options camera", sideray_camera_init)
                                           : first_camera(content->content, o.width, o.height);
    const std::vector<bool> traced =
        sideray::scenes::select_ray_traced(content->content, o.ray_traced, camera, o.width, o.height);
    sideray::Scene shared = sideray::Scene::share(scene);
    if (o.sky) set_sky(shared);
    sideray::scenes::fill(shared, content->content, traced);
  });
}

size_t sideray_content_object_count(const sideray_content* content) {
  return content->content.objects.size();
}

const char* sideray_content_object_name(const sideray_content* content, size_t index) {
  return index < content->content.objects.size() ? content->content.objects[index].name.c_str() : nullptr;
}

sideray_status sideray_content_move(sideray_content* content, double time_s, double previous_time_s,
                                    sideray_scene* scene, sideray_error* error) {
  return guarded(error, [&] {
    require(content, "content");
    require(scene, "scene");
    if (!sideray::scenes::moves(content->content)) return;
    sideray::scenes::pose(content->content, time_s);
    sideray::Scene shared = sideray::Scene::share(scene);
    shared.set_time(time_s, previous_time_s);
    sideray::scenes::move(shared, content->content);
  });
}
