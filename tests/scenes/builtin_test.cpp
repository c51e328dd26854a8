#include "scenes/builtin/builtin.h"

#include <gmock/gmock.h>

#include <cmath>
#include <cstring>
#include <glm/glm.hpp>
#include <map>
#include <set>

#include "scenes/support.h"

namespace sideray::scenes {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// Number of surfaces named `prefix`... on the ray, by trying every triangle. Cheap scenes only.
int surfaces_hit(const Content& content, glm::dvec3 origin, glm::dvec3 direction, const std::string& prefix) {
  int hits = 0;
  for (const Object& object : content.objects) {
    if (!object.name.starts_with(prefix)) continue;
    const Mesh& mesh = content.meshes[object.mesh];
    const double* m = object.world_from_object;
    const auto corner = [&](size_t i) {
      const float* p = &mesh.positions[3 * size_t{mesh.indices[i]}];
      const glm::dmat3 linear(m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8]);
      return linear * glm::dvec3(p[0], p[1], p[2]) + glm::dvec3(m[9], m[10], m[11]);
    };
    for (size_t i = 0; i < mesh.indices.size(); i += 3) {
      const glm::dvec3 a = corner(i), u = corner(i + 1) - a, v = corner(i + 2) - a, n = glm::cross(u, v);
      const double t = glm::dot(n, a - origin) / glm::dot(n, direction);
      const glm::dvec3 p = origin + t * direction - a;
      const double b = glm::dot(glm::cross(p, v), n) / glm::dot(n, n),
                   c = glm::dot(glm::cross(u, p), n) / glm::dot(n, n);
      if (t > 0 && b >= 0 && c >= 0 && b + c < 1) {
        ++hits;
        break;
      }
    }
  }
  return hits;
}

struct PanesCase {
  int count;
  double gap, angle, distance;
};

class Panes : public testing::TestWithParam<PanesCase> {};

TEST_P(Panes, EveryCoveredPixelHasAllLayersBeforeTheWall) {
  const PanesCase& p = GetParam();
  const auto text = [](double value) { return std::to_string(value); };
  const Content content = generate("panes", {{"count", std::to_string(p.count)},
                                             {"gap", text(p.gap)},
                                             {"angle", text(p.angle)},
                                             {"distance", text(p.distance)}});
  const sideray_camera& camera = content.cameras.at(0).camera;
  const double* m = camera.world_from_camera;
  const glm::dmat3 world_from_camera(m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8]);
  const glm::dvec3 eye(m[9], m[10], m[11]);
  constexpr int width = 128, height = 72;
  int covered = 0, partly = 0;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double tangent = std::tan(0.5 * double{camera.yfov});
      const glm::dvec3 view(((x + 0.5) / width * 2 - 1) * tangent * width / height,
                            (1 - (y + 0.5) / height * 2) * tangent, -1);
      const glm::dvec3 direction = world_from_camera * view;
      const int layers = surfaces_hit(content, eye, direction, "pane");
      covered += layers == p.count;
      partly += layers != 0 && layers != p.count;
      EXPECT_EQ(surfaces_hit(content, eye, direction, "wall"), 1) << "the wall reaches past the picture";
    }
  }
  EXPECT_LE(partly, 2 * (width + height) / 20) << "a thin rim at most";
  if (std::abs(p.angle) < 45) {
    EXPECT_NEAR(static_cast<double>(covered) / (width * height), 0.5, 0.1);
  }
}

INSTANTIATE_TEST_SUITE_P(Parameters, Panes,
                         testing::Values(PanesCase{4, 0.2, 0, 3}, PanesCase{1, 0.2, 0, 3}, PanesCase{8, 0.05, 30, 2},
                                         PanesCase{6, 0, -20, 3}, PanesCase{3, 1, 0, 1e4}, PanesCase{4, 0.2, 80, 3}));

TEST(Builtin, PanesAreMarkedSmoothAndBlended) {
  const Content content = generate("panes", {{"count", "3"}});
  int panes = 0;
  for (const Object& object : content.objects) {
    if (!object.name.starts_with("pane")) continue;
    ++panes;
    const Material& material = content.materials[object.material];
    EXPECT_EQ(material.ray_traced, RayTraced::yes);
    EXPECT_EQ(material.desc.alpha_mode, SIDERAY_BLEND);
    EXPECT_EQ(material.desc.base_color[3], 0.25f);
    EXPECT_LT(material.desc.roughness, 0.1f);
    EXPECT_TRUE(material.desc.double_sided);
    EXPECT_EQ(content.meshes[object.mesh].indices.size(), 6u) << "a single quad";
  }
  EXPECT_EQ(panes, 3);
}

