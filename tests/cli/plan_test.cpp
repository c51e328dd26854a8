// Tests that `sideray plan` predicts what `sideray render` does.
#include <fmt/format.h>

#include <map>
#include <set>

#include "cli/program.h"

namespace sideray::cli_tests {
namespace {

using nlohmann::json;

class Plan : public Program {
 protected:
  // No cache, so that tests do not share measurements.
  json plan(const std::string& arguments, const std::string& environment = "SIDERAY_CACHE=off") const {
    const Outcome outcome = run("plan " + arguments + " --json", environment);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
    return json::parse(outcome.output, nullptr, false);
  }
  // Returns the plan of a machine without OpenGL, which is quick.
  json bounded(const std::string& arguments) const { return plan(arguments + " --gl egl", no_gl); }
  static constexpr const char* no_gl =
      "SIDERAY_CACHE=off __EGL_VENDOR_LIBRARY_DIRS=/none __EGL_VENDOR_LIBRARY_FILENAMES=/none";

  json stats(const std::string& arguments) const {
    const Outcome outcome = run("bench " + arguments + " --repeat 1 --json s.json");
    EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
    return json::parse(text_of(path("s.json")), nullptr, false);
  }

  static bool runs(const json& plan, const std::string& stage) {
    for (const json& pass : plan["passes"])
      if (pass["name"] == stage) return pass["runs"];
    ADD_FAILURE() << "no pass " << stage;
    return false;
  }

  static uint64_t service_bytes(const json& plan) {
    uint64_t bytes = 0;
    for (const json& texture : plan["textures"]) {
      const std::string name = texture["name"];
      if (name.starts_with("layers.") || name.starts_with("composite.") || name == "shadow_masks" ||
          name == "shadow_tints" || name == "ambient_mask" || name == "reflections" ||
          name == "irradiance")
        bytes += texture["bytes"].get<uint64_t>();
    }
    return bytes;
  }

  void expect_agreement(const std::string& arguments) const {
    SCOPED_TRACE(arguments);
    const json planned = bounded(arguments), drawn = stats(arguments);
    for (const char* stage : {"build", "update", "gbuffer", "shadow_map", "mask", "readback", "trace", "trace_shadow",
                              "trace_ao", "upload", "light", "composite"})
      EXPECT_EQ(runs(planned, stage), drawn["stages_ms"][stage].get<double>() > 0) << stage;
    if (!runs(planned, "denoise")) {
      EXPECT_EQ(drawn["stages_ms"]["denoise"].get<double>(), 0);
    }
    const json& most = planned["bounds"];
    const json& bytes = drawn["bytes"];
    EXPECT_LE(drawn["rays"]["total"], most["rays"]);
    EXPECT_EQ(bytes["cache"], service_bytes(planned));
    EXPECT_LE(bytes["cache"].get<uint64_t>() + bytes["readback"].get<uint64_t>() + bytes["upload"].get<uint64_t>(),
              most["bytes"]);
    const json& layers = drawn["layers"];
    if (most.contains("fragments") && layers.contains("matched")) {
      EXPECT_LE(layers["matched"].get<uint64_t>() + layers["missed"].get<uint64_t>(), most["fragments"]);
    }
  }

