// Tests lines and points of files: their pixels, that surfaces hide them, and that both ways of drawing agree.
#include <cmath>
#include <functional>

#include "cli/glb_edit.h"
#include "cli/program.h"
#include "scenes/images/images.h"

namespace sideray::cli_tests {
namespace {

using nlohmann::json;

constexpr int width = 64, height = 48;

// An orthographic view of 64 x 48 units: the window's x and y are those of the world, 0 at the bottom left.
struct Drawing {
  json gltf = {{"asset", {{"version", "2.0"}}},
               {"scene", 0},
               {"scenes", {{{"nodes", {0}}}}},
               {"nodes", {{{"camera", 0}, {"translation", {32, 24, 10}}}}},
               {"cameras",
                {{{"type", "orthographic"},
                  {"orthographic", {{"xmag", 32}, {"ymag", 24}, {"znear", 1}, {"zfar", 100}}}}}}};

  size_t add_material(const json& material) {
    gltf["materials"].push_back(material);
    return gltf["materials"].size() - 1;
  }
  json& add(int mode, const std::vector<float>& positions, size_t material) {
    gltf["meshes"].push_back(
        {{"primitives",
          {{{"mode", mode}, {"material", material}, {"attributes", {{"POSITION", accessor_of(gltf, positions, 3)}}}}}}});
    gltf["nodes"].push_back({{"mesh", gltf["meshes"].size() - 1}});
    gltf["scenes"][0]["nodes"].push_back(gltf["nodes"].size() - 1);
    return gltf["meshes"].back()["primitives"][0];
  }
};

json color(float r, float g, float b, float a = 1) {
  return {{"pbrMetallicRoughness", {{"baseColorFactor", {r, g, b, a}}, {"metallicFactor", 0}}}};
}

// Returns a rectangle of two triangles.
std::vector<float> rectangle(float x0, float y0, float x1, float y1, float z) {
  return {x0, y0, z, x1, y0, z, x1, y1, z, x0, y0, z, x1, y1, z, x0, y1, z};
}

class Thin : public Program {
 protected:
  std::vector<std::string> ways() const {
    return can_draw() ? std::vector<std::string>{"none", "auto"} : std::vector<std::string>{"none"};
  }
  scenes::Image draw(const Drawing& drawing, const std::string& options) {
    std::ofstream(path("scene.gltf")) << drawing.gltf.dump();
    const Outcome outcome = run("render scene.gltf --size 64x48 --env none --aov Z,id -o picture.exr " + options);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
    EXPECT_EQ(outcome.errors, "") << options;
    return scenes::read_image(path("picture.exr"));
  }
  // Returns the value of a pixel, counted from the bottom left.
  static float value(const scenes::Image& image, const char* channel, int x, int y) {
    const scenes::Plane& plane = *image.find(channel);
    const auto i = static_cast<size_t>((height - 1 - y) * width + x);
    return plane.values.empty() ? static_cast<float>(plane.uint_values[i]) : plane.values[i];
  }
  static int count(const scenes::Image& image, const char* channel) {
    int count = 0;
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) count += value(image, channel, x, y) > 0.0f ? 1 : 0;
    return count;
  }
};

TEST_F(Thin, PointsFillThePixelThatTheyLieIn) {
  Drawing d;
  d.add(0, {10.5f, 20.5f, 0, 30.2f, 5.9f, 0, 63.9f, 47.9f, 0, 70, 10, 0}, d.add_material(color(0.25f, 0.5f, 1)));
  for (const std::string& way : ways()) {
    SCOPED_TRACE(way);
    const scenes::Image image = draw(d, "--gl " + way);
    EXPECT_EQ(count(image, "R"), 3);
    for (const auto& [x, y] : {std::pair(10, 20), std::pair(30, 5), std::pair(63, 47)}) {
      EXPECT_NEAR(value(image, "R", x, y), 0.25f, 1e-3f);
      EXPECT_NEAR(value(image, "B", x, y), 1.0f, 1e-3f);
      EXPECT_NEAR(value(image, "A", x, y), 1.0f, 0.0f);
      EXPECT_NEAR(value(image, "Z", x, y), 10.0f, 1e-3f);
    }
    EXPECT_EQ(value(image, "id.surface", 30, 5), 1.0f);
    EXPECT_EQ(value(image, "id.primitive", 30, 5), 2.0f) << "the second point";
    EXPECT_TRUE(std::isinf(value(image, "Z", 0, 0)));
  }
}

// Flat and steep lines in both directions have one pixel in each column or row; the last one belongs to the next line.
TEST_F(Thin, LinesLeaveDiamonds) {
  Drawing d;
  d.add(1, {2.5f, 10.5f, 0, 22.5f, 10.5f, 0, /**/ 30.5f, 2.5f, 0, 30.5f, 42.5f, 0, /**/ 60.5f, 45.5f, 0, 40.5f, 35.5f, 0},
        d.add_material(color(1, 1, 1)));
  for (const std::string& way : ways()) {
    SCOPED_TRACE(way);
    const scenes::Image image = draw(d, "--gl " + way);
    EXPECT_EQ(count(image, "R"), 20 + 40 + 20);
    for (int x = 2; x < 22; ++x) EXPECT_GT(value(image, "R", x, 10), 0.99f) << x;
    EXPECT_EQ(value(image, "R", 22, 10), 0.0f) << "the diamond that it ends in is not left";
    for (int y = 2; y < 42; ++y) EXPECT_GT(value(image, "R", 30, y), 0.99f) << y;
    EXPECT_GT(value(image, "R", 60, 45), 0.99f);
    EXPECT_EQ(value(image, "R", 40, 35), 0.0f);
  }
}

TEST_F(Thin, StripsAndLoopsJoin) {
  const std::vector<float> corners = {10.5f, 10.5f, 0, 30.5f, 10.5f, 0, 30.5f, 30.5f, 0, 10.5f, 30.5f, 0};
  // Drivers may omit a pixel where a line ends in its middle.
  const auto slack = [](const std::string& way) { return way == "none" ? 0 : 3; };
  for (const auto& [mode, pixels] : {std::pair(1, 40), std::pair(2, 80), std::pair(3, 60)}) {
    Drawing d;
    d.add(mode, corners, d.add_material(color(1, 1, 1)));
    for (const std::string& way : ways()) 
      EXPECT_NEAR(count(draw(d, "--gl " + way), "R"), pixels, slack(way)) << mode << " " << way;
  }
}

// Lines interpolate vertex colours, are hidden by surfaces in front, and hide those behind.
TEST_F(Thin, DepthAndColoursAreTested) {
  Drawing d;
  json& line = d.add(1, {0.5f, 20.5f, 0, 63.5f, 20.5f, 0}, d.add_material(color(1, 1, 1)));
  line["attributes"]["COLOR_0"] = accessor_of(d.gltf, {1, 0, 0, 1, 0, 0, 1, 1}, 4);
  json glow = color(0, 0, 0);
  glow["emissiveFactor"] = {0, 1, 0};
  glow["doubleSided"] = true;
  const size_t green = d.add_material(glow);
  d.add(4, rectangle(10, 10, 20, 30, 1), green);
  d.add(4, rectangle(40, 10, 50, 30, -1), green);
  for (const std::string& way : ways()) {
    SCOPED_TRACE(way);
    const scenes::Image image = draw(d, "--shadows off --ambient off --gl " + way);
    EXPECT_GT(value(image, "G", 15, 20), 0.9f);
    EXPECT_EQ(value(image, "G", 45, 20), 0.0f);
    EXPECT_GT(value(image, "G", 45, 21), 0.9f);
    for (const int x : {2, 30, 60}) {
      const auto share = static_cast<float>(x) / 63.0f;
      EXPECT_NEAR(value(image, "R", x, 20), 1.0f - share, 2e-3f) << x;
      EXPECT_NEAR(value(image, "B", x, 20), share, 2e-3f) << x;
    }
  }
}

TEST_F(Thin, GlassLiesOverThem) {
  Drawing d;
  d.add(1, {0.5f, 20.5f, 0, 63.5f, 20.5f, 0}, d.add_material(color(1, 1, 1)));
  json pane = color(0, 0, 0, 0.5f);
  pane["alphaMode"] = "BLEND";
  pane["doubleSided"] = true;
  pane["extensions"]["KHR_materials_specular"] = {{"specularFactor", 0}};
  const size_t dark = d.add_material(pane);
  d.add(4, rectangle(10, 10, 20, 30, 1), dark);
  d.add(4, rectangle(40, 10, 50, 30, -1), dark);
  for (const std::string& way : ways())
    for (const char* mode : {"raster", "hybrid", "raytraced", "reference"}) {
      SCOPED_TRACE(way + " " + mode);
      const scenes::Image image = draw(d, std::string("--translucency ") + mode + " --gl " + way);
      EXPECT_NEAR(value(image, "R", 15, 20), 0.5f, 0.02f) << "behind a pane";
      EXPECT_NEAR(value(image, "R", 45, 20), 1.0f, 0.02f) << "before one";
    }
}

// Lines with normals are lit, and cut-outs have holes.
TEST_F(Thin, NormalsLightThemAndCutOutsHaveHoles) {
  Drawing d;
  d.gltf["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "directional"}, {"intensity", 3.14159265}}};
  d.gltf["nodes"].push_back({{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
  d.gltf["scenes"][0]["nodes"].push_back(1);
  json matt = color(0.5f, 0.5f, 0.5f);
  matt["extensions"]["KHR_materials_specular"] = {{"specularFactor", 0}};
  json& lit = d.add(1, {0.5f, 10.5f, 0, 63.5f, 10.5f, 0}, d.add_material(matt));
  // One normal faces the light, the other is 60 degrees from it.
  lit["attributes"]["NORMAL"] = accessor_of(d.gltf, {0, 0, 1, 0, 0, 1}, 3);
  json& turned = d.add(1, {0.5f, 20.5f, 0, 63.5f, 20.5f, 0}, 0);
  turned["attributes"]["NORMAL"] = accessor_of(d.gltf, {0, 0.8660254f, 0.5f, 0, 0.8660254f, 0.5f}, 3);
  json holes = color(1, 1, 1);
  holes["alphaMode"] = "MASK";
  json& cut = d.add(1, {0.5f, 30.5f, 0, 63.5f, 30.5f, 0}, d.add_material(holes));
  cut["attributes"]["COLOR_0"] = accessor_of(d.gltf, {1, 1, 1, 0, 1, 1, 1, 1}, 4);
  for (const std::string& way : ways()) {
    SCOPED_TRACE(way);
    const scenes::Image image = draw(d, "--ambient off --gl " + way);
    EXPECT_NEAR(value(image, "R", 30, 10), 0.5f, 5e-3f);
    EXPECT_NEAR(value(image, "R", 30, 20), 0.25f, 5e-3f);
    EXPECT_EQ(value(image, "R", 20, 30), 0.0f);
    EXPECT_NEAR(value(image, "R", 40, 30), 1.0f, 1e-3f);
  }
}

// Both ways draw almost the same pixels of a fan of lines and many points in perspective.
TEST_F(Thin, BothWaysShowTheSame) {
  if (!can_draw()) GTEST_SKIP() << "no OpenGL";
  Drawing d;
  d.gltf["cameras"][0] = {{"type", "perspective"}, {"perspective", {{"yfov", 0.9}, {"znear", 0.1}}}};
  d.gltf["nodes"][0]["translation"] = {32, 24, 60};
  std::vector<float> fan, cloud;
  for (int i = 0; i < 48; ++i) {
    const double angle = 0.1309 * i;
    const auto x = static_cast<float>(30 * std::cos(angle)), y = static_cast<float>(30 * std::sin(angle));
    fan.insert(fan.end(), {32.3f, 24.1f, 0, 32.3f + x, 24.1f + y, static_cast<float>(20 * std::sin(3 * angle))});
  }
  uint32_t state = 1;
  const auto random = [&] { return static_cast<float>((state = state * 1664525u + 1013904223u) >> 8) * 0x1p-24f; };
  for (int i = 0; i < 1000; ++i)
    cloud.insert(cloud.end(), {64 * random(), 48 * random(), 30 * random() - 20});
  const size_t white = d.add_material(color(1, 1, 1));
  d.add(1, fan, white);
  d.add(0, cloud, d.add_material(color(1, 0.5f, 0)));
  const scenes::Image rays = draw(d, "--gl none"), raster = draw(d, "--gl auto");
  int differ = 0, seen = 0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      seen += value(rays, "A", x, y) > 0.0f ? 1 : 0;
      differ += std::abs(value(rays, "G", x, y) - value(raster, "G", x, y)) > 1e-2f ? 1 : 0;
    }
  EXPECT_GT(seen, 1000);
  EXPECT_LE(differ, seen / 50);
}

}  // namespace
}  // namespace sideray::cli_tests