TEST(Builtin, WrongRequestsListWhatExists) {
  EXPECT_THAT(message_of([] { generate("cafe", {}); }), AllOf(HasSubstr("bistro"), HasSubstr("panes")));
  EXPECT_THAT(message_of([] { generate("panes", {{"size", "3"}}); }), AllOf(HasSubstr("count"), HasSubstr("gap")));
  EXPECT_NE(message_of([] { generate("panes", {{"count", "many"}}); }), "");
  EXPECT_NE(message_of([] { generate("panes", {{"count", "0"}}); }), "");
  EXPECT_NE(message_of([] { generate("panes", {{"count", "2.5"}}); }), "");
  EXPECT_NE(message_of([] { generate("panes", {{"gap", "nan"}}); }), "");
}

bool same(const sideray_texture_slot& a, const Content& in_a, const sideray_texture_slot& b, const Content& in_b) {
  if ((a.texture == 0) != (b.texture == 0)) return false;
  if (a.texture == 0) return true;
  const Texture &x = in_a.textures[a.texture - 1], &y = in_b.textures[b.texture - 1];
  return x.rgba == y.rgba && x.width == y.width && x.height == y.height && x.srgb == y.srgb && x.name == y.name &&
         a.uv_set == b.uv_set && a.wrap_u == b.wrap_u && a.wrap_v == b.wrap_v && a.filter == b.filter &&
         std::equal(a.texture_from_uv, a.texture_from_uv + 6, b.texture_from_uv);
}

void expect_same_material(const Material& a, const Content& in_a, const Material& b, const Content& in_b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.ray_traced, b.ray_traced);
  sideray_material_desc x = a.desc, y = b.desc;
  for (int c = 0; c < 3; ++c) EXPECT_FLOAT_EQ(x.emissive[c], y.emissive[c]);
  std::copy_n(x.emissive, 3, y.emissive);  // split into colour and strength in the file: last bit only
  sideray_texture_slot sideray_material_desc::*const slots[] = {
      &sideray_material_desc::base_color_texture, &sideray_material_desc::metallic_roughness_texture,
      &sideray_material_desc::normal_texture,     &sideray_material_desc::occlusion_texture,
      &sideray_material_desc::emissive_texture,   &sideray_material_desc::transmission_texture,
      &sideray_material_desc::thickness_texture};
  for (const auto slot : slots) {
    EXPECT_TRUE(same(x.*slot, in_a, y.*slot, in_b));
    x.*slot = y.*slot = {};
  }
  EXPECT_EQ(std::memcmp(&x, &y, sizeof(x)), 0) << a.name;
}

void expect_same(const Content& a, const Content& b) {
  ASSERT_EQ(a.objects.size(), b.objects.size());
  for (size_t i = 0; i < a.objects.size(); ++i) {
    const Object &x = a.objects[i], &y = b.objects[i];
    EXPECT_EQ(x.name, y.name);
    EXPECT_TRUE(std::equal(x.world_from_object, x.world_from_object + 12, y.world_from_object)) << x.name;
    const Mesh &p = a.meshes[x.mesh], &q = b.meshes[y.mesh];
    EXPECT_TRUE(p.name == q.name && p.positions == q.positions && p.normals == q.normals && p.tangents == q.tangents &&
                p.uv0 == q.uv0 && p.uv1 == q.uv1 && p.colors == q.colors && p.indices == q.indices)
        << x.name;
    expect_same_material(a.materials[x.material], a, b.materials[y.material], b);
  }
  ASSERT_EQ(a.cameras.size(), b.cameras.size());
  for (size_t i = 0; i < a.cameras.size(); ++i) {
    EXPECT_EQ(a.cameras[i].name, b.cameras[i].name);
    const sideray_camera &x = a.cameras[i].camera, &y = b.cameras[i].camera;
    for (int k = 0; k < 12; ++k) EXPECT_NEAR(x.world_from_camera[k], y.world_from_camera[k], 1e-14);
    EXPECT_EQ(x.yfov, y.yfov);
    EXPECT_EQ(x.z_near, y.z_near);
    EXPECT_EQ(x.z_far, y.z_far);
  }
  ASSERT_EQ(a.lights.size(), b.lights.size());
  for (size_t i = 0; i < a.lights.size(); ++i) {
    const sideray_light &x = a.lights[i].light, &y = b.lights[i].light;
    EXPECT_EQ(a.lights[i].name, b.lights[i].name);
    EXPECT_EQ(x.type, y.type);
    EXPECT_EQ(x.range, y.range);
    EXPECT_EQ(x.angular_diameter_deg, y.angular_diameter_deg);
    const float length = std::hypot(x.direction[0], x.direction[1], x.direction[2]);
    for (int c = 0; c < 3; ++c) {
      EXPECT_FLOAT_EQ(x.intensity[c], y.intensity[c]);
      EXPECT_EQ(x.position[c], y.position[c]);
      if (x.type != SIDERAY_LIGHT_POINT) {
        EXPECT_NEAR(x.direction[c] / length, y.direction[c], 1e-6);
      }
    }
  }
}