  // Expects predictions of counts; times are not tested, since machines differ.
  void expect_predicted(const std::string& arguments) {
    SCOPED_TRACE(arguments);
    const json predicted = plan(arguments)["predicted"], drawn = stats(arguments);
    const auto expect_near = [&](const char* key, uint64_t counted) {
      EXPECT_NEAR(predicted[key].get<double>() / static_cast<double>(counted), 1.0, 0.1) << key;
    };
    const json &layers = drawn["layers"], &bytes = drawn["bytes"];
    expect_near("rays", drawn["rays"]["total"]);
    expect_near("fragments", layers["matched"].get<uint64_t>() + layers["missed"].get<uint64_t>());
    expect_near("bytes",
                bytes["readback"].get<uint64_t>() + bytes["upload"].get<uint64_t>() + bytes["cache"].get<uint64_t>());
    EXPECT_GT(predicted["ms"], 0);
    EXPECT_GT(predicted["stages_ms"]["composite"], 0);
    EXPECT_EQ(predicted["stages_ms"]["trace_shadow"], 0) << "left out";
  }
};

TEST_F(Plan, HasTheKeys) {
  const json planned = bounded("panes --size 64x36");
  EXPECT_EQ(planned["schema"], 1);
  EXPECT_EQ(planned["config"]["translucency"], "hybrid");
  EXPECT_EQ(planned["config"]["size"], "64x36");
  ASSERT_EQ(planned["passes"].size(), 14u);
  for (const json& pass : planned["passes"]) {
    EXPECT_TRUE(pass["name"].is_string() && pass["runs"].is_boolean()) << pass;
    EXPECT_FALSE(pass["reason"].get<std::string>().empty()) << pass;
  }
  ASSERT_FALSE(planned["textures"].empty());
  for (const json& texture : planned["textures"]) {
    for (const char* key : {"width", "height", "layers", "bytes"}) EXPECT_GT(texture[key], 0) << texture;
    EXPECT_TRUE(texture["name"].is_string() && texture["format"].is_string()) << texture;
  }
  for (const char* key : {"rays", "fragments", "bytes"}) EXPECT_GT(planned["bounds"][key], 0) << key;
  EXPECT_FALSE(planned.contains("candidates")) << "nothing was to be chosen";
  EXPECT_EQ(files().size(), 0u);
}

using SlowPlan = Plan;

TEST_F(Plan, PredictsWhatIsCounted) {
  if (!can_draw()) GTEST_SKIP() << "no OpenGL";
  expect_predicted("edges --size 400x225 --shadows map --ambient off --layers 1 --cache-rate checkerboard");
}

TEST_F(SlowPlan, PredictsWhatIsCounted) {
  if (!can_draw()) GTEST_SKIP() << "no OpenGL";
  expect_predicted("panes?count=2 --size 560x315 --shadows map --ambient off");
  expect_predicted("edges --size 560x315 --shadows map --ambient off --layers 1 --cache-rate checkerboard");
}

TEST_F(Plan, SmallPicturesAreDrawnWhole) {
  if (!can_draw()) GTEST_SKIP() << "no OpenGL";
  const std::string arguments = "panes --size 96x54 --translucency raytraced --shadows map --ambient off";
  EXPECT_EQ(plan(arguments)["predicted"]["rays"], stats(arguments)["rays"]["total"]);
}

TEST_F(Plan, WithoutOpenGlItKnowsItsBounds) {
  const Outcome outcome = run("plan panes --size 64x36 --json --gl egl", no_gl);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_NE(outcome.errors.find("nothing is predicted"), std::string::npos) << outcome.errors;
  const json planned = json::parse(outcome.output);
  EXPECT_TRUE(planned["predicted"].empty()) << planned["predicted"];
  EXPECT_GT(planned["bounds"]["rays"], 0);
}

TEST_F(Plan, IsMeasuredOnceAndKept) {
  if (!can_draw()) GTEST_SKIP() << "no OpenGL";
  const std::string keeps = "XDG_CACHE_HOME='" + path("") + "'", arguments = "panes?count=1 --size 64x36 --shadows map";
  const json first = plan(arguments, keeps);
  EXPECT_EQ(plan(arguments, keeps)["predicted"], first["predicted"]) << "times too";
  size_t kept = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(path("sideray"))) {
    ++kept;
    std::ofstream(entry.path()) << "{\"schema\": 1, \"key\"";
  }
  EXPECT_EQ(kept, 1u);
  EXPECT_EQ(plan(arguments, keeps)["predicted"]["rays"], first["predicted"]["rays"]) << "a broken file is none";
}

// Off, raster, hybrid and raytraced. There are as many layers as panes: panes shaded by the rasterizer lack the
// coloured shadows of others.
const std::string few_candidates = "panes --size 64x36 --shadows map --cache-rate full --layers 4 --oit sorted ";

TEST_F(Plan, PicksTheCheapestThatHoldsTheError) {
  if (!can_draw()) GTEST_SKIP() << "no OpenGL";
  const json planned = plan(few_candidates + "--max-error 0.05");
  size_t picked = 0;
  for (const json& c : planned["candidates"]) {
    if (c["picked"] == true) {
      ++picked;
      EXPECT_LE(c["error"], 0.05);
      EXPECT_EQ(planned["predicted"]["error"], c["error"]);
      EXPECT_EQ(planned["config"]["translucency"], c["config"]["translucency"]);
    }
    EXPECT_FALSE(c["config"].contains("shadows")) << "given, and left alone";
    if (c.contains("ms") && c["error"] <= 0.05) {
      EXPECT_GE(c["ms"], planned["predicted"]["ms"]);
    }
  }
  EXPECT_EQ(picked, 1u);
}

TEST_F(Plan, TheReferenceIsThatOfWhatWasAsked) {
  if (!can_draw()) GTEST_SKIP() << "no OpenGL";
  std::map<std::string, double> errors;  // of configurations that differ in shadows alone
  const json planned = plan("empty --size 64x36 --max-ms 1e6");
  for (const json& c : planned["candidates"])
    if (c.contains("error") && c["config"].size() == 1) errors[c["config"].value("shadows", "")] = c["error"];
  ASSERT_EQ(errors.size(), 3u);
  EXPECT_LT(errors["exact"], 0.9 * errors["off"]) << "the reference has shadows, whatever a candidate leaves out";
}

TEST_F(Plan, RenderDrawsWhatIsPicked) {
  if (!can_draw()) GTEST_SKIP() << "no OpenGL";
  const std::string keeps = "XDG_CACHE_HOME='" + path("") + "'";
  const std::string arguments = few_candidates + "--max-error 0.05";
  const json planned = plan(arguments, keeps);
  const Outcome outcome = run("render " + arguments + " -o x.png --stats s.json", keeps);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_NE(outcome.errors.find("--max-error 0.05: chose "), std::string::npos) << outcome.errors;
  EXPECT_EQ(outcome.error_lines(), 1u) << outcome.errors;
  const json config = json::parse(text_of(path("s.json")))["config"];
  for (const auto& [option, value] : planned["config"].items())
    if (option != "gl" && option != "device" && option != "threads") {
      EXPECT_EQ(config[option], value) << option;
    }
}

// The whole frame's time comes from the cache, so that the test does not depend on a clock.
TEST_F(Plan, AMissedTimeIsChosenAnew) {
  if (!can_draw()) GTEST_SKIP() << "no OpenGL";
  const std::string keeps = "XDG_CACHE_HOME='" + path("") + "'", bound = "--max-ms 1e6";
  const std::string arguments = "panes --size 640x260 --shadows map --cache-rate full --layers 2 --oit sorted ";
  const auto picked = [](const json& planned) {
    for (const json& c : planned["candidates"])
      if (c["picked"] == true) return c;
    return json();
  };
  const json first = plan(arguments + bound, keeps);
  EXPECT_EQ(first["choice"]["corrections"], 0);
  EXPECT_EQ(first["choice"]["scale"], 1.0);
  EXPECT_EQ(first["choice"]["measured_ms"], picked(first)["measured_ms"]);
  size_t kept = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(path("sideray"))) {
    json file = entry.path().extension() == ".json" ? json::parse(text_of(entry.path())) : json();
    if (!file.is_object() || file["key"]["what"] != "frame") continue;
    ++kept;
    file["value"]["ms"] = 1.001e6;
    std::ofstream(entry.path()) << file.dump();
  }
  ASSERT_EQ(kept, 1u) << "one frame was drawn whole";
  const json second = plan(arguments + bound, keeps);
  EXPECT_EQ(second["choice"]["corrections"], 1);
  EXPECT_DOUBLE_EQ(second["choice"]["scale"], 1.001e6 / picked(first)["ms"].get<double>());
  EXPECT_NE(picked(second)["config"], picked(first)["config"]) << "never what was measured to miss";
  EXPECT_LE(second["choice"]["measured_ms"], 1e6);
  const Outcome outcome = run("render " + arguments + bound + " -o a.png --stats s.json", keeps);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_NE(outcome.errors.find("; chosen anew once"), std::string::npos) << outcome.errors;
  EXPECT_EQ(json::parse(text_of(path("s.json")))["choice"], second["choice"]);
  std::string chosen;
  const json config = picked(second)["config"];
  for (const auto& [option, value] : config.items())
    chosen += fmt::format(" --{} {}", option, value.get<std::string>());
  ASSERT_EQ(run("render " + arguments + chosen + " --ambient off --reflections off -o b.png").exit_code, 0);
  EXPECT_EQ(text_of(path("a.png")), text_of(path("b.png"))) << "what was measured leaves no trace in the picture";
}

