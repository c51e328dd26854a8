// Tests that any accepted scene is drawn without a crash and without NaN, and that harmful input is refused with one
// line.
#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include "frame/frame.h"

namespace sideray::tests {
namespace {

constexpr float nan_float = std::numeric_limits<float>::quiet_NaN();
constexpr float infinite = std::numeric_limits<float>::infinity();
constexpr float denormal = std::numeric_limits<float>::denorm_min();
constexpr float largest = std::numeric_limits<float>::max();

// A square that fills the view, and a square of glass; every test damages one value.
struct Hostile {
  std::vector<float> positions{-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0}, normals{0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1},
      tangents{1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1}, uv{0, 0, 1, 0, 1, 1, 0, 1},
      colors{1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1};
  std::vector<uint32_t> indices{0, 1, 2, 0, 2, 3};
  double transform[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
  sideray_material_desc material = sideray_material_defaults();
  std::vector<sideray_light> lights;
  sideray_camera camera{};

  Hostile() {
    sideray_light sun{};
    sun.size = sizeof(sun);
    sun.type = SIDERAY_LIGHT_DIRECTIONAL;
    sun.direction[2] = -1;
    std::fill_n(sun.intensity, 3, 1.0f);
    sideray_light bulb = sun;
    bulb.type = SIDERAY_LIGHT_POINT;
    bulb.position[2] = 2;
    lights = {sun, bulb};
    const double eye[3] = {0, 0, 3}, target[3] = {0, 0, 0};
    camera = scenes::look_at(eye, target, 45.0f);
  }

  void fill(Scene& scene) const {
    const uint8_t texels[16] = {255, 0, 0, 255, 0, 255, 0, 128, 0, 0, 255, 255, 255, 255, 255, 0};
    const sideray_texture texture = scene.add_texture(2, 2, SIDERAY_RGBA8_SRGB, texels);
    sideray_mesh_desc mesh = sideray_mesh_defaults();
    mesh.vertex_count = static_cast<uint32_t>(positions.size() / 3);
    mesh.index_count = static_cast<uint32_t>(indices.size());
    mesh.indices = indices.data();
    mesh.positions = {positions.data(), 0};
    mesh.normals = {normals.data(), 0};
    mesh.tangents = {tangents.data(), 0};
    mesh.uv0 = {uv.data(), 0};
    mesh.colors = {colors.data(), 0};
    sideray_material_desc front = material;
    front.double_sided = 1;
    front.base_color_texture.texture = front.normal_texture.texture = texture;
    sideray_material_desc glass = front;
    glass.alpha_mode = SIDERAY_BLEND;
    const sideray_material materials[2] = {scene.add_material(front), scene.add_material(glass)};
    const sideray_mesh shape = scene.add_mesh(mesh);
    sideray_instance_desc instances[2] = {};
    for (uint32_t i = 0; i < 2; ++i) {
      instances[i].mesh = shape;
      instances[i].material = materials[i];
      std::copy_n(transform, 12, instances[i].world_from_object);
      instances[i].world_from_object[11] += 0.5 * i;
      instances[i].surface_id = i + 1;
      instances[i].visibility = SIDERAY_VISIBLE_ALL;
    }
    scene.add_instances(instances);
    scene.set_lights(lights);
    scene.commit();
  }
};

// Its light has one small shadow map, where the sun's and a bulb's take most of a picture's time.
Hostile lit_by_a_spot() {
  Hostile hostile;
  sideray_light spot = hostile.lights[1];
  spot.type = SIDERAY_LIGHT_SPOT;
  spot.outer_cone = 1.0f;  // the map shows far more than the squares
  hostile.lights = {spot};
  return hostile;
}

// Returns "" where the scene is drawn and no value is NaN, else the message of the refusal. Each scene is drawn in one of
// two ways by chance, the same in each run.
std::string drawn(const Hostile& hostile) {
  static Renderer renderer = Renderer::create(sideray_renderer_defaults()).value();
  static std::minstd_rand random;
  Scene scene = Scene::create().value();
  try {
    hostile.fill(scene);
    RenderOptions options;
    options.picture.width = options.picture.height = 16;
    options.translucency->method = random() % 2 == 0 ? SIDERAY_TRANSLUCENCY_HYBRID : SIDERAY_TRANSLUCENCY_RAYTRACED;
    const Picture picture = renderer.render(scene, hostile.camera, options).value();
    for (size_t c = 0; c < picture.channel_count(); ++c) {
      const sideray_channel channel = picture.channel(c);
      if (channel.type == SIDERAY_CHANNEL_UINT) continue;
      for (size_t i = 0; i < 256; ++i)
        EXPECT_FALSE(std::isnan(static_cast<const float*>(channel.values)[i])) << channel.name << " at " << i;
    }
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::MatchesRegex("[^\n]+: [^\n]+"));
    return error.what();
  }
  return "";
}

TEST(HostileScene, AnyNumberInAMeshIsDrawnOrLeftOut) {
  EXPECT_EQ(drawn({}), "");
  using List = std::vector<float> Hostile::*;
  for (const List list : {&Hostile::positions, &Hostile::normals, &Hostile::tangents, &Hostile::uv, &Hostile::colors}) {
    for (const float value : {nan_float, infinite, -infinite, denormal, largest, -largest, 0.0f, 1e15f, 1e30f}) {
      SCOPED_TRACE(value);
      // Shadow maps have positions alone.
      Hostile one = list == &Hostile::positions ? Hostile() : lit_by_a_spot(), all = one;
      (one.*list)[1] = value;
      std::fill((all.*list).begin(), (all.*list).end(), value);
      EXPECT_EQ(drawn(one), "");
      EXPECT_EQ(drawn(all), "");
    }
  }
}

TEST(HostileScene, IndicesOutOfRangeAreRefused) {
  for (const uint32_t index : {4u, 0x7fffffffu, 0xffffffffu}) {
    Hostile hostile;
    hostile.indices[4] = index;
    EXPECT_THAT(drawn(hostile), testing::HasSubstr("not below vertex_count"));
  }
}

TEST(HostileScene, AnyTransformIsDrawnOrRefused) {
  constexpr double nan_double = std::numeric_limits<double>::quiet_NaN();
  for (size_t i = 0; i < 12; ++i) {
    for (const double value : {nan_double, HUGE_VAL, -HUGE_VAL, 1e300, 2e15}) {
      Hostile hostile;
      hostile.transform[i] = value;
      EXPECT_NE(drawn(hostile), "") << i << " is " << value;
    }
    for (const double value : {1e15, -1e15, 1e-300, 0.0, 1e-9}) {
      SCOPED_TRACE(value);
      Hostile hostile;
      hostile.transform[i] = value;
      drawn(hostile);
    }
  }
  for (const double scale : {0.0, 1e-300, 1e-11, 1e-9, 1e9, 1e15}) {
    SCOPED_TRACE(scale);
    Hostile hostile;
    for (const size_t i : {0u, 4u, 8u}) hostile.transform[i] = scale;
    const std::string message = drawn(hostile);
    EXPECT_EQ(message.empty(), scale >= 1e-9) << message;
  }
  // The largest and the smallest scale together make an inverse beyond the range of floats.
  Hostile thin;
  thin.transform[0] = thin.transform[4] = 1e15, thin.transform[8] = 1e-59;
  drawn(thin);
}

TEST(HostileScene, LargeCoordinatesTimesLargeScales) {
  Hostile hostile;
  for (float& p : hostile.positions) p *= 1e15f;
  for (const size_t i : {0u, 4u, 8u}) hostile.transform[i] = 1e15;
  drawn(hostile);
}

TEST(HostileScene, AnyLightIsDrawnOrRefused) {
  using Damage = std::function<void(sideray_light&, float)>;
  const Damage damages[] = {[](sideray_light& l, float v) { l.intensity[1] = v; },
                            [](sideray_light& l, float v) { l.direction[0] = v; },
                            [](sideray_light& l, float v) { l.position[0] = double{v}; },
                            [](sideray_light& l, float v) { l.range = v; },
                            [](sideray_light& l, float v) { l.radius = v; },
                            [](sideray_light& l, float v) { l.angular_diameter_deg = v; },
                            [](sideray_light& l, float v) { l.inner_cone = v; },
                            [](sideray_light& l, float v) { l.outer_cone = v; }};
  for (const sideray_light_type type : {SIDERAY_LIGHT_DIRECTIONAL, SIDERAY_LIGHT_POINT, SIDERAY_LIGHT_SPOT}) {
    for (size_t d = 0; d < std::size(damages); ++d) {
      for (const float value : {nan_float, infinite, -infinite, denormal, largest, -largest, 0.0f, -1.0f}) {
        SCOPED_TRACE(testing::Message() << "type " << type << ", damage " << d << ", value " << value);
        Hostile hostile;
        sideray_light& light = hostile.lights[1];
        light.type = type;
        light.outer_cone = 0.5f;
        damages[d](light, value);
        hostile.lights = {light};  // another one's shadow map would take most of the time
        drawn(hostile);
      }
    }
  }
}

TEST(HostileScene, AnyMaterialIsDrawnOrRefused) {
  using Member = float sideray_material_desc::*;
  using D = sideray_material_desc;
  for (const Member member : {&D::metallic, &D::roughness, &D::transmission, &D::ior, &D::thickness, &D::specular,
                              &D::attenuation_distance, &D::normal_scale, &D::alpha_cutoff, &D::occlusion_strength,
                              &D::clearcoat, &D::clearcoat_roughness, &D::sheen_roughness, &D::diffuse_transmission,
                              &D::iridescence, &D::iridescence_ior, &D::iridescence_thickness_min,
                              &D::iridescence_thickness_max, &D::anisotropy, &D::anisotropy_rotation}) {
    for (const float value : {nan_float, infinite, -infinite, denormal, largest, -largest, 0.0f, 1.0f, 99.0f}) {
      SCOPED_TRACE(value);
      Hostile hostile = lit_by_a_spot();
      hostile.material.*member = value;
      drawn(hostile);
    }
  }
  for (const float value : {nan_float, infinite, denormal, largest, -1.0f}) {
    SCOPED_TRACE(value);
    Hostile color = lit_by_a_spot(), emission = color;
    color.material.base_color[0] = value;
    drawn(color);
    emission.material.emissive[2] = value;
    drawn(emission);
    for (size_t i = 0; i < 6; ++i) {
      Hostile moved = lit_by_a_spot();
      moved.material.base_color_texture.texture_from_uv[i] = value;
      drawn(moved);
    }
  }
}

TEST(HostileScene, CamerasThatScaleOrShearAreRefused) {
  for (const double value : {0.0, 0.9, 1.1, 1e15, 1e300}) {
    Hostile scaled, sheared;
    scaled.camera.world_from_camera[4] = value;
    EXPECT_THAT(drawn(scaled), testing::HasSubstr("is no rotation")) << value;
    sheared.camera.world_from_camera[3] = 1.0 + value;
    EXPECT_THAT(drawn(sheared), testing::HasSubstr("is no rotation")) << value;
  }
  Hostile rounded, far;
  for (double& value : rounded.camera.world_from_camera) value = static_cast<double>(static_cast<float>(value)) * 1.0001;
  EXPECT_EQ(drawn(rounded), "");
  far.camera.world_from_camera[10] = 1e16;
  EXPECT_THAT(drawn(far), testing::HasSubstr("position"));
}

TEST(HostileScene, AnyCameraIsDrawnOrRefused) {
  for (size_t i = 0; i < 12; ++i) {
    for (const double value : {std::nan(""), HUGE_VAL, 1e300, 1e15, 0.0}) {
      SCOPED_TRACE(value);
      Hostile hostile;
      hostile.camera.world_from_camera[i] = value;
      const std::string message = drawn(hostile);
      EXPECT_TRUE(std::isfinite(value) || !message.empty());
    }
  }
}

}  // namespace
}  // namespace sideray::tests