TEST(Builtins, WhatIsNoNumberGetsARemedy) {
  EXPECT_THAT(message_of([] {
                generate("panes", {{"count", "x"}});
              }),
              HasSubstr("panes: count is \"x\", not a number; give a number such as "));
}

class EveryBuiltin : public testing::TestWithParam<std::string> {};

TEST_P(EveryBuiltin, SameBytesTwiceAndReadsBackEqual) {
  const ScratchFolder folder;
  const Content content = load(GetParam());
  write_glb(folder / "a.glb", content);
  write_glb(folder / "b.glb", generate(GetParam(), {}));
  EXPECT_TRUE(bytes_of(folder / "a.glb") == bytes_of(folder / "b.glb"));
  const Content read = load(folder / "a.glb");
  EXPECT_TRUE(read.warnings.empty()) << read.warnings[0];
  EXPECT_TRUE(read.defaulted.empty()) << read.defaulted[0];
  expect_same(content, read);
}

// Animations are the same after writing and reading.
TEST(Bistro, ItsDollyTravelsAndSurvivesAFile) {
  const ScratchFolder folder;
  Content made = generate("bistro", {});
  write_glb(folder / "a.glb", made);
  Content read = load(folder / "a.glb");
  ASSERT_EQ(made.animations.size(), 1u);
  ASSERT_EQ(read.animations.size(), 1u);
  EXPECT_EQ(read.animations[0].name, "dolly");
  EXPECT_EQ(read.animations[0].length_s, made.animations[0].length_s);
  const auto eye = [](const Content& content) {
    for (const Camera& camera : content.cameras)
      if (camera.name == "dolly") {
        const double* m = camera.camera.world_from_camera;
        return glm::dvec3(m[9], m[10], m[11]);
      }
    return glm::dvec3(NAN);
  };
  const glm::dvec3 start = eye(made);
  pose(made, 1.0), pose(read, 1.0);
  const glm::dvec3 a_second = eye(made) - start;
  EXPECT_GT(glm::length(a_second), 0.2);
  for (size_t i = 0; i < made.cameras.size(); ++i)
    EXPECT_TRUE(std::equal(made.cameras[i].camera.world_from_camera, made.cameras[i].camera.world_from_camera + 12,
                           read.cameras[i].camera.world_from_camera))
        << made.cameras[i].name;
  pose(made, 2.0);
  EXPECT_LT(glm::length(eye(made) - start - 2.0 * a_second), 1e-6) << "at one speed: keys are floats";
  const Content later = load("bistro", {.animation = "", .time_s = 1.0});
  EXPECT_EQ(eye(later), eye(read)) << "--time moves built-in scenes too";
}

TEST(Builtin, ParametersMayFollowTheName) {
  const Content loaded = load("panes?count=2&gap=1.5"), made = generate("panes", {{"count", "2"}, {"gap", "1.5"}});
  ASSERT_EQ(loaded.objects.size(), made.objects.size());
  for (size_t i = 0; i < made.meshes.size(); ++i) EXPECT_EQ(loaded.meshes[i].positions, made.meshes[i].positions);
  EXPECT_THAT(message_of([] { load("panes?count"); }), HasSubstr("\"count\" is not K=V"));
  EXPECT_THAT(message_of([] { load("panes?count=2&count=3"); }), HasSubstr("count is given twice; remove one"));
  EXPECT_THAT(message_of([] { load("panes?width=2"); }), AllOf(HasSubstr("no parameter width"), HasSubstr("gap")));
  EXPECT_THAT(message_of([] { load("nonsense?count=2"); }), HasSubstr("no scene nonsense?count=2"));
}

TEST_P(EveryBuiltin, InfoIsJsonWithTheAgreedKeys) {
  const Content content = load(GetParam());
  const auto json = nlohmann::json::parse(info_json(content));
  for (const char* key : {"cameras", "lights", "animations", "materials", "extensions", "defaulted", "warnings"}) {
    EXPECT_TRUE(json.at(key).is_array()) << key;
  }
  EXPECT_EQ(json["scene"], GetParam());
  EXPECT_EQ(json["counts"]["objects"], content.objects.size());
  EXPECT_EQ(json["materials"].size(), content.materials.size());
  EXPECT_EQ(json["lights"][0]["name"], content.lights[0].name);
  for (const auto& light : json["lights"]) {
    if (!light.contains("direction")) continue;
    const auto direction = light["direction"].get<std::vector<double>>();
    EXPECT_NEAR(std::hypot(direction[0], direction[1], direction[2]), 1.0, 2e-6) << "as a file's node axis is";
  }
  EXPECT_THAT(info_text(content), HasSubstr(content.cameras.at(0).name));
}

INSTANTIATE_TEST_SUITE_P(Scenes, EveryBuiltin,
                         testing::Values("bistro", "panes", "edges", "crossing", "solids", "haze", "smoke", "frosted",
                                         "empty"),
                         [](const testing::TestParamInfo<std::string>& test) { return test.param; });

}  // namespace
}  // namespace sideray::scenes