TEST_F(Plan, NothingIsWrittenWhereNothingHolds) {
  if (!can_draw()) GTEST_SKIP() << "no OpenGL";
  const std::string off = "SIDERAY_CACHE=off", few = "panes --size 64x36 --shadows map --translucency raster ";
  expect_refused("render " + few + "-o x.png --max-error 0", 1, "the nearest is", off);
  expect_refused("plan " + few + "--max-ms 0.001", 1, "predicted", off);
}

TEST_F(Plan, ConfigHasTheLayersThatAreUsed) {
  EXPECT_EQ(bounded("panes?count=1 --size 64x36 --shadows map")["config"]["layers"], 1);
  EXPECT_EQ(bounded("panes?count=1 --size 64x36 --shadows map --layers 8")["config"]["layers"], 1);
  EXPECT_EQ(bounded("empty --size 64x36 --shadows map --ambient off --reflections off")["config"]["layers"], 0);
}

TEST_F(Plan, ListsWhatAnOrderNeeds) {
  const auto bytes = [&](const char* order, const std::string& name) {
    const json planned = bounded("panes?count=2 --size 64x36 --shadows map --layers 2 --oit " + std::string(order));
    uint64_t sum = 0;
    for (const json& texture : planned["textures"])
      if (texture["name"] == name) sum += texture["bytes"].get<uint64_t>();
    return sum / (64 * 36);
  };
  EXPECT_EQ(bytes("sorted", "order.keys") + bytes("sorted", "order.heads"), 0u);
  EXPECT_EQ(bytes("peel", "order.keys"), 2 * 8u);
  EXPECT_EQ(bytes("peel", "order.depth"), 2 * 8u);
  EXPECT_EQ(bytes("abuffer", "order.heads"), 4u);
}

