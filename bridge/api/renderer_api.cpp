// sideray_renderer_*, sideray_picture_*, sideray_device_*: the offscreen renderer.
#include <sideray/diagnostics.h>

#include "bridge/api/border.h"
#include "bridge/renderer/renderer.h"

using sideray::bridge::guarded;
using sideray::bridge::init_struct;
using sideray::bridge::require;

struct sideray_renderer {
  sideray::bridge::Renderer renderer;
  sideray_device_info device;  // points into `renderer`
};

struct sideray_device_list {
  std::vector<sideray::gl::DeviceInfo> found;
  std::vector<sideray_device_info> devices;  // points into `found`
};

namespace {

const char* platform_name(sideray::gl::Platform platform) {
  if (platform == sideray::gl::Platform::host) return "host";
  if (platform == sideray::gl::Platform::none) return "none";
  return platform == sideray::gl::Platform::osmesa ? "osmesa" : "egl";
}

sideray_device_info describe(const sideray::gl::DeviceInfo& info) {
  return {info.id.c_str(), platform_name(info.platform), info.renderer.c_str(), info.version.c_str(),
          info.usable,     info.reason.c_str()};
}

// Returns the result of a struct's init function, computed once, so that its address stays the same.
template <typename T>
const T* constant(void (*init)(T*, size_t)) {
  static const T filled = [&] {
    T made;
    init(&made, sizeof(made));
    return made;
  }();
  return &filled;
}

}  // namespace

sideray_status sideray_devices(sideray_device_list** devices, sideray_error* error) {
  return guarded(error, [&] {
    require(devices, "devices");
    auto list = std::make_unique<sideray_device_list>();
    list->found = sideray::gl::list_devices();
    for (const sideray::gl::DeviceInfo& found : list->found) list->devices.push_back(describe(found));
    *devices = list.release();
  });
}

size_t sideray_device_count(const sideray_device_list* devices) {
  return devices->devices.size();
}

const sideray_device_info* sideray_device_at(const sideray_device_list* devices, size_t index) {
  return index < devices->devices.size() ? &devices->devices[index] : nullptr;
}

void sideray_devices_free(sideray_device_list* devices) {
  delete devices;
}

void sideray_renderer_init(sideray_renderer_desc* out, size_t size) {
  sideray_renderer_desc d{};
  d.gl = "auto";
  init_struct(out, size, d);
}

sideray_status sideray_renderer_create(const sideray_renderer_desc* desc, sideray_renderer** renderer,
                                       sideray_error* error) {
  return guarded(error, [&] {
    const sideray_renderer_desc read =
        sideray::bridge::read_struct(desc, "renderer description", sideray_renderer_init);
    require(renderer, "renderer result");
    auto made = std::unique_ptr<sideray_renderer>(new sideray_renderer{sideray::bridge::Renderer(read), {}});
    made->device = describe(made->renderer.device());
    *renderer = made.release();
  });
}

void sideray_renderer_destroy(sideray_renderer* renderer) {
  delete renderer;
}

sideray_status sideray_renderer_device(sideray_renderer* renderer, const sideray_device_info** device,
                                       sideray_error* error) {
  return guarded(error, [&] {
    require(renderer, "renderer");
    require(device, "device result");
    *device = &renderer->device;
  });
}

void sideray_camera_init(sideray_camera* out, size_t size) {
  sideray_camera c{};
  c.world_from_camera[0] = c.world_from_camera[4] = c.world_from_camera[8] = 1.0;
  c.yfov = 0.785398163f;
  c.half_height = 1.0f;
  c.z_near = 0.1f;
  c.fx_per_fy = 1.0f;
  init_struct(out, size, c);
}

void sideray_translucency_init(sideray_translucency_options* out, size_t size) {
  sideray_translucency_options o{};
  o.method = SIDERAY_TRANSLUCENCY_HYBRID;
  o.layers = 4;
  o.mask = SIDERAY_COUNT_MASK;
  o.match_threshold = 0.001f;
  o.second_wave = 1;
  o.ray_reuse = SIDERAY_RAY_REUSE_AUTO;
  o.light_samples = 64;
  o.whole_pixels = 1;
  o.refraction = 1;
  o.bounces = 1;
  init_struct(out, size, o);
}

void sideray_shadow_init(sideray_shadow_options* out, size_t size) {
  sideray_shadow_options o{};
  o.method = SIDERAY_SHADOWS_INEXACT;
  o.inexact = SIDERAY_INEXACT_RESTPOSE;
  o.inexact_bias = 0.5f;
  o.inexact_target = SIDERAY_TARGET_STENCIL;
  init_struct(out, size, o);
}

