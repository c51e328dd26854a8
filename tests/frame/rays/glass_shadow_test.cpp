// Compares the shadow of glass on a floor, in every way of drawing, with the closed form of a straight ray.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <sideray/sideray.hpp>
#include <string>
#include <utility>
#include <vector>

namespace sideray::tests::glass_shadow_test {
namespace {

constexpr double degrees = 3.14159265358979323846 / 180;
constexpr double angles[] = {0, 25, 45, 60, 75};
constexpr double thicknesses[] = {0.05, 0.4, 1.0};
constexpr float colour[3] = {0.9f, 0.2f, 0.1f};
constexpr double attenuation_distance = 0.3;

using Colour = std::array<double, 3>;

struct Box {
  double low, high;  // y
  sideray_material_desc material;
  double left = -50, right = 50;  // x, and 50 to each side along z
};

struct Stage {
  std::vector<Box> boxes;  // above the floor, y = 0
  bool flat = false;       // their lower faces alone
  double angle_deg = 0;    // of the light to the normal
  std::vector<sideray_light> lamps{};  // instead of that light
};

// alone: rays without OpenGL; layers: the floor is itself translucent and has traced layers; maps: no rays at all;
// veil: maps, and a floor that lets half the light pass; paths: without caustics of lamps, above a floor so dark that
// it reflects little light; off: no translucent surface is drawn.
enum class Way { hybrid, alone, raytraced, reference, soft, layers, maps, veil, paths, off, off_maps };
constexpr Way ways[] = {Way::hybrid, Way::alone, Way::raytraced, Way::reference,
                        Way::soft,   Way::layers, Way::maps,     Way::veil};
constexpr float dark = 0.02f;

bool by_maps(Way way) {
  return way == Way::maps || way == Way::veil;
}

std::string name_of(Way way) {
  constexpr const char* names[] = {"hybrid", "alone", "raytraced", "reference", "soft",     "layers",
                                   "maps",   "veil",  "paths",     "off",       "off, maps"};
  return names[static_cast<int>(way)];
}

void add_box(Scene& scene, const Box& box, bool flat) {
  const auto y0 = static_cast<float>(box.low), y1 = static_cast<float>(box.high);
  const auto l = static_cast<float>(box.left), r = static_cast<float>(box.right);
  constexpr float h = 50.0f;
  const float positions[] = {l, y0, -h, r, y0, -h, r, y0, h, l, y0, h, l, y1, -h, r, y1, -h, r, y1, h, l, y1, h};
  const uint32_t indices[] = {0, 1, 2, 0, 2, 3, 4, 6, 5, 4, 7, 6, 0, 4, 5, 0, 5, 1,
                              1, 5, 6, 1, 6, 2, 2, 6, 7, 2, 7, 3, 3, 7, 4, 3, 4, 0};
  sideray_mesh_desc mesh = sideray_mesh_defaults();
  mesh.vertex_count = 8;
  mesh.positions.data = positions;
  mesh.index_count = flat ? 6 : 36;
  mesh.indices = indices;
  sideray_instance_desc instance{};
  instance.mesh = scene.add_mesh(mesh);
  instance.material = scene.add_material(box.material);
  for (int i : {0, 4, 8}) instance.world_from_object[i] = 1;
  instance.visibility = SIDERAY_VISIBLE_ALL;
  instance.surface_id = instance.mesh + 1u;
  scene.add_instances({&instance, 1});
}

Renderer* new_renderer(const char* gl) {
  sideray_renderer_desc desc = sideray_renderer_defaults();
  desc.gl = gl;
  return new Renderer(Renderer::create(desc).value());
}

// Shares a renderer among the pictures of a way, because contexts and shaders take longer than pictures.
Renderer& shared_renderer(Way way) {
  static Renderer &any = *new_renderer("auto"), &alone = *new_renderer("none");
  return way == Way::alone ? alone : any;
}

// Returns the floor's radiance, seen from below the objects above it.
Colour floor_of(const Stage& stage, Way way) {
  Scene scene = Scene::create().value();
  sideray_material_desc white = sideray_material_defaults();
  white.double_sided = 1;
  if (way == Way::layers || way == Way::veil) white.alpha_mode = SIDERAY_BLEND;
  if (way == Way::veil) white.base_color[3] = 0.5f;
  if (way == Way::paths) white.base_color[0] = white.base_color[1] = white.base_color[2] = dark, white.specular = 0;
  add_box(scene, {0.0, 0.0, white}, true);
  for (const Box& box : stage.boxes) add_box(scene, box, stage.flat);
  sideray_light light = sideray_light_defaults();
  light.direction[0] = static_cast<float>(-std::sin(stage.angle_deg * degrees));
  light.direction[1] = static_cast<float>(-std::cos(stage.angle_deg * degrees));
  for (float& c : light.intensity) c = way == Way::paths ? 2.0f / dark : 2.0f;
  light.angular_diameter_deg = way == Way::soft ? 0.1f : 0.0f;
  if (stage.lamps.empty())
    scene.set_lights({&light, 1});
  else
    scene.set_lights(stage.lamps);
  scene.commit();
  sideray_camera camera = sideray_camera_defaults();
  // Down along -y from 0.02 above the floor: right = x, up = -z.
  const double pose[12] = {1, 0, 0, 0, 0, -1, 0, 1, 0, 0.3, 0.02, 0.1};
  std::copy(std::begin(pose), std::end(pose), camera.world_from_camera);
  camera.z_near = 1e-3f;
  RenderOptions options;
  options.picture.width = options.picture.height = 40;
  options.shadows->method =
      by_maps(way) || way == Way::off_maps ? SIDERAY_SHADOWS_MAP : SIDERAY_SHADOWS_EXACT;
  options.translucency->method = way == Way::raytraced ? SIDERAY_TRANSLUCENCY_RAYTRACED : SIDERAY_TRANSLUCENCY_HYBRID;
  if (by_maps(way)) options.translucency->method = SIDERAY_TRANSLUCENCY_RASTER;
  if (way == Way::off || way == Way::off_maps) options.translucency->method = SIDERAY_TRANSLUCENCY_OFF;
  if (way == Way::reference || way == Way::paths) {
    options.reference = sideray_reference_defaults();
    options.reference->light_samples = 4;
    if (way == Way::paths) options.reference->bounces = 0;  // unlimited
  }
  Picture picture = shared_renderer(way).render(scene, camera, options).value();
  Colour seen{};
  for (size_t i = 0; i < picture.channel_count(); ++i) {
    const sideray_channel channel = picture.channel(i);
    const std::string name = channel.name;
    for (size_t c = 0; c < 3; ++c)
      if (name == std::string(1, "RGB"[c])) seen[c] = static_cast<double>(static_cast<const float*>(channel.values)[40 * 20 + 20]);
  }
  return seen;
}

double schlick(double cosine, double ior) {
  const double f0 = std::pow((ior - 1) / (ior + 1), 2);
  return f0 + (1 - f0) * std::pow(1 - cosine, 5);
}

// Returns the Fresnel reflectance of unpolarized light between two media; the angle is on the side of the lower index.
double fresnel(double cosine, double low, double high) {
  const double other = std::sqrt(1 - low * low / (high * high) * (1 - cosine * cosine));
  const double s = (low * cosine - high * other) / (low * cosine + high * other);
  const double p = (high * cosine - low * other) / (high * cosine + low * other);
  return 0.5 * (s * s + p * p);
}

sideray_material_desc glass(float ior, const float (&color)[3], double distance) {
  sideray_material_desc m = sideray_material_defaults();
  m.transmission = 1;
  m.roughness = 0;
  m.ior = ior;
  m.thickness = 1;
  m.attenuation_distance = static_cast<float>(distance);
  for (int c = 0; c < 3; ++c) m.attenuation_color[c] = color[c];
  return m;
}

// The floor with nothing above it.
Colour open_floor(double angle_deg, Way way) {
  static std::map<std::pair<double, Way>, Colour> known;
  const auto [at, is_new] = known.try_emplace({angle_deg, way});
  if (is_new) at->second = floor_of({{}, false, angle_deg}, way);
  return at->second;
}

void expect_shadow(const Stage& stage, const Colour& expected, const std::string& what, bool maps_too = true) {
  for (const Way way : ways) {
    if (by_maps(way) && !maps_too) continue;
    const Colour behind = floor_of(stage, way);
    const Colour lit = open_floor(stage.angle_deg, way);
    for (size_t c = 0; c < 3; ++c) {
      ASSERT_GT(lit[c], 0.02);
      // Masks have 8 bits, maps halfs of optical depths.
      const double tolerance = way == Way::reference || way == Way::layers ? 1e-3 : by_maps(way) ? 6e-3 : 0.6 / 255;
      EXPECT_NEAR(behind[c] / lit[c], expected[c], tolerance)
          << name_of(way) << ": " << what << ", channel " << c;
    }
  }
}

TEST(GlassShadow, SlabsKeepWhatFresnelAndBeerSay) {
  for (const double thickness : thicknesses)
    for (const double angle : angles) {
      // Beer's law multiplies what Fresnel's lets pass: one slab is lit at every angle, the others at two.
      if (thickness != thicknesses[1] && angle != angles[0] && angle != angles[3]) continue;
      const double cosine = std::cos(angle * degrees), passed = std::pow(1 - schlick(cosine, 1.5), 2);
      Colour expected;
      for (size_t c = 0; c < 3; ++c)
        expected[c] = passed * std::pow(static_cast<double>(colour[c]), thickness / cosine / attenuation_distance);
      expect_shadow({{{1, 1 + thickness, glass(1.5f, colour, attenuation_distance)}}, false, angle}, expected,
                    std::to_string(thickness) + " at " + std::to_string(angle));
    }
}

void expect_paths(const Stage& stage, const Colour& expected, const std::string& what) {
  const Colour behind = floor_of(stage, Way::paths), lit = open_floor(stage.angle_deg, Way::paths);
  for (size_t c = 0; c < 3; ++c)
    EXPECT_NEAR(behind[c] / lit[c], expected[c], 0.01) << "paths: " << what << ", channel " << c;
}

TEST(GlassShadow, ThinWallsAndCoverTintToo) {
  for (const double angle : angles) {
    const std::string at = " at " + std::to_string(angle);
    sideray_material_desc pane = glass(1.5f, colour, INFINITY);
    pane.thickness = 0;
    for (int c = 0; c < 3; ++c) pane.base_color[c] = colour[c];
    Colour expected;
    for (size_t c = 0; c < 3; ++c)
      expected[c] = static_cast<double>(colour[c]) * (1 - schlick(std::cos(angle * degrees), 1.5));
    const Stage wall{{{1, 1, pane}}, true, angle};
    expect_shadow(wall, expected, "thin wall" + at);
    expect_paths(wall, expected, "thin wall" + at);
    if (angle != angles[0] && angle != angles[3]) continue;  // cover is the same at any
    for (const float cover : {0.3f, 0.9f}) {
      sideray_material_desc veil = sideray_material_defaults();
      veil.alpha_mode = SIDERAY_BLEND;
      veil.base_color[3] = cover;
      const double left = 1 - static_cast<double>(cover);
      const Stage covered{{{1, 1, veil}}, true, angle};
      expect_shadow(covered, {left, left, left}, "cover" + at);
      expect_paths(covered, {left, left, left}, "cover" + at);
    }
  }
}

TEST(GlassShadow, LiquidsNest) {
  constexpr float blue[3] = {0.3f, 0.7f, 0.9f};
  for (const double angle : angles) {
    const double cosine = std::cos(angle * degrees);
    const double faces = std::pow((1 - schlick(cosine, 1.33)) * (1 - fresnel(cosine, 1.33, 1.5)), 2);
    Colour expected;
    for (size_t c = 0; c < 3; ++c)
      expected[c] = faces * std::pow(static_cast<double>(blue[c]), 0.75 / cosine) *
                    std::pow(static_cast<double>(colour[c]), 0.25 / cosine / attenuation_distance);
    const Stage marble{
        {{1, 2, glass(1.33f, blue, 1)}, {1.4, 1.65, glass(1.5f, colour, attenuation_distance)}}, false, angle};
    expect_shadow(marble, expected, "nested at " + std::to_string(angle), false);
    expect_paths(marble, expected, "nested at " + std::to_string(angle));
  }
}

// Maps treat every face as one to air, and overlapping solids both absorb. So the shadow of a drink in its glass, whose
// liquid touches the wall, is darker by the reflection of the faces between them, at most an eighth, and that of a
// marble in water by the water in its place.
TEST(GlassShadow, MapsOfNestedLiquidsAreDarker) {
  constexpr float blue[3] = {0.3f, 0.7f, 0.9f}, clear[3] = {1, 1, 1};
  const double angle = 30, cosine = std::cos(angle * degrees);
  const double wall = 1 - schlick(cosine, 1.5), water = 1 - schlick(cosine, 1.33);
  const auto shadow = [&](const Stage& stage, Way way) {
    Colour seen = floor_of(stage, way);
    for (size_t c = 0; c < 3; ++c) seen[c] /= open_floor(angle, way)[c];
    return seen;
  };
  const Stage drink{{{1, 1.1, glass(1.5f, clear, INFINITY)},
                     {1.1, 1.9, glass(1.33f, blue, 1)},
                     {1.9, 2, glass(1.5f, clear, INFINITY)}},
                    false,
                    angle};
  const Stage marble{{{1, 2, glass(1.33f, blue, 1)}, {1.4, 1.65, glass(1.5f, colour, attenuation_distance)}}, false, angle};
  const Colour drink_maps = shadow(drink, Way::maps), drink_rays = shadow(drink, Way::hybrid);
  const Colour marble_maps = shadow(marble, Way::maps), marble_rays = shadow(marble, Way::hybrid);
  for (size_t c = 0; c < 3; ++c) {
    const double in_drink = std::pow(static_cast<double>(blue[c]), 0.8 / cosine);
    EXPECT_NEAR(drink_maps[c], std::pow(wall, 4) * std::pow(water, 2) * in_drink, 6e-3) << c;
    EXPECT_LE(drink_maps[c], drink_rays[c] + 6e-3) << c;
    EXPECT_GE(drink_maps[c], drink_rays[c] * 7 / 8 - 6e-3) << c;
    const double in_both = std::pow(static_cast<double>(blue[c]), 1 / cosine) *
                           std::pow(static_cast<double>(colour[c]), 0.25 / cosine / attenuation_distance);
    EXPECT_NEAR(marble_maps[c], std::pow(wall * water, 2) * in_both, 6e-3) << c;
    EXPECT_LE(marble_maps[c], marble_rays[c] + 6e-3) << c;
    EXPECT_GE(marble_maps[c],
              marble_rays[c] * std::pow(static_cast<double>(blue[c]), 0.25 / cosine) * std::pow(wall, 2) - 6e-3)
        << c;
  }
}

TEST(GlassShadow, GrazingLightFadesAsFresnelSays) {
  constexpr float clear[3] = {1, 1, 1};
  for (const double angle : {80.0, 84.0}) {
    const double passed = std::pow(1 - schlick(std::cos(angle * degrees), 1.5), 2);
    const Stage stage{{{1, 1.05, glass(1.5f, clear, INFINITY)}}, false, angle};
    expect_shadow(stage, {passed, passed, passed}, "grazing at " + std::to_string(angle));
    expect_paths(stage, {passed, passed, passed}, "grazing at " + std::to_string(angle));
  }
}

// Light enters at the side and leaves at the top, where refracted light would be reflected totally. Straight light
// passes, equally in all ways.
TEST(GlassShadow, LightThatGlassWouldReflectTotallyPasses) {
  const double angle = 75, cosine = std::cos(angle * degrees), sine = std::sin(angle * degrees);
  const double side = 5.9, inside = (3 - (side - 0.3) * cosine / sine) / cosine;
  Colour expected;
  for (size_t c = 0; c < 3; ++c)
    expected[c] = (1 - schlick(cosine, 1.5)) * (1 - schlick(sine, 1.5)) * std::pow(static_cast<double>(colour[c]), inside / 10);
  const Stage stage{{{1, 3, glass(1.5f, colour, 10), side, 14}}, false, angle};
  expect_shadow(stage, expected, "through the side and the top");
  expect_paths(stage, expected, "through the side and the top");
}

// Objects that are not drawn cast no shadow.
TEST(GlassShadow, WithoutTranslucencyThereIsNone) {
  const Stage stage{{{1, 2, glass(1.5f, colour, attenuation_distance)}}, false, 25};
  for (const Way way : {Way::off, Way::off_maps}) EXPECT_EQ(floor_of(stage, way), open_floor(25, way)) << name_of(way);
}

sideray_light lamp_above(double height, double radius) {
  sideray_light lamp = sideray_light_defaults();
  lamp.type = SIDERAY_LIGHT_POINT;
  lamp.position[0] = 0.3;
  lamp.position[1] = height;
  lamp.position[2] = 0.1;
  lamp.radius = static_cast<float>(radius);
  for (float& c : lamp.intensity) c = 40;
  return lamp;
}

// Rays end at a lamp's sphere, and maps lack the glass deep inside. Glass a little inside tints a share of the light,
// and glass outside all of it.
TEST(GlassShadow, MapsLackWhatIsInsideLamps) {
  sideray_material_desc veil = sideray_material_defaults();
  veil.alpha_mode = SIDERAY_BLEND;
  veil.base_color[3] = 0.5f;
  const auto shadow = [&](double distance) {
    const std::vector<sideray_light> lamps = {lamp_above(4, 0.5)};
    const Stage bare{{}, false, 0, lamps}, shaded{{{4 - distance, 4 - distance, veil}}, true, 0, lamps};
    return floor_of(shaded, Way::maps)[0] / floor_of(bare, Way::maps)[0];
  };
  EXPECT_NEAR(shadow(0.2), 1.0, 6e-3);
  EXPECT_NEAR(shadow(1.0), 0.5, 6e-3);
  const double partly = shadow(0.4);
  EXPECT_GT(partly, 0.6);
  EXPECT_LT(partly, 0.95);
}

// Six lamps have 36 maps, which would take too much memory at half the side of shadow maps: smaller maps tint, too.
TEST(GlassShadow, MapsOfManyLampsTint) {
  sideray_material_desc veil = sideray_material_defaults();
  veil.alpha_mode = SIDERAY_BLEND;
  veil.base_color[3] = 0.5f;
  const std::vector<sideray_light> lamps(6, lamp_above(4, 0));
  const Stage bare{{}, false, 0, lamps}, shaded{{{2, 2, veil}}, true, 0, lamps};
  EXPECT_NEAR(floor_of(shaded, Way::maps)[0] / floor_of(bare, Way::maps)[0], 0.5, 6e-3);
}

TEST(GlassShadow, WhatGlowsThrowsNone) {
  sideray_material_desc glow = sideray_material_defaults();
  glow.alpha_mode = SIDERAY_BLEND;
  glow.base_color[3] = 0.5f;
  glow.unlit = 1;
  for (int c = 0; c < 3; ++c) glow.base_color[c] = 0;  // so that nothing shines on the floor
  expect_shadow({{{1, 1, glow}}, true, 0}, {1, 1, 1}, "unlit");
}

}  // namespace
}  // namespace sideray::tests::glass_shadow_test