TEST_F(Plan, ListsTheScenesOwnTextures) {
  const json planned = bounded("panes --size 64x36 --shadows map");
  std::vector<std::string> names;
  for (const json& texture : planned["textures"]) names.push_back(texture["name"]);
  for (const char* name : {"scene.environment", "scene.irradiance", "scene.albedo_terms"})
    EXPECT_EQ(std::count(names.begin(), names.end(), name), 1) << name;
}

TEST_F(Plan, BesideMasksOnlyDirectionalLightsHaveTintMaps) {
  const auto tint_maps = [&](const char* options) {
    const json planned = bounded(std::string(options) + " --size 64x36");
    std::set<std::string> names;
    for (const json& texture : planned["textures"])
      if (const auto name = texture["name"].get<std::string>(); name.starts_with("tint_map")) names.insert(name);
    return names;
  };
  const std::set<std::string> none, directional{"tint_map.directional"}, local{"tint_map.local"};
  EXPECT_EQ(tint_maps("solids --shadows map"), directional);
  EXPECT_EQ(tint_maps("solids --shadows inexact"), directional);
  EXPECT_EQ(tint_maps("solids --shadows off"), none);
  EXPECT_EQ(tint_maps("bistro --shadows map"), local);
  EXPECT_EQ(tint_maps("bistro --shadows inexact"), none);
}