void sideray_pose_init(sideray_pose_options* out, size_t size) {
  sideray_pose_options o{};
  o.poses = 16;
  o.cull_angle_deg = 0.0f;
  init_struct(out, size, o);
}

void sideray_reference_init(sideray_reference_options* out, size_t size) {
  sideray_reference_options o{};
  o.light_samples = 64;
  o.refraction = 1;
  o.bounces = 1;
  init_struct(out, size, o);
}

void sideray_diagnostics_init(sideray_diagnostics* out, size_t size) {
  init_struct(out, size, sideray_diagnostics{});
}

void sideray_raw_frame_init(sideray_raw_frame* out, size_t size) {
  sideray_raw_frame r{};
  r.most_flat_triangles = uint64_t{1} << 22;
  init_struct(out, size, r);
}

void sideray_render_init(sideray_render_options* out, size_t size) {
  sideray_render_options o{};
  o.width = 1280;
  o.height = 720;
  o.samples = 1;
  o.seed = 1;
  o.reflections = SIDERAY_REFLECTIONS_AUTO;
  o.ambient = SIDERAY_AMBIENT_AUTO;
  o.denoise = 1;
  o.translucency = constant(sideray_translucency_init);
  o.shadows = constant(sideray_shadow_init);
  o.poses = constant(sideray_pose_init);
  init_struct(out, size, o);
}

sideray_status sideray_renderer_render(sideray_renderer* renderer, sideray_scene* scene, const sideray_camera* camera,
                                       const sideray_render_options* options, sideray_picture** picture,
                                       sideray_error* error) {
  return guarded(error, [&] {
    require(renderer, "renderer");
    require(scene, "scene");
    const sideray_camera seen_from = sideray::bridge::read_struct(camera, "camera", sideray_camera_init);
    const sideray::bridge::RenderOptions read = sideray::bridge::read_render_options(options);
    require(picture, "picture result");
    *picture = renderer->renderer.render(scene, seen_from, read).release();
  });
}

sideray_status sideray_renderer_render_many(sideray_renderer* renderer, sideray_scene* scene, const sideray_camera* cameras,
                                            size_t count, const sideray_render_options* options,
                                            sideray_picture** pictures, sideray_error* error) {
  return guarded(error, [&] {
    require(renderer, "renderer");
    require(scene, "scene");
    const sideray::bridge::RenderOptions read = sideray::bridge::read_render_options(options);
    if (count == 0) return;
    require(cameras, "cameras");
    require(pictures, "pictures result");
    std::vector<sideray_camera> seen_from;
    const auto* bytes = reinterpret_cast<const unsigned char*>(cameras);
    for (size_t i = 0; i < count; ++i)
      seen_from.push_back(sideray::bridge::read_struct(
          reinterpret_cast<const sideray_camera*>(bytes + i * cameras->size), "camera", sideray_camera_init));
    auto drawn = renderer->renderer.render_many(scene, seen_from, read);
    for (size_t i = 0; i < count; ++i) pictures[i] = drawn[i].release();
  });
}

void sideray_renderer_cancel(sideray_renderer* renderer) {
  if (renderer) renderer->renderer.cancel();
}

void sideray_picture_release(sideray_picture* picture) {
  delete picture;
}

void sideray_picture_size(const sideray_picture* picture, uint32_t* width, uint32_t* height) {
  if (width) *width = picture->width;
  if (height) *height = picture->height;
}

size_t sideray_picture_channel_count(const sideray_picture* picture) {
  return picture->channels.size();
}

const sideray_channel* sideray_picture_channel(const sideray_picture* picture, size_t index) {
  return index < picture->channels.size() ? &picture->channels[index] : nullptr;
}

size_t sideray_picture_stage_count(const sideray_picture* picture) {
  return picture->stages.all().size();
}

const sideray_stage_time* sideray_picture_stage(const sideray_picture* picture, size_t index) {
  return index < picture->stages.all().size() ? &picture->stages.all()[index] : nullptr;
}

sideray_status sideray_picture_stats(const sideray_picture* picture, sideray_render_stats* stats,
                                     sideray_error* error) {
  return guarded(error, [&] {
    require(picture, "picture");
    sideray::bridge::write_struct(stats, picture->stats, "render statistics");
  });
}
