#include <gmock/gmock.h>

#include <cmath>
#include <glm/glm.hpp>

#include "scenes/builtin/builtin.h"
#include "scenes/support.h"

namespace sideray::scenes {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

// Four unit quads in the z = 0 plane: an opaque one, smooth glass, rough glass that is marked, and a multiply decal.
Content four_quads() {
  Content content;
  Mesh quad{.name = "quad",
            .positions = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0},
            .normals = {},
            .tangents = {},
            .uv0 = {},
            .uv1 = {},
            .colors = {},
            .indices = {0, 1, 2, 0, 2, 3}};
  content.meshes = {quad};
  const char* names[] = {"wall", "glass.small", "glass.big", "decal"};
  for (uint32_t i = 0; i < 4; ++i) {
    Material material;
    material.name = names[i];
    material.desc = sideray_material_defaults();
    material.desc.roughness = 0.1f;
    if (i > 0) material.desc.alpha_mode = SIDERAY_BLEND;
    content.materials.push_back(material);
    Object object{.name = names[i], .mesh = 0, .material = i};
    const double scale = i == 2 ? 2.0 : 1.0;
    const double m[12] = {scale, 0, 0, 0, scale, 0, 0, 0, 1, 0, 0, 0};
    std::copy_n(m, 12, object.world_from_object);
    content.objects.push_back(object);
  }
  content.materials[2].desc.roughness = 0.9f;
  content.materials[3].desc.blend_mode = SIDERAY_BLEND_MULTIPLY;
  return content;
}

sideray_camera in_front() {
  const double eye[3] = {0.5, 0.5, 5}, target[3] = {0.5, 0.5, 0};
  return look_at(eye, target, 45.0f);
}

std::vector<bool> selected(const Content& content, const std::string& selection) {
  return select_ray_traced(content, selection, in_front(), 640, 360);
}

TEST(Selection, AutoTakesMarksAndSmoothGlass) {
  Content content = four_quads();
  EXPECT_THAT(selected(content, "auto"), ElementsAre(false, true, false, false));
  content.materials[2].ray_traced = RayTraced::yes;
  content.materials[1].ray_traced = RayTraced::no;
  EXPECT_THAT(selected(content, "auto"), ElementsAre(false, false, true, false));
}

// Only rays blur the view through it.
TEST(Selection, AutoTakesRoughGlass) {
  Content content = four_quads();
  content.materials[2].desc.transmission = 1.0f;
  EXPECT_THAT(selected(content, "auto"), ElementsAre(false, true, true, false));
  content.materials[2].ray_traced = RayTraced::no;
  EXPECT_THAT(selected(content, "auto"), ElementsAre(false, true, false, false));
}

// A roughness of 1 says nothing where a texture is multiplied onto it.
TEST(Selection, AutoReadsTheMeanOfTheRoughnessTexture) {
  Content content = four_quads();
  content.textures.push_back({.name = "roughness", .width = 2, .height = 1, .rgba = {255, 20, 255, 255, 0, 80, 0, 255}});
  content.materials[2].desc.roughness = 1.0f;
  EXPECT_THAT(selected(content, "auto"), ElementsAre(false, true, false, false));
  content.materials[2].desc.metallic_roughness_texture.texture = 1;
  EXPECT_THAT(selected(content, "auto"), ElementsAre(false, true, true, false));
  content.textures[0].rgba = {0, 255, 0, 255, 0, 80, 0, 255};
  EXPECT_THAT(selected(content, "auto"), ElementsAre(false, true, false, false));
}

// The area in the picture decides, of which the lens may show only a part.
TEST(Selection, LargestGoesByTheLens) {
  Content content = four_quads();
  content.objects[2].world_from_object[9] = 3.0;  // the big one, to the right
  sideray_camera camera = in_front();
  const auto largest = [&] { return select_ray_traced(content, "largest:1", camera, 640, 360); };
  EXPECT_THAT(largest(), ElementsAre(false, false, true, false));
  camera.shift_x = 0.4f;
  EXPECT_THAT(largest(), ElementsAre(false, true, false, false)) << "the big one is outside";
  camera.shift_x = 0.0f;
  camera.fx_per_fy = 4.0f;
  EXPECT_THAT(largest(), ElementsAre(false, true, false, false)) << "a narrower view";
}

TEST(Selection, NamedForms) {
  const Content content = four_quads();
  EXPECT_THAT(selected(content, "all"), ElementsAre(false, true, true, false));
  EXPECT_THAT(selected(content, "none"), ElementsAre(false, false, false, false));
  EXPECT_THAT(selected(content, "largest:1"), ElementsAre(false, false, true, false));
  EXPECT_THAT(selected(content, "largest:9"), ElementsAre(false, true, true, false));
  EXPECT_THAT(selected(content, "largest:0"), ElementsAre(false, false, false, false));
  EXPECT_THAT(selected(content, "*.small"), ElementsAre(false, true, false, false));
  EXPECT_THAT(selected(content, "*.small,glass.b*"), ElementsAre(false, true, true, false));
}

