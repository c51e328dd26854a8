// sideray_content_*: glTF files and built-in scenes for programs in any language.
#include <fmt/format.h>
#include <sideray/scenes.h>

#include <cstdio>
#include <new>

#include "scenes/content/content.h"

using sideray::Error;
using sideray::scenes::Content;

struct sideray_content {
  Content content;
};

namespace {

sideray_status report(sideray_error* error, sideray_status status, const char* message) {
  if (!error) return status;
  error->status = status;
  std::snprintf(error->message, sizeof(error->message), "%s", message);
  return status;
}

// The border between exceptions and status codes, as bridge/api/border.h is for sideray.h.
template <typename Body>
sideray_status guarded(sideray_error* error, const Body& body) noexcept {
  try {
    body();
    return SIDERAY_OK;
  } catch (const Error& failure) {
    return report(error, failure.status, failure.what());
  } catch (const std::bad_alloc&) {
    return report(error, SIDERAY_OUT_OF_MEMORY, "out of memory: close other programs or load a smaller scene");
  } catch (const std::exception& exception) {
    return report(error, SIDERAY_INTERNAL, exception.what());
  } catch (...) {
    return report(error, SIDERAY_INTERNAL, "unknown exception");
  }
}

void require(const void* pointer, const char* name) {
  if (!pointer) throw Error(SIDERAY_INVALID_ARGUMENT, fmt::format("{}: is NULL; give a valid pointer", name));
}

// Gives what the caller gave, or the defaults.
template <typename T>
T given(const T* options, const T& defaults, const char* name) {
  if (!options) return defaults;
  if (options->size != sizeof(T))
    throw Error(SIDERAY_INVALID_ARGUMENT,
                fmt::format("{}: size is {}, not {}; fill the struct with its defaults function first", name,
                            options->size, sizeof(T)));
  return *options;
}

void set_sky(sideray::Scene& scene) {
  const sideray::scenes::Sky sky = sideray::scenes::sky();
  scene.set_environment(sky.width, sky.height, sky.rgb.data(), 1.0f, 0.0f);
}

}  // namespace

sideray_load_options sideray_load_defaults(void) {
  return {sizeof(sideray_load_options), nullptr, 0.0};
}

sideray_status sideray_content_load(const char* scene, const sideray_load_options* options, sideray_content** content,
                                    sideray_error* error) {
  return guarded(error, [&] {
    require(scene, "scene");
    require(content, "content result");
    const sideray_load_options o = given(options, sideray_load_defaults(), "load options");
    *content = new sideray_content{
        sideray::scenes::load(scene, {.animation = o.animation ? o.animation : "", .time_s = o.time_s})};
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
    require(camera, "camera result");
    const auto& cameras = content->content.cameras;
    if (cameras.empty() && index == 0)
      *camera = sideray::scenes::framing_camera(content->content, aspect);
    else if (index < cameras.size())
      *camera = cameras[index].camera;
    else
      throw Error(SIDERAY_INVALID_ARGUMENT,
                  fmt::format("camera {}: the scene has {}; count them from 0", index, cameras.size()));
  });
}

sideray_fill_options sideray_fill_defaults(void) {
  sideray_fill_options options{};
  options.size = sizeof(options);
  options.ray_traced = "auto";
  options.width = 1280, options.height = 720;
  options.sky = 1;
  return options;
}

sideray_status sideray_content_fill(const sideray_content* content, const sideray_fill_options* options,
                                    sideray_scene* scene, sideray_error* error) {
  return guarded(error, [&] {
    require(content, "content");
    require(scene, "scene");
    const sideray_fill_options o = given(options, sideray_fill_defaults(), "fill options");
    require(o.ray_traced, "ray_traced");
    const std::vector<bool> traced =
        sideray::scenes::select_ray_traced(content->content, o.ray_traced, o.camera, o.width, o.height);
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
