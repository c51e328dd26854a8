// Tests KHR_animation_pointer and KHR_node_visibility: the picture at a time equals that of a file with these values,
// with and without OpenGL, alone and in a sequence.
#include <fmt/format.h>

#include <functional>

#include "cli/glb_edit.h"
#include "cli/program.h"

namespace sideray::cli_tests {
namespace {

using nlohmann::json;

// Lets the pointer's value be `from` at 0 s and `to` from `end_s` on, in an animation of 100 s.
void animate(json& gltf, const std::string& pointer, const std::vector<float>& from, const std::vector<float>& to,
             float end_s, const char* interpolation) {
  std::vector<float> values = from;
  values.insert(values.end(), to.begin(), to.end());
  values.insert(values.end(), to.begin(), to.end());
  json& animation = gltf["animations"][0];
  animation["samplers"].push_back({{"input", accessor_of(gltf, {0, end_s, 100}, 1)},
                                   {"output", accessor_of(gltf, values, from.size())},
                                   {"interpolation", interpolation}});
  animation["channels"].push_back(
      {{"sampler", animation["samplers"].size() - 1},
       {"target", {{"path", "pointer"}, {"extensions", {{"KHR_animation_pointer", {{"pointer", pointer}}}}}}}});
}

void set(json& gltf, const std::string& pointer, const std::vector<float>& value) {
  json& at = gltf[json::json_pointer(pointer)];
  if (value.size() == 1)
    at = value[0];
  else
    at = value;
}

class PointerPictures : public Program {
 protected:
  // Makes a built-in scene with changed JSON, as NAME.glb.
  void make(const std::string& name, const std::function<void(json&)>& change) {
    ASSERT_EQ(run("make solids -o " + name + ".glb").exit_code, 0);
    edit_glb(path(name + ".glb"), change);
  }
  void draw(const std::string& arguments) {
    const Outcome outcome = run("render " + arguments);
    ASSERT_EQ(outcome.exit_code, 0) << arguments << "\n" << outcome.errors;
    EXPECT_EQ(outcome.errors, "") << arguments;
  }
  bool same(const std::string& a, const std::string& b) const { return text_of(path(a)) == text_of(path(b)); }
  std::vector<std::string> ways() const {
    return can_draw() ? std::vector<std::string>{"none", "auto"} : std::vector<std::string>{"none"};
  }
  // Expects that the frame at 1 s is that of a file with the value at 1 s, and that the one at 0 s is not.
  void expect_as_said(const std::string& pointer, const std::vector<float>& from, const std::vector<float>& to) {
    SCOPED_TRACE(pointer);
    std::vector<float> middle;
    for (size_t i = 0; i < from.size(); ++i) middle.push_back(0.5f * (from[i] + to[i]));
    make("moving", [&](json& gltf) { animate(gltf, pointer, from, to, 2, "LINEAR"); });
    make("still", [&](json& gltf) { set(gltf, pointer, middle); });
    for (const std::string& way : ways()) {
      const std::string how = " --size 32x18 --frames 0-1 --fps 1 --taa off --denoise off --gl " + way;
      draw("still.glb -o still.#.png" + how);
      draw("moving.glb -o moving.#.png" + how);
      EXPECT_TRUE(same("still.1.png", "moving.1.png")) << way;
      EXPECT_FALSE(same("still.0.png", "moving.0.png")) << way;
    }
  }
};

TEST_F(PointerPictures, AreThoseOfAFileThatSaysSo) {
  const std::string glass = "/materials/3/";  // of the cube
  expect_as_said("/materials/0/pbrMetallicRoughness/baseColorFactor", {1, 0, 0, 1}, {0, 0, 1, 1});
  expect_as_said(glass + "extensions/KHR_materials_transmission/transmissionFactor", {0}, {1});
  expect_as_said(glass + "extensions/KHR_materials_volume/attenuationColor", {1, 1, 1}, {0, 1, 0});
  expect_as_said("/extensions/KHR_lights_punctual/lights/0/intensity", {1}, {9});
  expect_as_said("/extensions/KHR_lights_punctual/lights/0/color", {1, 0, 0}, {0, 1, 1});
  expect_as_said("/cameras/0/perspective/yfov", {0.25}, {1});
}

// A sudden change shows at once: the history is rejected.
TEST_F(PointerPictures, SequencesNoticeThatLightAndMaterialsChange) {
  const std::string light = "/extensions/KHR_lights_punctual/lights/0/color", floor = "/materials/0/emissiveFactor";
  make("moving", [&](json& gltf) {
    animate(gltf, light, {1, 1, 1}, {0, 1, 0}, 1, "STEP");
    animate(gltf, floor, {0, 0, 0}, {1, 0, 0}, 1, "STEP");
  });
  make("still", [&](json& gltf) { set(gltf, light, {0, 1, 0}), set(gltf, floor, {1, 0, 0}); });
  for (const std::string& way : ways()) {
    const auto flip = [&](const std::string& frame) {
      const Outcome compared = run("compare m." + frame + ".png s." + frame + ".png --json");
      return json::parse(compared.output)["flip"].get<double>();
    };
    const auto draw_both = [&](const std::string& options) {
      for (const auto& [scene, frames] : {std::pair("moving.glb", "m"), std::pair("still.glb", "s")})
        draw(fmt::format("{} -o {}.####.png --size 96x54 --fps 1 --frames 0-2 --gl {} {}", scene, frames, way,
                         options));
    };
    draw_both("--taa off --ambient off");
    EXPECT_FALSE(same("m.0000.png", "s.0000.png")) << way;
    EXPECT_TRUE(same("m.0001.png", "s.0001.png")) << way;
    EXPECT_TRUE(same("m.0002.png", "s.0002.png")) << way;
    // Averages over time follow the change; only noise differs.
    draw_both("");
    EXPECT_LT(flip("0001"), 0.4 * flip("0000")) << way;
    EXPECT_LT(flip("0002"), 0.25 * flip("0000")) << way;
  }
}

TEST_F(PointerPictures, HiddenNodesAreNotInThem) {
  const std::string visible = "/extensions/KHR_node_visibility/visible";
  make("whole", [](json&) {});
  const std::string pointer = "/nodes/3" + visible;  // the cube
  make("moving", [&](json& g) { animate(g, pointer, {1}, {0}, 1, "STEP"); });
  make("still", [&](json& g) { g[json::json_pointer(pointer)] = false; });
  for (const std::string& way : ways()) {
    // Another body, however small, changes the origins of refraction rays by rounding.
    const std::string how = " --size 64x36 --translucency raster --gl " + way;
    draw("still.glb -o still.png" + how);
    draw("moving.glb --time 1 -o hidden.png" + how);
    draw("whole.glb -o whole.png" + how);
    EXPECT_TRUE(same("still.png", "hidden.png")) << way;
    EXPECT_FALSE(same("still.png", "whole.png")) << way;
  }
}

}  // namespace
}  // namespace sideray::cli_tests