TEST(Selection, MistakesAreNamed) {
  const Content content = four_quads();
  EXPECT_THAT(message_of([&] { selected(content, "glas"); }), HasSubstr("glas"));
  EXPECT_THAT(message_of([&] { selected(content, "wall"); }), HasSubstr("translucent"));
  EXPECT_THAT(message_of([&] { selected(content, "*.small,x*"); }), HasSubstr("x*"));
  EXPECT_THAT(message_of([&] { selected(content, "largest:many"); }), HasSubstr("largest"));
  EXPECT_NE(message_of([&] { selected(content, ""); }), "");
}

TEST(Selection, InfoListsTheNamesThatPatternsMatch) {
  Content content = four_quads();
  content.objects.push_back(content.objects[1]);
  const auto json = nlohmann::json::parse(info_json(content));
  EXPECT_EQ(json["objects"], nlohmann::json::parse(R"([{"name": "glass.small", "count": 2, "auto": true},
                                                       {"name": "glass.big", "count": 1, "auto": false},
                                                       {"name": "decal", "count": 1, "auto": false}])"));
  EXPECT_EQ(json["bounds"], nlohmann::json::parse(R"({"minimum": [0, 0, 0], "maximum": [2, 2, 0]})"));
  EXPECT_THAT(info_text(content), HasSubstr("\n  from 0 0 0 to 2 2 0\n"));
  EXPECT_THAT(info_text(content), HasSubstr("glass.small (2 objects): ray traced by auto\n"));
  EXPECT_THAT(info_text(content), HasSubstr("glass.big: rasterized by auto\n"));
  EXPECT_THAT(message_of([&] { selected(content, "x"); }), HasSubstr("`sideray info SCENE`"));
}

TEST(Camera, LookAtIsRigidAndLooksThere) {
  for (const glm::dvec3 target : {glm::dvec3(4, -2, 7), glm::dvec3(1, 50, 3), glm::dvec3(1, -50, 3)}) {
    const double eye[3] = {1, 2, 3};
    const sideray_camera camera = look_at(eye, &target[0], 60.0f);
    const double* m = camera.world_from_camera;
    const glm::dvec3 x(m[0], m[1], m[2]), y(m[3], m[4], m[5]), z(m[6], m[7], m[8]);
    EXPECT_NEAR(glm::length(z + glm::normalize(target - glm::dvec3(1, 2, 3))), 0.0, 1e-12);
    EXPECT_NEAR(glm::length(glm::cross(x, y) - z), 0.0, 1e-12);
    EXPECT_NEAR(glm::length(x), 1.0, 1e-12);
    EXPECT_GE(y.y, -1e-12);
    EXPECT_NEAR(camera.yfov, 1.0471976, 1e-6);
  }
}

TEST(Camera, FramingShowsTheWholeBoundingSphere) {
  const Content content = four_quads();
  for (const float aspect : {0.5f, 1.0f, 16.0f / 9.0f}) {
    const sideray_camera camera = framing_camera(content, aspect);
    const double* m = camera.world_from_camera;
    // The quads reach from 0 to 2 in x and y: a sphere of radius sqrt(2) about (1, 1, 0).
    const glm::dvec3 eye(m[9], m[10], m[11]), center(1, 1, 0), forward(-m[6], -m[7], -m[8]);
    const double distance = glm::distance(eye, center);
    EXPECT_NEAR(glm::length(glm::normalize(eye - center) - glm::normalize(glm::dvec3(1, 0.6, 1.4))), 0.0, 1e-12);
    EXPECT_NEAR(glm::dot(forward, glm::normalize(center - eye)), 1.0, 1e-12);
    const double half_fov = std::atan(std::tan(0.5 * double{camera.yfov}) * std::min(1.0, double{aspect}));
    EXPECT_NEAR(std::sin(half_fov) * distance, 1.05 * std::sqrt(2.0), 1e-6) << "a margin of 5 % around the sphere";
    EXPECT_LT(double{camera.z_near}, distance - std::sqrt(2.0));
    EXPECT_NEAR(camera.yfov, 0.78539816, 1e-6);
  }
}

TEST(SkyTest, IsBlueAboveAndEarthBelow) {
  const Sky s = sky();
  ASSERT_EQ(s.rgb.size(), size_t{3} * s.width * s.height);
  EXPECT_EQ(s.width, 2 * s.height);
  const float* top = s.rgb.data();
  const float* bottom = s.rgb.data() + s.rgb.size() - 3;
  EXPECT_GT(top[2], top[0]);
  EXPECT_GT(bottom[0], bottom[2]);
  for (const float v : s.rgb) EXPECT_TRUE(v > 0.0f && v <= 1.0f) << "no sun disc";
}

TEST(Fill, AcceptsEveryBuiltin) {
  for (const Builtin& builtin : builtins()) {
    const Content content = generate(builtin.name, {});
    Scene scene = Scene::create().value();
    fill(scene, content, selected(content, "auto"));
    double low[3], high[3];
    EXPECT_EQ(sideray_scene_bounds(scene.get(), low, high, nullptr), SIDERAY_OK);
    EXPECT_LT(low[0], high[0]);
  }
}

}  // namespace
}  // namespace sideray::scenes
