// Tests ground truth through the public interface: compared with the rasterizer, and of whole objects.
#include <sideray/ground_truth.hpp>

#include <gmock/gmock.h>

#include <cmath>
#include <cstring>

#include "frame/frame.h"
#include "scenes/builtin/builtin.h"

namespace sideray::tests::ground_truth_test {
namespace {

constexpr uint32_t every_truth =
    SIDERAY_AOV_FIRST | SIDERAY_AOV_GLASS | SIDERAY_AOV_BEHIND | SIDERAY_AOV_REFRACTION;

// Returns the share of pixels where both planes are equal.
template <typename T>
double share_equal(const std::vector<T>& a, const std::vector<T>& b) {
  size_t equal = 0;
  for (size_t i = 0; i < a.size(); ++i) equal += a[i] == b[i];
  return static_cast<double>(equal) / static_cast<double>(a.size());
}

bool same_bits(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

TEST(GroundTruthChannels, AreWhatTheRasterizerDraws) {
  for (const char* scene : {"crossing", "panes", "solids"}) {
    const scenes::Content content = scenes::generate(scene, {});
    const Frame frame =
        render(content, {.width = 160, .height = 90, .translucency = SIDERAY_TRANSLUCENCY_RASTER,
                         .aovs = every_truth | SIDERAY_AOV_Z | SIDERAY_AOV_ID | SIDERAY_AOV_MASK | SIDERAY_AOV_NORMAL});
    const std::vector<uint32_t>&glass = frame.uint_planes.at("glass.primitive"),
                               &count = frame.uint_planes.at("mask.count"), &id = frame.uint_planes.at("id.surface");
    size_t agreeing = 0, without = 0, same_id = 0;
    for (size_t i = 0; i < glass.size(); ++i) {
      agreeing += (glass[i] != 0) == (count[i] != 0);
      if (frame.uint_planes.at("behind.turns")[i] != 0) continue;
      ++without;
      if (frame.uint_planes.at("behind.surface")[i] != id[i]) continue;
      ++same_id;
      const float z = frame.planes.at("Z")[i], own = frame.planes.at("behind.Z")[i];
      if (std::isinf(z)) {
        EXPECT_EQ(own, z);
      } else {
        EXPECT_NEAR(own, z, 1e-3f * z);
        if (frame.uint_planes.at("behind.primitive")[i] != frame.uint_planes.at("id.primitive")[i]) continue;
        EXPECT_NEAR(frame.planes.at("behind.N.Y")[i], frame.planes.at("N.Y")[i], 0.05f);
      }
      if (glass[i] == 0) {
        EXPECT_EQ(frame.uint_planes.at("first.surface")[i], id[i]);
        EXPECT_EQ(frame.planes.at("first.Z")[i], own);
      } else {
        EXPECT_EQ(frame.planes.at("first.Z")[i], frame.planes.at("glass.Z")[i]);
        EXPECT_LE(frame.planes.at("glass.Z")[i], own);
      }
    }
    // Edges come from rasterization there and from rays here.
    EXPECT_GT(static_cast<double>(agreeing), 0.99 * static_cast<double>(glass.size())) << scene;
    EXPECT_GT(static_cast<double>(same_id), 0.99 * static_cast<double>(without)) << scene;
    EXPECT_GT(without, glass.size() / 3) << scene;
  }
}

// Rays of ground truth do not change the frame: poses, culling, history.
TEST(GroundTruthChannels, ChangeNothingElse) {
  const scenes::Content forest = scenes::generate("forest", {{"count", "20"}}), solids = scenes::generate("solids", {});
  for (const sideray_translucency method : {SIDERAY_TRANSLUCENCY_RASTER, SIDERAY_TRANSLUCENCY_HYBRID})
    for (const scenes::Content* content : {&forest, &solids}) {
      tests::Setup setup{.width = 64, .height = 36, .translucency = method, .shadows = SIDERAY_SHADOWS_EXACT, .samples = 2};
      if (method == SIDERAY_TRANSLUCENCY_RASTER) setup.shadows = SIDERAY_SHADOWS_MAP;
      setup.poses = SIDERAY_POSES_REST;
      setup.refraction = true;
      setup.time_s = 1.3;
      const Frame without = render(*content, setup);
      setup.aovs = every_truth;
      const Frame with = render(*content, setup);
      for (const auto& [name, values] : without.planes) EXPECT_TRUE(same_bits(values, with.planes.at(name))) << name;
    }
}

// Ground truth has the drawn poses of plants and small objects, whatever the frame's own rays hit.
TEST(GroundTruthChannels, MeetTheSceneAsItIsDrawn) {
  const scenes::Content content = scenes::generate("forest", {{"count", "40"}});
  tests::Setup setup{.width = 160, .height = 90, .translucency = SIDERAY_TRANSLUCENCY_RASTER,
              .shadows = SIDERAY_SHADOWS_EXACT, .aovs = SIDERAY_AOV_BEHIND | SIDERAY_AOV_ID, .time_s = 1.3};
  setup.poses = SIDERAY_POSES_REST;
  const Frame sways = render(content, setup);
  setup.time_s = 0;
  const Frame stands = render(content, setup);
  const auto agreement = [](const Frame& rays, const Frame& drawn) {
    return share_equal(rays.uint_planes.at("behind.primitive"), drawn.uint_planes.at("id.primitive"));
  };
  // Edges of leaves come from rasterization there and from rays here, with or without wind.
  EXPECT_GT(agreement(sways, sways), agreement(stands, stands) - 0.01);
  EXPECT_LT(agreement(stands, sways), agreement(sways, sways) - 0.02);
}

// They do not depend on the positions of the samples that are averaged for colours.
TEST(GroundTruthChannels, AreTheSameInAReferenceOfManySamples) {
  const scenes::Content content = scenes::generate("solids", {});
  tests::Setup setup{.width = 64, .height = 36, .aovs = every_truth};
  const Frame raster = render(content, setup);
  setup.samples = 2;
  EXPECT_EQ(render(content, setup).uint_planes, raster.uint_planes);
  setup.reference = true;
  setup.light_samples = 1;
  const Frame reference = render(content, setup);
  for (const auto& [name, values] : raster.uint_planes) EXPECT_EQ(values, reference.uint_planes.at(name)) << name;
  for (const auto& [name, values] : raster.planes)
    if (name.size() > 1) {
      EXPECT_TRUE(same_bits(values, reference.planes.at(name))) << name;
    }
  EXPECT_EQ(raster.uint_planes.size(), 2u + 2u + 4u + 1u);
  EXPECT_EQ(raster.planes.size(), 4u + 4u + 4u + 5u + 2u);
}

sideray_camera side_camera(bool orthographic) {
  sideray_camera camera = sideray_camera_defaults();
  // The pose is far from the world's origin, turned about y.
  const double s = std::sin(0.3), c = std::cos(0.3), far = 1e5;
  const double pose[12] = {c, 0, -s, 0, 1, 0, s, 0, c, far, 2.0, far};
  std::copy_n(pose, 12, camera.world_from_camera);
  camera.orthographic = orthographic;
  camera.half_height = 1.5f;
  camera.z_near = 0.5f;
  camera.z_far = orthographic ? 20.0f : 0.0f;
  return camera;
}

// A wall across the view and a pane in front of it; both face the camera.
class TwoQuads {
 public:
  explicit TwoQuads(const sideray_camera& camera) : scene(Scene::create().value()) {
    const float corners[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
    const uint32_t indices[] = {0, 1, 2, 0, 2, 3};
    sideray_mesh_desc mesh = sideray_mesh_defaults();
    mesh.vertex_count = 4, mesh.index_count = 6;
    mesh.positions = {corners, 0};
    mesh.indices = indices;
    const sideray_mesh quad = scene.add_mesh(mesh);
    sideray_material_desc pane = sideray_material_defaults();
    pane.alpha_mode = SIDERAY_BLEND;
    pane.base_color[3] = 0.5f;
    const sideray_material materials[] = {scene.add_material(sideray_material_defaults()), scene.add_material(pane)};
    for (uint32_t i = 0; i < 2; ++i) {
      sideray_instance_desc instance{};
      instance.mesh = quad;
      instance.material = materials[i];
      const double size = i == 0 ? 10 : 1, away = i == 0 ? 8 : 4;
      for (int r = 0; r < 3; ++r) {
        for (int k = 0; k < 3; ++k) instance.world_from_object[3 * k + r] = camera.world_from_camera[3 * k + r] * size;
        instance.world_from_object[9 + r] = camera.world_from_camera[9 + r] - camera.world_from_camera[6 + r] * away;
      }
      instance.surface_id = 10 * (i + 1);
      instance.visibility = SIDERAY_VISIBLE_ALL;
      scene.add_instances({&instance, 1});
    }
    scene.commit();
  }
  Scene scene;
};

TEST(CameraRays, AreThoseOfThePixels) {
  for (const int kind : {0, 1, 2, 3}) {
    const bool orthographic = kind % 2 == 1;
    sideray_camera camera = side_camera(orthographic);
    if (kind >= 2) camera.fx_per_fy = 1.25f, camera.shift_x = 0.125f, camera.shift_y = -0.0625f;
    const TwoQuads quads(camera);
    constexpr uint32_t width = 33, height = 21;
    RenderOptions options;
    options.picture.ambient = options.picture.reflections = 0;
    options.picture.width = width, options.picture.height = height;
    options.picture.aovs = SIDERAY_AOV_BEHIND | SIDERAY_AOV_Z;
    Renderer renderer = Renderer::create().value();
    const Picture picture = renderer.render(quads.scene, camera, options).value();
    const std::vector<sideray_ray> rays = camera_rays(camera, width, height);
    Tracer tracer = Tracer::create(quads.scene).value();
    const std::vector<sideray_hit> hits = tracer.trace(SIDERAY_RAYS_OPAQUE, rays);
    const float *z = nullptr, *raster_z = nullptr;
    for (size_t i = 0; i < picture.channel_count(); ++i) {
      const sideray_channel channel = picture.channel(i);
      if (std::string(channel.name) == "behind.Z") z = static_cast<const float*>(channel.values);
      if (std::string(channel.name) == "Z") raster_z = static_cast<const float*>(channel.values);
    }
    const double* m = camera.world_from_camera;
    for (size_t i = 0; i < rays.size(); ++i) {
      double along = 0, across = 0, length = 0;
      for (int k = 0; k < 3; ++k) {
        along -= double{rays[i].direction[k]} * m[6 + k];
        across += double{rays[i].direction[k]} * m[k];
        length += double{rays[i].direction[k]} * double{rays[i].direction[k]};
      }
      EXPECT_NEAR(length, 1.0, 1e-6);
      const double start = orthographic ? double{camera.z_near} : 0.0;
      EXPECT_NEAR(double{z[i]}, start + hits[i].distance * along, 2e-5);
      EXPECT_NEAR(double{raster_z[i]}, 8.0, 1e-3);
      EXPECT_NEAR(double{z[i]}, 8.0, 1e-2);  // floats beside an origin 10^5 away
      EXPECT_NEAR(start + double{rays[i].t_near} * along, double{camera.z_near}, 1e-6);
      // Columns go right.
      const double ndc =
          ((static_cast<double>(i % width) + 0.5) / width * 2 - 1 - 2 * double{camera.shift_x}) / double{camera.fx_per_fy};
      const double half = orthographic ? 0.0 : std::tan(0.5 * double{camera.yfov}) * width / height;
      EXPECT_NEAR(across / along, ndc * half, 1e-6);
    }
    // Rows go down: the first ray passes above the last one.
    const sideray_ray &first = rays.front(), &last = rays.back();
    EXPECT_GT(first.origin[1] + double{first.direction[1]}, last.origin[1] + double{last.direction[1]});
  }
}

TEST(CameraRays, AreRefusedWithAReason) {
  sideray_error error{};
  sideray_camera camera = sideray_camera_defaults();
  std::vector<sideray_ray> rays(4);
  const auto status = [&](const sideray_camera* c, uint32_t width, sideray_ray* out, size_t stride) {
    return sideray_camera_rays(c, width, 2, out, stride, &error);
  };
  EXPECT_EQ(status(nullptr, 2, rays.data(), sizeof(sideray_ray)), SIDERAY_INVALID_ARGUMENT);
  EXPECT_THAT(error.message, testing::HasSubstr("camera"));
  EXPECT_EQ(status(&camera, 0, rays.data(), sizeof(sideray_ray)), SIDERAY_INVALID_ARGUMENT);
  EXPECT_THAT(error.message, testing::HasSubstr("0x2"));
  EXPECT_EQ(status(&camera, 2, nullptr, sizeof(sideray_ray)), SIDERAY_INVALID_ARGUMENT);
  EXPECT_EQ(status(&camera, 2, rays.data(), 3), SIDERAY_INVALID_ARGUMENT);
  camera.z_near = -1;
  EXPECT_EQ(status(&camera, 2, rays.data(), sizeof(sideray_ray)), SIDERAY_INVALID_ARGUMENT);
  EXPECT_THAT(error.message, testing::HasSubstr("z_near"));
}

class ObjectTruthApi : public testing::Test {
 protected:
  ObjectTruthApi() {
    desc_.camera = &camera_;
    desc_.width = 40, desc_.height = 30;
  }
  sideray_status refused(const char* with) {
    sideray_object_truths* truths = nullptr;
    const sideray_status status = sideray_object_truths_create(tracer_.get(), &desc_, &truths, &error_);
    EXPECT_EQ(truths, nullptr);
    EXPECT_THAT(error_.message, testing::HasSubstr(with));
    return status;
  }
  sideray_camera camera_ = side_camera(false);
  TwoQuads quads_{camera_};
  Tracer tracer_ = Tracer::create(quads_.scene).value();
  sideray_object_truth_desc desc_ = sideray_object_truth_defaults();
  sideray_error error_{};
};

TEST_F(ObjectTruthApi, NumbersObjectsBySurfaceOrByName) {
  const ObjectTruths truths = ObjectTruths::create(tracer_, desc_).value();
  ASSERT_EQ(truths.size(), 2u);
  const sideray_object_truth &wall = truths[0], &pane = truths[1];
  EXPECT_EQ(wall.object, 10u);
  EXPECT_EQ(pane.object, 20u);
  EXPECT_EQ(wall.amodal.pixels, 1200u);
  EXPECT_EQ(wall.visible.pixels + pane.visible.pixels, 1200u);
  EXPECT_EQ(pane.visible.pixels, pane.amodal.pixels);
  EXPECT_EQ(pane.visible_fraction, 1.0);
  // The pane's side is 2 of 2 * 4 * tan(22.5 degrees) in 30 pixels, in the picture's middle.
  const double side = 30 / (4 * std::tan(0.5 * double{camera_.yfov}));
  EXPECT_NEAR(pane.coverage, side * side, 0.25 * 4 * side / 4);
  EXPECT_EQ(pane.amodal.x, (40 - pane.amodal.width) / 2);
  EXPECT_EQ(pane.amodal.y, (30 - pane.amodal.height) / 2);
  EXPECT_NEAR(wall.visible_fraction, 1 - pane.coverage / 1200, 1e-12);
  const uint32_t surfaces[] = {10, 20}, objects[] = {7, 7};
  desc_.surface_ids = surfaces, desc_.objects = objects, desc_.count = 2;
  const ObjectTruths one = ObjectTruths::create(tracer_, desc_).value();
  ASSERT_EQ(one.size(), 1u);
  EXPECT_EQ(one[0].object, 7u);
  EXPECT_EQ(one[0].visible.pixels, 1200u);
  desc_.hidden_by = SIDERAY_HIDDEN_BY_OPAQUE;
  desc_.surface_ids = nullptr;
  EXPECT_EQ(ObjectTruths::create(tracer_, desc_).value()[0].visible.pixels, 1200u);
  desc_.hidden_by = SIDERAY_HIDDEN_BY_ALL;
  desc_.surface_ids = surfaces, desc_.count = 1;
  const ObjectTruths rest = ObjectTruths::create(tracer_, desc_).value();
  ASSERT_EQ(rest.size(), 1u);
  EXPECT_EQ(rest[0].visible.pixels, wall.visible.pixels) << "what has no name hides all the same";
}

TEST_F(ObjectTruthApi, RefusesWithAReason) {
  const uint32_t surfaces[] = {10, 10}, missing[] = {11, 20}, objects[] = {1, 2}, none[] = {0, 1};
  desc_.surface_ids = surfaces, desc_.objects = objects, desc_.count = 2;
  EXPECT_EQ(refused("named twice"), SIDERAY_INVALID_ARGUMENT);
  desc_.surface_ids = missing;
  EXPECT_EQ(refused("surface id 11"), SIDERAY_INVALID_ARGUMENT);
  desc_.objects = none;
  EXPECT_EQ(refused("entry 0"), SIDERAY_INVALID_ARGUMENT);
  desc_.objects = nullptr;
  EXPECT_EQ(refused("objects"), SIDERAY_INVALID_ARGUMENT);
  desc_.surface_ids = nullptr;
  desc_.samples_per_side = 17;
  EXPECT_EQ(refused("samples_per_side 17"), SIDERAY_INVALID_ARGUMENT);
  desc_.samples_per_side = 1, desc_.width = 0;
  EXPECT_EQ(refused("0x30"), SIDERAY_INVALID_ARGUMENT);
  desc_.width = 40, desc_.camera = nullptr;
  EXPECT_EQ(refused("camera"), SIDERAY_INVALID_ARGUMENT);
  desc_.camera = &camera_;
  desc_.hidden_by = static_cast<sideray_hidden_by>(2);
  EXPECT_EQ(refused("hidden_by 2"), SIDERAY_INVALID_ARGUMENT);
  EXPECT_EQ(sideray_object_truths_at(nullptr, 0), nullptr);
  EXPECT_EQ(sideray_object_truths_count(nullptr), 0u);
  sideray_object_truths_release(nullptr);
}

TEST_F(ObjectTruthApi, LayersAreThoseOfBothKindsOfSurface) {
  sideray_layered_depth_desc desc = sideray_layered_depth_defaults();
  std::vector<uint32_t> counts(1200), surfaces(4800);
  std::vector<uint8_t> kinds(4800);
  desc.camera = &camera_, desc.width = 40, desc.height = 30, desc.layers = 4;
  desc.counts = counts.data(), desc.surface_ids = surfaces.data(), desc.kinds = kinds.data();
  layered_depth(tracer_, desc);
  const size_t middle = 15 * 40 + 20;
  EXPECT_EQ(counts[middle], 2u);
  EXPECT_EQ(surfaces[4 * middle], 20u);
  EXPECT_EQ(surfaces[4 * middle + 1], 10u);
  EXPECT_GE(kinds[4 * middle], SIDERAY_KIND_BLEND);
  EXPECT_EQ(kinds[4 * middle + 1], SIDERAY_KIND_OPAQUE);
  const auto refused_layers = [&](const char* with) {
    EXPECT_EQ(sideray_tracer_layered_depth(tracer_.get(), &desc, &error_), SIDERAY_INVALID_ARGUMENT);
    EXPECT_THAT(error_.message, testing::HasSubstr(with));
  };
  desc.layers = 65;
  refused_layers("layers 65");
  desc.layers = 1, desc.path = static_cast<sideray_layer_path>(2);
  refused_layers("path 2");
  desc.path = SIDERAY_LAYERS_BENT, desc.height = 16385;
  refused_layers("40x16385");
  desc.height = 1, desc.camera = nullptr;
  refused_layers("camera");
}

}  // namespace
}  // namespace sideray::tests::ground_truth_test