TEST_F(Plan, AgreesWithTheCounters) {
  expect_agreement("empty --size 96x54");
  expect_agreement("panes --size 96x54");
  expect_agreement("panes?count=1 --size 96x54 --cache-rate quarter --reflections on");
  expect_agreement("panes --size 96x54 --translucency raytraced --shadows map --ambient ao");
  expect_agreement("forest?count=200 --size 96x54");
}

TEST_F(Plan, NothingMoreThanTheSceneNeeds) {
  const json empty = bounded("empty --size 64x36 --shadows map --ambient off --reflections off");
  for (const char* stage : {"build", "mask", "readback", "trace", "trace_shadow", "upload", "composite"})
    EXPECT_FALSE(runs(empty, stage)) << stage;
  EXPECT_EQ(service_bytes(empty), 0u);
  EXPECT_EQ(empty["bounds"]["rays"], 0);
  EXPECT_EQ(service_bytes(bounded("empty --size 64x36 --ambient off --reflections off")), 64u * 36) << "one light, one mask";
  EXPECT_EQ(service_bytes(bounded("panes?count=1 --size 64x36 --shadows map --ambient off --diagnose whole-pixels=off")), 64u * 36 * 16)
      << "one pane, one layer";
  EXPECT_EQ(service_bytes(bounded("panes?count=6 --size 64x36 --shadows map --ambient off --diagnose whole-pixels=off")), 64u * 36 * 16 * 4);
  EXPECT_EQ(service_bytes(bounded("panes?count=6 --size 64x36 --shadows map --ambient off")), 64u * 36 * (16 * 4 + 16));
  // Stages that auto leaves out have no time.
  const json bare = bounded("panes --size 64x36 --translucency off --shadows map --env none --ambient off");
  for (const char* stage : {"build", "readback", "trace", "trace_ao", "denoise", "upload"})
    EXPECT_FALSE(runs(bare, stage)) << stage;
  EXPECT_EQ(service_bytes(bare), 0u);
  EXPECT_EQ(bare["bounds"]["rays"], 0);
}

TEST_F(Plan, WhatHasNoBoundIsNotStated) {
  const json reference = bounded("panes --size 64x36 --reference");
  EXPECT_FALSE(reference["bounds"].contains("rays") || reference["predicted"].contains("rays"));
  EXPECT_FALSE(runs(reference, "gbuffer"));
  EXPECT_FALSE(bounded("panes --size 64x36 --translucency raytraced --layers unlimited")["bounds"].contains("rays"));
}

TEST_F(Plan, SaysItInWords) {
  const Outcome outcome = run("plan empty --size 64x36", "SIDERAY_CACHE=off");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
  for (const char* words : {"quality balanced\n", "runs\n", "left out\n", "nothing in the scene is translucent", "textures\n", "at most"})
    EXPECT_NE(outcome.output.find(words), std::string::npos) << words << "\n" << outcome.output;
}

TEST_F(Plan, ASetOfValuesIsNamedAndResolved) {
  const json draft = bounded("panes --size 64x36 --quality draft")["config"];
  EXPECT_EQ(draft["quality"], "draft");
  EXPECT_EQ(draft["shadows"], "map");
  EXPECT_EQ(draft["layers"], 2);
  EXPECT_EQ(draft["refraction"], "off");
  const json best = bounded("panes --size 64x36 --layers 3 --quality best")["config"];
  EXPECT_EQ(best["quality"], "best");
  EXPECT_EQ(best["layers"], 3) << "what is given wins";
  EXPECT_EQ(best["ray-traced"], "all");
  EXPECT_EQ(best["ray-reuse"], 0);
}

TEST_F(Plan, WrongUsage) {
  expect_refused("plan", 2, "no scene");
  expect_refused("plan panes -o x.png", 2, "-o");
  expect_refused("plan panes --layers 9", 2, "0 to 8");
  expect_refused("plan panes --max-ms x", 2, "not a number");
  expect_refused("plan panes --max-error -1", 2, "out of range");
  expect_refused("plan nosuch", 2, "nosuch");
}

}  // namespace
}  // namespace sideray::cli_tests
