// Tests callers compiled with other versions of the interface: structs without their last field, structs with unknown
// fields, shorter outputs, arrays with other strides.
#include <gmock/gmock.h>

#include <cstddef>
#include <sideray/diagnostics.h>
#include <sideray/ground_truth.h>
#include <sideray/plan.h>

#include "embed/hosts/one_pane.h"
#include "embed/hosts/small_host.h"

namespace sideray::tests::versions_test {
namespace {

using Bytes = std::vector<std::byte>;

constexpr size_t unknown_bytes = 24;
constexpr std::byte untouched{0xa5};

// Returns the bytes of the struct in another version, with no memory after `size` bytes.
template <typename T>
Bytes resized(const T& full, size_t size) {
  Bytes bytes(size);
  std::memcpy(bytes.data(), &full, std::min(size, sizeof(T)));
  std::memcpy(bytes.data(), &size, sizeof(size));
  return bytes;
}

// `last_field` is the offset of the last field, which an older caller lacks; `call` passes the struct to the library.
template <typename T, typename Call>
void expect_any_version(const char* name, const T& full, size_t last_field, const Call& call) {
  SCOPED_TRACE(name);
  sideray_error error{};
  const auto status_of = [&](const Bytes& bytes) { return call(reinterpret_cast<const T*>(bytes.data()), &error); };
  for (const size_t size : {last_field, sizeof(T), sizeof(T) + unknown_bytes})
    EXPECT_EQ(status_of(resized(full, size)), SIDERAY_OK) << size << " bytes: " << error.message;
  Bytes newer = resized(full, sizeof(T) + unknown_bytes);
  newer[sizeof(T) + 5] = std::byte{1};
  EXPECT_EQ(status_of(newer), SIDERAY_UNSUPPORTED);
  EXPECT_THAT(error.message, testing::HasSubstr("byte " + std::to_string(sizeof(T) + 5)));
  Bytes senseless = resized(full, sizeof(T));
  std::fill_n(senseless.begin(), sizeof(size_t), untouched);
  EXPECT_EQ(status_of(senseless), SIDERAY_INVALID_ARGUMENT);
  EXPECT_THAT(error.message, testing::HasSubstr("size"));
}

// Expects that an older caller's struct, which ends at `last_field`, is filled and nothing after it is written. Returns
// the filled struct.
template <typename T, typename Fill>
T filled_as_far_as_known(const char* name, size_t last_field, const Fill& fill) {
  SCOPED_TRACE(name);
  Bytes bytes(sizeof(T), untouched);
  std::memcpy(bytes.data(), &last_field, sizeof(last_field));
  fill(reinterpret_cast<T*>(bytes.data()));
  EXPECT_THAT(Bytes(bytes.begin() + static_cast<std::ptrdiff_t>(last_field), bytes.end()), testing::Each(untouched));
  T filled{};
  std::memcpy(static_cast<void*>(&filled), bytes.data(), last_field);
  EXPECT_EQ(filled.size, last_field);
  return filled;
}

template <typename T>
void expect_initialized(const char* name, void (*init)(T*, size_t), size_t last_field) {
  T full;
  init(&full, sizeof(full));
  EXPECT_EQ(full.size, sizeof(T)) << name;
  filled_as_far_as_known<T>(name, last_field, [&](T* out) { init(out, last_field); });
}

#define SIDERAY_EXPECT_INIT(type, name, last) expect_initialized<type>(#name, sideray_##name##_init, offsetof(type, last))

TEST(Versions, DefaultsEndWhereTheCallersStructEnds) {
  SIDERAY_EXPECT_INIT(sideray_mesh_desc, mesh, colors);
  SIDERAY_EXPECT_INIT(sideray_material_desc, material, anisotropy);
  SIDERAY_EXPECT_INIT(sideray_wind_desc, wind, wavelength);
  SIDERAY_EXPECT_INIT(sideray_particles_desc, particles, lit);
  SIDERAY_EXPECT_INIT(sideray_light, light, shadow_filter_frames);
  SIDERAY_EXPECT_INIT(sideray_tracer_desc, tracer, isa);
  SIDERAY_EXPECT_INIT(sideray_shader_desc, shader, result_stride_bytes);
  SIDERAY_EXPECT_INIT(sideray_layer_inputs, layer_inputs, requested_bits);
  SIDERAY_EXPECT_INIT(sideray_mask_inputs, mask_inputs, shadow_bias_steps);
  SIDERAY_EXPECT_INIT(sideray_reflection_inputs, reflection_inputs, denoise);
  SIDERAY_EXPECT_INIT(sideray_frame_inputs, frame, view_id);
  SIDERAY_EXPECT_INIT(sideray_renderer_desc, renderer, host);
  SIDERAY_EXPECT_INIT(sideray_camera, camera, z_far);
  SIDERAY_EXPECT_INIT(sideray_translucency_options, translucency, bounces);
  SIDERAY_EXPECT_INIT(sideray_shadow_options, shadow, bias);
  SIDERAY_EXPECT_INIT(sideray_pose_options, pose, cull_angle_deg);
  SIDERAY_EXPECT_INIT(sideray_reference_options, reference, bounces);
  SIDERAY_EXPECT_INIT(sideray_raw_frame, raw_frame, is_flat);
  SIDERAY_EXPECT_INIT(sideray_diagnostics, diagnostics, raw_frame);
  SIDERAY_EXPECT_INIT(sideray_render_options, render, exposure);
  SIDERAY_EXPECT_INIT(sideray_object_truth_desc, object_truth, count);
  const auto camera = filled_as_far_as_known<sideray_camera>(
      "camera", offsetof(sideray_camera, z_far),
      [](sideray_camera* out) { sideray_camera_init(out, offsetof(sideray_camera, z_far)); });
  EXPECT_EQ(camera.z_near, sideray_camera_defaults().z_near);
  EXPECT_EQ(camera.world_from_camera[8], 1.0);
}

constexpr float corners[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0};

sideray_mesh_desc triangle() {
  sideray_mesh_desc mesh = sideray_mesh_defaults();
  mesh.vertex_count = 3;
  mesh.positions.data = corners;
  return mesh;
}

void shade_nothing(void*, const sideray_shading_point*, size_t, sideray_shading_result*) {}

TEST(Versions, DescriptionsOfSceneAndTracerMayBeOlderOrNewer) {
  Scene scene = Scene::create().value();
  expect_any_version("mesh", triangle(), offsetof(sideray_mesh_desc, colors), [&](const auto* desc, auto* error) {
    sideray_mesh mesh = 0;
    return sideray_scene_add_mesh(scene.get(), desc, &mesh, nullptr, error);
  });
  expect_any_version("material", sideray_material_defaults(),
                     offsetof(sideray_material_desc, diffuse_transmission_color_texture),
                     [&](const auto* desc, auto* error) {
                       sideray_material material = 0;
                       return sideray_scene_add_material(scene.get(), desc, &material, error);
                     });
  expect_any_version("wind", sideray_wind_defaults(), offsetof(sideray_wind_desc, wavelength),
                     [&](const auto* desc, auto* error) {
                       sideray_wind wind = 0;
                       return sideray_scene_add_wind(scene.get(), desc, &wind, error);
                     });
  expect_any_version("particles", sideray_particles_defaults(), offsetof(sideray_particles_desc, lit),
                     [&](const auto* desc, auto* error) {
                       sideray_particles particles = 0;
                       return sideray_scene_add_particles(scene.get(), desc, &particles, error);
                     });
  expect_any_version("light", sideray_light_defaults(), offsetof(sideray_light, shadow_filter_frames),
                     [&](const auto* light, auto* error) { return sideray_scene_set_lights(scene.get(), light, 1, error); });
  sideray_shader_desc shader = sideray_shader_defaults();
  shader.shade = shade_nothing;
  expect_any_version("shader", shader, offsetof(sideray_shader_desc, result_stride_bytes),
                     [&](const auto* desc, auto* error) { return sideray_scene_set_shader(scene.get(), desc, error); });
  expect_any_version("tracer", sideray_tracer_defaults(), offsetof(sideray_tracer_desc, isa),
                     [&](const auto* desc, auto* error) {
                       sideray_tracer* tracer = nullptr;
                       const sideray_status status = sideray_tracer_create(scene.get(), desc, &tracer, error);
                       if (tracer) sideray_tracer_release(tracer);
                       return status;
                     });
}

TEST(Versions, DescriptionsOfObjectTruthMayBeOlderOrNewer) {
  const Scene scene = pane_scene();
  const Tracer tracer = Tracer::create(scene).value();
  const sideray_camera camera = sideray_camera_defaults();
  sideray_object_truth_desc objects = sideray_object_truth_defaults();
  objects.camera = &camera;
  objects.width = objects.height = 4;
  expect_any_version("object truth", objects, offsetof(sideray_object_truth_desc, count),
                     [&](const auto* desc, auto* error) {
                       sideray_object_truths* truths = nullptr;
                       const sideray_status status = sideray_object_truths_create(tracer.get(), desc, &truths, error);
                       EXPECT_EQ(sideray_object_truths_count(truths), status == SIDERAY_OK ? 1u : 0u);
                       sideray_object_truths_release(truths);
                       return status;
                     });
}

TEST(Versions, DescriptionsOfLayeredDepthMayBeOlderOrNewer) {
  const Scene scene = pane_scene();
  const Tracer tracer = Tracer::create(scene).value();
  const sideray_camera camera = sideray_camera_defaults();
  sideray_layered_depth_desc layers = sideray_layered_depth_defaults();
  std::vector<uint32_t> counts(16);
  layers.camera = &camera;
  layers.width = layers.height = 4;
  layers.counts = counts.data();
  expect_any_version("layered depth", layers, offsetof(sideray_layered_depth_desc, faces),
                     [&](const auto* desc, auto* error) { return sideray_tracer_layered_depth(tracer.get(), desc, error); });
}

// Returns array elements of another version, `stride_bytes` apart, with unknown bytes set to `rest`.
template <typename T>
Bytes spread(std::span<const T> elements, size_t stride_bytes, std::byte rest) {
  Bytes bytes(stride_bytes * elements.size(), rest);
  for (size_t i = 0; i < elements.size(); ++i)
    std::memcpy(bytes.data() + i * stride_bytes, &elements[i], std::min(stride_bytes, sizeof(T)));
  return bytes;
}

TEST(Versions, ArraysHaveTheirCallersStrides) {
  for (const size_t more : {size_t{0}, size_t{16}}) {
    Scene scene = Scene::create().value();
    sideray_instance_desc descs[2] = {};
    for (size_t i = 0; i < 2; ++i) {
      descs[i].mesh = i == 0 ? scene.add_mesh(triangle()) : descs[0].mesh;
      descs[i].material = i == 0 ? scene.add_material(sideray_material_defaults()) : descs[0].material;
      for (const int k : {0, 4, 8}) descs[i].world_from_object[k] = 1.0;
      descs[i].world_from_object[11] = -static_cast<double>(i);
      descs[i].surface_id = static_cast<uint32_t>(i) + 1;
      descs[i].visibility = SIDERAY_VISIBLE_ALL;
    }
    // The older version lacks wind and its phase; the newer one has 16 unknown bytes.
    const size_t stride = more ? sizeof(descs[0]) + more : offsetof(sideray_instance_desc, wind);
    const Bytes instances = spread<sideray_instance_desc>(descs, stride, std::byte{0});
    sideray_error error{};
    ASSERT_EQ(sideray_scene_add_instances(scene.get(), reinterpret_cast<const sideray_instance_desc*>(instances.data()),
                                          stride, 2, nullptr, &error),
              SIDERAY_OK)
        << error.message;
    scene.commit();
    Tracer tracer = Tracer::create(scene).value();

    const sideray_ray rays[2] = {{{0.3, -0.3, 2}, {0, 0, -1}, 0, 10}, {{0.3, -0.3, -0.5}, {0, 0, -1}, 0, 10}};
    const size_t ray_stride = sizeof(sideray_ray) + more;
    const Bytes spread_rays = spread<sideray_ray>(rays, ray_stride, std::byte{0});
    const size_t hit_stride = sizeof(sideray_hit) + more;
    Bytes hits(2 * hit_stride, untouched);
    sideray_ray_batch batch = sideray_ray_batch_defaults();
    batch.rays = reinterpret_cast<const sideray_ray*>(spread_rays.data());
    batch.ray_stride_bytes = ray_stride;
    batch.count = 2;
    batch.hits = reinterpret_cast<sideray_hit*>(hits.data());
    batch.hit_stride_bytes = hit_stride;
    ASSERT_EQ(sideray_tracer_trace_rays(tracer.get(), &batch, &error), SIDERAY_OK) << error.message;
    for (size_t i = 0; i < 2; ++i) {
      sideray_hit hit{};
      std::memcpy(&hit, hits.data() + i * hit_stride, sizeof(hit));
      EXPECT_EQ(hit.surface_id, i + 1);
    }
    if (more) {
      EXPECT_EQ(hits[sizeof(sideray_hit) + 3], untouched) << "what the library does not know is not its to write";
    }
    batch.hit_stride_bytes = 3;
    EXPECT_EQ(sideray_tracer_trace_rays(tracer.get(), &batch, &error), SIDERAY_INVALID_ARGUMENT);
  }
}

class FrameVersions : public testing::Test {
 protected:
  FrameVersions() {
    const sideray_host_gl loader = host_.loader();
    EXPECT_EQ(sideray_service_create(host_.tracer(), &loader, &service_, nullptr), SIDERAY_OK);
    in_ = host_.inputs();
    for (const SmallHost::Case& c : SmallHost::cases())
      if (std::string(c.name) == "everything") c.ask(host_, in_);
  }
  ~FrameVersions() override { sideray_service_destroy(service_); }

