// `sideray plan` says what `sideray render` then does.
#include "cli/program.h"

namespace sideray::cli_tests {
namespace {

using nlohmann::json;

class Plan : public Program {
 protected:
  json plan(const std::string& arguments) const {
    const Outcome outcome = run("plan " + arguments + " --json");
    EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
    return json::parse(outcome.output, nullptr, false);
  }
  json stats(const std::string& arguments) const {
    const Outcome outcome = run("render " + arguments + " -o x.png --stats s.json");
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
          name == "ambient_mask" || name == "reflections")
        bytes += texture["bytes"].get<uint64_t>();
    }
    return bytes;
  }

  void expect_agreement(const std::string& arguments) const {
    SCOPED_TRACE(arguments);
    const json planned = plan(arguments), drawn = stats(arguments);
    for (const char* stage : {"build", "update", "gbuffer", "shadow_map", "mask", "readback", "trace", "trace_shadow",
                              "trace_ao", "upload", "light", "composite"})
      EXPECT_EQ(runs(planned, stage), drawn["stages_ms"][stage].get<double>() > 0) << stage;
    if (!runs(planned, "denoise")) {
      EXPECT_EQ(drawn["stages_ms"]["denoise"].get<double>(), 0);
    }
    const json& most = planned["predicted"];
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
};

TEST_F(Plan, HasTheKeys) {
  const json planned = plan("panes --size 64x36");
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
  for (const char* key : {"rays", "fragments", "bytes"}) EXPECT_GT(planned["predicted"][key], 0) << key;
  EXPECT_FALSE(planned["predicted"].contains("ms")) << "nothing is known of times";
  EXPECT_EQ(files().size(), 0u);
}

TEST_F(Plan, AgreesWithTheCounters) {
  expect_agreement("empty --size 96x54");
  expect_agreement("panes --size 96x54");
  expect_agreement("panes?count=1 --size 96x54 --cache-rate quarter --reflections on");
  expect_agreement("panes --size 96x54 --translucency raytraced --shadows map --ao on");
  expect_agreement("forest?count=200 --size 96x54");
}

TEST_F(Plan, NothingMoreThanTheSceneNeeds) {
  const json empty = plan("empty --size 64x36 --shadows map");
  for (const char* stage : {"build", "mask", "readback", "trace", "trace_shadow", "upload", "composite"})
    EXPECT_FALSE(runs(empty, stage)) << stage;
  EXPECT_EQ(service_bytes(empty), 0u);
  EXPECT_EQ(empty["predicted"]["rays"], 0);
  EXPECT_EQ(service_bytes(plan("empty --size 64x36")), 64u * 36) << "one light, one mask";
  EXPECT_EQ(service_bytes(plan("panes?count=1 --size 64x36 --shadows map")), 64u * 36 * 16) << "one pane, one layer";
  EXPECT_EQ(service_bytes(plan("panes?count=6 --size 64x36 --shadows map")), 64u * 36 * 16 * 4);
}

TEST_F(Plan, WhatHasNoBoundIsNotStated) {
  const json reference = plan("panes --size 64x36 --reference");
  EXPECT_FALSE(reference["predicted"].contains("rays"));
  EXPECT_FALSE(runs(reference, "gbuffer"));
  EXPECT_FALSE(plan("panes --size 64x36 --translucency raytraced --layers unlimited")["predicted"].contains("rays"));
}

TEST_F(Plan, SaysItInWords) {
  const Outcome outcome = run("plan empty --size 64x36");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
  for (const char* words : {"runs\n", "left out\n", "nothing in the scene is translucent", "textures\n", "at most"})
    EXPECT_NE(outcome.output.find(words), std::string::npos) << words << "\n" << outcome.output;
}

TEST_F(Plan, WrongUsage) {
  expect_refused("plan", 2, "no scene");
  expect_refused("plan panes -o x.png", 2, "-o");
  expect_refused("plan panes --layers 9", 2, "0 to 8");
  expect_refused("plan panes --max-ms 5", 2, "not built yet");
  expect_refused("plan panes --max-error 0.1", 2, "not built yet");
  expect_refused("plan nosuch", 2, "nosuch");
}

}  // namespace
}  // namespace sideray::cli_tests
