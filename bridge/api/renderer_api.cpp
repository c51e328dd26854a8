// sideray_renderer_*, sideray_picture_*, sideray_devices: the offscreen tier.
#include <cstdlib>
#include <cstring>

#include <sideray/diagnostics.h>

#include "bridge/api/border.h"
#include "bridge/renderer/renderer.h"

using sideray::bridge::guarded;
using sideray::bridge::require;
using sideray::bridge::require_struct;

struct sideray_renderer {
  sideray::bridge::Renderer renderer;
};

namespace {

const char* platform_name(sideray::gl::Platform platform) {
  return platform == sideray::gl::Platform::osmesa ? "osmesa" : "egl";
}

sideray_device_info describe(const sideray::gl::DeviceInfo& info) {
  return {info.id.c_str(), platform_name(info.platform), info.renderer.c_str(), info.version.c_str(),
          info.usable,     info.reason.c_str()};
}

// Strings of the list are malloc'd one by one, so that the list can be given back without remembering it.
const char* copy(const std::string& text) {
  char* bytes = static_cast<char*>(std::malloc(text.size() + 1));
  if (!bytes) throw std::bad_alloc();
  std::memcpy(bytes, text.c_str(), text.size() + 1);
  return bytes;
}

}  // namespace

sideray_status sideray_devices(const sideray_device_info** devices, size_t* count, sideray_error* error) {
  return guarded(error, [&] {
    require(devices, "devices");
    require(count, "count");
    const std::vector<sideray::gl::DeviceInfo> found = sideray::gl::list_devices();
    auto* list = static_cast<sideray_device_info*>(std::calloc(found.size() + 1, sizeof(sideray_device_info)));
    if (!list) throw std::bad_alloc();
    for (size_t i = 0; i < found.size(); ++i)
      list[i] = {copy(found[i].id),       platform_name(found[i].platform),
                 copy(found[i].renderer), copy(found[i].version),
                 found[i].usable,         copy(found[i].reason)};
    *devices = list;
    *count = found.size();
  });
}

void sideray_devices_free(const sideray_device_info* devices, size_t count) {
  for (size_t i = 0; devices && i < count; ++i)
    for (const char* text : {devices[i].id, devices[i].renderer, devices[i].version, devices[i].reason})
      std::free(const_cast<char*>(text));
  std::free(const_cast<sideray_device_info*>(devices));
}

sideray_renderer_desc sideray_renderer_defaults(void) {
  sideray_renderer_desc d{};
  d.size = sizeof(d);
  d.gl = "auto";
  return d;
}

sideray_status sideray_renderer_create(const sideray_renderer_desc* desc, sideray_renderer** renderer,
                                       sideray_error* error) {
  return guarded(error, [&] {
    require_struct(desc, "renderer description");
    require(renderer, "renderer result");
    *renderer = new sideray_renderer{sideray::bridge::Renderer(*desc)};
  });
}

void sideray_renderer_destroy(sideray_renderer* renderer) {
  delete renderer;
}

sideray_status sideray_renderer_device(sideray_renderer* renderer, sideray_device_info* info, sideray_error* error) {
  return guarded(error, [&] {
    require(renderer, "renderer");
    require(info, "info");
    *info = describe(renderer->renderer.device());
  });
}

sideray_render_options sideray_render_defaults(void) {
  sideray_render_options o{};
  o.size = sizeof(o);
  o.width = 1280;
  o.height = 720;
  o.translucency = SIDERAY_TRANSLUCENCY_HYBRID;
  o.layers = 4;
  o.mask = SIDERAY_COUNT_MASK;
  o.shadows = SIDERAY_SHADOWS_INEXACT;
  o.inexact = SIDERAY_INEXACT_RESTPOSE;
  o.inexact_bias = 0.5f;
  o.inexact_target = SIDERAY_TARGET_STENCIL;
  o.foliage = SIDERAY_FOLIAGE_SHARED;
  o.shared_copies = 1;
  o.unique_cap = 256;
  o.cull_angle_deg = 1.0f;
  o.samples = 1;
  o.light_samples = 64;
  o.match_threshold = 0.001f;
  o.denoise = 1;
  o.second_wave = 1;
  o.seed = 1;
  return o;
}

sideray_status sideray_renderer_set_exact_points(sideray_renderer* renderer, int32_t exact, sideray_error* error) {
  return guarded(error, [&] {
    require(renderer, "renderer");
    renderer->renderer.set_exact_points(exact != 0);
  });
}

sideray_status sideray_renderer_render(sideray_renderer* renderer, sideray_scene* scene, const sideray_camera* camera,
                                       const sideray_render_options* options, sideray_picture** picture,
                                       sideray_error* error) {
  return guarded(error, [&] {
    require(renderer, "renderer");
    require(scene, "scene");
    require_struct(camera, "camera");
    require_struct(options, "render options");
    require(picture, "picture result");
    *picture = renderer->renderer.render(scene, *camera, *options).release();
  });
}

void sideray_picture_release(sideray_picture* picture) {
  delete picture;
}

void sideray_picture_size(const sideray_picture* picture, uint32_t* width, uint32_t* height) {
  if (width) *width = picture->width;
  if (height) *height = picture->height;
}

size_t sideray_picture_channel_count(const sideray_picture* picture) {
  return picture->planes.size();
}

sideray_channel sideray_picture_channel(const sideray_picture* picture, size_t index) {
  if (index >= picture->planes.size()) return {};
  const sideray_picture::Plane& plane = picture->planes[index];
  if (plane.uint_values.empty()) return {plane.name.c_str(), SIDERAY_CHANNEL_FLOAT, plane.values.data()};
  return {plane.name.c_str(), SIDERAY_CHANNEL_UINT, plane.uint_values.data()};
}

void sideray_picture_stats(const sideray_picture* picture, sideray_render_stats* stats) {
  *stats = picture->stats;
}