  sideray_status trace(const sideray_frame_inputs* inputs, sideray_error* error) {
    const sideray_status status = sideray_service_submit(service_, inputs, &ticket_, error);
    return status == SIDERAY_OK ? sideray_service_wait(service_, ticket_, -1, error) : status;
  }

  SmallHost host_{gl::Context::create("auto", "")};
  FrameInputs in_;
  sideray_service* service_ = nullptr;
  sideray_ticket ticket_ = 0;
};

TEST_F(FrameVersions, InputsAndTheirJobsMayBeOlderOrNewer) {
  sideray_frame_inputs frame = in_.c();
  const auto traced_with = [&](auto sideray_frame_inputs::*job) {
    return [this, frame, job](const auto* inputs, sideray_error* error) {
      sideray_frame_inputs changed = frame;
      changed.*job = inputs;
      return trace(&changed, error);
    };
  };
  expect_any_version("frame", frame, offsetof(sideray_frame_inputs, view_id),
                     [&](const auto* inputs, auto* error) { return trace(inputs, error); });
  expect_any_version("layers", *in_.layers, offsetof(sideray_layer_inputs, requested_bits),
                     traced_with(&sideray_frame_inputs::layers));
  expect_any_version("masks", *in_.masks, offsetof(sideray_mask_inputs, shadow_bias_steps),
                     traced_with(&sideray_frame_inputs::masks));
  expect_any_version("reflections", *in_.reflections, offsetof(sideray_reflection_inputs, denoise),
                     traced_with(&sideray_frame_inputs::reflections));
  frame.source.reserved[14] = 1;
  sideray_error error{};
  EXPECT_EQ(trace(&frame, &error), SIDERAY_UNSUPPORTED);
  EXPECT_THAT(error.message, testing::HasSubstr("reserved"));
}

// Only at the rate FULL layers reuse rays.
TEST_F(FrameVersions, RatesOfVersion02AreFull) {
  in_.layers->ray_reuse = 0.5f;
  RenderOptions options;
  options.translucency->ray_reuse = 0.5f;
  const Scene scene = pane_scene();
  const auto expect = [&](int rate, sideray_status status) {
    in_.layers->cache_rate = options.translucency->cache_rate = static_cast<sideray_cache_rate>(rate);
    const sideray_frame_inputs frame = in_.c();
    EXPECT_EQ(trace(&frame, nullptr), status) << rate;
    sideray_plan* plan = nullptr;
    const sideray_render_options picture = options.c();
    EXPECT_EQ(sideray_plan_create(scene.get(), &picture, &plan, nullptr), status) << rate;
    sideray_plan_release(plan);
  };
  for (const int rate : {SIDERAY_RATE_FULL, SIDERAY_RATE_TEMPORAL4, SIDERAY_RATE_TEMPORAL8}) expect(rate, SIDERAY_OK);
  for (const int rate : {SIDERAY_RATE_QUARTER + 0, SIDERAY_RATE_TEMPORAL8 + 1}) expect(rate, SIDERAY_INVALID_ARGUMENT);
}

TEST_F(FrameVersions, OutputsAreFilledAsFarAsTheirCallerKnows) {
  const sideray_frame_inputs frame = in_.c();
  ASSERT_EQ(trace(&frame, nullptr), SIDERAY_OK);
  const auto newest = [&](auto read) {
    return [this, read](auto* out) { EXPECT_EQ(read(service_, 0, out, nullptr), SIDERAY_OK); };
  };
  FrameOutputs outputs;
  ASSERT_EQ(newest_outputs(service_, 0, outputs), SIDERAY_OK);
  ASSERT_TRUE(outputs.layers && outputs.masks && outputs.reflections);
  const auto layers = filled_as_far_as_known<sideray_layer_outputs>(
      "layers", offsetof(sideray_layer_outputs, surface_id_texture), newest(sideray_service_layers));
  EXPECT_EQ(layers.distance_texture, outputs.layers->distance_texture);
  const auto masks = filled_as_far_as_known<sideray_mask_outputs>("masks", offsetof(sideray_mask_outputs, ao_texture),
                                                                  newest(sideray_service_masks));
  EXPECT_EQ(masks.shadow_texture, outputs.masks->shadow_texture);
  const auto reflections = filled_as_far_as_known<sideray_reflection_outputs>(
      "reflections", offsetof(sideray_reflection_outputs, reflection_texture), newest(sideray_service_reflections));
  EXPECT_EQ(reflections.height, outputs.reflections->height);
  sideray_frame_stats stats{};
  stats.size = sizeof(stats);
  ASSERT_EQ(sideray_service_stats(service_, ticket_, &stats, nullptr), SIDERAY_OK);
  const auto fill = [&](auto* out) { EXPECT_EQ(sideray_service_stats(service_, ticket_, out, nullptr), SIDERAY_OK); };
  const auto known = filled_as_far_as_known<sideray_frame_stats>(
      "stats", offsetof(sideray_frame_stats, points_not_finite), fill);
  EXPECT_EQ(known.bytes_cache, stats.bytes_cache);
  sideray_mask_outputs none{};
  EXPECT_EQ(sideray_service_masks(service_, 0, &none, nullptr), SIDERAY_INVALID_ARGUMENT) << "its size is not set";
}

TEST_F(FrameVersions, TheLoaderMayBeNewer) {
  expect_any_version("host", host_.loader(), sizeof(sideray_host_gl), [&](const auto* host, auto* error) {
    sideray_service* service = nullptr;
    const sideray_status status = sideray_service_create(host_.tracer(), host, &service, error);
    sideray_service_destroy(service);
    return status;
  });
}

TEST(Versions, OptionsOfPicturesMayBeOlderOrNewer) {
  const Scene scene = pane_scene();
  const auto planned_with = [&](auto sideray_render_options::*part) {
    return [&scene, part](const auto* options, sideray_error* error) {
      sideray_render_options picture = sideray_render_defaults();
      picture.*part = options;
      sideray_plan* plan = nullptr;
      const sideray_status status = sideray_plan_create(scene.get(), &picture, &plan, error);
      sideray_plan_release(plan);
      return status;
    };
  };
  using Options = sideray_render_options;
  expect_any_version("translucency", sideray_translucency_defaults(), offsetof(sideray_translucency_options, check),
                     planned_with(&Options::translucency));
  expect_any_version("shadows", sideray_shadow_defaults(), offsetof(sideray_shadow_options, bias),
                     planned_with(&Options::shadows));
  expect_any_version("poses", sideray_pose_defaults(), offsetof(sideray_pose_options, cull_angle_deg),
                     planned_with(&Options::poses));
  expect_any_version("reference", sideray_reference_defaults(), offsetof(sideray_reference_options, refraction),
                     planned_with(&Options::reference));
  expect_any_version("diagnostics", sideray_diagnostics_defaults(), offsetof(sideray_diagnostics, raw_frame),
                     planned_with(&Options::diagnostics));
  expect_any_version("options", sideray_render_defaults(), offsetof(Options, exposure),
                     [&](const auto* options, auto* error) {
                       sideray_plan* plan = nullptr;
                       const sideray_status status = sideray_plan_create(scene.get(), options, &plan, error);
                       sideray_plan_release(plan);
                       return status;
                     });
  sideray_scene_facts facts{};
  facts.size = sizeof(facts);
  ASSERT_EQ(sideray_plan_scene(scene.get(), &facts, nullptr), SIDERAY_OK);
  const auto known = filled_as_far_as_known<sideray_scene_facts>(
      "facts", offsetof(sideray_scene_facts, has_environment),
      [&](auto* out) { EXPECT_EQ(sideray_plan_scene(scene.get(), out, nullptr), SIDERAY_OK); });
  EXPECT_EQ(known.triangles, facts.triangles);
}

TEST(Versions, RendererCameraAndStatisticsMayBeOlderOrNewer) {
  const Scene scene = pane_scene();
  expect_any_version("renderer", sideray_renderer_defaults(), offsetof(sideray_renderer_desc, host),
                     [&](const auto* desc, auto* error) {
                       sideray_renderer* renderer = nullptr;
                       const sideray_status status = sideray_renderer_create(desc, &renderer, error);
                       sideray_renderer_destroy(renderer);
                       return status;
                     });
  Renderer renderer = Renderer::create().value();
  sideray_camera camera = sideray_camera_defaults();
  camera.world_from_camera[11] = 3.0;
  sideray_render_options options = sideray_render_defaults();
  options.width = options.height = 16;
  expect_any_version("camera", camera, offsetof(sideray_camera, z_far), [&](const auto* any, auto* error) {
    sideray_picture* picture = nullptr;
    const sideray_status status = sideray_renderer_render(renderer.get(), scene.get(), any, &options, &picture, error);
    sideray_picture_release(picture);
    return status;
  });
  const Picture picture = renderer.render(scene, camera, options).value();
  const sideray_render_stats stats = picture.stats();
  sideray_picture* drawn = nullptr;
  ASSERT_EQ(sideray_renderer_render(renderer.get(), scene.get(), &camera, &options, &drawn, nullptr), SIDERAY_OK);
  const auto known = filled_as_far_as_known<sideray_render_stats>(
      "stats", offsetof(sideray_render_stats, embree),
      [&](auto* out) { EXPECT_EQ(sideray_picture_stats(drawn, out, nullptr), SIDERAY_OK); });
  EXPECT_EQ(known.triangles, stats.triangles);
  sideray_picture_release(drawn);
  options.repeats = 1;
  expect_any_version("raw frame", sideray_raw_frame_defaults(), offsetof(sideray_raw_frame, is_flat),
                     [&](const auto* given, auto* error) {
                       sideray_diagnostics diagnostics = sideray_diagnostics_defaults();
                       diagnostics.raw_frame = const_cast<sideray_raw_frame*>(given);
                       options.diagnostics = &diagnostics;
                       sideray_picture* made = nullptr;
                       const sideray_status status =
                           sideray_renderer_render(renderer.get(), scene.get(), &camera, &options, &made, error);
                       sideray_picture_release(made);
                       return status;
                     });
}

}  // namespace
}  // namespace sideray::tests::versions_test
